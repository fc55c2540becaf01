#include "common/coupling/window_clock.hpp"

#include "common/core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace poretwin::coupling {

namespace {
/// Instants closer than this fraction of their spacing are one instant.
constexpr double same = 1e-9;
/// Windows shorter than this fraction of the run end in an error rather than in a run without end.
constexpr double collapsed = 1e-12;
}  // namespace

double WindowClock::next_multiple(double interval, std::uint64_t passed) const {
  if (!(interval > 0.0)) return std::numeric_limits<double>::infinity();
  return static_cast<double>(passed + 1) * interval;
}

WindowClock::Plan WindowClock::plan(double proposed) const {
  double target = next_multiple(settings_.output_interval, frames_);
  bool at_output = true;
  if (target > settings_.end - same * settings_.output_interval) target = settings_.end;
  const double remaining = target - time_;
  double interval = proposed;
  if (settings_.longest) interval = std::min(interval, *settings_.longest);
  if (!(interval > collapsed * settings_.end))
    throw Error(
        ExitCode::diverged,
        fmt::format("the exchange window collapsed to {:g} s at t = {:g} s: nobody can advance", interval, time_));
  Plan plan;
  plan.start = time_;
  if (interval >= remaining * (1.0 - same)) {
    plan.end = target;
  } else {
    // No slivers: the last two windows before an instant share what is left.
    plan.end = interval > 0.5 * remaining ? time_ + 0.5 * remaining : time_ + interval;
    at_output = false;
  }
  plan.interval = plan.end - plan.start;
  plan.record_frame = at_output;
  plan.record_gauges = plan.end >= settings_.end || !(settings_.gauge_interval > 0.0) ||
                       plan.end >= next_multiple(settings_.gauge_interval, gauges_) - same * settings_.gauge_interval;
  return plan;
}

void WindowClock::accept(const Plan& plan) {
  time_ = plan.end;
  if (plan.record_frame) ++frames_;
  if (settings_.gauge_interval > 0.0)
    while (next_multiple(settings_.gauge_interval, gauges_) <= time_ + same * settings_.gauge_interval) ++gauges_;
}

}  // namespace poretwin::coupling
