#include "common/coupling/gate.hpp"

#include "common/coupling/socket_options.hpp"

#include <fmt/format.h>
#include <linux/inet_diag.h>
#include <linux/netlink.h>
#include <linux/sock_diag.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>

namespace poretwin::coupling {
namespace {

constexpr auto tick = Milliseconds(10);  // time between checks of connections that are no participant's

std::uint64_t cookie_of(int descriptor) {
  std::uint64_t cookie = 0;
  socklen_t size = sizeof cookie;
  return ::getsockopt(descriptor, SOL_SOCKET, SO_COOKIE, &cookie, &size) == 0 ? cookie : 0;
}

/// Bytes received over tcp so far; 0 for other kinds of connection.
std::uint64_t bytes_received(int descriptor) {
  tcp_info info{};
  socklen_t size = sizeof info;
  return ::getsockopt(descriptor, IPPROTO_TCP, TCP_INFO, &info, &size) == 0 ? info.tcpi_bytes_received : 0;
}

/// Splits an end of a connection into address and port, in the form of sock_diag queries.
bool split(const sockaddr_storage& end, std::uint32_t* address, std::uint16_t& port) {
  if (end.ss_family == AF_INET) {
    const auto& v4 = reinterpret_cast<const sockaddr_in&>(end);
    address[0] = v4.sin_addr.s_addr;
    port = v4.sin_port;
    return true;
  }
  const auto& v6 = reinterpret_cast<const sockaddr_in6&>(end);
  std::memcpy(address, &v6.sin6_addr, sizeof v6.sin6_addr);
  port = v6.sin6_port;
  return end.ss_family == AF_INET6;
}

/// The user at the other end of a tcp connection within this machine. The kernel is asked for this one connection
/// (sock_diag(7)): the time to read its table of all connections would grow with the number of strangers.
std::optional<uid_t> other_user(int descriptor) {
  sockaddr_storage ours{}, theirs{};
  socklen_t size = sizeof ours, other_size = sizeof theirs;
  if (::getsockname(descriptor, reinterpret_cast<sockaddr*>(&ours), &size) != 0 ||
      ::getpeername(descriptor, reinterpret_cast<sockaddr*>(&theirs), &other_size) != 0)
    return std::nullopt;
  struct {
    nlmsghdr head{};
    inet_diag_req_v2 question{};
  } request;
  auto& id = request.question.id;
  if (!split(theirs, id.idiag_src, id.idiag_sport) || !split(ours, id.idiag_dst, id.idiag_dport)) return std::nullopt;
  request.head.nlmsg_len = sizeof request;
  request.head.nlmsg_type = SOCK_DIAG_BY_FAMILY;
  request.head.nlmsg_flags = NLM_F_REQUEST;
  request.question.sdiag_family = static_cast<std::uint8_t>(ours.ss_family);
  request.question.sdiag_protocol = IPPROTO_TCP;
  request.question.idiag_states = ~0U;
  id.idiag_cookie[0] = id.idiag_cookie[1] = INET_DIAG_NOCOOKIE;
  const int kernel = ::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_SOCK_DIAG);
  if (kernel < 0) return std::nullopt;
  alignas(nlmsghdr) std::array<char, 4096> answer{};
  ssize_t count = -1;
  if (::send(kernel, &request, sizeof request, 0) == static_cast<ssize_t>(sizeof request))
    count = ::recv(kernel, answer.data(), answer.size(), MSG_DONTWAIT);
  ::close(kernel);
  const auto* head = reinterpret_cast<const nlmsghdr*>(answer.data());
  if (count < static_cast<ssize_t>(NLMSG_LENGTH(sizeof(inet_diag_msg))) || head->nlmsg_type != SOCK_DIAG_BY_FAMILY)
    return std::nullopt;
  return reinterpret_cast<const inet_diag_msg*>(answer.data() + NLMSG_HDRLEN)->idiag_uid;
}

std::size_t descriptors_open() {
  std::error_code none;
  return static_cast<std::size_t>(
      std::distance(std::filesystem::directory_iterator("/proc/self/fd", none), std::filesystem::directory_iterator()));
}

/// Number of strangers' connections for which the process has descriptors, after raising its limit as far as allowed.
std::size_t room_for_strangers(const GateLimits& limits) {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return limits.connections;
  limit.rlim_cur = limit.rlim_max;
  ::setrlimit(RLIMIT_NOFILE, &limit);
  ::getrlimit(RLIMIT_NOFILE, &limit);
  const std::size_t used = descriptors_open() + limits.descriptors_kept;
  const auto most = static_cast<std::size_t>(limit.rlim_cur);
  return std::clamp<std::size_t>(most > used ? (most - used) / 2 : 0, 4, limits.connections);
}

}  // namespace

