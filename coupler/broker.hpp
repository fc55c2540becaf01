// The coupler's side of the exchange of messages. It knows which participants are present or may join, and which are
// slow, frozen, dead or gone. It does not interpret fields; the schedule decides what is sent, and when.
#pragma once

#include "common/coupling/trace.hpp"
#include "common/coupling/transport.hpp"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace poretwin::coupling {

struct BrokerOptions {
  int dimension = 2;  ///< of the case
  std::string case_digest;
  std::string case_part;  ///< the "key = value" lines of which the digest is made
  std::string case_text;  ///< text of the case, for participants without a case file of their own
  std::vector<std::string> case_overrides;
  Milliseconds wait_deadline{60'000};  ///< longest wait for missing participants
  /// Times without a heartbeat. After the first, a participant is reported as frozen; after the second, the run fails.
  /// In between the participant may continue, for example after a stop in a debugger or a suspended machine.
  Milliseconds frozen_notice{2'500}, frozen_deadline{30'000};
  Milliseconds heartbeat{1'000};
  Milliseconds say_every{5'000};
  std::function<void(const std::string&)> say;      ///< writes one line to the log
  std::function<void(const std::string&)> waiting;  ///< called with the awaited participant several times per second
  std::function<bool()> interrupted;
  Trace* trace = nullptr;
};

struct BrokerTotals {
  std::uint64_t messages_sent = 0, messages_received = 0;  ///< heartbeats are not counted
  std::uint64_t bytes_sent = 0, bytes_received = 0;
  double waiting_for_fluid = 0.0, waiting_for_solid = 0.0, sending = 0.0;  ///< s
};

class Broker {
 public:
  Broker(Hub& hub, BrokerOptions options);
  ~Broker();
  Broker(const Broker&) = delete;
  Broker& operator=(const Broker&) = delete;

  /// Waits for one fluid and one solid that agree with the case and with each other. Refuses all other participants and
  /// tells them the reason.
  void gather();
  /// The next message of that participant, however slow it is. If EITHER participant fails meanwhile, throws an Error
  /// that names it, its step, its last message and what happened.
  Message wait(Role role);
  void send(Role role, Message message);
  /// Sends ABORT to all participants; never throws.
  void abort(const Error& error, const std::string& culprit);
  /// Waits until both participants have answered FINISH with BYE.
  void say_goodbye();

  [[nodiscard]] const Contract& contract(Role role) const;
  /// What the participant's HELLO announced on checkpoints.
  [[nodiscard]] bool keeps_checkpoints(Role role) const;
  [[nodiscard]] const std::vector<std::string>& checkpoints(Role role) const;
  void say(const std::string& line) const;
  /// Whether a user has asked the coupler or a participant to stop.
  [[nodiscard]] bool interrupted() const;
  [[nodiscard]] const BrokerTotals& totals() const;
  /// The process that caused the last error thrown here: "fluid", "solid" or "coupler".
  [[nodiscard]] const std::string& culprit() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace poretwin::coupling
