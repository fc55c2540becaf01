// The two parts of a case whose water is particles where it is free and a field in the soil
// (fluid.representation = "both"). Each part is a case of its own, checked and computed as any other.
#pragma once

#include "common/case/case.hpp"

namespace poretwin {

/// The soil with its water as a field. The parts of its outline that are open to free water are water faces, one for
/// each straight piece (WaterFace::free_water).
Case ground_part(const Case& scene);

/// The free water as particles, without the soil: the open parts of the soil's outline are walls, and walls end where
/// they reach the soil.
Case free_part(const Case& scene);

/// Whether some region of water lies outside the soil, in part at least.
bool has_free_water(const Case& scene);

/// Where a gauge is read.
enum class GaugePlace {
  free_water,
  ground,
  all,      ///< volumes: both parts and what passes between them
  nowhere,  ///< a kind that neither has
  astride,  ///< some of its points lie in the soil and others do not
};
GaugePlace place_of(const Case& scene, const Gauge& gauge);

}  // namespace poretwin
