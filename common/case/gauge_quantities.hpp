// The quantities that a point gauge can measure in each phase. The check of a case uses this list.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace poretwin {

/// Names of all quantities, one per component.
inline std::vector<std::string> point_quantities(std::string_view phase, int dimension) {
  std::vector<std::string> names;
  const auto vector = [&](const std::string& name) {
    for (int d = 0; d < dimension; ++d) names.push_back(name + "_" + "xyz"[d]);
  };
  const auto tensor = [&](const std::string& name) {
    for (const char* component : {"xx", "yy", "zz", "xy", "yz", "xz"}) names.push_back(name + "_" + component);
  };
  if (phase == "fluid") {
    names = {"pore_pressure", "pressure_head",  "head",    "degree_of_saturation",
             "water_content", "borne_pressure", "velocity"};
    vector("velocity");
    return names;
  }
  names = {"pore_pressure", "pore_pressure_ratio", "mobilised_friction", "void_fraction", "accumulated_plastic_strain"};
  vector("displacement");
  vector("velocity");
  tensor("effective_stress");
  tensor("total_stress");
  return names;
}

}  // namespace poretwin
