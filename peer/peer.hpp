// `poretwin peer`: stand-ins and examiners for either side of the coupling.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

namespace poretwin::peer {

/// `peer mock fluid|solid`: the case's still fields under a solver's own arguments.
int mock(const std::string& role, const std::vector<std::string>& arguments);

/// `peer record LOG COMMAND...`: runs a solver's command (with its --connect ADDRESS) and keeps its conversation.
int record(const std::filesystem::path& log, const std::vector<std::string>& command);

/// `peer replay LOG`: plays the recorded solver again, under a solver's own arguments. Ends with PeerError where the
/// coupler asks for another window than then; says where what comes in first differs.
int replay(const std::filesystem::path& log, const std::vector<std::string>& arguments);

/// `peer conformance CASE COMMAND...`: runs a solver's command against a coupler that tries its manners, one start per
/// check; writes the report. Exit code 0, or 3 when a check failed.
int conformance(const std::filesystem::path& case_file, const std::vector<std::string>& command, std::ostream& report);

}  // namespace poretwin::peer
