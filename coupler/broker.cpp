#include "coupler/broker.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <deque>
#include <map>
#include <random>
#include <sstream>
#include <utility>

namespace poretwin::coupling {
namespace {

using Clock = std::chrono::steady_clock;
constexpr std::array<Role, 2> both = {Role::fluid, Role::solid};

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

std::size_t bytes_of(const Frames& frames) {
  std::size_t bytes = 0;
  for (const auto& frame : frames) bytes += frame.size;
  return bytes;
}

std::string new_session() {
  std::random_device source;
  return fmt::format("{:08x}{:08x}", source(), source());
}

/// A stranger's text in a form fit for the log: short, on one line.
std::string shown(std::string text, std::size_t most = 64) {
  if (text.size() > most) text = text.substr(0, most) + "..";
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c >= 0x7f; }, '?');
  return text;
}

/// The first difference between the fields that one side gives and the fields that the other takes; empty if none.
std::optional<Reject> difference(const Contract& giver, const Contract& taker) {
  auto differs = [](const std::string& field, std::string expected, std::string got) {
    return Reject{RejectCode::field, field, std::move(expected), std::move(got), 0.0, ""};
  };
  auto given = [&](const std::string& name) {
    return std::find_if(giver.gives.begin(), giver.gives.end(), [&](const FieldSpec& s) { return s.name == name; });
  };
  for (const auto& want : taker.takes) {
    const auto have = given(want.name);
    if (have == giver.gives.end()) return differs(want.name, "a giver of this field", "none");
    if (have->unit != want.unit) return differs(want.name, "unit " + have->unit, "unit " + want.unit);
    if (have->components != want.components)
      return differs(want.name, fmt::format("{} components", have->components),
                     fmt::format("{} components", want.components));
    if (have->mapping != want.mapping)
      return differs(want.name, fmt::format("{} mapping", to_string(have->mapping)),
                     fmt::format("{} mapping", to_string(want.mapping)));
    if (have->mask != want.mask) return differs(want.name, "mask '" + have->mask + "'", "mask '" + want.mask + "'");
    if (have->mask.empty()) continue;
    const auto mask = given(have->mask);
    if (mask == giver.gives.end() || mask->components != 1)
      return differs(want.name, "its mask '" + have->mask + "' among the given fields, with one component", "none");
    if (have->mapping != Mapping::consistent)
      return differs(want.name, fmt::format("a {} field without a mask", to_string(have->mapping)),
                     "mask '" + have->mask + "'");
  }
  return std::nullopt;
}

/// The first key that differs between the cases: "water.density: expected 1000, got 900"; empty when unknown.
std::string different_key(const std::string& expected, const std::string& got) {
  if (expected.empty() || got.empty()) return {};
  const auto read = [](const std::string& part) {
    std::map<std::string, std::string> values;
    std::istringstream lines(part);
    for (std::string line; std::getline(lines, line);)
      if (const auto equals = line.find(" = "); equals != std::string::npos)
        values[line.substr(0, equals)] = line.substr(equals + 3);
    return values;
  };
  auto ours = read(expected), theirs = read(got);
  for (const auto& [key, value] : theirs) ours.try_emplace(key, "nothing");
  for (const auto& [key, value] : ours) {
    const auto found = theirs.find(key);
    const std::string other = found == theirs.end() ? "nothing" : found->second;
    if (other != value) return fmt::format("{}: expected {}, got {}", key, value, other);
  }
  return {};
}

struct Peer {
  std::string name;
  std::string line;  ///< empty: not connected
  Contract contract;
  bool keeps_checkpoints = false;
  std::vector<std::string> checkpoints;
  std::deque<Message> queue;
  std::uint64_t sequence = 0, sent = 0;
  Clock::time_point heard;
  std::string last = "none";
  std::string doing;  ///< activity in its last heartbeat
  std::uint64_t step = 0;
  bool left = false;     ///< it has sent BYE, or its connection has closed
  bool noticed = false;  ///< its silence has been reported
};

}  // namespace

