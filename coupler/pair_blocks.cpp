#include "coupler/pair_blocks.hpp"

#include "common/core/in_lanes.hpp"
#include "common/particles/kernel.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace poretwin::coupling {
namespace {

using Size = std::size_t;

template <int D>
Vec<D> point(const PointSet& points, Size i) {
  return Eigen::Map<const Vec<D>>(points.position.data() + i * D);
}

template <int D>
VecArray<D> all_points(const PointSet& points, Size begin, Size end) {
  VecArray<D> out(end - begin);
  for (Size i = begin; i < end; ++i) out[i - begin] = point<D>(points, i);
  return out;
}

/// Maximum of 0 and f(0) .. f(n - 1), computed in four independent chains of comparisons.
template <class F>
double largest_of(Size n, F&& f) {
  std::array<double, 4> most{};
  Size i = 0;
  for (; i + 4 <= n; i += 4)
    for (Size k = 0; k < 4; ++k) most[k] = std::max(most[k], f(i + k));
  for (; i < n; ++i) most[0] = std::max(most[0], f(i));
  return *std::max_element(most.begin(), most.end());
}

template <int D>
double largest_move(const std::vector<double>& now, const std::vector<double>& then) {
  return std::sqrt(largest_of(now.size() / D, [&](Size i) {
    double square = 0.0;
    for (Size d = i * D; d < (i + 1) * D; ++d) square += (now[d] - then[d]) * (now[d] - then[d]);
    return square;
  }));
}

double largest_growth(const std::vector<double>& now, const std::vector<double>& then) {
  return largest_of(now.size(), [&](Size i) { return now[i] - then[i]; });
}

bool same(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0);
}

double largest(const std::vector<double>& values) {
  return values.empty() ? 0.0 : *std::max_element(values.begin(), values.end());
}

}  // namespace

template <int D>
bool PairBlocks<D>::Then::stands(const PointSet& now) const {
  return same(now.position, position) && same(now.smoothing_length, length) && same(now.volume, volume);
}

template <int D>
void PairBlocks<D>::update(std::span<const Update> updates) {
  Size n_points = 0;
  for (const auto& [pairs, of, around] : updates) n_points += of.size() + around.size();
  std::vector<char> moved(updates.size());
  const auto prepare = [&](Size k) { moved[k] = updates[k].pairs->prepare(updates[k].of, updates[k].around); };
  if (n_points < worth_threads_in_points)
    for (Size k = 0; k < updates.size(); ++k) prepare(k);
  else
    for_each_part(updates.size(), prepare);
  std::vector<std::pair<Size, Size>> parts;
  for (Size k = 0; k < updates.size(); ++k)
    for (Size part = 0; part < updates[k].pairs->parts_; ++part) parts.emplace_back(k, part);
  for_each_part(parts.size(), [&](Size p) {
    const auto& [k, part] = parts[p];
    updates[k].pairs->find_candidates(updates[k].of, part);
  });
  for (Size k = 0; k < updates.size(); ++k) {
    if (!moved[k]) continue;
    updates[k].pairs->join_candidates();
    updates[k].pairs->gather(updates[k].of, updates[k].around);
  }
}

template <int D>
bool PairBlocks<D>::prepare(const PointSet& of, const PointSet& around) {
  parts_ = 0;
  const bool of_stands = made_ && of.n_active == n_active_ && of_last_.stands(of);
  const bool around_stands = made_ && around_last_.stands(around);
  if (of_stands && around_stands) {
    ++reuses_;
    return false;
  }
  const double gone = moved(of, around);
  if (made_ && gone <= skin_) {
    ++reuses_;
    served_ = true;
  } else {
    const double reach = sph::support_radius * std::max(largest(of.smoothing_length), largest(around.smoothing_length));
    in_vain_ = served_ || gone <= relative_skin * reach ? 0 : in_vain_ + 1;
    prepare_search(of, around, (in_vain_ < vain_lists ? relative_skin : no_skin) * reach);
    ++rebuilds_;
    served_ = false;
  }
  if (!of_stands) of_last_ = {of.position, of.smoothing_length, of.volume};
  if (!around_stands) around_last_ = {around.position, around.smoothing_length, around.volume};
  ++state_;
  return true;
}

