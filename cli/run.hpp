// `poretwin run`: starts the processes of a case, watches them, collects their results.
#pragma once

#include "cli/process.hpp"
#include "common/core/error.hpp"
#include "common/core/warning.hpp"

#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace poretwin::cli {

/// The summary that one process writes at its end (OUT/<process>.summary.json).
struct Summary {
  using Numbers = std::vector<std::pair<std::string, double>>;
  std::string process, reason;
  int exit = 0;
  double wall = 0.0, cpu = 0.0;  ///< s
  Numbers seconds, steps, counters;
  std::vector<Warning> warnings;
  std::vector<std::string> files;
};

struct RunOptions {
  std::filesystem::path case_file, out;
  std::string case_name;
  std::vector<std::string> overrides;
  std::string fluid, solid;        ///< commands that replace a solver; empty: poretwin's own
  std::filesystem::path programs;  ///< folder of poretwin-fluid, poretwin-solid, poretwin-coupler
  bool quiet = false;              ///< show neither progress nor summary
  bool warnings = true;            ///< show warnings when they occur; they are counted in any case
  bool pictures = true;
  bool profile = false;                    ///< write trace.json: what each process did when
  bool resume = false;                     ///< from the newest checkpoint in `out`
  bool overwrite = false;                  ///< begin anew even over a run that could be resumed
  bool accept_changed_program = false;     ///< also resume a run that another program began
  std::optional<double> checkpoint_every;  ///< s of wall-clock time; absent: the processes' default
  int restarts = 2;                        ///< largest number of restarts after crashes
  int tiles = 1;  ///< number of processes that share the water or dry soil, each with one tile of space (mpirun)
  std::filesystem::path hosts;  ///< names of the machines for these processes, as mpirun reads them; empty: this one
};

struct RunResult {
  int exit = 0;                   ///< of the process that failed first; 6: result in doubt; 130: interrupted
  std::string reason;             ///< empty where all went well, or the run had already ended
  bool already_finished = false;  ///< the run had ended before; nothing was done; the summaries are its own
  double wall = 0.0, cpu = 0.0;   ///< s
  int restarts = 0;               ///< number of restarts after crashes
  std::vector<Ended> ended;
  std::vector<Summary> summaries;
  std::vector<std::string> case_warnings;  ///< warnings of the check of the case
  std::string representation_chosen;       ///< how fluid.representation = "auto" was decided, and why; else empty
  /// Whether the run ended by itself, with or without warnings that put the result in doubt.
  [[nodiscard]] bool ended_well() const { return exit == 0 || exit == static_cast<int>(ExitCode::in_doubt); }
};

/// Runs a case. Throws CaseError and FileError before anything is started or changed; later failures are reported in
/// the result. Resuming a finished run does nothing.
RunResult run_case(const RunOptions& options);

/// Text with the time spent on each activity, steps, counters and files.
std::string summary_text(const RunResult& result, const std::filesystem::path& out);

/// What summary_text() shows, and all that the processes reported, as JSON for other programs.
nlohmann::ordered_json run_json(const std::string& case_name, const std::filesystem::path& case_file,
                                const std::filesystem::path& out, const RunResult& result);

/// Threads that a solver may use: OMP_NUM_THREADS, or the processors of this process.
int available_threads();

/// Why a process ended, with the last words of its log.
std::string reason_of(const Ended& ended);

/// The process that failed first; others may have failed because of it.
const Ended* root_cause(const std::vector<Ended>& ended);

}  // namespace poretwin::cli
