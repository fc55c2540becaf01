// The transports alone: the in-process one message by message, the sockets against false sizes.
#include "common/coupling/transport.hpp"
#include "common/coupling/shared_memory.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>
#include <zmq.hpp>

#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <numeric>
#include <thread>

namespace poretwin::coupling {
namespace {

constexpr Milliseconds at_once{0}, soon{2000};

Frames numbered(std::uint64_t step) { return encode(message_of(Heartbeat{}, step)); }

std::uint64_t step_of(const std::optional<Frames>& frames) { return frames ? decode(*frames).step : 0; }

TEST(InProcessTransport, PausesAndAllowsMessageByMessage) {
  InProcess process;
  const auto hub = process.hub();
  const auto line = process.line();
  process.pause();
  for (std::uint64_t k = 1; k <= 3; ++k) line->send(numbered(k));
  EXPECT_FALSE(hub->receive(at_once));
  process.allow(2);
  auto first = hub->receive(at_once);
  ASSERT_TRUE(first);
  EXPECT_EQ(step_of(first->frames), 1u);
  hub->send(first->line, numbered(9));
  EXPECT_EQ(step_of(line->receive(at_once)), 9u);  // either way counts
  EXPECT_FALSE(hub->receive(at_once));
  process.resume();
  EXPECT_EQ(step_of(hub->receive(at_once)->frames), 2u);
  EXPECT_EQ(step_of(hub->receive(at_once)->frames), 3u);
}

TEST(InProcessTransport, AHaltedOneLosesEverythingAndTellsNobody) {
  InProcess process;
  const auto hub = process.hub();
  const auto line = process.line();
  line->send(numbered(1));
  const auto event = hub->receive(at_once);
  ASSERT_TRUE(event);
  process.halt();
  line->send(numbered(2));
  EXPECT_FALSE(hub->receive(at_once));
  EXPECT_TRUE(hub->send(event->line, numbered(3)));
  EXPECT_FALSE(line->receive(at_once));
  EXPECT_FALSE(line->lost());
}

/// A stranger's announced size is not allocated: its connection, which claims a terabyte, is closed, and the next one
/// works.
TEST(SocketTransport, AClaimOfATerabyteEndsItsConnectionOnly) {
  const auto path = std::filesystem::temp_directory_path() / ("poretwin-claim-" + std::to_string(getpid()));
  const auto hub = bind_socket("ipc://" + path.string());
  {
    zmq::context_t context;
    zmq::socket_t stranger(context, zmq::socket_type::stream);
    stranger.set(zmq::sockopt::linger, 0);
    stranger.set(zmq::sockopt::reconnect_ivl, -1);  // else unsent data would be sent again, on a new connection
    stranger.set(zmq::sockopt::rcvtimeo, 2000);
    stranger.connect(hub->address());
    zmq::message_t id, nothing;
    ASSERT_TRUE(stranger.recv(id));
    ASSERT_TRUE(stranger.recv(nothing));
    const auto say = [&](const std::string& bytes) {
      stranger.send(zmq::buffer(id.data(), id.size()), zmq::send_flags::sndmore);
      stranger.send(zmq::buffer(bytes), zmq::send_flags::none);
    };
    // ZMTP 3.0: greeting, READY as a DEALER, then a frame with an eight-byte length.
    std::string greeting("\xff\0\0\0\0\0\0\0\x01\x7f\x03\0NULL", 16);
    greeting.resize(64, '\0');
    say(greeting);
    const std::string ready(
        "\x05READY\x0bSocket-Type\0\0\0\x06"
        "DEALER",
        28);
    say(std::string("\x04", 1) + static_cast<char>(ready.size()) + ready);
    say(std::string("\x02\0\0\x01\0\0\0\0\0", 9));  // 2^40 bytes to come
    say(std::string(1000, 'x'));
    EXPECT_FALSE(hub->receive(Milliseconds(500)));
  }
  const auto line = connect_socket(hub->address());
  line->send(numbered(7));
  const auto event = hub->receive(soon);
  ASSERT_TRUE(event);
  EXPECT_EQ(step_of(event->frames), 7u);
  std::filesystem::remove(path);
}

/// A connection to a hub's port without ZeroMQ.
class RawConnection {
 public:
  explicit RawConnection(const std::string& address) : descriptor_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    to.sin_port = htons(static_cast<std::uint16_t>(std::stoi(address.substr(address.rfind(':') + 1))));
    open_ = ::connect(descriptor_, reinterpret_cast<sockaddr*>(&to), sizeof to) == 0;
    const timeval patience{5, 0};
    ::setsockopt(descriptor_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    ::setsockopt(descriptor_, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
  }
  RawConnection(const RawConnection&) = delete;
  RawConnection& operator=(const RawConnection&) = delete;
  ~RawConnection() { ::close(descriptor_); }
  [[nodiscard]] bool open() const { return open_; }
  [[nodiscard]] bool send(const std::string& bytes) const {
    for (std::size_t at = 0; at < bytes.size();) {
      const auto count = ::send(descriptor_, bytes.data() + at, bytes.size() - at, MSG_NOSIGNAL);
      if (count <= 0) return false;
      at += static_cast<std::size_t>(count);
    }
    return true;
  }
  /// Whether the other end has closed the connection in time.
  [[nodiscard]] bool ended() const {
    std::array<char, 4096> bytes{};
    for (;;) {
      const auto count = ::recv(descriptor_, bytes.data(), bytes.size(), 0);
      if (count == 0) return true;
      if (count < 0) return errno != EAGAIN && errno != EWOULDBLOCK;
    }
  }
  /// Sends the greeting of a DEALER, ZMTP 3.0.
  [[nodiscard]] bool greet() const {
    std::string greeting("\xff\0\0\0\0\0\0\0\x01\x7f\x03\0NULL", 16);
    greeting.resize(64, '\0');
    const std::string ready(
        "\x05READY\x0bSocket-Type\0\0\0\x06"
        "DEALER",
        28);
    return send(greeting + std::string("\x04", 1) + static_cast<char>(ready.size()) + ready);
  }

 private:
  int descriptor_;
  bool open_ = false;
};

class Strangers : public testing::Test {
 protected:
  /// Collects what the hub reports within a time, or until it is enough: closings and messages by line.
  void listen(Milliseconds time, const std::function<bool()>& enough = [] { return false; }) {
    const auto end = std::chrono::steady_clock::now() + time;
    while (std::chrono::steady_clock::now() < end && !enough()) {
      if (auto event = hub_->receive(Milliseconds(10))) {
        if (event->frames.empty())
          closed_.push_back(event->line);
        else
          heard_.push_back(std::move(*event));
      }
      if (auto said = hub_->notice(); !said.empty()) notices_ += said + "\n";
    }
  }
  /// A line that the hub treats as a participant's.
  std::unique_ptr<Transport> participant() {
    auto line = connect_socket(hub_->address());
    line->send(numbered(1));
    for (int k = 0; k < 1000; ++k)
      if (auto event = hub_->receive(Milliseconds(10)); event && !event->frames.empty()) {
        participant_ = event->line;
        hub_->regard(event->line, Hub::Standing::participant);
        return line;
      }
    ADD_FAILURE() << "the participant is not heard";
    return line;
  }
  void expect_heard(Transport& line) {
    line.send(numbered(42));
    heard_.clear();
    const auto heard = [&] {
      return std::any_of(heard_.begin(), heard_.end(), [&](const auto& e) {
        return e.line == participant_ && decode(e.frames).step == 42;
      });
    };
    listen(Milliseconds(10'000), heard);
    EXPECT_TRUE(heard());
    EXPECT_EQ(std::count(closed_.begin(), closed_.end(), participant_), 0);
  }
  static std::size_t descriptors() {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {}));
  }

