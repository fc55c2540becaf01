// The surface of soil in 3D: facets of all soils, and which places of them are the border of the soil as a whole.
#pragma once

#include "common/case/case.hpp"
#include "common/geometry/triangle_mesh.hpp"

#include <optional>
#include <vector>

namespace poretwin {

class SoilSurface {
 public:
  /// spacing [m]: of the points in the soil; facets of curved surfaces depart from them by a hundredth of it.
  SoilSurface(const Case& scene, double spacing);

  /// Facets of all soils; they may cross and coincide where soils touch.
  [[nodiscard]] const TriangleMesh& facets() const { return *mesh_; }
  /// Whether soil ends at a place of the surface [m] with this outward normal (unit): soil lies on its inner side, and
  /// none on its outer side.
  [[nodiscard]] bool is_border(const Point3& x, const Point3& outwards) const;

  /// Whether no soil lies on the outer side of a place near the surface [m], up to a quarter of a spacing from it.
  [[nodiscard]] bool is_open(const Point3& x, const Point3& outwards) const;

  struct Place {
    Point3 at = Point3::Zero(), outwards = Point3::Zero();  ///< m; unit
  };
  /// Places of the soil's border, about a given distance [m] apart.
  [[nodiscard]] std::vector<Place> places(double apart) const;

 private:
  [[nodiscard]] bool in_soil(const Point3& x) const;

  const Case& scene_;
  double spacing_;
  std::optional<TriangleMesh> mesh_;
};

/// Whether a face is given at a place of the soil's border (3D): on its plane, if it has one, with its normal against
/// `outwards`, and within its shape, if it has one. slack [m]: distance up to which a place counts as lying there.
bool lies_along(const Face& face, const SoilSurface::Place& place, double slack);

/// The place at which a face ends above one of its places: the highest place of the soil's border along the face that
/// is reached from there within a distance [m] along the steepest way up its facet.
Point3 upper_end(const SoilSurface& surface, const Face& face, const SoilSurface::Place& from, const Point3& up,
                 double distance, double slack);

}  // namespace poretwin
