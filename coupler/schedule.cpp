#include "coupler/schedule.hpp"

#include "common/coupling/drive.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

namespace poretwin::coupling {
namespace {

using Clock = std::chrono::steady_clock;

Role other(Role role) { return role == Role::fluid ? Role::solid : Role::fluid; }

}  // namespace

class Schedule::Implementation {
 public:
  Implementation(Broker& broker, int dimension, WindowClock::Settings settings,
                 std::function<void(const Progress&)> progress, std::optional<IterationSettings> iteration)
      : broker_(broker),
        clock_(settings),
        mapping_(make_mapping(dimension)),
        progress_(std::move(progress)),
        iteration_settings_(iteration) {}

  void run() {
    try {
      broker_.gather();
      start();
      while (!clock_.finished() && !broker_.interrupted()) window();
      finish();
    } catch (const Error& error) {
      broker_.abort(error, broker_.culprit());
      throw;
    } catch (const std::exception& error) {
      broker_.abort(Error(ExitCode::failure, error.what()), "coupler");
      throw;
    }
  }

  void note_waiting(const std::string& whom) { tell_progress(whom, false); }

  ScheduleReport report() const {
    ScheduleReport out = report_;
    out.time = clock_.time();
    out.pairs = mapping_->counts();
    out.accounts = mapping_->accounts();
    return out;
  }

 private:
  Snapshot& now(Role role) { return role == Role::fluid ? fluid_ : solid_; }

  void start() {
    fluid_ = receive_publication(Role::fluid, 0.0, nullptr);
    solid_ = receive_publication(Role::solid, 0.0, nullptr);
    for (const Role role : {Role::fluid, Role::solid}) {
      Message message;
      message.body = Initialise{true, true};
      send_mapped(role, std::move(message), nullptr, now(other(role)), now(other(role)));
      now(role) = receive_publication(role, 0.0, now(role).points);
    }
  }

