// Tiles cover space once, have about equal loads, and are the same on every rank.
#include "common/tiles/partition.hpp"
#include "common/core/error.hpp"
#include "tests/tiles/ranks.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace poretwin::tiles {
namespace {

/// The points whose numbers give this rank as the remainder: each rank's lie all over the square.
template <int D>
VecArray<D> share_of(const VecArray<D>& whole, int rank, int size) {
  VecArray<D> own;
  for (std::size_t i = static_cast<std::size_t>(rank); i < whole.size(); i += static_cast<std::size_t>(size))
    own.push_back(whole[i]);
  return own;
}

template <int D>
Partition<D> cut(const VecArray<D>& whole, const std::function<double(const Vec<D>&)>& load) {
  const auto own = share_of<D>(whole, all_ranks().rank(), all_ranks().size());
  ScalarArray loads;
  for (const auto& x : own) loads.push_back(load(x));
  return bisect<D>(all_ranks(), own, loads);
}

/// Load of each tile.
template <int D>
ScalarArray loads(const Partition<D>& partition, const VecArray<D>& whole,
                  const std::function<double(const Vec<D>&)>& load) {
  ScalarArray sums(partition.tiles().size());
  for (const auto& x : whole) sums[static_cast<std::size_t>(partition.owner(x))] += load(x);
  return sums;
}

template <int D>
void expect_every_place_has_one_owner(const Partition<D>& partition, const VecArray<D>& places) {
  for (const auto& x : places) {
    int owners = 0;
    for (const auto& tile : partition.tiles())
      owners += (x.array() > tile.lower.array()).all() && (x.array() <= tile.upper.array()).all() ? 1 : 0;
    EXPECT_EQ(owners, 1) << x.transpose();
  }
}

template <int D>
void expect_equal_loads(std::size_t side) {
  const auto whole = scattered<D>(side);
  for (const auto& load : {std::function<double(const Vec<D>&)>([](const Vec<D>&) { return 1.0; }),
                           std::function<double(const Vec<D>&)>([](const Vec<D>& x) { return 1.0 + 9.0 * x[0]; })}) {
    const auto partition = cut<D>(whole, load);
    double sum = 0.0, most = 0.0;
    for (const auto& x : whole) {
      sum += load(x);
      most = std::max(most, load(x));
    }
    // A cut divides one point's load at most wrongly, and so does each cut above it.
    for (const double one : loads<D>(partition, whole, load)) EXPECT_NEAR(one, sum / all_ranks().size(), 2.0 * most);
    // Places on the faces of tiles, too, and far from all points.
    auto places = whole;
    for (const auto& tile : partition.tiles())
      for (int d = 0; d < D; ++d) {
        Vec<D> on_face = Vec<D>::Constant(0.5);
        on_face[d] = std::isfinite(tile.upper[d]) ? tile.upper[d] : 1e6;
        places.push_back(on_face);
        places.push_back(-on_face);
      }
    expect_every_place_has_one_owner<D>(partition, places);
  }
}

TEST(Partition, LoadsAreEqual2D) { expect_equal_loads<2>(31); }
TEST(Partition, LoadsAreEqual3D) { expect_equal_loads<3>(11); }

TEST(Partition, IsTheSameOnEveryRank) {
  const auto partition = cut<2>(scattered<2>(20), [](const Vec<2>& x) { return 1.0 + x[1]; });
  std::vector<double> sides;
  for (const auto& tile : partition.tiles())
    for (const double side : {tile.lower[0], tile.lower[1], tile.upper[0], tile.upper[1]}) sides.push_back(side);
  const auto of_all = all_ranks().gather(std::span<const double>(sides));
  for (std::size_t k = 0; k < of_all.size(); ++k) EXPECT_EQ(of_all[k], sides[k % sides.size()]);
}

TEST(Partition, FewerPointsThanRanksLeaveTilesEmpty) {
  const auto one = [](const Vec<2>&) { return 1.0; };
  for (const auto& whole :
       {VecArray<2>{}, VecArray<2>{Vec<2>(0.3, 0.4)}, VecArray<2>{Vec<2>(0.3, 0.4), Vec<2>(0.7, 0.4)}}) {
    const auto partition = cut<2>(whole, one);
    auto places = scattered<2>(10);
    places.insert(places.end(), whole.begin(), whole.end());
    expect_every_place_has_one_owner<2>(partition, places);
  }
  // Points at one place belong to one rank.
  const auto partition = cut<2>(VecArray<2>(12, Vec<2>(0.3, 0.4)), one);
  expect_every_place_has_one_owner<2>(partition, scattered<2>(10));
}

TEST(Partition, PointsWithoutLoadCountEqually) {
  const auto whole = scattered<2>(20);
  const auto partition = cut<2>(whole, [](const Vec<2>&) { return 0.0; });
  for (const double n : loads<2>(partition, whole, [](const Vec<2>&) { return 1.0; }))
    EXPECT_NEAR(n, 400.0 / all_ranks().size(), 2.0);
}

TEST(Partition, ImbalanceIsTheWaitOfTheOthers) {
  const auto& all = all_ranks();
  EXPECT_DOUBLE_EQ(imbalance(all, 3.0), 0.0);
  EXPECT_DOUBLE_EQ(imbalance(all, all.rank() == 0 ? 5.0 : 0.0), all.size() - 1.0);
  EXPECT_DOUBLE_EQ(imbalance(all, 0.0), 0.0);
}

TEST(Partition, PlacesAndLoadsThatAreNoNumbersAreRefused) {
  const auto& all = all_ranks();
  const Partition<2> whole(all.size());
  EXPECT_EQ(whole.owner(Vec<2>(1e9, -3.0)), 0);
  EXPECT_THROW(static_cast<void>(whole.owner(Vec<2>(std::nan(""), 0.0))), DivergedError);
  // Refused on every rank, though one alone has the point.
  const VecArray<2> x{Vec<2>(all.rank() == 0 ? std::nan("") : 0.0, 0.0)};
  const ScalarArray load{1.0}, negative{all.rank() == 0 ? -1.0 : 1.0};
  EXPECT_THROW(static_cast<void>(bisect<2>(all, x, load)), DivergedError);
  EXPECT_THROW(static_cast<void>(bisect<2>(all, VecArray<2>{Vec<2>::Zero()}, negative)), DivergedError);
}

}  // namespace
}  // namespace poretwin::tiles
