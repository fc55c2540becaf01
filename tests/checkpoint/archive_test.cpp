// What is written to an archive is read back unchanged, for all kinds of values; a shortened archive is refused before
// memory is allocated.
#include "common/core/archive.hpp"
#include "common/core/vector.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace poretwin {
namespace {

enum class Kind : std::uint8_t { one, two };

struct Inner {
  double x = 0.0;
  Vec<2> v = Vec<2>::Zero();
  std::vector<Kind> kinds;
  bool operator==(const Inner&) const = default;
};

struct Outer {
  int count = 0;
  std::string text;
  std::vector<Inner> inners;
  std::array<Inner, 2> pair;
  std::map<std::string, std::uint64_t> numbers;
  std::optional<double> maybe, never;
  MatArray<3> tensors;
  std::pair<char, bool> last{};
  bool operator==(const Outer&) const = default;
};

class Secret {
 public:
  void set(int x) { x_ = x; }
  [[nodiscard]] int get() const { return x_; }
  void archive(Archive& archive) { archive(x_); }

 private:
  int x_ = 0;
};

Outer filled() {
  Outer out;
  out.count = -7;
  out.text = std::string("with\0zero", 9);
  out.inners = {{1.0 / 3.0, {1e-300, -0.0}, {Kind::two, Kind::one}}, {}};
  out.pair[1].x = 5e-324;
  out.numbers = {{"a", 1}, {"", ~0ull}};
  out.maybe = 0.1;
  out.tensors = {Mat<3>::Identity(), Mat<3>::Constant(0.1)};
  out.last = {'c', true};
  return out;
}

TEST(Archive, EveryMemberOfAnAggregateIsCounted) {
  static_assert(count_fields<Inner>() == 3);
  static_assert(count_fields<Outer>() == 9);
}

TEST(Archive, BringsBackWhatItTook) {
  Outer then = filled();
  Secret secret;
  secret.set(42);
  Archive out;
  out(then, secret);
  Outer now;
  Secret told;
  now.inners.resize(5);
  now.never = 1.0;
  now.numbers = {{"old", 3}};
  Archive in(out.bytes());
  in(now, told);
  in.expect_end();
  EXPECT_EQ(now, then);
  EXPECT_TRUE(std::signbit(now.inners[0].v[1]));
  EXPECT_EQ(told.get(), 42);
}

TEST(Archive, KeepsTheBitsOfNoNumber) {
  double payload = std::bit_cast<double>(0x7ff8000000001234ull), infinite = std::numeric_limits<double>::infinity();
  Archive out;
  out(payload, infinite);
  Archive in(out.bytes());
  double a = 0.0, b = 0.0;
  in(a, b);
  EXPECT_EQ(std::bit_cast<std::uint64_t>(a), 0x7ff8000000001234ull);
  EXPECT_EQ(b, infinite);
}

TEST(Archive, EveryCutIsNoticed) {
  Outer then = filled();
  Archive out;
  out(then);
  for (std::size_t length = 0; length < out.bytes().size(); ++length) {
    Archive in(out.bytes().substr(0, length));
    Outer now;
    EXPECT_THROW(in(now), FileError) << length;
  }
  Archive longer(out.bytes() + "x");
  Outer now;
  longer(now);
  EXPECT_THROW(longer.expect_end(), FileError);
}

/// A size is compared with the number of bytes left before memory is allocated.
TEST(Archive, ASizeBeyondTheBytesIsRefused) {
  std::uint64_t huge = std::uint64_t{1} << 60;
  Archive out;
  out(huge);
  std::vector<double> numbers;
  std::vector<Inner> inners;
  EXPECT_THROW(Archive(out.bytes())(numbers), FileError);
  EXPECT_THROW(Archive(out.bytes())(inners), FileError);
}

}  // namespace
}  // namespace poretwin
