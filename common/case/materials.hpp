// What every program needs to know of a material to read a case: its name, whether it can yield, its own keys.
#pragma once

#include "common/case/keys.hpp"

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
    cohesion_and_friction,  ///< the cone that these keys of [[soil]] give
    own,                    ///< something else
  };
  std::string_view name;  ///< of soil.model and solid.model
  Strength strength = Strength::own;
  std::vector<MaterialKey> keys;
  [[nodiscard]] bool can_yield() const { return strength != Strength::none; }
  [[nodiscard]] bool has_cone() const { return strength == Strength::cohesion_and_friction; }
};

/// All materials, in the order of case-file.md. The rows stand with the models: solid_solver/material/registry.cpp.
std::vector<Material> materials();

/// The material of this name. Throws CaseError where there is none.
Material material(MaterialName name);

}  // namespace poretwin
