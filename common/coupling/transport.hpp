// How messages travel: one interface for a participant, one for the coupler, so that a run goes over sockets or, in
// tests, through memory with the same bytes.
#pragma once

#include "common/coupling/curve_keys.hpp"
#include "common/coupling/message.hpp"

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace poretwin::coupling {

using Milliseconds = std::chrono::milliseconds;

/// A participant's line to the coupler. Both calls may come from several threads.
class Transport {
 public:
  Transport() = default;
  Transport(const Transport&) = delete;
  Transport& operator=(const Transport&) = delete;
  virtual ~Transport() = default;
  /// Never blocks; what cannot be sent (nobody there) is dropped and shows as lost().
  virtual void send(Frames frames) = 0;
  /// The next message, or nothing after `timeout`.
  virtual std::optional<Frames> receive(Milliseconds timeout) = 0;
  /// Whether there was a connection and the other end is gone.
  [[nodiscard]] virtual bool lost() const = 0;
  /// What prevents a connection, as far as it is known; empty: nothing.
  [[nodiscard]] virtual std::string trouble() const { return {}; }
  /// Does what was sent stay without the acknowledgement that even a stopped process's host would give?
  [[nodiscard]] virtual bool cut() const { return false; }
  [[nodiscard]] virtual std::string address() const = 0;
};

/// The coupler's end of all lines; one thread only.
class Hub {
 public:
  struct Event {
    std::string line;  ///< opaque name of the line it came on
    Frames frames;     ///< empty: the line is gone
  };
  /// What the process at the end of a line is to the run. A stranger, as every process is at first, may send little and
  /// not stay for long.
  enum class Standing { guest, participant, refused };
  Hub() = default;
  Hub(const Hub&) = delete;
  Hub& operator=(const Hub&) = delete;
  virtual ~Hub() = default;
  /// False when nobody is at the end of that line.
  virtual bool send(const std::string& line, Frames frames) = 0;
  virtual std::optional<Event> receive(Milliseconds timeout) = 0;
  /// Does what was sent on that line stay without the acknowledgement that even a stopped process's host would give?
  [[nodiscard]] virtual bool cut(const std::string& line) const {
    static_cast<void>(line);
    return false;
  }
  virtual void regard(const std::string& line, Standing standing) {
    static_cast<void>(line);
    static_cast<void>(standing);
  }
  /// A line for the log, such as a connection that was refused; empty: nothing.
  virtual std::string notice() { return {}; }
  [[nodiscard]] virtual std::string address() const = 0;
};

/// DEALER socket that connects to `address` ("ipc:///path", "tcp://127.0.0.1:port"); the coupler may bind later. With
/// keys everything is encrypted, and only the coupler that has the matching key is accepted.
std::unique_ptr<Transport> connect_socket(const std::string& address, const std::optional<CurveKeys>& keys = {});

/// Whether everybody who can reach the socket is trusted.
enum class Callers { trusted, anybody };

/// ROUTER socket bound to `address`. Anything but ipc and loopback needs keys or `allow_any_address`. With
/// Callers::anybody strangers are limited (GateLimits), and a loopback address without keys accepts connections of the
/// same user (and of root) only. Throws Error.
std::unique_ptr<Hub> bind_socket(const std::string& address, bool allow_any_address = false,
                                 const std::optional<CurveKeys>& keys = {}, Callers callers = Callers::trusted);

/// The lines of one coupler inside one process.
class InProcess {
 public:
  InProcess();
  /// The coupler's end; to be called once.
  std::unique_ptr<Hub> hub();
  /// One more line; its destruction shows at the hub as a line that is gone, as a closed socket would.
  std::unique_ptr<Transport> line();

  // For tests: the conversation message by message, in both directions, heartbeats included.
  /// Messages wait where they are, until allow() or resume().
  void pause();
  /// Lets this number of messages through.
  void allow(std::size_t messages);
  void resume();
  /// From now on everything is lost, and neither side learns of it: a cut cable.
  void halt();

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
  class HubEnd;
  class LineEnd;
};

}  // namespace poretwin::coupling
