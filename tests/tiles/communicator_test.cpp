// Messages, sums and exchanges between ranks; ranks that do not ask for the same are found out.
#include "common/tiles/communicator.hpp"
#include "common/core/error.hpp"
#include "common/tiles/mpi_ranks.hpp"
#include "tests/tiles/ranks.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace poretwin::tiles {
namespace {

TEST(MpiRanks, SumAndMaximumHaveTheSameBitsOnEveryRank) {
  const auto& all = all_ranks();
  const MpiRanks ranks(all);
  // In the order of the ranks each one is lost in rounding; in another order from three ranks on some are not.
  const double own = all.rank() == 0 ? 1e16 : 1.0;
  std::array<double, 2> values{own, 1.0}, most{own, static_cast<double>(-all.rank())};
  ranks.sum(values);
  ranks.max(most);
  EXPECT_EQ(values[0], 1e16);
  EXPECT_EQ(values[1], all.size());
  EXPECT_EQ(most[0], 1e16);
  EXPECT_EQ(most[1], 0.0);
  ranks.sum({});
}

TEST(MpiRanks, AValueThatIsNoNumberIsTheMaximumOnEveryRank) {
  const auto& all = all_ranks();
  const MpiRanks ranks(all);
  double value = all.rank() == all.size() - 1 ? std::nan("") : 1.0;
  ranks.max(std::span(&value, 1));
  EXPECT_TRUE(std::isnan(value));
}

TEST(MpiRanks, ADomainAsksAllRanks) {
  const auto& all = all_ranks();
  const MpiRanks ranks(all);
  const Domain domain = ranks.domain();
  const int last = all.size() - 1;
  EXPECT_EQ(domain.sum(1.0), all.size());
  EXPECT_EQ(domain.min(static_cast<double>(all.rank())), 0.0);
  EXPECT_TRUE(domain.any(all.rank() == last));
  EXPECT_TRUE(domain.all(true));
  EXPECT_EQ(domain.all(all.rank() == last), all.size() == 1);
  EXPECT_FALSE(domain.any(false));
}

TEST(Communicator, MessagesOfAnyLengthArrive) {
  const auto& all = all_ranks();
  // Rank a sends a * 1000 + 7 b bytes of value a to rank b, nothing to the one before it.
  const auto length = [&](int a, int b) { return (a + all.size() - b) % all.size() == 1 ? 0 : a * 1000 + 7 * b; };
  std::vector<Bytes> to;
  for (int b = 0; b < all.size(); ++b)
    to.emplace_back(static_cast<std::size_t>(length(all.rank(), b)), static_cast<std::byte>(all.rank()));
  const auto from = all.trade(to);
  for (int a = 0; a < all.size(); ++a) {
    const auto& message = from[static_cast<std::size_t>(a)];
    EXPECT_EQ(message.size(), static_cast<std::size_t>(length(a, all.rank())));
    EXPECT_THAT(message, testing::Each(static_cast<std::byte>(a)));
  }
}

/// Ranks in a ring: each owns three particles, the last of which the next rank has a copy of.
HaloPlan ring(const Communicator& all) {
  HaloPlan plan;
  plan.owned = 3;
  if (all.size() == 1) return plan;
  const int next = (all.rank() + 1) % all.size(), before = (all.rank() + all.size() - 1) % all.size();
  plan.halo = 1;
  if (next == before)
    plan.neighbours = {{next, {2}, 1}};
  else
    plan.neighbours = {{std::min(next, before), {}, 0}, {std::max(next, before), {}, 0}};
  for (auto& neighbour : plan.neighbours) {
    if (neighbour.rank == next) neighbour.sent = {2};
    if (neighbour.rank == before) neighbour.received = 1;
  }
  return plan;
}

TEST(MpiRanks, AnExchangeSendsValuesAsTheyWereWhenItBegan) {
  const auto& all = all_ranks();
  const MpiRanks ranks(all, ring(all));
  const std::size_t n = 3 + ranks.plan().halo;
  const auto value = [](int rank, std::size_t k) { return 100.0 * rank + static_cast<double>(k); };
  ScalarArray one(n, -1.0), two(2 * n, -1.0);
  std::vector<std::uint64_t> ids(n, 0);
  for (std::size_t i = 0; i < 3; ++i) {
    one[i] = value(all.rank(), i);
    ids[i] = ~std::uint64_t{0} - static_cast<std::uint64_t>(all.rank());
  }
  for (std::size_t i = 0; i < 6; ++i) two[i] = value(all.rank(), 10 + i);
  auto first = ranks.begin_exchange(std::span(one), 1);
  auto second = ranks.begin_exchange(std::span(two), 2);
  auto third = ranks.begin_exchange(std::span(ids), 1);
  one[2] = two[4] = two[5] = 0.0;
  ranks.end_exchange(std::move(third));
  ranks.end_exchange(std::move(second));
  ranks.end_exchange(std::move(first));
  if (all.size() == 1) return;
  const int before = (all.rank() + all.size() - 1) % all.size();
  EXPECT_EQ(one[3], value(before, 2));
  EXPECT_EQ(two[6], value(before, 14));
  EXPECT_EQ(two[7], value(before, 15));
  EXPECT_EQ(ids[3], ~std::uint64_t{0} - static_cast<std::uint64_t>(before));
}

TEST(MpiRanks, AnArrayOfAnotherLengthIsRefused) {
  const MpiRanks ranks(all_ranks(), ring(all_ranks()));
  ScalarArray values(2 * (3 + ranks.plan().halo) + 1);
  EXPECT_THROW(ranks.exchange(values, 2), Error);
}

/// What a call throws, and nothing where it throws nothing.
template <class Call>
std::string complaint(const Call& call) {
  try {
    call();
  } catch (const PeerError& error) {
    return error.what();
  }
  return "";
}

TEST(MpiRanks, RanksThatExchangeDifferentNumbersAreNamed) {
  const auto& all = all_ranks();
  if (all.size() == 1) return;
  const MpiRanks ranks(all, ring(all));
  // The last rank sends two numbers per particle to the first, which expects one, as all others do.
  const std::size_t each = all.rank() == all.size() - 1 ? 2 : 1;
  ScalarArray values(each * 4);
  const std::string found = complaint([&] { ranks.exchange(values, each); });
  if (all.rank() == 0) {
    EXPECT_THAT(found, testing::HasSubstr("of 8 bytes from rank " + std::to_string(all.size() - 1)));
    EXPECT_THAT(found, testing::HasSubstr("rank 0 of"));
  }
  if (all.rank() == all.size() - 1) {
    EXPECT_THAT(found, testing::HasSubstr("expected 16 bytes from rank " + std::to_string(all.size() - 2) + ", got 8"));
  }
  if (all.rank() > 0 && all.rank() < all.size() - 1) {
    EXPECT_EQ(found, "");
  }
}

TEST(Communicator, ARankAtAnotherCallIsNamed) {
  const auto& all = all_ranks();
  if (all.size() == 1) return;
  const char purpose = all.rank() == 1 ? 'y' : 'x';
  const double one = 1.0;
  const std::string found =
      complaint([&] { static_cast<void>(all.gather(std::span<const double>(&one, 1), purpose)); });
  EXPECT_THAT(found, testing::HasSubstr(all.rank() == 1 ? "rank 0 at another" : "rank 1 at another"));
}

TEST(Communicator, AMessageToARankThatIsNotThereIsAnErrorOfThatCall) {
  const auto& all = all_ranks();
  const std::array<std::byte, 1> byte{};
  const Outgoing message{all.size(), byte};
  const std::string found = complaint([&] { all.begin(std::span(&message, 1), {}).finish(); });
  EXPECT_THAT(found, testing::HasSubstr("MPI_Isend failed"));
}

}  // namespace
}  // namespace poretwin::tiles