template <int D>
double PairBlocks<D>::moved(const PointSet& of, const PointSet& around) const {
  if (!made_) return 0.0;
  if (of.n_active != n_active_ || of.position.size() != of_listed_.position.size() ||
      around.position.size() != around_listed_.position.size())
    return std::numeric_limits<double>::infinity();
  const double growth = std::max(largest_growth(of.smoothing_length, of_listed_.length),
                                 largest_growth(around.smoothing_length, around_listed_.length));
  return largest_move<D>(of.position, of_listed_.position) + largest_move<D>(around.position, around_listed_.position) +
         sph::support_radius * growth;
}

template <int D>
void PairBlocks<D>::prepare_search(const PointSet& of, const PointSet& around, double skin) {
  const double reach = sph::support_radius * std::max(largest(of.smoothing_length), largest(around.smoothing_length));
  // Often only one of the clouds moves: the blocks or cells of a cloud that has not moved are kept.
  if (!made_ || !around_listed_.stands(around)) {
    sort_cells(around);
    around_listed_ = {around.position, around.smoothing_length, around.volume};
  }
  if (!made_ || n_active_ != of.n_active || !of_listed_.stands(of)) {
    n_of_ = of.size();
    n_active_ = of.n_active;
    blocks_.clear();
    make_blocks(of, 0, of.n_active, reach);
    n_active_blocks_ = blocks_.size();
    make_blocks(of, of.n_active, of.size(), reach);
    of_listed_ = {of.position, of.smoothing_length, of.volume};
  }
  nodes_.resize(around.size());
  made_ = true;
  skin_ = skin;
  parts_ = small_parts_for(blocks_.size(), worth_threads_in_blocks);
  finders_.resize(parts_);
}

/// Makes blocks of points that lie close together: the four points come from neighbouring cells two spacings wide, and
/// are never farther apart than `reach`.
template <int D>
void PairBlocks<D>::make_blocks(const PointSet& of, Size begin, Size end, double reach) {
  if (begin == end) return;
  double volume = 0.0;
  for (Size i = begin; i < end; ++i) volume += of.volume[i];
  const double spacing = std::pow(volume / static_cast<double>(end - begin), 1.0 / D);
  const auto points = all_points<D>(of, begin, end);
  sph::CellGrid<D> grid;
  // Slightly less than two spacings: on a lattice, rounding must not put the first point of a cell into the previous
  // cell.
  grid.build(points, (2.0 - 1e-6) * spacing);
  Vec<D> lower, upper;
  for (const Index i : grid.order()) {
    if (!blocks_.empty()) {
      auto& last = blocks_.back();
      const Vec<D> low = lower.cwiseMin(points[i]), high = upper.cwiseMax(points[i]);
      if (last.point[0] >= begin && last.used < n_lanes && (high - low).maxCoeff() <= reach) {
        last.point[last.used++] = static_cast<Index>(begin) + i;
        lower = low;
        upper = high;
        continue;
      }
    }
    Block block{};
    block.point.fill(static_cast<Index>(begin) + i);
    block.used = 1;
    blocks_.push_back(block);
    lower = upper = points[i];
  }
}

template <int D>
void PairBlocks<D>::sort_cells(const PointSet& around) {
  const Size n = around.size();
  grid_ = {};
  if (n > 0) grid_.build(all_points<D>(around, 0, n), 0.5 * sph::support_radius * largest(around.smoothing_length));
  for (auto& x : x_) x.resize(n + n_lanes);  // allows reading four at a time
  reach_.resize(n + n_lanes);
  index_.resize(n + n_lanes);
  for (Size m = 0; m < n; ++m) {
    const Size j = grid_.order()[m];
    for (Size d = 0; d < D; ++d) x_[d][m] = around.position[j * D + d];
    reach_[m] = sph::support_radius * around.smoothing_length[j];
    index_[m] = static_cast<Index>(j);
  }
}