  void window() {
    const auto accounts = mapping_->accounts();
    double limit = std::min(fluid_.proposed_interval, solid_.proposed_interval);
    const std::string& cause =
        fluid_.proposed_interval <= solid_.proposed_interval ? fluid_.limited_by : solid_.limited_by;
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
        limit = retry_interval(plan.interval, rejection->suggested_interval);
        continue;
      }
      ++step_;
      ++report_.windows;
      ++report_.limited_by[plan.interval < 0.999 * std::min(fluid_limit_, solid_limit_)
                               ? "output instant or coupling.interval"
                               : cause];
      clock_.accept(plan);
      tell_progress("", clock_.finished());
      return;
    }
  }

  /// Nothing when the window stands; else the refusal, with both sides restored.
  std::optional<Reject> try_window(const WindowClock::Plan& plan,
                                   const std::vector<SpatialMapping::Account>& accounts) {
    fluid_limit_ = fluid_.proposed_interval;
    solid_limit_ = solid_.proposed_interval;
    const Snapshot fluid_start = fluid_, solid_start = solid_;
    if (!iteration_settings_) return pass(plan, fluid_start, solid_start, nullptr);
    WindowIteration iteration(*iteration_settings_, broker_.contract(Role::solid));
    std::optional<Snapshot> given;  // the solid's end as the fluid is to see it; in the first pass its start
    for (int k = 0; k < most_iterations; ++k) {
      if (auto rejection = pass(plan, fluid_start, solid_start, given ? &*given : nullptr)) return rejection;
      given = iteration.next(given ? *given : solid_start, solid_);
      if (!given) return std::nullopt;
      take_back(fluid_start, solid_start, "iteration");
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

  /// Once through both solvers. `solid_end`: what the fluid is given of the solid at the window's end; null: its start
  /// is all there is.
  std::optional<Reject> pass(const WindowClock::Plan& plan, const Snapshot& fluid_start, const Snapshot& solid_start,
                             const Snapshot* solid_end) {
    ++report_.passes;
    const auto rejection_of_fluid = solid_end ? advance(Role::fluid, plan, &solid_start, *solid_end, solid_start)
                                              : advance(Role::fluid, plan, nullptr, solid_start, solid_start);
    if (rejection_of_fluid) {
      ++report_.rejected_by_fluid;
      restore(Role::fluid, rejection_of_fluid->reason);
      return rejection_of_fluid;
    }
    if (auto rejection = advance(Role::solid, plan, &fluid_start, fluid_, fluid_)) {
      ++report_.rejected_by_solid;
      take_back(fluid_start, solid_start, rejection->reason);
      return rejection;
    }
    return std::nullopt;
  }

  void take_back(const Snapshot& fluid_start, const Snapshot& solid_start, const std::string& reason) {
    restore(Role::solid, reason);
    restore(Role::fluid, reason);
    fluid_ = fluid_start;
    solid_ = solid_start;
  }

  /// `start` (or null) and `end`: the other side at the ends of the window; `amounts`: what it has given away.
  std::optional<Reject> advance(Role role, const WindowClock::Plan& plan, const Snapshot* start, const Snapshot& end,
                                const Snapshot& amounts) {
    Message message;
    message.step = step_ + 1;
    message.iteration = iteration_;
    message.time = plan.start;
    message.interval = plan.interval;
    message.body = Advance{plan.record_frame, plan.record_gauges};
    send_mapped(role, std::move(message), start, end, amounts);
    Message answer = broker_.wait(role);
    if (answer.step != step_ + 1 || answer.iteration != iteration_)
      throw PeerError(fmt::format("{} answered {} (attempt {}), expected step {} (attempt {})", to_string(role),
                                  describe(answer), answer.iteration, step_ + 1, iteration_));
    if (auto* reject = std::get_if<Reject>(&answer.body)) return *reject;
    now(role) = admitted(role, std::move(answer), plan.end, now(role).points);
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
    const auto begin = Clock::now();
    const auto& receiver = *now(role).points;
    const auto& specs = broker_.contract(role).takes;
    Inbox inbox = mapped(role, start, end, amounts);
    report_.fields_skipped += end.fields.size() - inbox.fields.size();
    report_.mapping += std::chrono::duration<double>(Clock::now() - begin).count();
    message.points = {receiver.dimension, receiver.revision, receiver.n_active, receiver.n_active, false};
    message.arrays.push_back({std::string(coverage_array), "1", 1, std::move(inbox.coverage)});
    message.arrays.push_back({std::string(asymmetry_array), "1", 1, std::move(inbox.asymmetry)});
    const auto add = [&](Field& field, std::string_view suffix) {
      const auto spec =
          std::find_if(specs.begin(), specs.end(), [&](const FieldSpec& s) { return s.name == field.name; });
      message.arrays.push_back(
          {field.name + std::string(suffix), spec->unit, field.components, std::move(field.values)});
    };
    for (auto& field : inbox.fields) add(field, "");
    for (auto& field : inbox.at_start) add(field, start_suffix);
    broker_.send(role, std::move(message));
  }

  /// The other side's fields at this side's points; those wanted in time also as they were at the window's start, when
  /// the other side's points may have been elsewhere.
  Inbox mapped(Role role, const Snapshot* start, const Snapshot& end, const Snapshot& amounts) {
    const Role giver = other(role);
    const auto& receiver = *now(role).points;
    std::vector<FieldSpec> intensities, shared, in_time;
    for (const auto& spec : broker_.contract(role).takes) {
      (spec.mapping == Mapping::conservative && &amounts != &end ? shared : intensities).push_back(spec);
      if (start && spec.in_time && spec.mapping == Mapping::consistent) in_time.push_back(spec);
    }
    Inbox inbox = mapping_->map(giver, *end.points, end.fields, intensities, receiver);
    if (!shared.empty()) {
      auto got = mapping_->map(giver, *amounts.points, amounts.fields, shared, receiver).fields;
      std::move(got.begin(), got.end(), std::back_inserter(inbox.fields));
    }
    if (!in_time.empty())
      inbox.at_start = mapping_->map(giver, *start->points, start->fields, in_time, receiver).fields;
    return inbox;
  }

  Snapshot receive_publication(Role role, double time, const std::shared_ptr<const PointSet>& previous) {
    return admitted(role, broker_.wait(role), time, previous);
  }

  Snapshot admitted(Role role, Message message, double time, const std::shared_ptr<const PointSet>& previous) {
    if (!message.points.sent) ++report_.points_unchanged;
    Snapshot snapshot = admit(std::move(message), broker_.contract(role), previous);
    // Both clocks must tell the same time, rounding apart.
    if (std::abs(snapshot.time - time) > 1e-9 * std::max(std::abs(time), 1e-3 * clock_.end()))
      throw PeerError(fmt::format("{} is at t = {} s after step {}, expected t = {} s", to_string(role), snapshot.time,
                                  step_ + 1, time));
    return snapshot;
  }

  void tell_progress(const std::string& waiting_for, bool) {
    if (progress_) progress_({clock_.time(), clock_.end(), step_, plan_.interval, waiting_for});
  }

  Broker& broker_;
  WindowClock clock_;
  std::unique_ptr<SpatialMapping> mapping_;
  std::function<void(const Progress&)> progress_;
  std::optional<IterationSettings> iteration_settings_;
  Snapshot fluid_, solid_;
  std::uint64_t step_ = 0;  ///< windows that stand
  std::uint32_t iteration_ = 0;
  WindowClock::Plan plan_;
  double fluid_limit_ = no_limit, solid_limit_ = no_limit;
  ScheduleReport report_;
};

Schedule::Schedule(Broker& broker, int dimension, WindowClock::Settings settings,
                   std::function<void(const Progress&)> progress, std::optional<IterationSettings> iteration)
    : implementation_(std::make_unique<Implementation>(broker, dimension, settings, std::move(progress), iteration)) {}
Schedule::~Schedule() = default;
void Schedule::run() { implementation_->run(); }
void Schedule::note_waiting(const std::string& whom) { implementation_->note_waiting(whom); }
ScheduleReport Schedule::report() const { return implementation_->report(); }

}  // namespace poretwin::coupling
