// A law of seepage: how the hydraulic gradient follows from the discharge in soil of a porosity. A law is one file and
// one row in `seepage_laws`; its parameters become keys of [[soil]] by themselves.
#pragma once

#include <deque>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace poretwin::porous {

/// i = U/k + b |U| U: hydraulic gradient i against the discharge velocity U = n (v_w - v_s).
struct Seepage {
  double conductivity = 0.0;  ///< k, m/s
  double quadratic = 0.0;     ///< b, s2/m2; 0: Darcy
};

/// A parameter of a law, a key of [[soil]]. Not negative.
struct LawParameter {
  std::string key, unit, meaning;
  double value = 0.0;   ///< unless the case says otherwise
  bool needed = false;  ///< must be given, and above `above`
  double above = 0.0;
};

/// What a law is asked with.
struct Medium {
  double porosity = 0.4;                    ///< n, where it is asked
  double own_porosity = 0.4;                ///< of the soil as the case has it
  double conductivity = 1e-4;               ///< [[soil]] hydraulic_conductivity, at `own_porosity`, m/s
  double gravity = 9.81;                    ///< m/s2
  double viscosity = 1e-6;                  ///< kinematic, of the water, m2/s
  std::span<const double> parameters = {};  ///< in the law's order
};

/// How many parameters a law may have.
inline constexpr std::size_t most_parameters = 8;

struct SeepageLaw {
  std::string name;     ///< [[soil]] seepage_law
  std::string meaning;  ///< for the reference of keys
  Seepage (*at)(const Medium& medium) = nullptr;
  std::vector<LawParameter> parameters = {};
  bool takes_conductivity = true;  ///< false: it has its own, hydraulic_conductivity must not be given
};

/// All laws; the first is the default. References stay valid.
const std::deque<SeepageLaw>& seepage_laws();
/// The law of that name; throws CaseError naming those there are.
const SeepageLaw& seepage_law(std::string_view name);
/// Adds a law, before a case is read. Throws CaseError where its name or a key is taken.
const SeepageLaw& add_seepage_law(SeepageLaw law);

}  // namespace poretwin::porous
