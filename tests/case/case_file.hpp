// Helpers that write case files, read them and collect the messages.
#pragma once

#include "common/case/case.hpp"
#include "common/core/error.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace poretwin {

class CaseFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("poretwin-case-" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  Case read(const std::string& text, const std::vector<std::string>& overrides = {}) {
    const auto path = folder_ / "case.toml";
    std::ofstream(path) << text;
    return read_case(path, overrides);
  }
  std::string complaint(const std::string& text, const std::vector<std::string>& overrides = {}) {
    try {
      read(text, overrides);
    } catch (const CaseError& error) {
      return error.what();
    }
    return "no complaint";
  }
  /// All warnings on a case that may run.
  std::string warnings(const std::string& text, const std::vector<std::string>& overrides = {}) {
    std::string all;
    for (const auto& warning : read(text, overrides).warnings) all += warning + "\n";
    return all;
  }
  static std::string changed(std::string text, const std::string& from, const std::string& to) {
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  }

  std::filesystem::path folder_;
};

}  // namespace poretwin
