// Images of particles behind straight boundaries: mirrored at walls, shifted at periodic sides. Images are exact for a
// plane wall and need no dummy particles. Images of images fill corners.
#pragma once

#include "common/core/vector.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <span>

namespace poretwin::sph {

/// A straight piece of a boundary, which makes images of the particles near it.
template <int D>
struct ImagePlane {
  enum class Kind { mirror, periodic };
  Kind kind = Kind::mirror;
  Vec<D> point = Vec<D>::Zero();   ///< any point of the plane [m]
  Vec<D> normal = Vec<D>::Zero();  ///< unit vector, into the domain
  Vec<D> shift = Vec<D>::Zero();   ///< periodic only: translation of the image [m]
  /// Only particles whose coordinate along `tangent` lies in [from, to] have images; by default all do.
  Vec<D> tangent = Vec<D>::Zero();
  double from = 0.0, to = 0.0;
  /// A rectangle (3D) ends likewise along the direction that is perpendicular to normal and tangent.
  Vec<D> second_tangent = Vec<D>::Zero();
  double second_from = 0.0, second_to = 0.0;
  /// For a corner at which two pieces share the images (meet_at_corners): `at` [m] is a point of the plane that divides
  /// the images, `out` its normal. This piece makes no image at x with out . (x - at) > 0. At any other end out = 0.
  struct End {
    Vec<D> at = Vec<D>::Zero(), out = Vec<D>::Zero();
  };
  std::array<End, 2> ends{};
  /// An end that was drawn in a corner of less than 105 degrees continues by `length` [m] beyond it, so that images of
  /// images fill the corner. closed_by: `piece` of the wall that closes it. What lies behind that wall belongs to other
  /// water or soil, and the continuation does not mirror it.
  struct Overhang {
    double length = 0.0;
    int closed_by = -1;
  };
  std::array<Overhang, 2> overhangs{};
  int piece = -1;      ///< number of the piece among those that meet at corners
  double speed = 0.0;  ///< m/s, of a moving mirror (a piston) along its normal, at `point`
  double spin = 0.0;   ///< 1/s, of a mirror that turns: gain of its speed per length along `tangent` (2D)
  int boundary = 0;    ///< number of the boundary in the solver, 0..31
  /// For points whose sight walls block (sight.hpp): number of the wall piece as a screen, the same for both of its
  /// sides; -1: the piece is no screen. seen_from, seen_to: extent of the screen along `tangent` [m].
  int screen = -1;
  double seen_from = 0.0, seen_to = 0.0;
  bool back = false, taken = false;  ///< back: far side of a line; taken: its start belongs to the piece before it
  [[nodiscard]] Vec<D> at(double along) const { return point + (along - tangent.dot(point)) * tangent; }
  /// How far x lies beyond the nearest end [m]; below zero between the ends.
  [[nodiscard]] double beyond(const Vec<D>& x) const {
    if (to <= from) return -std::numeric_limits<double>::infinity();
    const double along = tangent.dot(x), first = std::max(from - along, along - to);
    if (second_to <= second_from) return first;
    const double second = second_tangent.dot(x);
    return std::max({first, second_from - second, second - second_to});
  }
  /// Whether the piece lies opposite x, within its extent.
  [[nodiscard]] bool faces(const Vec<D>& x) const { return beyond(x) <= 0.0; }
};

/// Images in the order in which they are made. parent: index of the real particle. The velocity of an image is map v +
/// carried; other vectors are map v.
template <int D>
struct Images {
  VecArray<D> position;
  std::vector<Index> parent;
  MatArray<D> map;
  VecArray<D> carried;                    ///< m/s, from moving mirrors
  std::vector<std::uint32_t> boundaries;  ///< bit b is set if boundary b took part
  /// Only from images_in_all_orders(): the plane that made an image, and the point or image from which it was made (the
  /// numbers of images follow those of the points).
  std::vector<Index> by, of;
  [[nodiscard]] std::size_t size() const { return parent.size(); }
};

/// Whether a place x opposite the plane lies beyond the end of what was drawn, while its owner stands more than
/// `beyond` [m] behind the wall that closes the corner there. The owner is x itself or, if x is an image, its parent.
template <int D>
bool belongs_behind_corner(std::span<const ImagePlane<D>> planes, const ImagePlane<D>& plane, const Vec<D>& x,
                           const Vec<D>& owner, double beyond) {
  const double along = plane.tangent.dot(x);
  const std::array<double, 2> past{plane.from + plane.overhangs[0].length - along,
                                   along - plane.to + plane.overhangs[1].length};
  for (const std::size_t e : {0, 1}) {
    if (plane.overhangs[e].closed_by < 0 || past[e] <= 0.0) continue;
    for (const auto& wall : planes)
      if (wall.piece == plane.overhangs[e].closed_by && wall.normal.dot(owner - wall.point) < -beyond) return true;
  }
  return false;
}

/// Images of all points within `range` [m] of a plane, on its inner side. The planes are treated one after the other,
/// so that images of images fill corners. owners: places of the last points as far as belongs_behind_corner() asks for
/// them; by default they are those of the points.
template <int D>
Images<D> make_images(std::span<const Vec<D>> points, std::span<const ImagePlane<D>> planes, double range,
                      std::span<const Vec<D>> owners = {});

/// Further places whose surroundings a rank needs that has the particles at `position` [m] and makes images of all that
/// it knows. Where an image of a particle acts on a particle of this rank, the reflection or translation that makes the
/// image, undone, takes the latter to a place that is as near to the former as the image is. At a plane mirror the
/// particle itself is nearer still, unless it is on the outer side of the plane, beyond the end of a wall. range [m]:
/// as for make_images.
template <int D>
VecArray<D> places_that_see_images(std::span<const ImagePlane<D>> planes, double range,
                                   std::span<const Vec<D>> position);

/// Mirrors a point back that passed through a mirror (if the mirror has an end: by less than `reach` [m]) and moves it
/// at most by `reach`. Removes its velocity [m/s] towards the mirror, relative to the mirror.
template <int D>
void keep_inside(std::span<const ImagePlane<D>> planes, double reach, Vec<D>& x, Vec<D>& v) {
  for (const auto& plane : planes) {
    if (plane.kind != ImagePlane<D>::Kind::mirror) continue;
    const double distance = plane.normal.dot(x - plane.point);
    const bool endless = plane.to <= plane.from;
    if (distance >= 0.0 || (distance < -reach && !endless) || !plane.faces(x)) continue;
    if (belongs_behind_corner(planes, plane, x, x, reach)) continue;
    const double turning = plane.spin * plane.tangent.dot(x - plane.point);  // m/s
    x += (std::min(-distance, reach) - distance) * plane.normal;
    v -= std::min(0.0, plane.normal.dot(v) - plane.speed - turning) * plane.normal;
  }
}

}  // namespace poretwin::sph
