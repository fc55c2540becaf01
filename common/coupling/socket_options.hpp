// Common parts of the participant's and the coupler's sockets: options, frames in and out, monitor events. Includes
// zmq.hpp: do not include this file in other headers.
#pragma once

#include "common/coupling/transport.hpp"

#include <linux/tcp.h>
#include <netinet/in.h>

#include <sys/socket.h>
#include <zmq.hpp>

#include <array>
#include <cstring>

namespace poretwin::coupling {

/// Largest size of a frame in bytes. A connection that announces a larger frame is ended before memory is allocated.
/// The size suffices for 40 million points with 3 components.
inline constexpr std::int64_t largest_frame = std::int64_t{1} << 30;

template <class Socket>
void set_common_options(Socket& socket, const std::string& address) {
  socket.set(zmq::sockopt::linger, 2000);  // ms; an ABORT or BYE is still sent, but a dead peer does not delay the exit
  socket.set(zmq::sockopt::sndhwm, 0);     // no limit: at most one window's exchange is in transit
  socket.set(zmq::sockopt::rcvhwm, 0);
  socket.set(zmq::sockopt::maxmsgsize, largest_frame);
  socket.set(zmq::sockopt::reconnect_ivl, 50);  // ms; processes may start in any order: try again soon
  socket.set(zmq::sockopt::reconnect_ivl_max, 500);
  if (address.rfind("tcp:", 0) == 0) {
    // A cut connection is detected as a disconnect after some 20 s; frozen processes by missing heartbeats.
    socket.set(zmq::sockopt::tcp_keepalive, 1);
    socket.set(zmq::sockopt::tcp_keepalive_idle, 10);
    socket.set(zmq::sockopt::tcp_keepalive_intvl, 3);
    socket.set(zmq::sockopt::tcp_keepalive_cnt, 3);
  }
}

/// Whether sent bytes stay unacknowledged, which shows a cut connection or a dead host. The kernel of a living host
/// acknowledges received bytes, whatever its processes do. Always false except for tcp.
inline bool unacknowledged(int descriptor) {
  constexpr unsigned patience = 2000;  // ms since the last acknowledgement
  tcp_info info{};
  socklen_t size = sizeof info;
  if (descriptor < 0 || ::getsockopt(descriptor, IPPROTO_TCP, TCP_INFO, &info, &size) != 0) return false;
  // Bytes that could not even be sent: the network interface of this host is down.
  return (info.tcpi_unacked > 0 || info.tcpi_notsent_bytes > 0) &&
         (info.tcpi_retransmits > 0 || info.tcpi_last_ack_recv > patience);
}

/// Processes of one machine may share memory, except if they use keys: then all data must pass encrypted.
inline bool may_share(const std::string& address, const std::optional<CurveKeys>& keys) {
  return !keys && address.starts_with("ipc:");
}

/// A message that uses the frame's bytes without a copy and keeps their owner alive until they are sent.
inline zmq::message_t lend(Frame frame) {
  if (frame.size == 0) return zmq::message_t{};
  if (frame.size <= 256) return zmq::message_t(frame.data, frame.size);
  auto* kept = new Frame(std::move(frame));
  // ZeroMQ only reads the data of messages that are sent, but its interface is not const.
  return zmq::message_t(
      const_cast<char*>(kept->data), kept->size, [](void*, void* hint) { delete static_cast<Frame*>(hint); }, kept);
}

/// Repeats a call of ZeroMQ that a signal, such as Ctrl-C, has interrupted. It can also interrupt non-blocking calls.
template <class Call>
auto uninterrupted(Call&& call) {
  for (;;) try {
      return call();
    } catch (const zmq::error_t& error) {
      if (error.num() != EINTR) throw;
    }
}

inline bool receive_part(zmq::socket_t& socket, zmq::message_t& part,
                         zmq::recv_flags flags = zmq::recv_flags::dontwait) {
  return uninterrupted([&] { return socket.recv(part, flags); }).has_value();
}

/// Sends all frames as one multipart message, without blocking (there is no high-water mark).
inline void send_frames(zmq::socket_t& socket, Frames frames) {
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const auto flags = k + 1 < frames.size() ? zmq::send_flags::sndmore : zmq::send_flags::none;
    auto part = lend(std::move(frames[k]));
    uninterrupted([&] { return socket.send(part, flags | zmq::send_flags::dontwait); });
  }
}

/// A frame that shares the bytes of the received message.
inline Frame keep(zmq::message_t message) {
  auto kept = std::make_shared<zmq::message_t>(std::move(message));
  const char* data = static_cast<const char*>(kept->data());
  const std::size_t size = kept->size();
  return {std::move(kept), data, size};
}

/// One complete multipart message, if there is one.
inline std::optional<Frames> receive_frames(zmq::socket_t& socket) {
  Frames frames;
  bool more = true;
  while (more) {
    zmq::message_t part;
    if (!receive_part(socket, part, frames.empty() ? zmq::recv_flags::dontwait : zmq::recv_flags::none))
      return std::nullopt;
    more = part.more();
    frames.push_back(keep(std::move(part)));
  }
  return frames;
}

struct MonitorEvent {
  int kind = 0;
  int value = 0;  ///< the descriptor, for connection events
};

/// Makes `monitor` (a PAIR socket of the same context) receive the events of `socket`.
inline void watch(zmq::socket_t& socket, zmq::socket_t& monitor, int events) {
  const std::string address = "inproc://monitor";  // contexts are private, so one name is enough
  if (zmq_socket_monitor(socket.handle(), address.c_str(), events) != 0) throw zmq::error_t();
  monitor.set(zmq::sockopt::linger, 0);
  monitor.connect(address);
}

inline std::optional<MonitorEvent> next_event(zmq::socket_t& monitor) {
  zmq::message_t head, endpoint;
  if (!receive_part(monitor, head)) return std::nullopt;
  if (head.more() && !receive_part(monitor, endpoint, zmq::recv_flags::none)) return std::nullopt;
  if (head.size() < 6) return std::nullopt;
  std::uint16_t kind = 0;
  std::int32_t value = 0;
  std::memcpy(&kind, head.data(), sizeof kind);
  std::memcpy(&value, static_cast<const char*>(head.data()) + sizeof kind, sizeof value);
  return MonitorEvent{kind, value};
}

/// Waits for one of the items. Returns false if the context has been closed. A signal also ends the wait.
template <std::size_t N>
bool poll_all(std::array<zmq::pollitem_t, N>& items, Milliseconds timeout) {
  try {
    zmq::poll(items.data(), N, timeout);
  } catch (const zmq::error_t& error) {
    return error.num() == EINTR;
  }
  return true;
}

}  // namespace poretwin::coupling
