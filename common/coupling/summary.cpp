#include "common/coupling/summary.hpp"

#include "common/core/fault.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <fstream>

namespace poretwin::coupling {
namespace {

/// CPU time of the process or of the calling thread [s].
double cpu_seconds(int of) {
  rusage usage{};
  getrusage(of, &usage);
  auto seconds = [](const timeval& t) { return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec); };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// Largest memory that the process has used [bytes]; 0 where the system does not report it.
double peak_memory() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.rfind("VmHWM:", 0) == 0) return 1024.0 * std::stod(line.substr(6));
  return 0.0;
}

std::string json_object(const NamedNumbers& numbers) {
  std::string out = "{";
  for (const auto& [name, value] : numbers)
    out += (out.size() > 1 ? ", " : "") + json_string(name) + ": " + json_number(value);
  return out + "}";
}

}  // namespace

std::string json_string(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (static_cast<unsigned char>(c) < 0x20) {
      out += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    } else {
      out += c;
    }
  }
  return out + "\"";
}

std::string json_number(double value) { return std::isfinite(value) ? fmt::format("{}", value) : "null"; }

void write_summary(const std::filesystem::path& path, const RunSummary& summary) {
  std::string files;
  for (const auto& file : summary.files) files += (files.empty() ? "" : ", ") + json_string(file);
  std::string warnings;
  for (const auto& w : summary.warnings)
    warnings += fmt::format("{}\n    {{\"what\": {}, \"count\": {}, \"detail\": {}, \"result_in_doubt\": {}}}",
                            warnings.empty() ? "" : ",", json_string(w.what), json_number(w.count),
                            json_string(w.detail), w.result_in_doubt);
  const std::string text = fmt::format(
      "{{\n  \"process\": {},\n  \"exit\": {},\n  \"reason\": {},\n  \"wall_s\": {},\n  \"cpu_s\": {},\n  "
      "\"cpu_first_thread_s\": {},\n  \"memory_bytes\": {},\n  \"seconds\": {},\n"
      "  \"steps\": {},\n  \"counters\": {},\n  \"warnings\": [{}],\n  \"files\": [{}]\n}}\n",
      json_string(summary.process), static_cast<int>(summary.exit), json_string(summary.reason),
      json_number(summary.wall), json_number(cpu_seconds(RUSAGE_SELF)), json_number(cpu_seconds(RUSAGE_THREAD)),
      json_number(peak_memory()), json_object(summary.seconds), json_object(summary.steps),
      json_object(summary.counters), warnings, files);
  auto part = path;
  part += ".part";
  {
    std::ofstream out(part);
    out << text;
    if (fails(Fallible::write) || !out.flush()) {
      std::error_code ignored;
      std::filesystem::remove(part, ignored);
      throw FileError("cannot write " + part.string() + ": is the disk full or the folder write-protected?");
    }
  }
  std::error_code error;
  std::filesystem::rename(part, path, error);
  if (error) throw FileError("cannot write " + path.string() + ": " + error.message());
}

void ProgressLines::write(const Progress& progress, bool last) {
  if (descriptor_ < 0) return;
  const auto now = std::chrono::steady_clock::now();
  if (!last && now < next_) return;
  next_ = now + std::chrono::milliseconds(100);
  const std::string line = fmt::format("{{\"t\": {}, \"end\": {}, \"step\": {}, \"dt\": {}, \"waiting_for\": {}}}\n",
                                       json_number(progress.time), json_number(progress.end), progress.step,
                                       json_number(progress.interval), json_string(progress.waiting_for));
  if (::write(descriptor_, line.data(), line.size()) < 0) descriptor_ = -1;
}

void log_line(const std::string& line) {
  const std::string text = fmt::format("[{:%H:%M:%S}] {}\n", fmt::gmtime(std::time(nullptr)), line);
  std::fwrite(text.data(), 1, text.size(), stderr);
}

}  // namespace poretwin::coupling
