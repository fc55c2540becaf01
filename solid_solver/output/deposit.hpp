// Readings of soil that has flowed: position of its front, height, noise of its stress and density.
#pragma once

#include "solid_solver/setup.hpp"

namespace poretwin::solid {

/// Distance [m] from `from`, along the line to `to`, of the farthest soil that is at least `thickness` [m] thick
/// (packed as at the start, measured along gravity); thickness 0: of the last particle. 0 when there is none.
template <int D>
double front_position(const Setup<D>& setup, const State<D>& state, const Vec<D>& from, const Vec<D>& to,
                      double thickness);

/// Height [m] of the soil's surface over a point: the highest place where half of the kernel lies in soil; NaN without
/// soil.
template <int D>
double surface_height(const Setup<D>& setup, const State<D>& state, const Vec<D>& x);

/// Root of the mean square [Pa] of the mean effective stress against the linear field that fits it best around each
/// particle inside the soil.
template <int D>
double stress_noise(const Setup<D>& setup, const State<D>& state);

/// Root of the mean square of rho / rho_0 - 1 over the particles inside the soil.
template <int D>
double density_error(const Setup<D>& setup, const State<D>& state);

}  // namespace poretwin::solid
