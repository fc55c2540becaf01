// `poretwin safety`: factor of safety by strength reduction.
#pragma once

#include "cli/run.hpp"

namespace poretwin::cli {

/// One trial: a separate run with the soil's strength divided by `factor`.
struct SafetyTrial {
  double factor = 1.0;
  bool stands = false;
  double steps = 0.0, residual = 0.0;  ///< of the search for equilibrium; residual: largest acceleration, scaled
  double displacement = 0.0;           ///< m, largest
};

struct Safety {
  std::vector<SafetyTrial> trials;   ///< ordered by factor
  double stands = 0.0, fails = 0.0;  ///< largest factor at which the soil stands, smallest at which it fails
  RunResult run;                     ///< wall and CPU time of all trials; the rest describes the last trial
  std::filesystem::path failing;     ///< folder of the failing trial with the smallest factor
  [[nodiscard]] double factor() const { return 0.5 * (stands + fails); }
};

/// Finds by bracketing and bisection the factor F by which cohesion and tan(friction) of all soils can be divided
/// before the soil has no equilibrium under gravity, the loads without `start`, and the pressure and seepage force of
/// the water at time zero, which are not changed (Griffiths & Lane 1999). No equilibrium means that the search for it
/// ends without meeting its criterion. tolerance: width of the bracket over F. Every trial is a separate run in
/// OUT/F_<factor>. OUT/safety.csv lists them, OUT/gauges.csv contains F as factor_of_safety, and a picture of the
/// plastic strain in the failing trial nearest to F shows the failure surface. Throws CaseError where no soil has a
/// strength to reduce.
Safety find_safety(const RunOptions& options, double tolerance);

/// Text with a table of the trials, and the factor.
std::string safety_text(const Safety& safety);
nlohmann::ordered_json safety_json(const RunOptions& options, double tolerance, const Safety& safety);

}  // namespace poretwin::cli
