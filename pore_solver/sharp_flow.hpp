// Flow in soils without capillarity: saturated below a sharp front, dry above it.
#pragma once

#include "pore_solver/flow.hpp"

namespace poretwin::pore {

/// Each cell is a column of water at rest within itself. Its variable [m] is, where it is partly full, its height times
/// its volume of water over its full volume; where it is full, its height plus the head over its top. The variable and
/// the cell's shape determine the elevation h: the level of the water or, where the cell is full, the piezometric head.
/// With the mean m(h) of max(h - z, 0) over the common face, conductivity K and transmissibility T, the flow is
///
///   F_ab = K T [m(h_a) - m(h_b)]
///
/// Thus water passes only through the wet part of a face, and a front crosses a cell without a jump. At a face with
/// still water behind it the level of this water replaces h_b; above that level the face is a seepage face. Under a
/// face that looks upwards, water falls into a cell with air in it by its weight, too, through the depth of the point
/// below the face: else no more than the pressure's share would pass into soil that takes all of it. The
/// skeleton bears the mean of the pressure over the cell. Without gravity water has no level: all cells are full, and
/// their variable is the pressure head.
///
/// With h as the variable Newton's iteration would not converge in cells that are narrow at their bottom: the tangent
/// of the volume as a function of h leads far beyond the top there. In the variable above, the volume is linear.
class SharpFlow final : public FlowModel {
 public:
  SharpFlow(const Case& scene, const Network& network);
  void set(std::span<const double> variable) override;
  [[nodiscard]] Content saturation(Index a) const override;
  [[nodiscard]] Content borne_head(Index a) const override;
  [[nodiscard]] double pressure_head(Index a) const override { return level_[a].value - network_.elevation[a]; }
  [[nodiscard]] Flow through(const Link& link) const override;
  [[nodiscard]] Inflow below_level(const Segment& segment, double level) const override;
  [[nodiscard]] Inflow at_head(const Segment& segment, double pressure_head) const override;
  [[nodiscard]] double variable_at(Index a, double pressure_head) const override;
  [[nodiscard]] double full(Index a) const override { return weightless_ ? 0.0 : height(a); }
  [[nodiscard]] bool is_empty(Index a) const override { return !weightless_ && variable_[a] <= 0.0; }
  [[nodiscard]] double limited(Index a, double from, double to, char& stopped) const override;

 private:
  /// The elevation h and its derivative with respect to the variable.
  [[nodiscard]] Inflow level_at(Index a, double variable) const;
  [[nodiscard]] double height(Index a) const {
    return network_.filling(a).back().elevation - network_.filling(a).front().elevation;
  }
  [[nodiscard]] Inflow mean_depth(double h, double low, double high) const;
  /// The height [m] through which water from outside falls to the point of a cell with air in it, under a border that
  /// looks upwards, and its derivative by the variable. wet: fraction of the border with water outside. Where the
  /// cell's own water reaches up to the border, no water falls.
  [[nodiscard]] Inflow fall_into(const Segment& segment, double wet) const;
  /// Mean depth [m] of a point's water over elevations from `low` to `high`; slope: its derivative by the variable.
  [[nodiscard]] Inflow depth_in(Index a, double low, double high) const;

  const Network& network_;
  bool weightless_;
  ScalarArray variable_;       ///< m
  std::vector<Inflow> level_;  ///< m
};

}  // namespace poretwin::pore
