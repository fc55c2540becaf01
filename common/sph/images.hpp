// Images of particles behind straight boundaries: mirrored at walls, shifted at periodic sides.
// A wall by images is exact for a plane and needs no dummy particles; corners come from images of images.
#pragma once

#include "common/core/vector.hpp"

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
  int boundary = 0;  ///< the solver's own number of the boundary, 0..31
};

/// Images, in the order made; parent is the index of a real particle, map its linear part for vectors (v_image = map
/// v).
template <int D>
struct Images {
  VecArray<D> position;
  std::vector<Index> parent;
  MatArray<D> map;
  std::vector<std::uint32_t> boundaries;  ///< bit b: reached through boundary b
  [[nodiscard]] std::size_t size() const { return parent.size(); }
};

/// Images of every point within `range` [m] of a plane (of its inner side), planes taken in turn so that corners are
/// filled.
template <int D>
Images<D> make_images(std::span<const Vec<D>> points, std::span<const ImagePlane<D>> planes, double range) {
  Images<D> images;
  auto add = [&](const ImagePlane<D>& plane, const Vec<D>& x, Index parent, const Mat<D>& map, std::uint32_t bits) {
    const double distance = plane.normal.dot(x - plane.point);
    if (distance < 0.0 || distance > range) return;
    if (plane.to > plane.from) {
      const double along = plane.tangent.dot(x);
      if (along < plane.from || along > plane.to) return;
    }
    const bool mirror = plane.kind == ImagePlane<D>::Kind::mirror;
    Mat<D> own = Mat<D>::Identity();
    if (mirror) own -= 2.0 * plane.normal * plane.normal.transpose();
    images.position.push_back(mirror ? Vec<D>(x - 2.0 * distance * plane.normal) : Vec<D>(x + plane.shift));
    images.parent.push_back(parent);
    images.map.push_back(own * map);
    images.boundaries.push_back(bits | (1u << plane.boundary));
  };
  // An image shifted out through one periodic side is never shifted back through the other: on the side itself it would
  // fall on its own original.
  std::vector<std::size_t> made_by;
  auto shifted_back = [&](std::size_t k, const ImagePlane<D>& plane) {
    const ImagePlane<D>& maker = planes[made_by[k]];
    return plane.kind == ImagePlane<D>::Kind::periodic && maker.kind == ImagePlane<D>::Kind::periodic &&
           maker.normal.dot(plane.normal) < -0.5;
  };
  for (std::size_t p = 0; p < planes.size(); ++p) {
    const auto& plane = planes[p];
    const std::size_t made = images.size();
    for (std::size_t i = 0; i < points.size(); ++i)
      add(plane, points[i], static_cast<Index>(i), Mat<D>::Identity(), 0u);
    for (std::size_t k = 0; k < made; ++k)
      if (!shifted_back(k, plane))
        add(plane, Vec<D>(images.position[k]), images.parent[k], Mat<D>(images.map[k]), images.boundaries[k]);
    made_by.resize(images.size(), p);
  }
  return images;
}

}  // namespace poretwin::sph
