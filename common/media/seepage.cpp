#include "common/media/seepage.hpp"

#include "common/core/error.hpp"
#include "common/media/constant_conductivity.hpp"
#include "common/media/forchheimer.hpp"
#include "common/media/kozeny_carman.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace poretwin::porous {
namespace {

std::deque<SeepageLaw>& all_laws() {
  static std::deque<SeepageLaw> laws{kozeny_carman(), constant_conductivity(), forchheimer(), ergun()};
  return laws;
}

const SeepageLaw& law_of(const Soil& soil) { return soil.seepage_law ? *soil.seepage_law : all_laws().front(); }

/// Values of all laws' parameters, in the order of the laws; those that the soil does not have yet at their defaults.
std::vector<double> completed(std::vector<double> values) {
  std::size_t i = 0;
  for (const auto& law : all_laws())
    for (const auto& p : law.parameters)
      if (i++ >= values.size()) values.push_back(p.value);
  return values;
}

std::size_t index_of(std::string_view key) {
  std::size_t i = 0;
  for (const auto& law : all_laws())
    for (const auto& p : law.parameters) {
      if (p.key == key) return i;
      ++i;
    }
  throw CaseError(fmt::format("no law of seepage has a parameter '{}'", key));
}

}  // namespace

const std::deque<SeepageLaw>& seepage_laws() { return all_laws(); }

const SeepageLaw& seepage_law(std::string_view name) {
  std::string there;
  for (const auto& law : all_laws()) {
    if (law.name == name) return law;
    there += (there.empty() ? "" : ", ") + law.name;
  }
  throw CaseError(fmt::format("no law of seepage is called '{}'; there are {}", name, there));
}

const SeepageLaw& add_seepage_law(SeepageLaw law) {
  for (const auto& other : all_laws()) {
    if (other.name == law.name) throw CaseError(fmt::format("a law of seepage is called '{}' already", law.name));
    for (const auto& theirs : other.parameters)
      for (const auto& own : law.parameters)
        if (theirs.key == own.key)
          throw CaseError(fmt::format("'{}' is a parameter of the law '{}' already", own.key, other.name));
  }
  return all_laws().emplace_back(std::move(law));
}

double& parameter(Soil& soil, std::string_view key) {
  soil.seepage_parameters = completed(std::move(soil.seepage_parameters));
  return soil.seepage_parameters[index_of(key)];
}
double parameter(const Soil& soil, std::string_view key) { return completed(soil.seepage_parameters)[index_of(key)]; }

double Resistance::speed(double force) const {
  const double root = std::sqrt(linear * linear + 4.0 * quadratic * force);
  return linear + root > 0.0 ? 2.0 * force / (linear + root) : 0.0;
}

double specific_weight(const Case& scene) {
  const double g = scene.general.gravity.norm();
  return scene.water.density * (g > 0.0 ? g : 9.81);
}

Seepage seepage_at(const Case& scene, const Soil& soil, double porosity) {
  const SeepageLaw& law = law_of(soil);
  Medium medium{porosity, soil.porosity, soil.hydraulic_conductivity, specific_weight(scene) / scene.water.density,
                scene.water.kinematic_viscosity};
  std::size_t first = 0;
  for (const auto& other : all_laws()) {
    if (&other == &law) break;
    first += other.parameters.size();
  }
  std::vector<double> values;  // only where a soil made by hand lacks them
  std::span<const double> parameters = soil.seepage_parameters;
  if (parameters.size() < first + law.parameters.size()) parameters = values = completed(soil.seepage_parameters);
  medium.parameters = parameters.subspan(first, law.parameters.size());
  return law.at(medium);
}

Resistance resistance(double specific_weight, double n, const Seepage& seepage) {
  return {specific_weight * n * n / seepage.conductivity, specific_weight * n * n * n * seepage.quadratic};
}

double conductivity_contrast(const Case& scene) {
  double slowest = HUGE_VAL, fastest = 0.0;
  for (const auto& soil : scene.soils) {
    const double k = seepage_at(scene, soil, soil.porosity).conductivity;
    slowest = std::min(slowest, k);
    fastest = std::max(fastest, k);
  }
  return scene.soils.empty() ? 1.0 : fastest / slowest;
}

}  // namespace poretwin::porous
