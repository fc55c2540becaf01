#include "common/coupling/phase_main.hpp"

#include "common/case/identity.hpp"
#include "common/case/pace.hpp"
#include "common/case/programs.hpp"
#include "common/coupling/drive.hpp"
#include "common/coupling/interrupt.hpp"
#include "common/coupling/process_main.hpp"
#include "common/output/run_recorder.hpp"

#include <fmt/format.h>
#include <fstream>

namespace poretwin::coupling {
namespace {

/// Results of a run, kept up to date step by step.
struct Run {
  std::unique_ptr<Phase> phase;
  std::unique_ptr<Recorder> recorder;
  DriveReport report;
  std::optional<Trace> trace;
  std::uint64_t bytes_sent = 0, bytes_received = 0;
};

/// Writes the case sent by the coupler to OUT/case.toml, so that the run's folder contains all its input, and reads it.
Case case_of_coupler(Transport& line, Role role, const Arguments& arguments, const ParticipantOptions& options) {
  auto file = request_case(line, role, options);
  const auto path = arguments.out / "case.toml";
  std::ofstream stream(path, std::ios::binary);
  stream << file.text;
  stream.close();
  if (!stream) throw FileError("cannot write " + path.string() + ": is the disk full or the folder write-protected?");
  file.overrides.insert(file.overrides.end(), arguments.overrides.begin(), arguments.overrides.end());
  return read_case(path, file.overrides);
}

/// Throws CaseError unless the case has this phase only: without a partner no fields arrive.
void expect_own(const Case& scene, Role role) {
  const auto fail = [&](std::string_view found, std::string_view hint) {
    throw CaseError(fmt::format("{}: --alone: expected a case of the {} alone, found {}; {}", scene.path.string(),
                                to_string(role), found, hint));
  };
  if (scene.coupled())
    fail("water and soil that moves",
         "`poretwin run` starts both phases, --set 'solid.model=\"rigid\"' leaves the water in soil at rest");
  if (scene.deformable() != (role == Role::solid))
    fail(scene.deformable() ? "soil without water" : "no soil that moves",
         fmt::format("start poretwin-{}", scene.deformable() ? "solid" : "fluid"));
}

/// Throws CaseError where the water of this case belongs to another program (particles, a field or both).
void expect_representation(const Case& scene, Role role, FluidCase::Representation representation) {
  if (role != Role::fluid || scene.fluid.representation == representation) return;
  throw CaseError(fmt::format("{}: fluid.representation = \"{}\" is for poretwin-{}", scene.path.string(),
                              scene.is_field()  ? "field"
                              : scene.is_both() ? "both"
                                                : "particles",
                              water_program(scene.fluid.representation)));
}

void execute(const Arguments& arguments, Role role, const std::function<std::unique_ptr<Phase>(const Case&)>& make,
             FluidCase::Representation representation, Run& run) {
  const std::string name(to_string(role));
  if (arguments.profile) run.report.trace = &run.trace.emplace(arguments.out, name);
  ParticipantOptions options;
  options.welcome_deadline = Milliseconds(static_cast<long>(1000.0 * arguments.wait_deadline));
  options.coupler_deadline = Milliseconds(static_cast<long>(2000.0 * arguments.frozen_deadline));
  options.say = log_line;
  options.interrupted = interrupted;
  std::optional<CurveKeys> keys;
  if (!arguments.keys.empty()) keys = read_curve_keys(arguments.keys, KeyHolder::participant);
  // The coupler closes a connection that is silent for long. A process that needs nothing from it therefore connects
  // only after its particles are made, which can take minutes in 3D.
  const bool asks = !arguments.alone && arguments.case_file.empty();
  auto line = asks ? connect_socket(arguments.address, keys) : nullptr;
  const Case scene =
      asks ? case_of_coupler(*line, role, arguments, options) : read_case(arguments.case_file, arguments.overrides);
  expect_representation(scene, role, representation);
  if (arguments.alone) expect_own(scene, role);
  run.phase = make(scene);
  std::vector<std::string> gauges;
  for (const auto& gauge : scene.gauges)
    if (gauge.phase == name) gauges.push_back(gauge.name);
  run.report.warnings.begin([name](const std::string& said) { log_line(name + ": " + said); }, std::move(gauges));
  run.recorder = make_run_recorder(arguments.out, name, scene, arguments.resume);
  const CheckpointStore checkpoints(arguments.out, name, run_identity(scene), log_line,
                                    arguments.accept_changed_program);
  if (arguments.alone) {
    ProgressLines lines(arguments.progress_descriptor);
    drive_alone(
        *run.phase, scene, *run.recorder, [&](const Progress& p) { lines.write(p, p.time >= p.end); }, run.report,
        Checkpoints{&checkpoints, arguments.checkpoint_every, arguments.resume}, shortest_time(scene));
    return;
  }
  Contract contract = run.phase->contract();
  if (contract.case_digest.empty()) contract.case_digest = scene.digest();
  contract.case_part = scene.coupled_part();
  if (!line) line = connect_socket(arguments.address, keys);
  options.keeps_checkpoints = true;
  if (arguments.resume)
    for (const auto& checkpoint : checkpoints.whole()) options.checkpoints.push_back(checkpoint.name);
  Participant participant(std::move(line), role, std::move(contract), std::move(options));
  auto note_totals = [&] {
    run.bytes_sent = participant.totals().bytes_sent;
    run.bytes_received = participant.totals().bytes_received;
  };
  try {
    drive_coupled(*run.phase, participant, *run.recorder, run.report, &checkpoints);
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
  summary.warnings = r.warnings.all();
  if (run.recorder) summary.files = run.recorder->files();
  return summary;
}

}  // namespace

int phase_main(int argc, char** argv, Role role, std::function<std::unique_ptr<Phase>(const Case&)> make,
               FluidCase::Representation representation) {
  Run run;
  const std::string name(to_string(role));
  return process_main(argc, argv, "poretwin-" + (role == Role::fluid ? water_program(representation) : name), name,
                      role == Role::solid ? Program::solid : Program::phase,
                      {[&](const Arguments& arguments) {
                         execute(arguments, role, make, representation, run);
                         return run.report.interrupted;
                       },
                       [&] { return summarise(run); }});
}

}  // namespace poretwin::coupling
