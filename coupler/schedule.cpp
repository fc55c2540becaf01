#include "coupler/schedule.hpp"

#include "common/coupling/drive.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace poretwin::coupling {
namespace {

using Clock = std::chrono::steady_clock;

Role other(Role role) { return role == Role::fluid ? Role::solid : Role::fluid; }

}  // namespace

class Schedule::Implementation {
 public:
  Implementation(Broker& broker, int dimension, WindowClock::Settings settings,
                 std::function<void(const Progress&)> progress)
      : broker_(broker), clock_(settings), mapping_(make_mapping(dimension)), progress_(std::move(progress)) {}

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
      send_mapped(role, std::move(message));
      now(role) = receive_publication(role, 0.0, now(role).points);
    }
  }

  void window() {
    const auto accounts = mapping_->accounts();
    double limit = std::min(fluid_.proposed_interval, solid_.proposed_interval);
    const std::string& cause =
        fluid_.proposed_interval <= solid_.proposed_interval ? fluid_.limited_by : solid_.limited_by;
    for (int attempt = 0;; ++attempt) {
      const auto plan = clock_.plan(limit);
      plan_ = plan;
      iteration_ = static_cast<std::uint32_t>(attempt);
      if (const auto rejection = try_window(plan)) {
        mapping_->set_accounts(accounts);
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
  std::optional<Reject> try_window(const WindowClock::Plan& plan) {
    fluid_limit_ = fluid_.proposed_interval;
    solid_limit_ = solid_.proposed_interval;
    Snapshot fluid_before = fluid_;
    if (auto rejection = advance(Role::fluid, plan)) {
      ++report_.rejected_by_fluid;
      restore(Role::fluid, rejection->reason);
      return rejection;
    }
    if (auto rejection = advance(Role::solid, plan)) {
      ++report_.rejected_by_solid;
      restore(Role::solid, rejection->reason);
      restore(Role::fluid, rejection->reason);
      fluid_ = std::move(fluid_before);
      return rejection;
    }
    return std::nullopt;
  }

  std::optional<Reject> advance(Role role, const WindowClock::Plan& plan) {
    Message message;
    message.step = step_ + 1;
    message.iteration = iteration_;
    message.time = plan.start;
    message.interval = plan.interval;
    message.body = Advance{plan.record_frame, plan.record_gauges};
    send_mapped(role, std::move(message));
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

  void send_mapped(Role role, Message message) {
    const auto start = Clock::now();
    const auto& giver = now(other(role));
    const auto& receiver = *now(role).points;
    const auto& specs = broker_.contract(role).takes;
    Inbox inbox = mapping_->map(other(role), *giver.points, giver.fields, specs, receiver);
    report_.fields_skipped += giver.fields.size() - inbox.fields.size();
    report_.mapping += std::chrono::duration<double>(Clock::now() - start).count();
    message.points = {receiver.dimension, receiver.revision, receiver.n_active, receiver.n_active, false};
    message.arrays.push_back({std::string(coverage_array), "1", 1, std::move(inbox.coverage)});
    message.arrays.push_back({std::string(asymmetry_array), "1", 1, std::move(inbox.asymmetry)});
    for (auto& field : inbox.fields) {
      const auto spec =
          std::find_if(specs.begin(), specs.end(), [&](const FieldSpec& s) { return s.name == field.name; });
      message.arrays.push_back({field.name, spec->unit, field.components, std::move(field.values)});
    }
    broker_.send(role, std::move(message));
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
  Snapshot fluid_, solid_;
  std::uint64_t step_ = 0;  ///< windows that stand
  std::uint32_t iteration_ = 0;
  WindowClock::Plan plan_;
  double fluid_limit_ = no_limit, solid_limit_ = no_limit;
  ScheduleReport report_;
};

Schedule::Schedule(Broker& broker, int dimension, WindowClock::Settings settings,
                   std::function<void(const Progress&)> progress)
    : implementation_(std::make_unique<Implementation>(broker, dimension, settings, std::move(progress))) {}
Schedule::~Schedule() = default;
void Schedule::run() { implementation_->run(); }
void Schedule::note_waiting(const std::string& whom) { implementation_->note_waiting(whom); }
ScheduleReport Schedule::report() const { return implementation_->report(); }

}  // namespace poretwin::coupling
