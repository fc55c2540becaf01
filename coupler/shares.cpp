// Conservative mapping: amounts are distributed with balanced weights. The weights are stored twice, by giver and by
// receiver, so that both sums are computed four at a time and in an order that does not depend on the pair lists.
#include "common/core/error.hpp"
#include "common/core/in_lanes.hpp"
#include "coupler/mapping.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace poretwin::coupling {
namespace {

using Size = std::size_t;

/// Computes sum_j w_ij value_j, K values per point, for every point i of the blocks, and passes it to take(i, sums,
/// lane).
template <Size K, int D, class Take>
void multiply(std::span<const typename PairBlocks<D>::Block> blocks, const PairWeights& weights,
              const std::vector<double>& value, const Take& take) {
  for_each_in_lanes(
      blocks.size(), worth_threads_in_blocks, [&](Size b) __attribute__((always_inline)) {
        const auto& block = blocks[b];
        std::array<Quad, K> total{};
        for (Size p = block.first; p < weights.last[b]; ++p) {
          const double* const v = value.data() + weights.candidate[p] * K;
          const Lanes w = weights.weight[p].v;
          for (Size k = 0; k < K; ++k) total[k].v += w * v[k];
        }
        for (Size l = 0; l < block.used; ++l) take(block.point[l], total, l);
      });
}

/// Givers and receivers of one field, with a factor (`scale`) on the weights of each receiver.
template <int D>
class Shares {
 public:
  /// All weights use the receivers' kernels: by_giver at the givers' points, by_receiver at the receivers' points.
  Shares(const PairBlocks<D>& at_givers, const PairBlocks<D>& at_receivers, const PairWeights& by_giver,
         const PairWeights& by_receiver, const PointSet& givers, const PointSet& receivers, const Field& amounts)
      : at_givers_(at_givers),
        at_receivers_(at_receivers),
        givers_(givers),
        receivers_(receivers),
        by_giver_(by_giver),
        by_receiver_(by_receiver),
        components_(static_cast<Size>(amounts.components)),
        size_(givers.size(), 0.0),
        scale_(receivers.size() + n_lanes, 0.0),
        got_(receivers.size() + n_lanes) {
    for (Size i = 0; i < givers.n_active; ++i)
      for (Size c = 0; c < components_; ++c) size_[i] += std::abs(amounts.values[i * components_ + c]);
    std::fill_n(scale_.begin(), receivers.n_active, 1.0);
  }

  /// Finds factors with which an even distribution over the givers arrives evenly, however disordered the points are:
  /// of the givers' total volume each receiver then gets a share equal to its own volume (Sinkhorn 1967). Only
  /// receivers inside the cloud of the givers are balanced; at its edge the weights remain those of the kernel.
  void balance() {
    const auto wanted = wanted_inside();
    std::vector<double> part(givers_.size(), 0.0);
    for (int round = 0; round < balancing_rounds; ++round) {
      weigh_receivers([&](Size i, double total) {
        const bool gives = size_[i] > 0.0 && total > no_weight;
        part[i] = gives ? givers_.volume[i] / total : 0.0;
      });
      receive<1>(part, got_);
      if (rescale(wanted) < balancing_tolerance) break;
    }
  }

  /// Passes the sum of the receivers' scaled weights to take(giver, sum), for every active giver.
  template <class Take>
  void weigh_receivers(const Take& take) {
    for (Size j = receivers_.n_active; j < receivers_.size(); ++j) {
      const double owner = receivers_.owner[j];
      scale_[j] = owner < 0.0 ? 0.0 : scale_[static_cast<Size>(owner)];
    }
    multiply<1, D>(at_givers_.active_blocks(), by_giver_, scale_,
                   [&](Size i, const auto& total, Size lane) { take(i, total[0].v[lane]); });
  }

