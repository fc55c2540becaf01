// A line with latency, simulated by a relay on this host that forwards bytes after a delay.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <deque>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace poretwin::testing_tools {

class SlowLine {
 public:
  /// Listens on a port and forwards to `behind`, "tcp://127.0.0.1:port".
  SlowLine(const std::string& behind, std::chrono::milliseconds delay)
      : delay_(delay), port_behind_(static_cast<std::uint16_t>(std::stoi(behind.substr(behind.rfind(':') + 1)))) {
    listener_ = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in where = loopback(0);
    socklen_t size = sizeof where;
    if (::bind(listener_, reinterpret_cast<sockaddr*>(&where), size) != 0 || ::listen(listener_, 8) != 0 ||
        ::getsockname(listener_, reinterpret_cast<sockaddr*>(&where), &size) != 0)
      throw std::runtime_error("the relay found no port");
    address_ = "tcp://127.0.0.1:" + std::to_string(ntohs(where.sin_port));
    thread_ = std::thread([this] { relay(); });
  }
  ~SlowLine() {
    stop_ = true;
    thread_.join();
    for (const auto& way : ways_) ::close(way.from);
    ::close(listener_);
  }
  SlowLine(const SlowLine&) = delete;
  SlowLine& operator=(const SlowLine&) = delete;

  [[nodiscard]] const std::string& address() const { return address_; }

 private:
  using Clock = std::chrono::steady_clock;
  /// One direction of one connection.
  struct Way {
    int from, to;
    bool closed = false;
    std::deque<std::pair<Clock::time_point, std::string>> under_way = {};
  };

  static sockaddr_in loopback(std::uint16_t port) {
    sockaddr_in where{};
    where.sin_family = AF_INET;
    where.sin_port = htons(port);
    where.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    return where;
  }

  void relay() {
    while (!stop_) {
      std::vector<pollfd> waiting{{listener_, POLLIN, 0}};
      for (const auto& way : ways_) waiting.push_back({way.closed ? -1 : way.from, POLLIN, 0});
      ::poll(waiting.data(), waiting.size(), 1);
      for (std::size_t k = 0; k < ways_.size(); ++k)
        if (waiting[k + 1].revents != 0) read(ways_[k]);
      for (auto& way : ways_) pass_on(way);
      if (waiting[0].revents != 0) accept();
    }
  }

  void accept() {
    const int near = ::accept(listener_, nullptr, nullptr), far = ::socket(AF_INET, SOCK_STREAM, 0), yes = 1;
    sockaddr_in where = loopback(port_behind_);
    if (near < 0 || ::connect(far, reinterpret_cast<sockaddr*>(&where), sizeof where) != 0) {
      ::close(near);
      ::close(far);
      return;
    }
    for (const int end : {near, far}) ::setsockopt(end, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    ways_.push_back({near, far});
    ways_.push_back({far, near});
  }

  void read(Way& way) {
    char buffer[65536];
    const auto n = ::recv(way.from, buffer, sizeof buffer, 0);
    way.closed = n <= 0;
    way.under_way.emplace_back(Clock::now() + delay_, n > 0 ? std::string(buffer, static_cast<std::size_t>(n)) : "");
  }

  /// Forwards what has been delayed long enough; an empty piece means the end.
  static void pass_on(Way& way) {
    while (!way.under_way.empty() && way.under_way.front().first <= Clock::now()) {
      const std::string& bytes = way.under_way.front().second;
      if (bytes.empty()) ::shutdown(way.to, SHUT_WR);
      for (std::size_t sent = 0; sent < bytes.size();) {
        const auto n = ::send(way.to, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
        if (n <= 0) break;
        sent += static_cast<std::size_t>(n);
      }
      way.under_way.pop_front();
    }
  }

  std::chrono::milliseconds delay_;
  std::uint16_t port_behind_;
  int listener_ = -1;
  std::string address_;
  std::vector<Way> ways_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace poretwin::testing_tools
