// The client by which a phase takes part in a coupled run: handshake, commands with deadlines, publications,
// heartbeats.
#pragma once

#include "common/coupling/transport.hpp"

#include <functional>
#include <memory>

namespace poretwin::coupling {

struct ParticipantOptions {
  Milliseconds welcome_deadline{60'000};        ///< for the coupler to answer the HELLO
  Milliseconds coupler_deadline{60'000};        ///< silence after which the coupler counts as frozen
  Milliseconds say_every{5'000};                ///< while waiting
  std::function<void(const std::string&)> say;  ///< one line for the log; absent: silence
  std::function<bool()> interrupted;            ///< has a person asked to stop? Sent to the coupler by heartbeat
  std::string software = "poretwin";
  bool keeps_checkpoints = false;
  std::vector<std::string> checkpoints;  ///< that it could resume from
};

/// The coupler's next request.
struct Command {
  enum class Kind { initialise, resume, advance, restore, checkpoint, finish };
  Kind kind = Kind::finish;
  Window window;
  Inbox inbox;
  bool record_frame = false;   ///< the state at the window's end (initialise: at time zero) belongs in the output,
  bool record_gauges = false;  ///< written when the next advance or finish says that the window stands
  std::string reason;
  std::string checkpoint;         ///< to write, or to resume from
  std::vector<std::string> keep;  ///< earlier checkpoints to keep
};

struct ParticipantTotals {
  std::uint64_t messages_sent = 0, messages_received = 0;  ///< heartbeats not counted
  std::uint64_t bytes_sent = 0, bytes_received = 0;        ///< headers and frames
  double sending = 0.0, waiting = 0.0;                     ///< s
};

/// Asks the coupler for its case, on a line that has not said HELLO yet. Throws as Participant::join does.
CaseFile request_case(Transport& transport, Role role, const ParticipantOptions& options);

class Participant {
 public:
  Participant(std::unique_ptr<Transport> transport, Role role, Contract contract, ParticipantOptions options = {});
  /// Closes the connection silently when neither bye() nor abort() was called: the coupler reports a death.
  ~Participant();
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;

  /// HELLO and WELCOME. Throws PeerError when refused (naming what differs) or when nobody answers in time.
  void join();
  /// Answers initialise, resume and advance, and opens the conversation at time zero.
  void publish(Publication publication);
  /// Answers an advance that must be repeated with a shorter window.
  void reject(const Outcome& outcome);
  /// Answers checkpoint.
  void confirm_checkpoint(const std::string& name);
  /// Waits for the next command. Throws Error with the coupler's reason on ABORT, PeerError when the coupler is gone or
  /// silent.
  Command receive();
  /// Reports to all others that this phase cannot go on.
  void abort(const std::string& reason, ExitCode code);
  void bye(const std::string& reason);

  [[nodiscard]] Role role() const;
  [[nodiscard]] const Contract& contract() const;
  [[nodiscard]] ParticipantTotals totals() const;
  /// For mocks that behave like a frozen process.
  void set_heartbeats(bool on);

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace poretwin::coupling
