// The loop over pairs with a body of its own: four pairs at a time, one at a time, and as two plain loops.
#include "common/particles/for_pairs.hpp"
#include "common/particles/neighbours.hpp"
#include "tests/instructions.hpp"

#include <gtest/gtest.h>

#include <random>

namespace poretwin {
namespace {

constexpr double reach = 0.25;

struct Point {
  std::array<double, 4> x;  ///< position, weight, value
  [[nodiscard]] const double* row() const { return x.data(); }
};

/// What the body below sums: sum of weight (1 - r / reach)^2 (value - own value), where the other's value is larger,
/// and the same times the vector to it.
using Result = std::array<double, 3>;

std::vector<Point> points(std::size_t n) {
  std::mt19937_64 generator(1);
  std::uniform_real_distribution<double> any(0.0, 1.0);
  std::vector<Point> result(n);
  for (auto& point : result)
    for (double& number : point.x) number = any(generator);
  return result;
}

/// Lists of points within reach. The last `ghosts` points act, and are not acted on.
struct Lists {
  std::vector<Index> offset{0}, alone, index;
  void fill_up(std::size_t i) {
    while (index.size() % n_lanes != 0) index.push_back(static_cast<Index>(i));
  }
};
double distance(const Point& a, const Point& b) { return std::hypot(b.x[0] - a.x[0], b.x[1] - a.x[1]); }
bool near(const Point& a, const Point& b) { return distance(a, b) < reach; }

Lists full_lists(const std::vector<Point>& all, std::size_t ghosts) {
  Lists lists;
  for (std::size_t i = 0; i + ghosts < all.size(); ++i) {
    for (std::size_t j = 0; j < all.size(); ++j)
      if (j != i && near(all[i], all[j])) lists.index.push_back(static_cast<Index>(j));
    lists.fill_up(i);
    lists.offset.push_back(static_cast<Index>(lists.index.size()));
  }
  return lists;
}
/// Of two parts of the rows; pairs across them stand in both.
Lists half_lists(const std::vector<Point>& all, std::size_t ghosts, std::size_t cut) {
  Lists lists;
  const std::size_t n = all.size() - ghosts;
  const auto together = [&](std::size_t i, std::size_t j) { return j < n && (i < cut) == (j < cut); };
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = i + 1; j < n; ++j)
      if (together(i, j) && near(all[i], all[j])) lists.index.push_back(static_cast<Index>(j));
    lists.fill_up(i);
    lists.alone.push_back(static_cast<Index>(lists.index.size()));
    for (std::size_t j = 0; j < all.size(); ++j)
      if (!together(i, j) && near(all[i], all[j])) lists.index.push_back(static_cast<Index>(j));
    lists.fill_up(i);
    lists.offset.push_back(static_cast<Index>(lists.index.size()));
  }
  return lists;
}

std::vector<Result> by_plain_loops(const std::vector<Point>& all, std::size_t ghosts) {
  std::vector<Result> sums(all.size() - ghosts, Result{});
  for (std::size_t i = 0; i < sums.size(); ++i)
    for (std::size_t j = 0; j < all.size(); ++j) {
      const auto &a = all[i].x, &b = all[j].x;
      if (j == i || !near(all[i], all[j]) || b[3] <= a[3]) continue;
      const double u = 1.0 - distance(all[i], all[j]) / reach, part = b[2] * u * u * (b[3] - a[3]);
      sums[i][0] += part;
      for (std::size_t d = 0; d < 2; ++d) sums[i][1 + d] += part * (b[d] - a[d]);
    }
  return sums;
}

