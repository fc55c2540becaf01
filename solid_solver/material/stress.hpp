// Symmetric second-order tensors in six components, in the same form in 2D (plane strain, zz is computed) and 3D.
// Compression is negative.
#pragma once

#include "common/core/lanes.hpp"
#include "common/core/vector.hpp"

#include <cmath>
#include <utility>

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

/// Square root of the second invariant of the deviator; of one tensor or of four (Number: double or Lanes).
template <class Number>
[[gnu::always_inline]] inline void root_j2(const Number* t, Number& root) {
  const Number mean = (t[0] + t[1] + t[2]) / 3.0, x = t[0] - mean, y = t[1] - mean, z = t[2] - mean;
  root = 0.5 * (x * x + y * y + z * z + 2.0 * (t[3] * t[3] + t[4] * t[4] + t[5] * t[5]));
  sqrt_in_place(root);
}
inline double root_j2(const Tensor& t) {
  double root = 0.0;
  root_j2(t.data(), root);
  return root;
}

/// The largest and the smallest principal stress [Pa].
std::pair<double, double> extreme_stresses(const Tensor& t);

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

/// Sets the in-plane block.
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

/// Index of the component ab of a symmetric tensor.
constexpr int component(int a, int b) {
  constexpr int places[3][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}};
  return places[a][b];
}

/// Symmetric part of a velocity gradient L_ab = d v_a / d x_b, given by columns (Eq. (88), with both derivatives), of
/// one particle or of four (Number: double or Lanes).
template <int D, class Number>
[[gnu::always_inline]] inline void strain_rate(const Number* gradient, Number* rate) {
  for (int c = 0; c < 6; ++c) rate[c] = Number{};
  for (int a = 0; a < D; ++a)
    for (int b = a; b < D; ++b) rate[component(a, b)] = 0.5 * (gradient[a + D * b] + gradient[b + D * a]);
}

template <int D>
Tensor strain_rate(const Mat<D>& gradient) {
  double rate[6];
  strain_rate<D>(gradient.data(), rate);
  Tensor t;
  t << rate[0], rate[1], rate[2], rate[3], rate[4], rate[5];
  return t;
}

/// Rotation part of the Jaumann rate in Eq. (86): W sigma - sigma W with the spin W of Eq. (89), of one particle or of
/// four.
template <int D, class Number>
[[gnu::always_inline]] inline void spin_rate(const Number* stress, const Number* gradient, Number* rate) {
  for (int c = 0; c < 6; ++c) rate[c] = Number{};
  for (int c = 0; c < D; ++c)
    for (int d = 0; d < D; ++d) {
      if (c == d) continue;
      const Number spin = 0.5 * (gradient[c + D * d] - gradient[d + D * c]);  // W_cd
      // Contributions to W sigma in row c and to -sigma W in column d.
      for (int b = 0; b < D; ++b) {
        const Number part = spin * stress[component(d, b)];
        rate[component(c, b)] += b == c ? 2.0 * part : part;
      }
    }
}

}  // namespace poretwin::solid
