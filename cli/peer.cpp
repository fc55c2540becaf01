#include "cli/peer.hpp"

#include "cli/locate.hpp"
#include "common/core/error.hpp"
#include "peer/peer.hpp"

#include <iostream>
#include <string>
#include <vector>

namespace poretwin::cli {
namespace {

/// Declares a sub-command with one argument; all words after it are passed on.
CLI::App* declare_one(CLI::App& peer, const std::string& name, const std::string& word, const std::string& about,
                      std::function<int()>& action,
                      int (*run)(const std::string& word, const std::vector<std::string>& rest)) {
  auto* command = peer.add_subcommand(name, about);
  command->prefix_command();
  command->callback([command, name, word, run, &action] {
    action = [command, name, word, run] {
      auto words = command->remaining();
      if (words.empty()) throw CaseError("peer " + name + ": " + word + " is missing; see poretwin peer --help");
      const std::string first = words.front();
      words.erase(words.begin());
      if (!words.empty() && words.front() == "--") words.erase(words.begin());
      return run(first, words);
    };
  });
  return command;
}

}  // namespace

void declare_peer(CLI::App& app, std::function<int()>& action) {
  auto* peer = app.add_subcommand("peer", "Stand-ins for a solver, recordings, and a suite that examines one");
  peer->require_subcommand(1);
  peer->footer(
      "poretwin peer mock fluid|solid ARGUMENTS    ARGUMENTS: those of poretwin-fluid and poretwin-solid\n"
      "poretwin peer record LOG COMMAND...         COMMAND: a solver with its --connect ADDRESS\n"
      "poretwin peer replay LOG ARGUMENTS\n"
      "poretwin peer conformance CASE COMMAND...   COMMAND: a solver without --case, --out and --connect\n"
      "The first three take a solver's place: poretwin run CASE --solid \"poretwin peer mock solid\"");
  declare_one(*peer, "mock", "fluid or solid", "The case's fields at rest, as a fluid or a solid", action,
              [](const std::string& role, const auto& rest) { return peer::mock(role, rest); });
  declare_one(*peer, "record", "LOG", "Run a solver and keep its conversation in the file LOG", action,
              [](const std::string& log, const auto& rest) { return peer::record(log, rest); });
  declare_one(*peer, "replay", "LOG", "Play the recorded solver again", action,
              [](const std::string& log, const auto& rest) { return peer::replay(log, rest); });
  declare_one(*peer, "conformance", "CASE", "Examine a solver, in any language, that runs alone", action,
              [](const std::string& which, const auto& rest) {
                return peer::conformance(find_case(which).file, rest, std::cout);
              });
}

}  // namespace poretwin::cli
