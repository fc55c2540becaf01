// The command line of poretwin-fluid, poretwin-solid and poretwin-coupler.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace poretwin::coupling {

struct Arguments {
  std::filesystem::path case_file, out;
  std::string address;         ///< --connect or --bind
  std::filesystem::path keys;  ///< --keys; empty: no encryption
  bool alone = false;
  bool help = false, version = false;
  bool allow_any_address = false;
  int progress_descriptor = -1;
  double wait_deadline = 60.0;    ///< s, longest wait for the participants to join
  double frozen_deadline = 30.0;  ///< s without a sign of life after which a participant counts as frozen
  bool resume = false;
  bool overwrite = false;               ///< start a new run in spite of existing checkpoints
  bool accept_changed_program = false;  ///< also resume from checkpoints that another program wrote
  bool profile = false;                 ///< write all time spans to OUT/trace.<process>.json
  double checkpoint_every = 60.0;       ///< s of wall-clock time; infinite: only when interrupted
  std::vector<std::string> overrides;
  std::filesystem::path
      safety_of;  ///< solid: frames of a run for which factors of safety are searched for; otherwise empty
  std::vector<std::size_t> frames;  ///< solid: numbers of these frames, from 0
  double tolerance = 0.01;          ///< solid: width of the bracket over the factor of safety
};
enum class Program { phase, solid, coupler };

/// An argument as shown by --help, man pages and shell completions.
struct DeclaredArgument {
  std::string name, value, help;  ///< value: placeholder after the name, as "DIR"; empty: no value
};
std::vector<DeclaredArgument> declared_arguments(Program program);

/// The parsed command line. Throws CaseError that names the argument, what was expected and what was found.
Arguments parse_arguments(int argc, char** argv, Program program);
std::string usage(const std::string& name, Program program);
/// The line of `usage` that shows the required arguments.
std::string synopsis(const std::string& name, Program program);

}  // namespace poretwin::coupling
