#include "pore_solver/capillary_flow.hpp"

#include "pore_solver/numerics/steps.hpp"

#include <algorithm>
#include <cmath>

namespace poretwin::pore {

namespace {

/// 1 / (1 - exp(-p)) - 1 / p: weight of the upstream point, which grows from 1/2 at p = 0 to 1.
double upstream_share(double p) { return p < 1e-3 ? 0.5 + p / 12.0 : 1.0 / -std::expm1(-p) - 1.0 / p; }

}  // namespace

CapillaryFlow::CapillaryFlow(const Case& scene, const Network& network)
    : FlowModel(rigid_pores(scene, network)),
      network_(network),
      at_(network.size()),
      variable_(network.size(), 0.0),
      per_variable_(network.size(), 0.0) {
  for (const auto& soil : scene.soils)
    grounds_.push_back({porous::residual_saturation(soil), porous::retention_of(soil)});
}

CapillaryFlow::Water CapillaryFlow::water(const Ground& ground, double head, double elevation) const {
  return {head, ground.retention->potential(head), ground.retention->permeability(head), elevation};
}

void CapillaryFlow::set(std::span<const double> variable) {
  for (std::size_t a = 0; a < network_.size(); ++a) {
    const auto point = static_cast<Index>(a);
    const auto head = ground(point).retention->head(variable[a]);
    variable_[a] = variable[a];
    per_variable_[a] = head.slope;
    at_[a] = water(ground(point), head.value, network_.elevation[a]);
  }
}

Content CapillaryFlow::effective_saturation(Index a) const {
  const Ground& g = ground(a);
  // Below the joint of the curve's two parts the variable is the effective saturation itself.
  if (variable_[a] < g.retention->joint()) return {variable_[a], 1.0};
  const auto s = g.retention->saturation(at_[a].head);
  return {s.value, s.slope * per_variable_[a]};
}

Content CapillaryFlow::saturation(Index a) const {
  const Content s = effective_saturation(a);
  const double residual = ground(a).residual;
  return {residual + (1.0 - residual) * s.value, (1.0 - residual) * s.slope};
}

Content CapillaryFlow::borne_head(Index a) const {
  const double head = at_[a].head;
  if (head >= 0.0) return {head, per_variable_[a]};
  const Content s = effective_saturation(a);
  return {s.value * head, s.slope * head + s.value * per_variable_[a]};
}

CapillaryFlow::Driven CapillaryFlow::down(const Water& upper, const Water& lower) {
  const double drop = upper.elevation - lower.elevation, more = upper.head - lower.head;
  const double k_upper = upper.permeability.value, k_lower = lower.permeability.value;
  if (more >= 0.0) {
    const double w = k_lower > 0.0 ? upstream_share(drop * lower.permeability.slope / k_lower) : 1.0;
    const double k = w * k_upper + (1.0 - w) * k_lower;
    return {upper.potential - lower.potential + k * drop, k_upper + w * upper.permeability.slope * drop,
            -k_lower + (1.0 - w) * lower.permeability.slope * drop, k};
  }
  // For heads this close, the curve between them is straight, and a quotient of differences would be a rounding error.
  constexpr double close = 1e-7;
  if (-more < close * (1e-3 + std::abs(upper.head))) {
    const double mean = 0.5 * (k_upper + k_lower);
    return {mean * (more + drop), mean + 0.5 * upper.permeability.slope * (more + drop),
            -mean + 0.5 * lower.permeability.slope * (more + drop), mean};
  }
  const double mean = std::clamp((upper.potential - lower.potential) / more, k_upper, std::max(k_upper, k_lower));
  return {mean * (more + drop), k_upper + drop * (k_upper - mean) / more, -k_lower + drop * (mean - k_lower) / more,
          mean};
}

Flow CapillaryFlow::between(const Water& a, const Water& b, double& mean) {
  const bool a_above = a.elevation >= b.elevation;
  const Driven d = a_above ? down(a, b) : down(b, a);
  mean = d.mean;
  return a_above ? Flow{d.value, d.by_upper, d.by_lower} : Flow{-d.value, -d.by_lower, -d.by_upper};
}

Flow CapillaryFlow::through(const Link& link) const {
  const Index a = link.a, b = link.b;
  Water beyond = at_[b];
  beyond.elevation += link.lift;
  Flow f;
  double mean = 0.0;
  if (network_.soil[a] == network_.soil[b]) {
    f = between(at_[a], beyond, mean);
    const double kt = conductivity(link) * link.transmissibility;
    f = {kt * f.value, kt * f.by_a, kt * f.by_b};
  } else {
    const Ground &ga = ground(a), &gb = ground(b);
    double other_mean = 0.0;
    const Flow by_a = between(at_[a], water(ga, beyond.head, beyond.elevation), mean);
    const Flow by_b = between(water(gb, at_[a].head, at_[a].elevation), beyond, other_mean);
    const double ka = link.of_a * conductivity(a) * link.transmissibility,
                 kb = link.of_b * conductivity(b) * link.transmissibility;
    // Both flows go towards the lower head. Where both vanish, their ratio is that of the conductivities.
    double first = ka * std::abs(by_a.value), second = kb * std::abs(by_b.value);
    if (!(first + second > 1e-12 * (ka * mean + kb * other_mean))) {
      first = ka * mean;
      second = kb * other_mean;
    }
    if (!(first + second > 0.0)) return {};
    const double share_a = second / (first + second), share_b = first / (first + second);
    f.value = ka * by_a.value * share_a + kb * by_b.value * share_b;
    f.by_a = 2.0 * (ka * by_a.by_a * share_a * share_a + kb * by_b.by_a * share_b * share_b);
    f.by_b = 2.0 * (ka * by_a.by_b * share_a * share_a + kb * by_b.by_b * share_b * share_b);
  }
  return {f.value, f.by_a * per_variable_[a], f.by_b * per_variable_[b]};
}

Inflow CapillaryFlow::from(const Segment& segment, double head, double elevation) const {
  const Index a = segment.point;
  const Ground& g = ground(a);
  double mean = 0.0;
  const Flow f = between(water(g, head, elevation), at_[a], mean);
  const double kt = conductance(segment);
  return {kt * f.value, kt * f.by_b * per_variable_[a]};
}

Inflow CapillaryFlow::at_head(const Segment& segment, double pressure_head) const {
  return from(segment, pressure_head, 0.5 * (segment.low + segment.high));
}

Inflow CapillaryFlow::below_level(const Segment& segment, double level) const {
  const double height = segment.high - segment.low;
  const double wet =
      height > 0.0 ? std::clamp((level - segment.low) / height, 0.0, 1.0) : (level > segment.low ? 1.0 : 0.0);
  Inflow in;
  if (wet > 0.0) {
    const double middle = segment.low + 0.5 * wet * height;
    const Inflow under = from(segment, level - middle, middle);
    in = {wet * under.value, wet * under.slope};
  }
  if (wet < 1.0) {
    const Inflow open = from(segment, 0.0, segment.high - 0.5 * (1.0 - wet) * height);
    if (open.value < 0.0) {
      in.value += (1.0 - wet) * open.value;
      in.slope += (1.0 - wet) * open.slope;
    }
  }
  return in;
}

double CapillaryFlow::variable_at(Index a, double pressure_head) const {
  return ground(a).retention->variable(pressure_head);
}

double CapillaryFlow::limited(Index a, double from, double to, char& stopped) const {
  // Below the joint, the other part of the curve begins, to which the tangent does not apply: the step ends there.
  const double joint = ground(a).retention->joint();
  if (!stopped && from > joint && to < joint) {
    stopped = 1;
    return joint;
  }
  return std::max(to, steps::least_share * from);
}

}  // namespace poretwin::pore
