#include "common/particles/images.hpp"

#include <cmath>

namespace poretwin::sph {

template <int D>
Images<D> make_images(std::span<const Vec<D>> points, std::span<const ImagePlane<D>> planes, double range,
                      std::span<const Vec<D>> owners) {
  Images<D> images;
  const std::size_t without_owner = points.size() - owners.size();
  const double rounding = 1e-9 * range;
  auto add = [&](const ImagePlane<D>& plane, const Vec<D>& x, Index parent, const Mat<D>& map, const Vec<D>& carried,
                 std::uint32_t bits) {
    const double distance = plane.normal.dot(x - plane.point);
    if (distance < 0.0 || distance > range || !plane.faces(x)) return;
    const Vec<D>& owner = parent < without_owner ? points[parent] : owners[parent - without_owner];
    if (belongs_behind_corner(planes, plane, x, owner, rounding)) return;
    const bool mirror = plane.kind == ImagePlane<D>::Kind::mirror;
    const Vec<D> image = mirror ? Vec<D>(x - 2.0 * distance * plane.normal) : Vec<D>(x + plane.shift);
    for (const auto& end : plane.ends)
      if (end.out.dot(image - end.at) > 0.0) return;
    Mat<D> own = Mat<D>::Identity();
    if (mirror) own -= 2.0 * plane.normal * plane.normal.transpose();
    images.position.push_back(image);
    images.parent.push_back(parent);
    images.map.push_back(own * map);
    images.carried.push_back(own * carried + 2.0 * plane.speed * plane.normal);
    images.boundaries.push_back(bits | (1u << plane.boundary));
  };
  // An image shifted out through one periodic side is never shifted back through the opposite side: if it lies on that
  // side, it would coincide with its original.
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
      add(plane, points[i], static_cast<Index>(i), Mat<D>::Identity(), Vec<D>::Zero(), 0u);
    for (std::size_t k = 0; k < made; ++k)
      if (!shifted_back(k, plane))
        add(plane, Vec<D>(images.position[k]), images.parent[k], Mat<D>(images.map[k]), Vec<D>(images.carried[k]),
            images.boundaries[k]);
    made_by.resize(images.size(), p);
  }
  return images;
}

template <int D>
VecArray<D> places_that_see_images(std::span<const ImagePlane<D>> planes, double range,
                                   std::span<const Vec<D>> position) {
  VecArray<D> views;
  for (std::size_t k = planes.size(); k-- > 0;) {  // images are made in the order of the planes
    const auto& plane = planes[k];
    const bool periodic = plane.kind == ImagePlane<D>::Kind::periodic;
    const auto undo = [&](const Vec<D>& x) {
      const double distance = plane.normal.dot(x - plane.point);
      if (!periodic && distance >= 0.0) return;
      const Vec<D> seen = periodic ? Vec<D>(x - plane.shift) : Vec<D>(x - 2.0 * distance * plane.normal);
      // Images are made of particles within range of the plane.
      if (std::abs(plane.normal.dot(seen - plane.point)) <= 2.0 * range) views.push_back(seen);
    };
    const std::size_t before = views.size();
    for (const auto& x : position) undo(x);
    for (std::size_t v = 0; v < before; ++v) undo(Vec<D>(views[v]));
  }
  return views;
}

template VecArray<2> places_that_see_images(std::span<const ImagePlane<2>>, double, std::span<const Vec<2>>);
template VecArray<3> places_that_see_images(std::span<const ImagePlane<3>>, double, std::span<const Vec<3>>);
template Images<2> make_images<2>(std::span<const Vec<2>>, std::span<const ImagePlane<2>>, double,
                                  std::span<const Vec<2>>);
template Images<3> make_images<3>(std::span<const Vec<3>>, std::span<const ImagePlane<3>>, double,
                                  std::span<const Vec<3>>);

}  // namespace poretwin::sph
