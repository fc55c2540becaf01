#include "coupler/schedule.hpp"

#include "common/core/hash.hpp"
#include "common/coupling/drive.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <new>
#include <optional>

namespace poretwin::coupling {
namespace {

Role other(Role role) { return role == Role::fluid ? Role::solid : Role::fluid; }

/// Digest of all parts of a publication that can influence the rest of a run.
std::uint64_t digest_of(const Snapshot& snapshot) {
  Snapshot copy = snapshot;
  PointSet points = *snapshot.points;
  Archive archive;
  archive(copy.time, copy.proposed_interval, copy.limited_by, points, copy.fields);
  return fnv1a(archive.bytes());
}

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (const auto& name : names) text += (text.empty() ? "" : ", ") + name;
  return text.empty() ? "none" : text;
}

}  // namespace

class Schedule::Implementation {
 public:
  Implementation(Broker& broker, std::unique_ptr<SpatialMapping> mapping, WindowClock::Settings settings,
                 std::function<void(const Progress&)> progress, Checkpoints checkpoints, Scheme scheme, Trace* trace)
      : broker_(broker),
        clock_(settings),
        mapping_(std::move(mapping)),
        progress_(std::move(progress)),
        scheme_(scheme),
        checkpoints_(checkpoints),
        checkpoint_schedule_(checkpoints),
        trace_(trace) {}

  void run() {
    try {
      broker_.gather();
      start();
      if (std::holds_alternative<Settled>(scheme_) && found_wanted().empty()) {
        broker_.say("the fluid does not take what a pass found: every window is crossed once");
        scheme_ = Serial{};
      }
      while (!clock_.finished() && !broker_.interrupted()) {
        window();
        if (checkpoint_schedule_.due() && !clock_.finished()) checkpoint();
      }
      if (!clock_.finished() && checkpoints_.store) checkpoint();
      finish();
    } catch (const Error& error) {
      broker_.abort(error, broker_.culprit());
      throw;
    } catch (const std::bad_alloc&) {
      broker_.abort(Error(ExitCode::failure, "out of memory"), "coupler");
      throw;
    } catch (const std::exception& error) {
      broker_.abort(Error(ExitCode::failure, error.what()), "coupler");
      throw;
    }
  }

  void note_waiting(const std::string& whom) { report_progress(whom); }

  ScheduleReport report() const {
    ScheduleReport out = report_;
    out.time = clock_.time();
    out.pairs = mapping_->counts();
    out.accounts = mapping_->accounts();
    return out;
  }

 private:
  /// The last publication of one side, shared with the copies that a restore may need.
  using State = std::shared_ptr<const Snapshot>;
  State& now(Role role) { return role == Role::fluid ? fluid_ : solid_; }

  void start() {
    fluid_ = receive_publication(Role::fluid, 0.0, nullptr);
    solid_ = receive_publication(Role::solid, 0.0, nullptr);
    if (checkpoints_.store)
      for (const Role role : {Role::fluid, Role::solid})
        if (!broker_.keeps_checkpoints(role)) {
          if (checkpoints_.resume)
            throw PeerError(fmt::format("the {} keeps no checkpoints: this run cannot be resumed", to_string(role)));
          broker_.say(fmt::format("no checkpoints in this run: the {} keeps none", to_string(role)));
          checkpoints_.store = nullptr;
          checkpoint_schedule_ = CheckpointSchedule(checkpoints_);
          break;
        }
    if (checkpoints_.resume) {
      resume();
      return;
    }
    if (checkpoints_.store) checkpoints_.store->keep_only({});
    for (const Role role : {Role::fluid, Role::solid}) {
      Message message;
      message.body = Initialise{true, true};
      send_mapped(role, std::move(message), nullptr, *now(other(role)), *now(other(role)));
      now(role) = receive_publication(role, 0.0, now(role)->points);
    }
  }

  /// Writes or reads the coupler's own state. It contains only digests of the participants' publications, since the
  /// participants publish again when they resume.
  void archive(Archive& archive) {
    std::uint64_t fluid = 0, solid = 0;
    if (!archive.loading()) {
      fluid = digest_of(*fluid_);
      solid = digest_of(*solid_);
    }
    archive(clock_, step_, *mapping_, report_, fluid, solid);
    if (archive.loading()) digests_ = {fluid, solid};
  }

