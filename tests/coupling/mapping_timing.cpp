// How long mapping and a whole step of two mocks take: run by hand (no test), figures in docs/protocol.md.
#include "common/coupling/mock.hpp"
#include "coupler/mapping.hpp"
#include "tests/coupling/coupled_run.hpp"

#include <fmt/format.h>

#include <cmath>
#include <ctime>

using namespace poretwin;
using namespace poretwin::coupling;

namespace {

/// Processor time of this thread [s]: other work on the machine does not count.
double now() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

PointSet square(std::size_t n, double shift) {
  return lattice_points(2, {shift, 0.0}, {1.0, 1.0}, 1.0 / std::sqrt(static_cast<double>(n)));
}

void time_mapping(std::size_t n, double move, const char* what) {
  auto fluid = square(n, 0.0), solid = square(n, 0.3 / std::sqrt(static_cast<double>(n)));
  auto mapping = make_mapping(2);
  // Every field at work, both impulses included: the dearest step there is.
  const FieldFormula busy = [](const std::string&, int c, const double* x, double) {
    return 0.2 + 0.5 * x[0] + 0.1 * c;
  };
  const auto from_fluid = formula_publication(Role::fluid, 0.0, fluid, busy).fields;
  const auto from_solid = formula_publication(Role::solid, 0.0, solid, busy).fields;
  const auto fluid_gives = standard_fields(Role::fluid, 2), solid_gives = standard_fields(Role::solid, 2);
  const int steps = 20;
  double total = 0.0;
  for (int k = 0; k < steps; ++k) {
    for (std::size_t i = 0; i < fluid.position.size(); i += 2) fluid.position[i] += move;
    ++fluid.revision;
    const double start = now();
    mapping->map(Role::solid, solid, from_solid, solid_gives, fluid);
    mapping->map(Role::fluid, fluid, from_fluid, fluid_gives, solid);
    total += now() - start;
  }
  const auto counts = mapping->counts();
  fmt::print(
      "{:7} points a side, {:8}: {:7.3f} ms per step both ways, all 12 fields ({} rebuilds, {} reuses, {} unchanged)\n",
      n, what, 1e3 * total / steps, counts.rebuilds, counts.reuses, counts.unchanged);
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

int main() {
  for (const std::size_t n : {std::size_t{4900}, std::size_t{48400}}) {
    const double spacing = 1.0 / std::sqrt(static_cast<double>(n));
    time_mapping(n, 0.0, "still");
    time_mapping(n, 0.004 * spacing, "slow");
    time_mapping(n, 1.0 * spacing, "rebuilt");
    for (const Line line : {Line::in_process, Line::ipc, Line::tcp}) time_step(line, n);
  }
  for (const Line line : {Line::in_process, Line::ipc, Line::tcp}) time_step(line, 4);
}
