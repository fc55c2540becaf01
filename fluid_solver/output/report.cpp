#include "fluid_solver/output/report.hpp"

#include "fluid_solver/boundary/columns.hpp"
#include "fluid_solver/numerics/pressure.hpp"

#include <fmt/format.h>

namespace poretwin::fluid {

template <int D>
OutputFrame frame_of(const Setup<D>& setup, const State<D>& state) {
  const auto& p = state.particles;
  OutputFrame out;
  out.time = state.time;
  out.count = p.size();
  out.position = write_vectors<D>(p.position);
  const auto pressure = [&p, &setup](std::size_t a) {
    return p.pressure[a] + setup.weight.dot(p.position[a] - setup.origin);
  };
  const auto relative = [&p](std::size_t a, double* flux) {
    for (int d = 0; d < 3; ++d)
      flux[d] = d < D && p.mask[a] > 0.0 ? p.void_fraction[a] * (p.velocity[a][d] - p.solid_velocity[a][d]) : 0.0;
  };
  const auto surface = [&p](std::size_t a) { return p.surface[a] == Surface::interior ? 0.0 : 1.0; };
  out.fields = {
      {{"velocity", "m/s", "velocity of the water between the grains (intrinsic)", 3}, write_vectors<D>(p.velocity)},
      {{"pore_pressure", "Pa", "total pressure of the water", 1}, write_scalars(pressure)},
      {{"void_fraction", "1", "n_w, water's share of the volume where saturated; 1 in free water", 1},
       write_scalars([&p](std::size_t a) { return p.void_fraction[a]; })},
      {{"relative_flux", "m/s", "n (v_w - v_s), the discharge through the skeleton; zero in free water", 3}, relative},
      {{"surface", "1", "1 on the free surface", 1}, write_scalars(surface)},
      {{"volume", D == 2 ? "m2" : "m3", "bulk volume that the particle stands for", 1},
       write_scalars([&p](std::size_t a) { return p.volume[a]; })}};
  return out;
}

template <int D>
std::map<std::string, double> counters_of(const Setup<D>& setup, const State<D>& state) {
  const auto& c = state.counts;
  std::map<std::string, double> counters{{"particles", static_cast<double>(state.particles.size())},
                                         {"windows", c.windows},
                                         {"pressure iterations", c.pressure_iterations},
                                         {"multigrid cycles", c.multigrid_cycles},
                                         {"skeleton iterations", c.skeleton_iterations},
                                         {"outer iterations", c.outer_iterations},
                                         {"solves that missed their tolerance", c.unconverged},
                                         {"list rebuilds", c.stencils},
                                         {"further rounds of quadratic drag", c.drag_rounds},
                                         {"born", c.born},
                                         {"deleted", c.deleted},
                                         {"lost, far outside", c.lost}};
  if (!state.columns.empty() || !state.inlets.empty())
    counters[D == 2 ? "m2: water that faces let in and particles lack"
                    : "m3: water that faces let in and particles lack"] = missing_water<D>(setup, state);
  if (c.cavitating > 0.0) {
    counters["particles that cavitated, most at once"] = c.cavitating;
    counters["s: first cavitation"] = c.first_cavitation;
  }
  return counters;
}

std::vector<Warning> warnings_of(const Counts& c) {
  return {
      {"water particles lost", c.lost, "they left the scene, through a gap or a wall; their mass is gone", true},
      {"pressure solves that missed their tolerance", c.unconverged,
       c.in_doubt > 0.0
           ? fmt::format("the residual of {:g} of them exceeds {:g} of what drives the water: their pressures may be "
                         "wrong",
                         c.in_doubt, pressure::free_water_tolerance)
           : "the pressures of these windows are less exact than fluid.pressure_tolerance says",
       c.in_doubt > 0.0},
      {"particles of water that cavitated, most at once", c.cavitating,
       fmt::format("from t = {:g} s on; voids opened at water.cavitation_pressure", c.first_cavitation), false}};
}

#define PORETWIN_INSTANTIATE(D)                                                \
  template OutputFrame frame_of(const Setup<D>& setup, const State<D>& state); \
  template std::map<std::string, double> counters_of(const Setup<D>& setup, const State<D>& state);
PORETWIN_INSTANTIATE(2)
PORETWIN_INSTANTIATE(3)
#undef PORETWIN_INSTANTIATE

}  // namespace poretwin::fluid
