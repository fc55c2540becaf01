// A DEALER socket behind the Transport interface. It has no thread of its own, since that would add one wake-up to each
// message. The socket is locked while it sends or receives.
#include "common/core/fault.hpp"
#include "common/coupling/shared_memory.hpp"
#include "common/coupling/socket_options.hpp"
#include "common/coupling/transport.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <mutex>

namespace poretwin::coupling {
namespace {

class Socket final : public Transport {
 public:
  Socket(std::string address, const std::optional<CurveKeys>& keys)
      : address_(std::move(address)),
        wake_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
        dealer_(context_, zmq::socket_type::dealer),
        monitor_(context_, zmq::socket_type::pair) {
    if (wake_ < 0) throw Error(ExitCode::failure, "no event descriptor left (ulimit -n)");
    try {
      set_common_options(dealer_, address_);
      if (may_share(address_, keys))
        if (const auto name = lent_.name()) dealer_.set(zmq::sockopt::routing_id, sharing::routing_id(name));
      if (keys) {
        dealer_.set(zmq::sockopt::curve_publickey, keys->public_key);
        dealer_.set(zmq::sockopt::curve_secretkey, keys->secret_key);
        dealer_.set(zmq::sockopt::curve_serverkey, keys->peer_key);
      }
      watch(dealer_, monitor_,
            ZMQ_EVENT_CONNECTED | ZMQ_EVENT_HANDSHAKE_SUCCEEDED | ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL |
                ZMQ_EVENT_HANDSHAKE_FAILED_AUTH | ZMQ_EVENT_DISCONNECTED);
      dealer_.connect(address_);
      signals_ = {{{dealer_.get(zmq::sockopt::fd), POLLIN, 0},
                   {monitor_.get(zmq::sockopt::fd), POLLIN, 0},
                   {wake_, POLLIN, 0}}};
    } catch (const zmq::error_t& error) {
      ::close(wake_);
      throw Error(ExitCode::bad_case,
                  "cannot connect to '" + address_ + "': " + error.what() +
                      "; expected an address such as ipc:///tmp/run/socket or tcp://127.0.0.1:5555");
    }
  }

  ~Socket() override {
    while (look()) {
    }
    if (!open_ || lost_) dealer_.set(zmq::sockopt::linger, 0);  // without a connection, remaining messages are dropped
    dealer_.close();
    monitor_.close();
    ::close(wake_);
  }

  void send(Frames frames) override {
    const std::lock_guard lock(mutex_);
    try {
      if (fails(Fallible::send)) throw zmq::error_t();
      send_frames(dealer_, may_lend_ ? lent_.lend(std::move(frames)) : std::move(frames));
    } catch (const zmq::error_t& error) {
      throw Error(ExitCode::failure, "sending to the coupler at " + address_ + " failed: " + error.what());
    }
    // Sending also reads pending events, and so uses up the signal for which receive() may be waiting.
    if ((uninterrupted([&] { return dealer_.get(zmq::sockopt::events); }) & ZMQ_POLLIN) != 0) wake();
  }

  std::optional<Frames> receive(Milliseconds timeout) override {
    const auto end = std::chrono::steady_clock::now() + timeout;
    for (;;) {
      if (auto frames = look()) return frames;
      const auto left = std::chrono::ceil<Milliseconds>(end - std::chrono::steady_clock::now()).count();
      if (lost_ || left <= 0) return std::nullopt;
      auto items = signals_;
      if (::poll(items.data(), items.size(), static_cast<int>(left)) < 0) return std::nullopt;  // a signal
      std::uint64_t count = 0;
      [[maybe_unused]] const auto got = ::read(wake_, &count, sizeof count);
    }
  }

  bool lost() const override { return lost_; }
  std::string trouble() const override {
    return rejected_
               ? "a coupler answers there, but its encryption does not match: have both sides keys that `poretwin keys` "
                 "made together, or neither?"
               : "";
  }
  bool cut() const override { return unacknowledged(descriptor_); }
  std::string address() const override { return address_; }

 private:
  void wake() const {
    const std::uint64_t one = 1;
    // The counter does not overflow in practice; even a full counter would wake the reader.
    [[maybe_unused]] const auto written = ::write(wake_, &one, sizeof one);
  }

  /// The next message, if there is any; also reads the events of the connection.
  std::optional<Frames> look() {
    const std::lock_guard lock(mutex_);
    if (auto frames = next_message()) return frames;
    bool something = false;
    while (const auto event = next_event(monitor_)) {
      something = true;
      if (event->kind == ZMQ_EVENT_CONNECTED) {
        descriptor_ = event->value;
      } else if (event->kind == ZMQ_EVENT_HANDSHAKE_SUCCEEDED) {
        open_ = true;
        rejected_ = false;
      } else if (!open_) {
        rejected_ = true;
      } else if (event->kind == ZMQ_EVENT_DISCONNECTED) {
        lost_ = true;
      }
    }
    // The last message of the other end arrived before the event of its closing.
    return something ? next_message() : std::nullopt;
  }

  std::optional<Frames> next_message() {
    while (auto frames = receive_frames(dealer_)) {
      const auto name = sharing::read_offer(*frames);
      if (!name) return borrowed_.borrow(std::move(*frames));
      may_lend_ = true;
      if (borrowed_.reaches(*name)) send_frames(dealer_, sharing::accept());
    }
    return std::nullopt;
  }

  std::string address_;
  int wake_;
  zmq::context_t context_{1};
  zmq::socket_t dealer_, monitor_;
  std::array<pollfd, 3> signals_{};  ///< descriptors that are readable when there may be news
  std::mutex mutex_;                 ///< guards both sockets and the shared memory
  bool open_ = false;
  std::atomic<bool> lost_ = false, rejected_ = false;
  std::atomic<int> descriptor_ = -1;
  LentMemory lent_;
  BorrowedMemory borrowed_;
  bool may_lend_ = false;  ///< the other end can access the memory
};

}  // namespace

std::unique_ptr<Transport> connect_socket(const std::string& address, const std::optional<CurveKeys>& keys) {
  return std::make_unique<Socket>(address, keys);
}

}  // namespace poretwin::coupling
