// `poretwin element`: computes a laboratory test on one soil of a case, without particles.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace poretwin::cli {

struct ElementOptions {
  std::filesystem::path case_file, out;
  std::string case_name, soil, test;
  std::vector<std::string> overrides;
  double pressure = 0.0, ratio = 1.0;  ///< Pa, vertical effective stress at the start; horizontal over vertical stress
  std::vector<double> strains, loads;  ///< turning points of the strain or of the stress [Pa]; one list is empty
  int steps = 1000;                    ///< number of steps between two turning points
  std::optional<double> rate;          ///< 1/s, of the prescribed strain; absent: very slow
  bool pictures = true;
};

struct ElementResult {
  std::vector<std::string> names;         ///< of the columns, with units
  std::vector<std::vector<double>> rows;  ///< one row per step; the first is the state at the start
  std::string failure;                    ///< why the path ended before its last turning point; empty: it is complete
};

/// Computes the path and writes OUT/element.csv and OUT/element.png. Throws CaseError where the case has no such soil
/// or there is no such test.
ElementResult run_element(const ElementOptions& options);

/// Text with the strains and stresses at the end.
std::string element_text(const ElementOptions& options, const ElementResult& result);
nlohmann::ordered_json element_json(const ElementOptions& options, const ElementResult& result);

}  // namespace poretwin::cli
