// Pair lists compared with a plain double loop, also for difficult sets.
#include "common/core/error.hpp"
#include "common/particles/neighbours.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace poretwin::sph {
namespace {

template <int D>
VecArray<D> random_points(std::size_t n, double extent, unsigned seed) {
  std::mt19937_64 generator(seed);
  std::uniform_real_distribution<double> coordinate(0.0, extent);
  VecArray<D> points(n);
  for (auto& x : points)
    for (int d = 0; d < D; ++d) x[d] = coordinate(generator);
  return points;
}

template <int D>
void check(const VecArray<D>& targets, const VecArray<D>& sources, const std::vector<double>& radius) {
  const PairList list = find_pairs<D>(targets, sources, radius);
  ASSERT_EQ(list.size(), targets.size());
  for (std::size_t a = 0; a < targets.size(); ++a) {
    std::vector<Index> expected;
    for (std::size_t j = 0; j < sources.size(); ++j)
      if ((sources[j] - targets[a]).norm() < radius[j]) expected.push_back(static_cast<Index>(j));
    const auto found = list.of(a);
    EXPECT_EQ(std::vector<Index>(found.begin(), found.end()), expected) << "target " << a;
  }
}

TEST(Neighbours, MatchTheDoubleLoop) {
  std::vector<double> radius(400);
  for (std::size_t j = 0; j < radius.size(); ++j) radius[j] = 0.05 + 0.0003 * static_cast<double>(j);
  check<2>(random_points<2>(300, 1.0, 1), random_points<2>(400, 1.0, 2), radius);
  check<3>(random_points<3>(300, 0.6, 3), random_points<3>(400, 0.6, 4), radius);
}

TEST(Neighbours, EmptySetsAndStrayPoints) {
  check<2>({}, {}, {});
  check<2>(random_points<2>(5, 1.0, 1), {}, {});
  auto sources = random_points<2>(50, 1.0, 5);
  sources.push_back(Vec<2>(1e9, -1e9));  // one particle far away must not cost memory
  check<2>(random_points<2>(50, 1.0, 6), sources, std::vector<double>(51, 0.2));
}

TEST(Neighbours, APointThatIsNowhereIsRefusedByName) {
  for (const std::size_t lost : {0, 7, 49}) {
    auto points = random_points<2>(50, 1.0, 7);
    points[lost].y() = lost == 7 ? std::numeric_limits<double>::infinity() : std::nan("");
    try {
      CellGrid<2>().build(points, 0.1);
      FAIL() << "taken: point " << lost;
    } catch (const DivergedError& error) {
      EXPECT_NE(std::string(error.what()).find(fmt::format("{} of 50", lost)), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace poretwin::sph
