// What the participant's and the coupler's sockets share: options, frames in and out, monitor events. Includes zmq.hpp:
// keep it out of other headers.
#pragma once

#include "common/coupling/transport.hpp"

#include <linux/tcp.h>
#include <netinet/in.h>

#include <sys/socket.h>
#include <zmq.hpp>

#include <array>
#include <cstring>

namespace poretwin::coupling {

/// A frame that claims to be larger ends its connection before memory is taken for it: 40 million points of 3
/// components.
inline constexpr std::int64_t largest_frame = std::int64_t{1} << 30;

template <class Socket>
void set_common_options(Socket& socket, const std::string& address) {
  socket.set(zmq::sockopt::linger, 2000);  // ms: an ABORT or BYE still goes out, a dead peer does not hold us
  socket.set(zmq::sockopt::sndhwm, 0);     // the exchange itself bounds what is under way: one window
  socket.set(zmq::sockopt::rcvhwm, 0);
  socket.set(zmq::sockopt::maxmsgsize, largest_frame);
  socket.set(zmq::sockopt::reconnect_ivl, 50);  // ms: start order does not matter, so look again soon
  socket.set(zmq::sockopt::reconnect_ivl_max, 500);
  if (address.rfind("tcp:", 0) == 0) {
    // A cut line shows as a disconnect after some 20 s; freezing is left to the heartbeats of the participants.
    socket.set(zmq::sockopt::tcp_keepalive, 1);
    socket.set(zmq::sockopt::tcp_keepalive_idle, 10);
    socket.set(zmq::sockopt::tcp_keepalive_intvl, 3);
    socket.set(zmq::sockopt::tcp_keepalive_cnt, 3);
  }
}

/// The kernel of a living host acknowledges what it gets, whatever its processes do: bytes that stay unacknowledged
/// mean a cut line or a dead host. False for anything but tcp.
inline bool unacknowledged(int descriptor) {
  constexpr unsigned patience = 2000;  // ms since the last acknowledgement
  tcp_info info{};
  socklen_t size = sizeof info;
  if (descriptor < 0 || ::getsockopt(descriptor, IPPROTO_TCP, TCP_INFO, &info, &size) != 0) return false;
  // Not even sent: this host's own interface is down.
  return (info.tcpi_unacked > 0 || info.tcpi_notsent_bytes > 0) &&
         (info.tcpi_retransmits > 0 || info.tcpi_last_ack_recv > patience);
}

/// Two processes of one machine may share memory; with keys nothing may pass in the clear.
inline bool may_share(const std::string& address, const std::optional<CurveKeys>& keys) {
  return !keys && address.starts_with("ipc:");
}

/// A message that lends the frame's bytes to the socket and keeps their owner alive until they are sent.
inline zmq::message_t lend(Frame frame) {
  if (frame.size == 0) return zmq::message_t{};
  if (frame.size <= 256) return zmq::message_t(frame.data, frame.size);
  auto* kept = new Frame(std::move(frame));
  // ZeroMQ only reads what is sent; its interface has no const.
  return zmq::message_t(
      const_cast<char*>(kept->data), kept->size, [](void*, void* hint) { delete static_cast<Frame*>(hint); }, kept);
}

/// Signals that a process handles, such as a person's Ctrl-C, end calls of ZeroMQ that do not even wait.
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

/// The frame shares the bytes of the received message.
inline Frame keep(zmq::message_t message) {
  auto kept = std::make_shared<zmq::message_t>(std::move(message));
  const char* data = static_cast<const char*>(kept->data());
  const std::size_t size = kept->size();
  return {std::move(kept), data, size};
}

/// One whole multipart message if one is there.
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

/// False when the context is gone; a signal counts as a wake-up.
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
