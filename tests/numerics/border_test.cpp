// The critical factor between standing and failing.
#include "common/numerics/border.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace poretwin {
namespace {

TEST(Border, IsFoundFromEitherSideAndFromAGuess) {
  for (const double truth : {0.03, 0.7, 1.0, 1.3, 40.0})
    for (const double guess : {1.0, 0.9 * truth, 1.1 * truth}) {
      BorderSearch search;
      search.guess = guess;
      search.ratio = guess == 1.0 ? 2.0 : 1.01;
      int trials = 0;
      const auto found = find_border(search, [&](double factor) {
        ++trials;
        return std::optional(factor < truth);
      });
      ASSERT_TRUE(found);
      EXPECT_LT(found->stands, truth);
      EXPECT_GE(found->fails, truth);
      EXPECT_LE(found->fails - found->stands, search.tolerance * found->fails);
      EXPECT_LE(trials, guess == 1.0 ? 15 : 9) << "of " << truth << " from " << guess;
    }
}

TEST(Border, SaysWhereThereIsNone) {
  const BorderSearch search;
  EXPECT_TRUE(std::isinf(find_border(search, [](double) { return std::optional(true); })->fails));
  EXPECT_EQ(find_border(search, [](double) { return std::optional(false); })->stands, 0.0);
}

TEST(Border, IsNotFoundWhereTheSearchIsGivenUp) {
  int trials = 0;
  EXPECT_FALSE(find_border(BorderSearch{}, [&](double) { return ++trials < 3 ? std::optional(true) : std::nullopt; }));
}

}  // namespace
}  // namespace poretwin
