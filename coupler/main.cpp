// poretwin-coupler: reads the case, binds its address, runs the schedule, writes OUT/coupler.summary.json.
#include "common/case/case.hpp"
#include "common/case/identity.hpp"
#include "common/case/pace.hpp"
#include "common/core/memory.hpp"
#include "common/coupling/interrupt.hpp"
#include "common/coupling/process_main.hpp"
#include "coupler/broker.hpp"
#include "coupler/pairing.hpp"
#include "coupler/schedule.hpp"

#include <memory>
#include <optional>

namespace {

using namespace poretwin;
using namespace poretwin::coupling;

RunSummary summarise(const Broker& broker, const ScheduleReport& report) {
  const auto& totals = broker.totals();
  auto number = [](std::uint64_t n) { return static_cast<double>(n); };
  RunSummary out;
  out.reason = report.interrupted ? "interrupted" : "end";
  out.seconds = {{"mapping", report.mapping},
                 {"waiting_for_fluid", totals.waiting_for_fluid},
                 {"waiting_for_solid", totals.waiting_for_solid},
                 {"sending", totals.sending},
                 {"checkpointing", report.checkpointing}};
  out.steps = {{"windows", number(report.windows)},
               {"rejected", number(report.rejected_by_fluid + report.rejected_by_solid)},
               {"rejected_by_fluid", number(report.rejected_by_fluid)},
               {"rejected_by_solid", number(report.rejected_by_solid)},
               {"passes", number(report.passes)}};
  out.counters = {{"end_time_s", report.time},
                  {"bytes_sent", number(totals.bytes_sent)},
                  {"bytes_received", number(totals.bytes_received)},
                  {"pair_lists_rebuilt", number(report.pairs.rebuilds)},
                  {"pair_lists_reused", number(report.pairs.reuses)},
                  {"points_unchanged", number(report.points_unchanged)},
                  {"fields_skipped", number(report.fields_skipped)},
                  {"checkpoints", number(report.checkpoints)}};
  for (const auto& [cause, windows] : report.limited_by)
    out.counters.emplace_back("windows limited by " + cause, number(windows));
  const char axes[] = "xyz";
  for (const auto& account : report.accounts)
    for (std::size_t c = 0; c < account.given.size(); ++c) {
      const std::string name = account.field + " " + axes[c % 3] + " (" + account.unit + ") ";
      out.counters.emplace_back(name + "given", account.given[c]);
      out.counters.emplace_back(name + "delivered", account.delivered[c]);
      out.counters.emplace_back(name + "undelivered", account.undelivered[c]);
    }
  return out;
}

Scheme scheme_of(const Case& scene) {
  const CouplingCase& c = scene.coupling;
  if (c.scheme == CouplingCase::Scheme::serial) return Serial{};
  if (c.scheme == CouplingCase::Scheme::parallel) return Parallel{};
  if (scene.predicts()) return Settled{c.settled_below()};
  IterationSettings out;
  out.acceleration = AccelerationKind::none;
  if (c.tolerance) out.tolerance = *c.tolerance;
  if (c.acceleration == CouplingCase::Acceleration::aitken) out.acceleration = AccelerationKind::aitken;
  if (c.acceleration == CouplingCase::Acceleration::quasi_newton) out.acceleration = AccelerationKind::quasi_newton;
  return out;
}

/// What must outlive an exception, so that the summary can still be written.
struct Run {
  std::optional<Trace> trace;
  std::unique_ptr<Hub> hub;
  std::optional<CheckpointStore> checkpoints;
  std::optional<Broker> broker;
  std::optional<Schedule> schedule;
};

void execute(const Arguments& arguments, Run& run) {
  const Case scene = read_case(arguments.case_file, arguments.overrides);
  std::optional<CurveKeys> keys;
  if (!arguments.keys.empty()) keys = read_curve_keys(arguments.keys, KeyHolder::coupler);
  run.hub = bind_socket(arguments.address, arguments.allow_any_address, keys, Callers::anybody);
  auto lines = std::make_shared<ProgressLines>(arguments.progress_descriptor);
  BrokerOptions options;
  if (arguments.profile) options.trace = &run.trace.emplace(arguments.out, "coupler");
  options.dimension = scene.general.dimension;
  options.case_digest = scene.digest();
  options.case_part = scene.coupled_part();
  options.case_text = scene.text;
  options.case_overrides = scene.overrides;
  options.wait_deadline = Milliseconds(static_cast<long>(1000.0 * arguments.wait_deadline));
  options.frozen_deadline = Milliseconds(static_cast<long>(1000.0 * arguments.frozen_deadline));
  options.say = log_line;
  options.interrupted = interrupted;
  options.waiting = [&run](const std::string& whom) {
    if (run.schedule) run.schedule->note_waiting(whom);
  };
  run.checkpoints.emplace(arguments.out, "coupler", run_identity(scene), log_line, arguments.accept_changed_program);
  Trace* const trace = options.trace;
  run.broker.emplace(*run.hub, std::move(options));
  auto [shortest, of_what] = shortest_time(scene);
  run.schedule.emplace(
      *run.broker,
      scene.is_field() ? make_paired_mapping(scene.general.dimension) : make_mapping(scene.general.dimension),
      WindowClock::Settings{scene.general.end_time, scene.coupling.interval, scene.output.interval,
                            scene.output.gauge_interval, shortest, of_what},
      [lines](const Progress& p) { lines->write(p, p.time >= p.end); },
      Checkpoints{&*run.checkpoints, arguments.checkpoint_every, arguments.resume, arguments.accept_changed_program},
      scheme_of(scene), trace);
  log_line("coupler: listening at " + run.hub->address());
  keep_freed_memory();
  run.schedule->run();
}

}  // namespace

int main(int argc, char** argv) {
  Run run;
  return process_main(argc, argv, "poretwin-coupler", "coupler", Program::coupler,
                      {[&](const Arguments& arguments) {
                         execute(arguments, run);
                         return run.schedule->report().interrupted;
                       },
                       [&] { return run.schedule ? summarise(*run.broker, run.schedule->report()) : RunSummary{}; }});
}
