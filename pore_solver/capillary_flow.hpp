// Flow in soils with retention curves.
#pragma once

#include "common/media/retention.hpp"
#include "pore_solver/flow.hpp"

#include <vector>

namespace poretwin::pore {

/// With Phi = int k_r dpsi, K the saturated conductivity and T area over distance,
///
///   F_ab = K T [Phi_a - Phi_b + k_g (z_a - z_b)]
///
/// Where suction grows upwards k_g is the mean of k_r over the heads between the two, (Phi_a - Phi_b) / (psi_a -
/// psi_b), so that water at rest under suction stays at rest exactly. Where it does not, k_g = w k_r(upper) + (1 - w)
/// k_r(lower) with w = 1 / (1 - exp(-p)) - 1 / p and p = (z_a - z_b) k_r' / k_r at the lower: the mean where the
/// permeability changes little over the distance, upstream where it changes much, so that wetting fronts do not
/// oscillate; of exponential curves (Gardner's) the steady flow is exact (Scharfetter & Gummel 1969). The two forms
/// agree where the heads do. Across the border of two soils both laws give a flow for the two heads; their harmonic
/// mean is that of the two halves of the way in series.
class CapillaryFlow final : public FlowModel {
 public:
  CapillaryFlow(const Case& scene, const Network& network);
  void set(std::span<const double> variable) override;
  [[nodiscard]] Content saturation(Index a) const override;
  [[nodiscard]] Content borne_head(Index a) const override;
  [[nodiscard]] double pressure_head(Index a) const override { return at_[a].head; }
  [[nodiscard]] Flow through(const Link& link) const override;
  [[nodiscard]] Inflow below_level(const Segment& segment, double level) const override;
  [[nodiscard]] Inflow at_head(const Segment& segment, double pressure_head) const override;
  [[nodiscard]] double variable_at(Index a, double pressure_head) const override;
  [[nodiscard]] double full(Index a) const override { return variable_at(a, 0.0); }
  [[nodiscard]] double limited(Index a, double from, double to, char& stopped) const override;

 private:
  struct Ground {
    double residual = 0.0;  ///< saturation
    std::unique_ptr<porous::Retention> retention;
  };
  /// Water at a pressure head, by one soil's law.
  struct Water {
    double head = 0.0, potential = 0.0;  ///< psi, Phi, m
    porous::Rate permeability;
    double elevation = 0.0;  ///< m
  };
  /// A flow and its derivatives by the two pressure heads; both over K T.
  struct Driven {
    double value = 0.0, by_upper = 0.0, by_lower = 0.0;
    double mean = 0.0;  ///< of k_r
  };
  [[nodiscard]] Water water(const Ground& ground, double head, double elevation) const;
  /// Down from the upper to the lower of two places.
  [[nodiscard]] static Driven down(const Water& upper, const Water& lower);
  /// From a to b, derivatives by their pressure heads, by one soil's law.
  [[nodiscard]] static Flow between(const Water& a, const Water& b, double& mean);
  [[nodiscard]] Content effective_saturation(Index a) const;
  [[nodiscard]] const Ground& ground(Index a) const { return grounds_[network_.soil[a]]; }
  /// In from a place outside of the segment where water has a head.
  [[nodiscard]] Inflow from(const Segment& segment, double head, double elevation) const;

  const Network& network_;
  std::vector<Ground> grounds_;
  std::vector<Water> at_;                ///< of each point
  ScalarArray variable_, per_variable_;  ///< u, dpsi/du
};

}  // namespace poretwin::pore
