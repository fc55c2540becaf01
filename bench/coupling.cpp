// Costs of an exchange: bytes passed through a coupler, mapping, a whole step of two mocks. Run by hand; the figures
// are in docs/protocol.md.
#include "common/core/memory.hpp"
#include "common/coupling/mock.hpp"
#include "coupler/mapping.hpp"
#include "tests/coupling/coupled_run.hpp"

#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <span>
#include <string>
#include <thread>

using namespace poretwin;
using namespace poretwin::coupling;

namespace {

/// CPU time of this thread [s]; it does not include other work on the machine.
double now() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Wall-clock time [s].
double wall() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

PointSet square(std::size_t n, double shift) {
  return lattice_points(2, {shift, 0.0}, {1.0, 1.0}, 1.0 / std::sqrt(static_cast<double>(n)));
}

/// Exchanged fields of a step: the whole standard contract with both impulses, or one scalar and one vector each way.
struct Fields {
  const char* what;
  std::vector<FieldSpec> of_fluid, of_solid;
};

Fields all_fields() { return {"the whole contract", standard_fields(Role::fluid, 2), standard_fields(Role::solid, 2)}; }

Fields two_fields() {
  const auto all = all_fields();
  const auto pick = [](const std::vector<FieldSpec>& from, std::string_view scalar, std::string_view vector) {
    std::vector<FieldSpec> out;
    for (const auto& spec : from)
      if (spec.name == scalar || spec.name == vector) out.push_back(spec);
    for (auto& spec : out) spec.mask.clear();
    return out;
  };
  return {"a scalar and a vector", pick(all.of_fluid, field::pore_pressure, field::predicted_solid_velocity),
          pick(all.of_solid, field::solid_volume_fraction, field::solid_velocity)};
}

void time_mapping(std::size_t n, double move, const char* what, const Fields& fields) {
  auto fluid = square(n, 0.0), solid = square(n, 0.3 / std::sqrt(static_cast<double>(n)));
  auto mapping = make_mapping(2);
  const FieldFormula busy = [](const std::string&, int c, const double* x, double) {
    return 0.2 + 0.5 * x[0] + 0.1 * c;
  };
  const auto from_fluid = formula_publication(Role::fluid, 0.0, fluid, busy).fields;
  const auto from_solid = formula_publication(Role::solid, 0.0, solid, busy).fields;
  const int steps = n > 100'000 ? 6 : 20;
  std::vector<double> taken;
  for (int k = 0; k <= steps; ++k) {
    for (std::size_t i = 0; i < fluid.position.size(); i += 2) fluid.position[i] += move;
    ++fluid.revision;
    const double start = now();
    mapping->map(Role::solid, solid, from_solid, fields.of_solid, fluid);
    mapping->map(Role::fluid, fluid, from_fluid, fields.of_fluid, solid);
    if (k > 0) taken.push_back(now() - start);  // the first repeat makes the pair lists
  }
  std::sort(taken.begin(), taken.end());
  fmt::print("{:7} points a side, {:8}: {:8.3f} ms mapping per step both ways, median ({})\n", n, what,
             1e3 * taken[taken.size() / 2], fields.what);
}

/// Median over `repeat` calls of the time that work() takes [s].
template <class Work>
double median_wall(int repeat, Work&& work) {
  std::vector<double> taken;
  for (int k = 0; k <= repeat; ++k) {
    const double start = wall();
    work();
    if (k > 0) taken.push_back(wall() - start);
  }
  std::sort(taken.begin(), taken.end());
  return taken[taken.size() / 2];
}

/// Connects two threads by a stream: a unix socket, or tcp over the loopback interface.
void connect_pair(Line line, int ends[2]) {
  if (line == Line::ipc) {
    if (::socketpair(AF_UNIX, SOCK_STREAM, 0, ends) != 0) std::abort();
    return;
  }
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  auto* const where = reinterpret_cast<sockaddr*>(&address);
  const int listener = ::socket(AF_INET, SOCK_STREAM, 0), one = 1;
  if (::bind(listener, where, size) != 0 || ::listen(listener, 1) != 0 || ::getsockname(listener, where, &size) != 0)
    std::abort();
  ends[0] = ::socket(AF_INET, SOCK_STREAM, 0);
  if (::connect(ends[0], where, size) != 0) std::abort();
  ends[1] = ::accept(listener, nullptr, nullptr);
  for (const int* end = ends; end != ends + 2; ++end) ::setsockopt(*end, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
  ::close(listener);
}

/// Time of the kernel alone for the transfer of time_pass_through, over bare stream sockets: no message, no queue, one
/// buffer on each side. With a single byte: its four wake-ups.
double bare_sockets(Line line, std::size_t bytes, int steps) {
  int left[2], right[2];
  connect_pair(line, left);
  connect_pair(line, right);
  const auto pass = [bytes](auto transfer, int file, char* buffer) {
    for (std::size_t done = 0; done < bytes;) {
      const auto count = transfer(file, buffer + done, bytes - done);
      if (count <= 0) std::abort();
      done += static_cast<std::size_t>(count);
    }
  };
  std::thread relay([&] {
    std::vector<char> buffer(bytes);
    for (int k = 0; k <= steps; ++k) {
      pass(::read, left[1], buffer.data());
      pass(::write, right[1], buffer.data());
      pass(::read, right[1], buffer.data());
      pass(::write, left[1], buffer.data());
    }
  });
  std::thread echo([&] {
    std::vector<char> buffer(bytes);
    for (int k = 0; k <= steps; ++k) {
      pass(::read, right[0], buffer.data());
      pass(::write, right[0], buffer.data());
    }
  });
  std::vector<char> buffer(bytes);
  const double median = median_wall(steps, [&] {
    pass(::write, left[0], buffer.data());
    pass(::read, left[0], buffer.data());
  });
  relay.join();
  echo.join();
  for (const int file : {left[0], left[1], right[0], right[1]}) ::close(file);
  return median;
}

/// Passes one scalar and one vector each way through a hub that reads every message and sends it on; no mapping. The
/// lower bound is a memcpy of the same 48 n bytes.
void time_pass_through(Line line, std::size_t n) {
  std::vector<double> from(6 * n, 1.0), to(6 * n);
  const int steps = n > 100'000 ? 20 : 200;
  const double floor = median_wall(steps, [&] {
    std::memcpy(to.data(), from.data(), 48 * n);
    from.swap(to);
  });

  InProcess process;
  const std::string path = "/tmp/poretwin-bench";
  std::unique_ptr<Hub> hub =
      line == Line::in_process ? process.hub() : bind_socket(line == Line::ipc ? "ipc://" + path : "tcp://127.0.0.1:*");
  const auto connect = [&] { return line == Line::in_process ? process.line() : connect_socket(hub->address()); };
  const auto a = connect(), b = connect();
  std::thread relay([&] {
    std::string one, other;
    for (int messages = 0; messages < 2 * steps + 4;) {
      auto event = hub->receive(Milliseconds(100));
      if (!event || event->frames.empty()) continue;
      ++messages;
      if (one.empty()) one = event->line;
      if (other.empty() && event->line != one) other = event->line;
      if (messages <= 2) continue;
      Message message = decode(event->frames);
      hub->send(event->line == one ? other : one, encode(std::move(message)));
    }
  });
  const auto made = [n] {
    Message message;
    message.body = PublicationBody{};
    message.arrays = {{"scalar", "Pa", 1, std::vector<double>(n, 1.0)},
                      {"vector", "m/s", 2, std::vector<double>(2 * n, 1.0)}};
    return message;
  };
  const auto await = [](Transport& there) {  // until the values are in the receiver's own arrays
    for (;;)
      if (auto frames = there.receive(Milliseconds(1000))) {
        Message message = decode(*frames);
        std::vector<std::vector<double>> arrays;
        for (auto& array : message.arrays) arrays.push_back(array.take());
        return arrays;
      }
  };
  a->send(encode(made()));
  std::this_thread::sleep_for(Milliseconds(50));
  b->send(encode(made()));
  std::this_thread::sleep_for(Milliseconds(50));
  std::vector<double> taken;
  for (int k = 0; k <= steps; ++k) {
    auto there = made(), back = made();  // arrays that a solver has computed anyway
    const double start = wall();
    a->send(encode(std::move(there)));
    await(*b);
    b->send(encode(std::move(back)));
    await(*a);
    if (k > 0) taken.push_back(wall() - start);
  }
  relay.join();
  std::sort(taken.begin(), taken.end());
  const double median = taken[taken.size() / 2];
  fmt::print(
      "{:7} points a side, {:10}: {:8.3f} ms passing a step through, median; memcpy of the bytes {:.3f} ms: {:.1f} x\n",
      n, line_name(line), 1e3 * median, 1e3 * floor, median / floor);
  if (line == Line::in_process) return;
  const double bare = bare_sockets(line, 24 * n, steps), turns = bare_sockets(line, 1, steps);
  fmt::print("{:7} points a side, bare {} sockets: {:.3f} ms: {:.1f} x; with one byte a message {:.3f} ms\n", n,
             line_name(line), 1e3 * bare, bare / floor, 1e3 * turns);
}

void time_step(Line line, std::size_t n) {
  const double spacing = 1.0 / std::sqrt(static_cast<double>(n));
  const auto of_fluid = formula_publication(Role::fluid, 0.0, lattice_points(2, {0.0, 0.0}, {1.0, 1.0}, spacing));
  const auto of_solid = formula_publication(Role::solid, 0.0, lattice_points(2, {0.0, 0.0}, {1.0, 1.0}, spacing));
  auto moving = [](const Publication& base) {
    return [&base](double t) {
      auto out = base;
      out.points.revision = static_cast<std::uint64_t>(1e6 * t) + 1;
      return out;
    };
  };
  class Silent final : public MockPhase {
   public:
    using MockPhase::MockPhase;
    Outcome advance(const Window& window, const Inbox&) override { return MockPhase::advance(window, {}); }
  };
  Silent fluid(Role::fluid, 2, moving(of_fluid)), solid(Role::solid, 2, moving(of_solid));
  CoupledRun run;
  run.line = line;
  run.settings = {1.0, 0.01, 0.0, 10.0};
  run.run(&fluid, &solid);
  const double windows = static_cast<double>(run.report.windows);
  fmt::print(
      "{:7} points a side, {:10}: {:7.3f} ms per step, of which mapping {:.3f} ms, mocks {:.3f} ms, {:.2f} MB {}\n", n,
      line_name(line), 1e3 * run.wall / windows, 1e3 * run.report.mapping / windows,
      1e3 * (run.fluid.report.computing + run.solid.report.computing) / windows,
      1e-6 * static_cast<double>(run.totals.bytes_sent + run.totals.bytes_received) / windows, run.coupler.error);
}

}  // namespace

/// Usage: [mapping] [passing] [steps] [POINTS...]; without arguments: all.
int main(int argc, char** argv) {
  std::vector<std::string> parts;
  std::vector<std::size_t> sizes;
  for (const std::string word : std::span(argv + 1, static_cast<std::size_t>(argc - 1)))
    if (const auto n = std::strtoul(word.c_str(), nullptr, 10); n > 0)
      sizes.push_back(n);
    else
      parts.push_back(word);
  if (parts.empty()) parts = {"mapping", "passing", "steps"};
  const auto wanted = [&](std::string_view part) { return std::find(parts.begin(), parts.end(), part) != parts.end(); };
  keep_freed_memory();
  for (const auto n : sizes.empty() ? std::vector<std::size_t>{4900, 48400, 490000} : sizes) {
    const double spacing = 1.0 / std::sqrt(static_cast<double>(n));
    for (const auto& fields : {two_fields(), all_fields()}) {
      if (!wanted("mapping")) break;
      time_mapping(n, 0.0, "still", fields);
      time_mapping(n, 0.004 * spacing, "reused", fields);
      time_mapping(n, 1.0 * spacing, "rebuilt", fields);
    }
    if (wanted("passing"))
      for (const Line line : {Line::in_process, Line::ipc, Line::tcp}) time_pass_through(line, n);
  }
  for (const std::size_t n : {std::size_t{4}, std::size_t{4900}})
    if (wanted("steps"))
      for (const Line line : {Line::in_process, Line::ipc, Line::tcp}) time_step(line, n);
}
