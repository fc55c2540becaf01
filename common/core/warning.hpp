// Warnings of a run. The user must see them immediately, because the result may be wrong.
#pragma once

#include <string>

namespace poretwin {

/// An event in a run, with the number of its occurrences. A phase returns all of its warnings after every window. The
/// coupling logs each warning at its first occurrence, and the summary shows the totals.
struct Warning {
  std::string what;              ///< name under which it is counted: "water particles lost"
  double count = 0.0;            ///< occurrences so far; 0: the event has not occurred
  std::string detail;            ///< where, why and what to do; logged at the first occurrence
  bool result_in_doubt = false;  ///< mass was lost or numbers may be wrong: the run ends with ExitCode::in_doubt
};

}  // namespace poretwin
