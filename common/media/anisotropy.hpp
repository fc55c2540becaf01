// Soil in beds, which conducts water better along the beds than across them.
#pragma once

#include "common/case/case.hpp"

#include <algorithm>
#include <cmath>

namespace poretwin::porous {

/// Whether the conductivity of a soil along its beds differs from that across them.
inline bool is_anisotropic(const Soil& soil) { return soil.anisotropy != 1.0; }

/// Unit vector across the beds of a soil, as the case gives it, or along gravity. It is zero if the case gives no such
/// direction and has no gravity.
inline Point3 across_beds(const Case& scene, const Soil& soil) {
  return soil.bedding_normal.isZero() ? Point3(-scene.general.gravity.normalized()) : soil.bedding_normal.normalized();
}

/// The conductivity tensor of a soil over the conductivity along its beds: I - (1 - 1/a) n n^T, with the ratio a
/// (anisotropy) and the direction n across the beds.
inline Eigen::Matrix3d relative_conductivity(const Case& scene, const Soil& soil) {
  const Point3 n = across_beds(scene, soil);
  return Eigen::Matrix3d::Identity() - (1.0 - 1.0 / soil.anisotropy) * n * n.transpose();
}

/// Whether all soils of a case have the same relative conductivity.
inline bool same_anisotropy(const Case& scene) {
  constexpr double same = 1e-9;
  return std::all_of(scene.soils.begin(), scene.soils.end(), [&](const Soil& soil) {
    return (relative_conductivity(scene, soil) - relative_conductivity(scene, scene.soils.front())).norm() < same;
  });
}

}  // namespace poretwin::porous
