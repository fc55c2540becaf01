// Particles arrive once, complete and in the order of their ids.
#include "common/tiles/migration.hpp"
#include "common/core/error.hpp"
#include "common/core/unset.hpp"
#include "common/core/vector.hpp"
#include "tests/tiles/ranks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

namespace poretwin::tiles {
namespace {

/// Particles with fields of several types, all functions of the id.
struct Particles {
  std::vector<GlobalId> ids;
  VecArray<3> x;
  MatArray<2> stress;
  ScalarArray three;
  std::vector<char> flag;
  UnsetArray<float> mass;

  ParticleArrays arrays() {
    ParticleArrays arrays;
    arrays.add(x).add(stress).add(three, 3).add(flag).add(mass);
    return arrays;
  }
  void add(GlobalId id) {
    const auto a = static_cast<double>(id);
    ids.push_back(id);
    x.emplace_back(a, 0.5 * a, -a);
    stress.push_back(a * Mat<2>::Identity());
    for (const double k : {1.0, 2.0, 3.0}) three.push_back(a + 0.1 * k);
    flag.push_back(static_cast<char>(id % 100));
    mass.push_back(static_cast<float>(id) / 3.0F);
  }
  void expect_complete() const {
    Particles expected;
    for (const GlobalId id : ids) expected.add(id);
    EXPECT_TRUE(x == expected.x && stress == expected.stress && three == expected.three && flag == expected.flag &&
                mass == expected.mass);
    EXPECT_TRUE(std::ranges::is_sorted(ids));
  }
};

/// Rank of a particle at a step: they go this way and that; in step 3 all to the last rank, in step 4 all to the first,
/// so that every other tile is empty.
int place(GlobalId id, int step, int size) {
  if (step == 3) return size - 1;
  if (step == 4) return 0;
  return static_cast<int>((id * 7919 + id * static_cast<GlobalId>(step)) % static_cast<GlobalId>(size));
}

TEST(Migration, EveryParticleArrivesOnceAndComplete) {
  const auto& all = all_ranks();
  constexpr GlobalId n = 1000;
  Particles own;
  if (all.rank() == 0)
    for (GlobalId id = n; id-- > 0;) own.add(id);  // in descending order, all on rank 0
  auto arrays = own.arrays();
  for (int step = 0; step < 7; ++step) {
    std::vector<int> owner;
    for (const GlobalId id : own.ids) owner.push_back(place(id, step, all.size()));
    const std::size_t before = own.ids.size();
    const auto moved = migrate(all, owner, own.ids, arrays);
    EXPECT_EQ(before - moved.left + moved.came, own.ids.size());
    std::vector<GlobalId> expected;
    for (GlobalId id = 0; id < n; ++id)
      if (place(id, step, all.size()) == all.rank()) expected.push_back(id);
    EXPECT_EQ(own.ids, expected) << "step " << step;
    own.expect_complete();
  }
}

TEST(Migration, NoParticlesAtAll) {
  std::vector<GlobalId> ids;
  const auto moved = migrate(all_ranks(), {}, ids, {});
  EXPECT_EQ(moved.left + moved.came, 0U);
}

TEST(Migration, TwoParticlesOfOneIdAreRefusedOnEveryRank) {
  // One on the first rank, one on the last; they meet on the first.
  const auto& all = all_ranks();
  std::vector<GlobalId> ids;
  if (all.rank() == 0) ids.push_back(5);
  if (all.rank() == all.size() - 1) ids.push_back(5);
  const std::vector<int> owner(ids.size(), 0);
  try {
    migrate(all, owner, ids, {});
    ADD_FAILURE() << "nothing was thrown";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "rank 0 has two particles with the id 5");
  }
}

TEST(Migration, ArraysThatDoNotFitAreRefused) {
  std::vector<GlobalId> ids{1, 2};
  ScalarArray values(5);
  ParticleArrays arrays;
  arrays.add(values, 2);
  const std::vector<int> owner(2, all_ranks().rank()), too_few(1, 0);
  EXPECT_THROW(migrate(all_ranks(), owner, ids, arrays), Error);
  EXPECT_THROW(migrate(all_ranks(), too_few, ids, {}), Error);
}

TEST(ParticleArrays, AreBroughtIntoAnotherOrder) {
  ScalarArray one{0.0, 1.0, 2.0}, two{0.0, 0.5, 1.0, 1.5, 2.0, 2.5};
  std::vector<char> flags{'a', 'b', 'c'};
  ParticleArrays arrays;
  arrays.add(one).add(two, 2).add(flags);
  arrays.reorder(std::vector<Index>{2, 0});
  EXPECT_EQ(one, (ScalarArray{2.0, 0.0}));
  EXPECT_EQ(two, (ScalarArray{2.0, 2.5, 0.0, 0.5}));
  EXPECT_EQ(flags, (std::vector<char>{'c', 'a'}));
}

}  // namespace
}  // namespace poretwin::tiles
