#include "pore_solver/sharp_flow.hpp"

#include "common/media/seepage.hpp"

#include <algorithm>

namespace poretwin::pore {
namespace {

/// Mean of max(h - z, 0) over z from `low` to `high` [m], and its derivative: the wet share.
Inflow mean_depth(double h, double low, double high) {
  if (h >= high) return {h - 0.5 * (low + high), 1.0};
  if (h <= low) return {};
  const double wet = (h - low) / (high - low);
  return {0.5 * wet * (h - low), wet};
}

}  // namespace

SharpFlow::SharpFlow(const Case& scene, const Network& network) : network_(network) {
  for (const auto& soil : scene.soils) {
    conductivity_.push_back(porous::seepage_at(scene, soil, soil.porosity).conductivity);
    porosity_.push_back(soil.porosity);
  }
}

Content SharpFlow::content(Index a) const {
  const double pores = network_.volume[a] * porosity_[network_.soil[a]], h = level_[a];
  const auto filling = network_.filling(a);
  if (h >= filling.back().elevation) return {pores, 0.0};
  std::size_t i = 1;
  while (h >= filling[i].elevation) ++i;
  const Filling &below = filling[i - 1], &above = filling[i];
  const double slope = (above.share - below.share) / (above.elevation - below.elevation);
  return {pores * (below.share + slope * (h - below.elevation)), pores * slope};
}

Flow SharpFlow::through(const Link& link) const {
  const double ka = conductivity(link.a), kb = conductivity(link.b);
  const double kt = 2.0 * ka * kb / (ka + kb) * link.transmissibility;
  const Inflow a = mean_depth(level_[link.a], link.low, link.high), b = mean_depth(level_[link.b], link.low, link.high);
  return {kt * (a.value - b.value), kt * a.slope, -kt * b.slope};
}

Inflow SharpFlow::below_level(const Segment& segment, double level) const {
  const double kt = conductivity(segment.point) * segment.transmissibility;
  const Inflow inside = mean_depth(level_[segment.point], segment.low, segment.high);
  return {kt * (mean_depth(level, segment.low, segment.high).value - inside.value), -kt * inside.slope};
}

Inflow SharpFlow::at_head(const Segment& segment, double pressure_head) const {
  const double kt = conductivity(segment.point) * segment.transmissibility;
  const Inflow inside = mean_depth(level_[segment.point], segment.low, segment.high);
  return {kt * (std::max(pressure_head, 0.0) - inside.value), -kt * inside.slope};
}

double SharpFlow::variable_at(Index a, double pressure_head) const {
  return std::max(pressure_head + network_.elevation[a], network_.filling(a).front().elevation);
}

double SharpFlow::limited(Index a, double from, double to, char& stopped) const {
  const double low = network_.filling(a).front().elevation, high = network_.filling(a).back().elevation;
  if (!stopped && (from < high) != (to < high)) {
    stopped = 1;
    // Coming from above, just below: there the cell holds water that it can give.
    constexpr double just = 1e-9;
    return from < high ? high : high - just * (high - low);
  }
  return std::max(to, low);
}

}  // namespace poretwin::pore
