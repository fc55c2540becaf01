// The command `poretwin`.
#include "cli/commands.hpp"
#include "common/core/error.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace {

using namespace poretwin;
using namespace poretwin::cli;

int failed(JsonOutput& json, const std::string& what, ExitCode code) {
  std::fprintf(stderr, "poretwin: %s\n", what.c_str());
  const int exit = static_cast<int>(code);
  if (!json.wanted()) return exit;
  try {
    json.write(json_error(json.command(), exit, what));
    json.finish();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "poretwin: %s\n", error.what());
  }
  return exit;
}

/// Opens the JSON output named by the command line, even where the rest of it cannot be parsed.
void open_json(JsonOutput& json, const std::vector<std::string>& words) {
  const std::string name = "--json";
  for (std::size_t k = 1; k < words.size(); ++k)
    if (words[k].starts_with(name + "="))
      return json.open(words[0], words[k].substr(name.size() + 1));
    else if (words[k] == name && k + 1 < words.size())
      return json.open(words[0], words[k + 1]);
}

/// Parses the command line. Names unexpected arguments in the order in which they were given; CLI11 lists them from the
/// last to the first.
void parse(CommandLine& line, int argc, char** argv) {
  try {
    line.parse(argc, argv);
  } catch (const CLI::ExtrasError&) {
    throw CLI::ExtrasError(fmt::format("not expected: {}", fmt::join(line.remaining(true), " ")),
                           CLI::ExitCodes::ExtrasError);
  }
}

int command(int argc, char** argv, JsonOutput& json) {
  CommandLine line(json);
  try {
    parse(line, argc, argv);
  } catch (const CLI::ParseError& error) {
    if (line.exit(error) == 0) return 0;
    open_json(json, {argv + 1, argv + argc});
    if (json.wanted()) json.write(json_error(json.command(), static_cast<int>(ExitCode::bad_case), error.what()));
    return static_cast<int>(ExitCode::bad_case);
  }
  return line.act();
}

}  // namespace

int main(int argc, char** argv) {
  JsonOutput json;
  try {
    const int exit = command(argc, argv, json);
    json.finish();
    return exit;
  } catch (const Error& error) {
    return failed(json, error.what(), error.code());
  } catch (const std::filesystem::filesystem_error& error) {
    return failed(json, error.what(), ExitCode::input_output);
  } catch (const std::exception& error) {
    return failed(json, std::string("unforeseen: ") + error.what(), ExitCode::failure);
  }
}
