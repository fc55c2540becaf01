// A retention law: how much water soil keeps under suction, and how well it then conducts. A law is one file and one
// row in `retention_laws`; its parameters become keys of [soil.retention] by themselves.
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
  double slope = 0.0;  ///< per m of pressure head
};

/// The curves of one soil, at pressure heads psi [m] below zero. At zero and above the soil is full: both are one.
class RetentionCurve {
 public:
  RetentionCurve() = default;
  RetentionCurve(const RetentionCurve&) = delete;
  RetentionCurve& operator=(const RetentionCurve&) = delete;
  virtual ~RetentionCurve() = default;
  /// Effective saturation S_e = (theta - theta_r) / (theta_s - theta_r), in (0, 1]; rises with psi.
  [[nodiscard]] virtual Rate saturation(double psi) const = 0;
  /// Relative permeability k_r, in [0, 1]; does not fall with psi.
  [[nodiscard]] virtual Rate permeability(double psi) const = 0;
  /// The pressure head [m] at which S_e has a value, of those below that at `steepest`.
  [[nodiscard]] virtual double head(double saturation) const = 0;
  /// The pressure head [m], at most zero, at which S_e rises fastest.
  [[nodiscard]] virtual double steepest() const = 0;
};

/// What a law makes the curves of a soil from.
struct RetentionParameters {
  std::span<const double> numbers = {};  ///< in the law's order
  const Series* saturation = nullptr;    ///< S_e against psi, of laws that take tables
  const Series* permeability = nullptr;  ///< k_r against psi, likewise
};

struct RetentionLaw {
  std::string name;     ///< retention.model
  std::string meaning;  ///< for the reference of keys
  std::vector<LawParameter> parameters = {};
  bool takes_tables = false;
  /// None: no capillarity, the soil is full below a sharp front and empty above it.
  std::unique_ptr<RetentionCurve> (*curve)(const RetentionParameters& parameters) = nullptr;
};

/// All laws; the first is the default. References stay valid.
const std::deque<RetentionLaw>& retention_laws();
/// The law of a soil.
const RetentionLaw& retention_law(const Soil& soil);

}  // namespace poretwin::porous
