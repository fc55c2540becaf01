// The standard contract as one table: a new field of the exchange needs one row here and its name in `field::`. The
// table defines the fields that each role gives, the bounds of received values, the values of stand-ins, the tables of
// docs/protocol.md and the list of the Python client.
#pragma once

#include "common/coupling/exchange.hpp"

#include <span>

namespace poretwin::coupling {

/// Range of accepted values; soil and water have none outside it. A solver that begins to diverge still sends values
/// inside it for a while, and so can report the divergence itself before its values are refused.
struct Bounds {
  double low = 0.0, high = 0.0;
  /// "a number in [0, 1) m/s"; unit in SI, "1" if there is no unit.
  [[nodiscard]] std::string text(std::string_view unit) const;
};

/// One field of the standard contract. Every solver of the role `giver` gives it.
struct StandardField {
  Role giver = Role::fluid;
  std::string_view name, unit;  ///< SI
  bool vector = false;          ///< one component per dimension of the case
  Mapping mapping = Mapping::consistent;
  std::string_view mask = {};
  Bounds bounds;
  bool of_volume = false;                      ///< bounds are per m^D of the point's volume
  double at_rest = 0.0;                        ///< value from a stand-in for soil or water at rest
  bool of_particles = true, of_field = false;  ///< the representations of water that give it (fluid only)
  std::string_view meaning;
};

std::span<const StandardField> standard_contract();

/// The row of that name; nullptr if the standard contract does not contain the field.
const StandardField* standard_field(std::string_view name);

/// The tables of docs/protocol.md: the fields of both roles, and their bounds (Markdown).
std::string describe_contract();
/// The list of the Python client, as the source text of its module.
std::string python_contract();

}  // namespace poretwin::coupling
