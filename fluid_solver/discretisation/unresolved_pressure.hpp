// The part of a pressure that gradients do not resolve, pair by pair.
#pragma once

#include "common/core/threads.hpp"
#include "common/numerics/csr.hpp"
#include "fluid_solver/discretisation/stencil.hpp"
#include "fluid_solver/numerics/points.hpp"

namespace poretwin::fluid {

/// A pressure that alternates from row to row has a gradient G of zero. It shows in each pair of particles, where the
/// mean of the two gradients does not explain the whole difference between the two pressures. The unexplained
/// remainder, summed over the pairs of a particle, is
///
///     S(p)_a = sum_b w_ab [p_a - p_b - (G_a + G_b).(x_a - x_b) / 2],   w_ab: weight of the pair in a Laplacian
///
/// S(p) is zero for a linear pressure on any points, walls and surfaces included, and, where gradients are exact for
/// it, for a quadratic pressure. Pair (a, b) adds to a what it takes from b, so that the sum of S over all particles is
/// zero. The Laplacian less the divergence of the gradient has neither property: on disordered points it is 2 g.sum V
/// grad W under a linear pressure of slope g (decision 0031).
///
/// G is fitted to the pairs with other particles. Images beyond periodic sides count as particles. Images behind walls
/// are left out: they have their parents' pressures, although the pressure in moving soil has a slope at walls. Water
/// faces and the free surface are left out, too.
template <int D>
class UnresolvedPressure {
 public:
  UnresolvedPressure() = default;
  /// laplacian [m^(D-2)]: of mobility 1 on this stencil. The stencil and the laplacian must outlive the object.
  UnresolvedPressure(const Stencil<D>& stencil, const PairMatrix& laplacian)
      : s_(&stencil), weights_(&laplacian), inverse_(stencil.n_real) {
    parallel_for(s_->n_real, [&](std::size_t a) {
      Mat<D> moment = Mat<D>::Zero();
      for_pairs_of(a, [&](Index, double w, const Vec<D>& ab) { moment += w * ab * ab.transpose(); });
      inverse_[a] = bounded_inverse<D>(moment, points::least_pair_moment * 2.0 * s_->volume[a], nullptr);
    });
  }
  [[nodiscard]] bool empty() const { return s_ == nullptr; }

  /// S(p) [Pa m^(D-2)] of the real particles; all ranks call this.
  [[nodiscard]] ScalarArray operator()(std::span<const double> own) const {
    const std::size_t n = inverse_.size();
    const auto p = s_->with_copies(own);
    VecArray<D> slope(s_->n_particles);
    parallel_for(n, [&](std::size_t a) {
      Vec<D> sum = Vec<D>::Zero();
      for_pairs_of(a, [&](Index b, double w, const Vec<D>& ab) { sum += w * (p[b] - p[a]) * ab; });
      slope[a] = inverse_[a] * sum;
    });
    fill_copies(s_->domain, std::span(slope));
    ScalarArray result(n);
    parallel_for(n, [&](std::size_t a) {
      double sum = 0.0;
      for_pairs_of(a, [&](Index b, double w, const Vec<D>& ab) {
        sum += w * (p[a] - p[b] + 0.5 * (slope[a] + slope[b]).dot(ab));
      });
      result[a] = sum;
    });
    return result;
  }

 private:
  /// Calls take(b, w_ab, x_b - x_a) for the pairs of particle a with other particles.
  template <class Take>
  void for_pairs_of(std::size_t a, const Take& take) const {
    const Stencil<D>& s = *s_;
    for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k) {
      const Index j = s.other[k], b = s.parent[j];
      if (b >= s.n_particles || b == static_cast<Index>(a) || weights_->weight[k] == 0.0F) continue;
      if (j >= s.n_base && !s.map[j - s.n_base].isIdentity()) continue;
      take(b, static_cast<double>(weights_->weight[k]), Vec<D>(s.position[j] - s.position[a]));
    }
  }

  const Stencil<D>* s_ = nullptr;
  const PairMatrix* weights_ = nullptr;
  MatArray<D> inverse_;  ///< [real] inverse of sum w r r^T
};

}  // namespace poretwin::fluid
