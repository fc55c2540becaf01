// Conservative mapping: amounts shared out by balanced weights. Weights stand twice, by giver and by receiver, so that
// sums over either run four at a time and in an order of their own that no list can change.
#include "common/core/error.hpp"
#include "common/core/in_lanes.hpp"
#include "coupler/mapping.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace poretwin::coupling {
namespace {

using Size = std::size_t;

/// Whose smoothing length a pair's kernel has.
enum class Kernel { of_candidate, of_block };

template <Kernel K, int D>
void weigh_all(const PairBlocks<D>& pairs, std::span<const typename PairBlocks<D>::Block> blocks, const PointSet& of,
               typename Sharing<D>::Weights& out) {
  const auto* const nodes = pairs.nodes().data();
  out.last.resize(blocks.size());
  out.candidate.resize(pairs.n_candidates());
  out.weight.resize(pairs.n_candidates());
  for_each_in_lanes(
      blocks.size(), worth_threads_in_blocks, [&](Size b) __attribute__((always_inline)) {
        const auto& block = blocks[b];
        const std::array<Quad, D> x = block.x;
        Lanes shrink{}, amplitude{};
        if constexpr (K == Kernel::of_block)
          for (Size l = 0; l < n_lanes; ++l) {
            const auto own = PairBlocks<D>::node_of(of, block.point[l]);
            shrink[l] = own.shrink;
            amplitude[l] = own.amplitude;
          }
        Size n = block.first;
        for (const Index candidate : pairs.candidates(block)) {
          const auto& node = nodes[candidate];
          Lanes w;
          if constexpr (K == Kernel::of_block)
            weigh<D>(node, x, shrink, amplitude, w);
          else
            weigh<D>(node, x, node.shrink, node.amplitude, w);
          out.candidate[n] = candidate;
          out.weight[n].v = w;
          n += any(w > 0.0) ? 1 : 0;
        }
        out.last[b] = n;
      });
}

/// sum_j w_ij value_j for every point i of the blocks, K values a point; `value` in cell order, the sums in the
/// caller's.
template <Size K, int D>
void multiply(std::span<const typename PairBlocks<D>::Block> blocks, const typename Sharing<D>::Weights& weights,
              const std::vector<double>& value, std::vector<double>& sum) {
  for_each_in_lanes(
      blocks.size(), worth_threads_in_blocks, [&](Size b) __attribute__((always_inline)) {
        const auto& block = blocks[b];
        std::array<Quad, K> total{};
        for (Size p = block.first; p < weights.last[b]; ++p) {
          const double* const v = value.data() + weights.candidate[p] * K;
          const Lanes w = weights.weight[p].v;
          for (Size k = 0; k < K; ++k) total[k].v += w * v[k];
        }
        for (Size l = 0; l < block.used; ++l)
          for (Size k = 0; k < K; ++k) sum[block.point[l] * K + k] = total[k].v[l];
      });
}

/// Givers and receivers of one field, and how the receivers' weights are to be scaled.
template <int D>
class Shares {
 public:
  using Weights = typename Sharing<D>::Weights;
  Shares(Weights& by_giver, Weights& by_receiver, const PairBlocks<D>& at_givers, const PairBlocks<D>& at_receivers,
         const PointSet& givers, const PointSet& receivers, const Field& amounts)
      : at_givers_(at_givers),
        at_receivers_(at_receivers),
        givers_(givers),
        receivers_(receivers),
        by_giver_(by_giver),
        by_receiver_(by_receiver),
        components_(static_cast<Size>(amounts.components)),
        size_(givers.size(), 0.0),
        scale_(receivers.n_active, 1.0) {
    // Receivers weigh by their own kernels on either side.
    weigh_all<Kernel::of_candidate, D>(at_givers, at_givers.active_blocks(), givers, by_giver);
    weigh_all<Kernel::of_block, D>(at_receivers, at_receivers.blocks(), receivers, by_receiver);
    for (Size i = 0; i < givers.n_active; ++i)
      for (Size c = 0; c < components_; ++c) size_[i] += std::abs(amounts.values[i * components_ + c]);
  }

  /// Factors under which an even giving arrives evenly however disordered the points are: what reaches a receiver from
  /// the giving volumes is to be its own volume (Sinkhorn 1967). Only receivers inside the cloud of those that give are
  /// balanced; at its edge the shares stay as the kernel has them.
  void balance() {
    const auto inside = receivers_inside();
    std::vector<double> part(givers_.size(), 0.0), load;
    for (int round = 0; round < balancing_rounds; ++round) {
      const auto& total = totals();
      for (Size i = 0; i < total.size(); ++i)
        part[i] = size_[i] > 0.0 && total[i] > no_weight ? givers_.volume[i] / total[i] : 0.0;
      receive<1>(part, load);
      double worst = 0.0;
      for (Size j = 0; j < scale_.size(); ++j) {
        const double got = load[j] * scale_[j];
        if (!(got > 0.0) || !inside[j]) continue;
        const double ratio = receivers_.volume[j] / got;
        worst = std::max(worst, std::abs(ratio - 1.0));
        scale_[j] = std::clamp(scale_[j] * ratio, 0.25, 4.0);
      }
      if (worst < balancing_tolerance) break;
    }
  }