class Broker::Implementation {
 public:
  Implementation(Hub& hub, BrokerOptions options) : hub_(hub), options_(std::move(options)), session_(new_session()) {
    for (const Role role : both) peer(role).name = to_string(role);
  }

  void gather() {
    const auto start = Clock::now();
    auto said = start;
    while (true) {
      std::string missing;
      for (const Role role : both)
        if (peer(role).line.empty()) missing += (missing.empty() ? "" : " and ") + peer(role).name;
      if (missing.empty()) return;
      if (interrupted()) throw Error(ExitCode::interrupted, "interrupted while waiting for " + missing);
      if (Clock::now() - start > options_.wait_deadline) {
        culprit_ = missing;
        throw PeerError(fmt::format("{} did not come within {:g} s at {}{}", missing,
                                    static_cast<double>(options_.wait_deadline.count()) / 1000.0, hub_.address(),
                                    refused_.empty() ? "" : "; refused meanwhile: " + refused_));
      }
      if (Clock::now() - said >= options_.say_every) {
        said = Clock::now();
        say(fmt::format("waiting for {} at {} ({:.0f} s)", missing, hub_.address(), seconds_since(start)));
      }
      if (options_.waiting) options_.waiting(missing);
      listen(missing);
    }
  }

  Message wait(Role role) {
    auto& p = peer(role);
    const auto start = Clock::now();
    auto said = start;
    // The time counts even if the participant is lost during the wait.
    const bool fluid = role == Role::fluid;
    const Span span(fluid ? totals_.waiting_for_fluid : totals_.waiting_for_solid, options_.trace,
                    fluid ? "waiting for fluid" : "waiting for solid");
    while (p.queue.empty()) {
      if (Clock::now() - said >= options_.say_every) {
        said = Clock::now();
        say(fmt::format("waiting for {} ({:.0f} s): {}, last message {}", p.name, seconds_since(start), state_of(p),
                        p.last));
      }
      if (options_.waiting) options_.waiting(p.name);
      listen(p.name);
    }
    Message message = std::move(p.queue.front());
    p.queue.pop_front();
    return message;
  }

  void send(Role role, Message message) {
    auto& p = peer(role);
    p.step = std::max(p.step, message.step);
    bool sent = false;
    {
      const Span span(totals_.sending, options_.trace, "sending");
      sent = send_to(p, std::move(message));
    }
    if (!sent) expect_goodbye(p);
  }

  void abort(const Error& error, const std::string& culprit) {
    for (const Role role : both) {
      auto& p = peer(role);
      if (p.line.empty() || p.left) continue;
      try {
        send_to(p, message_of(Abort{culprit, error.what(), error.code()}, p.step));
      } catch (const std::exception&) {  // the other participant must be informed nevertheless
      }
    }
  }

  void say_goodbye() {
    finishing_ = true;
    // Without a deadline: a participant may write output for long, and listen() detects a frozen or dead participant.
    const auto start = Clock::now();
    auto said = start;
    while (!(peer(Role::fluid).left && peer(Role::solid).left)) {
      listen("the last output");
      if (Clock::now() - said < options_.say_every) continue;
      said = Clock::now();
      for (const auto& p : peers_)
        if (!p.left)
          say(fmt::format("waiting for the last output of {} ({:.0f} s): {}", p.name, seconds_since(start),
                          state_of(p)));
    }
  }

  const Contract& contract(Role role) const { return peers_[index(role)].contract; }
  bool keeps_checkpoints(Role role) const { return peers_[index(role)].keeps_checkpoints; }
  const std::vector<std::string>& checkpoints(Role role) const { return peers_[index(role)].checkpoints; }
  void say(const std::string& line) const {
    if (options_.say) options_.say("coupler: " + line);
  }
  bool interrupted() const { return peer_interrupted_ || (options_.interrupted && options_.interrupted()); }
  const BrokerTotals& totals() const { return totals_; }
  const std::string& culprit() const { return culprit_; }

 private:
  static std::size_t index(Role role) { return role == Role::fluid ? 0 : 1; }
  Peer& peer(Role role) { return peers_[index(role)]; }

