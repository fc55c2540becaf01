// Three hosts in three network namespaces, connected by virtual cables: the three commands of the README, unencrypted
// and encrypted, without a shared file system, and with a cable that is cut. Needs the right to make namespaces (root).
#include "common/output/gauge_log.hpp"
#include "tests/system/command.hpp"

#include <sys/stat.h>

namespace poretwin::testing_tools {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;
using namespace std::chrono_literals;
using Strings = std::vector<std::string>;

/// A host: a process that keeps a network namespace alive.
class Host {
 public:
  Host() : keeper_(Strings{"/usr/bin/unshare", "--net", "/bin/sleep", "600"}, "/dev/null") {
    // unshare becomes sleep once it is in its own namespace.
    const auto comm = "/proc/" + std::to_string(keeper_.pid()) + "/comm";
    for (int k = 0; k < 400 && text_of(comm) != "sleep\n"; ++k) std::this_thread::sleep_for(5ms);
  }
  [[nodiscard]] std::string pid() const { return std::to_string(keeper_.pid()); }
  /// The arguments that run a command on this host.
  [[nodiscard]] Strings in(const Strings& command) const {
    Strings words{"/usr/bin/nsenter", "--net", "--target", pid()};
    words.insert(words.end(), command.begin(), command.end());
    return words;
  }

 private:
  Child keeper_;
};

class Network : public Command {
 protected:
  void SetUp() override {
    Command::SetUp();
    for (const char* tool : {"/usr/bin/unshare", "/usr/bin/nsenter", "/bin/sh"})
      if (!fs::exists(tool)) GTEST_SKIP() << tool << " is not here";
    if (shell("unshare --net true") != 0) GTEST_SKIP() << "no right to make a network namespace";
    if (shell("command -v ip") != 0) GTEST_SKIP() << "the command ip (iproute2) is not here";
    for (auto& host : hosts_) host = std::make_unique<Host>();
    // Cables from the coupler's host (0) to the fluid's (1) and to the solid's (2).
    for (const int k : {1, 2}) {
      const auto n = std::to_string(k);
      ASSERT_EQ(on(0, "ip link add cable" + n + " type veth peer name cable netns " +
                          hosts_[static_cast<std::size_t>(k)]->pid() + " && ip address add 10.71." + n +
                          ".1/24 dev cable" + n + " && ip link set cable" + n + " up && ip link set lo up"),
                0);
      ASSERT_EQ(on(k, "ip address add 10.71." + n + ".2/24 dev cable && ip link set cable up && ip link set lo up"), 0);
    }
  }
  void TearDown() override {
    for (auto& host : hosts_) host.reset();
    Command::TearDown();
  }

  int shell(const std::string& script) const {
    return Child({"/bin/sh", "-c", script}, folder_ / "shell.log").wait(20s);
  }
  int on(int host, const std::string& script) const {
    return Child(hosts_[static_cast<std::size_t>(host)]->in({"/bin/sh", "-c", script}), folder_ / "shell.log")
        .wait(20s);
  }
  static fs::path program(const std::string& name) {
    return fs::path(PORETWIN_PROGRAM).parent_path() / ("poretwin-" + name);
  }
  std::unique_ptr<Child> coupler(Strings more, const std::string& end = "0.02") const {
    Strings words{program("coupler"),    "--case", terzaghi(),     "--out",
                  folder_ / "a",         "--bind", "tcp://*:5555", "--set",
                  "case.end_time=" + end};
    words.insert(words.end(), more.begin(), more.end());
    return std::make_unique<Child>(hosts_[0]->in(words), log("coupler"));
  }
  /// A solver without a case file: the coupler sends the case.
  std::unique_ptr<Child> solver(const std::string& name, Strings more) const {
    const int host = name == "fluid" ? 1 : 2;
    Strings words{program(name), "--out", folder_ / name, "--connect",
                  "tcp://10.71." + std::to_string(host) + ".1:5555"};
    words.insert(words.end(), more.begin(), more.end());
    return std::make_unique<Child>(hosts_[static_cast<std::size_t>(host)]->in(words), log(name));
  }
  [[nodiscard]] fs::path log(const std::string& name) const { return folder_ / (name + ".log"); }
  [[nodiscard]] fs::path key(const std::string& holder) const { return folder_ / "keys" / (holder + ".key"); }
  void make_keys() const { ASSERT_EQ(poretwin({"keys", (folder_ / "keys").string()}).exit, 0); }
  void expect_run(Strings coupler_options, Strings solver_options) const {
    const auto fluid = solver("fluid", solver_options);
    std::this_thread::sleep_for(300ms);  // any order of starting
    const auto c = coupler(std::move(coupler_options));
    const auto solid = solver("solid", solver_options);
    EXPECT_EQ(c->wait(30s), 0) << text_of(log("coupler"));
    EXPECT_EQ(fluid->wait(), 0) << text_of(log("fluid"));
    EXPECT_EQ(solid->wait(), 0) << text_of(log("solid"));
    EXPECT_NEAR(read_gauges(folder_ / "fluid" / "gauges.fluid.csv").at("base_pressure").value.back(), 1000.0, 50.0);
    EXPECT_EQ(text_of(folder_ / "solid" / "case.toml"), text_of(terzaghi()));
  }
  void wait_until_running() const {
    for (int k = 0; k < 2000 && text_of(folder_ / "fluid" / "gauges.fluid.csv").find("\n0.01") == std::string::npos;
         ++k)
      std::this_thread::sleep_for(10ms);
  }

