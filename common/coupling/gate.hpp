// Who is connected to the coupler's socket, to whom each line belongs, and what a connection may do that is no
// participant's: a port that others can reach must not cost the run more than a bounded amount of memory, descriptors,
// log and time.
#pragma once

#include "common/coupling/transport.hpp"

#include <atomic>
#include <deque>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <thread>

namespace zmq {
class socket_t;
}

namespace poretwin::coupling {

/// Limits for connections that are no participant's.
struct GateLimits {
  std::uint64_t bytes = 1 << 20;      ///< received; a HELLO with its contract has some thousand
  int messages = 20;                  ///< a participant sends three before it is one
  std::size_t connections = 128;      ///< at once
  Milliseconds silent{10'000};        ///< until something is said that makes sense
  Milliseconds guest{600'000};        ///< from asking for the case to HELLO: particles are made meanwhile
  Milliseconds refused{1'000};        ///< to read why
  std::size_t descriptors_kept = 16;  ///< of the process: for checkpoints and summaries
  std::size_t notices = 20;           ///< in the log
};

/// Watches a socket's monitor from a thread of its own, since the coupler may be mapping for long, which a stranger
/// must not be able to exploit. libzmq reports which descriptors it has accepted; a connection is ended by shutting its
/// descriptor down, which libzmq takes as if the other end had left.
class Gate {
 public:
  /// `monitor` hears ZMQ_EVENT_ACCEPTED, HANDSHAKE_FAILED_PROTOCOL and DISCONNECTED, and is the gate's alone. `limits`:
  /// none for a socket whose other end is trusted. own_user_only: over tcp, connections of other users of this machine
  /// are ended.
  Gate(zmq::socket_t& monitor, std::optional<GateLimits> limits, bool own_user_only);
  Gate(const Gate&) = delete;
  Gate& operator=(const Gate&) = delete;
  ~Gate();

  /// A message came on that line through that descriptor: may it be processed?
  bool heard(const std::string& line, int descriptor);
  void regard(const std::string& line, Hub::Standing standing);
  /// A line whose connection has closed since the last call.
  std::optional<std::string> closed();
  /// A line for the log; empty: nothing.
  std::string notice();
  void note(const std::string& what);
  /// The descriptor of a line's connection; -1: none.
  [[nodiscard]] int descriptor_of(const std::string& line) const;
  /// Readable when closed() or notice() may have something.
  [[nodiscard]] int signal() const { return signal_; }

 private:
  using Clock = std::chrono::steady_clock;
  struct Connection {
    std::uint64_t cookie = 0;  ///< the kernel's name for it, as descriptors are used again; 0: not asked for yet
    std::string line;
    Clock::time_point until;  ///< when it is ended unless it becomes a participant's
    Clock::time_point since;
    int messages = 0;
    bool member = false, ended = false;
  };
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
  // What a participant says must never wait for what strangers do.
  std::set<std::string> members_;  ///< of the hub's thread alone
  mutable std::mutex mutex_;       ///< of the monitor and of the next two
  std::map<int, Connection> connections_;
  std::map<std::string, int> descriptor_of_;
  std::mutex news_;  ///< of what is passed on to the hub's thread; locked last
  std::deque<std::string> closed_, notices_;
  std::set<std::string> said_;
  std::thread thread_;
};

}  // namespace poretwin::coupling