  std::string state_of(const Peer& p) const {
    const std::string cut = hub_.cut(p.line) ? ", and the line to it is cut or its host is down" : "";
    return (p.doing.empty() ? std::string("no heartbeat yet")
                            : fmt::format("{} ({:.1f} s ago)", p.doing, seconds_since(p.heard))) +
           cut;
  }

  [[noreturn]] void fail(const Peer& p, const std::string& what) {
    culprit_ = p.name;
    throw PeerError(fmt::format("{} {}; at step {}, last message {}, last heartbeat: {}", p.name, what, p.step, p.last,
                                state_of(p)));
  }

  /// Called when a message could not be delivered. Throws unless the participant's goodbye has arrived meanwhile; the
  /// error says if the connection closed without a goodbye.
  void expect_goodbye(const Peer& p) {
    while (auto event = hub_.receive(Milliseconds(0))) handle(std::move(*event));
    if (!p.left) fail(p, "is unreachable: nobody at the end of its line");
  }

  bool send_to(Peer& p, Message message) {
    message.session = session_;
    message.sender = "coupler";
    message.sequence = ++p.sent;
    const bool beat = std::holds_alternative<Heartbeat>(message.body);
    Frames frames = encode(std::move(message));
    if (!beat) {
      ++totals_.messages_sent;
      totals_.bytes_sent += bytes_of(frames);
    }
    return hub_.send(p.line, std::move(frames));
  }

  /// Handles the messages that arrive within a short time, sends heartbeats and checks for frozen participants.
  void listen(const std::string& waiting_for) {
    // The number of messages is limited, so that the caller can check its deadlines and heartbeats are sent in time.
    constexpr int most_at_once = 100;
    int count = 0;
    for (auto event = hub_.receive(std::min(options_.heartbeat, Milliseconds(50))); event;
         event = hub_.receive(Milliseconds(0))) {
      handle(std::move(*event));
      if (++count == most_at_once) break;
    }
    if (const std::string notice = hub_.notice(); !notice.empty()) say(notice);
    if (Clock::now() - beat_ >= options_.heartbeat) send_heartbeats(waiting_for);
    // If this process itself was stopped, or busy with mapping, the participants' silence is not their fault.
    if (Clock::now() - listened_ > std::min(options_.frozen_deadline, options_.frozen_notice) / 2)
      for (auto& p : peers_) p.heard = Clock::now();
    listened_ = Clock::now();
    look_for_frozen();
  }

  void send_heartbeats(const std::string& waiting_for) {
    beat_ = Clock::now();
    for (const Role role : both) {
      auto& p = peer(role);
      if (p.line.empty() || p.left) continue;
      const Heartbeat beat{"waiting", waiting_for == p.name ? "" : waiting_for, 0.0, false};
      if (!send_to(p, message_of(beat, p.step))) expect_goodbye(p);
    }
  }

  void look_for_frozen() {
    for (const Role role : both) {
      auto& p = peer(role);
      if (p.line.empty() || p.left) continue;
      const auto silence = Clock::now() - p.heard;
      if (silence > options_.frozen_notice && !p.noticed) {
        p.noticed = true;
        say(fmt::format(
            "{} {}: no heartbeat for {:.1f} s; at step {}, last message {}, last heartbeat: {}; the run ends "
            "after {:g} s of it",
            p.name, hub_.cut(p.line) ? "is unreachable" : "is frozen (a stopped process?)", seconds_since(p.heard),
            p.step, p.last, state_of(p), static_cast<double>(options_.frozen_deadline.count()) / 1000.0));
      }
      if (silence <= options_.frozen_deadline) continue;
      fail(p, hub_.cut(p.line)
                  ? fmt::format("is unreachable: the line is cut or its host is down, nothing came for {:.1f} s",
                                seconds_since(p.heard))
                  : fmt::format("is frozen: its connection stands but no heartbeat came for {:.1f} s",
                                seconds_since(p.heard)));
    }
  }

