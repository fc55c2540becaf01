// The common part of the three processes' mains: arguments, errors as exit codes with one clear line, a summary however
// the process ends.
#pragma once

#include "common/coupling/arguments.hpp"
#include "common/coupling/summary.hpp"

#include <functional>
#include <string>

namespace poretwin::coupling {

struct ProcessBody {
  std::function<bool(const Arguments&)> run;  ///< returns true where it was interrupted and ended cleanly
  std::function<RunSummary()> summarise;      ///< of the work so far; called also after `run` has failed
};

/// Locks OUT for a process with this name in the run (its role), and writes OUT/<name>.summary.json on every exit on
/// which it has the lock. called: name of the program. Returns the exit code.
int process_main(int argc, char** argv, const std::string& called, const std::string& name, Program program,
                 const ProcessBody& body);

}  // namespace poretwin::coupling
