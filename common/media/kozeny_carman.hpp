// Linear Darcy flow with a conductivity that depends on the porosity.
#pragma once

#include "common/media/seepage_law.hpp"

namespace poretwin::porous {

/// n^3 / (1 - n)^2, Eq. (19), with the porosity n.
inline double kozeny_carman_shape(double n) { return n * n * n / ((1.0 - n) * (1.0 - n)); }

/// k by Eq. (19), from the conductivity given at the soil's own porosity.
inline SeepageLaw kozeny_carman() {
  return {"kozeny_carman", "i = U/k, k after Eq. (19)", [](const Medium& m) {
            return Seepage{m.conductivity * kozeny_carman_shape(m.porosity) / kozeny_carman_shape(m.own_porosity), 0.0};
          }};
}

}  // namespace poretwin::porous
