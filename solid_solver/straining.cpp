#include "solid_solver/straining.hpp"

#include "common/core/threads.hpp"
#include "solid_solver/pair_loops.hpp"

namespace poretwin::solid {
namespace {

constexpr std::size_t at_once = 256;  // particles

/// Particles of one soil, at most so many; filled up to a multiple of four with the last.
struct Batch {
  std::array<Index, at_once> who;
  std::array<Four, at_once / n_lanes> fours;
  std::array<Quad, at_once / n_lanes> volume;
  std::size_t count = 0;
};

/// Trial strains, stresses that have turned, and the volumes that go with the strains.
template <int D>
void follow(const Setup<D>& setup, double dt, const State<D>& state, Index soil, Batch& batch) {
  const Particles<D>& p = state.particles;
  const double density = setup.density[soil], grain_density = setup.grain_density[soil],
               grain_share = setup.grain_share[soil];
  // Mass kept: n_s = m / (rho_s V), Eq. (50) by its rate. Bounded: a crack that opens is not porosity, and grains
  // that strike together keep a tenth of their pores.
  constexpr double pores_left = 0.1;
  run_lanes([&]() __attribute__((always_inline)) {
    for (std::size_t q = 0; q * n_lanes < batch.count; ++q) {
      const Index* const i = &batch.who[q * n_lanes];
      Four& four = batch.fours[q];
      Lanes gradient[D * D], turning[6];
      gather<Node<D>::at_gradient, D * D>(rows_at(state.nodes.data(), i), gradient);
      gather<0, 6>({p.stress[i[0]].data(), p.stress[i[1]].data(), p.stress[i[2]].data(), p.stress[i[3]].data()},
                   four.stress);
      const auto of_each = [&](const auto& values) __attribute__((always_inline)) {
        return Quad{{values[i[0]], values[i[1]], values[i[2]], values[i[3]]}};
      };
      const Lanes mass = of_each(p.mass).v, reference = mass / density, grains = mass / grain_density;
      Lanes volume = of_each(p.volume).v;
      // Dilation ends by the void ratio at the start: by that at the end it would begin and end with every
      // displacement that a search for equilibrium tries.
      four.saturation = of_each(state.external.saturation).v;
      four.void_ratio = volume / (grain_share * grains) - 1.0;
      Lanes rate{}, closest = grains + pores_left * (reference - grains);
      for (int d = 0; d < D; ++d) rate += gradient[d + D * d];
      raise_to(closest, 0.5 * reference);
      volume *= 1.0 + dt * rate;
      raise_to(volume, closest);
      lower_to(volume, 2.0 * reference);
      batch.volume[q].v = volume;
      spin_rate<D>(four.stress, gradient, turning);
      strain_rate<D>(gradient, four.strain);
      for (int c = 0; c < 6; ++c) {
        four.stress[c] += dt * turning[c];
        four.strain[c] *= dt;
      }
    }
  });
}

template <int D>
void advance(const Setup<D>& setup, double dt, Batch& batch, State<D>& state) {
  if (batch.count == 0) return;
  Particles<D>& p = state.particles;
  const Index soil = p.material[batch.who[0]];
  const std::size_t n_fours = (batch.count + n_lanes - 1) / n_lanes;
  for (std::size_t k = batch.count; k < n_fours * n_lanes; ++k) batch.who[k] = batch.who[batch.count - 1];
  follow<D>(setup, dt, state, soil, batch);
  setup.models[soil]->advance(std::span(batch.fours).first(n_fours));
  const float friction = setup.loose_friction[soil];
  for (std::size_t k = 0; k < batch.count; ++k) {
    const Index i = batch.who[k];
    const Four& four = batch.fours[k / n_lanes];
    const std::size_t lane = k % n_lanes;
    p.volume[i] = batch.volume[k / n_lanes].v[lane];
    const bool apart = friction > 0.0F && p.volume[i] > Setup<D>::loosest * p.mass[i] / setup.density[soil];
    p.rubbing[i] = apart ? friction : 0.0F;
    for (int c = 0; c < 6; ++c) p.stress[i][c] = apart ? 0.0 : four.stress[c][lane];
    if (four.plastic[lane] <= 0.0) continue;
    p.plastic_strain[i] += four.plastic[lane];
    state.yielded[i] = 1;
  }
  batch.count = 0;
}

}  // namespace

template <int D>
void strain(const Setup<D>& setup, double dt, State<D>& state) {
  const Particles<D>& p = state.particles;
  const Pairs& pairs = state.near.pairs;
  for_each_part(pairs.n_parts(), [&](std::size_t part) {
    Batch batch;
    for (Index i = pairs.part[part]; i < pairs.part[part + 1]; ++i) {
      const bool held = i >= p.free() && state.nodes[i].gradient.squaredNorm() == 0.0;
      if (held || pairs.skips(i) || state.regions.sleeps(i)) continue;
      const bool full = batch.count == at_once;
      if (full || (batch.count > 0 && p.material[batch.who[0]] != p.material[i])) advance<D>(setup, dt, batch, state);
      batch.who[batch.count++] = i;
    }
    advance<D>(setup, dt, batch, state);
  });
}

template void strain<2>(const Setup<2>&, double, State<2>&);
template void strain<3>(const Setup<3>&, double, State<3>&);

}  // namespace poretwin::solid
