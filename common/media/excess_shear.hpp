// Erosion in proportion to the shear stress beyond a critical one: the law of practice for cohesive dams that water
// overtops (Hanson, Cook & Hunt 2005; Temple et al. 2005).
#pragma once

#include "common/media/erosion_law.hpp"

#include <algorithm>

namespace poretwin::porous {

/// E = k_d (tau - tau_c) where tau > tau_c, otherwise 0.
inline ErosionLaw excess_shear() {
  return {"excess_shear",
          "E = k_d (tau - tau_c)",
          {{"critical_shear_stress", "Pa", "tau_c, below which nothing erodes (`excess_shear`)."},
           {"erodibility", "m3/(N s)",
            "k_d, erosion per shear stress beyond the critical one (`excess_shear`). 1 cm3/(N s) is 1e-6 m3/(N s).",
            0.0, true}},
          [](double shear_stress, std::span<const double> p) { return p[1] * std::max(0.0, shear_stress - p[0]); }};
}

}  // namespace poretwin::porous
