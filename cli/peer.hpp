// The sub-commands of `poretwin peer` on the command line.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace poretwin::cli {

/// Declares `peer` and its sub-commands; parsing sets `action` to the chosen one.
void declare_peer(CLI::App& app, std::function<int()>& action);

}  // namespace poretwin::cli