/// Writes to `found` those points of the finder's pieces that are within reach of a box; returns their number.
template <int D>
std::size_t PairBlocks<D>::take_near(const Vec<D>& lower, const Vec<D>& upper, double own, Finder& finder) const {
  Size room = n_lanes;
  for (const auto& [begin, end] : finder.pieces) room += end - begin;
  if (finder.found.size() < room) finder.found.resize(2 * room);
  Size n = 0;
  run_lanes([&]() __attribute__((always_inline)) {
    constexpr LaneMask ahead{0, 1, 2, 3};
    auto* const found = finder.found.data();
    for (const auto& [begin, end] : finder.pieces)
      for (Size m = begin; m < end; m += n_lanes) {
        Lanes square{}, radius = *reinterpret_cast<const LooseLanes*>(reach_.data() + m);
        for (Size d = 0; d < D; ++d) {
          const Lanes x = *reinterpret_cast<const LooseLanes*>(x_[d].data() + m);
          Lanes apart = lower[static_cast<Eigen::Index>(d)] - x;
          max_in_place(apart, x - upper[static_cast<Eigen::Index>(d)]);
          max_in_place(apart, Lanes{});
          square += apart * apart;
        }
        max_in_place(radius, Lanes{} + own);
        radius += skin_;
        const LaneMask near = (square < radius * radius) & (ahead < static_cast<long long>(end - m));
        // Every point is written. If it is out of reach, the next one overwrites it: a branch would be mispredicted too
        // often.
        for (Size l = 0; l < n_lanes; ++l) {
          found[n] = index_[m + l];
          n += static_cast<Size>(near[l] & 1);
        }
      }
  });
  return n;
}

/// Appends the first n of `found` to the candidates in the caller's order, with the help of one bit per point. This is
/// some five times as fast as sorting.
template <int D>
void PairBlocks<D>::append_in_order(Size n, Finder& finder) {
  auto &bits = finder.bits, &words = finder.words;
  Size first = words.size(), last = 0;
  for (Size k = 0; k < n; ++k) {
    const Size j = finder.found[k], word = j / 64;
    bits[word] |= std::uint64_t{1} << j % 64;
    words[word / 64] |= std::uint64_t{1} << word % 64;
    first = std::min(first, word / 64);
    last = std::max(last, word / 64 + 1);
  }
  finder.candidate.resize(finder.candidate.size() + n);
  Index* next = finder.candidate.data() + finder.candidate.size() - n;
  const auto take_bits = [](std::uint64_t& word, const auto& take) {
    for (; word != 0; word &= word - 1) take(static_cast<Size>(std::countr_zero(word)));
  };
  for (Size w = first; w < last; ++w)
    take_bits(words[w], [&](Size word) {
      take_bits(bits[w * 64 + word], [&](Size bit) { *next++ = static_cast<Index>((w * 64 + word) * 64 + bit); });
    });
}

