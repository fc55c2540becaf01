// The soil at the fluid's particles, as arrays of length n. They are mapped from the solid or, for rigid soil, taken
// from the case.
#pragma once

#include "common/core/or_zero.hpp"
#include "common/core/threads.hpp"
#include "common/core/vector.hpp"
#include "common/coupling/exchange.hpp"
#include "common/media/seepage.hpp"
#include "fluid_solver/exchange/ground.hpp"
#include "fluid_solver/numerics/exchange.hpp"
#include "fluid_solver/setup.hpp"

#include <cmath>
#include <span>

namespace poretwin::fluid {

template <int D>
struct SoilView {
  ScalarArray mask;         ///< [n] 1 inside soil, 0 in free water
  std::vector<int> number;  ///< [n] index of the soil in the case; -1: in no soil; empty where no soil is at rest
  OrZero<double> outside;   ///< [n] m, distance outside the edge of soil that moves, negative inside; of points within
                            ///< reach of the soil
  OrZero<double> coverage;  ///< [n] coverage by the points of soil that moves: 1 inside, 0 out of their reach
  std::vector<char> loose;  ///< [n] 1: grains apart from each other, which form no body with an edge; empty: none
  ScalarArray fraction;     ///< [n] solid fraction n_s, which includes the residual water of moist soil
  std::vector<porous::Resistance> resistance;  ///< [n] zero in free water; empty where `drag` is the whole law
  /// [n] Tangent of the drag at the present relative velocity, along the direction of flow: R = C w' - f with C [N
  /// s/m4] (drag) and f [N/m3] (drag_offset). f is zero for Darcy's law.
  ScalarArray drag;
  OrZero<Vec<D>> drag_offset;
  MatArray<D> drag_form;               ///< [n] factor on the relative velocity in a smoothed drag; empty: no factor
  OrZero<double> density;              ///< [n] R = n_s rho_s of soil that moves, kg/m3
  OrZero<double> modulus;              ///< [n] M = K + 4 G / 3, Pa
  OrZero<double> plastic_shear_ratio;  ///< [n] plastic over total shear strain in the soil's last window
  OrZero<Vec<D>> velocity;             ///< [n] v_s, m/s
  OrZero<Vec<D>> mean_velocity;        ///< [n] mean of v_s over the soil's last window, m/s
  OrZero<double> strain_rate;  ///< [n] volumetric strain rate over the soil's last window, as its stress law integrates
                               ///< it, 1/s
  OrZero<Vec<D>> force;        ///< [n] r: unbalanced force; includes the soil's weight, not pressure and drag, N/m3
  /// In a repeated window: the mean velocity of the soil that the last pass found [m/s], and the unbalanced force that
  /// remained in it, without pressure and drag [N/m3].
  OrZero<Vec<D>> found_velocity, found_force;
  /// [n] Impulse that the soil absorbed in its last window beyond the impulse of the drag, N s. Momentum balance
  /// requires the water to supply this excess.
  OrZero<Vec<D>> returned_impulse;
  void resize(std::size_t n) {
    for (auto* a : {&mask, &fraction, &drag}) a->assign(n, 0.0);
    resistance.assign(n, {});
  }
  [[nodiscard]] std::size_t size() const { return mask.size(); }
  /// Whether the tangent differs from the law of drag.
  [[nodiscard]] bool nonlinear() const {
    return !drag_form.empty() ||
           std::any_of(resistance.begin(), resistance.end(), [](const auto& r) { return r.quadratic > 0.0; });
  }
  /// Sets the tangent for the relative velocity of water and soil.
  void linearise(std::span<const Vec<D>> water, const OrZero<Vec<D>>& soil) {
    if (resistance.empty()) return;  // the tangent is the law
    const bool curved = nonlinear();
    drag_offset.allocate(curved ? size() : 0);
    parallel_for(size(), [&](std::size_t a) {
      const Vec<D> slip = water[a] - soil[a];
      drag[a] = resistance[a].slope(slip.norm());
      if (!curved) return;
      if (!drag_form.empty()) drag[a] *= drag_form[a].trace() / D;
      drag_offset.set(a, drag[a] * slip - drag_force(a, slip));
    });
    forget_law();
  }
  /// Frees the law of drag where the tangent is the whole law.
  void forget_law() {
    if (!nonlinear()) resistance = std::vector<porous::Resistance>();
  }
  /// Force on the water against the relative velocity `slip`, per volume [N/m3].
  [[nodiscard]] Vec<D> drag_force(std::size_t a, const Vec<D>& slip) const {
    const double C = resistance.empty() ? drag[a] : resistance[a].coefficient(slip.norm());
    return drag_form.empty() ? Vec<D>(C * slip) : Vec<D>(C * drag_form[a] * slip);
  }
};

/// Whether inertia dominates in soil, as in free water: drag then needs longer than 0.1 sqrt(spacing/g) to stop water.
/// At a spacing of 2 cm that is 4.5 ms, or a drag rate C / (n rho_w) of 220 1/s: rockfill has about 20 1/s, sand (k =
/// 1e-3 m/s, n = 0.4) 3900 1/s. The time is a third of the longest window for a free surface.
inline bool inertia_rules(double n, double density, double drag, double spacing, double gravity) {
  return gravity > 0.0 && drag * exchange::held_within * std::sqrt(spacing / gravity) < n * density;
}

/// The quantities that decide whether water seeps through soil or moves along with it.
struct SeepageRegime {
  double density = 0.0;      ///< kg/m3, of water
  double speed = 0.0;        ///< m/s, soil below this speed counts as at rest
  bool long_window = false;  ///< the window is longer than free water's surface waves allow
  /// Whether soil with this plastic shear ratio and speed [m/s] counts as moving. In long windows its motion is
  /// quasi-static, from equilibrium to equilibrium, and water seeps in and out.
  [[nodiscard]] bool soil_moves(double plastic_shear_ratio, double soil_speed) const {
    return (plastic_shear_ratio > 0.5 || soil_speed > speed) && !long_window;
  }
};

/// Whether particle a is in the seepage regime: its water moves through the soil, and its surface is a wetting front.
///
/// There are two exceptions. Where drag needs more than a spacing to stop the water, C spacing < n rho |w| (drag
/// coefficient C, porosity n, water density rho, relative velocity w), the water flows as free water does. Where the
/// soil moves, its water moves along and has a free surface (not in long windows, in which the motion is quasi-static).
/// At a wetting front the pressure is a natural boundary condition and does not enter the gradient. This is right for a
/// front whose speed follows from the pressure. It would further accelerate a mixture with inertia that moves inwards
/// (a surface wave over liquefied soil grew sevenfold in 2 ms).
template <int D>
bool in_seepage_regime(const SoilView<D>& soil, std::size_t a, const Vec<D>& velocity, double spacing,
                       const SeepageRegime& regime) {
  const double relative = (velocity - soil.velocity[a]).norm();
  const bool moves = regime.soil_moves(soil.plastic_shear_ratio[a], soil.velocity[a].norm());
  return soil.mask[a] > 0.5 && !moves && soil.drag[a] * spacing >= (1.0 - soil.fraction[a]) * regime.density * relative;
}

/// Soil membership from the asymmetry of the soil's points around a place, before it is bounded to [0, 1]: a ramp
/// around 0.47, the value on a flat edge. The membership is 1 for an asymmetry of 0.31 and less, so that disorder
/// inside the soil (0.3 at most, for particles anywhere in their cells) does not change the porosity.
inline double membership_ramp(double asymmetry) {
  return (exchange::outside_asymmetry - asymmetry) / exchange::ramp_width;
}
/// Distance outside a flat edge of the soil [m] of a place with this asymmetry. spacing: m, of the soil's points. The
/// asymmetry at d spacings is 0.482 + 0.64 d + 0.14 d^2, from sums over lattices in 2D and 3D.
inline double distance_outside(double asymmetry, double spacing) {
  constexpr auto c = exchange::asymmetry_outside;
  return (std::sqrt(std::max(0.0, c[1] * c[1] - 4.0 * c[2] * (c[0] - asymmetry))) - c[1]) / (2.0 * c[2]) * spacing;
}
inline double membership(double asymmetry) { return std::clamp(membership_ramp(asymmetry), 0.0, 1.0); }

/// Soil membership, with hysteresis, of water in or beside tight soil that moves; `before` is its previous value. Such
/// soil carries its pore water along, and water that flows past the soil's edge stays outside. The points of an edge
/// form a staircase, so that the asymmetry oscillates as water passes. Hence a membership between 0 and 1 reverses only
/// after the asymmetry has gone back by half of the ramp's width (backlash).
inline double membership(double asymmetry, double before) {
  const double ramp = membership_ramp(asymmetry);
  return std::clamp(before, std::clamp(2.0 * ramp - 1.0, 0.0, 1.0), std::clamp(2.0 * ramp, 0.0, 1.0));
}

/// Part, 0 to 1, in which the soil's points around a place form a body, which has an inside and an edge. In the rest,
/// they are grains apart from each other: no place is inside, and only the coverage says how much soil there is. Soil
/// that does not yield is a body. Soil that yields is one where it covers a place as densely as a body does at the same
/// asymmetry, by points that spread in space: one grain that has grown, or lies on its image in a wall, is no body.
inline double body_share(double coverage, double asymmetry, double spread, double yielding) {
  const auto ramp = [](double value, const std::array<double, 2>& ends) {
    return std::clamp((value - ends[0]) / (ends[1] - ends[0]), 0.0, 1.0);
  };
  const double of_body = 1.0 - exchange::coverage_slope * asymmetry;
  const double dense = of_body > 0.0 ? ramp(coverage / of_body, exchange::body_density) : 1.0;
  // Farther outside only the nearest points are within the kernel's reach, so that corners of a body spread little,
  // too.
  const bool near = asymmetry < exchange::outside_asymmetry;
  return 1.0 - yielding * (1.0 - (near ? std::min(dense, ramp(spread, exchange::body_spread)) : dense));
}

/// Part of a place that loose grains fill. It ends 1.2 spacings from them: water that splashes past the edge of soil
/// would otherwise take up and lose a few hundredths of grains within a window.
inline double loose_share(double coverage, double asymmetry) {
  const double inner = exchange::outside_asymmetry, outer = exchange::loose_asymmetry;
  return std::min(coverage, 1.0) * std::clamp((outer - asymmetry) / (outer - inner), 0.0, 1.0);
}

/// Soil as the case draws it, at rest and without yielding. drag: whether the soil resists the water.
template <int D>
SoilView<D> rigid_soil(const Ground<D>& ground, std::span<const Vec<D>> points, bool drag) {
  SoilView<D> soil;
  soil.resize(points.size());
  if (!ground.strata().empty()) soil.number.assign(points.size(), -1);
  parallel_for(points.size(), [&](std::size_t a) {
    const Stratum* here = ground.at(points[a]);
    if (!here) return;
    soil.number[a] = here->number;
    soil.mask[a] = 1.0;
    soil.fraction[a] = 1.0 - here->fillable_porosity;
    if (drag) soil.resistance[a] = here->resistance;
    soil.drag[a] = soil.resistance[a].linear;
  });
  return soil;
}

/// Soil of the other process, mapped to the fluid's particles. asymmetry [n]: of the soil's points around each
/// particle; 0 where a particle counts as in the soil wherever soil is within reach. before [n]: previous membership,
/// used with hysteresis where tight soil moves. full [n]: 1 where other water fills the pores around free water.
template <int D>
SoilView<D> mapped_soil(const Setup<D>& setup, const coupling::Inbox& inbox, std::span<const double> asymmetry,
                        std::span<const double> before, std::span<const char> full, const SeepageRegime& regime) {
  using namespace coupling;
  const std::size_t n = asymmetry.size();
  SoilView<D> soil;
  soil.resize(n);
  const auto& fraction = inbox.at(field::solid_volume_fraction).values;
  const auto& grain = inbox.at(field::grain_density).values;
  const auto& strain_rate = inbox.at(field::volumetric_strain_rate).values;
  const auto& modulus = inbox.at(field::constrained_modulus).values;
  const auto& yielding = inbox.at(field::yielding).values;
  const auto& conductivity = inbox.at(field::hydraulic_conductivity).values;
  const auto& quadratic = inbox.at(field::forchheimer_coefficient).values;
  const double weight = setup.ground.specific_weight();
  for (auto* values :
       {&soil.outside, &soil.coverage, &soil.density, &soil.strain_rate, &soil.modulus, &soil.plastic_shear_ratio})
    values->allocate(n);
  for (auto* values : {&soil.velocity, &soil.mean_velocity, &soil.force, &soil.returned_impulse}) values->allocate(n);
  const auto vector = [](const Field& from, std::size_t a) {
    return Vec<D>(Eigen::Map<const Vec<D>>(from.values.data() + a * D));
  };
  const Field force{"", D, inbox.between(field::unbalanced_force, 0.0)};  // at the window's start
  const Field &velocity = inbox.at(field::solid_velocity), &mean_velocity = inbox.at(field::mean_solid_velocity),
              &returned = inbox.at(field::returned_impulse);
  soil.loose.assign(n, 0);
  const bool repeated = !inbox.found.empty();
  if (repeated)
    for (auto* values : {&soil.found_velocity, &soil.found_force}) values->allocate(n);
  for (std::size_t a = 0; a < n; ++a) {
    soil.coverage.set(a, inbox.coverage[a]);
    soil.outside.set(a, distance_outside(asymmetry[a], setup.soil_spacing));
    soil.returned_impulse.set(a, vector(returned, a));
    const double whole = std::min(fraction[a], 1.0 - 1e-3);  // of the soil itself
    const bool moves = regime.soil_moves(yielding[a], vector(velocity, a).norm());
    const auto is_tight = [&] {
      if (!setup.drag || !(conductivity[a] > 0.0)) return false;
      const double n_w = 1.0 - whole, drag = porous::resistance(weight, n_w, {conductivity[a], quadratic[a]}).linear;
      return !inertia_rules(n_w, setup.density, drag, setup.spacing, setup.gravity);
    };
    double mask = 0.0;
    if (inbox.coverage[a] > 0.0) {
      const double spread = inbox.spread.empty() ? exchange::body_spread[1] : inbox.spread[a];
      const double body = body_share(inbox.coverage[a], asymmetry[a], spread, std::clamp(yielding[a], 0.0, 1.0));
      const bool tight = is_tight(), slips = moves && tight;
      mask = slips ? membership(asymmetry[a], before[a]) : membership(asymmetry[a]);
      // In the notches of an edge made of points water slips past, too.
      if (slips && mask < 0.5) mask = 0.0;
      // Free water that is pressed against full pores stays outside: with it the soil would count twice.
      if (tight && !regime.long_window && full[a] != 0) mask = 0.0;
      mask = body * mask + (1.0 - body) * loose_share(inbox.coverage[a], asymmetry[a]);
      soil.loose[a] = body < 0.5 ? 1 : 0;
    }
    const double n_s = whole * mask;
    if (n_s < exchange::least_solid_fraction || !(conductivity[a] > 0.0)) continue;
    soil.velocity.set(a, vector(velocity, a));
    soil.mean_velocity.set(a, vector(mean_velocity, a));
    soil.strain_rate.set(a, strain_rate[a]);
    soil.force.set(a, mask * vector(force, a));
    if (repeated) {
      soil.found_velocity.set(a, vector(inbox.found_at(field::mean_solid_velocity), a));
      soil.found_force.set(a, mask * vector(inbox.found_at(field::unbalanced_force), a));
    }
    soil.mask[a] = mask;
    soil.fraction[a] = n_s;
    soil.density.set(a, n_s * grain[a]);
    soil.modulus.set(a, modulus[a]);
    soil.plastic_shear_ratio.set(a, std::clamp(yielding[a], 0.0, 1.0));
    const double porosity = 1.0 - n_s;
    // Water that the soil covers in part seeps through that part and the free water in series.
    if (setup.drag)
      soil.resistance[a] = porous::resistance(weight, porosity, {conductivity[a] / mask, mask * quadratic[a]});
    soil.drag[a] = soil.resistance[a].linear;
  }
  return soil;
}

}  // namespace poretwin::fluid
