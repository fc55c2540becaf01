#include "solid_solver/stiffness.hpp"

#include "common/core/error.hpp"

namespace poretwin::solid {

template <int D>
Stiffness<D>::Stiffness(const Setup<D>& setup, const Particles<D>& particles, const VecArray<D>& lattice,
                        ScalarArray resistance)
    : resistance_(std::move(resistance)) {
  const std::size_t n = particles.size(), n_free = particles.free();
  Particles<D> laid = particles;
  laid.position = lattice;
  Neighbourhood<D> near;
  build_neighbourhood<D>(setup.boundaries, sph::support_radius * setup.smoothing_length, 1, laid, {}, near);
  const auto place = [&](std::size_t j) -> Vec<D> {
    if (j < n) return lattice[j];
    return near.images[j - n].map * lattice[near.images[j - n].parent] + near.images[j - n].shift;
  };
  const auto volume = [&](std::size_t i) { return laid.mass[i] / setup.density[laid.material[i]]; };
  for (std::size_t axis = 0; axis < D; ++axis) {
    std::vector<Eigen::Triplet<double>> entries;
    const auto add = [&](std::size_t i, std::size_t j, double value) {
      entries.emplace_back(static_cast<int>(i), static_cast<int>(j), value);
    };
    for (std::size_t i = 0; i < n_free; ++i) add(i, i, resistance_[i]);
    for_each_felt(near.pairs, [&](std::size_t i, std::size_t j, std::size_t) {
      if (i >= n_free) return;
      const std::size_t parent = j < n ? j : near.images[j - n].parent;
      const Vec<D> r = place(i) - place(j);
      const double distance = r.norm();
      const Elasticity &a = setup.models[laid.material[i]]->elasticity(),
                       &b = setup.models[laid.material[parent]]->elasticity();
      const double shear = 0.5 * (a.shear + b.shear), constrained = 0.5 * (a.constrained() + b.constrained());
      const double along = r[static_cast<Eigen::Index>(axis)] / distance;
      // Positive, so that the matrix is.
      const double form = std::max(2.0 * shear + (constrained - shear) * ((D + 2) * along * along - 1.0), 0.1 * shear);
      const double strength =
          -volume(i) * volume(parent) * sph::WendlandC2<D>::derivative_over_r(distance, setup.smoothing_length) * form;
      add(i, i, strength);
      if (parent >= n_free) return;
      const auto a_axis = static_cast<Eigen::Index>(axis);
      add(i, parent, j < n ? -strength : -strength * near.images[j - n].velocity(a_axis, a_axis));
    });
    Matrix matrix(static_cast<Eigen::Index>(n_free), static_cast<Eigen::Index>(n_free));
    matrix.setFromTriplets(entries.begin(), entries.end());
    factor_[axis] = std::make_unique<Eigen::SimplicialLLT<Matrix>>(matrix);
    if (factor_[axis]->info() != Eigen::Success)
      throw DivergedError("the soil's stiffness along an axis is not positive: report the case");
  }
  VecArray<D> weight(n_free);
  for (std::size_t i = 0; i < n_free; ++i) weight[i] = laid.mass[i] * upwards(setup);
  const VecArray<D> moved = displacements(weight);
  for (std::size_t i = 0; i < n_free; ++i) unit_work_ += weight[i].dot(moved[i]);
}

template <int D>
VecArray<D> Stiffness<D>::displacements(const VecArray<D>& forces) const {
  VecArray<D> moved(forces.size());
  Eigen::VectorXd b(static_cast<Eigen::Index>(forces.size()));
  for (Eigen::Index axis = 0; axis < D; ++axis) {
    for (std::size_t i = 0; i < forces.size(); ++i) b[static_cast<Eigen::Index>(i)] = forces[i][axis];
    const Eigen::VectorXd x = factor_[static_cast<std::size_t>(axis)]->solve(b);
    for (std::size_t i = 0; i < forces.size(); ++i) moved[i][axis] = x[static_cast<Eigen::Index>(i)];
  }
  return moved;
}

template class Stiffness<2>;
template class Stiffness<3>;

}  // namespace poretwin::solid