  /// Of the active givers: the sum of their receivers' weights.
  const std::vector<double>& totals() {
    const auto order = at_givers_.order();
    in_order_.resize(order.size());
    for (Size k = 0; k < order.size(); ++k) {
      const double owner = receivers_.owner[order[k]];
      in_order_[k] = owner < 0.0 ? 0.0 : scale_[static_cast<Size>(owner)];
    }
    total_.resize(givers_.n_active);
    multiply<1, D>(at_givers_.active_blocks(), by_giver_, in_order_, total_);
    return total_;
  }

  /// sum_i w_ij value_i of the active receivers, what their ghosts get included; K values a point, not yet scaled.
  template <Size K>
  void receive(const std::vector<double>& value, std::vector<double>& got) {
    const auto order = at_receivers_.order();
    in_order_.resize(order.size() * K);
    for (Size k = 0; k < order.size(); ++k)
      for (Size c = 0; c < K; ++c) in_order_[k * K + c] = value[order[k] * K + c];
    got.resize(receivers_.size() * K);
    multiply<K, D>(at_receivers_.blocks(), by_receiver_, in_order_, got);
    for (Size j = receivers_.n_active; j < receivers_.size(); ++j) {
      const double owner = receivers_.owner[j];
      if (owner < 0.0) continue;
      for (Size c = 0; c < K; ++c) got[static_cast<Size>(owner) * K + c] += got[j * K + c];
    }
    got.resize(receivers_.n_active * K);
  }

  [[nodiscard]] const std::vector<double>& size() const { return size_; }
  [[nodiscard]] const std::vector<double>& scale() const { return scale_; }

 private:
  /// Do those that give lie all around?
  std::vector<char> receivers_inside() {
    constexpr Size K = D + 1;
    std::vector<double> giving(at_receivers_.nodes().size());
    for (Size k = 0; k < giving.size(); ++k) giving[k] = size_[at_receivers_.order()[k]] > 0.0 ? 1.0 : 0.0;
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
    for (Size j = receivers_.n_active; j < receivers_.size(); ++j)
      if (const double owner = receivers_.owner[j]; owner >= 0.0)
        for (Size c = 0; c < K; ++c) sums[static_cast<Size>(owner) * K + c] += sums[j * K + c];
    std::vector<char> inside(receivers_.n_active);
    for (Size j = 0; j < inside.size(); ++j) {
      double square = 0.0;
      for (Size a = 0; a < D; ++a) square += sums[j * K + 1 + a] * sums[j * K + 1 + a];
      inside[j] = std::sqrt(square) <= inside_asymmetry * sums[j * K];
    }
    return inside;
  }

  const PairBlocks<D>&at_givers_, &at_receivers_;
  const PointSet &givers_, &receivers_;
  const Weights &by_giver_, &by_receiver_;
  Size components_;
  std::vector<double> size_;   ///< [givers] sum of the absolute components: 0, nothing is given
  std::vector<double> scale_;  ///< [active receivers]
  std::vector<double> in_order_, total_;
};

/// What the receivers get of the amounts, and of the key by which carried amounts are shared out.
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
  const auto& total = shares.totals();
  const auto& size = shares.size();
  std::vector<double> given(givers.size() * K, 0.0), got;
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
    const bool taken = parts > 0.0;
    if (!taken) out.undelivered[c] += rest;
    for (Size j = 0; j < receivers.n_active; ++j) {
      const double value = got[j * K + c] + (taken ? rest * got[j * K + Components] / parts : 0.0);
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
  Shares<D> shares(by_giver_, by_receiver_, at_givers, at_receivers, givers, receivers, amounts);
  if (amounts.components == 1) return share_out<D, 1>(std::move(shares), givers, receivers, amounts, carried);
  if (amounts.components == D) return share_out<D, D>(std::move(shares), givers, receivers, amounts, carried);
  throw PeerError("field '" + amounts.name + "' is shared out: expected a number or a vector of " + std::to_string(D) +
                  " components, got " + std::to_string(amounts.components));
}

template class Sharing<2>;
template class Sharing<3>;

}  // namespace poretwin::coupling
