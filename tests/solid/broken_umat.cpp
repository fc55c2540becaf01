// Libraries with a user's own model that fail: the stress of one is not a number from a strain of 1 % on; the other one
// (WITHOUT_FUNCTION) contains no model.
#include <cmath>
#ifndef WITHOUT_FUNCTION
extern "C" void umat_(double* stress, double*, double*, double*, double*, double*, double*, double*, double*, double*,
                      const double*, const double* dstran) {
  stress[1] += dstran[1] * 1e6;
  if (std::abs(dstran[1]) > 0.01) stress[0] = NAN;
}
#endif
