// What stays constant during a run: the case as the solver's numbers.
#pragma once

#include "common/media/seepage.hpp"
#include "solid_solver/discretisation/boundaries.hpp"
#include "solid_solver/discretisation/operators.hpp"
#include "solid_solver/material/model.hpp"
#include "solid_solver/numerics/points.hpp"

#include <limits>
#include <memory>
#include <optional>

namespace poretwin::solid {

/// A traction on the particles near one straight piece of a loaded face; it stays with these particles.
template <int D>
struct LoadedPatch {
  Vec<D> traction = Vec<D>::Zero();                         ///< Pa
  Vec<D> normal = Vec<D>::Zero();                           ///< unit, into the soil
  double start = -std::numeric_limits<double>::infinity();  ///< s; standing loads have always been there
  double level = 0.0;                                       ///< normal . point of the face [m]
  std::vector<Index> particles;
  std::optional<WaterFace> water_face;  ///< that lies on it
  std::optional<Series> factor;         ///< on the traction; absent: 1
  std::size_t load = 0;                 ///< of the case
  double length = 0.0;  ///< m, of the load's whole line, as far as soil lies along it; 0: a plane without end
  double scale = 1.0;   ///< on the forces: measure_loads()
};

/// The water, as far as the soil has to know it.
struct WaterSetup {
  double density = 0.0;              ///< kg/m3
  double kinematic_viscosity = 0.0;  ///< m2/s
  double weight = 0.0;               ///< N/m3, behind the word "conductivity"
  bool drags = true;                 ///< seepage force between the phases
  SolidCase::PressureGradient gradient = SolidCase::PressureGradient::difference;
  std::vector<PorePressure> prescribed;  ///< in soil that runs alone; none: a fluid gives the pressure
  bool is_field = false;                 ///< what the fluid gives is a field: pressure, and the share of full pores
  std::vector<WaterFace> faces;          ///< of a field: what stands behind them bears on the soil
  int dimension = 2;                     ///< of their regions
  Point3 gravity = Point3::Zero();       ///< m/s2
  [[nodiscard]] bool is_prescribed() const { return !prescribed.empty(); }
};

/// The law of seepage of a soil at a porosity.
inline porous::Seepage seepage_at(const WaterSetup& water, const Soil& soil, double porosity) {
  return porous::seepage_at(soil, porosity, water.weight / water.density, water.kinematic_viscosity);
}

/// How soil and water cross their windows together.
struct CouplingSetup {
  bool coupled = false;     ///< a fluid is there
  bool predicts = false;    ///< it predicts the soil's motion
  bool repeats = false;     ///< windows are repeated until both agree
  bool keep_points = true;  ///< points that have not moved keep their revision
  // Forces over the weight:
  double worth_repeating = 0.0;  ///< borne by neither phase, from which on a window is repeated
  double settled_below = 0.0;    ///< which the departure from the prediction calls for, and a repeated window may leave
};

/// The rest before time zero.
struct InitialRest {
  bool sought = true;
  bool bears_seepage = false;  ///< of water that flows steadily, not its buoyancy alone
};

template <int D>
struct Setup {
  double spacing = 0.0;           ///< m
  double smoothing_length = 0.0;  ///< m
  double full_cover = 1.0;        ///< sum V W in soil as dense as it was laid
  double skin = 0.0;              ///< m, pair lists hold until something moved half of it
  std::size_t parts = 1;          ///< of the particles, that threads share: as many on every machine
  bool can_yield = false;         ///< some soil can
  bool regular_flow = true;       ///< see dynamics/flow_regularisation.hpp
  bool soft_edges = false;        ///< surfaces that carry no stress are less stiff, for longer substeps
  double flow_limit =
      points::flow_limit;        ///< plastic strain above which hourglass control is off: it would brake the flow
  double inertia_share = 0.5;    ///< zr of the tracking coefficient Z = C + zr rho_bar / Dt
  bool counts_impulses = false;  ///< from outside, for a gauge
  bool parallel = false;  ///< the fluid's values are of the last window; where it predicts, Z = C / n^2 + .. then
  Vec<D> gravity = Vec<D>::Zero();
  double longest_substep = 0.0;  ///< s
  double rest_substep = 0.0;     ///< s, of dynamic relaxation
  double height = 0.0;           ///< m, extent of the soil along gravity
  Stabilisers stabilisers;
  Quiet quiet;          ///< of the case; regions = 0 where none sleep
  bool sleeps = false;  ///< soil that is quiet as a whole may sleep
  WaterSetup water;
  CouplingSetup coupling;
  InitialRest initial_rest;
  std::vector<Gauge> gauges;
  double gauge_interval = 0.0;  ///< s; 0: readings of every window
  Boundaries<D> boundaries;
  std::vector<LoadedPatch<D>> loads;
  std::vector<Soil> soils;  ///< their strength is that of the models; none is without `model`
  std::vector<std::shared_ptr<const ConstitutiveModel>> models;  ///< one per soil
  std::vector<Elasticity> typical;  ///< one per soil: under half the weight of soil and loads, where that counts
  ScalarArray largest_pressure;     ///< Pa, one per soil: mean effective pressure that the substep is chosen for
  std::vector<char> stiffens;       ///< one per soil: beyond it there are faster waves
  ScalarArray density;              ///< kg/m3, initial rho_bar_s, one per soil
  ScalarArray grain_density;        ///< kg/m3, of the grains with the residual water that moves with them, one per soil
  ScalarArray grain_share;          ///< of the grains in the volume of both, one per soil
  std::vector<char> constant_volume;    ///< one per soil: sheared without dilation
  std::vector<float> loose_friction;    ///< tan phi of collisions, one per soil; 0: grains never come apart
  std::vector<char> softened_by_water;  ///< one per soil: its cohesion follows the saturation
  [[nodiscard]] double range() const { return sph::support_radius * smoothing_length + skin; }
};

/// Volume fraction of what moves with the skeleton, n_s = m / (rho_s V), Eq. (50): the grains and, in soil that starts
/// moist, the residual water. The rest is what water can fill.
template <int D>
double solid_fraction(const Setup<D>& setup, const Particles<D>& particles, std::size_t i) {
  return particles.mass[i] / (setup.grain_density[particles.material[i]] * particles.volume[i]);
}

/// Porosity: the volume fraction of all but the grains.
template <int D>
double void_fraction(const Setup<D>& setup, const Particles<D>& particles, std::size_t i) {
  return 1.0 - setup.grain_share[particles.material[i]] * solid_fraction(setup, particles, i);
}

/// What the constitutive models follow: saturation, and the void ratio.
template <int D>
Condition condition(const Setup<D>& setup, const Particles<D>& particles, std::size_t i, double saturation) {
  return {saturation, 1.0 / (1.0 - void_fraction(setup, particles, i)) - 1.0};
}

/// Elastic moduli of a particle in its present state.
template <int D>
Elasticity moduli(const Setup<D>& setup, const Particles<D>& particles, std::size_t i) {
  return setup.models[particles.material[i]]->moduli(particles.stress[i], particles.state_of(i));
}

/// Throws DivergedError where soil whose stiffness follows the pressure bears more than the substep was chosen for.
template <int D>
void expect_bearable_pressure(const Setup<D>& setup, const Particles<D>& particles);

/// Unit vector against gravity; the last axis without any.
template <int D>
Vec<D> upwards(const Setup<D>& setup) {
  const double g = setup.gravity.norm();
  return g > 0.0 ? Vec<D>(-setup.gravity / g) : Vec<D>(Vec<D>::Unit(D - 1));
}

/// The same soil with its strength divided by a factor.
template <int D>
Setup<D> weaker(const Setup<D>& setup, double factor);

/// Numbers from the case; particles on the lattices of its soils. Throws CaseError when there is nothing to simulate.
template <int D>
std::pair<Setup<D>, Particles<D>> set_up(const Case& scene);

}  // namespace poretwin::solid
