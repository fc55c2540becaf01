// A DEALER socket behind the Transport interface. One thread owns the socket; the others meet it at two queues.
#include "common/coupling/shared_memory.hpp"
#include "common/coupling/socket_options.hpp"
#include "common/coupling/transport.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <atomic>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>

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
    } catch (const zmq::error_t& error) {
      ::close(wake_);
      throw Error(ExitCode::bad_case,
                  "cannot connect to '" + address_ + "': " + error.what() +
                      "; expected an address such as ipc:///tmp/run/socket or tcp://127.0.0.1:5555");
    }
    thread_ = std::thread([this] { run(); });
  }

  ~Socket() override {
    {
      const std::lock_guard lock(mutex_);
      stopping_ = true;
    }
    wake();
    thread_.join();
    ::close(wake_);
  }

  void send(Frames frames) override {
    {
      // Held until it is in the queue: what is sent in one order arrives in it.
      const std::lock_guard sending(sending_);
      if (may_lend_) frames = lent_.lend(std::move(frames));
      const std::lock_guard lock(mutex_);
      out_.push_back(std::move(frames));
    }
    wake();
  }

  std::optional<Frames> receive(Milliseconds timeout) override {
    std::unique_lock lock(mutex_);
    arrived_.wait_for(lock, timeout, [&] { return !in_.empty() || lost_; });
    if (in_.empty()) return std::nullopt;
    Frames frames = std::move(in_.front());
    in_.pop_front();
    return frames;
  }

  bool lost() const override { return lost_; }
  std::string trouble() const override {
    return rejected_
               ? "somebody answers there, but the two do not come to terms: are these the keys that `poretwin keys` "
                 "made together, on both sides or on none?"
               : "";
  }
  bool cut() const override { return unacknowledged(descriptor_); }
  std::string address() const override { return address_; }

 private:
  void wake() const {
    const std::uint64_t one = 1;
    // The counter cannot overflow in practice, and a full one wakes as well.
    [[maybe_unused]] const auto written = ::write(wake_, &one, sizeof one);
  }

  void run() {
    bool open = false;
    for (;;) {
      std::array<zmq::pollitem_t, 3> items{{{dealer_.handle(), 0, ZMQ_POLLIN, 0},
                                            {monitor_.handle(), 0, ZMQ_POLLIN, 0},
                                            {nullptr, wake_, ZMQ_POLLIN, 0}}};
      if (!poll_all(items, Milliseconds(1000))) break;
      std::uint64_t count = 0;
      [[maybe_unused]] const auto got = ::read(wake_, &count, sizeof count);
      const bool stop = send_queued();
      receive_ready();
      while (const auto event = next_event(monitor_)) {
        if (event->kind == ZMQ_EVENT_CONNECTED) descriptor_ = event->value;
        if (event->kind == ZMQ_EVENT_HANDSHAKE_SUCCEEDED) {
          open = true;
          rejected_ = false;
        } else if (event->kind != ZMQ_EVENT_CONNECTED && !open) {
          rejected_ = true;
        }
        if (event->kind == ZMQ_EVENT_DISCONNECTED && open) {
          receive_ready();
          const std::lock_guard lock(mutex_);
          lost_ = true;
          arrived_.notify_all();
        }
      }
      if (stop) break;
    }
    if (!open || lost_) dealer_.set(zmq::sockopt::linger, 0);  // there is nobody to hear the rest
    dealer_.close();
    monitor_.close();
  }

  bool send_queued() {
    std::deque<Frames> batch;
    bool stop = false;
    {
      const std::lock_guard lock(mutex_);
      batch.swap(out_);
      stop = stopping_;
    }
    for (auto& frames : batch) send_frames(dealer_, std::move(frames));
    return stop;
  }

  void receive_ready() {
    while (auto frames = receive_frames(dealer_)) {
      if (const auto name = sharing::read_offer(*frames)) {
        may_lend_ = true;
        if (borrowed_.reaches(*name)) send_frames(dealer_, sharing::accept());
        continue;
      }
      auto message = borrowed_.borrow(std::move(*frames));
      const std::lock_guard lock(mutex_);
      in_.push_back(std::move(message));
      arrived_.notify_all();
    }
  }

  std::string address_;
  int wake_;
  zmq::context_t context_{1};
  zmq::socket_t dealer_, monitor_;
  mutable std::mutex mutex_;
  std::condition_variable arrived_;
  std::deque<Frames> in_, out_;
  bool stopping_ = false;
  std::atomic<bool> lost_ = false, rejected_ = false;
  std::atomic<int> descriptor_ = -1;
  std::mutex sending_;
  LentMemory lent_;
  std::atomic<bool> may_lend_ = false;  ///< the other end has said that it reaches it
  BorrowedMemory borrowed_;             ///< the thread's
  std::thread thread_;
};

}  // namespace

std::unique_ptr<Transport> connect_socket(const std::string& address, const std::optional<CurveKeys>& keys) {
  return std::make_unique<Socket>(address, keys);
}

}  // namespace poretwin::coupling
