// Gauges of soil that has flowed: position of its front, its height, noise of its stress and of its density.
#pragma once

#include "solid_solver/setup.hpp"

#include <functional>

namespace poretwin::solid {

/// Distance [m] of the soil's front from `from` along the line to `to`: the farthest place where the soil is at least
/// `thickness` [m] thick. The thickness is measured along gravity, for soil packed as it is initially. With a thickness
/// of 0 the front is the position of the outermost particle. 0 if no such place exists.
template <int D>
double front_position(const Setup<D>& setup, const State<D>& state, const Vec<D>& from, const Vec<D>& to,
                      double thickness);

/// Height [m] of the soil's surface above a point: the highest place where half of the kernel lies in soil; NaN if no
/// such place exists.
template <int D>
double surface_height(const Setup<D>& setup, const State<D>& state, const Vec<D>& x);

/// Elevation [m] of the top of the soil: of its highest particle that others touch, and half a spacing; grains in
/// flight count only where there is nothing else. `counts`: whether a place belongs to the gauge's region.
template <int D>
double crest_level(const Setup<D>& setup, const State<D>& state, const std::function<bool(const Vec<D>&)>& counts);

/// Root mean square [Pa] of the difference between the mean effective stress and its best linear fit around each
/// particle inside the soil.
template <int D>
double stress_noise(const Setup<D>& setup, const State<D>& state);

/// Root mean square of rho / rho_0 - 1 of the particles inside the soil, with the bulk density rho and its initial
/// value rho_0.
template <int D>
double density_error(const Setup<D>& setup, const State<D>& state);

}  // namespace poretwin::solid
