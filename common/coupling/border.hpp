// Checks of all received data before use. Numbers must be finite and within the bounds of their field (docs/protocol.md
// lists the bounds); points must not coincide; sizes must be as announced.
#pragma once

#include "common/coupling/message.hpp"

#include <memory>
#include <span>
#include <vector>

namespace poretwin::coupling {

/// A participant's publication as stored by the coupler. Points that have not changed are shared with the previous one.
struct Snapshot {
  double time = 0.0;                    ///< s
  double proposed_interval = no_limit;  ///< s, longest window that the participant accepts at present
  std::string limited_by;
  double unsettled = 0.0;
  std::shared_ptr<const PointSet> points;
  std::vector<Field> fields;
};

/// Index of the first value that is outside [low, high] or NaN; if there is none, the number of values.
std::size_t first_outside(std::span<const double> values, double low, double high);

/// Converts a PUBLICATION message into a snapshot. If the message contains no points, those of `previous` are used.
/// Throws PeerError that names sender, step, field, point and value.
Snapshot admit(Message message, const Contract& contract, const std::shared_ptr<const PointSet>& previous);

}  // namespace poretwin::coupling
