#include "common/coupling/window_clock.hpp"

#include "common/core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace poretwin::coupling {

namespace {
/// Times whose difference is below this fraction of the interval considered count as equal.
constexpr double same = 1e-9;
/// Windows shorter than this fraction of the run's length would be lost in the rounding of its time. (A consolidation
/// over years begins with windows of a millisecond, 1e-12 of the run.)
constexpr double collapsed = 1e-15;
/// In windows shorter than this fraction of the shortest characteristic time of the scene nothing real moves: water
/// fast enough to need them would cross thousands of spacings while it falls through one. An impact causes fewer than a
/// thousand such windows in a row.
constexpr double far_below = 1e-4;
constexpr std::uint64_t most_stuck = 1000;
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
        fmt::format("the exchange window collapsed to {:g} s at t = {:g} s, too short to advance", interval, time_));
  Plan plan;
  plan.start = time_;
  if (interval >= remaining * (1.0 - same)) {
    plan.end = target;
  } else {
    // Avoids very short windows: the last two windows before an output time divide the remaining time equally.
    plan.end = interval > 0.5 * remaining ? time_ + 0.5 * remaining : time_ + interval;
    at_output = false;
  }
  plan.interval = plan.end - plan.start;
  plan.record_frame = at_output;
  plan.record_gauges = plan.end >= settings_.end || !(settings_.gauge_interval > 0.0) ||
                       plan.end >= next_multiple(settings_.gauge_interval, gauges_) - same * settings_.gauge_interval;
  return plan;
}

void WindowClock::accept(const Plan& plan, const std::string& held_by) {
  time_ = plan.end;
  if (plan.record_frame) ++frames_;
  if (settings_.gauge_interval > 0.0)
    while (next_multiple(settings_.gauge_interval, gauges_) <= time_ + same * settings_.gauge_interval) ++gauges_;
  if (!(plan.interval < far_below * settings_.shortest_time)) {
    stuck_ = 0;
    held_by_.clear();
    return;
  }
  ++held_by_[held_by];
  if (++stuck_ < most_stuck) return;
  std::vector<std::pair<std::uint64_t, std::string>> held;
  for (const auto& [cause, windows] : held_by_) held.emplace_back(windows, cause);
  std::sort(held.rbegin(), held.rend());
  std::string causes;
  constexpr std::size_t most_named = 3;
  for (std::size_t i = 0; i < std::min(held.size(), most_named); ++i)
    causes += fmt::format("{}{} ({} windows)", causes.empty() ? "" : "; ", held[i].second, held[i].first);
  throw DivergedError(fmt::format(
      "the exchange windows are stuck: {} in a row up to t = {:g} s were shorter than {:.2g} s, a ten-thousandth of the "
      "shortest time in which this scene moves ({:.2g} s, {}), the last one {:.2g} s; the rest would take {:.2g} more. "
      "Limited by {}. Look at the last frame and gauges for water or soil that flies apart there; another "
      "particle_spacing, or less sudden faces and loads, may avoid it",
      most_stuck, time_, far_below * settings_.shortest_time, settings_.shortest_time, settings_.of_what, plan.interval,
      (settings_.end - time_) / plan.interval, causes));
}

}  // namespace poretwin::coupling
