#include "common/coupling/process_main.hpp"

#include "common/core/memory.hpp"
#include "common/coupling/interrupt.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <new>

namespace poretwin::coupling {
int process_main(int argc, char** argv, const std::string& name, Program program, const ProcessBody& body) {
  const auto start = std::chrono::steady_clock::now();
  const InterruptGuard guard;
  return_freed_memory();
  Arguments arguments;
  ExitCode code = ExitCode::success;
  std::string reason;
  auto fail = [&](ExitCode why, const std::string& what) {
    code = why;
    reason = what;
    log_line(name + ": error: " + what);
  };
  try {
    arguments = parse_arguments(argc, argv, program);
    if (arguments.help) {
      std::fputs(usage("poretwin-" + name, program).c_str(), stdout);
      return 0;
    }
    std::filesystem::create_directories(arguments.out);
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
  if (arguments.out.empty()) return static_cast<int>(code);
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
    write_summary(arguments.out / (name + ".summary.json"), summary);
  } catch (const std::exception& error) {
    log_line(name + ": error: " + error.what());
    if (code == ExitCode::success) code = ExitCode::input_output;
  }
  return static_cast<int>(code);
}

}  // namespace poretwin::coupling
