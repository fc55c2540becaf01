#include "pore_solver/pore_phase.hpp"

#include "common/core/error.hpp"
#include "common/coupling/standard_contract.hpp"
#include "common/media/seepage.hpp"

namespace poretwin::pore {

PoreWater::PoreWater(const Case& scene)
    : scene_(scene),
      network_(make_network(scene_)),
      stepper_(scene_, network_),
      gauges_(scene_, network_),
      state_(stepper_.first_state(scene_)) {}

coupling::Contract PoreWater::contract() const { return {scene_.general.dimension, scene_.digest(), {}, {}}; }

coupling::Publication PoreWater::publish() const {
  coupling::Publication out;
  out.time = state_.time;
  out.points.dimension = scene_.general.dimension;
  std::tie(out.proposed_interval, out.limited_by) = proposal();
  return out;
}

std::pair<double, std::string> PoreWater::proposal() const {
  return {stepper_.proposal(state_), "the error of a step"};
}

coupling::Outcome PoreWater::advance(const coupling::Window& window, const coupling::Inbox&) {
  const auto outcome = stepper_.step(window.interval, state_);
  if (outcome.accepted) state_.time = window.time + window.interval;
  return outcome;
}

void PoreWater::compute_flux() const {
  flux_.assign(network_.size(), Point3::Zero());
  const auto add = [&](Index a, const Point3& from_point, double out) {
    flux_[a] += out / network_.volume[a] * (from_point - network_.position[a]);
  };
  for (std::size_t i = 0; i < network_.links.size(); ++i) {
    const Link& link = network_.links[i];
    add(link.a, link.centre, state_.flow[i]);
    add(link.b, link.centre, -state_.flow[i]);
  }
  for (std::size_t i = 0; i < network_.segments.size(); ++i)
    add(network_.segments[i].point, network_.segments[i].centre, -state_.inflow[i]);
}

OutputFrame PoreWater::frame() const {
  const FlowModel& flow = stepper_.flow(state_);
  head_.resize(network_.size());
  for (std::size_t a = 0; a < network_.size(); ++a) head_[a] = flow.pressure_head(static_cast<Index>(a));
  compute_flux();
  OutputFrame out;
  out.time = state_.time;
  out.count = network_.size();
  out.position = tell_vectors<3>(network_.position);
  const double weight = porous::specific_weight(scene_);
  out.fields = {{{"pressure_head", "m", "pressure over the water's specific weight; below zero under suction", 1},
                 tell_scalars([this](std::size_t a) { return head_[a]; })},
                {{"pore_pressure", "Pa", "pressure of the water; below zero under suction", 1},
                 tell_scalars([this, weight](std::size_t a) { return weight * head_[a]; })},
                {{"degree_of_saturation", "1", "water's share of the pores", 1}, tell_scalars([this](std::size_t a) {
                   return saturation(scene_, network_, state_, static_cast<Index>(a));
                 })},
                {{"water_content", "1", "volume of water per volume of soil", 1},
                 tell_scalars([this](std::size_t a) { return state_.water[a] / network_.volume[a]; })},
                {{"relative_flux", "m/s", "discharge through the skeleton, per area", 3}, tell_vectors<3>(flux_)},
                {{"volume", "m2", "of the soil that the point stands for", 1},
                 tell_scalars([this](std::size_t a) { return network_.volume[a]; })}};
  return out;
}

std::vector<GaugeReading> PoreWater::gauges() const { return gauges_.read(stepper_.flow(state_), stepper_, state_); }

std::map<std::string, double> PoreWater::counters() const {
  const Counts& c = state_.counts;
  return {{"points", static_cast<double>(network_.size())},
          {"Newton iterations", c.iterations},
          {"linear iterations", c.linear_iterations}};
}

std::unique_ptr<Phase> make_pore_water(const Case& scene) { return std::make_unique<PoreWater>(scene); }

}  // namespace poretwin::pore
