// The transports on their own: the in-process one message by message, the sockets against claims of size.
#include "common/coupling/transport.hpp"
#include "common/coupling/shared_memory.hpp"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>
#include <zmq.hpp>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <numeric>

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

/// Memory is not taken on a stranger's word: the connection that claims a terabyte is closed, the next one works.
TEST(SocketTransport, AClaimOfATerabyteEndsItsConnectionOnly) {
  const auto path = std::filesystem::temp_directory_path() / ("poretwin-claim-" + std::to_string(getpid()));
  const auto hub = bind_socket("ipc://" + path.string());
  {
    zmq::context_t context;
    zmq::socket_t stranger(context, zmq::socket_type::stream);
    stranger.set(zmq::sockopt::linger, 0);
    stranger.set(zmq::sockopt::reconnect_ivl, -1);  // else what is left would be said again, to a new connection
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

/// Is that address in memory that two processes can share?
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
  line->send(encode(large(0.0)));  // before the two know each other: through the socket
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
    if (k % 4 == 1) kept.push_back(*frames);  // as one who is slow to let go: no message waits for another's memory
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

/// What names memory is believed only where it is memory made for this.
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
  // Memory that could become shorter under the reader.
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
