#include "solid_solver/discretisation/pairs.hpp"

#include "common/core/lanes.hpp"
#include "common/geometry/surfaces.hpp"

#include <array>
#include <limits>

namespace poretwin::solid {
namespace {

/// Rows of one part. Offsets count from the beginning of the part. Each object has cache lines of its own, since lines
/// that threads share are slow to write.
struct alignas(64) Rows {
  std::vector<Index> offset, alone, index;
  Index fill_up(std::size_t i) {
    while (index.size() % n_lanes != 0) index.push_back(static_cast<Index>(i));
    return static_cast<Index>(index.size());
  }
};

/// A pair may be stored in either of its two rows. The entries of a row beyond a multiple of four are moved to their
/// other, later row, so that hardly any row needs padding (otherwise a sixth of all entries).
class PutOff {
 public:
  PutOff(Index first, Index last) : first_(first), newest_(last - first, none) {}
  /// Adds to row i, which begins at `begin`, the entries moved to this row. Moves its own excess to later rows of the
  /// part. may_take(j): whether row j may take entries.
  template <class MayTake>
  void even_out(Index i, std::size_t begin, const MayTake& may_take, std::vector<Index>& index) {
    std::size_t own = index.size();
    for (Index k = newest_[i - first_]; k != none; k = pairs_[k].older) index.push_back(pairs_[k].with);
    for (std::size_t surplus = (index.size() - begin) % n_lanes, m = own; surplus > 0 && m-- > begin;) {
      const Index j = index[m];
      if (!may_take(j)) continue;
      index[m] = index[--own];
      index[own] = index.back();
      index.pop_back();
      pairs_.push_back({i, newest_[j - first_]});
      newest_[j - first_] = static_cast<Index>(pairs_.size() - 1);
      --surplus;
    }
  }

 private:
  static constexpr Index none = std::numeric_limits<Index>::max();
  struct Pair {
    Index with, older;
  };
  Index first_;
  std::vector<Index> newest_;  ///< for each row, the index in pairs_ of its newest entry
  std::vector<Pair> pairs_;
};

/// Fixed or sleeping particles with a moving particle within range: 1 or 0 for each real particle.
std::vector<char> reached(const std::vector<Rows>& parts, std::size_t n_real, const auto& still) {
  std::vector<char> near(n_real, 0);
  for (const auto& rows : parts)
    for (const Index j : rows.index)
      if (j < n_real && still(j)) near[j] = 1;
  return near;
}

/// Appends `count` rows, beginning with `row`.
void append(const Rows& rows, std::size_t row, std::size_t count, Pairs& pairs) {
  const Index from = row == 0 ? 0 : rows.offset[row - 1], to = rows.offset[row + count - 1];
  const auto begin = static_cast<Index>(pairs.index.size());
  pairs.index.insert(pairs.index.end(), rows.index.begin() + from, rows.index.begin() + to);
  for (std::size_t r = row; r < row + count; ++r) {
    pairs.alone.push_back(begin + rows.alone[r] - from);
    pairs.offset.push_back(begin + rows.offset[r] - from);
  }
}

}  // namespace

void list_views(const Pairs& pairs, std::span<const Index> parents, Views& views) {
  const std::size_t n = pairs.size();
  const auto for_each_view = [&](const auto& visit) {
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t m = pairs.alone[i]; m < pairs.offset[i + 1]; ++m)
        if (pairs.index[m] >= n) visit(pairs.index[m] - n, Views::View{static_cast<Index>(i), static_cast<Index>(m)});
  };
  views.offset.assign(parents.size() + 1, 0);
  for_each_view([&](std::size_t k, Views::View) { ++views.offset[k + 1]; });
  for (std::size_t k = 0; k < parents.size(); ++k) views.offset[k + 1] += views.offset[k];
  views.view.resize(views.offset.back());
  std::vector<Index> next(views.offset.begin(), views.offset.end() - 1);
  for_each_view([&](std::size_t k, Views::View view) { views.view[next[k]++] = view; });
  views.first.clear();
  for (std::size_t k = 0; k < parents.size(); ++k)
    if (k == 0 || parents[k] != parents[k - 1]) views.first.push_back(static_cast<Index>(k));
  views.first.push_back(static_cast<Index>(parents.size()));
}

