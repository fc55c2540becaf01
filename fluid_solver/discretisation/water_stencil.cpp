#include "fluid_solver/discretisation/water_stencil.hpp"

#include "common/core/threads.hpp"
#include "fluid_solver/discretisation/free_surface.hpp"
#include "fluid_solver/discretisation/ranks.hpp"
#include "fluid_solver/motion/volume_source.hpp"
#include "fluid_solver/numerics/surface.hpp"

namespace poretwin::fluid {

template <int D>
Stencil<D> water_stencil(const Setup<D>& setup, const Walls<D>& walls, const State<D>& state) {
  const auto& p = state.particles;
  const auto buffers = make_buffers(state.columns, true);
  std::vector<char> free(p.size()), soilless;
  parallel_for(p.size(), [&](std::size_t a) { free[a] = is_free(state.particles, a); });
  const Domain domain = with_halo(setup, walls, p);
  if (!setup.ground.strata().empty()) {
    const WithCopies<double> mask(domain, p.mask);
    soilless.resize(p.size() + domain.copies());
    parallel_for(soilless.size(), [&](std::size_t a) { soilless[a] = mask[a] == 0.0; });
  }
  const WithCopies<Vec<D>> position(domain, p.position);
  const WithCopies<double> volume(domain, p.volume);
  auto s = make_stencil<D>(position, volume, std::span<const Buffer<D>>(buffers), walls.planes, free,
                           uses_density_weight(setup),
                           setup.coupled ? worth_threads_while_others_wait : worth_threads_in_pairs, walls.sight,
                           setup.joints, soilless, walls.surfaces.get(), domain);
  fit_columns<D>(state.columns, free, s, walls.sight);
  limit_surface<D>(setup, state, s);
  return s;
}

template <int D>
double share_of_rows(const Setup<D>& setup, double interval) {
  return std::min(1.0, interval / (surface::row_memory * free_repair_time(setup, setup.spacing)));
}

template <int D>
void mark_surface(const Setup<D>& setup, Stencil<D>& s, std::span<double> rows, double share, State<D>& state) {
  auto& p = state.particles;
  // No air can enter soil at rest that is full of water, with water behind every face. A gap of one spacing at the end
  // of a face is then no surface. If it counted as one, the water of several spacings would be drawn into it.
  const Domain& domain = setup.domain;
  const bool closed = domain.any(!state.columns.empty()) && domain.any(p.size() > 0) &&
                      (state.full || state.time == 0.0) && !setup.coupled && setup.is_projection() &&
                      domain.all_of(state.columns.size(),
                                    [&](std::size_t i) {
                                      const auto& c = state.columns[i];
                                      return c.wet && c.in_soil && (c.drag_dominated || !setup.one_soil);
                                    }) &&
                      domain.all_of(p.size(), [&](std::size_t a) { return p.mask[a] > 0.5 && p.in_seepage[a] != 0; });
  const auto flags = find_surface<D>(s, p.in_seepage, rows, share, closed && state.full);
  s.forget_moments();
  p.surface = flags;
  state.full = closed && domain.all_of(p.size(), [&](std::size_t a) { return flags[a] == Surface::interior; });
}

#define PORETWIN_INSTANTIATE(D)                                                                           \
  template double share_of_rows(const Setup<D>&, double);                                                 \
  template Stencil<D> water_stencil(const Setup<D>& setup, const Walls<D>& walls, const State<D>& state); \
  template void mark_surface(const Setup<D>& setup, Stencil<D>& s, std::span<double> rows, double share,  \
                             State<D>& state);
PORETWIN_INSTANTIATE(2)
PORETWIN_INSTANTIATE(3)
#undef PORETWIN_INSTANTIATE

}  // namespace poretwin::fluid
