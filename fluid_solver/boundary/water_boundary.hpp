// The region behind a face of water: still water, a basin, air, or a discharge that is let in. Each kind is one file
// and one row in `make_water_boundary` (docs/extending/boundary.md). Two mechanisms use it: columns of buffers
// (faces.hpp), through which water passes between still water and soil or into the air, and pistons (inlet.hpp), which
// let water particles in and out.
#pragma once

#include "common/case/case.hpp"
#include "fluid_solver/time_limit.hpp"

#include <memory>

namespace poretwin::fluid {

/// A place on a face.
struct FacePlace {
  Point3 position = Point3::Zero();  ///< m
  double elevation = 0.0;            ///< m, along -gravity
  double specific_weight = 0.0;      ///< rho g of water, N/m3
};

/// State of a face between windows.
struct FaceState {
  double supplied = 0.0;  ///< m^D, initial volume of its basin and inflow since; 0: no basin
  double level = 0.0;     ///< m, of the basin
  double taken = 0.0;     ///< m^D, volume of particles that have joined the still water behind the face
};

/// Volume of water that comes into the domain through a face, minus what goes out [m^D].
struct Passage {
  double before = 0.0;  ///< since the start, up to the window
  double during = 0.0;  ///< in the window, as far as it is known yet
};

/// Bounds on changes behind a face in one window, and on the window's length.
struct AllowedChange {
  double rise = 0.0;      ///< m, change of a level
  double pressure = 0.0;  ///< Pa, the pressure of that depth of water
  double shortest = 0.0;  ///< s, shortest window that a table may require
  double longest = 0.0;   ///< s, longest window that everything else allows
};

class WaterBoundary {
 public:
  virtual ~WaterBoundary() = default;

  /// The state at time zero.
  [[nodiscard]] virtual FaceState initial() const { return {}; }

  /// Level of the still water behind the face [m]; empty where no water with a level stands there.
  [[nodiscard]] virtual std::optional<double> level(double /*time*/, const FaceState& /*state*/) const { return {}; }

  /// Total pressure behind a place on the face [Pa]; negative: air.
  [[nodiscard]] virtual double pressure(const FacePlace& place, double time, const FaceState& state) const {
    const auto still = level(time, state);
    return still ? place.specific_weight * (*still - place.elevation) : -1.0;
  }

  /// Prescribed volume let in through the face between two times [m^D]; empty where it is not prescribed.
  [[nodiscard]] virtual std::optional<double> let_in(double /*from*/, double /*to*/) const { return {}; }

  /// Advances the state over a window. time, interval: s.
  virtual void advance(double /*time*/, double /*interval*/, const Passage& /*passed*/, FaceState& /*state*/) const {}

  /// Throws DivergedError where a run cannot continue from a state.
  virtual void check(double /*time*/, const FaceState& /*state*/) const {}

  /// The longest allowed window from `now` [s] on.
  [[nodiscard]] virtual TimeLimit limit(double /*now*/, const AllowedChange& /*allowed*/,
                                        const FaceState& /*state*/) const {
    return {};
  }
};

/// One boundary for each face of the case, in their order.
using WaterBoundaries = std::vector<std::unique_ptr<WaterBoundary>>;

/// The boundary that a face's keys describe.
std::unique_ptr<WaterBoundary> make_water_boundary(const Case& scene, const WaterFace& face);
WaterBoundaries make_water_boundaries(const Case& scene);

/// Time after t [s] for which a table stays within `most` of its value at t.
double unchanged_for(const Series& series, double t, double most);

}  // namespace poretwin::fluid
