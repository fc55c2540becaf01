// The surface of soil in 3D: facets of all soils, and the parts of them that are the border of the soil as a whole.
#pragma once

#include "common/case/case.hpp"
#include "common/geometry/triangle_mesh.hpp"

#include <optional>
#include <vector>

namespace poretwin {

class SoilSurface {
 public:
  /// spacing [m]: of the points in the soil; facets of curved surfaces depart from the surfaces by a hundredth of it.
  SoilSurface(const Case& scene, double spacing);

  /// Facets of all soils. They may cross and coincide where soils touch.
  [[nodiscard]] const TriangleMesh& facets() const { return *mesh_; }
  /// Whether the soil ends at a place of the surface [m] with this outward normal (unit): soil lies on the inner side
  /// of the place, but not on the outer side.
  [[nodiscard]] bool is_border(const Point3& x, const Point3& outwards) const;

  /// Whether a place [m] on the plane of a facet is open: the soil ends there, or, beside a curved surface from which
  /// the plane departs, a quarter of a spacing farther out.
  [[nodiscard]] bool is_open(const Point3& x, const Point3& outwards) const;

  struct Place {
    Point3 at = Point3::Zero(), outwards = Point3::Zero();  ///< m; unit
  };
  /// Places of the soil's border, about a given distance [m] apart.
  [[nodiscard]] std::vector<Place> places(double apart) const;
  /// Number of the soil that ends at a place of the border.
  [[nodiscard]] std::size_t soil_of(const Place& place) const;

 private:
  /// The soil at a place; nullptr: none.

  const Case& scene_;
  double spacing_;
  std::optional<TriangleMesh> mesh_;
};

/// Whether a face covers a place of the soil's border (3D): the place is on the face's plane, if it has one, with the
/// plane's normal against `outwards`, and within its shape, if it has one. slack [m]: tolerance of these distances.
bool lies_along(const Face& face, const SoilSurface::Place& place, double slack);

/// The upper end of a face above the place `from`: the highest place of the soil's border along the face within a
/// distance [m] of `from`, along the steepest way up the facet of `from`.
Point3 upper_end(const SoilSurface& surface, const Face& face, const SoilSurface::Place& from, const Point3& up,
                 double distance, double slack);

}  // namespace poretwin
