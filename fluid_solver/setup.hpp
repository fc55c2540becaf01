// What the water takes from its case: numbers, flags and geometry, made once. Below it nothing reads the case.
#pragma once

#include "common/case/case.hpp"
#include "fluid_solver/discretisation/stencil.hpp"
#include "fluid_solver/exchange/drag_form.hpp"
#include "fluid_solver/exchange/ground.hpp"

namespace poretwin::fluid {

/// A load on the soil, as far as windows depend on it.
struct LoadInTime {
  std::optional<double> start;   ///< s
  std::optional<Series> factor;  ///< against time [s]
  double traction = 0.0;         ///< Pa
};

/// A straight piece of a wall that the water presses on (2D), with the domain on its left.
template <int D>
struct PressedWall {
  Vec<D> from, to;          ///< m
  bool both_sides = false;  ///< water may press on its right as well
};

/// Lattices of particles in the regions of water, in their order.
template <int D>
std::vector<Lattice<D>> water_lattices(const Case& scene);

/// lattices: see water_lattices.
template <int D>
struct Setup {
  Setup(const Case& scene, std::span<const Lattice<D>> lattices);

  double spacing = 0.0;                  ///< of particles [m]
  double density = 1000.0;               ///< of water, kg/m3
  double kinematic_viscosity = 0.0;      ///< of water, m2/s
  double cavitation_pressure = 0.0;      ///< total, Pa
  double gravity = 0.0;                  ///< m/s2
  double gravity_or_standard = 9.81;     ///< m/s2, along bounded axes
  double central_force = 0.0;            ///< 1/s2
  Vec<D> acceleration = Vec<D>::Zero();  ///< of gravity, m/s2
  /// Weight of water [N/m3] along bounded axes, where it has a potential, and gravity along periodic ones [m/s2].
  Vec<D> weight = Vec<D>::Zero(), periodic_gravity = Vec<D>::Zero();
  Vec<D> origin = Vec<D>::Zero();  ///< of piezometric pressure: on the highest water at first [m]
  Vec<D> lower, upper;             ///< beyond, water is lost [m]
  std::vector<int> periodic;       ///< axes
  Point3 periodic_lower = Point3::Zero(), periodic_length = Point3::Zero();  ///< m, along those

  FluidCase::Scheme scheme = FluidCase::Scheme::projection;
  int sweeps = 1;                            ///< of explicit schemes
  std::optional<double> pressure_tolerance;  ///< relative; none: as the scene needs
  bool coupled = false;                      ///< the soil is a phase of its own
  bool responds = false;                     ///< and its skeleton responds inside the pressure solve
  bool computes_beside = false;              ///< and crosses each window at the same time
  bool soil_yields = false;                  ///< some soil moves and can yield
  bool drag = true;                          ///< between the phases
  std::optional<SmoothedDrag<D>> smoothed_drag;

  Ground<D> ground;
  bool one_soil = true;                       ///< of one conductivity
  std::uint32_t no_slip = 0, fixed_soil = 0;  ///< walls, by bits
  std::vector<Joint<D>> joints;
  std::vector<LoadInTime> loads;

  std::string digest;  ///< of what both solvers agree on
  std::vector<Gauge> gauges;
  std::vector<std::string> face_names;
  std::vector<PressedWall<D>> pressed_walls;

  [[nodiscard]] bool is_projection() const { return scheme == FluidCase::Scheme::projection; }
};

}  // namespace poretwin::fluid
