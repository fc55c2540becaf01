// Reads the frames that VtkHdfWriter wrote.
#pragma once

#include "common/output/hdf5.hpp"

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace poretwin {

class FrameFile {
 public:
  /// Throws FileError if the file cannot be read or was not written by VtkHdfWriter.
  explicit FrameFile(const std::filesystem::path& path);
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  /// Times of the frames [s], ascending.
  [[nodiscard]] const std::vector<double>& times() const { return times_; }
  /// Number of particles in a frame.
  [[nodiscard]] std::size_t particles(std::size_t frame) const { return static_cast<std::size_t>(points_.at(frame)); }
  /// Three coordinates of each particle [m].
  [[nodiscard]] std::vector<double> positions(std::size_t frame) const;
  [[nodiscard]] bool has(const std::string& field) const;
  /// All components of each particle, one particle after the other. Throws FileError if there is no such field.
  [[nodiscard]] std::vector<double> values(const std::string& field, std::size_t frame) const;

 private:
  std::filesystem::path path_;
  hdf5::File file_;
  std::vector<double> times_;
  std::vector<std::int64_t> points_, first_;  ///< of each frame: number of its particles, its first row
};

/// The index of the time nearest to `time`; `times` must not be empty.
std::size_t nearest_to(std::span<const double> times, double time);

}  // namespace poretwin
