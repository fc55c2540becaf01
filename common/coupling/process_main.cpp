#include "common/coupling/process_main.hpp"

#include "common/checkpoint/store.hpp"
#include "common/core/file_lock.hpp"
#include "common/core/memory.hpp"
#include "common/coupling/interrupt.hpp"
#include "common/output/build_info.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <new>
#include <optional>

namespace poretwin::coupling {
namespace {

std::filesystem::path summary_file(const Arguments& arguments, const std::string& name) {
  return arguments.out / (name + ".summary.json");
}

/// Whether the last run of this process in OUT succeeded, according to its summary.
bool has_finished(const Arguments& arguments, const std::string& name) {
  std::ifstream stream(summary_file(arguments, name));
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  return text.find("\"exit\": 0,") != std::string::npos;
}

/// Checks the folder of a process that a user starts directly; `poretwin run` has already checked it. Throws FileError.
/// Returns false where the run has already finished.
bool may_begin(const Arguments& arguments, const std::string& name) {
  const bool stopped = has_checkpoints(arguments.out, name), finished = has_finished(arguments, name);
  if (!arguments.resume && !arguments.overwrite && stopped && !finished)
    throw FileError(arguments.out.string() + ": holds checkpoints of an earlier run of the " + name +
                    "; go on with --resume, begin anew with --overwrite, or choose another --out");
  return !(arguments.resume && finished && !stopped);
}

}  // namespace

int process_main(int argc, char** argv, const std::string& called, const std::string& name, Program program,
                 const ProcessBody& body) {
  const auto start = std::chrono::steady_clock::now();
  const InterruptGuard guard;
  return_freed_memory();
  Arguments arguments;
  ExitCode code = ExitCode::success;
  std::string reason;
  std::optional<FileLock> lock;  // absent: the folder belongs to another run
  auto fail = [&](ExitCode why, const std::string& what) {
    code = why;
    reason = what;
    log_line(name + ": error: " + what);
  };
  try {
    arguments = parse_arguments(argc, argv, program);
    if (arguments.help) {
      std::fputs(usage(called, program).c_str(), stdout);
      return 0;
    }
    if (arguments.version) {
      std::puts((called + " " + version() + ", " + build()).c_str());
      return 0;
    }
    std::filesystem::create_directories(arguments.out);
    FileLock taken(arguments.out / (name + ".lock"),
                   arguments.out.string() + ": another " + name + " writes into this folder", FileLock::Inherited::no);
    if (!may_begin(arguments, name)) {
      log_line(name + ": this run has already finished: nothing is left to resume, nothing was touched");
      return 0;
    }
    taken.sign(called);
    lock.emplace(std::move(taken));
    if (body.run(arguments)) code = ExitCode::interrupted;
  } catch (const Error& error) {
    fail(error.code(), error.what());
  } catch (const std::filesystem::filesystem_error& error) {
    fail(ExitCode::input_output, error.what());
  } catch (const std::bad_alloc&) {
    fail(ExitCode::failure, "out of memory");
  } catch (const std::exception& error) {
    fail(ExitCode::failure, error.what());
  }
  if (!lock) return static_cast<int>(code);
  try {
    RunSummary summary = body.summarise();
    const auto& warnings = summary.warnings;
    if (code == ExitCode::success &&
        std::any_of(warnings.begin(), warnings.end(), [](const Warning& w) { return w.result_in_doubt; })) {
      code = ExitCode::in_doubt;
      reason = "ended, with warnings that put the result in doubt";
    }
    summary.process = name;
    summary.exit = code;
    if (!reason.empty()) summary.reason = reason;
    summary.wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    write_summary(summary_file(arguments, name), summary);
  } catch (const std::exception& error) {
    // After a failure, this error is only a consequence. `poretwin run` shows the last line with "error:" in a log.
    log_line(name + (code == ExitCode::success ? ": error: " : ": and then: ") + error.what());
    if (code == ExitCode::success) code = ExitCode::input_output;
  }
  return static_cast<int>(code);
}

}  // namespace poretwin::coupling