  /// Computes sum_i w_ij value_i for the active receivers j, without the factors but with the parts of their ghosts. A
  /// point has K values.
  template <Size K>
  void receive(const std::vector<double>& value, std::vector<double>& got) const {
    multiply<K, D>(at_receivers_.blocks(), by_receiver_, value, [&](Size j, const auto& total, Size lane) {
      for (Size k = 0; k < K; ++k) got[j * K + k] = total[k].v[lane];
    });
    for (Size j = receivers_.n_active; j < receivers_.size(); ++j) {
      const double owner = receivers_.owner[j];
      if (owner < 0.0) continue;
      for (Size c = 0; c < K; ++c) got[static_cast<Size>(owner) * K + c] += got[j * K + c];
    }
  }

  [[nodiscard]] const std::vector<double>& size() const { return size_; }
  [[nodiscard]] const std::vector<double>& scale() const { return scale_; }

 private:
  /// The volume that each active receiver should get: its own, or 0 where the givers do not surround it.
  std::vector<double> wanted_inside() const {
    constexpr Size K = D + 1;
    std::vector<double> giving(givers_.size());
    for (Size i = 0; i < giving.size(); ++i) {
      // Behind walls the images of givers stand for the cloud's mirrored part: a wall is no edge of it.
      const double owner = i < givers_.n_active ? static_cast<double>(i) : givers_.owner[i];
      giving[i] = owner >= 0.0 && size_[static_cast<Size>(owner)] > 0.0 ? 1.0 : 0.0;
    }
    std::vector<double> sums(receivers_.size() * K, 0.0);
    const auto blocks = at_receivers_.blocks();
    for_each_in_lanes(
        blocks.size(), worth_threads_in_blocks, [&](Size b) __attribute__((always_inline)) {
          const auto& block = blocks[b];
          Lanes weight{};
          std::array<Quad, D> moment{};
          for (Size p = block.first; p < by_receiver_.last[b]; ++p) {
            const auto& node = at_receivers_.nodes()[by_receiver_.candidate[p]];
            const Lanes w = by_receiver_.weight[p].v * giving[by_receiver_.candidate[p]];
            weight += w;
            for (Size a = 0; a < D; ++a) moment[a].v += w * (node.x[a] - block.x[a].v);
          }
          for (Size l = 0; l < block.used; ++l) {
            double* const out = sums.data() + block.point[l] * K;
            out[0] = weight[l] * receivers_.smoothing_length[block.point[l]];
            for (Size a = 0; a < D; ++a) out[1 + a] = moment[a].v[l];
          }
        });
    std::vector<double> wanted(receivers_.n_active + n_lanes, 0.0);
    for (Size j = 0; j < receivers_.n_active; ++j) {
      double square = 0.0;
      for (Size a = 0; a < D; ++a) square += sums[j * K + 1 + a] * sums[j * K + 1 + a];
      if (std::sqrt(square) <= inside_asymmetry * sums[j * K]) wanted[j] = receivers_.volume[j];
    }
    return wanted;
  }

  /// Multiplies each factor by the ratio of wanted to received volume; returns the largest relative change.
  double rescale(const std::vector<double>& wanted) {
    Quad worst{};
    run_lanes([&]() __attribute__((always_inline)) {
      for (Size j = 0; j < receivers_.n_active; j += n_lanes) {
        const Lanes before = *reinterpret_cast<const LooseLanes*>(scale_.data() + j),
                    want = *reinterpret_cast<const LooseLanes*>(wanted.data() + j),
                    have = *reinterpret_cast<const LooseLanes*>(got_.data() + j) * before;
        const LaneMask balanced = (have > 0.0) & (want > 0.0);
        const Lanes ratio = balanced ? want / (balanced ? have : Lanes{} + 1.0) : Lanes{} + 1.0;
        const Lanes off = ratio - 1.0;
        max_in_place(worst.v, off);
        max_in_place(worst.v, -off);
        Lanes after = before * ratio;
        max_in_place(after, Lanes{} + 0.25);
        min_in_place(after, Lanes{} + 4.0);
        *reinterpret_cast<LooseLanes*>(scale_.data() + j) = balanced ? after : before;
      }
    });
    double most = worst.v[0];
    for (std::size_t l = 1; l < n_lanes; ++l) most = std::max(most, worst.v[l]);
    return most;
  }

