#include "common/media/retention.hpp"

#include "common/media/brooks_corey.hpp"
#include "common/media/gardner.hpp"
#include "common/media/retention_table.hpp"
#include "common/media/sharp.hpp"
#include "common/media/van_genuchten.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

namespace poretwin::porous {
namespace {

/// Heads at which Phi, the integral of k_r over the head, is tabulated: 0, from -`nearest` to -`farthest`, evenly
/// spaced in the logarithm, and the corners of the curve. Cubics between them have a relative error of 1e-9; below the
/// last head k_r is constant.
constexpr double nearest = 1e-5, farthest = 1e5;  // m
constexpr int per_decade = 150;
const double rows_per_e = per_decade / std::log(10.0);  // rows for a factor e of the head
const int rows = static_cast<int>(std::lround(per_decade * std::log10(farthest / nearest))) + 2;

double head_of_row(int row) { return row == 0 ? 0.0 : -nearest * std::exp((row - 1) / rows_per_e); }

}  // namespace

const std::deque<RetentionLaw>& retention_laws() {
  static const std::deque<RetentionLaw> laws{sharp(), van_genuchten(), gardner(), brooks_corey(), retention_table()};
  return laws;
}

const RetentionLaw& retention_law(const Soil& soil) {
  return soil.retention && soil.retention->law ? *soil.retention->law : retention_laws().front();
}

Retention::Retention(std::unique_ptr<RetentionCurve> curve)
    : curve_(std::move(curve)), joint_head_(curve_->steepest()) {
  // Where the curve has a corner at the joint, the slope below the joint is taken.
  joint_ = curve_->saturation(std::min(joint_head_ * (1.0 + 1e-12), -1e-12));
  joint_.value = saturation(joint_head_).value;
  std::vector<double> corners = curve_->corners();
  std::ranges::sort(corners, std::greater<>());
  auto corner = corners.begin();
  for (int row = 0; row < rows; ++row) {
    for (; corner != corners.end() && *corner >= head_of_row(row); ++corner)
      if (!heads_.empty() && *corner < heads_.back() && *corner > head_of_row(row)) heads_.push_back(*corner);
    place_.push_back(heads_.size());
    heads_.push_back(head_of_row(row));
  }
  potential_.push_back(0.0);
  permeability_.push_back(1.0);
  for (std::size_t i = 1; i < heads_.size(); ++i) {
    // Integrates with three Gauss points.
    const double a = heads_[i], b = heads_[i - 1], middle = 0.5 * (a + b), half = 0.5 * (b - a);
    double sum = 8.0 / 9.0 * permeability(middle).value;
    for (const double side : {-1.0, 1.0}) sum += 5.0 / 9.0 * permeability(middle + side * std::sqrt(0.6) * half).value;
    potential_.push_back(potential_.back() - half * sum);
    permeability_.push_back(permeability(a).value);
  }
}

double Retention::potential(double psi) const {
  if (psi >= 0.0) return psi;
  if (psi <= heads_.back()) return potential_.back() + permeability_.back() * (psi - heads_.back());
  const int row = psi > -nearest ? 1 : std::min(rows - 1, 2 + static_cast<int>(std::log(-psi / nearest) * rows_per_e));
  std::size_t i = place_[static_cast<std::size_t>(row)];
  while (i > 1 && psi > heads_[i - 1]) --i;  // corners between the rows
  const double x0 = heads_[i], x1 = heads_[i - 1], h = x1 - x0;
  const double s = (psi - x0) / h, t = 1.0 - s;
  return t * t * (1.0 + 2.0 * s) * potential_[i] + s * s * (1.0 + 2.0 * t) * potential_[i - 1] +
         h * s * t * (t * permeability_[i] - s * permeability_[i - 1]);
}

double Retention::variable(double psi) const {
  return psi < joint_head_ ? curve_->saturation(psi).value : joint_.value + joint_.slope * (psi - joint_head_);
}

Rate Retention::head(double u) const {
  if (u >= joint_.value) return {joint_head_ + (u - joint_.value) / joint_.slope, 1.0 / joint_.slope};
  const double psi = curve_->head(u);
  return {psi, 1.0 / curve_->saturation(psi).slope};
}

std::unique_ptr<Retention> retention_of(const Soil& soil) {
  const RetentionLaw& law = retention_law(soil);
  if (law.curve == nullptr) return nullptr;
  std::vector<double> numbers;
  for (const auto& p : law.parameters) numbers.push_back(p.in(soil.retention->numbers));
  RetentionParameters parameters{numbers};
  if (soil.retention->saturation) parameters.saturation = &*soil.retention->saturation;
  if (soil.retention->permeability) parameters.permeability = &*soil.retention->permeability;
  return std::make_unique<Retention>(law.curve(parameters));
}

double residual_saturation(const Soil& soil) {
  return soil.retention ? soil.retention->residual_water_content / soil.porosity : 0.0;
}

}  // namespace poretwin::porous
