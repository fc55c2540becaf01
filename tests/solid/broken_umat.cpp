// Libraries with a user's own model that fail: one whose stress is not a number once it is strained by more than 1 %,
// and (WITHOUT_FUNCTION) one that has none.
#include <cmath>
#ifndef WITHOUT_FUNCTION
extern "C" void umat_(double* stress, double*, double*, double*, double*, double*, double*, double*, double*, double*,
                      const double*, const double* dstran) {
  stress[1] += dstran[1] * 1e6;
  if (std::abs(dstran[1]) > 0.01) stress[0] = NAN;
}
#endif
