#include "common/coupling/exchange.hpp"

#include "common/core/error.hpp"

#include <algorithm>

namespace poretwin::coupling {

std::string_view to_string(Mapping mapping) {
  switch (mapping) {
    case Mapping::consistent:
      return "consistent";
    case Mapping::nearest:
      return "nearest";
    case Mapping::conservative:
      break;
  }
  return "conservative";
}

std::string_view to_string(Role role) { return role == Role::fluid ? "fluid" : "solid"; }

std::vector<FieldSpec> free_water_fields(int dimension) {
  const std::string share(field::free_share);
  return {{std::string(field::free_velocity), "m/s", dimension, Mapping::consistent, share},
          {share, "1", 1, Mapping::consistent, {}}};
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
