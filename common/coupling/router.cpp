// A ROUTER socket behind the Hub interface. The socket monitor tells which descriptor closed, the messages tell whose
// it was.
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

/// Answers ZeroMQ's question (ZAP, rfc.zeromq.org/spec/27) whether the holder of a key may come in.
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
  /// Where somebody came from who was not let in; empty: nobody.
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
  Router(const std::string& address, bool allow_any_address, const std::optional<CurveKeys>& keys)
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
      watch(router_, monitor_, ZMQ_EVENT_DISCONNECTED | ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL);
      router_.bind(address);
      address_ = router_.get(zmq::sockopt::last_endpoint);
    } catch (const zmq::error_t& error) {
      throw Error(ExitCode::input_output, "cannot listen on '" + address + "': " + error.what() +
                                              "; is another run using it, or the path longer than 107 characters?");
    }
  }

  bool send(const std::string& line, Frames frames) override {
    try {
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
    // Messages before closings: what a dying peer still said counts.
    if (auto event = receive_message()) return event;
    if (auto event = receive_closing()) return event;
    std::array<zmq::pollitem_t, 3> items{{{router_.handle(), 0, ZMQ_POLLIN, 0},
                                          {monitor_.handle(), 0, ZMQ_POLLIN, 0},
                                          {doorkeeper_ ? doorkeeper_->handle() : monitor_.handle(), 0, ZMQ_POLLIN, 0}}};
    poll_all(items, timeout);
    if (doorkeeper_)
      if (const std::string whence = doorkeeper_->answer(); !whence.empty())
        note("somebody at " + whence + " without the participant's key was not let in");
    if (auto event = receive_message()) return event;
    return receive_closing();
  }

  bool cut(const std::string& line) const override {
    for (const auto& [descriptor, name] : line_of_)
      if (name == line) return unacknowledged(descriptor);
    return false;
  }
  std::string notice() override { return std::exchange(notice_, {}); }
  std::string address() const override { return address_; }

 private:
  /// Who is turned away tries again several times a second: everything is said once.
  void note(const std::string& what) {
    if (told_.size() < 100 && told_.insert(what).second) notice_ = what;
  }

  /// What both ends of a line on this machine show each other.
  struct Shared {
    LentMemory lent;
    BorrowedMemory borrowed;
    bool may_lend = false;
  };

  /// Of a line whose other end has memory that we reach; the first time it is offered ours.
  Shared* shared_with(const std::string& line) {
    if (const auto found = shared_.find(line); found != shared_.end()) return &found->second;
    const auto theirs = may_share_ ? sharing::read_routing_id(line) : std::nullopt;
    if (!theirs || !asked_.insert(line).second) return nullptr;
    Shared shared;
    const auto ours = shared.lent.name();
    if (!ours || !shared.borrowed.reaches(*theirs) || !send(line, sharing::offer(*ours))) return nullptr;
    return &shared_.emplace(line, std::move(shared)).first->second;
  }

  /// The next message that is meant for the coupler.
  std::optional<Event> receive_message() {
    while (auto event = receive_any()) {
      auto* shared = shared_with(event->line);
      if (!shared) return event;
      if (sharing::is_accept(event->frames)) {
        shared->may_lend = true;
        continue;
      }
      event->frames = shared->borrowed.borrow(std::move(event->frames));
      // Its sender is gone, and with it what it said last; else the gap in its numbers will tell.
      if (!sharing::is_table(event->frames)) return event;
    }
    return std::nullopt;
  }

  std::optional<Event> receive_any() {
    zmq::message_t line;
    if (!receive_part(router_, line)) return std::nullopt;
    Event event{line.to_string(), {}};
    bool more = line.more();
    while (more) {
      zmq::message_t part;
      if (!receive_part(router_, part, zmq::recv_flags::none)) break;
      more = part.more();
      if (!more)
        if (const char* descriptor = zmq_msg_gets(part.handle(), "__fd")) line_of_[std::atoi(descriptor)] = event.line;
      event.frames.push_back(keep(std::move(part)));
    }
    if (event.frames.empty()) event.frames.push_back(Frame::of(std::string()));  // an empty message is no closing
    return event;
  }

  std::optional<Event> receive_closing() {
    while (const auto event = next_event(monitor_)) {
      if (event->kind == ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL)
        note(
            "somebody was turned away who does not speak this coupler's way: keys on one side only, or not made "
            "together?");
      const auto found = line_of_.find(event->value);
      if (event->kind != ZMQ_EVENT_DISCONNECTED || found == line_of_.end()) continue;
      Event closing{found->second, {}};
      line_of_.erase(found);
      shared_.erase(closing.line);
      asked_.erase(closing.line);
      return closing;
    }
    return std::nullopt;
  }

  std::string address_;
  zmq::context_t context_{1};
  zmq::socket_t router_, monitor_;
  std::optional<Doorkeeper> doorkeeper_;
  std::map<int, std::string> line_of_;
  bool may_share_ = false;
  std::map<std::string, Shared> shared_;  ///< by line
  std::set<std::string> asked_;           ///< lines whose memory has been tried
  std::string notice_;
  std::set<std::string> told_;
};

}  // namespace

std::unique_ptr<Hub> bind_socket(const std::string& address, bool allow_any_address,
                                 const std::optional<CurveKeys>& keys) {
  return std::make_unique<Router>(address, allow_any_address, keys);
}

}  // namespace poretwin::coupling
