// `poretwin peer`: stand-ins for a solver, recordings, and checks of solvers.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

namespace poretwin::peer {

/// `peer mock fluid|solid`: gives the case's fields at rest; takes the arguments of a solver.
int mock(const std::string& role, const std::vector<std::string>& arguments);

/// `peer record LOG COMMAND...`: runs a solver's command (with its --connect ADDRESS) and records all its messages.
int record(const std::filesystem::path& log, const std::vector<std::string>& command);

/// `peer replay LOG`: stands in for the recorded solver: sends its messages again, and takes the arguments of a solver.
/// Ends with PeerError where the coupler requests another window than in the recording. Reports the first difference in
/// the fields received.
int replay(const std::filesystem::path& log, const std::vector<std::string>& arguments);

/// `peer conformance CASE COMMAND...`: runs a solver's command, once per check, against a coupler that tests its
/// conduct. Writes a report. Returns exit code 0, or 3 if a check failed.
int conformance(const std::filesystem::path& case_file, const std::vector<std::string>& command, std::ostream& report);

}  // namespace poretwin::peer
