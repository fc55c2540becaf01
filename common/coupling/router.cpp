// A ROUTER socket behind the Hub interface. The gate knows the descriptor of each line, and which lines have closed.
#include "common/core/fault.hpp"
#include "common/coupling/gate.hpp"
#include "common/coupling/shared_memory.hpp"
#include "common/coupling/socket_options.hpp"
#include "common/coupling/transport.hpp"

#include <cstdlib>
#include <filesystem>
#include <map>
#include <set>
#include <utility>

namespace poretwin::coupling {
namespace {

bool is_loopback(const std::string& address) {
  for (const char* prefix : {"ipc://", "tcp://127.", "tcp://localhost:", "tcp://[::1]:"})
    if (address.rfind(prefix, 0) == 0) return true;
  return false;
}

/// Answers ZeroMQ's authentication requests (ZAP, rfc.zeromq.org/spec/27): whether a key is admitted.
class Doorkeeper {
 public:
  Doorkeeper(zmq::context_t& context, const CurveKeys& keys) : socket_(context, zmq::socket_type::rep) {
    std::array<std::uint8_t, 32> key{};
    zmq_z85_decode(key.data(), keys.peer_key.c_str());
    allowed_.assign(key.begin(), key.end());
    socket_.set(zmq::sockopt::linger, 0);
    socket_.bind("inproc://zeromq.zap.01");
  }
  void* handle() { return socket_.handle(); }
  /// Answers one request; returns the address of the connection if it is refused, else an empty text.
  std::string answer() {
    const auto request = receive_frames(socket_);
    if (!request) return {};
    const auto text = [&](std::size_t k) {
      return k < request->size() ? std::string((*request)[k].data, (*request)[k].size) : std::string();
    };
    const bool welcome = text(5) == "CURVE" && text(6) == allowed_;
    Frames reply;
    for (const std::string& part : {std::string("1.0"), text(1), std::string(welcome ? "200" : "400"),
                                    std::string(welcome ? "OK" : "unknown key"), std::string(), std::string()})
      reply.push_back(Frame::of(part));
    send_frames(socket_, std::move(reply));
    return welcome ? std::string() : text(3);
  }