template <int D>
void pair_up(std::span<const Vec<D>> positions, std::size_t n_free, std::size_t n_real, double range,
             std::size_t n_parts, std::span<const char> asleep, std::span<const Index> originals, Pairs& pairs,
             std::span<const char> copies_at_rest) {
  sph::CellGrid<D> particles, images;
  particles.build(positions.first(n_real), range);
  images.build(positions.subspan(n_real), range);
  pairs.offset.assign(1, 0);
  pairs.alone.clear();
  pairs.index.clear();
  pairs.part.clear();
  // Estimated work per row, by which the rows are cut into parts of equal work. Rows of fixed particles (behind rough
  // walls) take less than half of the work of free ones, since only some have free particles within range.
  constexpr std::size_t free_weight = 5, held_weight = 2;
  const std::size_t moving_work = free_weight * n_free, work = moving_work + held_weight * (n_real - n_free);
  for (std::size_t k = 0; k <= n_parts; ++k) {
    const std::size_t share = work * k / n_parts;
    pairs.part.push_back(
        static_cast<Index>(share < moving_work ? share / free_weight : n_free + (share - moving_work) / held_weight));
  }
  const auto still = [&](std::size_t i) { return i >= n_free || (!asleep.empty() && asleep[i] != 0); };
  const auto from = [](std::size_t first) {
    return [first](Index j, double) __attribute__((always_inline)) { return j >= first; };
  };
  auto append_images = [&](std::size_t i, std::vector<Index> & index) __attribute__((always_inline)) {
    const std::size_t begin = index.size();
    if (originals.empty())
      images.append_within(positions[i], range, index, from(0));
    else
      images.append_within(positions[i], range, index, [&](Index m, double) {
        return Surfaces::sees<D>(positions[i], positions[originals[m]], positions[n_real + m]);
      });
    for (std::size_t m = begin; m < index.size(); ++m) index[m] += static_cast<Index>(n_real);
  };
  // A pair of a moving and a still (fixed or sleeping) particle is stored in the row of the moving one.
  std::vector<Rows> moving(n_parts), resting(n_parts);
  const auto pair_moving = [&](std::size_t part) __attribute__((always_inline)) {
    Rows& rows = moving[part];
    const Index first = pairs.part[part], last = pairs.part[part + 1];
    std::vector<Index> beyond;  // particles in other parts
    PutOff later(first, last);
    const auto moves = [&](Index j) { return !still(j); };
    for (Index i = first; i < std::min<std::size_t>(last, n_free); ++i) {
      if (still(i)) continue;
      const std::size_t begin = rows.index.size();
      if (asleep.empty())
        particles.append_within(
            positions[i], range, rows.index, [&](Index j, double) __attribute__((always_inline)) {
              return static_cast<bool>(static_cast<int>(j > i) | static_cast<int>(j < first));
            });
      else
        particles.append_within(
            positions[i], range,
            rows.index, [&](Index j, double) __attribute__((always_inline)) { return j > i || j < first || still(j); });
      beyond.clear();
      if (n_parts > 1) {
        std::size_t own = begin;
        for (std::size_t m = begin; m < rows.index.size(); ++m) {
          const Index j = rows.index[m];
          if (j >= first && j < last)
            rows.index[own++] = j;
          else
            beyond.push_back(j);
        }
        rows.index.resize(own);
      }
      later.even_out(i, begin, moves, rows.index);
      rows.alone.push_back(rows.fill_up(i));
      rows.index.insert(rows.index.end(), beyond.begin(), beyond.end());
      append_images(i, rows.index);
      rows.offset.push_back(rows.fill_up(i));
    }
  };
  const auto in_lanes = [&](const auto& pair) {
    for_each_part(n_parts, [&](std::size_t part) { run_lanes([&]() __attribute__((always_inline)) { pair(part); }); });
  };
  in_lanes(pair_moving);
  std::vector<char> near = reached(moving, n_real, still);
  for (std::size_t c = 0; c < copies_at_rest.size() && (n_free < n_real || !asleep.empty()); ++c)
    if (!copies_at_rest[c])
      particles.for_each_within(positions[n_real + c], range, [&](Index j, double) { near[j] = near[j] || still(j); });
  in_lanes([&](std::size_t part) __attribute__((always_inline)) {
    Rows& rows = resting[part];
    const Index first = pairs.part[part], last = pairs.part[part + 1];
    std::vector<Index> around;
    for (std::size_t i = asleep.empty() ? std::max<std::size_t>(first, n_free) : first; i < last; ++i) {
      if (!still(i)) continue;
      around.clear();
      const bool all = n_parts > 1 || !asleep.empty(), listed = near[i] || i < n_free;
      if (listed) particles.append_within(positions[i], range, around, from(all ? 0 : n_free));
      auto shared = [&](Index j) { return j >= first && j < last && (!still(j) || near[j] == near[i]); };
      for (const Index j : around)
        if (j > i && still(j) && shared(j)) rows.index.push_back(j);
      rows.alone.push_back(rows.fill_up(i));
      if (listed) append_images(i, rows.index);
      for (const Index j : around)
        if (!shared(j)) rows.index.push_back(j);
      rows.offset.push_back(rows.fill_up(i));
    }
  });
  for (std::size_t part = 0; part < n_parts; ++part) {
    std::array<std::size_t, 2> done{};  // number of rows done: of moving, of still particles
    for (std::size_t i = pairs.part[part], next = i; i < pairs.part[part + 1]; i = next) {
      const bool rests = still(i);
      while (next < pairs.part[part + 1] && still(next) == rests) ++next;
      append(rests ? resting[part] : moving[part], done[rests], next - i, pairs);
      done[rests] += next - i;
    }
  }
  pairs.skipped.clear();
  if (asleep.empty()) return;
  pairs.skipped.assign(n_real, 0);
  for (std::size_t i = 0; i < n_free; ++i) pairs.skipped[i] = asleep[i] != 0 && near[i] == 0;
}

template void pair_up<2>(std::span<const Vec<2>>, std::size_t, std::size_t, double, std::size_t, std::span<const char>,
                         std::span<const Index>, Pairs&, std::span<const char>);
template void pair_up<3>(std::span<const Vec<3>>, std::size_t, std::size_t, double, std::size_t, std::span<const char>,
                         std::span<const Index>, Pairs&, std::span<const char>);

}  // namespace poretwin::solid
