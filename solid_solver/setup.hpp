// The properties that stay constant during a run: the quantities of the case in the form that the solver uses.
#pragma once

#include "common/media/erosion_law.hpp"
#include "common/media/seepage.hpp"
#include "common/particles/domain.hpp"
#include "common/particles/tiling.hpp"
#include "solid_solver/discretisation/boundaries.hpp"
#include "solid_solver/discretisation/operators.hpp"
#include "solid_solver/discretisation/plates.hpp"
#include "solid_solver/material/model.hpp"
#include "solid_solver/numerics/points.hpp"

#include <limits>
#include <memory>
#include <optional>

namespace poretwin::solid {

/// A traction on the particles near one straight piece of a loaded face. It always acts on the same particles.
template <int D>
struct LoadedPatch {
  Vec<D> traction = Vec<D>::Zero();                         ///< Pa
  Vec<D> normal = Vec<D>::Zero();                           ///< unit, into the soil; 0: on all sides, by `pressure`
  double pressure = 0.0;                                    ///< Pa, on all sides of the soil
  double start = -std::numeric_limits<double>::infinity();  ///< s; a load that always acts has the start -infinity
  double level = 0.0;                                       ///< normal . x [m] of the points x on the face
  std::vector<Index> particles;         ///< of the whole soil, where several ranks share it (for_each_own)
  std::optional<WaterFace> water_face;  ///< water face of the case that coincides with this piece
  std::optional<Series> factor;         ///< factor on the traction as a function of time; absent: 1
  std::size_t load = 0;                 ///< index of the load in the case
  double length = 0.0;  ///< m, length of the load's whole line along which soil lies (3D: m2, area of its part of a
                        ///< plane); 0 for a plane without ends
  double scale = 1.0;   ///< factor on the forces, see measure_loads()
};

/// The properties of the water that the soil needs.
struct WaterSetup {
  double density = 0.0;              ///< kg/m3
  double kinematic_viscosity = 0.0;  ///< m2/s
  double weight = 0.0;               ///< N/m3, specific weight to which the case's `conductivity` refers
  bool drags = true;                 ///< water and skeleton exchange seepage forces
  SolidCase::PressureGradient gradient = SolidCase::PressureGradient::difference;
  std::vector<PorePressure> prescribed;  ///< prescribed pore pressures, for soil without a fluid; empty: a fluid gives
                                         ///< the pressure
  bool is_field = false;                 ///< the fluid is a field on the soil's points: it gives a pressure and a
                                         ///< degree of saturation
  std::vector<WaterFace> faces;          ///< water faces of a field: the pressure behind them acts on the soil
  int dimension = 2;                     ///< dimension of the case's regions
  Point3 gravity = Point3::Zero();       ///< m/s2
  [[nodiscard]] double dynamic_viscosity() const { return density * kinematic_viscosity; }  ///< Pa s
  [[nodiscard]] bool is_prescribed() const { return !prescribed.empty(); }
  [[nodiscard]] bool has_basins() const { return is_field && poretwin::has_basins(faces); }
};

/// The law of seepage of a soil at a given porosity.
inline porous::Seepage seepage_at(const WaterSetup& water, const Soil& soil, double porosity) {
  return porous::seepage_at(soil, porosity, water.weight / water.density, water.kinematic_viscosity);
}

/// How soil and water are computed together in a window.
struct CouplingSetup {
  bool coupled = false;     ///< a fluid takes part
  bool predicts = false;    ///< the fluid predicts the soil's motion
  bool repeats = false;     ///< windows are repeated until fluid and solid agree
  bool keep_points = true;  ///< points that have not moved keep their revision number
  // Forces over the weight:
  double worth_repeating = 0.0;  ///< force borne by neither phase above which the first pass is repeated
  double settled_below = 0.0;    ///< in a repeated window: force that the departure from the prediction may still
                                 ///< require
};

/// The search for the soil's rest before time zero.
struct InitialRest {
  bool sought = true;
  bool bears_seepage = false;  ///< steady seepage force acts, not only the water's buoyancy
};

template <int D>
struct Setup {
  Domain domain;  ///< the part of the soil that this process computes; how many particles and copies
                  ///< it has changes with time and stands in Particles
  std::shared_ptr<Tiling<D>> tiling;  ///< the tiles of the ranks that share the soil; null: this process has all of its
                                      ///< bodies to itself
  double spacing = 0.0;               ///< m
  double smoothing_length = 0.0;      ///< m
  double full_cover = 1.0;            ///< sum V W in soil on its initial lattice
  double skin = 0.0;                  ///< m, margin of the pair lists: valid until a particle has moved by half of it
  std::size_t parts = 1;              ///< parts of the particles that threads share: as many on every machine
  bool can_yield = false;             ///< some soil of the case can yield
  bool regular_flow = true;           ///< see dynamics/flow_regularisation.hpp
  bool soft_edges = false;  ///< soil at surfaces that carry no stress is less stiff, which allows longer substeps
  double flow_limit = points::flow_limit;  ///< plastic strain above which hourglass control is off: it would brake the
                                           ///< flow
  double inertia_share = 0.5;              ///< zr of the tracking coefficient Z = C + zr rho_bar / Dt
  bool counts_impulses = false;            ///< impulses from outside are summed, for a gauge
  bool parallel = false;  ///< parallel scheme: the fluid's values are those of the last window; if it predicts the
                          ///< soil's motion, Z = C / n^2 + zr rho_bar / Dt
  Vec<D> gravity = Vec<D>::Zero();
  double longest_substep = 0.0;  ///< s
  double rest_substep = 0.0;     ///< s, substep of dynamic relaxation
  double height = 0.0;           ///< m, extent of the soil along gravity
  Stabilisers stabilisers;
  Quiet quiet;          ///< `solid.quiet` of the case; regions = 0: no region sleeps beside flowing soil
  bool sleeps = false;  ///< soil may sleep when all of it is quiet
  WaterSetup water;
  CouplingSetup coupling;
  InitialRest initial_rest;
  std::vector<Gauge> gauges;
  double gauge_interval = 0.0;  ///< s; 0: gauges are read in every window
  Boundaries<D> boundaries;
  std::vector<LoadedPatch<D>> loads;
  std::vector<PlateSetup<D>> plates;
  std::vector<Soil> soils;  ///< strength is as the models use it; `model` is set for each soil
  std::vector<std::shared_ptr<const ConstitutiveModel>> models;  ///< one per soil
  std::vector<Elasticity> typical;  ///< one per soil: moduli under half the weight of soil and loads, if they depend on
                                    ///< pressure
  ScalarArray largest_pressure;     ///< Pa, one per soil: largest mean effective pressure that the substep allows for
  std::vector<char> stiffens;       ///< one per soil: 1 where a higher pressure would make waves faster than the
                                    ///< substep allows
  ScalarArray density;              ///< kg/m3, initial bulk density rho_bar_s, one per soil
  ScalarArray grain_density;        ///< kg/m3, density of the grains with the residual water that moves with them, one
                                    ///< per soil
  ScalarArray grain_share;          ///< volume fraction of the grains in grains plus residual water, one per soil
  std::vector<char> constant_volume;  ///< one per soil: 1 where it shears without dilation
  /// Bulk volume over its initial value above which the grains do not touch and carry no stress, one per soil;
  /// infinite where they touch at the start.
  ScalarArray contact_volume;
  std::vector<float> loose_friction;  ///< tan phi of collisions, one per soil; 0: its grains never come apart
  std::vector<std::optional<porous::Erosion>> erosion;  ///< one per soil: how free water erodes it; empty: it does not
  bool erodes = false;                                  ///< free water erodes some soil
  std::vector<char> softened_by_water;  ///< one per soil: 1 where the cohesion depends on the saturation
  [[nodiscard]] double range() const { return sph::support_radius * smoothing_length + skin; }
};

/// Volume fraction of the matter that moves with the skeleton, n_s = m / (rho_s V), Eq. (50): the grains and, in
/// initially moist soil, its residual water. Water can fill the rest of the volume.
template <int D>
double solid_fraction(const Setup<D>& setup, const Particles<D>& particles, std::size_t i) {
  return particles.mass[i] / (setup.grain_density[particles.material[i]] * particles.volume[i]);
}

/// Porosity: volume fraction of all matter except the grains.
template <int D>
double void_fraction(const Setup<D>& setup, const Particles<D>& particles, std::size_t i) {
  return 1.0 - setup.grain_share[particles.material[i]] * solid_fraction(setup, particles, i);
}

/// Conditions of a particle whose stress is brought back to what its soil can carry, without a strain.
template <int D>
Condition at_once(const Setup<D>& setup, const Particles<D>& particles, std::size_t i, double saturation) {
  return {saturation, 1.0 / (1.0 - void_fraction(setup, particles, i)) - 1.0, 0.0, setup.water.dynamic_viscosity()};
}

/// Whether the grains of a particle are apart because they have not settled to their soil's contact porosity yet.
template <int D>
bool in_suspension(const Setup<D>& setup, const Particles<D>& particles, std::size_t i) {
  const Index soil = particles.material[i];
  return particles.volume[i] > setup.contact_volume[soil] * particles.mass[i] / setup.density[soil];
}

/// Elastic moduli of a particle in its present state; of suspended grains, those that they have once they touch.
template <int D>
Elasticity moduli(const Setup<D>& setup, const Particles<D>& particles, std::size_t i) {
  return setup.models[particles.material[i]]->moduli(particles.stress[i], particles.state_of(i));
}

/// Throws DivergedError where the pressure on soil with pressure-dependent stiffness exceeds what the substep allows.
template <int D>
void expect_bearable_pressure(const Setup<D>& setup, const Particles<D>& particles);

/// Unit vector against gravity; along the last axis if there is no gravity.
template <int D>
Vec<D> upwards(const Setup<D>& setup) {
  const double g = setup.gravity.norm();
  return g > 0.0 ? Vec<D>(-setup.gravity / g) : Vec<D>(Vec<D>::Unit(D - 1));
}

/// A copy of the setup with the strength of all soils divided by a factor.
template <int D>
Setup<D> weaker(const Setup<D>& setup, double factor);

/// Setup of a case, and particles on the lattices of its soils. Throws CaseError when no particle lies in any soil.
template <int D>
std::pair<Setup<D>, Particles<D>> set_up(const Case& scene, const Domain& domain = {});
/// For one of several ranks that share the soil: all its particles, of which laid_out() keeps this rank's share. Throws
/// CaseError where the case has what several ranks cannot compute.
template <int D>
std::pair<Setup<D>, Particles<D>> set_up(const Case& scene, std::shared_ptr<Tiling<D>> tiling);

}  // namespace poretwin::solid