  Peer* peer_on(const std::string& line) {
    for (auto& p : peers_)
      if (p.line == line) return &p;
    return nullptr;
  }

  void handle(Hub::Event event) {
    Peer* known = peer_on(event.line);
    if (event.frames.empty()) {
      // No more messages are sent to it: when the socket closes, it would wait until they are delivered.
      if (known && !std::exchange(known->left, true)) fail(*known, "died: its connection closed without a goodbye");
      return;
    }
    if (known) {
      if (known->noticed) say(fmt::format("{} is back after {:.1f} s", known->name, seconds_since(known->heard)));
      known->noticed = false;
      known->heard = Clock::now();
    }
    Message message;
    try {
      message = decode(event.frames);
    } catch (const PeerError& error) {
      if (known) fail(*known, std::string("sent nonsense: ") + error.what());
      say_of_stranger(std::string("ignored a stranger: ") + error.what());
      return;
    }
    if (known)
      take(*known, std::move(message), bytes_of(event.frames));
    else
      consider(event.line, message);
  }

  void take(Peer& p, Message message, std::size_t bytes) {
    if (message.session != session_)
      fail(p, fmt::format("spoke for session '{}', expected '{}'", message.session, session_));
    if (message.sequence != p.sequence + 1)
      fail(p, fmt::format("lost messages: expected sequence {}, got {}", p.sequence + 1, message.sequence));
    p.sequence = message.sequence;
    if (const auto* beat = std::get_if<Heartbeat>(&message.body)) {
      p.doing = fmt::format("{} step {} since {:.1f} s", beat->doing, message.step, beat->since);
      peer_interrupted_ = peer_interrupted_ || beat->interrupted;
      return;
    }
    p.last = describe(message);
    ++totals_.messages_received;
    totals_.bytes_received += bytes;
    if (const auto* abort = std::get_if<Abort>(&message.body)) {
      p.left = true;
      culprit_ = p.name;
      throw Error(abort->code, fmt::format("{} gave up at step {}: {}", p.name, p.step, abort->reason));
    }
    if (const auto* bye = std::get_if<Bye>(&message.body)) {
      p.left = true;
      if (!finishing_) fail(p, "left before the end: " + bye->reason);
      return;
    }
    p.queue.push_back(std::move(message));
  }

  void consider(const std::string& line, const Message& message) {
    const auto* hello = std::get_if<Hello>(&message.body);
    if (const auto* request = std::get_if<CaseRequest>(&message.body); request && message.major == protocol_major) {
      say_of_stranger("the case goes to " + shown(request->role));
      hub_.regard(line, Hub::Standing::guest);
      answer_stranger(line,
                      CaseFile{options_.case_text, options_.case_overrides, options_.case_digest, options_.dimension});
      return;
    }
    std::optional<Reject> reject;
    if (message.major != protocol_major)
      reject = Reject{RejectCode::protocol,
                      "protocol",
                      fmt::format("{}.x", protocol_major),
                      fmt::format("{}.{}", message.major, message.minor),
                      0.0,
                      ""};
    else if (!hello)
      return;  // not HELLO: its sender was refused, or has left, and still sends
    else
      reject = objection(*hello);
    const std::string who = shown(hello && message.major == protocol_major ? hello->role : message.sender);
    if (reject) {
      const std::string what =
          shown(fmt::format("{}: {}: expected {}, got {}{}{}", who, reject->field, reject->expected, reject->got,
                            reject->reason.empty() ? "" : "; ", reject->reason),
                500);
      say_of_stranger("refused " + what);
      constexpr std::size_t longest = 2000;
      if (refused_.size() < longest) refused_ += (refused_.empty() ? "" : ", ") + what;
      answer_stranger(line, std::move(*reject));
      hub_.regard(line, Hub::Standing::refused);
      return;
    }
    auto& p = peer(hello->role == "fluid" ? Role::fluid : Role::solid);
    p.line = line;
    p.contract = hello->contract;
    p.keeps_checkpoints = hello->keeps_checkpoints;
    p.checkpoints = hello->checkpoints;
    p.sequence = message.sequence;
    p.heard = Clock::now();
    p.last = describe(message);
    hub_.regard(line, Hub::Standing::participant);
    say(fmt::format("{} is here ({}, process {} on {})", p.name, shown(hello->software), hello->process,
                    shown(hello->host)));
    send_to(p, message_of(Welcome{static_cast<double>(options_.heartbeat.count()) / 1000.0,
                                  static_cast<double>(options_.frozen_deadline.count()) / 1000.0}));
  }

