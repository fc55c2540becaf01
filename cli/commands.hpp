// The command line of poretwin: all commands with their options, and what each does.
#pragma once

#include "cli/json_output.hpp"

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>

namespace poretwin::cli {

class CommandLine : public CLI::App {
 public:
  explicit CommandLine(JsonOutput& json);
  ~CommandLine() override;
  /// Runs the command that the parsed command line names; returns the exit code.
  int act() const { return action_(); }

  struct Arguments;

 private:
  std::unique_ptr<Arguments> arguments_;
  std::function<int()> action_;
};

}  // namespace poretwin::cli
