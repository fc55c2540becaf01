// Flow in soils with retention curves.
#pragma once

#include "common/media/retention.hpp"
#include "pore_solver/flow.hpp"

#include <vector>

namespace poretwin::pore {

/// The flow between two points a and b at the elevations z_a and z_b, with the relative permeability k_r, its integral
/// Phi over the pressure head psi, the saturated conductivity K, and the transmissibility T (area over distance):
///
///   F_ab = K T [Phi_a - Phi_b + k_g (z_a - z_b)]
///
/// Where suction increases upwards, k_g is the mean of k_r over the heads between psi_a and psi_b, (Phi_a - Phi_b) /
/// (psi_a - psi_b). Water at rest under suction then stays at rest exactly.
///
/// Elsewhere k_g = w k_r(upper) + (1 - w) k_r(lower) with w = 1 / (1 - exp(-p)) - 1 / p and p = (z_a - z_b) k_r' / k_r
/// at the lower point, where k_r' is the slope of k_r over psi. This k_g is the mean of both k_r where k_r changes
/// little over the distance, and the upstream value where it changes much, so that wetting fronts do not oscillate.
/// With exponential curves (Gardner's) the steady flow is exact (Scharfetter & Gummel 1969). Where the two heads are
/// equal, so are the two forms of k_g.
///
/// Across the border of two soils, the law of each soil gives a flow for the two heads. The harmonic mean of both is
/// the flow through the two halves of the distance in series.
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
  [[nodiscard]] bool is_empty(Index) const override { return false; }
  [[nodiscard]] double limited(Index a, double from, double to, char& stopped) const override;

 private:
  struct Ground {
    double residual = 0.0;  ///< residual saturation
    std::unique_ptr<porous::Retention> retention;
  };
  /// Properties of water at a pressure head in one soil.
  struct Water {
    double head = 0.0, potential = 0.0;  ///< psi [m], Phi [m]
    porous::Rate permeability;
    double elevation = 0.0;  ///< m
  };
  /// A flow over K T and its derivatives with respect to the two pressure heads.
  struct Driven {
    double value = 0.0, by_upper = 0.0, by_lower = 0.0;
    double mean = 0.0;  ///< mean of k_r
  };
  [[nodiscard]] Water water(const Ground& ground, double head, double elevation) const;
  /// The flow from the upper to the lower of two points.
  [[nodiscard]] static Driven down(const Water& upper, const Water& lower);
  /// The flow from a to b by the law of one soil, with its derivatives with respect to the heads of both points. mean:
  /// mean of k_r.
  [[nodiscard]] static Flow between(const Water& a, const Water& b, double& mean);
  [[nodiscard]] Content effective_saturation(Index a) const;
  [[nodiscard]] const Ground& ground(Index a) const { return grounds_[network_.soil[a]]; }
  /// Inflow from a place outside of the segment with this pressure head and elevation [m].
  [[nodiscard]] Inflow from(const Segment& segment, double head, double elevation) const;

  const Network& network_;
  std::vector<Ground> grounds_;
  std::vector<Water> at_;                ///< at each point
  ScalarArray variable_, per_variable_;  ///< of each point: its variable u, and the derivative of psi with respect to u
};

}  // namespace poretwin::pore
