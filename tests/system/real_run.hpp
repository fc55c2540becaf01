// The real `poretwin` with the real processes, and helpers that read their results.
#pragma once

#include "common/output/gauge_log.hpp"
#include "common/output/hdf5.hpp"
#include "tests/system/command.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cmath>
#include <memory>
#include <numeric>

namespace poretwin::testing_tools {

namespace fs = std::filesystem;

/// Times of the steps in a file of particles; checks that every step is complete and every number finite.
inline std::vector<double> steps_in(const fs::path& path) {
  const auto file = hdf5::File::open_to_read(path);
  const auto times = file.read_numbers("VTKHDF/Steps/Values");
  EXPECT_EQ(file.attribute_integers("VTKHDF/Steps", "NSteps"), std::vector<std::int64_t>{std::ssize(times)});
  const auto points = file.read_integers("VTKHDF/NumberOfPoints");
  EXPECT_EQ(points.size(), times.size());
  const auto all = static_cast<std::size_t>(std::accumulate(points.begin(), points.end(), std::int64_t{0}));
  EXPECT_EQ(file.shape("VTKHDF/Points"), (std::vector<std::size_t>{all, 3}));
  for (const auto& field : file.names("VTKHDF/PointData")) {
    EXPECT_EQ(file.shape("VTKHDF/PointData/" + field).front(), all) << field;
    for (const double value : file.read_numbers("VTKHDF/PointData/" + field))
      if (!std::isfinite(value)) {
        ADD_FAILURE() << field << " is not finite in " << path;
        break;
      }
  }
  return times;
}

/// A port of this machine that is not in use.
inline int free_port() {
  const int descriptor = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  auto* general = reinterpret_cast<sockaddr*>(&address);
  EXPECT_EQ(::bind(descriptor, general, size), 0);
  EXPECT_EQ(::getsockname(descriptor, general, &size), 0);
  ::close(descriptor);
  return ntohs(address.sin_port);
}

/// The child of `parent` that runs the program of this name; 0: none.
inline pid_t child_called(pid_t parent, const std::string& name) {
  const auto id = std::to_string(parent);
  std::istringstream children(text_of("/proc/" + id + "/task/" + id + "/children"));
  for (pid_t child = 0; children >> child;)
    if (text_of("/proc/" + std::to_string(child) + "/comm") == name + "\n") return child;
  return 0;
}

inline void wait_for(const std::function<bool()>& condition) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (!condition() && std::chrono::steady_clock::now() < deadline)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
}

class RealRun : public Command {
 protected:
  std::vector<std::string> arguments(const fs::path& file, std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"run", file.string(), "--out", out().string(), "--no-pictures"});
    return more;
  }
  std::unique_ptr<Child> process(const std::string& name, std::vector<std::string> more,
                                 const Child::Environment& environment = {}, const fs::path& program = {}) const {
    const auto real = fs::path(PORETWIN_PROGRAM).parent_path() / ("poretwin-" + name);
    const std::string chosen = (program.empty() ? real : program).string();
    more.insert(more.begin(), {chosen, "--case", terzaghi().string(), "--out", out().string()});
    return std::make_unique<Child>(std::move(more), log(name), log(name), environment);
  }
  std::unique_ptr<Child> short_process(const std::string& name, const std::string& address,
                                       std::vector<std::string> more = {}, const Child::Environment& environment = {},
                                       const fs::path& program = {}) const {
    more.insert(more.begin(), {name == "coupler" ? "--bind" : "--connect", address, "--set", "case.end_time=0.02",
                               "--wait-deadline", "2"});
    return process(name, std::move(more), environment, program);
  }
  [[nodiscard]] fs::path log(const std::string& name) const { return folder_ / (name + ".log"); }
  [[nodiscard]] std::string socket() const { return "ipc://" + (folder_ / "socket").string(); }
  /// A folder with the real programs, but with a mock in place of one of them.
  [[nodiscard]] fs::path programs_with_mock(const std::string& instead_of) const {
    const auto folder = folder_ / "programs";
    fs::create_directories(folder);
    for (const std::string name : {"coupler", "fluid", "solid"}) {
      const auto program = "poretwin-" + name;
      fs::create_symlink(
          name == instead_of ? fs::path(MOCK_PROCESS) : fs::path(PORETWIN_PROGRAM).parent_path() / program,
          folder / program);
    }
    return folder;
  }
  void expect_results(double end) const {
    for (const char* name : {"fluid.vtkhdf", "solid.vtkhdf"}) {
      const auto times = steps_in(out() / name);
      ASSERT_GE(times.size(), 2u) << name;
      EXPECT_EQ(times.front(), 0.0);
      EXPECT_NEAR(times.back(), end, 1e-12);
    }
  }
};

}  // namespace poretwin::testing_tools
