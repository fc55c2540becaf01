// The soil as the fluid sees it: arrays at the fluid particles, from the exchange or, when the soil is rigid, from the
// case.
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
  std::vector<int> number;  ///< [n] of the soil in the case, -1: none; empty for soil that moves
  OrZero<double> coverage;  ///< [n] by the soil's points: 1 inside, 0 out of their reach; of soil that moves
  ScalarArray fraction;     ///< [n] n_s, the residual water of moist soil counted in
  std::vector<porous::Resistance> resistance;  ///< [n] none in free water; empty where `drag` says it all
  /// [n] the resistance about the present slip w, R = C w' - f: C [N s/m4], f [N/m3] (Newton's tangent along the flow;
  /// f is zero under Darcy's law)
  ScalarArray drag;
  OrZero<Vec<D>> drag_offset;
  MatArray<D> drag_form;               ///< [n] that multiplies the slip in a smoothed drag; empty: none
  OrZero<double> density;              ///< [n] R = n_s rho_s, kg/m3; of soil that moves
  OrZero<double> modulus;              ///< [n] M = K + 4 G / 3, Pa
  OrZero<double> plastic_shear_ratio;  ///< [n] plastic over all shear strain of the soil's last window
  OrZero<Vec<D>> velocity;             ///< [n] v_s, m/s
  OrZero<Vec<D>> mean_velocity;        ///< [n] over the soil's last window, m/s
  OrZero<double> strain_rate;  ///< [n] of the skeleton's volume over that window, by the soil's own account, 1/s
  OrZero<Vec<D>> force;  ///< [n] r: unbalanced force per volume with the soil's weight, no pressure, no drag, N/m3
  /// Where a window is repeated: the mean velocity that the last pass found, m/s, and the unbalanced force that it
  /// left, without pressure and drag, N/m3.
  OrZero<Vec<D>> found_velocity, found_force;
  /// [n] impulse that the soil absorbed in its last window beyond the one given by the drag, N s. Momentum balance
  /// requires the water to supply it.
  OrZero<Vec<D>> returned_impulse;
  void resize(std::size_t n) {
    for (auto* a : {&mask, &fraction, &drag}) a->assign(n, 0.0);
    resistance.assign(n, {});
  }
  [[nodiscard]] std::size_t size() const { return mask.size(); }
  /// Does the tangent differ from the law?
  [[nodiscard]] bool nonlinear() const {
    return !drag_form.empty() ||
           std::any_of(resistance.begin(), resistance.end(), [](const auto& r) { return r.quadratic > 0.0; });
  }
  /// Takes the resistance about the slip between these velocities.
  void linearise(std::span<const Vec<D>> water, const OrZero<Vec<D>>& soil) {
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
  /// Lets go of the law where the tangent says it all.
  void forget_law() {
    if (!nonlinear()) resistance = std::vector<porous::Resistance>();
  }
  /// Force on the water against the slip, per volume [N/m3].
  [[nodiscard]] Vec<D> drag_force(std::size_t a, const Vec<D>& slip) const {
    const double C = resistance[a].coefficient(slip.norm());
    return drag_form.empty() ? Vec<D>(C * slip) : Vec<D>(C * drag_form[a] * slip);
  }
};

/// Does inertia rule in soil, as in free water? Where drag needs longer than 0.1 sqrt(spacing/g), a third of the window
/// that a free surface allows, to stop water: in rockfill (about 20 1/s against 150 1/s), never in sand.
inline bool inertia_rules(double n, double density, double drag, double spacing, double gravity) {
  return gravity > 0.0 && drag * exchange::held_within * std::sqrt(spacing / gravity) < n * density;
}

/// What decides whether water seeps through soil or moves along with it.
struct SeepageRegime {
  double density = 0.0;      ///< kg/m3, of water
  double speed = 0.0;        ///< m/s, up to which soil counts as at rest
  bool long_window = false;  ///< longer than the period of free water's surface waves
  /// Whether soil with this plastic shear ratio and speed [m/s] moves. In long windows its motion is quasi-static, from
  /// equilibrium to equilibrium, and water seeps in and out.
  [[nodiscard]] bool soil_moves(double plastic_shear_ratio, double soil_speed) const {
    return (plastic_shear_ratio > 0.5 || soil_speed > speed) && !long_window;
  }
};