  std::unique_ptr<Hub> hub_ = bind_socket("tcp://127.0.0.1:*", false, {}, Callers::anybody);
  std::vector<Hub::Event> heard_;
  std::vector<std::string> closed_;
  std::string notices_, participant_;
};

TEST_F(Strangers, AParticipantMaySendWhatItLikes) {
  const auto line = participant();
  for (int k = 0; k < 100; ++k) line->send(encode(message_of(Heartbeat{std::string(100'000, 'x'), "", 0.0, false})));
  listen(Milliseconds(10'000), [&] { return heard_.size() == 100; });
  EXPECT_EQ(heard_.size(), 100u);
  EXPECT_EQ(notices_, "");
}

TEST_F(Strangers, AFloodOfMessagesEndsItsConnection) {
  const auto line = participant();
  zmq::context_t context;
  zmq::socket_t stranger(context, zmq::socket_type::dealer);
  stranger.set(zmq::sockopt::linger, 0);
  stranger.set(zmq::sockopt::reconnect_ivl, -1);
  stranger.connect(hub_->address());
  for (int k = 0; k < 20'000; ++k) stranger.send(zmq::buffer(std::string("hello")), zmq::send_flags::dontwait);
  listen(Milliseconds(1000));
  EXPECT_LE(heard_.size(), 20u);
  EXPECT_NE(notices_.find("sent more than 20 messages"), std::string::npos) << notices_;
  expect_heard(*line);
}

/// A message of endless parts: ZeroMQ would store them all and report nothing.
TEST_F(Strangers, AMessageWithoutEndEndsItsConnection) {
  const auto line = participant();
  const RawConnection stranger(hub_->address());
  ASSERT_TRUE(stranger.greet());
  const std::string part = std::string("\x03\0\0\0\0\0\x10\0\0", 9) + std::string(1 << 20, 'x');  // 1 MB, more to come
  int sent = 0;
  while (sent < 500 && stranger.send(part)) ++sent;
  EXPECT_LT(sent, 200);
  EXPECT_TRUE(stranger.ended());
  listen(Milliseconds(100));
  EXPECT_NE(notices_.find("sent more than 1048576 bytes"), std::string::npos) << notices_;
  expect_heard(*line);
}

TEST_F(Strangers, ConnectionsThatSayNothingDoNotUseUpDescriptors) {
  const auto line = participant();
  const auto before = descriptors();
  std::vector<std::unique_ptr<RawConnection>> idle;
  for (int k = 0; k < 400; ++k) {
    idle.push_back(std::make_unique<RawConnection>(hub_->address()));
    ASSERT_TRUE(idle.back()->open());
  }
  listen(Milliseconds(300));
  EXPECT_LE(descriptors() - before, 400u + 140u) << "its own ends, and at most 128 of the hub's";
  EXPECT_TRUE(idle.front()->ended());
  expect_heard(*line);
  auto other = connect_socket(hub_->address());  // a connection after that is admitted
  heard_.clear();
  other->send(numbered(7));
  listen(Milliseconds(10'000), [&] { return !heard_.empty(); });
  ASSERT_EQ(heard_.size(), 1u);
  EXPECT_EQ(decode(heard_.front().frames).step, 7u);
}

/// Descriptors are reused at once: the closing of another connection must not be taken for the participant's.
TEST_F(Strangers, AScannersLeavingIsNotTakenForAParticipants) {
  std::atomic<bool> stop = false;
  std::thread scanner([&] {
    while (!stop) RawConnection(hub_->address());
  });
  for (int k = 0; k < 20; ++k) {
    closed_.clear();
    const auto line = participant();
    expect_heard(*line);
  }
  stop = true;
  scanner.join();
}

/// A stranger that is refused sends messages and leaves; the participant's connection gets its descriptor before the
/// hub has read them.
TEST_F(Strangers, WhatOneLeavesUnreadIsNotHeldAgainstTheNext) {
  constexpr Milliseconds soon_done(100);  // for the hub's own thread to receive or notice something
  const auto speak = [&](const RawConnection& connection, const std::string& text) {
    ASSERT_TRUE(connection.greet());
    std::this_thread::sleep_for(soon_done);  // messages that come before the hub's own greeting end a connection
    ASSERT_TRUE(connection.send(std::string(1, '\0') + static_cast<char>(text.size()) + text));
    std::this_thread::sleep_for(soon_done);
  };
  const auto text_of = [](const Hub::Event& event) {
    return event.frames.empty() ? "" : std::string(event.frames[0].data, event.frames[0].size);
  };
  {
    const RawConnection stranger(hub_->address());
    speak(stranger, "hello");
  }
  std::this_thread::sleep_for(soon_done);
  const RawConnection participant(hub_->address());
  speak(participant, "it is I");
  std::string line;
  for (int k = 0; k < 100; ++k) {
    const auto event = hub_->receive(Milliseconds(5));
    if (!event || event->frames.empty()) continue;
    const bool joins = text_of(*event) == "it is I";
    hub_->regard(event->line, joins ? Hub::Standing::participant : Hub::Standing::refused);
    if (joins) line = event->line;
  }
  ASSERT_NE(line, "");
  listen(Milliseconds(1500));  // longer than one who was refused may stay
  EXPECT_TRUE(participant.send(std::string("\0\x0fI am still here", 17)));
  const auto heard = [&] {
    return std::any_of(heard_.begin(), heard_.end(),
                       [&](const auto& e) { return e.line == line && text_of(e) == "I am still here"; });
  };
  listen(Milliseconds(2000), heard);
  EXPECT_TRUE(heard());
  EXPECT_EQ(std::count(closed_.begin(), closed_.end(), line), 0);
}

TEST_F(Strangers, AnotherUserOfTheMachineIsNotLetIn) {
  if (::geteuid() != 0) GTEST_SKIP() << "no other user can be played here";
  const std::string address = hub_->address();
  const pid_t child = ::fork();
  if (child == 0) {
    if (::setuid(65534) != 0) ::_exit(3);
    const RawConnection other(address);
    static_cast<void>(other.greet());
    ::_exit(other.ended() ? 0 : 1);
  }
  listen(Milliseconds(500));
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), 0);
  EXPECT_NE(notices_.find("somebody of user 65534 was not let in"), std::string::npos) << notices_;
  const auto line = participant();
  expect_heard(*line);
}

/// Whether an address is in memory that two processes can share.
bool is_shared(const void* address) {
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    std::uintptr_t from = 0, to = 0;
    if (std::sscanf(line.c_str(), "%lx-%lx", &from, &to) == 2 && reinterpret_cast<std::uintptr_t>(address) >= from &&
        reinterpret_cast<std::uintptr_t>(address) < to)
      return line.find("/memfd:poretwin") != std::string::npos;
  }
  return false;
}

Message large(double first, std::size_t n = 100'000) {
  Message message = message_of(PublicationBody{}, 1);
  std::vector<double> values(n);
  std::iota(values.begin(), values.end(), first);
  message.arrays = {{"many", "Pa", 1, values}, {"none", "Pa", 1, {}}, {"few", "m", 2, {first, 2.0}}};
  return message;
}

void expect_large(Message message, double first, std::size_t n = 100'000) {
  ASSERT_EQ(message.arrays.size(), 3u);
  const auto sent = large(first, n);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_TRUE(message.arrays[k].take() == sent.arrays[k].values) << k;
}

class SharedMemory : public testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove(path_); }
  std::filesystem::path path_ =
      std::filesystem::temp_directory_path() / ("poretwin-shared-" + std::to_string(getpid()));
};

TEST_F(SharedMemory, LargeFramesLieThereEitherWay) {
  const auto hub = bind_socket("ipc://" + path_.string());
  const auto line = connect_socket(hub->address());
  line->send(encode(large(0.0)));  // through the socket: no memory agreed on yet
  auto event = hub->receive(soon);
  ASSERT_TRUE(event);
  EXPECT_FALSE(is_shared(event->frames[1].data));
  expect_large(decode(event->frames), 0.0);
  std::vector<Frames> kept;
  bool from_line = false, from_hub = false;
  for (int k = 1; k < 20; ++k) {
    hub->send(event->line, encode(large(k)));
    auto frames = line->receive(soon);
    ASSERT_TRUE(frames);
    from_hub = is_shared((*frames)[1].data);
    expect_large(decode(*frames), k);
    if (k % 4 == 1) kept.push_back(*frames);  // as a slow receiver: no message waits for the memory of another
    line->send(encode(large(-k, 100'000 + 5'000 * static_cast<std::size_t>(k))));
    const auto answer = hub->receive(soon);
    ASSERT_TRUE(answer);
    from_line = is_shared(answer->frames[1].data);
    expect_large(decode(answer->frames), -k, 100'000 + 5'000 * static_cast<std::size_t>(k));
  }
  EXPECT_TRUE(from_line);
  EXPECT_FALSE(from_hub) << "four messages are kept: the fifth has no memory left";
  for (std::size_t k = 0; k < kept.size(); ++k) expect_large(decode(kept[k]), 1.0 + 4.0 * static_cast<double>(k));
  kept.clear();
  hub->send(event->line, encode(large(7.0)));
  const auto again = line->receive(soon);
  ASSERT_TRUE(again);
  EXPECT_TRUE(is_shared((*again)[1].data));
}

TEST_F(SharedMemory, StrangersAndKeysDoWithout) {
  const auto hub = bind_socket("ipc://" + path_.string());
  zmq::context_t context;
  zmq::socket_t stranger(context, zmq::socket_type::dealer);
  stranger.set(zmq::sockopt::linger, 0);
  stranger.set(zmq::sockopt::rcvtimeo, 2000);
  stranger.connect(hub->address());
  for (int k = 0; k < 2; ++k) {
    stranger.send(zmq::buffer(std::string("hello")), zmq::send_flags::none);
    const auto event = hub->receive(soon);
    ASSERT_TRUE(event);
    ASSERT_TRUE(hub->send(event->line, encode(large(1.0))));
    zmq::message_t head, many;
    ASSERT_TRUE(stranger.recv(head));
    ASSERT_TRUE(stranger.recv(many));
    EXPECT_EQ(many.size(), 800'000u);
    while (many.more()) ASSERT_TRUE(stranger.recv(many));
  }
}

/// A name of memory is accepted only where it refers to memory made for this purpose.
TEST_F(SharedMemory, LiesAreNotFollowed) {
  LentMemory lent;
  const auto name = lent.name();
  ASSERT_TRUE(name);
  BorrowedMemory borrowed;
  EXPECT_TRUE(borrowed.reaches(*name));
  BorrowedMemory fresh;
  EXPECT_FALSE(fresh.reaches({name->process, name->descriptor, name->token + 1}));
  EXPECT_FALSE(fresh.reaches({name->process, 1 << 20, name->token}));
  EXPECT_FALSE(fresh.reaches({name->process, 0, name->token}));
  EXPECT_FALSE(fresh.reaches({-1, name->descriptor, name->token}));
  // Memory that could become shorter during a read.
  const int open = ::memfd_create("poretwin", MFD_CLOEXEC);
  ASSERT_EQ(::ftruncate(open, 4096), 0);
  EXPECT_FALSE(fresh.reaches({getpid(), open, 0}));
  ::close(open);

  const Frames good = lent.lend(encode(large(3.0)));
  ASSERT_EQ(good.size(), 5u);
  const std::string table(good.front().data, good.front().size);
  const auto with_table = [&](const std::string& bytes) {
    Frames frames = good;
    frames.front() = Frame::of(bytes);
    return frames;
  };
  for (const std::size_t where : {table.size() - 24, table.size() - 16, table.size() - 8})
    for (const std::uint64_t size : {~std::uint64_t{0}, std::uint64_t{1} << 40, ~std::uint64_t{0} - 62}) {
      std::string lie = table;
      std::memcpy(lie.data() + where, &size, sizeof size);
      const auto left = borrowed.borrow(with_table(lie));
      EXPECT_TRUE(sharing::is_table(left));
      EXPECT_THROW(decode(left), PeerError);
    }
  for (const std::size_t length : {std::size_t{16}, table.size() - 8, table.size() - 1, table.size() - 25})
    EXPECT_TRUE(sharing::is_table(borrowed.borrow(with_table(table.substr(0, length))))) << length;
  expect_large(decode(borrowed.borrow(good)), 3.0);
}

}  // namespace
}  // namespace poretwin::coupling
