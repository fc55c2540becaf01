#include "common/coupling/exchange.hpp"

#include "common/core/error.hpp"

#include <algorithm>

namespace poretwin::coupling {

std::string_view to_string(Role role) { return role == Role::fluid ? "fluid" : "solid"; }

std::vector<FieldSpec> standard_fields(Role giver, int dimension) {
  using enum Mapping;
  auto spec = [](std::string_view name, std::string unit, int components, Mapping mapping = consistent,
                 std::string_view mask = {}) {
    return FieldSpec{std::string(name), std::move(unit), components, mapping, std::string(mask)};
  };
  if (giver == Role::fluid)
    return {
        spec(field::pore_pressure, "Pa", 1),
        spec(field::predicted_solid_velocity, "m/s", dimension, consistent, field::soil_fraction),
        spec(field::predicted_change, "m/s", dimension, consistent, field::soil_fraction),
        spec(field::drag_impulse, "N s", dimension, conservative),
        spec(field::soil_fraction, "1", 1),
        spec(field::surface_gradient, "Pa/m", dimension, consistent, field::surface_share),
        spec(field::surface_share, "1", 1),
    };
  return {
      spec(field::solid_velocity, "m/s", dimension),
      spec(field::mean_solid_velocity, "m/s", dimension),
      spec(field::volumetric_strain_rate, "1/s", 1),
      spec(field::unbalanced_force, "N/m3", dimension),
      spec(field::solid_volume_fraction, "1", 1),
      spec(field::grain_density, "kg/m3", 1),
      spec(field::constrained_modulus, "Pa", 1),
      spec(field::yielding, "1", 1),
      spec(field::hydraulic_conductivity, "m/s", 1),
      spec(field::forchheimer_coefficient, "s2/m2", 1),
      spec(field::returned_impulse, "N s", dimension, conservative),
  };
}

namespace {

const Field& named(const std::vector<Field>& fields, std::string_view name) {
  const auto field = std::find_if(fields.begin(), fields.end(), [&](const Field& f) { return f.name == name; });
  if (field == fields.end())
    throw PeerError("field '" + std::string(name) + "' was expected in the exchange and did not arrive");
  return *field;
}

}  // namespace

const Field& Inbox::at(std::string_view name) const { return named(fields, name); }
const Field& Inbox::found_at(std::string_view name) const { return named(found, name); }

std::vector<double> Inbox::between(std::string_view name, double share) const {
  std::vector<double> values = at(name).values;
  const auto start = std::find_if(at_start.begin(), at_start.end(), [&](const Field& f) { return f.name == name; });
  if (start == at_start.end()) return values;
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = (1.0 - share) * start->values[i] + share * values[i];
  return values;
}

}  // namespace poretwin::coupling