  /// Logs a line about a stranger. The number of such lines is limited, since the number of strangers is not.
  void say_of_stranger(const std::string& line) {
    constexpr int most = 50;
    if (said_of_strangers_ < most) say(line);
    if (++said_of_strangers_ == most) say("no more is said of who is turned away or asks for the case");
  }

  void answer_stranger(const std::string& line, Body body) {
    Message answer = message_of(std::move(body));
    answer.session = session_;
    answer.sender = "coupler";
    answer.sequence = 1;
    hub_.send(line, encode(std::move(answer)));
  }

  std::optional<Reject> objection(const Hello& hello) {
    auto refuse = [](RejectCode code, std::string what, std::string expected, std::string got) {
      return Reject{code, std::move(what), std::move(expected), std::move(got), 0.0, ""};
    };
    if (hello.role != "fluid" && hello.role != "solid")
      return refuse(RejectCode::role, "role", "fluid or solid", "'" + hello.role + "'");
    const Role role = hello.role == "fluid" ? Role::fluid : Role::solid;
    const auto& other = peer(role == Role::fluid ? Role::solid : Role::fluid);
    if (!peer(role).line.empty())
      return refuse(RejectCode::role, "role", other.line.empty() ? other.name : "nobody: both roles are taken",
                    "a second " + hello.role);
    const auto& contract = hello.contract;
    if (contract.dimension != options_.dimension)
      return refuse(RejectCode::dimension, "dimension", std::to_string(options_.dimension),
                    std::to_string(contract.dimension));
    if (contract.case_digest != options_.case_digest)
      return Reject{RejectCode::digest,   "case_digest", options_.case_digest,
                    contract.case_digest, 0.0,           different_key(options_.case_part, contract.case_part)};
    if (other.line.empty()) return std::nullopt;
    if (auto found = difference(contract, other.contract)) return found;
    return difference(other.contract, contract);
  }

  Hub& hub_;
  BrokerOptions options_;
  std::string session_;
  std::array<Peer, 2> peers_;
  BrokerTotals totals_;
  std::string culprit_ = "coupler", refused_;
  Clock::time_point beat_ = Clock::now(), listened_ = Clock::now();
  bool finishing_ = false, peer_interrupted_ = false;
  int said_of_strangers_ = 0;
};

Broker::Broker(Hub& hub, BrokerOptions options)
    : implementation_(std::make_unique<Implementation>(hub, std::move(options))) {}
Broker::~Broker() = default;
void Broker::gather() { implementation_->gather(); }
Message Broker::wait(Role role) { return implementation_->wait(role); }
void Broker::send(Role role, Message message) { implementation_->send(role, std::move(message)); }
void Broker::abort(const Error& error, const std::string& culprit) {
  try {
    implementation_->abort(error, culprit);
  } catch (const std::exception&) {
    // The run has failed already; the first cause is the one to report.
  }
}
void Broker::say_goodbye() { implementation_->say_goodbye(); }
const Contract& Broker::contract(Role role) const { return implementation_->contract(role); }
bool Broker::keeps_checkpoints(Role role) const { return implementation_->keeps_checkpoints(role); }
const std::vector<std::string>& Broker::checkpoints(Role role) const { return implementation_->checkpoints(role); }
void Broker::say(const std::string& line) const { implementation_->say(line); }
bool Broker::interrupted() const { return implementation_->interrupted(); }
const BrokerTotals& Broker::totals() const { return implementation_->totals(); }
const std::string& Broker::culprit() const { return implementation_->culprit(); }

}  // namespace poretwin::coupling
