#include "joint_solver/joint_water.hpp"

#include "common/case/parts.hpp"
#include "common/core/error.hpp"
#include "joint_solver/numerics/cycle.hpp"
#include "joint_solver/output/joined_frame.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace poretwin::joint {

// Windows of free water are short, and their state is not saved: the ground's step in one is finished, too.
JointWater::JointWater(const Case& scene)
    : scene_(scene),
      free_(free_part(scene)),
      ground_(ground_part(scene), [] { return false; }),
      openings_(ground_.openings()) {
  std::vector<fluid::BedPart<2>> bed;
  for (const auto& opening : openings_) {
    auto& part = bed.emplace_back();
    part.centre = opening.centre.head<2>();
    part.normal = opening.outwards.head<2>();
  }
  free_.lay_bed(std::move(bed));
}

coupling::Contract JointWater::contract() const { return {scene_.general.dimension, scene_.digest(), {}, {}}; }

coupling::Publication JointWater::publish() const {
  coupling::Publication out;
  out.time = free_.state().time;
  out.points.dimension = scene_.general.dimension;
  std::tie(out.proposed_interval, out.limited_by) = proposal();
  return out;
}

std::pair<double, std::string> JointWater::proposal() const {
  const auto free = free_.proposal();
  // While there is free water its windows are much shorter than the ground's steps.
  if (std::isfinite(free.first)) return free;
  return {state_.next - state_.since, "the ground's step"};
}

void JointWater::initialise(const coupling::Inbox& inbox) {
  free_.initialise(inbox);
  ground_.initialise(inbox);
  state_.initial = stored();
}

coupling::Outcome JointWater::advance(const coupling::Window& window, const coupling::Inbox& inbox) {
  const auto outcome = free_.advance(window, inbox);
  if (!outcome.accepted) return outcome;
  state_.since += window.interval;
  const double end = window.time + window.interval, following = std::min(free_.proposal().first, state_.next);
  if (state_.since + 0.5 * following >= state_.next || is_instant_of_output(end)) step_ground(end);
  return outcome;
}

bool JointWater::is_instant_of_output(double time) const {
  const auto is_multiple = [time](double interval) {
    return interval > 0.0 && std::abs(time / interval - std::round(time / interval)) * interval <= 1e-9 * time;
  };
  return is_multiple(scene_.output.interval) || is_multiple(scene_.output.gauge_interval) ||
         time >= scene_.general.end_time * (1.0 - 1e-9);
}

void JointWater::step_ground(double time) {
  const auto water = free_.water_before_bed();
  std::vector<pore::PoreWater::Standing> standing(openings_.size());
  ScalarArray film(openings_.size());
  for (std::size_t i = 0; i < openings_.size(); ++i) {
    film[i] = free_.state().bed[i].film;
    standing[i] = {water[i].head, std::max(0.0, film[i] + water[i].volume)};
  }
  ground_.set_standing(standing);
  double limit = HUGE_VAL;
  for (double left = time - ground_.state().time; left > 0.0; left = time - ground_.state().time) {
    const double interval = std::min({left, limit, ground_.proposal().first});
    const coupling::Window window{0, ground_.state().time, interval};
    if (const auto outcome = ground_.advance(window, {}); outcome.accepted) {
      limit = HUGE_VAL;
    } else {
      limit = outcome.suggested_interval;
      if (!(limit > 1e-12 * state_.since))
        throw DivergedError(fmt::format("water in the soil: no solution at t = {:g} s, in steps down to {:g} s",
                                        ground_.state().time, limit));
    }
    // The rest of a sum of intervals is rounding.
    if (time - ground_.state().time <= 1e-12 * time) break;
  }
  double fastest = 0.0;  // m/s
  const auto remains = ground_.left_standing();
  for (std::size_t i = 0; i < openings_.size(); ++i) {
    const double soaked = standing[i].volume - remains[i];
    film[i] -= soaked;
    fastest = std::max(fastest, std::abs(soaked) / (state_.since * openings_[i].area));
  }
  const double window = free_.proposal().first, depth = cycle::depth * scene_.fluid.particle_spacing;
  state_.next = std::max(
      std::min({cycle::windows * window, ground_.proposal().first, fastest > 0.0 ? depth / fastest : HUGE_VAL}),
      std::isfinite(window) ? window : 0.0);
  state_.since = 0.0;
  free_.turn_over(film, state_.next);
}

double JointWater::film() const {
  double sum = 0.0;
  for (const auto& part : free_.state().bed) sum += part.film;
  return sum;
}

OutputFrame JointWater::frame() const { return joined(free_.frame(), ground_.frame()); }

void JointWater::read_both(const Gauge& gauge, std::vector<GaugeReading>& readings) const {
  if (gauge.kind == "infiltration") readings.push_back({gauge.name, ground_.through_openings(), "m2"});
  if (gauge.kind != "balance") return;
  const auto faces = ground_.through_faces();
  readings.push_back({gauge.name + "_in", faces.in, "m2"});
  readings.push_back({gauge.name + "_out", faces.out, "m2"});
  readings.push_back({gauge.name + "_stored", stored(), "m2"});
  readings.push_back({gauge.name + "_film", film(), "m2"});
  readings.push_back({gauge.name + "_error", faces.in - faces.out - (stored() - state_.initial), "m2"});
}

std::vector<GaugeReading> JointWater::gauges() const {
  const auto free = free_.gauges(), ground = ground_.gauges();
  std::vector<GaugeReading> readings = free;
  for (const auto& reading : ground) {
    // Both parts read volumes; no other reading has the same name in both.
    const auto same = std::find_if(readings.begin(), readings.end(),
                                   [&](const GaugeReading& other) { return other.gauge == reading.gauge; });
    if (same == readings.end())
      readings.push_back(reading);
    else
      same->value += reading.value;
  }
  for (const auto& gauge : scene_.gauges) {
    if (gauge.kind == "volume" && !gauge.region)
      for (auto& reading : readings)
        if (reading.gauge == gauge.name) reading.value += film();
    read_both(gauge, readings);
  }
  return readings;
}

std::map<std::string, double> JointWater::counters() const {
  auto counters = free_.counters();
  for (const auto& [name, value] : ground_.counters()) counters["soil: " + name] = value;
  return counters;
}

std::unique_ptr<Phase> make_joint_water(const Case& scene) { return std::make_unique<JointWater>(scene); }

}  // namespace poretwin::joint
