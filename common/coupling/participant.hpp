// The client through which a phase takes part in a coupled run: handshake, commands with deadlines, publications,
// heartbeats.
#pragma once

#include "common/coupling/transport.hpp"

#include <functional>
#include <memory>

namespace poretwin::coupling {

struct ParticipantOptions {
  Milliseconds welcome_deadline{60'000};        ///< for the coupler's answer to HELLO
  Milliseconds coupler_deadline{60'000};        ///< time without a message after which the coupler counts as frozen
  Milliseconds say_every{5'000};                ///< interval of log lines while waiting
  std::function<void(const std::string&)> say;  ///< writes one line to the log; absent: no log
  std::function<bool()> interrupted;            ///< whether a user requested a stop; heartbeats tell the coupler
  std::string software = "poretwin";
  bool keeps_checkpoints = false;
  std::vector<std::string> checkpoints;  ///< names of checkpoints from which the participant could resume
};

/// The coupler's next request.
struct Command {
  enum class Kind { initialise, resume, advance, restore, checkpoint, finish };
  Kind kind = Kind::finish;
  Window window;
  Inbox inbox;
  /// Whether to record the state at the window's end (for initialise, at time zero). It is recorded once the window is
  /// known to be final.
  bool record_frame = false;
  bool record_gauges = false;
  std::string reason;
  std::string checkpoint;         ///< name of the checkpoint to write, or from which to resume
  std::vector<std::string> keep;  ///< names of earlier checkpoints to keep
};

struct ParticipantTotals {
  std::uint64_t messages_sent = 0, messages_received = 0;  ///< without heartbeats
  std::uint64_t bytes_sent = 0, bytes_received = 0;        ///< headers and frames
  double sending = 0.0, waiting = 0.0;                     ///< s
};

/// Requests the case from the coupler, before HELLO is sent on this line. Throws the same errors as Participant::join.
CaseFile request_case(Transport& transport, Role role, const ParticipantOptions& options);

class Participant {
 public:
  Participant(std::unique_ptr<Transport> transport, Role role, Contract contract, ParticipantOptions options = {});
  /// If neither bye() nor abort() was called, closes the connection silently: the coupler then reports a death.
  ~Participant();
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;

  /// Exchanges HELLO and WELCOME. Throws PeerError if refused (with the difference) or if no answer comes in time.
  void join();
  /// Answers the commands initialise, resume and advance.
  void publish(Publication publication);
  /// Answers the command advance if the window must be repeated with a shorter length.
  void reject(const Outcome& outcome);
  /// Answers the command checkpoint.
  void confirm_checkpoint(const std::string& name);
  /// Waits for the next command. Throws Error with the coupler's reason on ABORT, and PeerError when the coupler has
  /// left or is silent.
  Command receive();
  /// Reports to the coupler, and through it to all processes, that this phase cannot continue.
  void abort(const std::string& reason, ExitCode code);
  void bye(const std::string& reason);

  [[nodiscard]] Role role() const;
  [[nodiscard]] const Contract& contract() const;
  [[nodiscard]] ParticipantTotals totals() const;
  /// false: stops the heartbeats, as in a frozen process; for mocks.
  void set_heartbeats(bool on);

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace poretwin::coupling
