// Measures how wall-clock time is spent: sums for the summary and, for `poretwin run --profile`, all time spans on a
// time line.
#pragma once

#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>

namespace poretwin::coupling {

using Instant = std::chrono::steady_clock::time_point;

/// The activities of one process over time in Chrome's trace format, one event per line: OUT/trace.<process>.json. All
/// processes of a machine use one clock, so that their events fit on one time line.
class Trace {
 public:
  /// Appends to the existing trace if a run is resumed. Throws FileError.
  Trace(const std::filesystem::path& out, const std::string& process);
  void add(const char* what, Instant begin, Instant end);

 private:
  std::ofstream stream_;
  int number_;  ///< number of the process, on the time line
};

/// The file with the events of a process.
std::filesystem::path trace_part(const std::filesystem::path& out, const std::string& process);
/// Joins the parts of the processes into OUT/trace.json and removes the parts. Returns false if there are no parts.
/// Throws FileError.
bool join_traces(const std::filesystem::path& out);

/// Measures its own lifetime [s]: adds it to a sum and, if there is a trace, records the span.
class Span {
 public:
  Span(double& seconds, Trace* trace, const char* what) : seconds_(seconds), trace_(trace), what_(what) {}
  Span(const Span&) = delete;
  Span& operator=(const Span&) = delete;
  ~Span() {
    const Instant end = std::chrono::steady_clock::now();
    seconds_ += std::chrono::duration<double>(end - begin_).count();
    if (trace_) trace_->add(what_, begin_, end);
  }

 private:
  double& seconds_;
  Trace* trace_;
  const char* what_;
  Instant begin_ = std::chrono::steady_clock::now();
};

}  // namespace poretwin::coupling
