// The real `poretwin`, run in a temporary folder.
#pragma once

#include "tests/child.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

namespace poretwin::testing_tools {

struct Outcome {
  int exit = -1;
  std::string out, err;
  double seconds = 0.0;
};

class Command : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fresh_folder("poretwin-command");
    std::filesystem::create_directories(folder_ / "temporary");
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  /// Runs the program; `meanwhile` is called with its process id.
  Outcome poretwin(std::vector<std::string> arguments, Child::Environment environment = {},
                   const std::function<void(pid_t)>& meanwhile = {}) const {
    arguments.insert(arguments.begin(), PORETWIN_PROGRAM);
    environment.emplace_back("TMPDIR", (folder_ / "temporary").string());
    const auto start = std::chrono::steady_clock::now();
    Child child(std::move(arguments), folder_ / "out", folder_ / "err", environment);
    if (meanwhile) meanwhile(child.pid());
    Outcome outcome;
    outcome.exit = child.wait(std::chrono::seconds(60));
    outcome.out = text_of(folder_ / "out");
    outcome.err = text_of(folder_ / "err");
    outcome.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return outcome;
  }

  static std::filesystem::path terzaghi() {
    return std::filesystem::path(PORETWIN_SOURCE_DIR) / "cases" / "terzaghi" / "case.toml";
  }
  [[nodiscard]] std::filesystem::path out() const { return folder_ / "run"; }
  /// A copy of the case with one piece of its text replaced.
  [[nodiscard]] std::filesystem::path changed_case(const std::string& from, const std::string& to) const {
    std::string text = text_of(terzaghi());
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    std::ofstream(folder_ / "changed.toml") << text.replace(at, from.size(), to);
    return folder_ / "changed.toml";
  }

  std::filesystem::path folder_;
};

}  // namespace poretwin::testing_tools
