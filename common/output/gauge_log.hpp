// The readings of all gauges of one process: a CSV file that grows during the run, and a copy in memory for the HDF5
// file.
#pragma once

#include "common/coupling/phase.hpp"

#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace poretwin {

struct GaugeSeries {
  std::string unit;
  std::vector<double> time, value;
};

class GaugeLog {
 public:
  /// Creates the file with its header `time_s,gauge,value,unit`. Throws FileError.
  explicit GaugeLog(const std::filesystem::path& path);
  /// Continues the file from the position that archive() saved. Later rows are removed. Throws FileError.
  GaugeLog(const std::filesystem::path& path, Archive& checkpoint);
  /// Saves or restores the length of the file.
  void archive(Archive& archive) { archive(bytes_); }
  void append(double time, const std::vector<GaugeReading>& readings);
  [[nodiscard]] const std::map<std::string, GaugeSeries>& series() const { return series_; }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::filesystem::path path_;
  std::unique_ptr<std::FILE, Close> file_;
  std::map<std::string, GaugeSeries> series_;
  std::uint64_t bytes_ = 0;  ///< length of the file
};

/// Reads a file that GaugeLog wrote. Throws FileError with path and line.
std::map<std::string, GaugeSeries> read_gauges(const std::filesystem::path& path);

/// Merges several logs into one, ordered by time. Missing sources are skipped.
void merge_gauges(const std::vector<std::filesystem::path>& sources, const std::filesystem::path& target);

}  // namespace poretwin
