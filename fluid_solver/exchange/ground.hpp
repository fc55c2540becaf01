// The soil as the case draws it, at rest: which soil lies at a place, and the soil's properties for the water.
#pragma once

#include "common/core/vector.hpp"
#include "common/geometry/shapes.hpp"
#include "common/media/anisotropy.hpp"
#include "common/media/seepage.hpp"

#include <optional>
#include <vector>

namespace poretwin::fluid {

template <int D>
Point3 to_point3(const Vec<D>& x) {
  Point3 p = Point3::Zero();
  p.head<D>() = x;
  return p;
}

/// One soil of the case.
struct Stratum {
  int number = 0;                   ///< index in the case
  double porosity = 0.0;            ///< n
  double fillable_porosity = 0.0;   ///< n (1 - s_r0): volume fraction that water can fill; the residual water of moist
                                    ///< soil moves with the grains
  double initial_saturation = 0.0;  ///< s_r0
  double suction_head = 0.0;        ///< m, suction head at a wetting front
  double critical_gradient = 0.0;   ///< gradient at which water that leaves upwards lifts the grains
  porous::Seepage seepage;          ///< law of seepage at this porosity
  porous::Resistance resistance;    ///< resistance to water that fills the fillable porosity
};

template <int D>
class Ground {
 public:
  explicit Ground(const Case& scene)
      : specific_weight_(porous::specific_weight(scene)), contrast_(porous::conductivity_contrast(scene)) {
    for (const auto& soil : scene.soils) {
      Stratum s;
      s.number = static_cast<int>(strata_.size());
      s.porosity = soil.porosity;
      s.fillable_porosity = soil.porosity * (1.0 - soil.initial_saturation);
      s.initial_saturation = soil.initial_saturation;
      s.suction_head = soil.suction_head;
      s.critical_gradient = porous::critical_gradient(scene, soil);
      s.seepage = porous::seepage_at(scene, soil, soil.porosity);
      s.resistance = porous::resistance(specific_weight_, s.fillable_porosity, s.seepage);
      strata_.push_back(s);
      shapes_.push_back(soil.shape);
    }
    if (!scene.soils.empty() && porous::is_anisotropic(scene.soils.front()))
      beds_ = porous::relative_conductivity(scene, scene.soils.front()).topLeftCorner<D, D>();
  }

  /// The soil at a place (where several overlap, the first); nullptr where there is no soil.
  [[nodiscard]] const Stratum* at(const Vec<D>& x) const {
    const Point3 p = to_point3<D>(x);
    for (std::size_t i = 0; i < shapes_.size(); ++i)
      if (contains(shapes_[i], p, D)) return &strata_[i];
    return nullptr;
  }
  /// Suction of the soil at a place [Pa].
  [[nodiscard]] double suction(const Vec<D>& x) const {
    const auto* here = at(x);
    return here ? specific_weight_ * here->suction_head : 0.0;
  }
  [[nodiscard]] const std::vector<Stratum>& strata() const { return strata_; }
  /// Specific weight of water [N/m3] to which the case's `conductivity` refers.
  [[nodiscard]] double specific_weight() const { return specific_weight_; }
  /// Tensor of conductivity of soil in beds over the conductivity along the beds, the same for all soils of a case;
  /// empty: the soils have no beds.
  [[nodiscard]] const std::optional<Mat<D>>& beds() const { return beds_; }
  /// Flux through a plane with this unit normal under a gradient of the head, over the conductivity along the beds.
  [[nodiscard]] double through(const Vec<D>& normal, const Vec<D>& gradient) const {
    return beds_ ? normal.dot(*beds_ * gradient) : normal.dot(gradient);
  }
  /// The same under a gradient of 1 along the normal.
  [[nodiscard]] double through(const Vec<D>& normal) const { return beds_ ? through(normal, normal) : 1.0; }
  /// Ratio of the largest to the smallest conductivity of the soils.
  [[nodiscard]] double contrast() const { return contrast_; }

 private:
  std::vector<Stratum> strata_;
  std::vector<Shape> shapes_;
  std::optional<Mat<D>> beds_;
  double specific_weight_ = 0.0, contrast_ = 1.0;
};

}  // namespace poretwin::fluid
