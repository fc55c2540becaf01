// A halo holds what its rank's particles can interact with, and nothing else.
#include "common/tiles/halo.hpp"
#include "common/particles/images.hpp"
#include "common/particles/kernel.hpp"
#include "common/particles/neighbours.hpp"
#include "common/tiles/partition.hpp"
#include "tests/tiles/ranks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <set>

namespace poretwin::tiles {
namespace {

/// This rank's part of points that all ranks know. ids: numbers of the points.
template <int D>
struct Part {
  VecArray<D> x;
  std::vector<GlobalId> ids;
};
template <int D>
Part<D> part_of(const VecArray<D>& whole, const Partition<D>& partition) {
  Part<D> part;
  for (std::size_t i = 0; i < whole.size(); ++i)
    if (partition.owner(whole[i]) == all_ranks().rank()) {
      part.x.push_back(whole[i]);
      part.ids.push_back(i);
    }
  return part;
}

/// Tiles of unequal size: slabs across the first axis that end at 0.15, 0.4, 0.6; the last is open.
template <int D>
Partition<D> slabs() {
  constexpr std::array<double, 3> ends{0.15, 0.4, 0.6};
  constexpr double infinity = std::numeric_limits<double>::infinity();
  std::vector<Box<D>> tiles;
  double lower = -infinity;
  for (int r = 0; r < all_ranks().size(); ++r) {
    Box<D> tile{Vec<D>::Constant(-infinity), Vec<D>::Constant(infinity)};
    tile.lower[0] = lower;
    if (r + 1 < all_ranks().size()) lower = tile.upper[0] = ends.at(static_cast<std::size_t>(r));
    tiles.push_back(tile);
  }
  return Partition<D>(std::move(tiles));
}

/// Adds the places and ids of the halo behind the owned ones.
template <int D>
HaloPlan fill(Part<D>& part, double reach, std::span<const Vec<D>> shifts = {}) {
  HaloPlan plan = find_halo<D>(all_ranks(), part.x, part.ids, reach, shifts);
  const MpiRanks ranks(all_ranks(), plan);
  part.x.resize(plan.owned + plan.halo);
  part.ids.resize(plan.owned + plan.halo);
  ranks.end_exchange(ranks.begin_exchange(std::span(part.x), 1));
  ranks.end_exchange(ranks.begin_exchange(std::span(part.ids), 1));
  return plan;
}

template <int D>
void expect_what_is_within_reach(const VecArray<D>& whole, const Partition<D>& partition, double reach,
                                 std::span<const Vec<D>> shifts = {}) {
  auto part = part_of<D>(whole, partition);
  const Part<D> own = part;
  const auto plan = fill<D>(part, reach, shifts);
  EXPECT_EQ(plan.owned, own.x.size());
  // Every pair is tried.
  VecArray<D> moved_by{Vec<D>::Zero()};
  moved_by.insert(moved_by.end(), shifts.begin(), shifts.end());
  std::set<GlobalId> expected;
  for (std::size_t j = 0; j < whole.size(); ++j) {
    if (partition.owner(whole[j]) == all_ranks().rank()) continue;
    for (const auto& x : own.x)
      for (const auto& by : moved_by)
        if ((x - whole[j] - by).norm() < reach) expected.insert(j);
  }
  const auto halo = std::span(part.ids).subspan(plan.owned);
  EXPECT_EQ(std::set<GlobalId>(halo.begin(), halo.end()), expected);
  EXPECT_EQ(halo.size(), expected.size()) << "no particle has two copies";
  for (std::size_t i = 0; i < part.ids.size(); ++i) EXPECT_EQ(part.x[i], whole[part.ids[i]]);
  // Those of each neighbour stand together, in ascending order.
  std::size_t at = plan.owned;
  for (const auto& neighbour : plan.neighbours) {
    EXPECT_TRUE(std::is_sorted(part.ids.begin() + static_cast<std::ptrdiff_t>(at),
                               part.ids.begin() + static_cast<std::ptrdiff_t>(at + neighbour.received)));
    at += neighbour.received;
  }
}

template <int D>
Partition<D> bisected(const VecArray<D>& whole) {
  const bool first = all_ranks().rank() == 0;
  const VecArray<D> own = first ? whole : VecArray<D>{};
  return bisect<D>(all_ranks(), own, ScalarArray(own.size(), 1.0));
}

TEST(Halo, HoldsWhatIsWithinReach2D) {
  const auto whole = scattered<2>(20);
  expect_what_is_within_reach<2>(whole, bisected<2>(whole), 0.13);
  expect_what_is_within_reach<2>(whole, slabs<2>(), 0.13);
  expect_what_is_within_reach<2>(whole, slabs<2>(), 0.5);  // beyond the next tile
}
TEST(Halo, HoldsWhatIsWithinReach3D) {
  const auto whole = scattered<3>(9);
  expect_what_is_within_reach<3>(whole, bisected<3>(whole), 0.25);
  expect_what_is_within_reach<3>(whole, slabs<3>(), 0.25);
}
TEST(Halo, OfAnEmptyTileIsEmpty) {
  const auto whole = scattered<2>(12);
  expect_what_is_within_reach<2>(whole, Partition<2>(all_ranks().size()), 0.3);
  expect_what_is_within_reach<2>({}, Partition<2>(all_ranks().size()), 0.3);
}
TEST(Halo, HoldsWhatIsWithinReachOfFurtherPlaces) {
  const auto whole = scattered<2>(16);
  const auto partition = slabs<2>();
  const auto own = part_of<2>(whole, partition);
  const VecArray<2> views{{0.9 - 0.2 * all_ranks().rank(), 0.3}};
  const HaloPlan plan = find_halo<2>(all_ranks(), own.x, own.ids, 0.1, {}, views);
  std::size_t expected = 0;
  for (const auto& x : whole) {
    const bool near = (x - views[0]).norm() < 0.1 ||
                      std::ranges::any_of(own.x, [&](const Vec<2>& other) { return (x - other).norm() < 0.1; });
    expected += near && partition.owner(x) != all_ranks().rank() ? 1 : 0;
  }
  EXPECT_EQ(plan.halo, expected);
}
TEST(Halo, ReachesAcrossPeriodicSides) {
  const auto whole = scattered<2>(16);
  const VecArray<2> shifts{{1.0, 0.0}, {-1.0, 0.0}};
  expect_what_is_within_reach<2>(whole, slabs<2>(), 0.12, shifts);
  expect_what_is_within_reach<2>(whole, bisected<2>(whole), 0.12, shifts);
}

TEST(Halo, HoldsUntilAParticleHasMovedByHalfTheSkin) {
  constexpr double radius = 0.12, skin = 0.04;
  const auto whole = scattered<2>(20);
  const auto partition = slabs<2>();
  auto part = part_of<2>(whole, partition);
  const auto plan = fill<2>(part, radius + skin);
  const MpiRanks ranks(all_ranks(), plan);
  // Towards each other across every face, by almost half of the skin.
  const auto moved = [&](const Vec<2>& x, GlobalId id, double share) {
    return Vec<2>(x + 0.5 * share * skin * Vec<2>(id % 2 == 0 ? 1.0 : -1.0, 0.0));
  };
  VecArray<2> now(part.x), all_now(whole);
  for (std::size_t i = 0; i < all_now.size(); ++i) all_now[i] = moved(whole[i], i, 0.999);
  for (std::size_t i = 0; i < now.size(); ++i) now[i] = moved(part.x[i], part.ids[i], 0.999);
  const std::span<const Vec<2>> at(part.x.data(), plan.owned), here(now.data(), plan.owned);
  EXPECT_FALSE(lists_outdated<2>(ranks.domain(), here, at, skin));
  std::size_t pairs = 0, expected = 0;
  for (const auto& x : here) {
    for (const auto& y : now) pairs += (x - y).norm() < radius ? 1 : 0;
    for (const auto& y : all_now) expected += (x - y).norm() < radius ? 1 : 0;
  }
  EXPECT_EQ(pairs, expected);
  // One particle of one rank outdates the lists of all.
  if (all_ranks().rank() == 0 && plan.owned > 0) now[0] = moved(part.x[0], part.ids[0], 1.001);
  EXPECT_TRUE(lists_outdated<2>(ranks.domain(), here, at, skin));
}

TEST(Halo, ImagesAtMirrorsAndPeriodicSidesAreThoseOfOneRank) {
  // Mirrors below and above, periodic sides left and right; tiles are cut across both.
  constexpr double h = 0.05, reach = 2.0 * h;
  using Plane = sph::ImagePlane<2>;
  std::vector<Plane> planes(4);
  planes[0].normal = {0.0, 1.0};
  planes[1].normal = {0.0, -1.0};
  planes[1].point = {0.0, 1.0};
  planes[2].kind = planes[3].kind = Plane::Kind::periodic;
  planes[2].normal = {1.0, 0.0};
  planes[2].shift = {1.0, 0.0};
  planes[3].normal = {-1.0, 0.0};
  planes[3].point = {1.0, 0.0};
  planes[3].shift = {-1.0, 0.0};
  // Number of points and images in each point's support, and the sum of the kernel over them.
  const auto sums = [&](const VecArray<2>& points, std::size_t owned) {
    VecArray<2> sources = points;
    const auto images = sph::make_images<2>(points, planes, reach);
    sources.insert(sources.end(), images.position.begin(), images.position.end());
    const auto pairs = sph::find_pairs<2>(std::span(points).first(owned), sources, ScalarArray(sources.size(), reach));
    std::vector<std::pair<std::size_t, double>> found;
    for (std::size_t a = 0; a < owned; ++a) {
      double sum = 0.0;
      for (const Index j : pairs.of(a)) sum += sph::WendlandC2<2>::value((points[a] - sources[j]).norm(), h);
      found.emplace_back(pairs.of(a).size(), sum);
    }
    return found;
  };
  const auto whole = scattered<2>(30);
  const auto expected = sums(whole, whole.size());
  const VecArray<2> shifts{{1.0, 0.0}, {-1.0, 0.0}};
  for (const auto& partition : {slabs<2>(), bisected<2>(whole)}) {
    auto part = part_of<2>(whole, partition);
    const auto plan = fill<2>(part, reach, shifts);
    const auto found = sums(part.x, plan.owned);
    for (std::size_t a = 0; a < plan.owned; ++a) {
      EXPECT_EQ(found[a].first, expected[part.ids[a]].first);
      EXPECT_NEAR(found[a].second, expected[part.ids[a]].second, 1e-14 * expected[part.ids[a]].second);
    }
  }
}

}  // namespace
}  // namespace poretwin::tiles
