// What stands behind a face of water: still water, a basin, air, or a discharge that is let in. A kind is one file and
// one row in `make_water_boundary` (docs/extending/boundary.md). Two mechanisms ask it: columns of buffers
// (faces.hpp), through which water passes between still water and soil or out into the air, and pistons (inlet.hpp),
// which let particles of water in and out.
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

/// What is remembered of a face between windows.
struct FaceState {
  double supplied = 0.0;  ///< volume of its basin at first, and poured in since [m^D]; 0: no basin
  double level = 0.0;     ///< of the basin [m]
  double taken = 0.0;     ///< volume of particles that joined the still water behind the face [m^D]
};

/// Volume of water that comes into the domain through a face, less what goes out [m^D].
struct Passage {
  double before = 0.0;  ///< since the start, up to the window
  double during = 0.0;  ///< in the window, as far as it is known yet
};

/// How much may change behind a face in one window, and between which lengths the window is to be.
struct AllowedChange {
  double rise = 0.0;      ///< of a level [m]
  double pressure = 0.0;  ///< Pa, of water as deep
  double shortest = 0.0;  ///< s, what any table may ask for
  double longest = 0.0;   ///< s, what everything else allows
};

class WaterBoundary {
 public:
  virtual ~WaterBoundary() = default;

  /// At time zero.
  [[nodiscard]] virtual FaceState initial() const { return {}; }

  /// Level of the still water behind the face [m]; none: no water with a level stands there.
  [[nodiscard]] virtual std::optional<double> level(double /*time*/, const FaceState& /*state*/) const { return {}; }

  /// Total pressure of what stands behind a place of the face [Pa]; below zero: air.
  [[nodiscard]] virtual double pressure(const FacePlace& place, double time, const FaceState& state) const {
    const auto still = level(time, state);
    return still ? place.specific_weight * (*still - place.elevation) : -1.0;
  }

  /// Volume that is let in through the face from one time to another [m^D]; none: that is not prescribed.
  [[nodiscard]] virtual std::optional<double> let_in(double /*from*/, double /*to*/) const { return {}; }

  /// Takes the state over a window: time and interval [s].
  virtual void advance(double /*time*/, double /*interval*/, const Passage& /*passed*/, FaceState& /*state*/) const {}

  /// Throws DivergedError where a run cannot go on from a state.
  virtual void check(double /*time*/, const FaceState& /*state*/) const {}

  /// The longest window from `now` [s] on.
  [[nodiscard]] virtual TimeLimit limit(double /*now*/, const AllowedChange& /*allowed*/,
                                        const FaceState& /*state*/) const {
    return {};
  }
};

/// Of each face of the case, in its order.
using WaterBoundaries = std::vector<std::unique_ptr<WaterBoundary>>;

/// The boundary that a face's keys mean.
std::unique_ptr<WaterBoundary> make_water_boundary(const Case& scene, const WaterFace& face);
WaterBoundaries make_water_boundaries(const Case& scene);

/// For how long after t [s] a table stays within `most` of its value at t.
double unchanged_for(const Series& series, double t, double most);

}  // namespace poretwin::fluid
