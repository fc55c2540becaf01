// Why the coupler has loops of its own: interpolation of many fields from one cloud of points to another, by its blocks
// of four receiving points with common candidates, and by for_pairs(), four givers of one receiving point at a time.
// Run by hand: `ninja mapping_loops && bin/mapping_loops [POINTS]`.
#include "bench/timing.hpp"
#include "common/particles/for_pairs.hpp"
#include "common/particles/kernel.hpp"
#include "coupler/mapping.hpp"

#include <fmt/format.h>

#include <random>

using namespace poretwin;

namespace {

constexpr std::size_t n_fields = 24;  // as many numbers as a soil in motion gives to the water

/// Position, 1 / (2 h), amplitude of the kernel, values.
struct alignas(32) Giver {
  std::array<double, 4 + n_fields> x{};
  [[nodiscard]] const double* row() const { return x.data(); }
};

coupling::PointSet lattice(std::size_t side, double shift) {
  coupling::PointSet points;
  const double dx = 1.0 / static_cast<double>(side);
  std::mt19937_64 generator(1);
  std::uniform_real_distribution<double> jitter(-0.2 * dx, 0.2 * dx);
  for (std::size_t j = 0; j < side; ++j)
    for (std::size_t i = 0; i < side; ++i) {
      points.position.push_back((static_cast<double>(i) + shift) * dx + jitter(generator));
      points.position.push_back((static_cast<double>(j) + shift) * dx + jitter(generator));
      points.volume.push_back(dx * dx);
      points.smoothing_length.push_back(1.25 * dx);
      points.owner.push_back(-1.0);
    }
  points.n_active = points.size();
  return points;
}

/// Sums of w and of w times each value over the givers around every point, four receiving points at a time, as
/// consistent() in coupler/interpolation.cpp forms them.
void by_blocks(const coupling::PairBlocks<2>& pairs, const std::vector<double>& values, std::vector<double>& out) {
  const auto blocks = pairs.active_blocks();
  std::vector<Index> near(pairs.longest_list());
  std::vector<Quad> weight(near.size());
  run_lanes([&]() __attribute__((always_inline)) {
    for (const auto& block : blocks) {
      const std::size_t n =
          coupling::weigh_block<coupling::Kernel::of_candidate, 2>(pairs, block, {}, near.data(), weight.data());
      Lanes whole{};
      for (std::size_t c = 0; c < n; ++c) whole += weight[c].v;
      for (std::size_t column = 0; column < n_fields; column += 4) {
        Lanes sum[4] = {};
        for (std::size_t c = 0; c < n; ++c) {
          const double* const value = values.data() + near[c] * n_fields + column;
          for (std::size_t q = 0; q < 4; ++q) sum[q] += weight[c].v * value[q];
        }
        for (std::size_t l = 0; l < block.used; ++l)
          for (std::size_t q = 0; q < 4; ++q) out[block.point[l] * n_fields + column + q] = sum[q][l] / whole[l];
      }
    }
  });
}

/// The same by for_pairs, all values in one pass.
void by_pairs(const FullRows& rows, const std::vector<Giver>& givers, const std::vector<Giver>& receivers,
              std::vector<double>& out) {
  double* const mapped = out.data();
  const Giver* const at = receivers.data();
  for_pairs<SumsOf<n_fields + 1>::Row>(
      rows, PairInputs<Giver, 0, 4>{givers.data(), givers.size()},
      [=](const auto& pair, auto& own) __attribute__((always_inline)) {
        using Number = NumberOf<decltype(pair)>;
        const double* const self = at[pair.i].row();
        Number giver[4 + n_fields], r{};
        gather<0, 4 + n_fields>(pair.rows(), giver);
        for (std::size_t d = 0; d < 2; ++d) r += (giver[d] - self[d]) * (giver[d] - self[d]);
        sqrt_in_place(r);
        Number u = 1.0 - r * giver[2];
        max_in_place(u, Number{});
        const Number weight = giver[3] * (u * u) * (u * u) * (5.0 - 4.0 * u);
        for (std::size_t k = 0; k < n_fields; ++k) own.sum[k] += weight * giver[4 + k];
        own.sum[n_fields] += weight;
      },
      [=](std::size_t i, const auto& own) __attribute__((always_inline)) {
        double total[SumsOf<n_fields + 1>::size] = {};
        own.add_to(total);
        for (std::size_t k = 0; k < n_fields; ++k) mapped[i * n_fields + k] = total[k] / total[n_fields];
      });
}

}  // namespace

int main(int argc, char** argv) {
  const std::size_t n = argc > 1 ? std::stoul(argv[1]) : 40000;
  const auto side = static_cast<std::size_t>(std::sqrt(static_cast<double>(n)));
  const auto from = lattice(side, 0.5), to = lattice(side, 0.77);
  coupling::PairBlocks<2> blocks;
  blocks.update(to, from);
  std::mt19937_64 generator(2);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  std::vector<double> values(from.size() * n_fields);
  for (double& value : values) value = any(generator);

  std::vector<Giver> givers(from.size()), receivers(to.size());
  VecArray<2> sources, targets;
  for (std::size_t j = 0; j < from.size(); ++j) {
    const auto node = coupling::PairBlocks<2>::node_of(from, j);
    sources.emplace_back(node.x[0], node.x[1]);
    targets.emplace_back(to.position[2 * j], to.position[2 * j + 1]);
    givers[j].x = {node.x[0], node.x[1], node.shrink, node.amplitude};
    std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(j * n_fields), n_fields, givers[j].x.begin() + 4);
    receivers[j].x = {targets[j][0], targets[j][1]};
  }
  // Padded with a giver out of reach.
  givers.push_back({});
  givers.back().x[0] = 1e3;
  givers.back().x[2] = givers[0].x[2];
  const ScalarArray radius(sources.size(), 2.0 * from.smoothing_length[0]);
  const auto lists = sph::find_pairs<2>(targets, sources, radius);
  std::vector<Index> offset{0}, index;
  for (std::size_t i = 0; i < lists.size(); ++i) {
    for (const Index j : lists.of(i)) index.push_back(j);
    while (index.size() % n_lanes != 0) index.push_back(static_cast<Index>(sources.size()));
    offset.push_back(static_cast<Index>(index.size()));
  }
  const FullRows rows{offset.data(), index.data(), targets.size(), targets.size() + 1};
  const auto n_pairs = static_cast<double>(lists.index.size());
  fmt::print("{} points, {:.1f} givers around each, {} numbers; four points have {:.1f} candidates in common\n",
             targets.size(), n_pairs / static_cast<double>(targets.size()), n_fields,
             static_cast<double>(blocks.n_candidates()) / static_cast<double>(blocks.blocks().size()));
  std::vector<double> one(targets.size() * n_fields), other(one);
  const double blocked = seconds([&] { by_blocks(blocks, values, one); });
  const double paired = seconds([&] { by_pairs(rows, givers, receivers, other); });
  double differ = 0.0;
  for (std::size_t i = 0; i < one.size(); ++i) differ = std::max(differ, std::abs(one[i] - other[i]));
  fmt::print("million pairs a CPU second: blocks {:.0f}, for_pairs {:.0f}; results differ by {:.1g}\n",
             1e-6 * n_pairs / blocked, 1e-6 * n_pairs / paired, differ);
}
