// Rigid plates that press on the soil: moving walls of images (docs/theory/plates.md).
#pragma once

#include "solid_solver/discretisation/boundaries.hpp"

#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace poretwin::solid {

/// A plate as the case describes it.
template <int D>
struct PlateSetup {
  std::string name;
  Vec<D> normal = Vec<D>::Zero();      ///< unit, into the soil: the direction in which the plate presses
  Vec<D> along = Vec<D>::Zero();       ///< unit, along its line, towards its last point
  std::optional<Series> displacement;  ///< m, along the normal
  std::optional<Series> speed;         ///< m/s, along the normal, in place of the displacement
  std::optional<Series> force;         ///< N, along the normal, in place of displacement and speed
  std::optional<Series> slide;         ///< m, displacement along the line
  double start = -std::numeric_limits<double>::infinity();  ///< s, time from which on the force acts
  double mass = 0.0;                                        ///< kg, of a plate under a force
  double row = 0.0;                                         ///< kg, mass of a row of the soil in front of the plate
  bool sinks_in = false;  ///< soil lies beside one of the plate's ends; the plate may sink into it
  // Of a plate that tilts (2D).
  bool tilts = false, lifts = false;
  Vec<D> middle = Vec<D>::Zero();  ///< m, at time zero
  double half = 0.0;               ///< m, half of its length
  double inertia = 0.0;            ///< kg m2/m, of the mass, about the middle
  double row_inertia = 0.0;        ///< kg m2/m, of the row of soil
  double eccentricity = 0.0;       ///< m, place of the force on the line, from the middle
  std::optional<Series> moment;    ///< N m/m, on the plate, counter-clockwise
  [[nodiscard]] bool is_free() const { return force.has_value(); }  ///< the plate moves under a force
  /// Displacement [m] that the case prescribes at `time` [s]. For a plate under a force it has no component along the
  /// normal.
  [[nodiscard]] Vec<D> prescribed(double time) const;
  /// Force [N] along the normal at `time` [s], and moment [N m/m] in addition to that of the force.
  [[nodiscard]] double force_at(double time) const;
  [[nodiscard]] double moment_at(double time) const;
};

/// A motion of a plate that follows from the forces on it: its displacement along its normal, or its rotation.
struct PlateFreedom {
  std::size_t plate = 0;
  bool turns = false;
};

/// What the case prescribes for a plate in a step: its displacement at the step's end, `target` [m], and the force on
/// it along its normal [N] and its moment [N m/m]. For a plate under a force only the displacement along its line is
/// prescribed.
template <int D>
struct PlateOrder {
  Vec<D> target = Vec<D>::Zero();
  double force = 0.0, moment = 0.0;
};

/// The plates of a case in front of soil of the given spacing [m], positions [m] and masses [kg].
template <int D>
std::vector<PlateSetup<D>> make_plates(const Case& scene, double spacing, const VecArray<D>& position,
                                       const ScalarArray& mass);

/// What the case prescribes for the plates in a step that ends at `time` [s].
template <int D>
std::vector<PlateOrder<D>> orders_at(const std::vector<PlateSetup<D>>& plates, double time);

/// All freedoms of the plates under a force.
template <int D>
std::vector<PlateFreedom> freedoms_of(const std::vector<PlateSetup<D>>& plates);

}  // namespace poretwin::solid
