// Smoothing kernels. The dimension is a template parameter. The support radius of both kernels is 2 h.
#pragma once

#include <cmath>
#include <numbers>

namespace poretwin::sph {

/// Radius of support in units of the smoothing length.
inline constexpr double support_radius = 2.0;

/// Cubic spline (Monaghan & Lattanzio 1985), the kernel of Bui & Nguyen (2017) for Eq. (47).
template <int D>
struct CubicSpline {
  static constexpr double normalisation(double h) {
    if constexpr (D == 1) return 2.0 / (3.0 * h);
    if constexpr (D == 2) return 10.0 / (7.0 * std::numbers::pi * h * h);
    return 1.0 / (std::numbers::pi * h * h * h);
  }
  /// W(r, h) [1/m^D].
  static double value(double r, double h) {
    const double q = r / h;
    if (q >= 2.0) return 0.0;
    const double u = 2.0 - q;
    return normalisation(h) * (q < 1.0 ? 1.0 - 1.5 * q * q + 0.75 * q * q * q : 0.25 * u * u * u);
  }
  /// W'(r, h) / r [1/m^(D+2)], never positive, finite at r = 0: grad W = derivative_over_r * (r_a - r_b).
  static double derivative_over_r(double r, double h) {
    const double q = r / h;
    if (q >= 2.0) return 0.0;
    const double u = 2.0 - q;
    return normalisation(h) / (h * h) * (q < 1.0 ? -3.0 + 2.25 * q : -0.75 * u * u / q);
  }
};

/// Wendland C2 (Wendland 1995), which causes no pairing of particles; the default.
template <int D>
struct WendlandC2 {
  static_assert(D == 2 || D == 3);
  static constexpr double normalisation(double h) {
    if constexpr (D == 2) return 7.0 / (4.0 * std::numbers::pi * h * h);
    return 21.0 / (16.0 * std::numbers::pi * h * h * h);
  }
  /// W(r, h) [1/m^D].
  static double value(double r, double h) {
    const double q = r / h;
    if (q >= 2.0) return 0.0;
    const double u = 1.0 - 0.5 * q;
    return normalisation(h) * u * u * u * u * (2.0 * q + 1.0);
  }
  /// W'(r, h) / r [1/m^(D+2)], never positive, finite at r = 0: grad W = derivative_over_r * (r_a - r_b).
  static double derivative_over_r(double r, double h) {
    const double q = r / h;
    if (q >= 2.0) return 0.0;
    const double u = 1.0 - 0.5 * q;
    return -5.0 * normalisation(h) / (h * h) * u * u * u;
  }
  /// Value and -W'/r together.
  struct Pair {
    double value, strength;
  };
  static Pair pair(double r, double h) {
    const double inverse = 1.0 / h, q = r * inverse;
    if (q >= 2.0) return {0.0, 0.0};
    const double u = 1.0 - 0.5 * q, scaled = normalisation(1.0) * (D == 2 ? 1.0 : inverse) * inverse * inverse;
    return {scaled * u * u * u * u * (2.0 * q + 1.0), 5.0 * scaled * inverse * inverse * u * u * u};
  }
};

}  // namespace poretwin::sph