  /// Lets both participants write their state. The checkpoint is valid once the coupler has written its own file, the
  /// last of the three.
  void checkpoint() {
    const Span span(report_.checkpointing, trace_, "checkpointing");
    const std::string name = checkpoint_schedule_.name(step_);
    for (const Role role : {Role::fluid, Role::solid}) {
      Message message = message_of(CheckpointOrder{name, checkpoint_schedule_.kept()}, step_);
      message.time = clock_.time();
      broker_.send(role, std::move(message));
    }
    for (const Role role : {Role::fluid, Role::solid}) {
      const Message answer = broker_.wait(role);
      const auto* written = std::get_if<CheckpointWritten>(&answer.body);
      if (!written || written->name != name)
        throw PeerError(fmt::format("{} answered {} to CHECKPOINT {}", to_string(role), describe(answer), name));
    }
    Archive state;
    archive(state);
    checkpoints_.store->write({name, step_, clock_.time()}, state);
    checkpoint_schedule_.committed(name);
    checkpoints_.store->keep_only(checkpoint_schedule_.kept());
    ++report_.checkpoints;
  }

  /// Resumes from the newest checkpoint that all three processes have.
  void resume() {
    const auto mine = checkpoints_.store->whole();
    const auto &fluids = broker_.checkpoints(Role::fluid), &solids = broker_.checkpoints(Role::solid);
    std::vector<std::string> names;
    const auto has = [](const auto& list, const std::string& name) {
      return std::find(list.begin(), list.end(), name) != list.end();
    };
    const auto chosen = std::find_if(mine.begin(), mine.end(), [&](const Checkpoint& c) {
      names.push_back(c.name);
      return has(fluids, c.name) && has(solids, c.name);
    });
    if (chosen == mine.end())
      throw FileError(
          fmt::format("nothing to resume from: expected one checkpoint that all three hold whole, found: "
                      "coupler {}; fluid {}; solid {}",
                      listed(names), listed(fluids), listed(solids)));
    Archive state = checkpoints_.store->read(chosen->name);
    archive(state);
    state.expect_end();
    broker_.say(fmt::format("resuming from checkpoint {}: step {}, t = {:g} s", chosen->name, step_, clock_.time()));
    checkpoint_schedule_.set_kept({chosen->name});
    for (const Role role : {Role::fluid, Role::solid}) {
      Message message = message_of(Resume{chosen->name}, step_);
      message.time = clock_.time();
      broker_.send(role, std::move(message));
      now(role) = receive_publication(role, clock_.time(), now(role)->points);
      if (!checkpoints_.changed_program &&
          digest_of(*now(role)) != (role == Role::fluid ? digests_.first : digests_.second))
        throw PeerError(fmt::format("the {} came back from checkpoint {} with a state other than the one that it saved",
                                    to_string(role), chosen->name));
    }
  }

  void window() {
    const auto accounts = mapping_->accounts();
    double limit = std::min(fluid_->proposed_interval, solid_->proposed_interval);
    const bool by_fluid = fluid_->proposed_interval <= solid_->proposed_interval;
    const std::string cause = by_fluid ? fluid_->limited_by : solid_->limited_by;  // copied: the window changes it
    std::string refused;
    iteration_ = 0;
    for (int attempt = 0;; ++attempt) {
      const auto plan = clock_.plan(limit);
      plan_ = plan;
      if (const auto rejection = try_window(plan, accounts)) {
        mapping_->set_accounts(accounts);
        ++iteration_;
        if (attempt >= most_rejections)
          throw PeerError(fmt::format("window {} from t = {:g} s was rejected {} times, last at {:g} s: {}", step_ + 1,
                                      plan.start, attempt + 1, plan.interval, rejection->reason));
        if (broker_.interrupted()) return;  // the window is given up: both sides are at its start again
        limit = retry_interval(plan.interval, rejection->suggested_interval);
        refused = "a refusal of longer windows: " + rejection->reason;
        continue;
      }
      ++step_;
      ++report_.windows;
      const bool shorter = plan.interval < 0.999 * std::min(fluid_limit_, solid_limit_);
      const std::string instant = "output instant or coupling.interval";
      ++report_.limited_by[shorter ? instant : cause];
      clock_.accept(plan, !refused.empty() ? refused
                          : shorter        ? instant
                                           : (by_fluid ? "the fluid: " : "the solid: ") + cause);
      report_progress("");
      return;
    }
  }

