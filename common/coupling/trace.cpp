#include "common/coupling/trace.hpp"

#include "common/core/error.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>

namespace poretwin::coupling {
namespace {

namespace fs = std::filesystem;

/// Order of the processes on the time line, from top to bottom.
constexpr std::array<const char*, 3> processes{"coupler", "fluid", "solid"};

double microseconds(std::chrono::steady_clock::duration d) {
  return std::chrono::duration<double, std::micro>(d).count();
}

[[noreturn]] void cannot_write(const fs::path& path) {
  throw FileError("cannot write " + path.string() + ": is the disk full or the folder write-protected?");
}

}  // namespace

fs::path trace_part(const fs::path& out, const std::string& process) { return out / ("trace." + process + ".json"); }

Trace::Trace(const fs::path& out, const std::string& process)
    : stream_(trace_part(out, process), std::ios::binary | std::ios::app),
      number_(1 + static_cast<int>(std::find(processes.begin(), processes.end(), process) - processes.begin())) {
  stream_ << fmt::format(
      "{{\"ph\":\"M\",\"name\":\"process_name\",\"pid\":{0},\"tid\":{1},\"args\":{{\"name\":\"{2}\"}}}}\n"
      "{{\"ph\":\"M\",\"name\":\"process_sort_index\",\"pid\":{0},\"tid\":{1},\"args\":{{\"sort_index\":{0}}}}}\n",
      number_, ::getpid(), process);
  if (!stream_) cannot_write(trace_part(out, process));
}

void Trace::add(const char* what, Instant begin, Instant end) {
  stream_ << fmt::format("{{\"ph\":\"X\",\"name\":\"{}\",\"pid\":{},\"tid\":{},\"ts\":{:.3f},\"dur\":{:.3f}}}\n", what,
                         number_, ::getpid(), microseconds(begin.time_since_epoch()), microseconds(end - begin));
}

bool join_traces(const fs::path& out) {
  const fs::path whole = out / "trace.json";
  std::ofstream stream;
  for (const char* process : processes) {
    std::ifstream part(trace_part(out, process), std::ios::binary);
    if (!part) continue;
    for (std::string line; std::getline(part, line);) {
      if (!line.ends_with('}')) continue;  // incomplete: the process was killed while writing
      if (!stream.is_open()) {
        stream.open(whole, std::ios::binary);
        stream << "{\"displayTimeUnit\":\"ms\",\"traceEvents\":[\n" << line;
      } else {
        stream << ",\n" << line;
      }
    }
  }
  if (!stream.is_open()) return false;
  stream << "\n]}\n";
  stream.close();
  if (!stream) cannot_write(whole);
  for (const char* process : processes) fs::remove(trace_part(out, process));
  return true;
}

}  // namespace poretwin::coupling
