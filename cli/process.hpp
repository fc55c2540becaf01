// Child processes: started in their own process group, watched through signalfd and pipes, ended by SIGTERM, then by
// SIGKILL.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace poretwin::cli {

struct Program {
  std::string name;  ///< "fluid"
  std::filesystem::path file;
  std::vector<std::string> arguments;
  std::map<std::string, std::string> environment;  ///< variables in addition to those of this process
  std::filesystem::path log;                       ///< file for its stdout and stderr
  bool reports_progress = false;                   ///< "--progress-fd N" is passed to it
  /// mpirun starts it: N is its stdout, which mpirun passes on, and the exit code 128 + n says that signal n killed one
  /// of its ranks.
  bool by_mpirun = false;
  int stop_signal = SIGINT;  ///< asks it to finish the window and stop
  bool goes_on = false;      ///< its run is resumed: append to the log
};

struct Ended {
  std::string name;
  int status = 0;      ///< exit code; 128 + signal where a signal killed it
  int signal = 0;      ///< signal that killed it, or one of its ranks; 0: it ended by itself
  bool by_us = false;  ///< killed by this process, after another one's failure or Ctrl-C
  double cpu = 0.0;    ///< s
  std::filesystem::path log;
};

struct Watched {
  std::vector<Ended> ended;  ///< in the order in which the programs ended
  bool interrupted = false;  ///< SIGINT or SIGTERM reached this process
};

struct Patience {
  std::chrono::milliseconds by_itself{5000};   ///< time in which others may end by themselves after a failure
  std::chrono::milliseconds after_term{3000};  ///< time from SIGTERM to SIGKILL
  /// Time for a clean stop after Ctrl-C, before SIGTERM is sent. It is long, since a window may take minutes. A second
  /// Ctrl-C ends this time, once `grace` has passed.
  std::chrono::milliseconds after_interrupt{600000};
  std::chrono::milliseconds grace{10000};  ///< time after Ctrl-C during which further ones are ignored
};

/// Starts all programs, passes their progress lines to `progress`, calls `tick` about four times a second with whether
/// they have been asked to stop, and returns when all have ended. Throws FileError where one cannot be started, after
/// ending those already started.
Watched run_together(const std::vector<Program>& programs, const std::function<void(const std::string&)>& progress,
                     const std::function<void(bool)>& tick, const Patience& patience = {});

}  // namespace poretwin::cli
