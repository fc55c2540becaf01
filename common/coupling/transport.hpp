// Transport of messages: one interface for a participant, one for the coupler. A run uses sockets, a test uses memory;
// the bytes are the same.
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

/// A participant's connection (line) to the coupler. Several threads may call it.
class Transport {
 public:
  Transport() = default;
  Transport(const Transport&) = delete;
  Transport& operator=(const Transport&) = delete;
  virtual ~Transport() = default;
  /// Never blocks. If there is no connection, the message is dropped, and lost() becomes true.
  virtual void send(Frames frames) = 0;
  /// The next message; empty if none arrives within `timeout`.
  virtual std::optional<Frames> receive(Milliseconds timeout) = 0;
  /// Whether there was a connection and the other end has left it.
  [[nodiscard]] virtual bool lost() const = 0;
  /// The known reason that prevents a connection; empty if nothing is known to prevent it.
  [[nodiscard]] virtual std::string trouble() const { return {}; }
  /// Whether sent bytes stay without an acknowledgement. Even the host of a stopped process would acknowledge them.
  [[nodiscard]] virtual bool cut() const { return false; }
  [[nodiscard]] virtual std::string address() const = 0;
};

/// The coupler's end of all lines. Only one thread may use it.
class Hub {
 public:
  struct Event {
    std::string line;  ///< identifies the line on which the event occurred
    Frames frames;     ///< empty: the line has closed
  };
  /// Role of a process at the end of a line. Initially every process is a stranger, which may send little and stay only
  /// for a short time.
  enum class Standing { guest, participant, refused };
  Hub() = default;
  Hub(const Hub&) = delete;
  Hub& operator=(const Hub&) = delete;
  virtual ~Hub() = default;
  /// Returns false if no process is at the end of that line.
  virtual bool send(const std::string& line, Frames frames) = 0;
  virtual std::optional<Event> receive(Milliseconds timeout) = 0;
  /// Whether bytes sent on that line stay without an acknowledgement. Even the host of a stopped process would
  /// acknowledge them.
  [[nodiscard]] virtual bool cut(const std::string& line) const {
    static_cast<void>(line);
    return false;
  }
  virtual void regard(const std::string& line, Standing standing) {
    static_cast<void>(line);
    static_cast<void>(standing);
  }
  /// A text for the log, such as that of a refused connection; empty if there is no text.
  virtual std::string notice() { return {}; }
  [[nodiscard]] virtual std::string address() const = 0;
};

/// A DEALER socket that connects to `address` ("ipc:///path", "tcp://127.0.0.1:port"); the coupler may bind later. With
/// keys all data are encrypted, and only the coupler with the matching key is accepted.
std::unique_ptr<Transport> connect_socket(const std::string& address, const std::optional<CurveKeys>& keys = {});

/// Whether all processes that can reach the socket are trusted.
enum class Callers { trusted, anybody };

/// A ROUTER socket bound to `address`. Addresses other than ipc and loopback need keys or `allow_any_address`. With
/// Callers::anybody strangers are limited (GateLimits), and a loopback address without keys accepts only connections of
/// the same user (and of root). Throws Error.
std::unique_ptr<Hub> bind_socket(const std::string& address, bool allow_any_address = false,
                                 const std::optional<CurveKeys>& keys = {}, Callers callers = Callers::trusted);

/// The lines of one coupler within one process, without sockets.
class InProcess {
 public:
  InProcess();
  /// The coupler's end; may be called once.
  std::unique_ptr<Hub> hub();
  /// Opens one more line to the coupler. When the line is destroyed, the hub reports it as closed, as with a socket.
  std::unique_ptr<Transport> line();

  // For tests: controls the exchange message by message, in both directions, including heartbeats.
  /// Stops all messages until allow() or resume().
  void pause();
  /// Lets this number of messages pass.
  void allow(std::size_t messages);
  void resume();
  /// After this call all messages are lost and neither side is informed, as with a cut cable.
  void halt();

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
  class HubEnd;
  class LineEnd;
};

}  // namespace poretwin::coupling
