// The loops over all pairs, four at a time.
#include "solid_solver/operators.hpp"

#include "solid_solver/pair_loops.hpp"

namespace poretwin::solid {
namespace {

using Size = std::size_t;

/// W'/r of a pair at distance r [1/m^(D+2)]: scale u^3 with u = 1 - r / 2h.
template <int D>
struct PairKernel {
  double scale, half_inverse;
  explicit PairKernel(double h) : scale(-5.0 * sph::WendlandC2<D>::normalisation(h) / (h * h)), half_inverse(0.5 / h) {}
  [[gnu::always_inline]] void at(const Lanes& distance, Lanes& kernel) const {
    Lanes u = 1.0 - half_inverse * distance;
    raise_to(u, Lanes{});
    kernel = scale * u * u * u;
  }
};

/// M x of matrices in columns, four at a time.
template <int D>
[[gnu::always_inline]] inline void times(const Lanes* matrix, const Lanes* x, Lanes* product) {
  for (int a = 0; a < D; ++a) {
    product[a] = matrix[a] * x[0];
    for (int b = 1; b < D; ++b) product[a] += matrix[a + D * b] * x[b];
  }
}

}  // namespace

template <int D>
void pair_kernels(const std::vector<Node<D>>& nodes, const Pairs& pairs, double h, Size first, ScalarArray& kernel) {
  const PairKernel<D> derivative(h);
  kernel.resize(pairs.index.size());
  for_all_rows_in_lanes(
      pairs, first, pairs.size(), [&](Size i) __attribute__((always_inline)) {
        const double* const self = nodes[i].row();
        for_four_pairs(
            pairs, i, [&](Size m, bool) __attribute__((always_inline)) {
              Lanes x[D], distance{}, k;
              gather<0, D>(rows_at(nodes.data(), &pairs.index[m]), x);
              for (int d = 0; d < D; ++d) distance += (self[d] - x[d]) * (self[d] - x[d]);
              take_root(distance);
              derivative.at(distance, k);
              *reinterpret_cast<LooseLanes*>(&kernel[m]) = k;
            });
      });
}

template <int D>
void velocity_gradient(const Pairs& pairs, const ScalarArray& kernel, Scratch<D>& scratch, std::vector<Node<D>>& nodes,
                       MatArray<D>& correction) {
  using Own = Sums<D * D + D*(D + 1) / 2>;
  Own* const sums = scratch.template zero_sums<D * D + D*(D + 1) / 2>(pairs.size());
  for_rows_in_lanes(
      pairs, 0, pairs.size(), [&](Size i) __attribute__((always_inline)) {
        const double* const self = nodes[i].row();
        const double volume = nodes[i].volume;
        Lanes own[Own::size] = {};
        for_four_pairs(
            pairs, i, [&](Size m, bool both) __attribute__((always_inline)) {
              const auto rows = rows_at(nodes.data(), &pairs.index[m]);
              const Lanes volumes = {rows[0][Node<D>::at_volume], rows[1][Node<D>::at_volume],
                                     rows[2][Node<D>::at_volume], rows[3][Node<D>::at_volume]};
              Lanes other[2 * D], r[D], w[D], felt[Own::size] = {};
              gather<0, 2 * D>(rows, other);
              const Lanes k = *reinterpret_cast<const LooseLanes*>(&kernel[m]);
              for (Size d = 0; d < D; ++d) {
                r[d] = self[d] - other[d];
                w[d] = k * r[d];
              }
              Size c = 0;
              for (Size b = 0; b < D; ++b)
                for (Size a = 0; a < D; ++a) felt[c++] = (other[D + a] - self[D + a]) * w[b];
              for (Size b = 0; b < D; ++b)
                for (Size a = 0; a <= b; ++a) felt[c++] = -r[a] * w[b];
              for (Size n = 0; n < c; ++n) own[n] += volumes * felt[n];
              if (!both) return;
              for (Size n = 0; n < c; ++n) felt[n] *= volume;
              scatter_add<Own::size>(felt, sums_at(sums, &pairs.index[m]));
            });
        add_lanes<Own::size>(own, sums[i].x.data());
      });
  for_rows(pairs, 0, pairs.size(), [&](Size i) {
    const double* const sum = sums[i].x.data();
    const double* square = sum + D * D;
    if (*square == 0.0) {  // no neighbours at all
      nodes[i].gradient.setZero();
      return;
    }
    Mat<D> moment;
    for (int b = 0; b < D; ++b)
      for (int a = 0; a <= b; ++a) moment(a, b) = moment(b, a) = *square++;
    const Mat<D> inverse = invert_moment<D>(moment);  // in registers, as long as it is copied number by number
    for (int c = 0; c < D * D; ++c) correction[i].data()[c] = inverse.data()[c];
    nodes[i].gradient.noalias() = Eigen::Map<const Mat<D>>(sum) * inverse;
  });
}

template <int D>
void internal_force(const std::vector<Node<D>>& nodes, const Pairs& pairs, Size n_free, double h,
                    const Stabilisers& stabilisers, ScalarArray& kernel, Scratch<D>& scratch, VecArray<D>& internal,
                    VecArray<D>& stabilising) {
  using Own = Sums<2 * D>;
  using N = Node<D>;
  constexpr Size n_head = N::at_flux;
  const PairKernel<D> derivative(h);
  const double control = 0.25 * stabilisers.zero_energy * stabilisers.sound_speed * h;
  const double stiffness = stabilisers.stiffness * stabilisers.modulus;
  const double viscosity = 0.5 * stabilisers.artificial * stabilisers.sound_speed * h;
  const double quadratic = 0.5 * stabilisers.quadratic * h * h;
  const double collision = 0.5 * stabilisers.collision * stabilisers.sound_speed * h;
  const double clip = 0.01 * h * h;
  kernel.resize(pairs.index.size());
  Own* const sums = scratch.template zero_sums<2 * D>(pairs.size());
  for_rows_in_lanes(
      pairs, 0, n_free, [&](Size i) __attribute__((always_inline)) {
        const double* const self = nodes[i].row();
        const double volume = nodes[i].volume, firmness = nodes[i].firmness;
        Lanes own[Own::size] = {};
        for_four_pairs(
            pairs, i, [&](Size m, bool both) __attribute__((always_inline)) {
              const auto rows = rows_at(nodes.data(), &pairs.index[m]);
              Lanes head[n_head], other[D * D], r[D], u[D], kr[D];
              Lanes felt[Own::size] = {};  // the force without and with what stabilises
              gather<0, n_head>(rows, head);
              Lanes squared{}, approach{}, k;
              for (Size d = 0; d < D; ++d) {
                r[d] = self[d] - head[d];
                u[d] = self[D + d] - head[D + d];
                squared += r[d] * r[d];
                approach -= r[d] * u[d];
              }
              raise_to(approach, Lanes{});
              Lanes distance = squared;
              take_root(distance);
              derivative.at(distance, k);
              *reinterpret_cast<LooseLanes*>(&kernel[m]) = k;
              for (Size d = 0; d < D; ++d) kr[d] = k * r[d];
              gather<N::at_flux, D * D>(rows, other);
              for (Size c = 0; c < D * D; ++c) other[c] += self[N::at_flux + c];
              times<D>(other, kr, felt);
              const Lanes share = k * (self[N::at_density] + head[N::at_density]);
              const Lanes closing = approach / (squared + clip);  // 1/s
              const Lanes viscous = viscosity + quadratic * closing;
              Lanes resist = share * closing;
              Lanes rubbing =
                  head[N::at_rubbing] > self[N::at_rubbing] ? head[N::at_rubbing] : Lanes{} + self[N::at_rubbing];
              const LaneMask rubs = rubbing > 0.0;
              if (any(rubs)) {
                resist *= rubs ? Lanes{} + collision : viscous;
                // Coulomb's friction of the collision.
                const LaneMask collides = rubs & (approach > 0.0);
                const Lanes pull = approach / (collides ? squared : Lanes{} + 1.0);
                Lanes along[D], slip{};
                for (Size d = 0; d < D; ++d) {
                  along[d] = u[d] + pull * r[d];
                  slip += along[d] * along[d];
                }
                take_root(slip);
                Lanes friction = rubbing * resist * distance / (slip + pull * distance);
                friction = collides ? friction : Lanes{};
                for (Size d = 0; d < D; ++d) felt[D + d] = friction * along[d] - resist * r[d];
              } else {
                resist *= viscous;
                for (Size d = 0; d < D; ++d) felt[D + d] = -resist * r[d];
              }
              const Lanes firm = head[N::at_firmness] < firmness ? head[N::at_firmness] : Lanes{} + firmness;
              if (firmness > N::flows && any(firm > N::flows)) {
                Lanes turned[D];
                gather<N::at_gradient, D * D>(rows, other);
                for (Size c = 0; c < D * D; ++c) other[c] += self[N::at_gradient + c];
                times<D>(other, r, turned);
                const Lanes weight = firm > N::flows ? control * share : Lanes{};
                for (Size d = 0; d < D; ++d) felt[D + d] += weight * (2.0 * u[d] - turned[d]);
              }
              if (firmness == N::elastic && any(firm > N::yielded)) {
                Lanes shift[D], linear[D];
                gather<N::at_deformation, D * D>(rows, other);
                gather<N::at_displacement, D>(rows, shift);
                for (Size c = 0; c < D * D; ++c) other[c] += self[N::at_deformation + c];
                times<D>(other, r, linear);
                const Lanes weight = firm > N::yielded ? stiffness * k : Lanes{};
                for (Size d = 0; d < D; ++d)
                  felt[d] += weight * (self[N::at_displacement + d] - shift[d] - 0.5 * linear[d]);
              }
              for (Size n = 0; n < 2 * D; ++n) own[n] += head[N::at_volume] * felt[n];
              if (!both) return;
              for (Size n = 0; n < 2 * D; ++n) felt[n] *= -volume;
              scatter_add<Own::size>(felt, sums_at(sums, &pairs.index[m]));
            });
        add_lanes<Own::size>(own, sums[i].x.data());
      });
  for_rows(pairs, 0, n_free, [&](Size i) {
    for (Size d = 0; d < D; ++d) {
      internal[i][static_cast<int>(d)] = sums[i].x[d];
      stabilising[i][static_cast<int>(d)] = sums[i].x[D + d];
    }
  });
}

#define PORETWIN_INSTANTIATE(D)                                                                                \
  template void pair_kernels<D>(const std::vector<Node<D>>&, const Pairs&, double, Size, ScalarArray&);        \
  template void velocity_gradient<D>(const Pairs&, const ScalarArray&, Scratch<D>&, std::vector<Node<D>>&,     \
                                     MatArray<D>&);                                                            \
  template void internal_force<D>(const std::vector<Node<D>>&, const Pairs&, Size, double, const Stabilisers&, \
                                  ScalarArray&, Scratch<D>&, VecArray<D>&, VecArray<D>&);
PORETWIN_INSTANTIATE(2)
PORETWIN_INSTANTIATE(3)
#undef PORETWIN_INSTANTIATE

}  // namespace poretwin::solid
