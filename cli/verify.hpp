// `poretwin verify`: runs cases and compares them with their references.
#pragma once

#include "cli/json_output.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace poretwin::cli {

struct VerifyOptions {
  std::string which;             ///< a case, or "all"
  std::filesystem::path report;  ///< a folder for a page with pictures; empty: none
  std::string run;               ///< only this run of a case; empty: all
  std::vector<std::string> overrides;
  bool short_runs = false;
  std::filesystem::path programs, out = "runs/verify";
};

/// Prints a table; returns 0 only if every metric of every case passes, else 6; 130 when interrupted.
int verify(const VerifyOptions& options, JsonOutput& json);

}  // namespace poretwin::cli
