// `poretwin verify`: runs cases and compares them with their references.
#pragma once

#include "cli/json_output.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace poretwin::cli {

struct VerifyOptions {
  std::string which;             ///< a case, or "all"
  std::filesystem::path report;  ///< folder for a page with pictures; empty: no page
  std::string run;               ///< only this run of the case; empty: all runs
  std::vector<std::string> overrides;
  bool short_runs = false;
  int tiles = 1;  ///< see RunOptions
  std::filesystem::path programs, out = "runs/verify";
};

/// Prints a table; returns 0 only if every metric of every case passes, else 6; 130 when interrupted.
int verify(const VerifyOptions& options, JsonOutput& json);

}  // namespace poretwin::cli
