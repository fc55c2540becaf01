#include "solid_solver/dynamics/straining.hpp"

#include "solid_solver/discretisation/batch.hpp"
#include "solid_solver/numerics/flow.hpp"

#include <cmath>

namespace poretwin::solid {
namespace {

/// Share of a strain during which the grains touch, where the bulk volume [m^D] goes from `before` to `after` and they
/// touch below `contact`. Suspended grains are strained from the contact on only.
[[gnu::always_inline]] inline void touching_share(const Lanes& before, const Lanes& after, const Lanes& contact,
                                                  Lanes& share) {
  const LaneMask settles = (before > contact) & (after < contact);
  const Lanes change = settles ? before - after : Lanes{} + 1.0;
  share = settles ? (contact - after) / change : Lanes{} + 1.0;
  share = after > contact ? Lanes{} : share;
}

/// Computes trial strains, rotated stresses, and the volumes that follow from the strains, for a batch of particles.
template <int D>
void follow(const Setup<D>& setup, double dt, double duration, const State<D>& state, Batch& batch) {
  const Particles<D>& p = state.particles;
  const Index soil = batch.soil;
  const double density = setup.density[soil], grain_density = setup.grain_density[soil],
               grain_share = setup.grain_share[soil], contact = setup.contact_volume[soil];
  const bool suspended = std::isfinite(contact);
  // The solid fraction n_s = m / (rho_s V), Eq. (50), conserves mass: V changes at the rate of volumetric strain. V is
  // bounded, since an opening crack is not porosity, and since colliding grains keep a tenth of their pores.
  run_lanes([&]() __attribute__((always_inline)) {
    for (std::size_t q = 0; q < batch.n_fours(); ++q) {
      const Index* const i = &batch.who[q * n_lanes];
      Four& four = batch.fours[q];
      four.duration = duration;
      four.viscosity = setup.water.dynamic_viscosity();
      Lanes gradient[D * D], turning[6];
      gather<Node<D>::at_gradient, D * D>(rows_at(state.nodes.data(), i), gradient);
      take_stresses(p.stress, i, four.stress);
      Lanes mass, volume;
      take_each(p.mass, i, mass);
      take_each(p.volume, i, volume);
      const Lanes reference = mass / density, grains = mass / grain_density;
      // The limit of dilation uses the void ratio at the start of the step. With that at the end, dilation would start
      // and stop from trial to trial in a search for equilibrium.
      take_each(state.external.saturation, i, four.saturation);
      four.void_ratio = volume / (grain_share * grains) - 1.0;
      Lanes rate{}, closest = grains + flow::pores_left * (reference - grains);
      for (int d = 0; d < D; ++d) rate += gradient[d + D * d];
      // Motion that only evens out the points is no strain of the soil.
      Lanes spreading;
      take_each(state.external.spreading, i, spreading);
      rate -= spreading;
      max_in_place(closest, 0.5 * reference);
      volume *= 1.0 + dt * rate;
      max_in_place(volume, closest);
      min_in_place(volume, 2.0 * reference);
      batch.volume[q].v = volume;
      Lanes touching = Lanes{} + 1.0;
      if (suspended) {
        Lanes before;
        take_each(p.volume, i, before);
        touching_share(before, volume, contact * reference, touching);
      }
      spin_rate<D>(four.stress, gradient, turning);
      strain_rate<D>(gradient, four.strain);
      for (int d = 0; d < D; ++d) four.strain[d] -= spreading / D;
      Lanes share = Lanes{} + 1.0;
      if (setup.soft_edges) {
        Lanes upper[D * (D + 1) / 2];
        gather<Node<D>::at_correction, D*(D + 1) / 2>(rows_at(state.nodes.data(), i), upper);
        edge_stiffness<D>(upper, share);
      }
      batch.stiffness[q].v = share;
      for (int c = 0; c < 6; ++c) {
        four.stress[c] += dt * turning[c];
        four.strain[c] *= dt * touching * share;  // the stress of the lower moduli
      }
    }
  });
}

}  // namespace

template <int D>
void strain(const Setup<D>& setup, double dt, double duration, State<D>& state) {
  Particles<D>& p = state.particles;
  const auto strained = [&](Index i) {
    const bool held = i >= p.free() && state.nodes[i].gradient.squaredNorm() == 0.0;
    return !held && !state.near.pairs.skips(i) && !state.regions.sleeps(i);
  };
  for_batches(state, strained, [&](Batch& batch) {
    follow<D>(setup, dt, duration, state, batch);
    follow_strains(setup, batch, p);
    const float friction = setup.loose_friction[batch.soil];
    for (std::size_t k = 0; k < batch.count; ++k) {
      const Index i = batch.who[k];
      const Four& four = batch.fours[k / n_lanes];
      const std::size_t lane = k % n_lanes;
      p.volume[i] = batch.volume[k / n_lanes].v[lane];
      const bool apart = friction > 0.0F && p.volume[i] > flow::loosest * p.mass[i] / setup.density[batch.soil];
      p.rubbing[i] = apart ? friction : 0.0F;
      const bool stressed = !apart && !in_suspension(setup, p, i);
      for (int c = 0; c < 6; ++c) p.stress[i][c] = stressed ? four.stress[c][lane] : 0.0;
      if (four.plastic[lane] <= 0.0) continue;
      p.plastic_strain[i] += four.plastic[lane] / batch.stiffness[k / n_lanes].v[lane];
      state.yielded[i] = 1;
    }
  });
}

template void strain<2>(const Setup<2>&, double, double, State<2>&);
template void strain<3>(const Setup<3>&, double, double, State<3>&);

}  // namespace poretwin::solid