 private:
  zmq::socket_t socket_;
  std::string allowed_;
};

class Router final : public Hub {
 public:
  Router(const std::string& address, bool allow_any_address, const std::optional<CurveKeys>& keys, Callers callers)
      : router_(context_, zmq::socket_type::router), monitor_(context_, zmq::socket_type::pair) {
    if (!allow_any_address && !keys && !is_loopback(address))
      throw Error(
          ExitCode::bad_case,
          "will not listen on '" + address +
              "': expected ipc:///path or tcp://127.0.0.1:port; anyone who reaches another address can steer the "
              "run, so it needs keys (`poretwin keys`, --keys) or --allow-any-address");
    may_share_ = may_share(address, keys);
    try {
      set_common_options(router_, address);
      router_.set(zmq::sockopt::router_mandatory, 1);
      if (keys) {
        router_.set(zmq::sockopt::curve_server, 1);
        router_.set(zmq::sockopt::curve_secretkey, keys->secret_key);
        doorkeeper_.emplace(context_, *keys);
      }
      const bool guarded = callers == Callers::anybody;
      if (guarded) router_.set(zmq::sockopt::handshake_ivl, 10'000);  // ms; longest handshake
      watch(router_, monitor_, ZMQ_EVENT_ACCEPTED | ZMQ_EVENT_DISCONNECTED | ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL);
      gate_.emplace(monitor_, guarded ? std::optional(GateLimits{}) : std::nullopt, !keys && !allow_any_address);
      router_.bind(address);
      address_ = router_.get(zmq::sockopt::last_endpoint);
    } catch (const zmq::error_t& error) {
      throw Error(ExitCode::input_output, "cannot listen on '" + address + "': " + error.what() +
                                              "; is another run using it, or the path longer than 107 characters?");
    }
  }

  bool send(const std::string& line, Frames frames) override {
    try {
      if (fails(Fallible::send)) throw zmq::error_t();
      uninterrupted(
          [&] { return router_.send(zmq::buffer(line), zmq::send_flags::sndmore | zmq::send_flags::dontwait); });
      const auto found = shared_.find(line);
      send_frames(router_, found != shared_.end() && found->second.may_lend ? found->second.lent.lend(std::move(frames))
                                                                            : std::move(frames));
      return true;
    } catch (const zmq::error_t& error) {
      if (error.num() == EHOSTUNREACH || error.num() == EAGAIN) return false;
      throw Error(ExitCode::failure, std::string("sending failed: ") + error.what());
    }
  }

  std::optional<Event> receive(Milliseconds timeout) override {
    if (auto event = next()) return event;
    std::array<zmq::pollitem_t, 3> items{{{router_.handle(), 0, ZMQ_POLLIN, 0},
                                          {nullptr, gate_->signal(), ZMQ_POLLIN, 0},
                                          {doorkeeper_ ? doorkeeper_->handle() : router_.handle(), 0, ZMQ_POLLIN, 0}}};
    poll_all(items, timeout);
    if (doorkeeper_)
      if (const std::string whence = doorkeeper_->answer(); !whence.empty())
        gate_->note("somebody at " + whence + " without the participant's key was not let in");
    return next();
  }

  bool cut(const std::string& line) const override { return unacknowledged(gate_->descriptor_of(line)); }
  void regard(const std::string& line, Standing standing) override { gate_->regard(line, standing); }
  std::string notice() override { return gate_->notice(); }
  std::string address() const override { return address_; }

 private:
  /// Messages are returned before closings, since the last message of a peer that died arrived before its line closed.
  std::optional<Event> next() {
    if (closing_.empty()) closing_ = gate_->closed().value_or("");
    if (auto event = receive_message()) return event;
    if (closing_.empty()) return std::nullopt;
    shared_.erase(closing_);
    offered_.erase(closing_);
    return Event{std::exchange(closing_, {}), {}};
  }

  /// Shared memory of the two ends of a line within one machine: each end lends its own to the other.
  struct Shared {
    LentMemory lent;
    BorrowedMemory borrowed;
    bool may_lend = false;
  };

  /// The memory shared with the other end of a line; nullptr where that memory is not accessible. The first call for a
  /// line offers memory.
  Shared* shared_with(const std::string& line) {
    if (const auto found = shared_.find(line); found != shared_.end()) return &found->second;
    const auto theirs = may_share_ ? sharing::read_routing_id(line) : std::nullopt;
    if (!theirs || !offered_.insert(line).second) return nullptr;
    Shared shared;
    const auto ours = shared.lent.name();
    if (!ours || !shared.borrowed.reaches(*theirs) || !send(line, sharing::offer(*ours))) return nullptr;
    return &shared_.emplace(line, std::move(shared)).first->second;
  }

  /// The next message for the coupler.
  std::optional<Event> receive_message() {
    while (auto event = receive_any()) {
      auto* shared = shared_with(event->line);
      if (!shared) return event;
      if (sharing::is_accept(event->frames)) {
        shared->may_lend = true;
        continue;
      }
      event->frames = shared->borrowed.borrow(std::move(event->frames));
      // Frames that are still a table: the sender and its shared memory are gone. (Else sequence numbers show a gap.)
      if (!sharing::is_table(event->frames)) return event;
    }
    return std::nullopt;
  }

  std::optional<Event> receive_any() {
    zmq::message_t line;
    if (!receive_part(router_, line)) return std::nullopt;
    Event event{line.to_string(), {}};
    int descriptor = -1;
    bool more = line.more();
    while (more) {
      zmq::message_t part;
      if (!receive_part(router_, part, zmq::recv_flags::none)) break;
      more = part.more();
      if (!more)
        if (const char* number = zmq_msg_gets(part.handle(), "__fd")) descriptor = std::atoi(number);
      event.frames.push_back(keep(std::move(part)));
    }
    if (!gate_->heard(event.line, descriptor)) return std::nullopt;
    if (event.frames.empty()) event.frames.push_back(Frame::of(std::string()));  // no frames would mean: closed line
    return event;
  }

  std::string address_;
  zmq::context_t context_{1};
  zmq::socket_t router_, monitor_;
  std::optional<Doorkeeper> doorkeeper_;
  std::optional<Gate> gate_;
  std::string closing_;  ///< a line that has closed, to be reported once its last messages are read
  bool may_share_ = false;
  std::map<std::string, Shared> shared_;  ///< by line
  std::set<std::string> offered_;         ///< lines to which sharing memory has been offered
};

}  // namespace

std::unique_ptr<Hub> bind_socket(const std::string& address, bool allow_any_address,
                                 const std::optional<CurveKeys>& keys, Callers callers) {
  return std::make_unique<Router>(address, allow_any_address, keys, callers);
}

}  // namespace poretwin::coupling
