// Pair lists remain valid while neighbours move together.
#include "solid_solver/discretisation/lists_hold.hpp"
#include "solid_solver/dynamics/step.hpp"
#include "tests/solid/scenes.hpp"

#include <gtest/gtest.h>

#include <random>

namespace poretwin::solid::test {
namespace {

/// A kernel sum of every particle over all nodes in its list: it grows as soon as another one is within reach.
template <int D>
ScalarArray felt(const Setup<D>& setup, const Particles<D>& p, const Neighbourhood<D>& near) {
  ScalarArray sum(p.size(), 0.0);
  const auto at = [&](std::size_t j) -> Vec<D> {
    if (j < p.size()) return p.position[j];
    const auto& image = near.images[j - p.size()];
    return image.map * p.position[image.parent] + image.shift;
  };
  for_each_ordered_pair(near.pairs, [&](std::size_t i, std::size_t j, std::size_t) {
    sum[i] += sph::WendlandC2<D>::value((at(i) - at(j)).norm(), setup.smoothing_length);
  });
  return sum;
}

/// Moves a column on a base at random, as a whole, in shear, and each particle by itself; lists that are said to be
/// valid must miss no pair. Returns how often they were valid although something had moved by more than half the
/// margin.
template <int D>
int holds_without_misses(unsigned seed) {
  ColumnSpec spec;
  spec.dimension = D;
  spec.width = D == 2 ? 1.5 : 0.9;
  spec.height = 2.5;
  spec.spacing = D == 2 ? 0.05 : 0.1;
  spec.sides = false;
  auto [setup, laid] = set_up<D>(column(spec));
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  Neighbourhood<D> built;
  build_neighbourhood<D>(setup.boundaries, setup.range(), 1, laid, {}, built);
  int held = 0;
  for (int k = 0; k < 40; ++k) {
    Particles<D> p = laid;
    const double along = 2.0 * setup.skin * any(generator), shear = 0.5 * setup.skin * any(generator),
                 apart = 0.2 * setup.skin * std::abs(any(generator));
    for (auto& x : p.position) {
      const double away = std::clamp(1.5 * x[D - 1] / spec.height - 0.3, 0.0, 1.0);  // no motion near the base
      x[0] += away * (along + shear * x[0] / spec.width);
      for (int d = 0; d < D; ++d) x[d] += away * apart * any(generator);
    }
    double farthest = 0.0;
    for (std::size_t i = 0; i < p.size(); ++i) farthest = std::max(farthest, (p.position[i] - laid.position[i]).norm());
    if (!lists_hold(setup, p, built)) {
      EXPECT_GT(farthest, 0.5 * setup.skin) << "lists are built anew for nothing";
      continue;
    }
    held += farthest > 0.5 * setup.skin ? 1 : 0;
    Neighbourhood<D> anew;
    build_neighbourhood<D>(setup.boundaries, setup.range(), 1, p, {}, anew);
    const ScalarArray with = felt(setup, p, built), truth = felt(setup, p, anew);
    for (std::size_t i = 0; i < p.size(); ++i) EXPECT_NEAR(with[i], truth[i], 1e-9 * truth[i]) << "particle " << i;
  }
  return held;
}

TEST(Lists, HoldWhileNeighboursMoveAlong) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    EXPECT_GT(holds_without_misses<2>(seed), 3);
    EXPECT_GT(holds_without_misses<3>(seed), 3);
  }
}

/// A box without walls in two parts: number of pairs between them.
template <int D>
double felt_across(const Vec<D>& extent, double spacing) {
  Case scene = column({.dimension = D, .spacing = spacing, .base = Wall::ForSoil::none, .sides = false});
  scene.soils[0].shape.max.head<D>() = extent;
  const auto [setup, laid] = set_up<D>(scene);
  Neighbourhood<D> near;
  build_neighbourhood<D>(setup.boundaries, setup.range(), 2, laid, {}, near);
  double count = 0.0;
  for_each_ordered_pair(near.pairs, [&](std::size_t i, std::size_t j, std::size_t) {
    count += (i < near.pairs.part[1]) != (j < near.pairs.part[1]) ? 1.0 : 0.0;
  });
  return count;
}

TEST(Lists, PartsMeetWhereTheSoilIsNarrow) {
  // Twice 11 pairs per row of a lattice: 5 at one spacing along the normal, 2 times 3 at two spacings.
  const double square = 22.0 * 20.0;
  EXPECT_NEAR(felt_across<2>({4.0, 1.0}, 0.05), square, 0.1 * square);
  EXPECT_NEAR(felt_across<2>({1.0, 4.0}, 0.05), square, 0.1 * square);
  const double wide = felt_across<3>({2.0, 1.0, 1.0}, 0.1);
  EXPECT_GT(wide, 0.0);
  EXPECT_EQ(felt_across<3>({1.0, 2.0, 1.0}, 0.1), wide);
  EXPECT_EQ(felt_across<3>({1.0, 1.0, 2.0}, 0.1), wide);
}

TEST(Lists, DoNotHoldWhereSomethingPassesOrNearsAWall) {
  auto [setup, laid] = set_up<2>(column({.width = 1.0, .height = 1.0}));
  Neighbourhood<2> built;
  build_neighbourhood<2>(setup.boundaries, setup.range(), 1, laid, {}, built);
  EXPECT_TRUE(lists_hold(setup, laid, built));
  const auto moved = [&, &laid = laid, &setup = setup](const Vec<2>& by, auto&& who) {
    Particles<2> p = laid;
    for (auto& x : p.position)
      if (who(x)) x += by;
    return lists_hold(setup, p, built);
  };
  const double more = 0.6 * setup.skin;
  const auto all = [](const Vec<2>&) { return true; };
  const auto upper = [](const Vec<2>& x) { return x.y() > 0.5; };
  const auto middle = [](const Vec<2>& x) { return x.y() > 0.3 && std::abs(x.x() - 0.5) < 0.2; };
  const auto one = [](const Vec<2>& x) { return (x - Vec<2>(0.525, 0.525)).norm() < 1e-3; };
  EXPECT_FALSE(moved({0.0, more}, all)) << "side walls' images stay behind";
  EXPECT_FALSE(moved({2.0 * more, 0.0}, upper));
  EXPECT_TRUE(moved({more, 0.0}, middle));
  EXPECT_TRUE(moved({more, 0.0}, one));
  EXPECT_FALSE(moved({2.0 * more, 0.0}, one));
  EXPECT_FALSE(moved({20.0 * more, 0.0}, one));
}

}  // namespace
}  // namespace poretwin::solid::test
