#include "fluid_solver/pressure/water_solve.hpp"

#include "common/core/error.hpp"
#include "common/core/threads.hpp"
#include "fluid_solver/numerics/pressure.hpp"

#include <fmt/format.h>

#include <cmath>

namespace poretwin::fluid {

template <int D>
WindowProblem<D> window_problem(const Setup<D>& setup, const Walls<D>& walls, const State<D>& state, double interval) {
  WindowProblem<D> in;
  in.interval = interval;
  in.density = setup.density;
  in.weight = setup.weight;
  in.origin = setup.origin;
  in.inertia = !is_driven_by_pressure(setup, state);
  in.beds = setup.ground.beds();
  if (in.beds) in.walls = {walls.planes, &walls.sight, setup.joints};
  in.response = setup.responds;
  in.fixed_soil = setup.fixed_soil;
  in.void_fraction = state.particles.void_fraction;
  in.void_volume = state.particles.void_volume.values();
  in.closed_body = state.particles.closed_body.values();
  const auto& mask = state.particles.mask;
  if (setup.domain.all_of(mask.size(), [&](std::size_t a) { return mask[a] <= 0.5; }))
    in.tolerance = pressure::free_water_tolerance;
  else
    in.tolerance = std::max(in.tolerance / setup.ground.contrast(), pressure::tightest_tolerance);
  if (setup.pressure_tolerance) in.tolerance = *setup.pressure_tolerance;
  for (const auto& c : state.columns) {
    in.face_pressure.push_back(c.pressure);
    in.face_slope.push_back(c.slope);
    in.face_holds.push_back(c.held);
    const Stratum* before =
        setup.coupled ? nullptr : setup.ground.at(just_inside<D>(setup.ground, c.foot, c.normal, c.spacing));
    in.face_soil.push_back(before ? before->number : -1);
  }
  return in;
}

template <int D>
std::vector<Section<D>> solved_sections(const Setup<D>& setup, const State<D>& state) {
  std::vector<Section<D>> sections;
  if (D != 2 || setup.coupled || !setup.periodic.empty() || !setup.is_projection() || !state.full) return sections;
  for (const auto& gauge : setup.gauges)
    if (gauge.phase == "fluid" && gauge.kind == "discharge")
      sections.push_back({gauge.points[0].template head<D>(), gauge.points[1].template head<D>()});
  return sections;
}

template <int D>
WindowSolution<D> solve_with_drag(const Setup<D>& setup, const Stencil<D>& s, const WindowProblem<D>& in,
                                  const Passes<D>& passes, SoilView<D>& view, State<D>& state) {
  const auto& p = state.particles;
  const bool nonlinear = setup.domain.any(view.nonlinear());
  WindowSolution<D> out;
  out.multigrid = state.multigrid;
  for (int round = 1;; ++round) {
    const bool again = !passes.pressure().empty();
    out.pressure = again ? passes.pressure() : p.pressure;
    out.solid_velocity = p.solid_velocity;
    if (again) out.solid_velocity.values() = passes.predicted();
    solve_window<D>(s, view, p.surface, in, out);
    if (!nonlinear || round == pressure::most_drag_rounds) break;
    double error = 0.0, whole = 0.0;
    for (std::size_t a = 0; a < p.size(); ++a) {
      const Vec<D> slip = out.velocity[a] - out.solid_velocity[a];
      const Vec<D> right = view.drag_force(a, slip);
      const double aw = p.void_fraction[a] * setup.density / in.interval;
      error += p.volume[a] * (view.drag[a] * slip - view.drag_offset[a] - right).squaredNorm();
      whole += p.volume[a] * (aw * out.velocity[a] + right).squaredNorm();
    }
    if (setup.domain.sum(error) <= pressure::drag_tolerance * pressure::drag_tolerance * setup.domain.sum(whole)) break;
    view.linearise(out.velocity, out.solid_velocity);
    ++state.counts.drag_rounds;
  }
  return out;
}

template <int D>
void check_finite(const State<D>& state, const WindowSolution<D>& solution, double time) {
  const auto& x = state.particles.position;
  const auto wrong = [&](std::size_t a) {
    return !std::isfinite(solution.pressure[a])      ? "pore_pressure"
           : !solution.velocity[a].allFinite()       ? "velocity"
           : !solution.solid_velocity[a].allFinite() ? "predicted_solid_velocity"
           : solution.velocity[a].norm() > 1e6       ? "velocity (beyond 1e6 m/s)"
                                                     : nullptr;
  };
  if (parallel_all(x.size(), [&](std::size_t a) { return wrong(a) == nullptr; })) return;
  for (std::size_t a = 0; a < x.size(); ++a) {
    if (const char* term = wrong(a))
      throw DivergedError(fmt::format("fluid: {} of particle {} at ({}) is not finite; last good state at t = {} s",
                                      term, a,
                                      D == 2 ? fmt::format("{:.4g}, {:.4g}", x[a][0], x[a][1])
                                             : fmt::format("{:.4g}, {:.4g}, {:.4g}", x[a][0], x[a][1], x[a][D - 1]),
                                      time));
  }
}

template <int D>
void take_solution(const Setup<D>& setup, const WindowSolution<D>& solution, double time, State<D>& state) {
  auto& p = state.particles;
  auto& counts = state.counts;
  counts.windows += 1;
  counts.pressure_iterations += solution.pressure_iterations;
  counts.multigrid_cycles += solution.multigrid_cycles;
  counts.skeleton_iterations += solution.skeleton_iterations;
  counts.outer_iterations += solution.outer;
  counts.unconverged += solution.converged ? 0.0 : 1.0;
  counts.in_doubt += solution.in_doubt ? 1.0 : 0.0;
  state.multigrid = solution.multigrid;
  // Copied, not moved, since moving would fragment the memory of the state's arrays.
  p.pressure = solution.pressure;
  p.solid_velocity = solution.solid_velocity;
  p.velocity = solution.velocity;
  p.void_volume = solution.void_volume;
  state.section_flow = solution.section_flow;
  const double cavitating = setup.domain.sum(
      static_cast<double>(std::count_if(p.void_volume.begin(), p.void_volume.end(), [](double c) { return c > 0.0; })));
  if (cavitating == 0.0) return;
  if (counts.cavitating == 0.0) counts.first_cavitation = time;
  counts.cavitating = std::max(counts.cavitating, cavitating);
}

#define PORETWIN_INSTANTIATE(D)                                                                                      \
  template WindowProblem<D> window_problem(const Setup<D>& setup, const Walls<D>& walls, const State<D>& state,      \
                                           double interval);                                                         \
  template std::vector<Section<D>> solved_sections(const Setup<D>& setup, const State<D>& state);                    \
  template WindowSolution<D> solve_with_drag(const Setup<D>& setup, const Stencil<D>& s, const WindowProblem<D>& in, \
                                             const Passes<D>& passes, SoilView<D>& view, State<D>& state);           \
  template void check_finite(const State<D>& state, const WindowSolution<D>& solution, double time);                 \
  template void take_solution(const Setup<D>&, const WindowSolution<D>&, double, State<D>&);
PORETWIN_INSTANTIATE(2)
PORETWIN_INSTANTIATE(3)
#undef PORETWIN_INSTANTIATE

}  // namespace poretwin::fluid