/// The body: what the other does to the particle of the row is added to its sums, what that does to the other is given
/// to it.
template <class Rows>
std::vector<Result> by_for_pairs(const Rows& rows, const std::vector<Point>& all, std::size_t n) {
  std::vector<std::array<double, 4>> sums(n);
  auto* const sum_of = sums.data();
  for_pairs<SumsOf<3>::Row>(
      rows, PairInputs<Point, 0, 1>{all.data(), all.size()},
      [=](const auto& pair, auto& own) __attribute__((always_inline)) {
        using Number = NumberOf<decltype(pair)>;
        const double* const self = pair.self;
        Number other[4], r[2], u{}, theirs[4] = {};
        gather<0, 4>(pair.rows(), other);
        for (std::size_t d = 0; d < 2; ++d) {
          r[d] = other[d] - self[d];
          u += r[d] * r[d];
        }
        sqrt_in_place(u);
        u = 1.0 - u / reach;
        const Number difference = other[3] - self[3], shape = u * u;
        const MaskOf<decltype(pair)> higher = difference > 0.0;
        const Number mine = higher ? other[2] * shape * difference : Number{};
        own.sum[0] += mine;
        for (std::size_t d = 0; d < 2; ++d) own.sum[1 + d] += mine * r[d];
        if (!pair.both || !any(!higher)) return;
        const Number yours = higher ? Number{} : -self[2] * shape * difference;
        theirs[0] = yours;
        for (std::size_t d = 0; d < 2; ++d) theirs[1 + d] = -yours * r[d];
        pair.template give<4>(theirs, [=](Index j) { return sum_of[j].data(); });
      },
      [=](std::size_t i, const auto& own) __attribute__((always_inline)) { own.add_to(sum_of[i].data()); });
  std::vector<Result> result(n);
  for (std::size_t i = 0; i < n; ++i) std::copy_n(sums[i].begin(), 3, result[i].begin());
  return result;
}

void expect_near(const std::vector<Result>& found, const std::vector<Result>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(found[i][k], expected[i][k], 1e-12) << i << " " << k;
}

TEST(ForPairs, SumsFullAndHalfListsAsPlainLoopsDo) {
  constexpr std::size_t ghosts = 20, cut = 70;
  const auto all = points(200);
  const std::size_t n = all.size() - ghosts;
  const Lists full = full_lists(all, ghosts), half = half_lists(all, ghosts, cut);
  const std::array<Index, 3> parts{0, cut, static_cast<Index>(n)};
  const auto expected = by_plain_loops(all, ghosts);
  test::with_each_instruction_set([&] {
    expect_near(by_for_pairs(FullRows{full.offset.data(), full.index.data(), n, 8}, all, n), expected);
    const HalfRows rows{half.offset.data(), half.alone.data(), half.index.data(), parts, half.index.size(), 0, n};
    expect_near(by_for_pairs(rows, all, n), expected);
  });
}

TEST(ForPairs, LeavesOutRows) {
  const auto all = points(100);
  const std::size_t n = all.size();
  Lists lists = full_lists(all, 0);
  lists.alone.assign(lists.offset.begin(), lists.offset.end() - 1);  // every pair acts on its row's particle alone
  std::vector<char> skipped(n, 0);
  skipped[20] = 1;
  const std::array<Index, 2> parts{0, static_cast<Index>(n)};
  const auto expected = by_plain_loops(all, 0);
  const auto found = by_for_pairs(HalfRows{lists.offset.data(), lists.alone.data(), lists.index.data(), parts,
                                           lists.index.size(), 10, 40, skipped.data()},
                                  all, n);
  for (std::size_t i = 0; i < n; ++i)
    EXPECT_NEAR(found[i][0], i >= 10 && i < 40 && i != 20 ? expected[i][0] : 0.0, 1e-12) << i;
}

/// More points than a core's caches hold: their numbers are fetched in advance.
TEST(ForPairs, FetchesAheadWithinTheList) {
  const auto all = points(20000);
  Lists lists;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const std::size_t j = i * 7919 % all.size();
    if (j != i && near(all[i], all[j])) lists.index.push_back(static_cast<Index>(j));
    lists.fill_up(i);
    lists.offset.push_back(static_cast<Index>(lists.index.size()));
  }
  const auto found = by_for_pairs(FullRows{lists.offset.data(), lists.index.data(), all.size(), 8}, all, all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto &a = all[i].x, &b = all[i * 7919 % all.size()].x;
    const double u = 1.0 - std::hypot(b[0] - a[0], b[1] - a[1]) / reach;
    EXPECT_NEAR(found[i][0], u > 0.0 && b[3] > a[3] ? b[2] * u * u * (b[3] - a[3]) : 0.0, 1e-12) << i;
  }
}

}  // namespace
}  // namespace poretwin
