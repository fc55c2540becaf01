// Rotations of plates that tilt, in the plane of a 2D case. In 3D no plate tilts, and nothing turns.
#pragma once

#include "common/core/vector.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace poretwin::solid {

/// Rotation by an angle [rad], counter-clockwise.
template <int D>
Mat<D> rotation(double angle) {
  Mat<D> turned = Mat<D>::Identity();
  if constexpr (D == 2) turned << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  return turned;
}

/// Velocity gradient [1] of a rotation at a unit rate.
template <int D>
Mat<D> spinning() {
  Mat<D> gradient = Mat<D>::Zero();
  if constexpr (D == 2) gradient << 0.0, -1.0, 1.0, 0.0;
  return gradient;
}

/// Moment of a force at the arm `arm`, counter-clockwise.
template <int D>
double moment_of(const Vec<D>& arm, const Vec<D>& force) {
  return force.dot(spinning<D>() * arm);
}

/// Which of `n` equal parts of a plate of the length `length` [m] lies `along` [m] from its first point; the nearest
/// one beyond its ends.
inline std::size_t part_at(std::size_t n, double length, double along) {
  const double part = std::floor(along / length * static_cast<double>(n));
  return static_cast<std::size_t>(std::clamp(part, 0.0, static_cast<double>(n - 1)));
}

}  // namespace poretwin::solid
