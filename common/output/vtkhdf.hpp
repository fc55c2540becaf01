// Particles over time in a format that ParaView reads (VTKHDF 2.0, UnstructuredGrid), with an .xmf side-car for
// versions before 5.12. PolyData is not used: newer readers mis-index the step after an empty step, and a dry case
// starts without water particles.
#pragma once

#include "common/coupling/phase.hpp"
#include "common/output/hdf5.hpp"

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace poretwin {

class VtkHdfWriter {
 public:
  /// Creates `path` and, beside it, a file of the same name ending in .xmf.
  explicit VtkHdfWriter(const std::filesystem::path& path);
  /// Continues the file from the step that archive() saved. Later steps are removed. Throws FileError.
  VtkHdfWriter(const std::filesystem::path& path, Archive& checkpoint);
  VtkHdfWriter(const VtkHdfWriter&) = delete;
  VtkHdfWriter& operator=(const VtkHdfWriter&) = delete;
  /// Writes the side-car for the last time.
  ~VtkHdfWriter();

  /// Appends one step. Every frame must have the fields of the first frame. The data are written first, then the step's
  /// rows, then NSteps, then a flush: neither a reader nor a crash ever sees half a step.
  void append(const OutputFrame& frame);

  /// Saves or restores the number of steps.
  void archive(Archive& archive);

  /// The open file, for groups that VTKHDF readers ignore.
  hdf5::File& file() { return file_; }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::filesystem::path sidecar() const;

 private:
  struct Step {
    double time;
    std::int64_t points, first;
  };
  struct Column {
    FieldDeclaration declaration;
    hdf5::Dataset values, offsets;
    void archive(Archive& archive) { archive(declaration); }
  };
  /// Creates the data sets, or opens them and removes what lies beyond the recorded steps.
  void bind(bool create);
  void bind_columns(bool create);
  void declare(const OutputFrame& frame);
  void check(const OutputFrame& frame) const;
  /// Rewrites the whole side-car, a text file, if needed: initially after every step, then each time the number of
  /// steps has grown by a sixteenth, and at the end.
  void write_sidecar();

  std::filesystem::path path_;
  hdf5::File file_;
  hdf5::Dataset number_of_points_, number_of_cells_, number_of_ids_, points_, connectivity_, offsets_, types_;
  hdf5::Dataset times_, part_offsets_, parts_, point_offsets_, cell_offsets_, id_offsets_;
  std::vector<Column> columns_;
  std::vector<Step> steps_;
  std::int64_t total_ = 0;
  std::size_t in_sidecar_ = 0;  ///< number of steps that the side-car lists
};

}  // namespace poretwin