Gate::Gate(zmq::socket_t& monitor, std::optional<GateLimits> limits, bool own_user_only)
    : monitor_(monitor),
      limits_(limits),
      own_user_only_(own_user_only),
      events_(monitor.get(zmq::sockopt::fd)),
      signal_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      stop_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (signal_ < 0 || stop_ < 0) throw Error(ExitCode::failure, "no event descriptor left (ulimit -n)");
  if (limits_) most_strangers_ = room_for_strangers(*limits_);
  thread_ = std::thread([this] { keep_looking(); });
}

Gate::~Gate() {
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto written = ::write(stop_, &one, sizeof one);
  thread_.join();
  ::close(signal_);
  ::close(stop_);
}

void Gate::wake() const {
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto written = ::write(signal_, &one, sizeof one);
}

void Gate::keep_looking() {
  for (;;) {
    bool strangers = false;
    bool more = false;
    {
      const std::lock_guard lock(mutex_);
      more = look();
      if (!more) enforce();
      strangers = limits_ && std::any_of(connections_.begin(), connections_.end(),
                                         [this](const auto& c) { return !is_members(c.second); });
    }
    std::array<pollfd, 2> items{{{events_, POLLIN, 0}, {stop_, POLLIN, 0}}};
    constexpr int idle = 200;  // ms
    ::poll(items.data(), items.size(), more ? 0 : strangers ? static_cast<int>(tick.count()) : idle);
    if (items[1].revents != 0) return;
  }
}

/// Reads pending events of the monitor in the order in which they happened. Returns true where more may be pending.
bool Gate::look() {
  constexpr int most_at_once = 64;
  for (int count = 0; count < most_at_once; ++count) {
    const auto event = next_event(monitor_);
    if (!event) return false;
    const auto found = connections_.find(event->value);
    switch (event->kind) {
      case ZMQ_EVENT_ACCEPTED:
        connections_[event->value] = Connection{};
        connections_[event->value].since = Clock::now();
        break;
      case ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL:
        note(
            "a connection was turned away: its encryption does not match. Has only one side keys, or were they not "
            "made together by `poretwin keys`?");
        break;
      case ZMQ_EVENT_DISCONNECTED:
        if (found == connections_.end()) break;
        for (const auto& line : found->second.lines) {
          callers_.erase(line);
          const std::lock_guard news(news_);
          closed_.push_back(line);
          wake();
        }
        connections_.erase(found);
        break;
      default:
        break;
    }
  }
  return true;
}

/// Identifies a new connection. To be called only after all events of the monitor have been read: while events are
/// pending, the descriptor may already belong to a later connection.
void Gate::meet(int descriptor, Connection& connection) {
  connection.cookie = cookie_of(descriptor);
  if (!own_user_only_) return;
  const auto user = other_user(descriptor);
  if (user && *user != ::geteuid() && *user != 0)
    end(descriptor, connection,
        fmt::format("somebody of user {} was not let in: without keys a run is for the user who started it", *user));
}

bool Gate::is_members(const Connection& connection) const {
  return std::any_of(connection.lines.begin(), connection.lines.end(),
                     [this](const auto& line) { return callers_.at(line).member; });
}

bool Gate::sends_too_much(const Connection& connection) const {
  return std::all_of(connection.lines.begin(), connection.lines.end(),
                     [this](const auto& line) { return callers_.at(line).messages > limits_->messages; });
}

Gate::Clock::time_point Gate::end_of(const Connection& connection) const {
  if (connection.lines.empty()) return connection.since + limits_->silent;
  auto until = Clock::time_point::min();
  for (const auto& line : connection.lines) until = std::max(until, callers_.at(line).until);
  return until;
}

