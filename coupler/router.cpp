// A ROUTER socket behind the Hub interface. The socket monitor tells which descriptor closed, the messages tell whose
// it was.
#include "common/coupling/socket_options.hpp"
#include "coupler/broker.hpp"

#include <cstdlib>
#include <filesystem>
#include <map>

namespace poretwin::coupling {
namespace {

bool is_loopback(const std::string& address) {
  for (const char* prefix : {"ipc://", "tcp://127.", "tcp://localhost:", "tcp://[::1]:"})
    if (address.rfind(prefix, 0) == 0) return true;
  return false;
}

class Router final : public Hub {
 public:
  Router(const std::string& address, bool allow_any_address)
      : router_(context_, zmq::socket_type::router), monitor_(context_, zmq::socket_type::pair) {
    if (!allow_any_address && !is_loopback(address))
      throw Error(
          ExitCode::bad_case,
          "will not listen on '" + address +
              "': expected ipc:///path or tcp://127.0.0.1:port; anyone who reaches another address can steer the "
              "run, so it needs --allow-any-address");
    try {
      set_common_options(router_, address);
      router_.set(zmq::sockopt::router_mandatory, 1);
      watch(router_, monitor_, ZMQ_EVENT_DISCONNECTED);
      router_.bind(address);
      address_ = router_.get(zmq::sockopt::last_endpoint);
    } catch (const zmq::error_t& error) {
      throw Error(ExitCode::input_output, "cannot listen on '" + address + "': " + error.what() +
                                              "; is another run using it, or the path longer than 107 characters?");
    }
  }

  bool send(const std::string& line, Frames frames) override {
    try {
      router_.send(zmq::buffer(line), zmq::send_flags::sndmore | zmq::send_flags::dontwait);
      send_frames(router_, std::move(frames));
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
    std::array<zmq::pollitem_t, 2> items{{{router_.handle(), 0, ZMQ_POLLIN, 0}, {monitor_.handle(), 0, ZMQ_POLLIN, 0}}};
    poll_all(items, timeout);
    if (auto event = receive_message()) return event;
    return receive_closing();
  }

  std::string address() const override { return address_; }

 private:
  std::optional<Event> receive_message() {
    zmq::message_t line;
    if (!router_.recv(line, zmq::recv_flags::dontwait)) return std::nullopt;
    Event event{line.to_string(), {}};
    bool more = line.more();
    while (more) {
      zmq::message_t part;
      if (!router_.recv(part)) break;
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
      const auto found = line_of_.find(event->value);
      if (event->kind != ZMQ_EVENT_DISCONNECTED || found == line_of_.end()) continue;
      Event closing{found->second, {}};
      line_of_.erase(found);
      return closing;
    }
    return std::nullopt;
  }

  std::string address_;
  zmq::context_t context_{1};
  zmq::socket_t router_, monitor_;
  std::map<int, std::string> line_of_;
};

}  // namespace

std::unique_ptr<Hub> bind_socket(const std::string& address, bool allow_any_address) {
  return std::make_unique<Router>(address, allow_any_address);
}

}  // namespace poretwin::coupling
