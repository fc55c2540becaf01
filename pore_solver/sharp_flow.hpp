// Flow in soils without capillarity: full below a sharp front, empty above it.
#pragma once

#include "pore_solver/flow.hpp"

namespace poretwin::pore {

/// Each cell is a column of water at rest within itself, its variable the elevation h up to which it stands, or the
/// piezometric head where the cell is full; how much it then holds follows from the cell's shape. With m(h) the mean of
/// max(h - z, 0) over the common face,
///
///   F_ab = K T [m(h_a) - m(h_b)]
///
/// so that water passes through the wet part of a face only, and a front crosses a cell without a jump. A face with
/// still water of level H behind it is the same with H for h_b; above H it is a seepage face. What the skeleton bears
/// of the pressure is its mean over the cell. Without gravity water has no level: all cells are full, and their
/// variable is the pressure head.
class SharpFlow final : public FlowModel {
 public:
  SharpFlow(const Case& scene, const Network& network);
  void set(std::span<const double> variable) override { level_.assign(variable.begin(), variable.end()); }
  [[nodiscard]] Content saturation(Index a) const override;
  [[nodiscard]] Content borne_head(Index a) const override;
  [[nodiscard]] double pressure_head(Index a) const override { return level_[a] - network_.elevation[a]; }
  [[nodiscard]] Flow through(const Link& link) const override;
  [[nodiscard]] Inflow below_level(const Segment& segment, double level) const override;
  [[nodiscard]] Inflow at_head(const Segment& segment, double pressure_head) const override;
  [[nodiscard]] double variable_at(Index a, double pressure_head) const override;
  [[nodiscard]] double full(Index a) const override { return network_.filling(a).back().elevation; }
  [[nodiscard]] double limited(Index a, double from, double to, char& stopped) const override;

 private:
  [[nodiscard]] Inflow mean_depth(double h, double low, double high) const;

  const Network& network_;
  bool weightless_;
  ScalarArray level_;  ///< m, of each point
};

}  // namespace poretwin::pore
