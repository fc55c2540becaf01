// Checkpoint files: complete or absent, of this run or refused; the last two are kept.
#include "common/checkpoint/schedule.hpp"
#include "tests/child.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>

namespace poretwin {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

class Store : public testing::Test {
 protected:
  void TearDown() override { fs::remove_all(folder_); }
  CheckpointStore store(const RunIdentity& identity = {{"case file", "a"}}) {
    return {folder_, "fluid", identity, [this](const std::string& line) { said_ += line + "\n"; }};
  }
  static Archive state(double x) {
    Archive out;
    out(x);
    return out;
  }
  static double number_in(Archive archive) {
    double x = 0.0;
    archive(x);
    archive.expect_end();
    return x;
  }
  [[nodiscard]] std::vector<std::string> names(const CheckpointStore& s) const {
    std::vector<std::string> out;
    for (const auto& checkpoint : s.whole()) out.push_back(checkpoint.name);
    return out;
  }
  fs::path file(const std::string& name) const { return folder_ / "checkpoints" / ("fluid-" + name + ".state"); }

  fs::path folder_ = testing_tools::fresh_folder("poretwin-store");
  std::string said_;
};

TEST_F(Store, NewestFirstAndOnlyItsOwn) {
  const auto s = store();
  EXPECT_TRUE(s.whole().empty());
  EXPECT_FALSE(has_checkpoints(folder_, "fluid"));
  s.write({"x-3", 3, 0.3}, state(0.3));
  s.write({"x-20", 20, 2.0}, state(2.0));
  CheckpointStore(folder_, "solid", {}).write({"x-30", 30, 3.0}, state(3.0));
  EXPECT_THAT(names(s), ElementsAre("x-20", "x-3"));
  EXPECT_EQ(s.whole().front().time, 2.0);
  EXPECT_EQ(number_in(s.read("x-3")), 0.3);
  EXPECT_TRUE(has_checkpoints(folder_, "fluid"));
  s.keep_only({"x-20"});
  EXPECT_THAT(names(s), ElementsAre("x-20"));
  EXPECT_TRUE(has_checkpoints(folder_, "solid"));
}

TEST_F(Store, DamageOfAnyKindLeavesTheOlderOne) {
  const auto s = store();
  s.write({"x-1", 1, 0.1}, state(0.1));
  s.write({"x-2", 2, 0.2}, state(0.2));
  const std::string good = testing_tools::text_of(file("x-2"));
  for (std::size_t k = 0; k < good.size(); ++k) {
    std::string bad = good;
    bad[k] = static_cast<char>(bad[k] ^ 0x10);
    std::ofstream(file("x-2"), std::ios::binary) << bad;
    ASSERT_THAT(names(s), ElementsAre("x-1")) << "byte " << k;
    std::ofstream(file("x-2"), std::ios::binary) << good.substr(0, k);
    ASSERT_THAT(names(s), ElementsAre("x-1")) << "cut at " << k;
  }
  EXPECT_THAT(said_, HasSubstr("fluid-x-2.state: is damaged: its checksum differs"));
  EXPECT_THAT(said_, HasSubstr("cut off"));
  EXPECT_THROW(static_cast<void>(s.read("x-2")), FileError);
}

TEST_F(Store, AnotherCaseIsRefusedByName) {
  store().write({"x-1", 1, 0.1}, state(0.1));
  try {
    static_cast<void>(store({{"case file", "b"}}).whole());
    FAIL();
  } catch (const CaseError& error) {
    EXPECT_THAT(error.what(),
                HasSubstr("fluid-x-1.state: case file: expected that of the run to be resumed, a, found b"));
  }
}

/// A file that cannot grow, as on a full disk: the cause is reported, the checkpoint before is kept, no incomplete file
/// remains.
TEST_F(Store, NoRoomLeavesTheOlderOne) {
  const auto s = store();
  s.write({"x-1", 1, 0.1}, state(0.1));
  Archive large;
  std::vector<double> numbers(100'000, 1.0);
  large(numbers);
  rlimit before{};
  ::getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small{4096, before.rlim_max};
  const auto old = std::signal(SIGXFSZ, SIG_IGN);
  ::setrlimit(RLIMIT_FSIZE, &small);
  std::string what;
  try {
    s.write({"x-2", 2, 0.2}, large);
  } catch (const FileError& error) {
    what = error.what();
  }
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, old);
  EXPECT_THAT(what, HasSubstr("cannot be written: File too large"));
  EXPECT_THAT(names(s), ElementsAre("x-1"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "checkpoints"), {}), 1);
}

TEST_F(Store, ANameThatPointsElsewhereIsRefused) {
  const auto s = store();
  for (const auto& name : std::vector<std::string>{"", "../x", "a/b", "A", "a.b", std::string(65, 'a')}) {
    EXPECT_THROW(s.write({name, 1, 0.1}, state(0.1)), PeerError) << name;
    EXPECT_THROW(static_cast<void>(s.read(name)), PeerError) << name;
  }
}

TEST_F(Store, AFolderThatCannotBeMadeIsNamed) {
  std::ofstream(folder_ / "checkpoints") << "a file in its place";
  try {
    store().write({"x-1", 1, 0.1}, state(0.1));
    FAIL();
  } catch (const FileError& error) {
    EXPECT_THAT(error.what(), HasSubstr("the folder cannot be made"));
  }
}

TEST(CheckpointSchedule, KeepsTwoAndIsDueInTime) {
  const CheckpointStore store("/nowhere", "x", {});
  CheckpointSchedule always({&store, 0.0, false}), hourly({&store, 3600.0, false}), never({});
  EXPECT_TRUE(always.due());
  EXPECT_FALSE(hourly.due());
  EXPECT_FALSE(never.due());
  EXPECT_NE(always.name(1), hourly.name(1));
  for (const char* name : {"a", "b", "c"}) always.committed(name);
  EXPECT_THAT(always.kept(), ElementsAre("c", "b"));
}

}  // namespace
}  // namespace poretwin