/// Ends one stranger's connection where there are too many: the oldest of those that have sent nothing, if any, since
/// the newest may be that of a participant about to join. Returns false where there are not too many.
bool Gate::make_room() {
  std::size_t strangers = 0;
  auto oldest = connections_.end();
  for (auto c = connections_.begin(); c != connections_.end(); ++c) {
    const auto& connection = c->second;
    if (connection.ended || is_members(connection)) continue;
    ++strangers;
    const auto rank = [](const Connection& x) { return std::pair(!x.lines.empty(), x.since); };
    if (oldest == connections_.end() || rank(connection) < rank(oldest->second)) oldest = c;
  }
  if (strangers <= most_strangers_) return false;
  end(oldest->first, oldest->second,
      fmt::format("more than {} connections that are no participant's: the oldest is ended", most_strangers_));
  return true;
}

void Gate::end(int descriptor, Connection& connection, const std::string& why) {
  if (!why.empty()) note(why);
  connection.ended = true;
  if (cookie_of(descriptor) == connection.cookie) ::shutdown(descriptor, SHUT_RDWR);
}

/// Ends connections of strangers beyond the limits: on their number, on the bytes they have sent and on the time they
/// have stayed.
void Gate::enforce() {
  if (!limits_) return;
  for (auto& [descriptor, connection] : connections_)
    if (connection.cookie == 0) meet(descriptor, connection);
  while (make_room()) {
  }
  const auto now = Clock::now();
  for (auto& [descriptor, connection] : connections_) {
    if (connection.ended || is_members(connection)) continue;
    if (now > end_of(connection))
      end(descriptor, connection, "");
    else if (bytes_received(descriptor) > limits_->bytes)
      end(descriptor, connection,
          fmt::format("a connection was ended that sent more than {} bytes without being a participant's",
                      limits_->bytes));
  }
}

bool Gate::heard(const std::string& line, int descriptor) {
  // Messages of a participant are processed even if they arrive after its connection has closed.
  if (members_.count(line) > 0) return true;
  const std::lock_guard lock(mutex_);
  while (look()) {  // reads all events, to find the connection that has this descriptor now
  }
  const auto found = connections_.find(descriptor);
  if (found == connections_.end()) return !limits_;
  auto& connection = found->second;
  const auto [caller, is_new] = callers_.try_emplace(line);
  if (is_new) {
    caller->second.descriptor = descriptor;
    if (limits_) caller->second.until = connection.since + limits_->silent;
    connection.lines.push_back(line);
  }
  if (!limits_) return members_.insert(line).second;
  if (connection.cookie == 0) meet(descriptor, connection);
  if (connection.ended) return false;
  if (++caller->second.messages <= limits_->messages) return true;
  if (!sends_too_much(connection)) return false;
  end(descriptor, connection,
      fmt::format("a connection was ended that sent more than {} messages without being a participant's",
                  limits_->messages));
  return false;
}

void Gate::regard(const std::string& line, Hub::Standing standing) {
  const std::lock_guard lock(mutex_);
  const auto found = callers_.find(line);
  if (found == callers_.end() || !limits_) return;
  auto& caller = found->second;
  if (standing == Hub::Standing::participant) {
    caller.member = true;
    members_.insert(line);
  }
  if (standing == Hub::Standing::guest) caller.until = connections_.at(caller.descriptor).since + limits_->guest;
  if (standing == Hub::Standing::refused) caller.until = std::min(caller.until, Clock::now() + limits_->refused);
}

std::optional<std::string> Gate::closed() {
  const std::lock_guard lock(news_);
  std::uint64_t count = 0;
  [[maybe_unused]] const auto got = ::read(signal_, &count, sizeof count);
  if (closed_.empty()) return std::nullopt;
  std::string line = std::move(closed_.front());
  closed_.pop_front();
  return line;
}

/// A refused process tries again several times a second: each text is logged once, and the number of texts is limited.
void Gate::note(const std::string& what) {
  const std::lock_guard lock(news_);
  const std::size_t most = limits_ ? limits_->notices : 100;
  if (said_.size() > most || !said_.insert(what).second) return;
  notices_.push_back(said_.size() <= most ? what : "further connections that are turned away are not reported");
  wake();
}

std::string Gate::notice() {
  const std::lock_guard lock(news_);
  if (notices_.empty()) return {};
  std::string text = std::move(notices_.front());
  notices_.pop_front();
  return text;
}

int Gate::descriptor_of(const std::string& line) const {
  const std::lock_guard lock(mutex_);
  const auto found = callers_.find(line);
  return found == callers_.end() ? -1 : found->second.descriptor;
}

}  // namespace poretwin::coupling
