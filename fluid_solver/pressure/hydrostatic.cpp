#include "fluid_solver/pressure/hydrostatic.hpp"

#include "common/core/threads.hpp"
#include "fluid_solver/discretisation/bodies.hpp"
#include "fluid_solver/discretisation/water_stencil.hpp"
#include "fluid_solver/exchange/soil_exchange.hpp"
#include "fluid_solver/numerics/pressure.hpp"
#include "fluid_solver/numerics/steps.hpp"
#include "fluid_solver/pressure/water_solve.hpp"
#include "fluid_solver/regimes.hpp"

#include <cmath>

namespace poretwin::fluid {

template <int D>
void solve_hydrostatic(const Setup<D>& setup, const Walls<D>& walls, SoilView<D>& view, State<D>& state) {
  auto& p = state.particles;
  if (!setup.domain.any(p.size() > 0)) return;
  auto s = water_stencil<D>(setup, walls, state);
  mark_surface<D>(setup, s, {}, 0.0, state);
  number_closed_bodies<D>(s, state);
  Vec<D> low = Vec<D>::Constant(HUGE_VAL), high = -low;
  for (const auto& x : p.position) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  for (double& x : low) x = setup.domain.min(x);
  for (double& x : high) x = setup.domain.max(x);
  auto in = window_problem<D>(setup, walls, state,
                              std::sqrt(2.0 * ((high - low).norm() + setup.spacing) / setup.gravity_or_standard));
  in.response = false;
  in.tolerance = pressure::initial_tolerance;
  view.velocity = {};
  view.forget_law();
  WindowSolution<D> out;
  out.pressure = p.pressure;
  solve_window<D>(s, view, p.surface, in, out);
  p.pressure = out.pressure;
  if (out.in_doubt) {
    ++state.counts.unconverged;
    ++state.counts.in_doubt;
  }
  if (setup.coupled) store_coupling_force<D>(setup, view, out.gradient, 0.0, p);
  const double fastest = setup.domain.max_over(p.size(), 0.0, [&](std::size_t a) {
    return is_drag_dominated<D>(setup, state.particles, view, a) ? out.velocity[a].norm() / spacing_of<D>(p.volume[a])
                                                                 : 0.0;
  });
  state.window_limits.clear();
  if (fastest > 0.0)
    state.window_limits.push_back(
        {steps::seepage_courant / fastest, "a quarter spacing per window of seepage that begins"});
}

template void solve_hydrostatic(const Setup<2>& setup, const Walls<2>& walls, SoilView<2>& view, State<2>& state);
template void solve_hydrostatic(const Setup<3>& setup, const Walls<3>& walls, SoilView<3>& view, State<3>& state);

}  // namespace poretwin::fluid
