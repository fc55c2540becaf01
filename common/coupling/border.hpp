// Checks of all received data before use: numbers are finite and within the bounds of their field (docs/protocol.md
// lists them), points do not coincide, sizes are as announced.
#pragma once

#include "common/coupling/message.hpp"

#include <memory>
#include <span>
#include <vector>

namespace poretwin::coupling {

/// A participant's publication as the coupler keeps it. Points that have not changed are shared with the previous one.
struct Snapshot {
  double time = 0.0;                    ///< s
  double proposed_interval = no_limit;  ///< s, longest window that the participant accepts now
  std::string limited_by;
  double unsettled = 0.0;
  std::shared_ptr<const PointSet> points;
  std::vector<Field> fields;
};

/// Index of the first value outside [low, high] or NaN; the number of values where all are inside.
std::size_t first_outside(std::span<const double> values, double low, double high);

/// Turns a PUBLICATION message into a snapshot; `previous` supplies the points where the message leaves them out.
/// Throws PeerError naming sender, step, field, point and value.
Snapshot admit(Message message, const Contract& contract, const std::shared_ptr<const PointSet>& previous);

}  // namespace poretwin::coupling
