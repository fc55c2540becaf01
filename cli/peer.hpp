// `poretwin peer`: its sub-commands on the command line.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace poretwin::cli {

/// Declares `peer` and its sub-commands; the chosen one is left in `action`.
void declare_peer(CLI::App& app, std::function<int()>& action);

}  // namespace poretwin::cli