/// Finds the candidates for the blocks of one part, as a separate list.
template <int D>
void PairBlocks<D>::find_candidates(const PointSet& of, Size part) {
  const double longest = largest(reach_);
  Finder& finder = finders_[part];
  finder.candidate.clear();
  finder.bits.assign((nodes_.size() + 63) / 64, 0);
  finder.words.assign((finder.bits.size() + 63) / 64, 0);
  for (Size b = first_block(part); b < first_block(part + 1); ++b) {
    auto& block = blocks_[b];
    Vec<D> lower = point<D>(of, block.point[0]), upper = lower;
    double own = 0.0;
    for (Size l = 0; l < block.used; ++l) {
      const Vec<D> x = point<D>(of, block.point[l]);
      lower = lower.cwiseMin(x);
      upper = upper.cwiseMax(x);
      own = std::max(own, sph::support_radius * of.smoothing_length[block.point[l]]);
    }
    const double reach = std::max(own, longest) + skin_;
    finder.pieces.clear();
    grid_.for_each_piece_near((lower.array() - reach).matrix(), (upper.array() + reach).matrix(),
                              [&](Index first, Index last) {
                                finder.pieces.push_back({first, last});
                              });
    const Size n = take_near(lower, upper, own, finder);
    block.first = finder.candidate.size();
    append_in_order(n, finder);
    block.last = finder.candidate.size();
  }
}

/// Joins the candidate lists of all parts; does nothing where the lists were kept.
template <int D>
void PairBlocks<D>::join_candidates() {
  if (parts_ == 0) return;
  candidate_.clear();
  longest_ = 0;
  for (Size part = 0; part < parts_; ++part) {
    const Size shift = candidate_.size();
    for (Size b = first_block(part); b < first_block(part + 1); ++b) {
      blocks_[b].first += shift;
      blocks_[b].last += shift;
      longest_ = std::max(longest_, blocks_[b].last - blocks_[b].first);
    }
    candidate_.insert(candidate_.end(), finders_[part].candidate.begin(), finders_[part].candidate.end());
  }
}

template <int D>
typename PairBlocks<D>::Node PairBlocks<D>::node_of(const PointSet& points, Size i) {
  Node out;
  const double per_length = 1.0 / points.smoothing_length[i];
  for (Size d = 0; d < D; ++d) out.x[d] = points.position[i * D + d];
  out.length = points.smoothing_length[i];
  out.shrink = per_length / sph::support_radius;
  out.amplitude = points.volume[i] * sph::WendlandC2<D>::normalisation(1.0);
  for (int d = 0; d < D; ++d) out.amplitude *= per_length;
  return out;
}

template <int D>
void PairBlocks<D>::gather(const PointSet& of, const PointSet& around) {
  parallel_ranges(nodes_.size(), worth_threads_in_points, [&](Size begin, Size end) {
    for (Size j = begin; j < end; ++j) nodes_[j] = node_of(around, j);
  });
  parallel_ranges(blocks_.size(), worth_threads_in_points, [&](Size begin, Size end) {
    for (auto& block : std::span(blocks_).subspan(begin, end - begin))
      for (Size l = 0; l < n_lanes; ++l)
        for (Size d = 0; d < D; ++d) block.x[d].v[l] = of.position[block.point[l] * D + d];
  });
}

template <int D>
template <Kernel K>
void PairBlocks<D>::weigh_all(std::span<const Block> blocks, const PointSet& of, PairWeights& out) const {
  out.last.resize(blocks.size());
  out.candidate.resize(n_candidates());
  out.weight.resize(n_candidates());
  for_each_in_lanes(
      blocks.size(), worth_threads_in_blocks, [&](Size b) __attribute__((always_inline)) {
        const Size first = blocks[b].first;
        out.last[b] =
            first + weigh_block<K, D>(*this, blocks[b], of, out.candidate.data() + first, out.weight.data() + first);
      });
}

template class PairBlocks<2>;
template class PairBlocks<3>;
template void PairBlocks<2>::weigh_all<Kernel::of_block>(std::span<const Block>, const PointSet&, PairWeights&) const;
template void PairBlocks<2>::weigh_all<Kernel::of_candidate>(std::span<const Block>, const PointSet&,
                                                             PairWeights&) const;
template void PairBlocks<3>::weigh_all<Kernel::of_block>(std::span<const Block>, const PointSet&, PairWeights&) const;
template void PairBlocks<3>::weigh_all<Kernel::of_candidate>(std::span<const Block>, const PointSet&,
                                                             PairWeights&) const;

}  // namespace poretwin::coupling
