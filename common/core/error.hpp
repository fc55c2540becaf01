// The errors that a user can get, each with its exit code. what() contains what was expected, what was found and what
// to do.
#pragma once

#include <stdexcept>
#include <string>

namespace poretwin {

/// Exit codes of every executable; documented in docs/protocol.md and `poretwin --help`.
enum class ExitCode : int {
  success = 0,
  failure = 1,        ///< an unforeseen failure
  bad_case = 2,       ///< the case file, the command line or the geometry
  peer = 3,           ///< a peer is missing, dead, frozen, of the wrong kind, or sent invalid messages
  diverged = 4,       ///< a field is no longer finite
  input_output = 5,   ///< files: missing, unreadable, unwritable, disk full
  in_doubt = 6,       ///< the run ended, but its result is in doubt: mass was lost, a bound was violated, ...
  interrupted = 130,  ///< Ctrl-C or SIGTERM
};

class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  [[nodiscard]] ExitCode code() const noexcept { return code_; }

 private:
  ExitCode code_;
};

/// Wrong input. The message names file, line, key, what was expected, and what was found.
class CaseError : public Error {
 public:
  explicit CaseError(const std::string& message) : Error(ExitCode::bad_case, message) {}
};

/// A peer failed. The message names peer, step, and last message.
class PeerError : public Error {
 public:
  explicit PeerError(const std::string& message) : Error(ExitCode::peer, message) {}
};

/// A simulation diverged. The message names particle, term, and last good state.
class DivergedError : public Error {
 public:
  explicit DivergedError(const std::string& message) : Error(ExitCode::diverged, message) {}
};

/// A file could not be read or written. The message names path and cause.
class FileError : public Error {
 public:
  explicit FileError(const std::string& message) : Error(ExitCode::input_output, message) {}
};

}  // namespace poretwin
