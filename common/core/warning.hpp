// Warnings of a run, which the user is to see at once, because its result may not be what it seems.
#pragma once

#include <string>

namespace poretwin {

/// Something that happened in a run, counted. A phase returns all of its own after every window; what is new is logged
/// once, the totals are in the summary.
struct Warning {
  std::string what;              ///< counted under this name: "water particles lost"
  double count = 0.0;            ///< so far; at zero nothing has happened
  std::string detail;            ///< where, why and what to do; logged with the first
  bool result_in_doubt = false;  ///< mass was lost or numbers may be wrong: the run ends with ExitCode::in_doubt
};

}  // namespace poretwin
