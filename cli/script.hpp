// Commands that are Python scripts: `poretwin plot`, `poretwin view`, `poretwin bench`.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace poretwin::cli {

/// Runs a script of the data folder ("cli/plot.py") and returns its exit code. Its output goes to the file `log`; if
/// `log` is empty, to the terminal.
int run_script(const std::string& name, const std::vector<std::string>& arguments,
               const std::filesystem::path& log = {});

/// Replaces this process by the script. Throws FileError when there is no Python.
[[noreturn]] void become_script(const std::string& name, const std::vector<std::string>& arguments);

/// Draws pictures of fields and gauges of a run.
inline int draw_pictures(const std::vector<std::string>& arguments, const std::filesystem::path& log) {
  return run_script("cli/plot.py", arguments, log);
}

}  // namespace poretwin::cli
