// The loops over all pairs of particles.
#include "solid_solver/discretisation/operators.hpp"

#include "common/particles/for_pairs.hpp"
#include "solid_solver/numerics/points.hpp"

namespace poretwin::solid {
namespace {

using Size = std::size_t;

/// W'/r of a pair at the distance r [1/m^(D+2)]: scale u^3 with u = 1 - r / (2 h), at least 0.
template <int D>
struct PairKernel {
  double scale, half_inverse;
  explicit PairKernel(double h) : scale(-5.0 * sph::WendlandC2<D>::normalisation(h) / (h * h)), half_inverse(0.5 / h) {}
  template <class Number>
  [[gnu::always_inline]] void at(const Number& distance, Number& kernel) const {
    Number u = 1.0 - half_inverse * distance;
    max_in_place(u, Number{});
    kernel = scale * u * u * u;
  }
};

/// The data of a particle or an image that the pressure gradient reads, packed together.
template <int D>
struct alignas(32) Soaked {
  Vec<D> position;
  double volume = 0.0;  ///< m^D; 0 for an image behind a wall, so that it does not contribute
  double pressure = 0.0;
  [[nodiscard]] const double* row() const { return position.data(); }
};

/// The loop that computes kernels needs no sums of a row.
template <class>
struct NoSums {
  explicit NoSums(const double*) {}
};

/// Product M x of a matrix (stored by columns) with a vector.
template <int D, class Number>
[[gnu::always_inline]] inline void times(const Number* matrix, const Number* x, Number* product) {
  for (int a = 0; a < D; ++a) {
    product[a] = matrix[a] * x[0];
    for (int b = 1; b < D; ++b) product[a] += matrix[a + D * b] * x[b];
  }
}

}  // namespace

template <int D>
void pair_kernels(const std::vector<Node<D>>& nodes, const Pairs& pairs, double h, Size first, Kernels& kernel) {
  const PairKernel<D> derivative(h);
  kernel.resize(pairs.index.size());
  float* const kernels = kernel.data();
  for_pairs<NoSums>(
      pairs.all_rows(first, pairs.size()), PairInputs{nodes.data()},
      [=](const auto& pair, auto&) __attribute__((always_inline)) {
        NumberOf<decltype(pair)> x[D], distance{}, k;
        gather<0, D>(pair.rows(), x);
        for (int d = 0; d < D; ++d) distance += (pair.self[d] - x[d]) * (pair.self[d] - x[d]);
        sqrt_in_place(distance);
        derivative.at(distance, k);
        put(k, &kernels[pair.m]);
      },
      [](Size, const auto&) __attribute__((always_inline)){});
}

template <int D>
void velocity_gradient(const Pairs& pairs, const Kernels& kernel, std::vector<Node<D>>& nodes) {
  constexpr Size n_sums = Node<D>::n_sums;
  for_rows(pairs, 0, pairs.size(), [&](Size i) { std::fill_n(nodes[i].sums(), n_sums, 0.0); });
  Node<D>* const all = nodes.data();
  const float* const kernels = kernel.data();
  for_pairs<SumsOf<n_sums>::template Row>(
      pairs.rows(0, pairs.size()), PairInputs<Node<D>, 0, 2>{all, nodes.size()},
      [=](const auto& pair, auto& own) __attribute__((always_inline)) {
        using Number = NumberOf<decltype(pair)>;
        const double* const self = pair.self;
        const auto rows = pair.rows();
        Number other[2 * D], r[D], w[D], k, volumes, contribution[n_sums] = {};
        gather_one(rows, Node<D>::at_volume, volumes);
        gather<0, 2 * D>(rows, other);
        take(&kernels[pair.m], k);
        for (Size d = 0; d < D; ++d) {
          r[d] = self[d] - other[d];
          w[d] = k * r[d];
        }
        Size c = 0;
        for (Size b = 0; b < D; ++b)
          for (Size a = 0; a < D; ++a) contribution[c++] = (other[D + a] - self[D + a]) * w[b];
        for (Size b = 0; b < D; ++b)
          for (Size a = 0; a <= b; ++a) contribution[c++] = -r[a] * w[b];
        for (Size n = 0; n < c; ++n) own.sum[n] += volumes * contribution[n];
        if (!pair.both) return;
        for (Size n = 0; n < c; ++n) contribution[n] *= self[Node<D>::at_volume];
        pair.template give<n_sums>(contribution, [=](Index j) { return all[j].sums(); });
      },
      [=](Size i, const auto& own) __attribute__((always_inline)) { own.add_to(all[i].sums()); });
  for_rows(pairs, 0, pairs.size(), [&](Size i) {
    Node<D>& node = nodes[i];
    const Mat<D> moment = node.correction();
    if (moment(0, 0) == 0.0) {  // without neighbours
      node.set_correction(Mat<D>::Identity());
      return;
    }
    const Mat<D> inverse = invert_moment<D>(moment);
    node.set_correction(inverse);
    node.gradient = (node.gradient * inverse).eval();
  });
}

template <int D>
VecArray<D> pressure_gradient_difference(const State<D>& state, std::span<const double> pressure) {
  const Pairs& pairs = state.near.pairs;
  const Size n = state.particles.size();
  std::vector<Soaked<D>> soaked(state.nodes.size());
  for (Size j = 0; j < soaked.size(); ++j) {
    const bool contribution = j < n || state.near.images[j - n].periodic;
    soaked[j] = {state.nodes[j].position, contribution ? state.nodes[j].volume : 0.0,
                 pressure[j < n ? j : state.near.images[j - n].parent]};
  }
  // The sums of a row: the gradient, then the upper triangle of the moment matrix.
  constexpr Size n_moments = D * (D + 1) / 2;
  using Own = Sums<D + n_moments>;
  std::vector<Own> sums(n);
  const float* const kernels = state.kernel.data();
  Own* const sum_of = sums.data();
  for_pairs<SumsOf<D + n_moments>::template Row>(
      pairs.all_rows(0, n), PairInputs{soaked.data()},
      [=](const auto& pair, auto& own) __attribute__((always_inline)) {
        using Number = NumberOf<decltype(pair)>;
        const double* const self = pair.self;
        Number other[D + 2], r[D], w[D], k, contribution[Own::size] = {};
        gather<0, D + 2>(pair.rows(), other);
        take(&kernels[pair.m], k);
        for (Size d = 0; d < D; ++d) {
          r[d] = self[d] - other[d];
          w[d] = k * r[d];
        }
        Size c = 0;
        for (Size d = 0; d < D; ++d) contribution[c++] = (other[D + 1] - self[D + 1]) * w[d];
        for (Size b = 0; b < D; ++b)
          for (Size a = 0; a <= b; ++a) contribution[c++] = -r[a] * w[b];
        for (Size s = 0; s < c; ++s) own.sum[s] += other[D] * contribution[s];
        if (!pair.both) return;
        for (Size s = 0; s < c; ++s) contribution[s] *= self[D];
        pair.template give<Own::size>(contribution, [=](Index j) { return sum_of[j].x.data(); });
      },
      [=](Size i, const auto& own) __attribute__((always_inline)) { own.add_to(sum_of[i].x.data()); });
  VecArray<D> gradient(n);
  parallel_for(n, [&](Size i) {
    const double* const sum = sums[i].x.data();
    gradient[i] = invert_moment<D>(symmetric<D>(sum + D)) * Eigen::Map<const Vec<D>>(sum);
  });
  return gradient;
}

template <int D>
void internal_force(const std::vector<Node<D>>& nodes, const Pairs& pairs, const std::vector<ImageRule<D>>& rules,
                    const VecArray<D>& displacement, Size n_free, double h, const Stabilisers& stabilisers,
                    Kernels& kernel, std::vector<Force<D>>& force) {
  using Own = Sums<2 * D>;
  using N = Node<D>;
  constexpr Size n_head = N::at_gradient;
  const PairKernel<D> derivative(h);
  const double control = 0.25 * stabilisers.hourglass_viscosity * stabilisers.sound_speed * h;
  const double stiffness = stabilisers.hourglass_stiffness * stabilisers.modulus;
  const double viscosity = 0.5 * stabilisers.artificial * stabilisers.sound_speed * h;
  const double quadratic = 0.5 * stabilisers.quadratic * h * h;
  const double collision = 0.5 * stabilisers.collision * stabilisers.sound_speed * h;
  const double step = stabilisers.step, clip = points::viscosity_softening * h * h;
  kernel.resize(pairs.index.size());
  for_rows(pairs, 0, pairs.size(), [&](Size i) { force[i] = {}; });
  const Vec<D>* const displaced = displacement.data();
  const ImageRule<D>* const images = rules.data();
  const Size n_real = displacement.size();
  float* const kernels = kernel.data();
  Force<D>* const forces = force.data();
  for_pairs<SumsOf<2 * D>::template Row>(
      pairs.rows(0, n_free), PairInputs<N, 0, 3>{nodes.data(), nodes.size()},
      [=](const auto& pair, auto& own) __attribute__((always_inline)) {
        using Number = NumberOf<decltype(pair)>;
        const double* const self = pair.self;
        const double volume = self[N::at_volume], own_level = self[N::at_hourglass_level];
        const auto rows = pair.rows();
        Number head[n_head], other[D * D], r[D], u[D], kr[D];
        Number contribution[Own::size] = {};  // first the force with stiffness, then the viscous forces
        gather<0, n_head>(rows, head);
        Number squared{}, approach{}, k;
        for (Size d = 0; d < D; ++d) {
          r[d] = self[d] - head[d];
          u[d] = self[D + d] - head[D + d];
          squared += r[d] * r[d];
          approach -= r[d] * u[d];
        }
        max_in_place(approach, Number{});
        Number distance = squared;
        sqrt_in_place(distance);
        derivative.at(distance, k);
        put(k, &kernels[pair.m]);
        take(&kernels[pair.m], k);
        for (Size d = 0; d < D; ++d) kr[d] = k * r[d];
        gather<N::at_flux, D * D>(rows, other);
        for (Size c = 0; c < D * D; ++c) other[c] += self[N::at_flux + c];
        times<D>(other, kr, contribution);
        const Number share = k * (self[N::at_density] + head[N::at_density]);
        const Number closing = approach / (squared + clip);  // 1/s
        const Number viscous = viscosity + quadratic * closing;
        Number resist = share * closing;
        Number rubbing =
            head[N::at_rubbing] > self[N::at_rubbing] ? head[N::at_rubbing] : Number{} + self[N::at_rubbing];
        const MaskOf<decltype(pair)> rubs = rubbing > 0.0;
        if (any(rubs)) {
          // Implicit in the velocities of the pair: an explicit force would make grains rebound that are close together
          // or have swollen.
          const Number stop =
              step * collision * share * (volume / head[N::at_density] + head[N::at_volume] / self[N::at_density]);
          resist *= rubs ? collision / (1.0 - stop) : viscous;
          // Coulomb's friction between colliding grains.
          const MaskOf<decltype(pair)> collides = rubs & (approach > 0.0);
          const Number rate = approach / (collides ? squared : Number{} + 1.0);
          Number along[D], slip{};
          for (Size d = 0; d < D; ++d) {
            along[d] = u[d] + rate * r[d];
            slip += along[d] * along[d];
          }
          sqrt_in_place(slip);
          Number friction = rubbing * resist * distance / (slip + rate * distance);
          friction = collides ? friction : Number{};
          for (Size d = 0; d < D; ++d) contribution[D + d] = friction * along[d] - resist * r[d];
        } else {
          resist *= viscous;
          for (Size d = 0; d < D; ++d) contribution[D + d] = -resist * r[d];
        }
        const Number level =
            head[N::at_hourglass_level] < own_level ? head[N::at_hourglass_level] : Number{} + own_level;
        if (own_level > N::flows) {
          Number turned[D];
          gather<N::at_gradient, D * D>(rows, other);
          for (Size c = 0; c < D * D; ++c) other[c] += self[N::at_gradient + c];
          times<D>(other, r, turned);
          const Number weight = level > N::flows ? control * share : Number{};
          for (Size d = 0; d < D; ++d) contribution[D + d] += weight * (2.0 * u[d] - turned[d]);
        }
        if (own_level > N::yielded) {
          Number linear[D];
          gather<N::at_deformation, D * D>(rows, other);
          const auto theirs = pair.rows_of(
              [=](Index j) { return j < n_real ? displaced[j].data() : images[j - n_real].displacement.data(); });
          for (Size c = 0; c < D * D; ++c) other[c] += self[N::at_deformation + c];
          times<D>(other, r, linear);
          Number weight = stiffness * k, left[D], size{};  // `left`: the part of the displacement that is not linear
          for (Size d = 0; d < D; ++d) {
            Number shift;
            gather_one(theirs, d, shift);
            left[d] = displaced[pair.i][static_cast<int>(d)] - shift - 0.5 * linear[d];
            size += left[d] * left[d];
          }
          if (any(level < N::elastic)) {
            sqrt_in_place(size);
            const Number most = (level - N::yielded) * distance;
            weight *= size > most ? most / size : Number{} + 1.0;
            weight = level > N::yielded ? weight : Number{};
          }
          for (Size d = 0; d < D; ++d) contribution[d] += weight * left[d];
        }
        for (Size n = 0; n < 2 * D; ++n) own.sum[n] += head[N::at_volume] * contribution[n];
        if (!pair.both) return;
        for (Size n = 0; n < 2 * D; ++n) contribution[n] *= -volume;
        pair.template give<Own::size>(contribution, [=](Index j) { return forces[j].sum.x.data(); });
      },
      [=](Size i, const auto& own) __attribute__((always_inline)) { own.add_to(forces[i].sum.x.data()); });
  for_rows(pairs, n_free, pairs.size(), [&](Size i) { force[i] = {}; });
}

template <int D>
void refit_deformation(const Particles<D>& p, const Neighbourhood<D>& near, double h, std::vector<Node<D>>& nodes) {
  if (near.behind_curved.empty() || nodes.size() < p.size()) return;
  struct Fit {
    Mat<D> gradient = Mat<D>::Zero(), moment = Mat<D>::Zero();
  };
  std::vector<Index> place(p.size(), 0);
  std::vector<Fit> fits(1);
  for (const auto& behind : near.behind_curved) {
    Index& at = place[near.images[behind.image].parent];
    if (at != 0) continue;
    at = static_cast<Index>(fits.size());
    fits.emplace_back();
  }
  for_each_ordered_pair(near.pairs, [&](Size i, Size j, Size) {
    if (place[i] == 0 || j >= p.size()) return;
    const Vec<D> r = p.position[i] - p.position[j];
    const Vec<D> w = p.volume[j] * sph::WendlandC2<D>::derivative_over_r(r.norm(), h) * r;
    Fit& fit = fits[place[i]];
    fit.gradient += (p.displacement[j] - p.displacement[i]) * w.transpose();
    fit.moment -= r * w.transpose();
  });
  for (Size i = 0; i < p.size(); ++i)
    if (place[i] != 0 && fits[place[i]].moment(0, 0) > 0.0)
      nodes[i].deformation = fits[place[i]].gradient * invert_moment<D>(fits[place[i]].moment);
}

template <int D>
void pull_back(const std::vector<Node<D>>& nodes, const Neighbourhood<D>& near, const Kernels& kernel,
               const VecArray<D>& slip, std::vector<Force<D>>& force) {
  const Views& views = near.views;
  if (views.first.empty()) return;
  const Size n = near.pairs.size();
  parallel_for(views.first.size() - 1, [&](Size group) {
    for (Size k = views.first[group]; k < views.first[group + 1]; ++k) {
      const ImageRule<D>& rule = near.images[k];
      const Node<D>& image = nodes[n + k];
      const Mat<D> back = rule.velocity.transpose();
      Vec<D> sum = Vec<D>::Zero();
      for (Size m = views.offset[k]; m < views.offset[k + 1]; ++m) {
        const auto [i, pair] = views.view[m];
        const Vec<D> w = nodes[i].volume * static_cast<double>(kernel[pair]) * (nodes[i].position - image.position);
        const Vec<D> pull = nodes[i].flux * w;
        sum += back * pull;
        if (!rule.slips || rule.n_crossings > 1 || slip[i].isZero(0.0)) continue;
        // Slipping soil is mirrored along the wall (see fill_nodes).
        const Vec<D>& normal = rule.crossings[0].normal;
        const Vec<D> along = nodes[i].flux * (w - normal.dot(w) * normal);
        sum += 2.0 * (along - normal.dot(along) * normal);
      }
      Eigen::Map<Vec<D>>(force[rule.parent].sum.x.data()) -= image.volume / nodes[rule.parent].volume * sum;
    }
  });
}

#define PORETWIN_INSTANTIATE(D)                                                                                        \
  template void refit_deformation<D>(const Particles<D>&, const Neighbourhood<D>&, double, std::vector<Node<D>>&);     \
  template void pull_back<D>(const std::vector<Node<D>>&, const Neighbourhood<D>&, const Kernels&, const VecArray<D>&, \
                             std::vector<Force<D>>&);                                                                  \
  template void pair_kernels<D>(const std::vector<Node<D>>&, const Pairs&, double, Size, Kernels&);                    \
  template void velocity_gradient<D>(const Pairs&, const Kernels&, std::vector<Node<D>>&);                             \
  template VecArray<D> pressure_gradient_difference<D>(const State<D>&, std::span<const double>);                      \
  template void internal_force<D>(const std::vector<Node<D>>&, const Pairs&, const std::vector<ImageRule<D>>&,         \
                                  const VecArray<D>&, Size, double, const Stabilisers&, Kernels&,                      \
                                  std::vector<Force<D>>&);
PORETWIN_INSTANTIATE(2)
PORETWIN_INSTANTIATE(3)
#undef PORETWIN_INSTANTIATE

}  // namespace poretwin::solid
