// Checks of everything that comes in, before anybody computes with it: numbers are finite and within the bounds of
// their field (docs/protocol.md lists them), points do not coincide, sizes are as announced.
#pragma once

#include "common/coupling/message.hpp"

#include <memory>
#include <span>
#include <vector>

namespace poretwin::coupling {

/// A participant's publication as the coupler keeps it; unchanged points are shared with the one before.
struct Snapshot {
  double time = 0.0;                    ///< s
  double proposed_interval = no_limit;  ///< s
  std::string limited_by;
  double unsettled = 0.0;
  std::shared_ptr<const PointSet> points;
  std::vector<Field> fields;
};

/// The first value that is not in [low, high], NaN included; their number when all are.
std::size_t first_outside(std::span<const double> values, double low, double high);

/// Turns a PUBLICATION into a snapshot. `previous` has the points where the message does not. Throws PeerError that
/// names sender, step, field, point and value.
Snapshot admit(Message message, const Contract& contract, const std::shared_ptr<const PointSet>& previous);

}  // namespace poretwin::coupling
