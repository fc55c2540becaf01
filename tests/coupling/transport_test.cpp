// The transports on their own: the in-process one message by message, the sockets against claims of size.
#include "common/coupling/transport.hpp"

#include <gtest/gtest.h>
#include <unistd.h>
#include <zmq.hpp>

#include <cstring>
#include <filesystem>

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

}  // namespace
}  // namespace poretwin::coupling
