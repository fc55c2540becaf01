// The checks of the conformance suite; each check starts the solver anew.
#include "common/core/error.hpp"
#include "peer/examiner.hpp"
#include "peer/peer.hpp"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <ostream>

namespace poretwin::peer {
namespace {

using namespace coupling;

double everywhere(const Point3&) { return 1.0; }
double nowhere(const Point3&) { return 0.0; }

/// Coverage of the solver's points by the other phase: 1 left of a front, 0 right of it. share: the front's position as
/// a fraction of the width of these points.
Sight left_of(const Examiner& solver, double share) {
  const auto& points = *solver.state().points;
  const auto d = static_cast<std::size_t>(points.dimension);
  double low = 0.0, high = 0.0;
  for (std::size_t i = 0; i < points.n_active; ++i) {
    const double x = points.position[i * d];
    low = i == 0 ? x : std::min(low, x);
    high = i == 0 ? x : std::max(high, x);
  }
  return [front = low + share * (high - low)](const Point3& x) { return x[0] <= front ? 1.0 : 0.0; };
}

/// Compares two publications bit by bit; returns a text on the first difference, or an empty text.
std::string difference(const Snapshot& a, const Snapshot& b) {
  if (a.points->size() != b.points->size())
    return fmt::format("{} points, then {}", a.points->size(), b.points->size());
  const auto compare = [](const std::string& name, const std::vector<double>& u, const std::vector<double>& v,
                          int components) -> std::string {
    for (std::size_t k = 0; k < u.size(); ++k)
      if (u[k] != v[k])
        return fmt::format("{} of point {} was {}, then {}", name, k / static_cast<std::size_t>(components), u[k],
                           v[k]);
    return {};
  };
  auto found = compare("the position", a.points->position, b.points->position, a.points->dimension);
  for (std::size_t k = 0; k < a.fields.size() && found.empty(); ++k)
    found = compare(a.fields[k].name, a.fields[k].values, b.fields[k].values, a.fields[k].components);
  if (found.empty() && a.proposed_interval != b.proposed_interval)
    found = fmt::format("it proposed {} s, then {} s", a.proposed_interval, b.proposed_interval);
  return found;
}

std::string handshake(Examiner& solver) {
  const auto& hello = solver.hello();
  return fmt::format("comes as {}, gives {} fields and takes {}", hello.role, hello.contract.gives.size(),
                     hello.contract.takes.size());
}

std::string refusal(Examiner& solver) {
  solver.hello();
  solver.send(Reject{RejectCode::field, "pore_pressure", "unit Pa", "unit kPa", 0.0, ""});
  solver.expect_exit(static_cast<int>(ExitCode::peer), "REJECT");
  return "leaves with exit code 3";
}

std::string another_protocol(Examiner& solver) {
  solver.hello();
  solver.foreign_major() = protocol_major + 1;
  solver.send(Welcome{1.0, 30.0});
  solver.expect_exit(static_cast<int>(ExitCode::peer), "a WELCOME of another protocol");
  return "leaves with exit code 3";
}

std::string a_run(Examiner& solver) {
  solver.begin();
  for (int k = 0; k < 3; ++k) solver.window(everywhere);
  solver.finish("end");
  solver.expect_exit(0, "FINISH");
  return fmt::format("three windows, {} points, BYE and exit code 0", solver.state().points->size());
}

std::string moving_points(Examiner& solver) {
  solver.begin();
  for (int k = 0; k < 4; ++k)
    solver.window([k](const Point3& x) { return 0.75 + 0.25 * std::cos(10.0 * (x[0] + x[1]) + k); });
  return "the other side's cover changes in every window";
}

std::string growing_and_shrinking(Examiner& solver) {
  solver.begin();
  for (const double share : {0.5, 0.75, 1.0, 0.75, 0.5}) solver.window(left_of(solver, share));
  return "the other side covers a half, three quarters, all, three quarters, a half";
}

std::string empty_set(Examiner& solver) {
  solver.begin();
  solver.window(everywhere);
  for (int k = 0; k < 2; ++k) solver.window(nowhere);
  solver.window(everywhere);
  return "the other side is gone for two windows, then back";
}

std::string late_answer(Examiner& solver) {
  solver.begin();
  solver.window(everywhere);
  const int beats = solver.idle(Milliseconds(3000));
  if (beats < 7) throw Failed{fmt::format("{} heartbeats in 3 s of waiting; WELCOME asked for one every 0.2 s", beats)};
  solver.window(everywhere);
  return fmt::format("waits for 3 s with {} heartbeats, then goes on", beats);
}

std::string rejected_step(Examiner& solver) {
  solver.begin();
  solver.window(everywhere);
  const double interval = 0.5 * solver.allowed();
  if (solver.advance(interval, everywhere)) return "refuses half of its own proposal; not judged";
  const Snapshot first = solver.state();
  solver.restore();
  solver.advance(0.5 * interval, everywhere);
  solver.restore();
  solver.advance(interval, everywhere);
  if (const auto found = difference(first, solver.state()); !found.empty())
    throw Failed{"after two RESTOREs the same window gave another result: " + found};
  solver.window(everywhere);
  return "restored twice, the same window gives the same result bit by bit";
}

/// The solver writes two checkpoints and is killed. When resumed, it must return to the second checkpoint and repeat
/// the window after it bit by bit.
std::string resume(Examiner& solver) {
  solver.begin();
  if (!solver.keeps_checkpoints()) return "keeps no checkpoints; not judged";
  solver.window(everywhere);
  solver.checkpoint("first", {});
  solver.window(everywhere);
  solver.checkpoint("second", {"first"});
  const Snapshot then = solver.state();
  const double interval = 0.5 * solver.allowed();
  if (solver.advance(interval, everywhere)) return "refuses half of its own proposal; not judged";
  const Snapshot later = solver.state();
  solver.restore();
  solver.kill();
  const PrivateFolder folder;
  Examiner again(solver, folder.path() / "solver.log");
  again.resume("second", solver);
  if (const auto found = difference(then, again.state()); !found.empty())
    throw Failed{"resumed, its publication differs from the one at the checkpoint: " + found};
  again.advance(interval, everywhere);
  if (const auto found = difference(later, again.state()); !found.empty())
    throw Failed{"resumed, the same window gave another result: " + found};
  again.finish("end");
  again.expect_exit(0, "FINISH");
  return "killed and resumed, the same window gives the same result bit by bit";
}

std::string abort_run(Examiner& solver) {
  solver.begin();
  solver.window(everywhere);
  solver.send(Abort{"fluid", "the conformance suite tries it", ExitCode::diverged});
  solver.expect_exit(static_cast<int>(ExitCode::diverged), "ABORT with exit code 4");
  return "leaves with the exit code that ABORT brought";
}

std::string lost_coupler(Examiner& solver) {
  solver.begin();
  solver.window(everywhere);
  solver.hang_up();
  solver.expect_exit(static_cast<int>(ExitCode::peer), "the connection closed");
  return "leaves with exit code 3";
}

std::string interruption(Examiner& solver) {
  solver.begin();
  solver.window(everywhere);
  solver.interrupt();
  solver.finish("interrupted");
  solver.expect_exit(static_cast<int>(ExitCode::interrupted), "FINISH, interrupted");
  return "tells of SIGINT by heartbeat, leaves with exit code 130 after FINISH";
}

struct Check {
  const char* name;
  std::string (*run)(Examiner&);
};
constexpr Check checks[] = {
    {"handshake", handshake},
    {"refusal", refusal},
    {"another protocol", another_protocol},
    {"a run", a_run},
    {"moving points", moving_points},
    {"growing, shrinking", growing_and_shrinking},
    {"empty set", empty_set},
    {"late answer", late_answer},
    {"rejected step", rejected_step},
    {"resume", resume},
    {"abort", abort_run},
    {"lost coupler", lost_coupler},
    {"interruption", interruption},
};

std::string tail_of(const std::filesystem::path& log) {
  std::ifstream stream(log);
  std::string last;
  for (std::string line; std::getline(stream, line);)
    if (!line.empty()) last = line;
  return last;
}

}  // namespace

int conformance(const std::filesystem::path& case_file, const std::vector<std::string>& command, std::ostream& report) {
  if (command.empty()) throw CaseError("peer conformance: expected CASE, then the command of a solver");
  const Case scene = read_case(case_file);
  const PrivateFolder folder;
  int failed = 0, passed = 0;
  for (const auto& check : checks) {
    const auto log = folder.path() / "solver.log";
    std::filesystem::remove(log);
    std::string verdict = "passed", words;
    try {
      Examiner solver(scene, case_file, command, log);
      words = check.run(solver);
      ++passed;
    } catch (const Failed& failure) {
      verdict = "FAILED";
      words = failure.what;
      if (const auto last = tail_of(log); !last.empty()) words += "\n" + std::string(29, ' ') + "it said: " + last;
      ++failed;
    }
    report << fmt::format("{}  {:<20} {}\n", verdict, check.name, words) << std::flush;
  }
  report << fmt::format("{} checks passed, {} failed\n", passed, failed);
  return failed == 0 ? 0 : static_cast<int>(ExitCode::peer);
}

}  // namespace poretwin::peer
