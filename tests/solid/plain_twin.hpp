// The pair loops of the soil in their simplest form: every particle visits every node, and pairs are not shared. The
// fast loops are compared with them.
#pragma once

#include "solid_solver/discretisation/operators.hpp"
#include "solid_solver/setup.hpp"

namespace poretwin::solid {

template <int D>
struct TwinResult {
  VecArray<D> internal, stabilising;  ///< N/m3
  MatArray<D> gradient;               ///< 1/s
};

/// Computed from the present nodes.
template <int D>
TwinResult<D> plain_twin(const Setup<D>& setup, const State<D>& state) {
  const auto& s = setup.stabilisers;
  const double h = setup.smoothing_length;
  TwinResult<D> out;
  const std::size_t n = state.particles.size();
  const auto displacement = [&](std::size_t i) {
    return i < n ? state.particles.displacement[i] : state.near.images[i - n].displacement;
  };
  for (std::size_t i = 0; i < state.particles.size(); ++i) {
    const Node<D>& a = state.nodes[i];
    Vec<D> internal = Vec<D>::Zero(), viscous = Vec<D>::Zero();
    Mat<D> raw = Mat<D>::Zero(), moment = Mat<D>::Zero();
    for (std::size_t j = 0; j < state.nodes.size(); ++j) {
      if (j == i) continue;
      const Node<D>& b = state.nodes[j];
      const Vec<D> r = a.position - b.position;
      const Vec<D> u = a.velocity - b.velocity;
      const double derivative = static_cast<float>(sph::WendlandC2<D>::derivative_over_r(r.norm(), h));
      const Vec<D> gradient_w = derivative * r;
      raw += b.volume * (b.velocity - a.velocity) * gradient_w.transpose();
      moment -= b.volume * r * gradient_w.transpose();
      internal += b.volume * (a.flux + b.flux) * gradient_w;
      const double hourglass_level = std::min(a.hourglass_level, b.hourglass_level);
      if (hourglass_level > Node<D>::yielded) {
        const Vec<D> linear = 0.5 * (a.deformation + b.deformation) * r;
        Vec<D> left = displacement(i) - displacement(j) - linear;
        const double most = (hourglass_level - Node<D>::yielded) * r.norm();
        if (left.norm() > most) left *= most / left.norm();
        internal += s.hourglass_stiffness * s.modulus * b.volume * derivative * left;
      }
      const double share = b.volume * derivative * (a.density + b.density);
      const Vec<D> rest = u - 0.5 * (a.gradient + b.gradient) * r;
      viscous +=
          0.5 * s.hourglass_viscosity * s.sound_speed * h * (hourglass_level > Node<D>::flows ? share : 0.0) * rest;
      if (u.dot(r) >= 0.0) continue;
      const double rubbing = std::max(a.rubbing, b.rubbing);
      const double closing = -u.dot(r) / (r.squaredNorm() + 0.01 * h * h);
      const double collision = s.collision * s.sound_speed * h;
      const double stop = -0.5 * s.step * collision * derivative * (a.density + b.density) *
                          (a.volume / b.density + b.volume / a.density);
      const double viscosity =
          rubbing > 0.0 ? collision / (1.0 + stop) : s.artificial * s.sound_speed * h + s.quadratic * h * h * closing;
      const Vec<D> normal = -0.5 * viscosity * share * closing * r;
      const Vec<D> along = u - u.dot(r) / r.squaredNorm() * r;
      viscous += normal;
      const double slip = along.norm() / (along.norm() - u.dot(r) / r.norm());
      if (rubbing > 0.0) viscous -= rubbing * normal.norm() * slip * along.normalized();
    }
    out.internal.push_back(internal);
    out.stabilising.push_back(viscous);
    out.gradient.push_back(raw * invert_moment<D>(moment));
  }
  return out;
}

/// Gradient of the pressure [Pa/m]; images behind walls do not count.
template <int D>
VecArray<D> plain_pressure_gradient(const Setup<D>& setup, const State<D>& state, const ScalarArray& pressure) {
  const std::size_t n = state.particles.size();
  VecArray<D> out(n, Vec<D>::Zero());
  for (std::size_t i = 0; i < n; ++i) {
    Mat<D> moment = Mat<D>::Zero();
    for (std::size_t j = 0; j < state.nodes.size(); ++j) {
      if (j == i || (j >= n && !state.near.images[j - n].periodic)) continue;
      const Vec<D> r = state.nodes[i].position - state.nodes[j].position;
      const double derivative =
          static_cast<float>(sph::WendlandC2<D>::derivative_over_r(r.norm(), setup.smoothing_length));
      const Vec<D> w = state.nodes[j].volume * derivative * r;
      out[i] += (pressure[j < n ? j : state.near.images[j - n].parent] - pressure[i]) * w;
      moment -= r * w.transpose();
    }
    out[i] = invert_moment<D>(moment) * out[i];
  }
  return out;
}

}  // namespace poretwin::solid
