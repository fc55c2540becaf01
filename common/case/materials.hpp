// What every program needs to know of a material to read a case: its name, whether it can yield, its own keys.
#pragma once

#include "common/case/case.hpp"
#include "common/case/keys.hpp"

#include <algorithm>
#include <functional>
#include <string_view>
#include <vector>

namespace poretwin {

/// A number in [[soil]] that belongs to one material; models read it with Soil::own().
struct MaterialKey {
  std::string_view name;
  double standard = 0.0;  ///< where the case gives none
  About about;
  Range range;
  bool strength = false;  ///< divided by solid.strength_reduction
};

struct Material {
  /// What limits the stress.
  enum class Strength {
    none,                   ///< nothing: the stress follows from the strain, whatever its path
    cohesion_and_friction,  ///< these keys of [[soil]], as Coulomb's, or a cone fitted to it
    own,                    ///< something else
  };
  std::string_view name;  ///< of soil.model and solid.model
  Strength strength = Strength::own;
  std::vector<MaterialKey> keys;
  /// Calls complain(key, what) where numbers of a soil do not go together, which the ranges of its keys cannot say.
  using Complain = std::function<void(std::string_view key, const std::string& what)>;
  void (*judge)(const Soil& soil, const Complain& complain) = nullptr;
  /// The soil has no state without stress: it needs `earth_pressure_at_rest` and a search for rest.
  bool begins_under_stress = false;
  [[nodiscard]] bool can_yield() const { return strength != Strength::none; }
  [[nodiscard]] bool has_cone() const { return strength == Strength::cohesion_and_friction; }
  /// Whether there is something that solid.strength_reduction divides.
  [[nodiscard]] bool has_strength() const {
    return has_cone() || std::ranges::any_of(keys, [](const MaterialKey& key) { return key.strength; });
  }
};

/// All materials, in the order of case-file.md. The rows stand with the models: solid_solver/material/registry.cpp.
std::vector<Material> materials();

/// Why a case has no factor of safety: the key concerned, and what is expected of it; nothing where its soil can fail,
/// and all that can has a strength to divide.
std::optional<std::pair<std::string, std::string>> lacks_strength(const Case& scene);

/// Constrained modulus K + 4 G / 3 [Pa] of soil that nothing has strained, under a pressure [Pa] from all sides.
double constrained_modulus(MaterialName material, const Soil& soil, double pressure);
/// The same under half the weight of all soil, where the stiffness follows the pressure.
double constrained_modulus(const Case& scene, const Soil& soil);

/// The material of this name. Throws CaseError where there is none.
Material material(MaterialName name);

}  // namespace poretwin
