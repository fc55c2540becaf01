// Symmetric second-order tensors in six components, the same in 2D (plane strain, zz carried along) and 3D.
// Compression is negative.
#pragma once

#include "common/core/vector.hpp"

#include <cmath>

namespace poretwin::solid {

/// xx yy zz xy yz xz; shear components are tensor components (half of the engineering strain).
using Tensor = Eigen::Matrix<double, 6, 1>;

/// First invariant.
inline double trace(const Tensor& t) { return t[0] + t[1] + t[2]; }

/// a : b.
inline double contract(const Tensor& a, const Tensor& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + 2.0 * (a[3] * b[3] + a[4] * b[4] + a[5] * b[5]);
}

inline Tensor deviator(Tensor t) {
  const double mean = trace(t) / 3.0;
  for (int d = 0; d < 3; ++d) t[d] -= mean;
  return t;
}

/// Square root of the second invariant of the deviator.
inline double root_j2(const Tensor& t) {
  const Tensor s = deviator(t);
  return std::sqrt(0.5 * contract(s, s));
}

/// The in-plane block as a matrix.
template <int D>
Mat<D> matrix_of(const Tensor& t) {
  Mat<D> m;
  if constexpr (D == 2) {
    m << t[0], t[3], t[3], t[1];
  } else {
    m << t[0], t[3], t[5], t[3], t[1], t[4], t[5], t[4], t[2];
  }
  return m;
}

/// Writes the in-plane block.
template <int D>
void set_matrix(const Mat<D>& m, Tensor& t) {
  t[0] = m(0, 0);
  t[1] = m(1, 1);
  t[3] = m(0, 1);
  if constexpr (D == 3) {
    t[2] = m(2, 2);
    t[4] = m(1, 2);
    t[5] = m(0, 2);
  }
}

/// Symmetric part of a velocity gradient, L_ab = d v_a / d x_b (Eq. (88), both derivative components).
template <int D>
Tensor strain_rate(const Mat<D>& gradient) {
  Tensor t;
  auto half = [&](int a, int b) { return 0.5 * (gradient(a, b) + gradient(b, a)); };
  // All six at once, here and below: single ones written over zeros stay in memory, and a wide load of them waits.
  if constexpr (D == 2) {
    t << gradient(0, 0), gradient(1, 1), 0.0, half(0, 1), 0.0, 0.0;
  } else {
    t << gradient(0, 0), gradient(1, 1), gradient(2, 2), half(0, 1), half(1, 2), half(0, 2);
  }
  return t;
}

/// Rotation part of the Jaumann rate in Eq. (86): W sigma - sigma W with the spin W of Eq. (89).
template <int D>
Tensor spin_rate(const Tensor& s, const Mat<D>& gradient) {
  Tensor t;
  if constexpr (D == 2) {
    const double w = 0.5 * (gradient(0, 1) - gradient(1, 0)), rate = 2.0 * w * s[3];
    t << rate, -rate, 0.0, w * (s[1] - s[0]), 0.0, 0.0;
  } else {
    const Mat<3> w = 0.5 * (gradient - gradient.transpose());
    const Mat<3> m = matrix_of<3>(s);
    const Mat<3> r = w * m - m * w;
    t << r(0, 0), r(1, 1), r(2, 2), r(0, 1), r(1, 2), r(0, 2);
  }
  return t;
}

}  // namespace poretwin::solid
