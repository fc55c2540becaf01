// Neighbours of one cloud of points in another, in blocks of four points with a common list of candidates, so that sums
// are computed for four points at once. Lists are valid until points have moved by a margin (skin). Keeping a list
// never changes a result: candidates are in the caller's order, and those out of reach have weight exactly 0.
#pragma once

#include "common/core/lanes.hpp"
#include "common/core/vector.hpp"
#include "common/coupling/exchange.hpp"
#include "common/particles/neighbours.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace poretwin::coupling {

/// Margin (Verlet skin) added to every support radius, as a fraction of the largest radius: lists remain valid until
/// the sum of the largest displacements in both clouds reaches it. The margin is vain if a list serves one update only,
/// even if it has this margin. After `vain_lists` such lists in a row only `no_skin` is added, for rounding errors:
/// longer lists would save no rebuild.
inline constexpr double relative_skin = 0.1, no_skin = 1e-6;
inline constexpr int vain_lists = 4;

/// Least number of blocks, and of points with little work each, for which several threads are worth their overhead.
inline constexpr std::size_t worth_threads_in_blocks = 128, worth_threads_in_points = 1024;

/// Whose smoothing length and volume determine the weight of a pair: the candidate's, or those of the block's point.
enum class Kernel { of_candidate, of_block };

/// Weights of all pairs of two clouds, except pairs out of reach. The weights of block b begin at blocks[b].first and
/// end before last[b].
struct PairWeights {
  std::vector<std::size_t> last;
  std::vector<Index> candidate;
  std::vector<Quad> weight;
};

template <int D>
class PairBlocks {
 public:
  /// A candidate, with the Wendland C2 kernel W(r, h) V = amplitude u^4 (5 - 4 u), u = max(0, 1 - r shrink).
  struct Node {
    std::array<double, D> x;  ///< m
    double shrink;            ///< 1/m, 1 / (2 h)
    double amplitude;         ///< V times the kernel's value at r = 0
    double length;            ///< m, h
  };
  /// Four points; if a block has fewer, one point is repeated in the free lanes.
  struct Block {
    std::array<Quad, D> x;
    std::array<Index, n_lanes> point;  ///< indices in the caller's order
    std::size_t used;
    std::size_t first, last;  ///< range of its candidates
  };

  /// Blocks to update, and the two clouds to which they belong.
  struct Update {
    PairBlocks* pairs;
    const PointSet &of, &around;
  };
  /// Updates the blocks of all points of `of`, their candidates among all points of `around`, and the positions.
  /// Several pairs of clouds are updated in parallel.
  static void update(std::span<const Update> updates);
  void update(const PointSet& of, const PointSet& around) {
    const Update one{this, of, around};
    update(std::span(&one, 1));
  }

  /// All blocks; those of active points come first.
  [[nodiscard]] std::span<const Block> blocks() const { return blocks_; }
  [[nodiscard]] std::span<const Block> active_blocks() const { return std::span(blocks_).first(n_active_blocks_); }
  [[nodiscard]] std::span<const Index> candidates(const Block& b) const {
    return std::span(candidate_).subspan(b.first, b.last - b.first);
  }
  [[nodiscard]] std::size_t longest_list() const { return longest_; }
  [[nodiscard]] std::size_t n_candidates() const { return candidate_.size(); }
  /// The points of `around`.
  [[nodiscard]] std::span<const Node> nodes() const { return nodes_; }
  /// Points of `of`.
  [[nodiscard]] std::size_t size() const { return n_of_; }
  [[nodiscard]] std::size_t n_active() const { return n_active_; }

  /// Weights V W(r, h) at the points `of` of these blocks, which begin with the first block.
  template <Kernel K>
  void weigh_all(std::span<const Block> blocks, const PointSet& of, PairWeights& out) const;
  /// A number that changes with every update in which any point has moved.
  [[nodiscard]] std::uint64_t state() const { return state_; }

  /// A point as a candidate.
  static Node node_of(const PointSet& points, std::size_t i);

  [[nodiscard]] std::uint64_t rebuilds() const { return rebuilds_; }
  [[nodiscard]] std::uint64_t reuses() const { return reuses_; }

