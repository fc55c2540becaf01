// Child processes: started in their own process group, watched through signalfd and pipes, ended by SIGTERM, then by
// SIGKILL.
#pragma once

#include <sys/types.h>

#include <chrono>
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
  std::map<std::string, std::string> environment;  ///< in addition to this process's
  std::filesystem::path log;                       ///< where its stdout and stderr go
  bool reports_progress = false;                   ///< gets "--progress-fd N"
  bool goes_on = false;                            ///< it resumes a run: its log is appended to
};

struct Ended {
  std::string name;
  int status = 0;      ///< exit code; 128 + signal when killed by one
  int signal = 0;      ///< 0: ended by itself
  bool by_us = false;  ///< ended by a signal from here, after another one's failure or Ctrl-C
  double cpu = 0.0;    ///< s
  std::filesystem::path log;
};

struct Watched {
  std::vector<Ended> ended;  ///< in the order of ending
  bool interrupted = false;  ///< SIGINT or SIGTERM reached this process
};

struct Patience {
  std::chrono::milliseconds by_itself{5000};   ///< for the others to end after a failure, before SIGTERM
  std::chrono::milliseconds after_term{3000};  ///< before SIGKILL
  /// Time for a clean stop after Ctrl-C before SIGTERM is sent: long, since a window may take minutes. A second Ctrl-C
  /// ends the wait, once `grace` has passed.
  std::chrono::milliseconds after_interrupt{600000};
  std::chrono::milliseconds grace{10000};  ///< after Ctrl-C, in which further ones are ignored
};

/// Starts all programs, passes their progress lines to `progress`, calls `tick` about four times a second, returns when
/// all have ended. Throws FileError when one cannot be started (those already started are ended first).
Watched run_together(const std::vector<Program>& programs, const std::function<void(const std::string&)>& progress,
                     const std::function<void()>& tick, const Patience& patience = {});

}  // namespace poretwin::cli
