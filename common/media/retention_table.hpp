// Measured retention curves: tables of saturation and relative permeability against pressure head.
#pragma once

#include "common/media/retention_law.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace poretwin::porous {

/// A monotonically rising table, interpolated by monotone cubics (Fritsch & Carlson 1980). Below its first row it
/// continues as a power of the suction, above its last row it is constant. It meets the constant without a corner, at
/// which Newton's method would find no solution.
class RisingTable {
 public:
  explicit RisingTable(const Series& rows) : rows_(rows.knots), slope_(rows.knots.size(), 0.0) {
    const std::size_t n = rows_.size();
    std::vector<double> chord;
    for (std::size_t i = 0; i + 1 < n; ++i)
      chord.push_back((rows_[i + 1].second - rows_[i].second) / (rows_[i + 1].first - rows_[i].first));
    // Harmonic means of the neighbouring slopes (Fritsch & Butland 1984) keep every piece monotone.
    power_ = std::log(rows_[1].second / rows_[0].second) / std::log(rows_[0].first / rows_[1].first);
    slope_.front() = std::min(-power_ * rows_[0].second / rows_[0].first, 3.0 * chord.front());
    slope_.back() = 0.0;
    for (std::size_t i = 1; i + 1 < n; ++i) slope_[i] = 2.0 / (1.0 / chord[i - 1] + 1.0 / chord[i]);
  }
  [[nodiscard]] Rate at(double psi) const {
    if (psi <= rows_.front().first) {
      const double value = rows_.front().second * std::pow(psi / rows_.front().first, -power_);
      return {value, -power_ * value / psi};
    }
    if (psi >= rows_.back().first) return {rows_.back().second, 0.0};
    const auto after = std::upper_bound(rows_.begin(), rows_.end(), psi,
                                        [](double head, const auto& row) { return head < row.first; });
    const auto i = static_cast<std::size_t>(after - rows_.begin()) - 1;
    const auto& [x0, y0] = rows_[i];
    const auto& [x1, y1] = rows_[i + 1];
    const double h = x1 - x0, s = (psi - x0) / h, t = 1.0 - s, a = h * slope_[i], b = h * slope_[i + 1];
    return {t * t * (1.0 + 2.0 * s) * y0 + s * s * (1.0 + 2.0 * t) * y1 + s * t * (t * a - s * b),
            (6.0 * s * t * (y1 - y0) + t * (t - 2.0 * s) * a + s * (s - 2.0 * t) * b) / h};
  }
  /// The head at which the table has this value.
  [[nodiscard]] double inverse(double value) const {
    if (value <= rows_.front().second)
      return rows_.front().first * std::pow(value / rows_.front().second, -1.0 / power_);
    double lower = rows_.front().first, upper = rows_.back().first;
    while (upper - lower > 1e-15 * -rows_.front().first) {
      const double middle = 0.5 * (lower + upper);
      if (middle <= lower || middle >= upper) break;
      (at(middle).value < value ? lower : upper) = middle;
    }
    return 0.5 * (lower + upper);
  }
  [[nodiscard]] const std::vector<std::pair<double, double>>& rows() const { return rows_; }

 private:
  std::vector<std::pair<double, double>> rows_;
  std::vector<double> slope_;  ///< at each row
  double power_ = 0.0;
};

class RetentionTable final : public RetentionCurve {
 public:
  RetentionTable(const Series& saturation, const Series& permeability)
      : saturation_(saturation), permeability_(permeability) {
    // A cubic is steepest at an end or inside. Its slope is compared at both ends and at twenty points between them.
    constexpr int places = 20;
    double most = 0.0;
    const auto& rows = saturation_.rows();
    for (std::size_t i = 0; i + 1 < rows.size(); ++i)
      for (int k = 0; k <= places; ++k) {
        const double psi = rows[i].first + (rows[i + 1].first - rows[i].first) * k / places;
        // At a row itself, the slope is that of the piece before the row.
        const double slope = saturation_.at(psi * (1.0 + 1e-12)).slope;
        if (slope <= most) continue;
        most = slope;
        steepest_ = psi;
      }
  }
  [[nodiscard]] Rate saturation(double psi) const override { return saturation_.at(psi); }
  [[nodiscard]] Rate permeability(double psi) const override { return permeability_.at(psi); }
  [[nodiscard]] double head(double saturation) const override { return saturation_.inverse(saturation); }
  [[nodiscard]] double steepest() const override { return steepest_; }
  [[nodiscard]] std::vector<double> corners() const override {
    constexpr int parts = 8;  // of each piece, whose permeability may rise by orders of magnitude
    std::vector<double> heads{permeability_.rows().front().first};
    for (std::size_t i = 0; i + 1 < permeability_.rows().size(); ++i) {
      const double from = permeability_.rows()[i].first, to = permeability_.rows()[i + 1].first;
      for (int k = 1; k <= parts; ++k) heads.push_back(k < parts ? from + (to - from) * k / parts : to);
    }
    return heads;
  }

 private:
  RisingTable saturation_, permeability_;
  double steepest_ = 0.0;
};

inline RetentionLaw retention_table() {
  return {"table",
          "`saturation` and `permeability`",
          {},
          true,
          [](const RetentionParameters& p) -> std::unique_ptr<RetentionCurve> {
            return std::make_unique<RetentionTable>(*p.saturation, *p.permeability);
          }};
}

}  // namespace poretwin::porous