  /// Tries one window. Empty where it is accepted; otherwise the refusal, after both sides have been restored.
  std::optional<Reject> try_window(const WindowClock::Plan& plan,
                                   const std::vector<SpatialMapping::Account>& accounts) {
    fluid_limit_ = fluid_->proposed_interval;
    solid_limit_ = solid_->proposed_interval;
    const State fluid_start = fluid_, solid_start = solid_;
    if (std::holds_alternative<Parallel>(scheme_)) return pass_at_once(plan, fluid_start, solid_start);
    if (const auto* settled = std::get_if<Settled>(&scheme_))
      return settle(plan, fluid_start, solid_start, accounts, settled->tolerance);
    const auto* const settings = std::get_if<IterationSettings>(&scheme_);
    if (!settings) return pass(plan, fluid_start, solid_start, nullptr);
    WindowIteration iteration(*settings, broker_.contract(Role::solid));
    std::optional<Snapshot> given;  // the solid's fields that the fluid receives; absent in the first pass
    for (int k = 0; k < most_iterations; ++k) {
      if (auto rejection = pass(plan, fluid_start, solid_start, given ? &*given : nullptr)) return rejection;
      given = iteration.next(given ? *given : *solid_start, *solid_);
      if (!given) return std::nullopt;
      restore_state(fluid_start, solid_start, "iteration");
      mapping_->set_accounts(accounts);
      ++iteration_;
    }
    return Reject{RejectCode::step,
                  "",
                  "",
                  "",
                  0.5 * plan.interval,
                  fmt::format("not converged after {} iterations", most_iterations)};
  }

  /// Computes a window by the serial scheme, and repeats it until the solid moves as the fluid predicted.
  std::optional<Reject> settle(const WindowClock::Plan& plan, const State& fluid_start, const State& solid_start,
                               const std::vector<SpatialMapping::Account>& accounts, double tolerance) {
    State found;
    pass_ = 0;
    for (;;) {
      found_ = found.get();
      auto rejection = pass(plan, fluid_start, solid_start, nullptr);
      found_ = nullptr;
      if (rejection) return rejection;
      if (solid_->unsettled <= tolerance) return std::nullopt;
      ++pass_;
      const auto reason =
          fmt::format("{:.2g} of the weight missing in the balance, {:g} allowed", solid_->unsettled, tolerance);
      found = solid_;
      restore_state(fluid_start, solid_start, reason);
      mapping_->set_accounts(accounts);
      ++iteration_;
      if (pass_ == most_passes)
        return Reject{
            RejectCode::step, "", "", "", 0.5 * plan.interval, fmt::format("{}, after {} passes", reason, most_passes)};
    }
  }

  /// One pass with both solvers at the same time: each receives the other's state at the window's start, with the
  /// amounts that the other gave in the last window.
  std::optional<Reject> pass_at_once(const WindowClock::Plan& plan, const State& fluid_start,
                                     const State& solid_start) {
    ++report_.passes;
    order(Role::fluid, plan, nullptr, *solid_start, *solid_start);
    order(Role::solid, plan, nullptr, *fluid_start, *fluid_start);
    auto rejection = answer(Role::fluid, plan), of_solid = answer(Role::solid, plan);
    if (!rejection && !of_solid) return std::nullopt;
    if (rejection) ++report_.rejected_by_fluid;
    if (of_solid) ++report_.rejected_by_solid;
    const auto retry = [&](const Reject& r) { return retry_interval(plan.interval, r.suggested_interval); };
    if (!rejection || (of_solid && retry(*of_solid) < retry(*rejection))) rejection = std::move(of_solid);
    restore_state(fluid_start, solid_start, rejection->reason);
    return rejection;
  }

  /// One pass with both solvers, the fluid first. `solid_end`: the solid's fields at the window's end that the fluid
  /// receives; if nullptr, the fluid receives only the fields at the window's start.
  std::optional<Reject> pass(const WindowClock::Plan& plan, const State& fluid_start, const State& solid_start,
                             const Snapshot* solid_end) {
    ++report_.passes;
    const auto rejection_of_fluid = solid_end ? advance(Role::fluid, plan, solid_start.get(), *solid_end, *solid_start)
                                              : advance(Role::fluid, plan, nullptr, *solid_start, *solid_start);
    if (rejection_of_fluid) {
      ++report_.rejected_by_fluid;
      restore(Role::fluid, rejection_of_fluid->reason);
      return rejection_of_fluid;
    }
    if (auto rejection = advance(Role::solid, plan, fluid_start.get(), *fluid_, *fluid_)) {
      ++report_.rejected_by_solid;
      restore_state(fluid_start, solid_start, rejection->reason);
      return rejection;
    }
    return std::nullopt;
  }

