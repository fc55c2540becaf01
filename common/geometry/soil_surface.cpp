#include "common/geometry/soil_surface.hpp"

#include "common/geometry/shapes.hpp"
#include "common/geometry/solid.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace poretwin {
namespace {

/// Distance from a facet, in spacings, at which the code looks for soil. It is larger than rounding errors and gaps
/// between shapes drawn with rounded coordinates, and smaller than the distance of facets from curved surfaces.
constexpr double beside = 1e-3;

}  // namespace

SoilSurface::SoilSurface(const Case& scene, double spacing) : scene_(scene), spacing_(spacing) {
  Triangles all;
  const auto add = [&](const Triangles& part, bool turned) {
    const auto first = static_cast<Index>(all.points.size());
    all.points.insert(all.points.end(), part.points.begin(), part.points.end());
    for (const auto& [a, b, c] : part.facets)
      all.facets.push_back(turned ? Facet{first + a, first + c, first + b} : Facet{first + a, first + b, first + c});
  };
  for (const auto& soil : scene.soils) {
    if (soil.shape.solid)
      for (const auto& part : soil.shape.solid->parts()) add(part.mesh.triangles(), part.cut_out);
    else
      add(surface_of(soil.shape, spacing, {}), false);
  }
  mesh_.emplace(std::move(all));
}

bool SoilSurface::is_border(const Point3& x, const Point3& outwards) const {
  const Point3 step = beside * spacing_ * outwards;
  return soil_at(scene_, x - step) && !soil_at(scene_, x + step);
}

bool SoilSurface::is_open(const Point3& x, const Point3& outwards) const {
  const Point3 step = beside * spacing_ * outwards;
  const Soil *inner = soil_at(scene_, x - step), *outer = soil_at(scene_, x + step);
  if (inner && !outer) return true;
  if (inner && inner != outer) return false;  // where two soils touch, even if the second one is thin here
  constexpr double before = 0.25;  // spacings; within a cell curved surfaces depart less from their tangent plane
  return !soil_at(scene_, x + before * spacing_ * outwards);
}

std::vector<SoilSurface::Place> SoilSurface::places(double apart) const {
  std::vector<Place> found;
  const auto& triangles = mesh_->triangles();
  for (Index f = 0; f < mesh_->size(); ++f) {
    const auto& [i, j, k] = triangles.facets[f];
    const Point3 a = triangles.points[i], u = triangles.points[j] - a, v = triangles.points[k] - a;
    const double longest = std::max({u.norm(), v.norm(), (u - v).norm()});
    const int parts = std::max(1, static_cast<int>(std::ceil(longest / apart)));
    // Lines parallel to its sides divide the facet into small triangles, whose centres are the places.
    for (int p = 0; p < parts; ++p)
      for (int q = 0; p + q < parts; ++q)
        for (const double third : {1.0 / 3.0, 2.0 / 3.0}) {
          if (third > 0.5 && p + q + 1 >= parts) continue;
          const Point3 x = a + (p + third) / parts * u + (q + third) / parts * v;
          if (is_border(x, mesh_->normal(f))) found.push_back({x, mesh_->normal(f)});
        }
  }
  return found;
}

std::size_t SoilSurface::soil_of(const Place& place) const {
  return static_cast<std::size_t>(soil_at(scene_, place.at - beside * spacing_ * place.outwards) - scene_.soils.data());
}

bool lies_along(const Face& face, const SoilSurface::Place& place, double slack) {
  constexpr double parallel = 0.999;
  if (!face.normal.isZero()) {
    const Point3 normal = face.normal.normalized();
    if (normal.dot(place.outwards) > -parallel || std::abs(normal.dot(place.at - face.point)) > slack) return false;
  }
  return !face.within || contains(*face.within, place.at, 3);
}

Point3 upper_end(const SoilSurface& surface, const Face& face, const SoilSurface::Place& from, const Point3& up,
                 double distance, double slack) {
  const Point3 way = up - up.dot(from.outwards) * from.outwards;
  if (way.norm() < 1e-9) return from.at;
  const Point3 direction = way.normalized();
  const auto there = [&](double s) {
    const SoilSurface::Place place{from.at + s * direction, from.outwards};
    return surface.is_border(place.at, place.outwards) && lies_along(face, place, slack);
  };
  double in = 0.0, out = distance;
  if (there(out)) return from.at + out * direction;
  while (out - in > 0.1 * slack) (there(0.5 * (in + out)) ? in : out) = 0.5 * (in + out);
  return from.at + in * direction;
}

}  // namespace poretwin