  const PairBlocks<D>&at_givers_, &at_receivers_;
  const PointSet &givers_, &receivers_;
  const PairWeights &by_giver_, &by_receiver_;
  Size components_;
  std::vector<double> size_;   ///< [givers] sum of the absolute values of the components; 0: nothing given
  std::vector<double> scale_;  ///< [receivers, padded] factors; a ghost has the factor of its owner
  std::vector<double> got_;    ///< [receivers, padded] received volume, without the factors
};

/// Distributes the amounts, and in the same proportions the amounts carried over from earlier windows.
template <int D, Size Components>
Delivery share_out(Shares<D> shares, const PointSet& givers, const PointSet& receivers, const Field& amounts,
                   std::span<const double> carried) {
  constexpr Size K = Components + 1;
  Delivery out;
  out.values.assign(receivers.n_active * Components, 0.0);
  out.given.assign(Components, 0.0);
  out.delivered.assign(Components, 0.0);
  out.undelivered.assign(Components, 0.0);
  shares.balance();
  std::vector<double> total(givers.n_active);
  shares.weigh_receivers([&](Size i, double sum) { total[i] = sum; });
  const auto& size = shares.size();
  std::vector<double> given(givers.size() * K, 0.0), got(receivers.size() * K);
  double parts = 0.0;
  for (Size i = 0; i < givers.n_active; ++i) {
    const double* const amount = amounts.values.data() + i * Components;
    for (Size c = 0; c < Components; ++c) out.given[c] += amount[c];
    if (size[i] == 0.0) continue;
    if (!(total[i] > no_weight)) {
      for (Size c = 0; c < Components; ++c) out.undelivered[c] += amount[c];
      continue;
    }
    for (Size c = 0; c < Components; ++c) given[i * K + c] = amount[c] / total[i];
    given[i * K + Components] = size[i] / total[i];
    parts += size[i];
  }
  shares.template receive<K>(given, got);
  for (Size j = 0; j < receivers.n_active; ++j)
    for (Size c = 0; c < K; ++c) got[j * K + c] *= shares.scale()[j];
  for (Size c = 0; c < Components; ++c) {
    const double rest = c < carried.size() ? carried[c] : 0.0;
    const bool taken = parts > 0.0, more = taken && rest != 0.0;
    if (!taken) out.undelivered[c] += rest;
    for (Size j = 0; j < receivers.n_active; ++j) {
      const double value = got[j * K + c] + (more ? rest * got[j * K + Components] / parts : 0.0);
      out.values[j * Components + c] = value;
      out.delivered[c] += value;
    }
  }
  return out;
}

}  // namespace

template <int D>
Delivery Sharing<D>::conservative(const PairBlocks<D>& at_givers, const PairBlocks<D>& at_receivers,
                                  const PointSet& givers, const PointSet& receivers, const Field& amounts,
                                  std::span<const double> carried) {
  if (!weights_at(at_givers)) {
    at_givers.template weigh_all<Kernel::of_candidate>(at_givers.active_blocks(), givers, by_giver_);
    weighed_ = &at_givers;
    weighed_state_ = at_givers.state();
  }
  at_receivers.template weigh_all<Kernel::of_block>(at_receivers.blocks(), receivers, by_receiver_);
  Shares<D> shares(at_givers, at_receivers, by_giver_, by_receiver_, givers, receivers, amounts);
  if (amounts.components == 1) return share_out<D, 1>(std::move(shares), givers, receivers, amounts, carried);
  if (amounts.components == D) return share_out<D, D>(std::move(shares), givers, receivers, amounts, carried);
  throw PeerError("field '" + amounts.name + "' is shared out: expected a number or a vector of " + std::to_string(D) +
                  " components, got " + std::to_string(amounts.components));
}

template class Sharing<2>;
template class Sharing<3>;

}  // namespace poretwin::coupling
