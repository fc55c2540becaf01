// The coupler's side of the conversation: which participants are there, who may join, who is slow, frozen, dead or
// gone. It knows messages, not their meaning for the physics; the schedule decides what is sent when.
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
  std::string case_part;  ///< what the digest is of, as "key = value" lines
  std::string case_text;  ///< for participants without a case file of their own
  std::vector<std::string> case_overrides;
  Milliseconds wait_deadline{60'000};  ///< for missing participants
  /// Time without a heartbeat after which a participant is reported as frozen, and after which the run is given up. In
  /// between it may come back (from a debugger, or when its machine was suspended): the report alone ends nothing.
  Milliseconds frozen_notice{2'500}, frozen_deadline{30'000};
  Milliseconds heartbeat{1'000};
  Milliseconds say_every{5'000};
  std::function<void(const std::string&)> say;      ///< one line for the log
  std::function<void(const std::string&)> waiting;  ///< whom for; called several times per second while waiting
  std::function<bool()> interrupted;
  Trace* trace = nullptr;
};

struct BrokerTotals {
  std::uint64_t messages_sent = 0, messages_received = 0;  ///< heartbeats not counted
  std::uint64_t bytes_sent = 0, bytes_received = 0;
  double waiting_for_fluid = 0.0, waiting_for_solid = 0.0, sending = 0.0;  ///< s
};

class Broker {
 public:
  Broker(Hub& hub, BrokerOptions options);
  ~Broker();
  Broker(const Broker&) = delete;
  Broker& operator=(const Broker&) = delete;

  /// Waits for one fluid and one solid that agree with the case and with each other; refuses all others with a reason.
  void gather();
  /// The next message of that participant. Every failure of EITHER participant meanwhile throws an Error that names it,
  /// its step, its last message and what happened. A participant that is merely slow is waited for.
  Message wait(Role role);
  void send(Role role, Message message);
  /// Sends ABORT to all participants; never throws.
  void abort(const Error& error, const std::string& culprit);
  /// Waits for the BYE of both after FINISH.
  void say_goodbye();

  [[nodiscard]] const Contract& contract(Role role) const;
  /// What the participant said of checkpoints in its HELLO.
  [[nodiscard]] bool keeps_checkpoints(Role role) const;
  [[nodiscard]] const std::vector<std::string>& checkpoints(Role role) const;
  void say(const std::string& line) const;
  /// Has a person asked the coupler or a participant to stop?
  [[nodiscard]] bool interrupted() const;
  [[nodiscard]] const BrokerTotals& totals() const;
  /// "fluid", "solid" or "coupler": who caused the last error thrown here.
  [[nodiscard]] const std::string& culprit() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace poretwin::coupling
