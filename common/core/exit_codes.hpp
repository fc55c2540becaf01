// The exit codes with their explanations: --help, man pages and docs/protocol.md show this table.
#pragma once

#include "common/core/error.hpp"

#include <array>
#include <string>

namespace poretwin {

struct ExitMeaning {
  ExitCode code;
  const char* meaning;
};

inline constexpr std::array<ExitMeaning, 8> exit_meanings{{
    {ExitCode::success, "done"},
    {ExitCode::failure, "unforeseen: a crash, out of memory"},
    {ExitCode::bad_case, "the case, the command line or the geometry is wrong"},
    {ExitCode::peer, "a peer is missing, dead, frozen, refused or sent nonsense"},
    {ExitCode::diverged, "diverged: some numbers are no longer finite, or windows are stuck"},
    {ExitCode::input_output, "a file is missing, unreadable or unwritable, or the disk is full"},
    {ExitCode::in_doubt, "ended, but the result is in doubt: mass was lost, a reference missed, .."},
    {ExitCode::interrupted, "interrupted by Ctrl-C or SIGTERM"},
}};

/// The text "Exit codes:" with one line for each code.
std::string exit_codes_text();

}  // namespace poretwin
