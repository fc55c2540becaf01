// Space stretched such that anisotropic soil conducts equally in all directions.
#pragma once

#include "common/media/anisotropy.hpp"

namespace poretwin::pore {

/// In coordinates S x with S = (K / k)^(-1/2), K the tensor of conductivity and k its value along the beds, soil is
/// isotropic (Samsioe 1931). A head that changes only along a side of a Voronoi cell made in these coordinates drives
/// no flow K grad h through the side, so that flow between two points is exact for a linear head at any arrangement of
/// the points. Soils that differ in their anisotropy have no such common coordinates; S is then the identity.
class Stretch {
 public:
  explicit Stretch(const Case& scene) {
    if (scene.soils.empty() || !porous::same_anisotropy(scene)) return;
    const Soil& soil = scene.soils.front();
    if (!porous::is_anisotropic(soil)) return;
    shared_ = true;
    const Point3 n = porous::across_beds(scene, soil);
    const Eigen::Matrix3d along = n * n.transpose();
    const double most = std::sqrt(soil.anisotropy);
    to_ = Eigen::Matrix3d::Identity() + (most - 1.0) * along;
    from_ = Eigen::Matrix3d::Identity() + (1.0 / most - 1.0) * along;
    growth_ = most;
  }
  /// From soil to stretched space, and back.
  [[nodiscard]] Point3 to(const Point3& x) const { return to_ * x; }
  [[nodiscard]] Point3 from(const Point3& x) const { return from_ * x; }
  /// growth: ratio of a volume in stretched space to that in the soil. least: least such ratio of lengths.
  [[nodiscard]] double growth() const { return growth_; }
  [[nodiscard]] double least() const { return std::min(1.0, growth_); }

  /// The plane outwards . x = deep in the soil, with x relative to a point. Returns the vector in stretched space from
  /// the point to its mirror image in this plane.
  [[nodiscard]] Point3 to_image(const Point3& outwards, double deep) const {
    const Point3 normal = from_ * outwards;
    return 2.0 * deep / normal.squaredNorm() * normal;
  }

  /// Conductivity of a soil for the flow from one point to another through the common side of their cells, over the
  /// conductivity along the beds.
  [[nodiscard]] double between(const Case& scene, const Soil& soil, const Point3& way) const {
    if (shared_) return way.norm() / (to_ * (to_ * way)).norm();
    const Point3 e = way.normalized();
    return e.dot(porous::relative_conductivity(scene, soil) * e);
  }
  /// The same ratio for the flow through a part of the border with this unit normal, for a head uniform on that part.
  [[nodiscard]] static double through(const Case& scene, const Soil& soil, const Point3& normal) {
    return normal.dot(porous::relative_conductivity(scene, soil) * normal);
  }

 private:
  bool shared_ = false;
  Eigen::Matrix3d to_ = Eigen::Matrix3d::Identity(), from_ = to_;
  double growth_ = 1.0;
};

}  // namespace poretwin::pore
