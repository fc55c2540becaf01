// Connections to the coupler's socket: finds the line of communication of each connection, and limits the connections
// that belong to no participant (strangers). A port that others can reach must cost the run only a bounded amount of
// memory, descriptors, log and time.
#pragma once

#include "common/coupling/transport.hpp"

#include <atomic>
#include <deque>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

namespace zmq {
class socket_t;
}

namespace poretwin::coupling {

/// Limits for connections of strangers.
struct GateLimits {
  std::uint64_t bytes = 1 << 20;      ///< received bytes; a HELLO with its contract takes some thousand
  int messages = 20;                  ///< a participant sends three messages before it is accepted
  std::size_t connections = 128;      ///< at the same time
  Milliseconds silent{10'000};        ///< until the first valid message
  Milliseconds guest{600'000};        ///< from the request for the case to HELLO, while the participant makes particles
  Milliseconds refused{1'000};        ///< time to read the reason of a refusal
  std::size_t descriptors_kept = 16;  ///< reserved for checkpoints and summaries
  std::size_t notices = 20;           ///< lines in the log
};

/// Watches the events of a socket's monitor in its own thread, so that strangers cannot exploit the time in which the
/// coupler is busy mapping. libzmq reports the descriptors that it has accepted. The gate ends a connection by shutting
/// down its descriptor, which libzmq treats as if the other end had left.
class Gate {
 public:
  /// `monitor` must report ZMQ_EVENT_ACCEPTED, HANDSHAKE_FAILED_PROTOCOL and DISCONNECTED, and only the gate may use
  /// it. `limits`: absent for a socket whose other ends are trusted. own_user_only: ends tcp connections of other users
  /// of this machine.
  Gate(zmq::socket_t& monitor, std::optional<GateLimits> limits, bool own_user_only);
  Gate(const Gate&) = delete;
  Gate& operator=(const Gate&) = delete;
  ~Gate();

  /// Records a message that arrived on that line through that descriptor. Returns whether it may be processed.
  bool heard(const std::string& line, int descriptor);
  void regard(const std::string& line, Hub::Standing standing);
  /// A line whose connection has closed. Each such line is returned once.
  std::optional<std::string> closed();
  /// A text for the log; empty if there is no text.
  std::string notice();
  void note(const std::string& what);
  /// Descriptor of a line's connection; -1 if it has none.
  [[nodiscard]] int descriptor_of(const std::string& line) const;
  /// Descriptor that becomes readable when closed() or notice() may return a result.
  [[nodiscard]] int signal() const { return signal_; }

 private:
  using Clock = std::chrono::steady_clock;
  struct Connection {
    std::uint64_t cookie = 0;  ///< the kernel's identifier, since descriptors are reused; 0: not read yet
    /// Normally one. Unread messages of an earlier connection through the same descriptor add the line of that one,
    /// and nothing tells which is which. A connection is therefore ended only if every line on it allows that.
    std::vector<std::string> lines;
    Clock::time_point since;
    bool ended = false;
  };
  /// The process at the end of a line.
  struct Caller {
    int descriptor = -1;
    Clock::time_point until;  ///< time at which its connection is ended unless it is a participant by then
    int messages = 0;
    bool member = false;
  };
  bool is_members(const Connection& connection) const;
  bool sends_too_much(const Connection& connection) const;
  /// Time until which a stranger's connection may stay.
  Clock::time_point end_of(const Connection& connection) const;
  bool look();
  void meet(int descriptor, Connection& connection);
  void end(int descriptor, Connection& connection, const std::string& why);
  void enforce();
  bool make_room();
  void wake() const;
  void keep_looking();

  zmq::socket_t& monitor_;
  const std::optional<GateLimits> limits_;
  const bool own_user_only_;
  int events_ = -1, signal_ = -1, stop_ = -1;
  std::size_t most_strangers_ = 0;
  // Messages from participants must never wait until messages from strangers are handled.
  std::set<std::string> members_;  ///< used by the hub's thread only
  mutable std::mutex mutex_;       ///< guards the monitor and the next two members
  std::map<int, Connection> connections_;
  std::map<std::string, Caller> callers_;  ///< by line
  std::mutex news_;                        ///< guards the data that are passed to the hub's thread; locked last
  std::deque<std::string> closed_, notices_;
  std::set<std::string> said_;
  std::thread thread_;
};

}  // namespace poretwin::coupling