/// Whether particle a is in the seepage regime: its water moves through the soil, and its surface is a wetting front.
/// Not where drag needs more than a spacing to stop it, C spacing < n rho |w| with the relative velocity w: it flows as
/// free water does. Nor where the soil itself moves: there water moves along and has a free surface, except in long
/// windows, whose motion is quasi-static. The pressure of a front is a natural condition, of which the gradient knows
/// nothing. That is right for a front whose speed follows from the pressure; a mixture with inertia would be pushed in
/// where it already moves in (a surface wave over liquefied soil grew sevenfold in 2 ms).
template <int D>
bool in_seepage_regime(const SoilView<D>& soil, std::size_t a, const Vec<D>& velocity, double spacing,
                       const SeepageRegime& regime) {
  const double relative = (velocity - soil.velocity[a]).norm();
  const bool moves = regime.soil_moves(soil.plastic_shear_ratio[a], soil.velocity[a].norm());
  return soil.mask[a] > 0.5 && !moves && soil.drag[a] * spacing >= (1.0 - soil.fraction[a]) * regime.density * relative;
}

/// Asymmetry of the soil's points about a place, to soil membership: a ramp about its value on a flat edge, 0.47, flat
/// below 0.31: disorder inside the soil (0.3 at most, for particles anywhere in their cells) does not change the
/// porosity.
inline double membership_ramp(double asymmetry) {
  return (exchange::outside_asymmetry - asymmetry) / exchange::ramp_width;
}
inline double membership(double asymmetry) { return std::clamp(membership_ramp(asymmetry), 0.0, 1.0); }

/// Soil membership of water in or beside tight soil that moves, with hysteresis; `before` is its previous value. Such
/// soil carries its pore water along, and water that flows past its edge stays outside. The points of an edge form a
/// staircase, so the asymmetry oscillates as water passes: a membership between 0 and 1 reverses only after the
/// asymmetry has gone back by half of the ramp's width (backlash).
inline double membership(double asymmetry, double before) {
  const double ramp = membership_ramp(asymmetry);
  return std::clamp(before, std::clamp(2.0 * ramp - 1.0, 0.0, 1.0), std::clamp(2.0 * ramp, 0.0, 1.0));
}

/// Soil as it is drawn, at rest and unyielding. drag: whether it resists the water.
template <int D>
SoilView<D> rigid_soil(const Ground<D>& ground, std::span<const Vec<D>> points, bool drag) {
  SoilView<D> soil;
  soil.resize(points.size());
  soil.number.assign(points.size(), -1);
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

/// Soil of the other process, as mapped to the fluid particles; asymmetry [n]: that of the exchange, 0 where a particle
/// counts as in the soil wherever any is in reach; before: [n] previous membership, used (with hysteresis) where tight
/// soil moves.
template <int D>
SoilView<D> mapped_soil(const Setup<D>& setup, const coupling::Inbox& inbox, std::span<const double> asymmetry,
                        std::span<const double> before, const SeepageRegime& regime) {
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
  for (auto* values : {&soil.coverage, &soil.density, &soil.strain_rate, &soil.modulus, &soil.plastic_shear_ratio})
    values->allocate(n);
  for (auto* values : {&soil.velocity, &soil.mean_velocity, &soil.force, &soil.returned_impulse}) values->allocate(n);
  const auto vector = [](const Field& from, std::size_t a) {
    return Vec<D>(Eigen::Map<const Vec<D>>(from.values.data() + a * D));
  };
  const Field force{"", D, inbox.between(field::unbalanced_force, 0.0)};  // at the window's start
  const Field &velocity = inbox.at(field::solid_velocity), &mean_velocity = inbox.at(field::mean_solid_velocity),
              &returned = inbox.at(field::returned_impulse);
  const bool repeated = !inbox.found.empty();
  if (repeated)
    for (auto* values : {&soil.found_velocity, &soil.found_force}) values->allocate(n);
  for (std::size_t a = 0; a < n; ++a) {
    soil.coverage.set(a, inbox.coverage[a]);
    soil.returned_impulse.set(a, vector(returned, a));
    const double whole = std::min(fraction[a], 1.0 - 1e-3);  // of the soil
    const auto passes_by = [&] {
      const bool moves = regime.soil_moves(yielding[a], vector(velocity, a).norm());
      if (!moves || !setup.drag || !(conductivity[a] > 0.0)) return false;
      const double n_w = 1.0 - whole, drag = porous::resistance(weight, n_w, {conductivity[a], quadratic[a]}).linear;
      return !inertia_rules(n_w, setup.density, drag, setup.spacing, setup.gravity);
    };
    double mask = 0.0;
    if (inbox.coverage[a] > 0.0) mask = passes_by() ? membership(asymmetry[a], before[a]) : membership(asymmetry[a]);
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
    if (setup.drag)
      soil.resistance[a] = porous::resistance(
          weight, porosity, porous::carried_over({conductivity[a], quadratic[a]}, 1.0 - whole, porosity));
    soil.drag[a] = soil.resistance[a].linear;
  }
  return soil;
}

}  // namespace poretwin::fluid
