// Openings through which real water comes and goes: pistons. A mirror moves in with the water; when it has pushed by a
// spacing it steps back, and a row of particles stands where it stood (after Lastiwka et al. 2009, whose inflow zone
// the mirror's images are). What is let in is exact: the piston's way times its width.
#pragma once

#include "common/case/case.hpp"
#include "common/core/vector.hpp"
#include "common/particles/images.hpp"
#include "common/particles/sight.hpp"
#include "fluid_solver/boundary/water_boundary.hpp"

#include <cmath>
#include <vector>

namespace poretwin::fluid {

template <int D>
struct Inlet {
  int face = 0;                                              ///< of Case::water_faces
  bool sill = false;                                         ///< the opening over the crest of a reservoir
  Vec<D> foot = Vec<D>::Zero();                              ///< middle of the opening [m]
  Vec<D> normal = Vec<D>::Zero(), tangent = Vec<D>::Zero();  ///< unit; normal into the domain
  double width = 0.0;                                        ///< m; of a sill the water's depth there
  double lowest = 0.0, highest = 0.0;                        ///< elevations of its ends [m]
  double spacing = 0.0;                                      ///< of the rows along the normal [m]
  int row = 0;                                               ///< particles in a row
  double piston = 0.0;                                       ///< how far it stands inside [m]
  double speed = 0.0;                                        ///< inwards [m/s]
  double level = 0.0;                                        ///< of the water before it [m]
  double net = 0.0;                                          ///< volume of particles born less taken away [m^D]
  bool flows = false;                                        ///< a sill: its reservoir stands above it
  double current = 0.0;  ///< slowly averaged: speed in front of a sill; or the one that a reservoir's head needs [m/s]
  [[nodiscard]] double depth(const Vec<D>& x) const { return normal.dot(x - foot) - piston; }
  [[nodiscard]] bool before(const Vec<D>& x) const { return 2.0 * std::abs(tangent.dot(x - foot)) <= width; }
  /// Volume of water that has come in, less what has gone out [m^D].
  [[nodiscard]] double passed() const { return net + piston * width; }
  /// Opens a sill to a depth, at least half a particle's; the volume its piston has swept stays.
  void open(double depth, double dx) {
    const Vec<D> crest = foot + 0.5 * width * tangent;
    const double swept = piston * width;
    width = std::max(depth, 0.5 * dx);
    foot = crest - 0.5 * width * tangent;
    row = std::max(1, static_cast<int>(std::lround(width / dx)));
    spacing = row * std::pow(dx, D) / width;
    piston = swept / width;
  }
};

template <int D>
std::vector<Inlet<D>> make_inlets(const Case& scene, const WaterBoundaries& boundaries);

/// Depth [m] and mean velocity [m/s] of water that runs over a crest.
struct SillFlow {
  double depth = 0.0, speed = 0.0;
};
/// At the opening from still water of level `head` [m] over the crest, `before` it on the crest; gravity in m/s2. The
/// wave that comes out to the opening keeps u - 2 sqrt(g h) (Stoker 1957); what goes in keeps the reservoir's energy,
/// h + u^2/2g = head, and no more than critically, h = 2/3 head (Belanger 1828); what comes out leaves it behind.
SillFlow flow_over(double head, const SillFlow& before, double gravity);

/// Speed inwards through one window [m/s]: of the discharge prescribed, or of what brings the water before the opening
/// to the level prescribed, Q = sqrt(g d) (H - level), the discharge of a long wave of that height in water d deep: it
/// neither sends a wave that comes in back nor needs the area of the reservoir. What is drawn off for long comes as
/// Inlet::current.
/// gravity [m/s2]: of the case.
template <int D>
double inlet_speed(const WaterBoundary& boundary, const FaceState& state, const Inlet<D>& inlet, double dx,
                   double gravity, double time, double interval);

/// Number of the boundary for the sills' pistons, for the others and for periodic sides.
inline constexpr int sill_boundary = 29, piston_boundary = 30, periodic_boundary = 31;

}  // namespace poretwin::fluid
