// What the mains of all three processes share: arguments, errors as exit codes with one clear line, the summary on
// every way out.
#pragma once

#include "common/coupling/arguments.hpp"
#include "common/coupling/summary.hpp"

#include <functional>
#include <string>

namespace poretwin::coupling {

struct ProcessBody {
  std::function<bool(const Arguments&)> run;  ///< true: it was interrupted and ended cleanly
  std::function<RunSummary()> summarise;      ///< of what has been done so far; also called after a failure of `run`
};

/// Locks OUT for a process of this name in the run (its role), and writes OUT/<name>.summary.json on every exit that has
/// the lock. called: the program's own name. Returns the exit code.
int process_main(int argc, char** argv, const std::string& called, const std::string& name, Program program,
                 const ProcessBody& body);

}  // namespace poretwin::coupling