 private:
  /// Sum of the largest displacements in both clouds since the lists were made, and of the growth of supports [m];
  /// infinite where points have been added or removed.
  [[nodiscard]] double moved(const PointSet& of, const PointSet& around) const;
  /// Returns whether any point has moved. Where the lists are no longer valid, makes new cells and blocks and divides
  /// the blocks into `parts_`.
  bool prepare(const PointSet& of, const PointSet& around);
  void prepare_search(const PointSet& of, const PointSet& around, double skin);
  void make_blocks(const PointSet& of, std::size_t begin, std::size_t end, double reach);
  void sort_cells(const PointSet& around);
  /// The first block of a part.
  [[nodiscard]] std::size_t first_block(std::size_t part) const { return blocks_.size() * part / parts_; }
  void find_candidates(const PointSet& of, std::size_t part);
  void join_candidates();
  /// Working memory of one part in the search for candidates, and the candidates found.
  struct alignas(64) Finder {
    std::vector<Index> found;
    /// One bit for each point found, and one for each word with such bits: scanning them gives the caller's order.
    std::vector<std::uint64_t> bits, words;
    std::vector<std::pair<Index, Index>> pieces;
    std::vector<Index> candidate;
  };
  std::size_t take_near(const Vec<D>& lower, const Vec<D>& upper, double own, Finder& finder) const;
  static void append_in_order(std::size_t n, Finder& finder);
  void gather(const PointSet& of, const PointSet& around);

  std::vector<Block> blocks_;
  std::size_t n_active_blocks_ = 0, n_of_ = 0, n_active_ = 0, longest_ = 0;
  std::vector<Index> candidate_;  ///< indices in nodes_
  std::vector<Node> nodes_;
  std::uint64_t rebuilds_ = 0, reuses_ = 0;
  /// A cloud at an earlier time.
  struct Then {
    std::vector<double> position, length, volume;
    [[nodiscard]] bool stands(const PointSet& now) const;
  };
  Then of_listed_, around_listed_;  ///< state when the lists were made
  Then of_last_, around_last_;      ///< state at the last update
  bool made_ = false;               ///< whether lists exist
  bool served_ = false;             ///< whether the lists were kept in an update in which points had moved
  int in_vain_ = 0;                 ///< number of lists in a row for which the margin saved nothing
  double skin_ = 0.0;               ///< m
  std::uint64_t state_ = 0;
  sph::CellGrid<D> grid_;  ///< cells of `around`; in the order of cells:
  std::array<std::vector<double>, D> x_;
  std::vector<double> reach_;  ///< m, radius of support
  std::vector<Index> index_;   ///< index in the caller's order
  std::size_t parts_ = 0;      ///< parts of the blocks in the present search; 0: lists are valid
  std::vector<Finder> finders_;
};

/// V W(|x_i - x_j|, h) of one candidate j for the four points i of a block. h and V are either the candidate's (two
/// numbers) or those of the points (lanes).
template <int D, class Value>
[[gnu::always_inline]] inline void weigh(const typename PairBlocks<D>::Node& node, const std::array<Quad, D>& x,
                                         const Value& shrink, const Value& amplitude, Lanes& weight) {
  Lanes r{};
  for (std::size_t d = 0; d < D; ++d) {
    const Lanes apart = node.x[d] - x[d].v;
    r += apart * apart;
  }
  sqrt_in_place(r);
  Lanes u = 1.0 - r * shrink;
  max_in_place(u, Lanes{});
  const Lanes u2 = u * u;
  weight = amplitude * (u2 * u2) * (5.0 - 4.0 * u);
}

/// Writes the candidates that reach a block, and their weights at its points, to arrays with space for all candidates;
/// returns their number.
template <Kernel K, int D>
[[gnu::always_inline]] inline std::size_t weigh_block(const PairBlocks<D>& pairs,
                                                      const typename PairBlocks<D>::Block& block, const PointSet& of,
                                                      Index* candidate, Quad* weight) {
  const auto* const nodes = pairs.nodes().data();
  const std::array<Quad, D> x = block.x;
  Lanes shrink{}, amplitude{};
  if constexpr (K == Kernel::of_block)
    for (std::size_t l = 0; l < n_lanes; ++l) {
      const auto own = PairBlocks<D>::node_of(of, block.point[l]);
      shrink[l] = own.shrink;
      amplitude[l] = own.amplitude;
    }
  std::size_t n = 0;
  for (const Index near : pairs.candidates(block)) {
    const auto& node = nodes[near];
    Lanes w;
    if constexpr (K == Kernel::of_block)
      weigh<D>(node, x, shrink, amplitude, w);
    else
      weigh<D>(node, x, node.shrink, node.amplitude, w);
    candidate[n] = near;
    weight[n].v = w;
    n += any(w > 0.0) ? 1 : 0;
  }
  return n;
}

}  // namespace poretwin::coupling
