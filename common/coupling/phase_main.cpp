#include "common/coupling/phase_main.hpp"

#include "common/coupling/drive.hpp"
#include "common/coupling/interrupt.hpp"
#include "common/coupling/process_main.hpp"
#include "common/output/run_recorder.hpp"

namespace poretwin::coupling {
namespace {

/// What a run leaves behind, filled step by step.
struct Run {
  std::unique_ptr<Phase> phase;
  std::unique_ptr<Recorder> recorder;
  DriveReport report;
  std::uint64_t bytes_sent = 0, bytes_received = 0;
};

void execute(const Arguments& arguments, Role role, const std::function<std::unique_ptr<Phase>(const Case&)>& make,
             Run& run) {
  const std::string name(to_string(role));
  const Case scene = read_case(arguments.case_file, arguments.overrides);
  run.phase = make(scene);
  run.recorder = make_run_recorder(arguments.out, name, scene);
  if (arguments.alone) {
    ProgressLines lines(arguments.progress_descriptor);
    drive_alone(
        *run.phase, scene, *run.recorder, [&](const Progress& p) { lines.write(p, p.time >= p.end); }, run.report);
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

RunSummary summarise(const Run& run) {
  RunSummary summary;
  summary.reason = run.report.reason;
  const auto& r = run.report;
  summary.seconds = {
      {"computing", r.computing}, {"waiting", r.waiting}, {"sending", r.sending}, {"writing", r.writing}};
  summary.steps = {{"windows", static_cast<double>(r.windows)}, {"rejected", static_cast<double>(r.rejected)}};
  summary.counters.emplace_back("end_time_s", r.time);
  summary.counters.emplace_back("bytes_sent", static_cast<double>(run.bytes_sent));
  summary.counters.emplace_back("bytes_received", static_cast<double>(run.bytes_received));
  for (const auto& [cause, windows] : r.limited_by)
    summary.counters.emplace_back("windows limited by " + cause, static_cast<double>(windows));
  if (run.phase)
    for (const auto& [key, value] : run.phase->counters()) summary.counters.emplace_back(key, value);
  if (run.recorder) summary.files = run.recorder->files();
  return summary;
}

}  // namespace

int phase_main(int argc, char** argv, Role role, std::function<std::unique_ptr<Phase>(const Case&)> make) {
  Run run;
  return process_main(argc, argv, std::string(to_string(role)), Program::phase,
                      {[&](const Arguments& arguments) {
                         execute(arguments, role, make, run);
                         return run.report.interrupted;
                       },
                       [&] { return summarise(run); }});
}

}  // namespace poretwin::coupling
