// The region behind a face of water: still water, a basin, air, or a prescribed discharge. Each kind of region is one
// file and one row in `make_water_boundary` (docs/extending/boundary.md).
// Two mechanisms use these kinds. Water passes through columns of buffers (faces.hpp) between still water and soil or
// into the air; pistons (inlet.hpp) let water particles in and out.
#pragma once

#include "common/case/case.hpp"
#include "fluid_solver/time_limit.hpp"

#include <memory>

namespace poretwin::fluid {

/// A point on a face.
struct FacePlace {
  Point3 position = Point3::Zero();  ///< m
  double elevation = 0.0;            ///< m, along -gravity
  double specific_weight = 0.0;      ///< rho g of water, N/m3
};

/// State of a face between windows.
struct FaceState {
  double supplied = 0.0;  ///< m^D, initial volume of the face's basin plus its inflow since; 0: no basin
  double level = 0.0;     ///< m, of the basin
  double taken = 0.0;     ///< m^D, volume of the particles that have joined the still water behind the face
};

/// Volume of water that enters the domain through a face, minus the volume that leaves [m^D].
struct Passage {
  double before = 0.0;  ///< since the start, up to the window
  double during = 0.0;  ///< in the window, as far as known
};

/// Bounds on the changes behind a face in one window, and on the window's length.
struct AllowedChange {
  double rise = 0.0;      ///< m, change of a level
  double pressure = 0.0;  ///< Pa, change of a pressure: that of water `rise` deep
  double shortest = 0.0;  ///< s, shortest window that a table may require
  double longest = 0.0;   ///< s, longest window that all other limits allow
};

class WaterBoundary {
 public:
  virtual ~WaterBoundary() = default;

  /// The state at time zero.
  [[nodiscard]] virtual FaceState initial() const { return {}; }

  /// Level of the still water behind the face [m]; empty where no water with a level stands there.
  [[nodiscard]] virtual std::optional<double> level(double /*time*/, const FaceState& /*state*/) const { return {}; }

  /// Total pressure behind a place on the face [Pa]; a negative value stands for air.
  [[nodiscard]] virtual double pressure(const FacePlace& place, double time, const FaceState& state) const {
    const auto still = level(time, state);
    return still ? place.specific_weight * (*still - place.elevation) : -1.0;
  }

  /// Prescribed volume that enters through the face between two times [m^D]; empty where none is prescribed.
  [[nodiscard]] virtual std::optional<double> let_in(double /*from*/, double /*to*/) const { return {}; }

  /// Advances the state over a window. time, interval: s.
  virtual void advance(double /*time*/, double /*interval*/, const Passage& /*passed*/, FaceState& /*state*/) const {}

  /// Throws DivergedError where a run cannot continue from a state.
  virtual void check(double /*time*/, const FaceState& /*state*/) const {}

  /// The longest window that is allowed at time `now` [s].
  [[nodiscard]] virtual TimeLimit limit(double /*now*/, const AllowedChange& /*allowed*/,
                                        const FaceState& /*state*/) const {
    return {};
  }
};

/// One boundary for each face of the case, in the order of the faces.
using WaterBoundaries = std::vector<std::unique_ptr<WaterBoundary>>;

/// The boundary that a face's keys describe.
std::unique_ptr<WaterBoundary> make_water_boundary(const Case& scene, const WaterFace& face);
WaterBoundaries make_water_boundaries(const Case& scene);

/// Time after t [s] during which a table stays within `most` of its value at t.
double unchanged_for(const Series& series, double t, double most);

}  // namespace poretwin::fluid
