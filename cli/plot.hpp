// `poretwin plot`: pictures of fields and gauges, drawn by plot.py.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace poretwin::cli {

/// Runs plot.py with the arguments; its output goes to `log` (empty: to the terminal). Returns its exit code.
int draw_pictures(const std::vector<std::string>& arguments, const std::filesystem::path& log);

}  // namespace poretwin::cli
