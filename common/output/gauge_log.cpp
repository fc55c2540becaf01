#include "common/output/gauge_log.hpp"

#include "common/core/error.hpp"
#include "common/core/fault.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>

namespace poretwin {
namespace {

constexpr const char* header = "time_s,gauge,value,unit\n";

std::string shown(double value) { return std::isnan(value) ? "nan" : fmt::format("{:.17g}", value); }

std::string quoted(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string result = "\"";
  for (const char c : text) result += c == '"' ? "\"\"" : std::string(1, c);
  return result + "\"";
}

std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> result(1);
  bool inside = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"' && inside && i + 1 < line.size() && line[i + 1] == '"')
      result.back() += line[++i];
    else if (c == '"')
      inside = !inside;
    else if (c == ',' && !inside)
      result.emplace_back();
    else if (c != '\r')
      result.back() += c;
  }
  return result;
}

struct Row {
  double time = 0.0;
  std::string gauge;
  double value = 0.0;
  std::string unit;
};

std::vector<Row> read_rows(const std::filesystem::path& path) {
  std::ifstream stream(path);
  if (!stream) throw FileError(fmt::format("{}: cannot be opened: {}", path.string(), std::strerror(errno)));
  std::vector<Row> rows;
  std::string line;
  std::getline(stream, line);
  for (std::size_t number = 2; std::getline(stream, line); ++number) {
    // A killed run may leave an incomplete last line.
    if (stream.eof()) break;
    const auto cell = cells(line);
    if (cell.size() != 4)
      throw FileError(fmt::format("{}:{}: expected time_s,gauge,value,unit, found '{}'", path.string(), number, line));
    rows.push_back({std::strtod(cell[0].c_str(), nullptr), cell[1], std::strtod(cell[2].c_str(), nullptr), cell[3]});
  }
  return rows;
}

}  // namespace

GaugeLog::GaugeLog(const std::filesystem::path& path)
    : path_(path), file_(std::fopen(path.c_str(), "w")), bytes_(std::strlen(header)) {
  if (!file_ || std::fputs(header, file_.get()) < 0 || std::fflush(file_.get()) != 0)
    throw FileError(fmt::format("{}: cannot be written: {}", path.string(), std::strerror(errno)));
}

GaugeLog::GaugeLog(const std::filesystem::path& path, Archive& checkpoint) : path_(path) {
  archive(checkpoint);
  std::error_code error;
  if (const auto size = std::filesystem::file_size(path, error); error || size < bytes_)
    throw FileError(fmt::format("{}: expected the {} bytes that stood at the checkpoint, found {}", path.string(),
                                bytes_, error ? "none" : std::to_string(size)));
  std::filesystem::resize_file(path, bytes_);
  series_ = read_gauges(path);
  file_.reset(std::fopen(path.c_str(), "a"));
  if (!file_) throw FileError(fmt::format("{}: cannot be written: {}", path.string(), std::strerror(errno)));
}

void GaugeLog::append(double time, const std::vector<GaugeReading>& readings) {
  std::string text;
  for (const auto& reading : readings) {
    text +=
        fmt::format("{},{},{},{}\n", shown(time), quoted(reading.gauge), shown(reading.value), quoted(reading.unit));
    auto& series = series_[reading.gauge];
    series.unit = reading.unit;
    series.time.push_back(time);
    series.value.push_back(reading.value);
  }
  if (fails(Fallible::write) || std::fwrite(text.data(), 1, text.size(), file_.get()) != text.size() ||
      std::fflush(file_.get()) != 0)
    throw FileError(fmt::format("{}: cannot be written: {}", path_.string(), std::strerror(errno)));
  bytes_ += text.size();
}

std::map<std::string, GaugeSeries> read_gauges(const std::filesystem::path& path) {
  std::map<std::string, GaugeSeries> result;
  for (const auto& row : read_rows(path)) {
    auto& series = result[row.gauge];
    series.unit = row.unit;
    series.time.push_back(row.time);
    series.value.push_back(row.value);
  }
  return result;
}

void merge_gauges(const std::vector<std::filesystem::path>& sources, const std::filesystem::path& target) {
  std::vector<Row> rows;
  for (const auto& source : sources) {
    if (!std::filesystem::exists(source)) continue;
    auto more = read_rows(source);
    rows.insert(rows.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
  }
  std::stable_sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) { return a.time < b.time; });
  std::ofstream stream(target, std::ios::binary);
  stream << header;
  for (const auto& row : rows)
    stream << fmt::format("{},{},{},{}\n", shown(row.time), quoted(row.gauge), shown(row.value), quoted(row.unit));
  stream.close();
  if (!stream) throw FileError(fmt::format("{}: cannot be written: {}", target.string(), std::strerror(errno)));
}

}  // namespace poretwin
