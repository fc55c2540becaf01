// `poretwin safety`: factor of safety by strength reduction.
#pragma once

#include "cli/run.hpp"

namespace poretwin::cli {

/// One trial: a run of its own with the soil's strength divided by `factor`.
struct SafetyTrial {
  double factor = 1.0;
  bool stands = false;
  double steps = 0.0, residual = 0.0;  ///< of the search for rest; largest acceleration over the driving one
  double displacement = 0.0;           ///< m, largest
};

struct Safety {
  std::vector<SafetyTrial> trials;   ///< in order of factor
  double stands = 0.0, fails = 0.0;  ///< the bracket
  RunResult run;                     ///< wall and CPU time of all trials, the rest of the last one
  std::filesystem::path failing;     ///< folder of the trial that fails nearest to the factor
  [[nodiscard]] double factor() const { return 0.5 * (stands + fails); }
};

/// Brackets and bisects the factor F by which cohesion and tan(friction) of all soils can be divided before the soil
/// finds no equilibrium under gravity, loads without `start` and the pressure and seepage force of the water at time
/// zero, which stay as they are (Griffiths & Lane 1999). No equilibrium means that the search for rest ends without
/// meeting its criterion. tolerance: width of the bracket over F. Every trial is a run of its own in OUT/F_<factor>;
/// OUT/safety.csv lists them, OUT/gauges.csv has the factor as factor_of_safety, and a picture of the plastic strain of
/// the failing trial nearest to F shows the failure surface. Throws CaseError where there is nothing to reduce.
Safety find_safety(const RunOptions& options, double tolerance);

/// Table of the trials and the factor.
std::string safety_text(const Safety& safety);
nlohmann::ordered_json safety_json(const RunOptions& options, double tolerance, const Safety& safety);

}  // namespace poretwin::cli
