// Openings through which water enters and leaves as particles. A mirror moves inwards with the water, like a piston.
// When it is half a spacing inside, it is moved back by one spacing, and a row of particles fills the gap (after
// Lastiwka et al. 2009; the images behind the mirror serve as their inflow zone). The volume that enters is exact: the
// piston's displacement times the opening's width.
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
  int face = 0;                                              ///< index in Case::water_faces
  bool sill = false;                                         ///< an opening over the crest of a reservoir
  Vec<D> foot = Vec<D>::Zero();                              ///< m, middle of the opening
  Vec<D> normal = Vec<D>::Zero(), tangent = Vec<D>::Zero();  ///< unit; normal into the domain
  double width = 0.0;                                        ///< m; for a sill the depth of the water over it
  double lowest = 0.0, highest = 0.0;                        ///< m, elevations of the opening's ends
  double spacing = 0.0;                                      ///< m, of the rows of particles along the normal
  int row = 0;                                               ///< number of particles in a row
  double piston = 0.0;                                       ///< m, position of the piston inside the opening
  double speed = 0.0;                                        ///< m/s, inwards
  double level = 0.0;                                        ///< m, of the water in front of the piston
  double net = 0.0;                                          ///< m^D, volume of particles born minus that of particles
                                                             ///< deleted
  bool flows = false;                                        ///< for a sill: the reservoir's level is above it
  double current = 0.0;  ///< m/s, averaged over time: for a sill the speed in front of it, else the current that keeps
                         ///< a reservoir's level
  [[nodiscard]] double depth(const Vec<D>& x) const { return normal.dot(x - foot) - piston; }
  [[nodiscard]] bool before(const Vec<D>& x) const { return 2.0 * std::abs(tangent.dot(x - foot)) <= width; }
  /// Volume of water that has entered, minus the volume that has left [m^D].
  [[nodiscard]] double passed() const { return net + piston * width; }
  /// Opens a sill to a depth [m], at least half a particle's. The volume that its piston has swept stays the same.
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

/// Depth [m] and mean velocity [m/s] of water that flows over a crest.
struct SillFlow {
  double depth = 0.0, speed = 0.0;
};
/// Flow at the opening from still water of level `head` [m] above the crest. `before` is the flow on the crest; gravity
/// is in m/s2. The outgoing wave keeps u - 2 sqrt(g h) (Stoker 1957). Inflow keeps the reservoir's energy, h + u^2/2g =
/// head, and is at most critical, h = 2/3 head (Belanger 1828). Outflow loses its kinetic energy.
SillFlow flow_over(double head, const SillFlow& before, double gravity);

/// Inward speed through one window [m/s]. With a prescribed discharge it is that discharge over the opening's area.
/// With a prescribed level H it follows from the discharge Q = sqrt(g d) (H - level) per width, that of a long wave of
/// this height in water of depth d. This inlet reflects no incoming wave and does not depend on the reservoir's area.
/// Inlet::current replaces water that is drawn off steadily. gravity [m/s2]: of the case.
template <int D>
double inlet_speed(const WaterBoundary& boundary, const FaceState& state, const Inlet<D>& inlet, double dx,
                   double gravity, double time, double interval);

/// Boundary numbers: of sills' pistons, of other pistons, and of periodic sides.
inline constexpr int sill_boundary = 29, piston_boundary = 30, periodic_boundary = 31;

}  // namespace poretwin::fluid
