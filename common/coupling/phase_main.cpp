#include "common/coupling/phase_main.hpp"

#include "common/coupling/drive.hpp"
#include "common/coupling/interrupt.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>

#if __has_include("common/output/run_recorder.hpp")
#include "common/output/run_recorder.hpp"
#else
namespace poretwin {
std::unique_ptr<Recorder> make_run_recorder(const std::filesystem::path& out_dir, const std::string& phase_name, const Case& scene);
}
#endif

namespace poretwin::coupling {
namespace {

/// What a run leaves behind, filled step by step.
struct Run {
  std::unique_ptr<Phase> phase;
  std::unique_ptr<Recorder> recorder;
  DriveReport report;
  std::uint64_t bytes_sent = 0, bytes_received = 0;
};

void execute(const Arguments& arguments, Role role, const std::function<std::unique_ptr<Phase>(const Case&)>& make, Run& run) {
  const std::string name(to_string(role));
  const Case scene = read_case(arguments.case_file, arguments.overrides);
  run.phase = make(scene);
  run.recorder = make_run_recorder(arguments.out, name, scene);
  if (arguments.alone) {
    ProgressLines lines(arguments.progress_descriptor);
    drive_alone(*run.phase, scene, *run.recorder, [&](const Progress& p) { lines.write(p, p.time >= p.end); }, run.report);
    return;
  }
  Contract contract = run.phase->contract();
  if (contract.case_digest.empty()) contract.case_digest = scene.digest();
  ParticipantOptions options;
  options.welcome_deadline = Milliseconds(static_cast<long>(1000.0 * arguments.wait_deadline));
  options.coupler_deadline = Milliseconds(static_cast<long>(2000.0 * arguments.frozen_deadline));
  options.say = log_line;
  options.interrupted = interrupted;
  Participant participant(connect_socket(arguments.address), role, std::move(contract), std::move(options));
  auto note_totals = [&] {
    run.bytes_sent = participant.totals().bytes_sent;
    run.bytes_received = participant.totals().bytes_received;
  };
  try {
    drive_coupled(*run.phase, participant, *run.recorder, run.report);
  } catch (...) {
    note_totals();
    throw;
  }
  note_totals();
}

RunSummary summarise(const std::string& name, const Run& run) {
  RunSummary summary;
  summary.process = name;
  summary.reason = run.report.reason;
  const auto& r = run.report;
  summary.seconds = {{"computing", r.computing}, {"waiting", r.waiting}, {"sending", r.sending}, {"writing", r.writing}};
  summary.steps = {{"windows", static_cast<double>(r.windows)}, {"rejected", static_cast<double>(r.rejected)}};
  summary.counters.emplace_back("end_time_s", r.time);
  summary.counters.emplace_back("bytes_sent", static_cast<double>(run.bytes_sent));
  summary.counters.emplace_back("bytes_received", static_cast<double>(run.bytes_received));
  if (run.phase)
    for (const auto& [key, value] : run.phase->counters()) summary.counters.emplace_back(key, value);
  if (run.recorder) summary.files = run.recorder->files();
  return summary;
}

}  // namespace

int phase_main(int argc, char** argv, Role role, std::function<std::unique_ptr<Phase>(const Case&)> make) {
  const std::string name(to_string(role));
  const auto start = std::chrono::steady_clock::now();
  const InterruptGuard guard;
  Arguments arguments;
  Run run;
  ExitCode code = ExitCode::success;
  std::string reason;
  auto fail = [&](ExitCode why, const std::string& what) {
    code = why;
    reason = what;
    log_line(name + ": error: " + what);
  };
  try {
    arguments = parse_arguments(argc, argv, Program::phase);
    if (arguments.help) {
      std::fputs(usage("poretwin-" + name, Program::phase).c_str(), stdout);
      return 0;
    }
    std::filesystem::create_directories(arguments.out);
    execute(arguments, role, make, run);
    if (run.report.interrupted) code = ExitCode::interrupted;
  } catch (const Error& error) {
    fail(error.code(), error.what());
  } catch (const std::filesystem::filesystem_error& error) {
    fail(ExitCode::input_output, error.what());
  } catch (const std::bad_alloc&) {
    fail(ExitCode::failure, "out of memory");
  } catch (const std::exception& error) {
    fail(ExitCode::failure, error.what());
  }
  if (!arguments.out.empty()) {
    try {
      RunSummary summary = summarise(name, run);
      summary.exit = code;
      if (!reason.empty()) summary.reason = reason;
      summary.wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      write_summary(arguments.out / (name + ".summary.json"), summary);
    } catch (const std::exception& error) {
      log_line(name + ": error: " + error.what());
      if (code == ExitCode::success) code = ExitCode::input_output;
    }
  }
  return static_cast<int>(code);
}

}  // namespace poretwin::coupling