  void restore_state(const State& fluid_start, const State& solid_start, const std::string& reason) {
    restore(Role::solid, reason);
    restore(Role::fluid, reason);
    fluid_ = fluid_start;
    solid_ = solid_start;
  }

  std::optional<Reject> advance(Role role, const WindowClock::Plan& plan, const Snapshot* start, const Snapshot& end,
                                const Snapshot& amounts) {
    order(role, plan, start, end, amounts);
    return answer(role, plan);
  }

  /// Sends ADVANCE to one side. `start` (may be nullptr) and `end`: the other side's state at the start and the end of
  /// the window; `amounts`: the state of the other side from which conservative amounts are taken.
  void order(Role role, const WindowClock::Plan& plan, const Snapshot* start, const Snapshot& end,
             const Snapshot& amounts) {
    Message message;
    message.step = step_ + 1;
    message.iteration = iteration_;
    message.time = plan.start;
    message.interval = plan.interval;
    message.body = Advance{plan.record_frame, plan.record_gauges, std::holds_alternative<Settled>(scheme_) ? pass_ : 0};
    send_mapped(role, std::move(message), start, end, amounts);
  }

  /// Waits for the answer of one side: its refusal; empty where it has computed the window.
  std::optional<Reject> answer(Role role, const WindowClock::Plan& plan) {
    Message answer = broker_.wait(role);
    if (answer.step != step_ + 1 || answer.iteration != iteration_)
      throw PeerError(fmt::format("{} answered {} (attempt {}), expected step {} (attempt {})", to_string(role),
                                  describe(answer), answer.iteration, step_ + 1, iteration_));
    if (auto* reject = std::get_if<Reject>(&answer.body)) return *reject;
    now(role) = admitted(role, std::move(answer), plan.end, now(role)->points);
    return std::nullopt;
  }

  void restore(Role role, const std::string& reason) {
    Message message;
    message.step = step_ + 1;
    message.iteration = iteration_;
    message.time = plan_.start;
    message.body = Restore{reason};
    broker_.send(role, std::move(message));
  }

  void finish() {
    report_.interrupted = !clock_.finished();
    for (const Role role : {Role::fluid, Role::solid}) {
      Message message;
      message.step = step_;
      message.time = clock_.time();
      message.body = Finish{report_.interrupted ? "interrupted" : "end", true, true};
      broker_.send(role, std::move(message));
    }
    broker_.say_goodbye();
  }

  void send_mapped(Role role, Message message, const Snapshot* start, const Snapshot& end, const Snapshot& amounts) {
    const auto& receiver = *now(role)->points;
    const auto& specs = broker_.contract(role).takes;
    Inbox inbox = mapped(role, start, end, amounts);
    report_.fields_skipped += end.fields.size() - inbox.fields.size();
    message.points = {receiver.dimension, receiver.revision, receiver.n_active, receiver.n_active, false};
    message.arrays.push_back({std::string(coverage_array), "1", 1, std::move(inbox.coverage)});
    message.arrays.push_back({std::string(asymmetry_array), "1", 1, std::move(inbox.asymmetry)});
    message.arrays.push_back({std::string(spread_array), "1", 1, std::move(inbox.spread)});
    const auto add = [&](Field& field, std::string_view suffix) {
      const auto spec =
          std::find_if(specs.begin(), specs.end(), [&](const FieldSpec& s) { return s.name == field.name; });
      message.arrays.push_back(
          {field.name + std::string(suffix), spec->unit, field.components, std::move(field.values)});
    };
    for (auto& field : inbox.fields) add(field, "");
    for (auto& field : inbox.at_start) add(field, start_suffix);
    for (auto& field : inbox.found) add(field, found_suffix);
    broker_.send(role, std::move(message));
  }

