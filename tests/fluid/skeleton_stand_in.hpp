// A skeleton for coupling tests: an elastic column in y by finite differences, with the same exchange as the solid
// solver.
#pragma once

#include "common/coupling/exchange.hpp"

#include <cmath>
#include <cstddef>
#include <functional>
#include <numbers>
#include <vector>

namespace poretwin::fluid::test {

struct ElasticColumn {
  double height = 0.2;    // m
  double spacing = 0.01;  // m
  double modulus = 4e6;   // Pa
  double solid_fraction = 0.6;
  double grain_density = 2600.0;
  double conductivity = 1e-4;
  double load = 1000.0;  // Pa, on top
  double weight_density = 9810.0;
  std::vector<double> u, v, mean, extra, old_p;
  std::vector<double> water;    // N/m3, pressure and drag at the end of the last window
  double extra_momentum = 0.0;  // N s per m2 of cross-section beyond the drag impulse, last window
  std::uint64_t substeps = 0;
  static constexpr std::size_t followed = 4;  // largest number of substeps per window with waves resolved

  void start() {
    const auto n = static_cast<std::size_t>(std::lround(height / spacing));
    spacing = height / static_cast<double>(n);
    u.assign(n, 0.0);
    v = mean = extra = old_p = water = u;
  }
  double density() const { return solid_fraction * grain_density; }
  double at(std::size_t i) const { return (static_cast<double>(i) + 0.5) * spacing; }
  /// Force of stress and load, N/m3.
  std::vector<double> force() const {
    const std::size_t n = u.size();
    std::vector<double> sigma(n + 1), f(n);
    sigma[0] = modulus * u[0] / (0.5 * spacing);
    for (std::size_t i = 1; i < n; ++i) sigma[i] = modulus * (u[i] - u[i - 1]) / spacing;
    sigma[n] = -load;
    for (std::size_t i = 0; i < n; ++i) f[i] = (sigma[i + 1] - sigma[i]) / spacing;
    return f;
  }
  /// Force including the water's, N/m3.
  std::vector<double> unbalanced() const {
    auto f = force();
    for (std::size_t i = 0; i < f.size(); ++i) f[i] += water[i];
    return f;
  }
  double settlement() const { return -u.back() - load / modulus * -0.5 * spacing; }

  /// Solves (mass - stiffness d2/dy2) v = impulse for v, zero half a spacing below the first point, free at the top.
  static std::vector<double> solved(std::vector<double> impulse, double mass, double stiffness) {
    const std::size_t n = impulse.size();
    std::vector<double> upper(n), v(n);
    for (std::size_t i = 0; i < n; ++i) {
      const double below = i > 0 ? stiffness : 0.0, above = i + 1 < n ? stiffness : 0.0;
      const double diagonal = mass + (i > 0 ? below : 2.0 * stiffness) + above - (i > 0 ? below * upper[i - 1] : 0.0);
      upper[i] = above / diagonal;
      impulse[i] = (impulse[i] + (i > 0 ? below * impulse[i - 1] : 0.0)) / diagonal;
    }
    for (std::size_t i = n; i-- > 0;) v[i] = impulse[i] + (i + 1 < n ? upper[i] * v[i + 1] : 0.0);
    return v;
  }

  /// Advances one window; pressure, drag force per volume, predicted velocity and its change are functions of y.
  void advance(double dt, const std::function<double(double)>& p, const std::function<double(double)>& drag,
               const std::function<double(double)>& predicted, const std::function<double(double)>& change,
               double porosity) {
    const std::size_t n = u.size();
    const double R = density(), C = weight_density * porosity * porosity / conductivity, a = porosity * weight_density / 9.81 / dt;
    auto count = static_cast<std::size_t>(std::ceil(dt / (0.5 * spacing / std::sqrt(modulus / R)) - 1e-9));
    const bool rests = count > followed;  // then one step of backward Euler
    if (rests) count = 1;
    const double h = dt / static_cast<double>(count);
    // Water that moves along; departures grow linearly over the window, and their mean is to equal that at its end.
    const double whole = 2.0 * static_cast<double>(count) / static_cast<double>(count + 1), along = C * a / (a + C),
                 inertia = rests ? 0.5 * R / dt : 0.0, Z = rests ? C + inertia : whole * along;
    std::vector<double> new_p(n), ds(n), d(n), start = u, v_start = v;
    for (std::size_t i = 0; i < n; ++i) {
      new_p[i] = p(at(i));
      ds[i] = change(at(i));
      if (rests) ds[i] = (1.0 - inertia / Z) * (predicted(at(i)) - v[i]) + inertia / Z * ds[i];
      d[i] = drag(at(i));
    }
    extra.assign(n, 0.0);
    for (std::size_t step = 0; step < count; ++step) {
      const double ramp = (static_cast<double>(step) + 1.0) / static_cast<double>(count);
      std::vector<double> impulse = force();
      for (std::size_t i = 0; i < n; ++i) {
        const auto pressure = [&](std::size_t k) { return old_p[k] + ramp * (new_p[k] - old_p[k]); };
        const double below = i > 0 ? pressure(i - 1) : pressure(0),
                     above = i + 1 < n ? pressure(i + 1) : -pressure(n - 1);
        water[i] = d[i] - solid_fraction * (above - below) / (2.0 * spacing);
        impulse[i] = R * v[i] + h * (impulse[i] + water[i] + Z * (v_start[i] + ramp * ds[i]));
      }
      v = solved(impulse, R + h * Z, rests ? h * h * modulus / (spacing * spacing) : 0.0);
      for (std::size_t i = 0; i < n; ++i) {
        extra[i] += h * (rests ? along : Z) * (v_start[i] + ramp * ds[i] - v[i]);
        u[i] += h * v[i];
      }
      ++substeps;
    }
    old_p = new_p;
    extra_momentum = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      mean[i] = (u[i] - start[i]) / dt;
      extra_momentum += extra[i] * spacing;
    }
  }

  /// Linear interpolation at y, linear beyond the ends; zero_at_base: the value at y = 0 is zero.
  double sample(const std::vector<double>& values, double y, bool zero_at_base) const {
    const double s = y / spacing - 0.5;
    const auto n = static_cast<std::ptrdiff_t>(values.size());
    auto i = static_cast<std::ptrdiff_t>(std::floor(s));
    if (i < 0 && zero_at_base) return values[0] * y / (0.5 * spacing);
    i = std::min(std::max<std::ptrdiff_t>(i, 0), n - 2);
    const double w = s - static_cast<double>(i);
    return (1.0 - w) * values[static_cast<std::size_t>(i)] + w * values[static_cast<std::size_t>(i + 1)];
  }
};

/// Terzaghi's degree of consolidation, and his base pressure over the load, at the time factor T.
inline double terzaghi_consolidation(double T) {
  double sum = 0.0;
  for (int m = 0; m < 200; ++m) {
    const double M = 0.5 * std::numbers::pi * (2 * m + 1);
    sum += 2.0 / (M * M) * std::exp(-M * M * T);
  }
  return 1.0 - sum;
}
inline double terzaghi_base_pressure(double T) {
  double sum = 0.0;
  for (int m = 0; m < 200; ++m) {
    const double M = 0.5 * std::numbers::pi * (2 * m + 1);
    sum += 2.0 / M * (m % 2 == 0 ? 1.0 : -1.0) * std::exp(-M * M * T);
  }
  return sum;
}

}  // namespace poretwin::fluid::test
