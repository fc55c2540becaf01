#include "pore_solver/sharp_flow.hpp"

#include "pore_solver/numerics/steps.hpp"

#include <algorithm>

namespace poretwin::pore {
namespace {

/// Mean of max(h - z, 0) over z from `low` to `high` [m], and its derivative with respect to h: the wet fraction.
Inflow depth_of(double h, double low, double high) {
  if (h >= high) return {h - 0.5 * (low + high), 1.0};
  if (h <= low) return {};
  const double wet = (h - low) / (high - low);
  return {0.5 * wet * (h - low), wet};
}

/// The two entries of a cell's filling between which the number `of` them reaches `value`, which is below the last one.
std::pair<const Filling&, const Filling&> around(std::span<const Filling> filling, double Filling::*of, double value) {
  std::size_t i = 1;
  while (value >= filling[i].*of) ++i;
  return {filling[i - 1], filling[i]};
}

}  // namespace

SharpFlow::SharpFlow(const Case& scene, const Network& network)
    : FlowModel(rigid_pores(scene, network)), network_(network), weightless_(scene.general.gravity.isZero()) {}

Inflow SharpFlow::mean_depth(double h, double low, double high) const {
  return weightless_ ? Inflow{h, 1.0} : depth_of(h, low, high);
}

Inflow SharpFlow::depth_in(Index a, double low, double high) const {
  const Inflow depth = mean_depth(level_[a].value, low, high);
  return {depth.value, depth.slope * level_[a].slope};
}

Inflow SharpFlow::level_at(Index a, double variable) const {
  if (weightless_) return {variable, 1.0};
  const auto filling = network_.filling(a);
  const double share = std::max(variable, 0.0) / height(a);
  if (share >= 1.0) return {filling.front().elevation + variable, 1.0};
  const auto [below, above] = around(filling, &Filling::share, share);
  const double per_share = (above.elevation - below.elevation) / (above.share - below.share);
  return {below.elevation + per_share * (share - below.share), per_share / height(a)};
}

void SharpFlow::set(std::span<const double> variable) {
  variable_.assign(variable.begin(), variable.end());
  level_.resize(variable_.size());
  for (std::size_t a = 0; a < variable_.size(); ++a) level_[a] = level_at(static_cast<Index>(a), variable_[a]);
}

Content SharpFlow::saturation(Index a) const {
  if (weightless_ || variable_[a] >= height(a)) return {1.0, 0.0};
  return {std::max(variable_[a], 0.0) / height(a), 1.0 / height(a)};
}

Content SharpFlow::borne_head(Index a) const {
  const auto filling = network_.filling(a);
  const Inflow depth = depth_in(a, filling.front().elevation, filling.back().elevation);
  return {depth.value, depth.slope};
}

Inflow SharpFlow::fall_into(const Segment& segment, double wet) const {
  const Index a = segment.point;
  const double depth = 0.5 * (segment.low + segment.high) - network_.elevation[a], air = height(a) - variable_[a];
  if (weightless_ || depth <= 0.0 || air <= 0.0) return {};
  // Water inside that reaches up to the border bears the water outside.
  const double range = segment.high - segment.low, over = level_[a].value - segment.low;
  const Inflow reached = over <= 0.0     ? Inflow{}
                         : over >= range ? Inflow{1.0, 0.0}
                                         : Inflow{over / range, level_[a].slope / range};
  const double dry = wet - reached.value, last = steps::last_air * height(a);
  if (dry <= 0.0) return {};
  const Inflow open = air < last ? Inflow{air / last, -1.0 / last} : Inflow{1.0, 0.0};
  return {depth * dry * open.value, depth * (dry * open.slope - reached.slope * open.value)};
}

Flow SharpFlow::through(const Link& link) const {
  const double kt = conductivity(link) * link.transmissibility;
  const Inflow a = depth_in(link.a, link.low, link.high),
               b = depth_in(link.b, link.low - link.lift, link.high - link.lift);
  return {kt * (a.value - b.value), kt * a.slope, -kt * b.slope};
}

Inflow SharpFlow::below_level(const Segment& segment, double level) const {
  const double kt = conductance(segment);
  const Inflow inside = depth_in(segment.point, segment.low, segment.high),
               outside = mean_depth(level, segment.low, segment.high), fall = fall_into(segment, outside.slope);
  return {kt * (outside.value - inside.value + fall.value), kt * (fall.slope - inside.slope)};
}

Inflow SharpFlow::at_head(const Segment& segment, double pressure_head) const {
  const double kt = conductance(segment);
  const Inflow inside = depth_in(segment.point, segment.low, segment.high),
               fall = fall_into(segment, pressure_head >= 0.0 ? 1.0 : 0.0);
  const double outside = weightless_ ? pressure_head : std::max(pressure_head, 0.0);
  return {kt * (outside - inside.value + fall.value), kt * (fall.slope - inside.slope)};
}

double SharpFlow::variable_at(Index a, double pressure_head) const {
  if (weightless_) return 0.0;
  const auto filling = network_.filling(a);
  const double h = pressure_head + network_.elevation[a];
  if (h <= filling.front().elevation) return 0.0;
  if (h >= filling.back().elevation) return h - filling.front().elevation;
  const auto [below, above] = around(filling, &Filling::elevation, h);
  const double part = (h - below.elevation) / (above.elevation - below.elevation);
  return (below.share + part * (above.share - below.share)) * height(a);
}

double SharpFlow::limited(Index a, double from, double to, char& stopped) const {
  if (weightless_) return to;
  const double full = height(a);
  if (!stopped && (from < full) != (to < full)) {
    stopped = 1;
    // A decrease stops just below the cell's top, where the cell can give water.
    constexpr double just = 1e-9;
    return from < full ? full : (1.0 - just) * full;
  }
  return std::max(to, 0.0);
}

}  // namespace poretwin::pore