  /// Maps the other side's fields to this side's points. Fields with `in_time` are also mapped from the state at the
  /// window's start, when the other side's points may have been elsewhere.
  Inbox mapped(Role role, const Snapshot* start, const Snapshot& end, const Snapshot& amounts) {
    const Span span(report_.mapping, trace_, "mapping");
    const Role giver = other(role);
    const auto& receiver = *now(role)->points;
    std::vector<FieldSpec> intensities, shared, in_time;
    for (const auto& spec : broker_.contract(role).takes) {
      (spec.mapping == Mapping::conservative && &amounts != &end ? shared : intensities).push_back(spec);
      if (start && spec.in_time && spec.mapping == Mapping::consistent) in_time.push_back(spec);
    }
    // The start is mapped first, since the pair lists of the last window's end are still valid for its points.
    std::vector<Field> at_start;
    if (!in_time.empty()) at_start = mapping_->map(giver, *start->points, start->fields, in_time, receiver).fields;
    Inbox inbox = mapping_->map(giver, *end.points, end.fields, intensities, receiver);
    inbox.at_start = std::move(at_start);
    if (found_ && role == Role::fluid)
      inbox.found = mapping_->map(giver, *found_->points, found_->fields, found_wanted(), receiver).fields;
    if (!shared.empty()) {
      auto got = mapping_->map(giver, *amounts.points, amounts.fields, shared, receiver).fields;
      std::move(got.begin(), got.end(), std::back_inserter(inbox.fields));
    }
    return inbox;
  }

  /// The fields of the solid's last pass that the fluid receives in a repeated window.
  [[nodiscard]] std::vector<FieldSpec> found_wanted() const {
    std::vector<FieldSpec> wanted;
    for (const auto& spec : broker_.contract(Role::fluid).takes)
      if (spec.found && spec.mapping == Mapping::consistent) wanted.push_back(spec);
    return wanted;
  }

  State receive_publication(Role role, double time, const std::shared_ptr<const PointSet>& previous) {
    return admitted(role, broker_.wait(role), time, previous);
  }

  State admitted(Role role, Message message, double time, const std::shared_ptr<const PointSet>& previous) {
    if (!message.points.sent) ++report_.points_unchanged;
    Snapshot snapshot = admit(std::move(message), broker_.contract(role), previous);
    // Both sides must be at the same time, up to rounding.
    if (std::abs(snapshot.time - time) > 1e-9 * std::max(std::abs(time), 1e-3 * clock_.end()))
      throw PeerError(fmt::format("{} is at t = {} s after step {}, expected t = {} s", to_string(role), snapshot.time,
                                  step_ + 1, time));
    return std::make_shared<const Snapshot>(std::move(snapshot));
  }

  void report_progress(const std::string& waiting_for) {
    if (progress_) progress_({clock_.time(), clock_.end(), step_, plan_.interval, waiting_for});
  }

  Broker& broker_;
  WindowClock clock_;
  std::unique_ptr<SpatialMapping> mapping_;
  std::function<void(const Progress&)> progress_;
  Scheme scheme_;
  State fluid_, solid_;
  std::uint64_t step_ = 0;  ///< number of accepted windows
  std::uint32_t iteration_ = 0;
  unsigned pass_ = 0;                ///< passes of the Settled scheme through this window so far
  const Snapshot* found_ = nullptr;  ///< in repeated windows, the solid's state at the end of its last pass
  WindowClock::Plan plan_;
  double fluid_limit_ = no_limit, solid_limit_ = no_limit;
  ScheduleReport report_;
  Checkpoints checkpoints_;
  CheckpointSchedule checkpoint_schedule_;
  Trace* trace_;
  std::pair<std::uint64_t, std::uint64_t> digests_{};  ///< of the publications of fluid and solid at the checkpoint
};

Schedule::Schedule(Broker& broker, std::unique_ptr<SpatialMapping> mapping, WindowClock::Settings settings,
                   std::function<void(const Progress&)> progress, Checkpoints checkpoints, Scheme scheme, Trace* trace)
    : implementation_(std::make_unique<Implementation>(broker, std::move(mapping), settings, std::move(progress),
                                                       checkpoints, scheme, trace)) {}
Schedule::~Schedule() = default;
void Schedule::run() { implementation_->run(); }
void Schedule::note_waiting(const std::string& whom) { implementation_->note_waiting(whom); }
ScheduleReport Schedule::report() const { return implementation_->report(); }

}  // namespace poretwin::coupling
