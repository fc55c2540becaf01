// Man pages and shell completions, made from the declarations of the command line.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace poretwin::cli {

/// Declares the hidden command `describe WHAT`, which prints the file WHAT: poretwin.1, poretwin-fluid.bash, ..
void declare_describe(CLI::App& app, std::function<int()>& action);

}  // namespace poretwin::cli
