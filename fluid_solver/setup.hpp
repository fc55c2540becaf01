// The parts of a case that the water needs: numbers, flags and geometry, computed once. The functions that compute a
// window do not use the case.
#pragma once

#include "common/case/case.hpp"
#include "common/particles/domain.hpp"
#include "common/particles/tiling.hpp"
#include "fluid_solver/discretisation/stencil.hpp"
#include "fluid_solver/exchange/drag_form.hpp"
#include "fluid_solver/exchange/ground.hpp"

#include <memory>

namespace poretwin::fluid {

/// A load on the soil: the properties on which the length of windows depends.
struct LoadInTime {
  std::optional<double> start;   ///< s, time at which the load begins to act; absent: it acts from the beginning
  std::optional<Series> factor;  ///< factor on the traction against time [s]; absent: 1
  double traction = 0.0;         ///< Pa
};

/// A straight piece of a wall with water beside it (2D). The domain lies on the left of the piece.
template <int D>
struct PressedWall {
  Vec<D> from, to;          ///< m
  bool both_sides = false;  ///< water may also press on the right
};

/// Lattices of particles in the case's regions of water, in their order.
template <int D>
std::vector<Lattice<D>> water_lattices(const Case& scene);

/// Properties of the water that stay constant during a run. lattices: the part of water_lattices in this domain.
template <int D>
struct Setup {
  Setup(const Case& scene, std::span<const Lattice<D>> lattices, const Domain& here = {});
  /// As one of several ranks that share the water. lattices: of the whole case. Throws CaseError where the case has
  /// something that several ranks cannot compute.
  Setup(const Case& scene, std::span<const Lattice<D>> lattices, std::shared_ptr<Tiling<D>> tiles);

  Domain domain;                      ///< the part of the water that this process computes
  std::shared_ptr<Tiling<D>> tiling;  ///< the tiles of the ranks that share the water; null: this process has all of it

  double spacing = 0.0;                  ///< of particles [m]
  double soil_spacing = 0.0;             ///< of the soil's particles [m]
  double density = 1000.0;               ///< of water, kg/m3
  double kinematic_viscosity = 0.0;      ///< of water, m2/s
  double cavitation_pressure = 0.0;      ///< Pa, total pressure
  double gravity = 0.0;                  ///< m/s2
  double gravity_or_standard = 9.81;     ///< m/s2, along bounded axes
  double central_force = 0.0;            ///< 1/s2
  Vec<D> acceleration = Vec<D>::Zero();  ///< of gravity, m/s2
  /// Specific weight of water [N/m3] along bounded axes, where gravity has a potential; gravity [m/s2] along periodic
  /// axes.
  Vec<D> weight = Vec<D>::Zero(), periodic_gravity = Vec<D>::Zero();
  Vec<D> origin = Vec<D>::Zero();  ///< m, datum of the piezometric pressure: initially on the highest water
  Vec<D> lower, upper;             ///< m, box beyond which water is lost
  std::vector<int> periodic;       ///< periodic axes
  Point3 periodic_lower = Point3::Zero(), periodic_length = Point3::Zero();  ///< m, along the periodic axes

  FluidCase::Scheme scheme = FluidCase::Scheme::projection;
  int sweeps = 1;                            ///< number of sweeps of explicit schemes
  std::optional<double> pressure_tolerance;  ///< relative; absent: as the case requires
  bool coupled = false;                      ///< the soil is computed as a separate phase
  bool responds = false;                     ///< the skeleton responds inside the pressure solve
  bool computes_beside = false;              ///< the soil is computed at the same time as the water (parallel scheme)
  bool soil_yields = false;                  ///< some soil moves and can yield
  bool soil_erodes = false;                  ///< free water carries off some soil
  bool drag = true;                          ///< the phases exert drag on each other
  std::optional<SmoothedDrag<D>> smoothed_drag;

  Ground<D> ground;
  bool one_soil = true;                       ///< all soils have one conductivity
  std::uint32_t no_slip = 0, fixed_soil = 0;  ///< walls (one bit for each): no slip of water; soil fixed
  std::vector<Joint<D>> joints;
  std::vector<LoadInTime> loads;

  std::string digest;  ///< of the case; both solvers must have the same
  std::vector<Gauge> gauges;
  std::vector<std::string> face_names;
  std::vector<PressedWall<D>> pressed_walls;

  [[nodiscard]] bool is_projection() const { return scheme == FluidCase::Scheme::projection; }
};

}  // namespace poretwin::fluid
