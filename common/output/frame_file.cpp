#include "common/output/frame_file.hpp"

#include "common/core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace poretwin {

FrameFile::FrameFile(const std::filesystem::path& path) : path_(path), file_(hdf5::File::open_to_read(path)) {
  if (!file_.has("VTKHDF") || !file_.has("VTKHDF/Steps") || !file_.has("VTKHDF/Steps/Values"))
    throw FileError(fmt::format("{}: expected the frames of a run (VTKHDF), found something else", path_.string()));
  times_ = file_.read_numbers("VTKHDF/Steps/Values");
  points_ = file_.read_integers("VTKHDF/NumberOfPoints");
  first_ = file_.read_integers("VTKHDF/Steps/PointOffsets");
  // A frame is complete once NSteps counts it, since its data were written before.
  const auto whole = file_.attribute_integers("VTKHDF/Steps", "NSteps").front();
  const std::size_t steps = std::min({static_cast<std::size_t>(whole), times_.size(), points_.size(), first_.size()});
  times_.resize(steps);
  points_.resize(steps);
  first_.resize(steps);
}

std::vector<double> FrameFile::positions(std::size_t frame) const {
  return file_.read_rows("VTKHDF/Points", static_cast<std::size_t>(first_.at(frame)), particles(frame));
}

bool FrameFile::has(const std::string& field) const { return file_.has("VTKHDF/PointData/" + field); }

std::vector<double> FrameFile::values(const std::string& field, std::size_t frame) const {
  if (!has(field))
    throw FileError(fmt::format("{}: its frames have no field '{}': another program, or an earlier one, wrote them",
                                path_.string(), field));
  return file_.read_rows("VTKHDF/PointData/" + field, static_cast<std::size_t>(first_.at(frame)), particles(frame));
}

std::size_t nearest_to(std::span<const double> times, double time) {
  const auto nearest = std::ranges::min_element(times, {}, [time](double t) { return std::abs(t - time); });
  return static_cast<std::size_t>(nearest - times.begin());
}

}  // namespace poretwin
