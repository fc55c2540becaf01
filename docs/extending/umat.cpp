// A user's own model as a shared library: undrained clay, elastic and perfectly plastic after von
// Mises. PROPS: Young's modulus [Pa], Poisson's ratio, shear strength [Pa]. STATEV(1): equivalent plastic strain.
//
//   c++ -O2 -shared -fPIC -o my_soil.so umat.cpp
#include <cmath>
#include <cstddef>

extern "C" void umat_(double* stress, double* statev, double* ddsdde, double* /*sse*/, double* /*spd*/, double* /*scd*/,
                      double* /*rpl*/, double* /*ddsddt*/, double* /*drplde*/, double* /*drpldt*/,
                      const double* /*stran*/, const double* dstran, const double* /*time*/, const double* /*dtime*/,
                      const double* /*temp*/, const double* /*dtemp*/, const double* /*predef*/,
                      const double* /*dpred*/, const char* /*cmname*/, const int* /*ndi*/, const int* /*nshr*/,
                      const int* ntens, const int* /*nstatv*/, const double* props, const int* /*nprops*/,
                      const double* /*coords*/, const double* /*drot*/, double* /*pnewdt*/, const double* /*celent*/,
                      const double* /*dfgrd0*/, const double* /*dfgrd1*/, const int* /*noel*/, const int* /*npt*/,
                      const int* /*layer*/, const int* /*kspt*/, const int* /*kstep*/, const int* /*kinc*/,
                      std::size_t /*length of cmname*/) {
  const double shear = props[0] / (2.0 * (1.0 + props[1])), strength = props[2];
  const double lame = props[0] * props[1] / ((1.0 + props[1]) * (1.0 - 2.0 * props[1]));
  // Elastic tangent. Components 11 22 33 12 13 23, tension positive, shear strains as gamma.
  for (int i = 0; i < *ntens; ++i)
    for (int j = 0; j < *ntens; ++j)
      ddsdde[i + *ntens * j] = (i < 3 && j < 3 ? lame : 0.0) + (i != j ? 0.0 : i < 3 ? 2.0 * shear : shear);
  for (int i = 0; i < *ntens; ++i)
    for (int j = 0; j < *ntens; ++j) stress[i] += ddsdde[i + *ntens * j] * dstran[j];
  const double mean = (stress[0] + stress[1] + stress[2]) / 3.0;
  double j2 = 0.0;
  for (int i = 0; i < *ntens; ++i) j2 += i < 3 ? 0.5 * (stress[i] - mean) * (stress[i] - mean) : stress[i] * stress[i];
  const double size = std::sqrt(j2);
  if (size <= strength) return;
  for (int i = 0; i < *ntens; ++i)
    stress[i] = (i < 3 ? mean : 0.0) + (stress[i] - (i < 3 ? mean : 0.0)) * strength / size;
  statev[0] += (size - strength) / (shear * std::sqrt(3.0));
}
