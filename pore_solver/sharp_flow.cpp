#include "pore_solver/sharp_flow.hpp"

#include <algorithm>

namespace poretwin::pore {
namespace {

/// Mean of max(h - z, 0) over z from `low` to `high` [m], and its derivative with respect to h, the wet fraction.
Inflow depth_of(double h, double low, double high) {
  if (h >= high) return {h - 0.5 * (low + high), 1.0};
  if (h <= low) return {};
  const double wet = (h - low) / (high - low);
  return {0.5 * wet * (h - low), wet};
}

}  // namespace

SharpFlow::SharpFlow(const Case& scene, const Network& network)
    : FlowModel(rigid_pores(scene, network)), network_(network), weightless_(scene.general.gravity.isZero()) {}

Inflow SharpFlow::mean_depth(double h, double low, double high) const {
  return weightless_ ? Inflow{h, 1.0} : depth_of(h, low, high);
}

Content SharpFlow::saturation(Index a) const {
  if (weightless_) return {1.0, 0.0};
  const double h = level_[a];
  const auto filling = network_.filling(a);
  if (h >= filling.back().elevation) return {1.0, 0.0};
  std::size_t i = 1;
  while (h >= filling[i].elevation) ++i;
  const Filling &below = filling[i - 1], &above = filling[i];
  const double slope = (above.share - below.share) / (above.elevation - below.elevation);
  return {below.share + slope * (h - below.elevation), slope};
}

Content SharpFlow::borne_head(Index a) const {
  const auto filling = network_.filling(a);
  const Inflow depth = mean_depth(level_[a], filling.front().elevation, filling.back().elevation);
  return {depth.value, depth.slope};
}

Flow SharpFlow::through(const Link& link) const {
  const double kt = conductivity(link) * link.transmissibility;
  const Inflow a = mean_depth(level_[link.a], link.low, link.high), b = mean_depth(level_[link.b], link.low, link.high);
  return {kt * (a.value - b.value), kt * a.slope, -kt * b.slope};
}

Inflow SharpFlow::below_level(const Segment& segment, double level) const {
  const double kt = conductance(segment);
  const Inflow inside = mean_depth(level_[segment.point], segment.low, segment.high);
  return {kt * (mean_depth(level, segment.low, segment.high).value - inside.value), -kt * inside.slope};
}

Inflow SharpFlow::at_head(const Segment& segment, double pressure_head) const {
  const double kt = conductance(segment);
  const Inflow inside = mean_depth(level_[segment.point], segment.low, segment.high);
  const double outside = weightless_ ? pressure_head : std::max(pressure_head, 0.0);
  return {kt * (outside - inside.value), -kt * inside.slope};
}

double SharpFlow::variable_at(Index a, double pressure_head) const {
  if (weightless_) return 0.0;
  return std::max(pressure_head + network_.elevation[a], network_.filling(a).front().elevation);
}

double SharpFlow::limited(Index a, double from, double to, char& stopped) const {
  if (weightless_) return to;
  const double low = network_.filling(a).front().elevation, high = network_.filling(a).back().elevation;
  if (!stopped && (from < high) != (to < high)) {
    stopped = 1;
    // From above it stops just below the cell's top: there the cell can give water.
    constexpr double just = 1e-9;
    return from < high ? high : high - just * (high - low);
  }
  return std::max(to, low);
}

}  // namespace poretwin::pore
