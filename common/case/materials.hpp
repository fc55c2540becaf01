// The properties of a material that every program needs to read a case: its name, whether it can yield, its own keys.
#pragma once

#include "common/case/case.hpp"
#include "common/case/keys.hpp"

#include <algorithm>
#include <functional>
#include <optional>
#include <string_view>
#include <vector>

namespace poretwin {

/// A parameter in [[soil]] that belongs to one material. The model gets its value from Soil::own().
struct MaterialKey {
  std::string_view name;
  double standard = 0.0;  ///< value if the case gives none
  About about;
  Range range;
  bool strength = false;  ///< solid.strength_reduction divides the parameter
};

struct Material {
  /// What limits the stress.
  enum class Strength {
    none,                   ///< nothing: the soil cannot yield
    cohesion_and_friction,  ///< Coulomb's criterion, or a cone fitted to it, by the keys of [[soil]]
    own,                    ///< a limit that the model defines itself
  };
  std::string_view name;  ///< as in soil.model and solid.model
  Strength strength = Strength::own;
  std::vector<MaterialKey> keys;
  /// Calls complain(key, what) for parameters that contradict each other, which the ranges of single keys cannot
  /// express.
  using Complain = std::function<void(std::string_view key, const std::string& what)>;
  void (*judge)(const Soil& soil, const Complain& complain) = nullptr;
  /// The model has no stress-free state: it needs `earth_pressure_at_rest` and an initial search for equilibrium.
  bool begins_under_stress = false;
  /// For a limit of the model's own: the friction coefficient of the soil's grains where they have no cohesion and
  /// shear at constant volume; nothing where they do not.
  std::optional<double> (*grains)(const Soil& soil) = nullptr;
  /// Whether the model has a key of its own of this name.
  [[nodiscard]] bool has_key(std::string_view key) const {
    return std::ranges::find(keys, key, &MaterialKey::name) != keys.end();
  }
  [[nodiscard]] bool can_yield() const { return strength != Strength::none; }
  [[nodiscard]] bool has_cone() const { return strength == Strength::cohesion_and_friction; }
  /// Whether the material has a strength that solid.strength_reduction can divide.
  [[nodiscard]] bool has_strength() const {
    return has_cone() || std::ranges::any_of(keys, [](const MaterialKey& key) { return key.strength; });
  }
};

/// All materials, in the order of docs/case-file.md. Their table is in solid_solver/material/registry.cpp, with the
/// models.
std::vector<Material> materials();

/// Width of a shear band of particles. The gradient at each of two rows shows a jump of the velocity between them as a
/// strain over two rows.
/// Unit: spacings. Test: case softening_band.
inline constexpr double band_width = 2.0;

/// The reason why a case has no factor of safety: the key concerned, and what it should be. Empty if some soil can
/// yield and all such soil has a strength that a factor can divide.
std::optional<std::pair<std::string, std::string>> lacks_strength(const Case& scene);

/// Constrained modulus K + 4 G / 3 [Pa] of unstrained soil under an isotropic effective pressure [Pa].
double constrained_modulus(MaterialName material, const Soil& soil, double pressure);
/// Constrained modulus [Pa] under half the weight of all soil. The weight matters if the stiffness depends on pressure.
double constrained_modulus(const Case& scene, const Soil& soil);

/// The material of this name. Throws CaseError if no material has the name.
Material material(MaterialName name);

}  // namespace poretwin
