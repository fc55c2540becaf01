// A retention law: how much water soil retains under suction, and its relative permeability. Each law has one file and
// one row in `retention_laws`. Its parameters become keys of [soil.retention] automatically.
#pragma once

#include "common/case/case.hpp"
#include "common/media/seepage_law.hpp"

#include <deque>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace poretwin::porous {

/// A quantity that depends on the pressure head, and its derivative.
struct Rate {
  double value = 0.0;
  double slope = 0.0;  ///< derivative, per m of pressure head
};

/// The curves of one soil for pressure heads psi [m] below zero. For psi >= 0 the soil is saturated; both are 1.
class RetentionCurve {
 public:
  RetentionCurve() = default;
  RetentionCurve(const RetentionCurve&) = delete;
  RetentionCurve& operator=(const RetentionCurve&) = delete;
  virtual ~RetentionCurve() = default;
  /// Effective saturation S_e = (theta - theta_r) / (theta_s - theta_r), in (0, 1], with the water content theta and
  /// its residual and saturated values theta_r and theta_s. S_e rises with psi.
  [[nodiscard]] virtual Rate saturation(double psi) const = 0;
  /// Relative permeability k_r, in [0, 1]; never decreases with psi.
  [[nodiscard]] virtual Rate permeability(double psi) const = 0;
  /// The pressure head [m] at which S_e has this value. Only for values up to that of S_e at `steepest`.
  [[nodiscard]] virtual double head(double saturation) const = 0;
  /// The pressure head [m], at most zero, at which S_e rises fastest.
  [[nodiscard]] virtual double steepest() const = 0;
  /// Pressure heads [m] below zero between which k_r is smooth, where it has corners or rises over a short range.
  [[nodiscard]] virtual std::vector<double> corners() const { return {}; }
};

/// Parameters from which a law makes the curves of a soil.
struct RetentionParameters {
  std::span<const double> numbers = {};  ///< in the order of the law's parameters
  const Series* saturation = nullptr;    ///< S_e against psi [m]; for laws that take tables
  const Series* permeability = nullptr;  ///< k_r against psi [m]; for laws that take tables
};

struct RetentionLaw {
  std::string name;     ///< retention.model
  std::string meaning;  ///< for docs/case-file.md
  std::vector<LawParameter> parameters = {};
  bool takes_tables = false;
  /// nullptr: no capillarity; the soil is saturated below a sharp front and dry above it.
  std::unique_ptr<RetentionCurve> (*curve)(const RetentionParameters& parameters) = nullptr;
};

/// All laws; the first is the default. References to them remain valid.
const std::deque<RetentionLaw>& retention_laws();
/// The law of a soil.
const RetentionLaw& retention_law(const Soil& soil);

}  // namespace poretwin::porous
