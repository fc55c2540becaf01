#include "common/tiles/heartbeat.hpp"

#include "common/core/error.hpp"
#include "common/output/build_info.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <random>
#include <thread>

namespace poretwin::tiles {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

/// Often enough that several datagrams may be lost, too rarely to cost anything.
constexpr milliseconds between_beats{250};
/// All ranks end within some 3 s after one has stopped: mpirun takes up to a second to end them.
constexpr milliseconds longest_silence{2000};

struct Beat {
  std::uint64_t run;  ///< a random number that only the ranks of this run know
  std::uint64_t step;
  std::int32_t rank;
  std::int32_t ends;  ///< 1: the last one
};

struct Place {
  std::array<char, 256> host{};
  std::uint16_t port = 0;  ///< in the order of the network
};

std::optional<sockaddr_in> address_of(const Place& place, bool one_machine) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = place.port;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (one_machine) return address;
  addrinfo hints{}, *found = nullptr;
  hints.ai_family = AF_INET;
  hints.ai_socktype = SOCK_DGRAM;
  if (::getaddrinfo(place.host.data(), nullptr, &hints, &found) != 0 || found == nullptr) return std::nullopt;
  address.sin_addr =
      reinterpret_cast<const sockaddr_in*>(found->ai_addr)->sin_addr;  // NOLINT: the interface of sockets
  ::freeaddrinfo(found);
  return address;
}

class Socket {
 public:
  explicit Socket(bool one_machine) : file_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(one_machine ? INADDR_LOOPBACK : INADDR_ANY);
    socklen_t size = sizeof address;
    auto* const any = reinterpret_cast<sockaddr*>(&address);  // NOLINT: the interface of sockets
    if (file_ < 0 || ::bind(file_, any, size) != 0 || ::getsockname(file_, any, &size) != 0)
      throw PeerError("no socket for the signs of life between ranks can be opened (UDP)");
    port_ = address.sin_port;
  }
  ~Socket() { ::close(file_); }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

  [[nodiscard]] std::uint16_t port() const { return port_; }
  void send(const Beat& beat, const sockaddr_in& to) const {
    const auto* const any = reinterpret_cast<const sockaddr*>(&to);  // NOLINT: the interface of sockets
    // What cannot be sent counts as silence.
    static_cast<void>(::sendto(file_, &beat, sizeof beat, MSG_DONTWAIT, any, sizeof to));
  }
  [[nodiscard]] std::optional<Beat> next(milliseconds patience) const {
    pollfd waiting{file_, POLLIN, 0};
    if (::poll(&waiting, 1, static_cast<int>(patience.count())) <= 0) return std::nullopt;
    Beat beat{};
    if (::recv(file_, &beat, sizeof beat, MSG_DONTWAIT) != sizeof beat) return std::nullopt;
    return beat;
  }

 private:
  int file_;
  std::uint16_t port_ = 0;
};

bool on_one_machine(const Communicator& all) {
  const std::string own = host();
  const char same = all.from_first(own) == own ? 1 : 0;
  const auto everywhere = all.gather(std::span<const char>(&same, 1));
  return std::all_of(everywhere.begin(), everywhere.end(), [](char one) { return one == 1; });
}

}  // namespace

class Heartbeat::Pulse {
 public:
  explicit Pulse(const Communicator& all) : all_(all), one_machine_(on_one_machine(all)), socket_(one_machine_) {
    Place own;
    host().copy(own.host.data(), own.host.size() - 1);
    own.port = socket_.port();
    const auto places = all.gather(std::span<const Place>(&own, 1));
    std::random_device random;
    run_ = std::stoull(all.from_first(std::to_string(std::uint64_t{random()} << 32U | random())));
    const int size = all.size();
    previous_ = (all.rank() + size - 1) % size;
    previous_host_ = places[static_cast<std::size_t>(previous_)].host.data();
    const Place& next = places[static_cast<std::size_t>((all.rank() + 1) % size)];
    next_ = address_of(next, one_machine_);
    if (!next_)
      fmt::print(stderr, "rank {}: the name of machine {} cannot be resolved: no signs of life are sent to it\n",
                 all.rank(), next.host.data());
    // Who hears nothing, since nothing is sent, does not listen.
    const char sends = next_ ? 1 : 0;
    listens_ = all.gather(std::span<const char>(&sends, 1))[static_cast<std::size_t>(previous_)] == 1;
    // Signals are for the thread that computes.
    sigset_t every, before;
    sigfillset(&every);
    pthread_sigmask(SIG_SETMASK, &every, &before);
    thread_ = std::thread([this] { beat(); });
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
  }
  ~Pulse() {
    ends_ = true;
    thread_.join();
  }
  Pulse(const Pulse&) = delete;
  Pulse& operator=(const Pulse&) = delete;

 private:
  void beat() {
    auto heard = Clock::now(), sent = heard - between_beats, awake = heard;
    std::uint64_t step = 0;
    while (!ends_) {
      const auto now = Clock::now();
      // This process was stopped, and perhaps all were.
      if (now - awake > 4 * between_beats) heard = now;
      awake = now;
      if (now - sent >= between_beats) {
        send(false);
        sent = now;
      }
      if (const auto beat = socket_.next(between_beats / 5); beat && beat->run == run_ && beat->rank == previous_) {
        heard = now;
        step = beat->step;
        if (beat->ends != 0) listens_ = false;
      }
      if (listens_ && now - heard > longest_silence) give_up(step);
    }
    send(true);
  }

  void send(bool ends) const {
    if (next_) socket_.send({run_, all_.step(), all_.rank(), ends ? 1 : 0}, *next_);
  }

  [[noreturn]] void give_up(std::uint64_t step) const {
    const std::string text = fmt::format(
        "rank {} of {}: error: rank {} (tile {}) on {} has given no sign of life for {} s; the last one came in "
        "step {}: it was stopped, or its machine or network is gone. Resume from the last checkpoint\n",
        all_.rank(), all_.size(), previous_, previous_, previous_host_,
        static_cast<double>(longest_silence.count()) / 1000.0, step);
    std::fputs(text.c_str(), stderr);
    std::fflush(stderr);
    // MPI is the computing thread's, which waits for the rank that is silent. mpirun ends the others.
    std::_Exit(static_cast<int>(ExitCode::peer));
  }

  const Communicator& all_;
  bool one_machine_;
  Socket socket_;
  std::uint64_t run_ = 0;
  int previous_ = 0;
  std::string previous_host_;
  std::optional<sockaddr_in> next_;
  bool listens_ = true;
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

Heartbeat::Heartbeat(const Communicator& all) {
  if (all.size() > 1) pulse_ = std::make_unique<Pulse>(all);
}
Heartbeat::~Heartbeat() = default;

}  // namespace poretwin::tiles
