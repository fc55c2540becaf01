// The common part of the three processes' main functions: arguments, errors as exit codes with one clear line, and a
// summary at every end of the process.
#pragma once

#include "common/coupling/arguments.hpp"
#include "common/coupling/summary.hpp"

#include <functional>
#include <string>

namespace poretwin::coupling {

struct ProcessBody {
  std::function<bool(const Arguments&)> run;  ///< returns true if it was interrupted and ended cleanly
  std::function<RunSummary()> summarise;      ///< summary of the work so far; also called after `run` has failed
};

/// Locks OUT for a process with this name in the run (its role). Writes OUT/<name>.summary.json at every exit at which
/// it has the lock. called: name of the program. Returns the exit code.
int process_main(int argc, char** argv, const std::string& called, const std::string& name, Program program,
                 const ProcessBody& body);

}  // namespace poretwin::coupling
