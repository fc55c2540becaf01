// Output of every process about itself: OUT/NAME.summary.json at its end, progress lines and log lines during the run.
#pragma once

#include "common/core/error.hpp"
#include "common/core/warning.hpp"

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace poretwin::coupling {

using NamedNumbers = std::vector<std::pair<std::string, double>>;

struct RunSummary {
  std::string process;  ///< "fluid", "solid", "coupler"
  ExitCode exit = ExitCode::success;
  std::string reason = "end";
  double wall = 0.0;     ///< s
  NamedNumbers seconds;  ///< s of wall-clock time per activity
  NamedNumbers steps;
  NamedNumbers counters;
  std::vector<Warning> warnings;
  std::vector<std::string> files;
};

/// Writes {"process","exit","reason","wall_s","cpu_s","cpu_first_thread_s","memory_bytes","seconds":{},"steps":{},
/// "counters":{},"warnings":[{"what","count","detail","result_in_doubt"}],"files":[]}, completely or not at all. The
/// first thread must call this, since its CPU time is read. memory_bytes: the largest so far. Throws FileError.
void write_summary(const std::filesystem::path& path, const RunSummary& summary);

/// A JSON string literal, including the quotes.
std::string json_string(const std::string& text);
/// A JSON number; null if the value is not finite.
std::string json_number(double value);

/// The state of a run, for progress lines.
struct Progress {
  double time = 0.0, end = 0.0;  ///< s
  std::uint64_t step = 0;
  double interval = 0.0;  ///< s
  std::string waiting_for;
};

/// Writes JSON lines {"t","end","step","dt","waiting_for"} to a descriptor, at most 10 per second. If the reader has
/// closed the descriptor, the lines are dropped.
class ProgressLines {
 public:
  explicit ProgressLines(int descriptor) : descriptor_(descriptor) {}
  /// `last`: this line is always written.
  void write(const Progress& progress, bool last = false);

 private:
  int descriptor_;  ///< negative: no progress lines
  std::chrono::steady_clock::time_point next_{};
};

/// One line to stderr: "[seconds] who: what".
void log_line(const std::string& line);

}  // namespace poretwin::coupling
