#include "solid_solver/statics/stiffness.hpp"

#include "solid_solver/numerics/statics.hpp"
#include "solid_solver/statics/axis_inverse.hpp"

namespace poretwin::solid {

template <int D>
Stiffness<D>::Stiffness(const Setup<D>& setup, const Particles<D>& particles, const VecArray<D>& lattice,
                        ScalarArray resistance)
    : resistance_(std::move(resistance)) {
  const std::size_t n = particles.size(), n_free = particles.free();
  Particles<D> laid = particles;
  laid.position = lattice;
  for (auto& plate : laid.plates) plate = {};
  Neighbourhood<D> near;
  build_neighbourhood<D>(setup.boundaries, sph::support_radius * setup.smoothing_length, 1, laid, {}, near);
  const auto place = [&](std::size_t j) -> Vec<D> {
    if (j < n) return lattice[j];
    return near.images[j - n].map * lattice[near.images[j - n].parent] + near.images[j - n].shift;
  };
  // Moduli of unstrained soil: one factorisation serves many windows, and a resumed run computes the same one.
  const std::vector<Elasticity>& elasticity = setup.typical;
  const auto volume = [&](std::size_t i) { return laid.mass[i] / setup.density[laid.material[i]]; };
  inverse_ = D == 2 ? by_factors<D>() : by_multigrid<D>();
  const std::vector<PlateFreedom> freedoms = freedoms_of(setup.plates);
  border_.assign(freedoms.size(), VecArray<D>(n_free, Vec<D>::Zero()));
  std::vector<Vec<D>> carried(near.images.size() * freedoms.size(), Vec<D>::Zero());  // by image, then by freedom
  for (const BehindPlate<D>& behind : near.behind_plates)
    for (std::size_t f = 0; f < freedoms.size(); ++f)
      if (freedoms[f].plate == behind.plate)
        carried[behind.image * freedoms.size() + f] = behind.velocity * setup.plates[behind.plate].normal;
  // Displacement of the plate along its normal at the place between two nodes, per displacement in a freedom.
  const auto share_of = [&](const PlateFreedom& freedom, std::size_t i, std::size_t j) {
    const PlateSetup<D>& plate = setup.plates[freedom.plate];
    return freedom.turns ? plate.along.dot(0.5 * (place(i) + place(j)) - plate.middle) / plate.half : 1.0;
  };
  const auto m = static_cast<Eigen::Index>(freedoms.size());
  Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(m, m);
  for (Eigen::Index axis = 0; axis < D; ++axis) {
    std::vector<Eigen::Triplet<double>> entries;
    const auto add = [&](std::size_t i, std::size_t j, double value) {
      entries.emplace_back(static_cast<int>(i), static_cast<int>(j), value);
    };
    for (std::size_t i = 0; i < n_free; ++i) add(i, i, resistance_[i]);
    for_each_ordered_pair(near.pairs, [&](std::size_t i, std::size_t j, std::size_t) {
      if (i >= n_free) return;
      const std::size_t parent = j < n ? j : near.images[j - n].parent;
      const Vec<D> r = place(i) - place(j);
      const double distance = r.norm();
      const Elasticity &a = elasticity[laid.material[i]], &b = elasticity[laid.material[parent]];
      const double shear = 0.5 * (a.shear + b.shear), constrained = 0.5 * (a.constrained() + b.constrained());
      const double along = r[axis] / distance;
      // The lower bound makes the matrix positive definite.
      const double form = std::max(2.0 * shear + (constrained - shear) * ((D + 2) * along * along - 1.0),
                                   statics::least_pair_stiffness * shear);
      const double strength =
          -volume(i) * volume(parent) * sph::WendlandC2<D>::derivative_over_r(distance, setup.smoothing_length) * form;
      add(i, i, strength);
      for (std::size_t f = 0; f < freedoms.size() && j >= n; ++f) {
        const double share = share_of(freedoms[f], i, j);
        const double force = strength * share * carried[(j - n) * freedoms.size() + f][axis];
        border_[f][i][axis] += force;
        if (!freedoms[f].turns) continue;
        const auto at = static_cast<Eigen::Index>(f);
        stiffness(at, at) += force * share * setup.plates[freedoms[f].plate].normal[axis];
      }
      if (parent >= n_free) return;
      const double coupling = j < n ? -strength : -strength * near.images[j - n].velocity(axis, axis);
      if (j < n || !near.images[j - n].curved) {
        add(i, parent, coupling);
        return;
      }
      // Behind a curved wall, the images of the two particles of a pair are not equally far away: the mean is added.
      add(i, parent, 0.5 * coupling);
      add(parent, i, 0.5 * coupling);
    });
    Eigen::SparseMatrix<double> matrix(static_cast<Eigen::Index>(n_free), static_cast<Eigen::Index>(n_free));
    matrix.setFromTriplets(entries.begin(), entries.end());
    inverse_->add(matrix);
  }
  const auto times = [](const VecArray<D>& a, const VecArray<D>& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += a[i].dot(b[i]);
    return sum;
  };
  for (const VecArray<D>& force : border_) follow_.push_back(displacements(force));
  for (Eigen::Index a = 0; a < m; ++a) {
    const auto f = static_cast<std::size_t>(a);
    for (Eigen::Index b = 0; b < m; ++b) {
      const auto g = static_cast<std::size_t>(b);
      // Soil that moves along with the plate does not resist it.
      if (!freedoms[f].turns && freedoms[f].plate == freedoms[g].plate) {
        double along = 0.0;
        for (const Vec<D>& force : border_[g]) along += force.dot(setup.plates[freedoms[f].plate].normal);
        stiffness(a, b) += along;
        if (a != b) stiffness(b, a) += along;
      }
      stiffness(a, b) -= times(border_[f], follow_[g]);
    }
  }
  compliance_ = stiffness.inverse();
  VecArray<D> weight(n_free);
  for (std::size_t i = 0; i < n_free; ++i) weight[i] = laid.mass[i] * upwards(setup);
  unit_work_ = work(weight);
}

template <int D>
Stiffness<D>::~Stiffness() = default;

template <int D>
double Stiffness<D>::work(const VecArray<D>& forces) const {
  return inverse_->work(forces);
}

template <int D>
VecArray<D> Stiffness<D>::displacements(const VecArray<D>& forces) const {
  return inverse_->displacements(forces);
}

template <int D>
VecArray<D> Stiffness<D>::displacements(const VecArray<D>& forces, const Eigen::VectorXd& on_plates,
                                        Eigen::VectorXd& plates) const {
  VecArray<D> moved = displacements(forces);
  Eigen::VectorXd left = on_plates;
  for (std::size_t f = 0; f < border_.size(); ++f)
    for (std::size_t i = 0; i < forces.size(); ++i) left[static_cast<Eigen::Index>(f)] += border_[f][i].dot(moved[i]);
  plates = compliance_ * left;
  for (std::size_t f = 0; f < border_.size(); ++f)
    for (std::size_t i = 0; i < forces.size(); ++i) moved[i] += plates[static_cast<Eigen::Index>(f)] * follow_[f][i];
  return moved;
}

template class Stiffness<2>;
template class Stiffness<3>;

}  // namespace poretwin::solid
