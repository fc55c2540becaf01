// A seepage law: the hydraulic gradient as a function of the discharge velocity, in soil of a given porosity. Each law
// has one file and one row in `seepage_laws`. Its parameters become keys of [[soil]] automatically.
#pragma once

#include <deque>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace poretwin::porous {

/// i = U/k + b |U| U: hydraulic gradient i against the discharge velocity U = n (v_w - v_s).
struct Seepage {
  double conductivity = 0.0;  ///< k, m/s
  double quadratic = 0.0;     ///< b, s2/m2; 0: Darcy flow
};

/// A parameter of a law: a key of [[soil]] with a non-negative value.
struct LawParameter {
  std::string key, unit, meaning;
  double value = 0.0;   ///< default
  bool needed = false;  ///< the case must give it, greater than `above`
  double above = 0.0;

  /// Its value among the numbers of a case, by key; its default where they do not contain it.
  [[nodiscard]] double in(const std::map<std::string, double, std::less<>>& numbers) const {
    const auto given = numbers.find(key);
    return given == numbers.end() ? value : given->second;
  }
};

/// The properties for which a law is evaluated.
struct Medium {
  double porosity = 0.4;                    ///< n, the porosity for which k and b are computed
  double own_porosity = 0.4;                ///< porosity of the soil as the case gives it
  double conductivity = 1e-4;               ///< [[soil]] hydraulic_conductivity, at `own_porosity`, m/s
  double gravity = 9.81;                    ///< m/s2
  double viscosity = 1e-6;                  ///< kinematic viscosity of the water, m2/s
  std::span<const double> parameters = {};  ///< in the order of the law's parameters
};

/// Largest number of parameters of a law.
inline constexpr std::size_t most_parameters = 8;

struct SeepageLaw {
  std::string name;     ///< [[soil]] seepage_law
  std::string meaning;  ///< for docs/case-file.md
  Seepage (*at)(const Medium& medium) = nullptr;
  std::vector<LawParameter> parameters = {};
  bool takes_conductivity = true;  ///< false: the law computes k; hydraulic_conductivity must not be given
};

/// All laws; the first is the default. References to them remain valid.
const std::deque<SeepageLaw>& seepage_laws();
/// The law of that name. Throws CaseError with the names of all laws if there is no such law.
const SeepageLaw& seepage_law(std::string_view name);
/// Adds a law. To be called before a case is read. Throws CaseError if its name or a key is already in use.
const SeepageLaw& add_seepage_law(SeepageLaw law);

}  // namespace poretwin::porous