  std::array<std::unique_ptr<Host>, 3> hosts_;
};

TEST_F(Network, ThreeHostsRunPlainWhenThatIsSaid) { expect_run({"--allow-any-address"}, {}); }

TEST_F(Network, ThreeHostsRunEncrypted) {
  make_keys();
  expect_run({"--keys", key("coupler")}, {"--keys", key("participant")});
}

TEST_F(Network, AnotherAddressThanLoopbackNeedsKeysOrTheFlag) {
  const auto c = coupler({});
  EXPECT_EQ(c->wait(), 2);
  EXPECT_THAT(text_of(log("coupler")), HasSubstr("--keys"));
}

TEST_F(Network, WithoutTheRightKeyNobodyComesIn) {
  make_keys();
  ASSERT_EQ(poretwin({"keys", (folder_ / "others").string()}).exit, 0);
  const auto c = coupler({"--keys", key("coupler"), "--wait-deadline", "4"});
  const auto open = solver("fluid", {"--wait-deadline", "3"});
  const auto stranger = solver("solid", {"--wait-deadline", "3", "--keys", folder_ / "others" / "participant.key"});
  EXPECT_EQ(open->wait(), 3);
  EXPECT_EQ(stranger->wait(), 3);
  EXPECT_EQ(c->wait(), 3);
  EXPECT_THAT(text_of(log("fluid")), HasSubstr("have both sides keys that `poretwin keys` made together"));
  EXPECT_THAT(text_of(log("solid")), HasSubstr("have both sides keys that `poretwin keys` made together"));
  EXPECT_THAT(text_of(log("coupler")), HasSubstr("fluid and solid did not come"));
  EXPECT_THAT(text_of(log("coupler")), HasSubstr("was turned away"));
}

TEST_F(Network, AKeyMadeForThisCouplerButNotThisParticipantIsNotLetIn) {
  make_keys();
  ASSERT_EQ(poretwin({"keys", (folder_ / "others").string()}).exit, 0);
  // The coupler's public key is right, but the participant's own key pair is not the one that the coupler admits.
  const std::string right = text_of(key("participant"));
  std::string forged = text_of(folder_ / "others" / "participant.key");
  forged.replace(forged.find("peer "), 45, right.substr(right.find("peer "), 45));
  const auto file = folder_ / "forged.key";
  std::ofstream(file) << forged;
  ::chmod(file.c_str(), 0600);
  const auto c = coupler({"--keys", key("coupler"), "--wait-deadline", "4"});
  const auto stranger = solver("solid", {"--wait-deadline", "3", "--keys", file});
  EXPECT_EQ(stranger->wait(), 3);
  EXPECT_EQ(c->wait(), 3);
  EXPECT_THAT(text_of(log("coupler")), HasSubstr("somebody at 10.71.2.2 without the participant's key was not let in"));
}

TEST_F(Network, ACutCableIsCalledSo) {
  const auto c = coupler({"--allow-any-address", "--frozen-deadline", "4"}, "100"),
             fluid = solver("fluid", {"--frozen-deadline", "4"}), solid = solver("solid", {"--frozen-deadline", "2.5"});
  wait_until_running();
  ASSERT_EQ(on(2, "ip link set cable down"), 0);
  EXPECT_EQ(c->wait(15s), 3);
  EXPECT_EQ(fluid->wait(), 3);
  EXPECT_EQ(solid->wait(15s), 3);
  EXPECT_THAT(text_of(log("coupler")), HasSubstr("solid is unreachable: the line is cut or its host is down"));
  EXPECT_THAT(text_of(log("coupler")), HasSubstr("at step"));
  EXPECT_THAT(text_of(log("fluid")), HasSubstr("aborted by solid"));
  EXPECT_THAT(text_of(log("solid")), HasSubstr("the coupler is unreachable, the line is cut or its host is down"));
}

TEST_F(Network, AStoppedSolverBehindAWholeCableIsCalledFrozen) {
  const auto c = coupler({"--allow-any-address", "--frozen-deadline", "2.5"}, "100"), fluid = solver("fluid", {}),
             solid = solver("solid", {});
  wait_until_running();
  solid->signal(SIGSTOP);
  const auto stopped = std::chrono::steady_clock::now();
  EXPECT_EQ(c->wait(15s), 3);
  EXPECT_LT(std::chrono::steady_clock::now() - stopped, 6s);
  EXPECT_EQ(fluid->wait(), 3);
  EXPECT_THAT(text_of(log("coupler")), HasSubstr("solid is frozen: its connection stands"));
}

TEST_F(Network, ACablePluggedInAgainInTimeChangesNothing) {
  const auto c = coupler({"--allow-any-address"}, "0.1"), fluid = solver("fluid", {}), solid = solver("solid", {});
  wait_until_running();
  ASSERT_EQ(on(2, "ip link set cable down"), 0);
  std::this_thread::sleep_for(2s);
  ASSERT_EQ(on(2, "ip link set cable up"), 0);
  EXPECT_EQ(c->wait(60s), 0) << text_of(log("coupler"));
  EXPECT_EQ(fluid->wait(), 0) << text_of(log("fluid"));
  EXPECT_EQ(solid->wait(), 0) << text_of(log("solid"));
}

TEST_F(Network, ASlowLineIsAWorkingLine) {
  if (on(1, "tc qdisc add dev cable root netem delay 20ms") != 0)
    GTEST_SKIP() << "this kernel offers no netem: " << text_of(folder_ / "shell.log");
  expect_run({"--allow-any-address"}, {});
}

}  // namespace
}  // namespace poretwin::testing_tools
