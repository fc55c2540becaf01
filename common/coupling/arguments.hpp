// The command line of poretwin-fluid, poretwin-solid and poretwin-coupler.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace poretwin::coupling {

struct Arguments {
  std::filesystem::path case_file, out;
  std::string address;         ///< --connect or --bind
  std::filesystem::path keys;  ///< --keys; empty: nothing is encrypted
  bool alone = false;
  bool help = false, version = false;
  bool allow_any_address = false;
  int progress_descriptor = -1;
  double wait_deadline = 60.0;    ///< s
  double frozen_deadline = 30.0;  ///< s
  bool resume = false;
  bool overwrite = false;               ///< begin anew where checkpoints lie
  bool accept_changed_program = false;  ///< resume what another program wrote
  bool profile = false;                 ///< every span of time to OUT/trace.<process>.json
  double checkpoint_every = 60.0;       ///< s of wall-clock; infinite: only when interrupted
  std::vector<std::string> overrides;
};
enum class Program { phase, coupler };

/// An argument as --help, man pages and completions show it.
struct DeclaredArgument {
  std::string name, value, help;  ///< value: what follows the name, "DIR"; empty: nothing
};
std::vector<DeclaredArgument> declared_arguments(Program program);

/// Throws CaseError naming the argument, what was expected, what was found.
Arguments parse_arguments(int argc, char** argv, Program program);
std::string usage(const std::string& name, Program program);
/// The line of `usage` that shows what must be given.
std::string synopsis(const std::string& name, Program program);

}  // namespace poretwin::coupling
