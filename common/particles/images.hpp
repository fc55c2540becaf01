// Images of particles behind straight boundaries: mirrored at walls, shifted at periodic sides.
// A wall by images is exact for a plane and needs no dummy particles; corners come from images of images.
#pragma once

#include "common/core/vector.hpp"

#include <algorithm>
#include <array>
#include <span>

namespace poretwin::sph {

/// A straight boundary piece that makes images of the particles near it.
template <int D>
struct ImagePlane {
  enum class Kind { mirror, periodic };
  Kind kind = Kind::mirror;
  Vec<D> point = Vec<D>::Zero();   ///< any point of the plane [m]
  Vec<D> normal = Vec<D>::Zero();  ///< unit, into the domain
  Vec<D> shift = Vec<D>::Zero();   ///< periodic only: translation of the image [m]
  /// Extent: only particles whose coordinate along `tangent` lies in [from, to] (3D: all) have images; unbounded by
  /// default.
  Vec<D> tangent = Vec<D>::Zero();
  double from = 0.0, to = 0.0;
  /// Where images are divided at a corner (meet_at_corners), those beyond the bisector are the next piece's:
  /// out . (x - at) > 0. No such end: out is zero.
  struct End {
    Vec<D> at = Vec<D>::Zero(), out = Vec<D>::Zero();
  };
  std::array<End, 2> ends{};
  double speed = 0.0;  ///< of a mirror along its normal [m/s]: a piston
  int boundary = 0;    ///< the solver's own number of the boundary, 0..31
  /// Where points see only what no wall hides (sight.hpp): the piece's number as what stands in the way, on both sides
  /// the same; -1: none. Its own extent along `tangent` [m], and whether at its start the piece before it counts.
  int screen = -1;
  double seen_from = 0.0, seen_to = 0.0;
  bool back = false, taken = false;  ///< back: the far side of a wall that is a line
  [[nodiscard]] Vec<D> at(double along) const { return point + (along - tangent.dot(point)) * tangent; }
  /// Does the piece lie across from x, within its extent?
  [[nodiscard]] bool faces(const Vec<D>& x) const {
    if (to <= from) return true;
    const double along = tangent.dot(x);
    return along >= from && along <= to;
  }
};

/// Images, in the order made; parent is the index of a real particle; v_image = map v + carried for velocities, map v
/// for other vectors.
template <int D>
struct Images {
  VecArray<D> position;
  std::vector<Index> parent;
  MatArray<D> map;
  VecArray<D> carried;                    ///< m/s, from mirrors that move
  std::vector<std::uint32_t> boundaries;  ///< bit b: reached through boundary b
  /// Only where images are made in all orders of mirrors: the plane by which an image was made, and the point of which
  /// it was made, images counted behind the points.
  std::vector<Index> by, of;
  [[nodiscard]] std::size_t size() const { return parent.size(); }
};

/// Images of every point within `range` [m] of a plane (of its inner side), planes taken in turn so that corners are
/// filled.
template <int D>
Images<D> make_images(std::span<const Vec<D>> points, std::span<const ImagePlane<D>> planes, double range);

/// A point that slipped through a mirror, by less than `reach` [m] where the mirror ends somewhere, is mirrored back,
/// by `reach` at most; its velocity towards the mirror [m/s] is stopped.
template <int D>
void keep_inside(std::span<const ImagePlane<D>> planes, double reach, Vec<D>& x, Vec<D>& v) {
  for (const auto& plane : planes) {
    if (plane.kind != ImagePlane<D>::Kind::mirror) continue;
    const double distance = plane.normal.dot(x - plane.point);
    const bool endless = plane.to <= plane.from;
    if (distance >= 0.0 || (distance < -reach && !endless) || !plane.faces(x)) continue;
    x += (std::min(-distance, reach) - distance) * plane.normal;
    v -= std::min(0.0, plane.normal.dot(v) - plane.speed) * plane.normal;
  }
}

}  // namespace poretwin::sph
