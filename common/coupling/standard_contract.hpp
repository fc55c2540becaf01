// The standard contract as one table: a new field of the exchange is one row here and its name in `field::`. From it
// come what each role gives, the bounds at the border, the values of stand-ins, the tables of docs/protocol.md and the
// list of the Python client.
#pragma once

#include "common/coupling/exchange.hpp"

#include <span>

namespace poretwin::coupling {

/// Numbers that are accepted. Outside are values that no soil and no water can have; a run that is about to diverge
/// stays inside for a while, so that its own solver can report that.
struct Bounds {
  double low = 0.0, high = 0.0;
  /// "a number in [0, 1) m/s"; unit: SI, "1" for none.
  [[nodiscard]] std::string text(std::string_view unit) const;
};

/// One field that every solver of a role gives.
struct StandardField {
  Role giver = Role::fluid;
  std::string_view name, unit;  ///< SI
  bool vector = false;          ///< as many components as the case has dimensions
  Mapping mapping = Mapping::consistent;
  std::string_view mask = {};
  Bounds bounds;
  bool of_volume = false;                      ///< bounds are of each m^D of the point
  double at_rest = 0.0;                        ///< what a stand-in for soil or water at rest gives
  bool of_particles = true, of_field = false;  ///< of a fluid: which kinds of water give it
  std::string_view meaning;
};

std::span<const StandardField> standard_contract();

/// The row of that name; none for fields beyond the standard contract.
const StandardField* standard_field(std::string_view name);

/// The tables of docs/protocol.md: the fields of both roles, and their bounds (Markdown).
std::string describe_contract();
/// The list of the Python client, as the source of its module.
std::string python_contract();

}  // namespace poretwin::coupling
