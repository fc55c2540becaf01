#include "solid_solver/dynamics/flow_regularisation.hpp"

#include "solid_solver/discretisation/batch.hpp"
#include "solid_solver/discretisation/ranks.hpp"
#include "solid_solver/numerics/flow.hpp"

#include <algorithm>
#include <cmath>

namespace poretwin::solid {
namespace {

/// h^2 sum V |W'/r| over a full neighbourhood [1]; the same value serves 2D and 3D.
constexpr double full_weight = 3.5;

/// Number of stress components that can differ from zero.
template <int D>
constexpr int n_components = D == 2 ? 4 : 6;

/// Sets Scratch::flows and yielded_since. After a step from equilibrium to equilibrium, soil that yielded a little
/// counts, too; its plastic strain since the last call is used and stored.
template <int D>
void see_what_yields(const Setup<D>& setup, bool in_equilibrium, State<D>& state) {
  const Particles<D>& p = state.particles;
  const std::size_t n = p.size();
  ScalarArray& flows = state.scratch.flows;
  flows.assign(n, 0.0);
  if (setup.domain.all_of(n, [&](std::size_t i) { return p.plastic_strain[i] <= 0.0; })) return;
  for (std::size_t i = 0; i < n; ++i)
    if (p.plastic_strain[i] > setup.flow_limit) flows[i] = 1.0;
  state.evened.resize(n, 0.0F);
  ScalarArray& yielded = state.scratch.yielded_since;
  yielded.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const auto strain = static_cast<float>(p.plastic_strain[i]);
    yielded[i] = static_cast<double>(strain - state.evened[i]);
    state.evened[i] = strain;
    if (in_equilibrium && flows[i] == 0.0 && p.rubbing[i] <= 0.0F)
      flows[i] = -flow::evened_out * moduli(setup, p, i).shear * yielded[i];
  }
}

/// Fills the packed data that the loops over pairs, four at a time, read.
template <int D>
void fill_grains(const Domain& domain, const State<D>& state, Scratch<D>& scratch) {
  const auto& p = state.particles;
  const std::size_t n = p.with_copies();
  scratch.grains.resize(state.nodes.size());
  const auto place = [&](std::size_t j) {
    const Node<D>& node = state.nodes[j];
    Grain<D>& grain = scratch.grains[j];
    grain.position = node.position;
    grain.volume = node.volume;
    grain.mass = node.volume * node.density;
  };
  parallel_for(p.size(), [&](std::size_t i) {  // also sleeping particles, since they act on others
    Grain<D>& grain = scratch.grains[i];
    place(i);
    grain.shown = p.volume[i];
    grain.swollen = p.volume[i] / p.mass[i];
    grain.flows = scratch.flows[i];
    grain.stress = p.stress[i].template head<n_components<D>>();
  });
  fill_copies(domain, std::span(scratch.grains).first(n));
  for (std::size_t j = n; j < state.nodes.size(); ++j) {
    const ImageRule<D>& image = state.near.images[j - n];
    scratch.grains[j] = scratch.grains[image.parent];
    place(j);
    if (!image.periodic) scratch.grains[j].shown = 0.0;
  }
}

/// Stress gradients [Pa/m] of the particles that flow, or of all particles; exact for linear stress up to the soil's
/// surface. Images get the gradients of their parents.
template <int D>
void stress_slopes(const Domain& domain, const State<D>& state, bool of_all, Scratch<D>& scratch) {
  using G = Grain<D>;
  constexpr std::size_t n_slopes = n_components<D> * D + D * (D + 1) / 2;
  using Own = Sums<n_slopes>;
  constexpr std::size_t n_stress = n_components<D>;
  const std::size_t n = state.particles.size();
  const Pairs& pairs = state.near.pairs;
  const float* const kernels = state.kernel.data();
  Own* const sums = scratch.template zero_sums<n_slopes>(n);
  for_pairs<SumsOf<n_slopes>::template Row>(
      pairs.rows(0, n), PairInputs{static_cast<const G*>(scratch.grains.data())},
      [=](const auto& pair, auto& own) __attribute__((always_inline)) {
        using Number = NumberOf<decltype(pair)>;
        const double* const self = pair.self;
        const auto rows = pair.rows();
        Number head[G::at_stress], stress[n_stress], w[D], r[D], k, contribution[Own::size] = {};
        gather<0, G::at_stress>(rows, head);
        if (!of_all && self[G::at_flows] == 0.0 && !(pair.both && any(head[G::at_flows] > 0.0))) return;
        gather<G::at_stress, n_stress>(rows, stress);
        take(&kernels[pair.m], k);
        for (std::size_t d = 0; d < D; ++d) {
          r[d] = self[d] - head[d];
          w[d] = k * r[d];
        }
        std::size_t c = 0;
        for (std::size_t d = 0; d < D; ++d)
          for (std::size_t a = 0; a < n_stress; ++a) contribution[c++] = (stress[a] - self[G::at_stress + a]) * w[d];
        for (std::size_t b = 0; b < D; ++b)
          for (std::size_t a = 0; a <= b; ++a) contribution[c++] = -r[a] * w[b];
        for (std::size_t q = 0; q < c; ++q) own.sum[q] += head[G::at_shown] * contribution[q];
        if (!pair.both) return;
        for (std::size_t q = 0; q < c; ++q) contribution[q] *= self[G::at_shown];
        pair.template give<Own::size>(contribution, [=](Index j) { return sums[j].x.data(); });
      },
      [=](std::size_t i, const auto& own) __attribute__((always_inline)) { own.add_to(sums[i].x.data()); });
  for_rows(pairs, 0, n, [&](std::size_t i) {
    if (!of_all && scratch.flows[i] == 0.0) return;
    const double* const sum = sums[i].x.data();
    const double* square = sum + n_stress * D;
    Mat<D> moment;
    for (int b = 0; b < D; ++b)
      for (int a = 0; a <= b; ++a) moment(a, b) = moment(b, a) = *square++;
    scratch.grains[i].slope =
        Eigen::Map<const Eigen::Matrix<double, n_components<D>, D>>(sum) * invert_moment<D>(moment);
  });
  const std::size_t images_from = state.particles.with_copies();
  fill_copies(domain, std::span(scratch.grains).first(images_from));
  for (std::size_t j = images_from; j < scratch.grains.size(); ++j)
    scratch.grains[j].slope = scratch.grains[state.near.images[j - images_from].parent].slope;
}

/// Kernel sums (see Around) for particles that flow or yielded a little: the departures of the stress from the linear
/// fields of the neighbours. For flowing particles also the excess of the neighbours' volumes, the crowding and the
/// coverage.
template <int D>
const Sums<Around<D>::size>* sum_neighbours(const State<D>& state, double h, Scratch<D>& scratch) {
  using G = Grain<D>;
  using A = Around<D>;
  using Own = Sums<A::size>;
  constexpr std::size_t n_stress = n_components<D>;
  const std::size_t n = state.particles.size();
  const Pairs& pairs = state.near.pairs;
  const double centre = sph::WendlandC2<D>::value(0.0, h), half_inverse = 0.5 / h;
  const float* const kernels = state.kernel.data();
  const double* const volumes = state.particles.volume.data();
  Own* const sums = scratch.template zero_sums<A::size>(n);
  for_pairs<SumsOf<A::size>::template Row>(
      pairs.rows(0, n), PairInputs{static_cast<const G*>(scratch.grains.data())},
      [=](const auto& pair, auto& own) __attribute__((always_inline)) {
        using Number = NumberOf<decltype(pair)>;
        const double* const self = pair.self;
        const auto rows = pair.rows();
        Number head[G::at_stress], other[n_stress], slope[n_stress * D], r[D], contribution[Own::size] = {},
                                                                               theirs[Own::size] = {};
        gather<0, G::at_stress>(rows, head);
        const double mine = self[G::at_flows];
        const bool flows = mine > 0.0;
        const Number yours = head[G::at_flows];
        if (mine == 0.0 && !any(yours < 0.0) && !(pair.both && any(yours > 0.0))) return;
        // Flowing particles are averaged with flowing ones, and others with others. The change of a pair of others is
        // limited by the larger of its two bounds.
        Number together = flows ? yours : -yours;
        if (!flows) max_in_place(together, Number{} - mine);
        const MaskOf<decltype(pair)> alike = flows ? yours > 0.0 : yours <= 0.0;
        together = alike ? together : Number{};
        Number k;
        take(&kernels[pair.m], k);
        Number distance{};
        for (std::size_t d = 0; d < D; ++d) {
          r[d] = self[d] - head[d];
          distance += r[d] * r[d];
        }
        sqrt_in_place(distance);
        Number u = 1.0 - half_inverse * distance;
        max_in_place(u, Number{});
        const Number value = centre * (u * u) * (u * u) * (5.0 - 4.0 * u);
        contribution[A::at_cover] = head[G::at_volume] * value;
        theirs[A::at_cover] = self[G::at_volume] * value;
        for (std::size_t d = 0; d < D; ++d) {
          contribution[A::at_crowding + d] = head[G::at_mass] * k * r[d];
          theirs[A::at_crowding + d] = -self[G::at_mass] * k * r[d];
        }
        if (any(together > 0.0)) {
          gather<G::at_stress, n_stress>(rows, other);
          gather<G::at_slope, n_stress * D>(rows, slope);
          Number unexplained[n_stress], size{};
          for (std::size_t a = 0; a < n_stress; ++a) {
            unexplained[a] = other[a] - self[G::at_stress + a];
            for (std::size_t d = 0; d < D; ++d)
              unexplained[a] += 0.5 * (self[G::at_slope + n_stress * d + a] + slope[n_stress * d + a]) * r[d];
            size += unexplained[a] * unexplained[a];
          }
          if (!flows) {
            sqrt_in_place(size);
            together = size > together ? together / size : together > 0.0 ? Number{} + 1.0 : Number{};
          }
          const Number weight = -k * together, they = weight * head[G::at_shown], me = weight * self[G::at_shown];
          for (std::size_t a = 0; a < n_stress; ++a) {
            contribution[a] = they * unexplained[a];
            theirs[a] = -me * unexplained[a];
          }
          contribution[A::at_swelling] = they * (head[G::at_swollen] / self[G::at_swollen] - 1.0);
          theirs[A::at_swelling] = me * (self[G::at_swollen] / head[G::at_swollen] - 1.0);
        }
        // Pairs of a particle with itself only pad the list.
        const Number real = distance > 0.0 ? Number{} + 1.0 : Number{};
        contribution[A::at_cover] *= real;
        for (std::size_t q = 0; q < A::size; ++q) own.sum[q] += contribution[q];
        if (!pair.both) return;
        theirs[A::at_cover] *= real;
        pair.template give<Own::size>(theirs, [=](Index j) { return sums[j].x.data(); });
      },
      [=](std::size_t i, auto& own) __attribute__((always_inline)) {
        add_to_first(volumes[i] * centre, own.sum[A::at_cover]);
        own.add_to(sums[i].x.data());
      });
  return sums;
}

/// Evens out stresses and volumes of a batch of particles, before the constitutive model is applied to the result.
/// moves [m]: displacements that even out the packing.
template <int D>
void even_out(const Setup<D>& setup, double interval, const State<D>& state, const Sums<Around<D>::size>* sums,
              Batch& batch, std::array<Quad, D>* moves) {
  using A = Around<D>;
  const Particles<D>& p = state.particles;
  const Index soil = batch.soil;
  std::array<Quad, Batch::most / n_lanes> bulk, stiffness_in_shear;
  for (std::size_t k = 0; k < batch.n_fours() * n_lanes; ++k) {
    const Elasticity elasticity = moduli(setup, p, batch.who[k]);
    bulk[k / n_lanes].v[k % n_lanes] = elasticity.bulk;
    stiffness_in_shear[k / n_lanes].v[k % n_lanes] = elasticity.shear;
  }
  const double h = setup.smoothing_length, scale = h * h / full_weight, density = setup.density[soil];
  const double longest = flow::longest_move * setup.spacing;
  const double grains = setup.grain_share[soil] / setup.grain_density[soil];
  const bool dilates = setup.constant_volume[soil] != 0;
  run_lanes([&]() __attribute__((always_inline)) {
    for (std::size_t q = 0; q < batch.n_fours(); ++q) {
      const Index* const i = &batch.who[q * n_lanes];
      Four& four = batch.fours[q];
      four.duration = 0.0;
      Lanes gradient[D * D], around[A::size], rate[6], mass, volume, coverage, shear, elastic;
      gather<Node<D>::at_gradient, D * D>(rows_at(state.nodes.data(), i), gradient);
      gather<0, A::size>({sums[i[0]].x.data(), sums[i[1]].x.data(), sums[i[2]].x.data(), sums[i[3]].x.data()}, around);
      take_stresses(p.stress, i, four.stress);
      take_each(p.mass, i, mass);
      take_each(p.volume, i, volume);
      take_each(state.external.coverage, i, coverage);
      take_each(state.external.saturation, i, four.saturation);
      const Lanes mean = (four.stress[0] + four.stress[1] + four.stress[2]) / 3.0;
      strain_rate<D>(gradient, rate);
      root_j2(rate, shear);
      shear *= 2.0 * interval;
      root_j2(four.stress, elastic);
      elastic *= flow::renewing / stiffness_in_shear[q].v;
      Lanes flows;
      take_each(state.scratch.flows, i, flows);
      const LaneMask flowing = flows > 0.0;
      const Lanes flowed = (flowing & (shear < elastic)) ? shear / elastic : Lanes{} + 1.0;
      for (int a = 0; a < n_components<D>; ++a) four.stress[a] += flow::stress_share * scale * flowed * around[a];
      // In wet soil, water fills the volume that the soil's motion leaves. Averaging this volume with particles that
      // hardly yield would press water out of them or draw it in. Only the error of rows that slide past each other is
      // evened out there, and volumes are not taken from positions.
      const LaneMask dry = coverage <= 0.5;
      Lanes renewed;
      take_each(state.scratch.yielded_since, i, renewed);
      renewed /= flow::volume_renewing;
      min_in_place(renewed, Lanes{} + 1.0);
      renewed = dry ? flowed : renewed;
      volume *= flowing ? 1.0 + flow::volume_share * scale * renewed * around[A::at_swelling] : Lanes{} + 1.0;
      const Lanes cover = around[A::at_cover] / setup.full_cover;
      Lanes* const crowding = &around[A::at_crowding];
      Lanes crowded{};
      for (int d = 0; d < D; ++d) {
        crowding[d] /= density;
        crowded += crowding[d] * crowding[d];
      }
      sqrt_in_place(crowded);
      const LaneMask inside = flowing & (crowded * h <= flow::surface) & (cover >= flow::inside_cover);
      volume *= inside & dry ? 1.0 - flow::packing_share * (cover - 1.0) : Lanes{} + 1.0;
      Lanes strain = shear;
      min_in_place(strain, Lanes{} + flow::largest_strain);
      if (dilates) {
        Lanes excess = mass / (density * volume) - 1.0 + mean / bulk[q].v;
        max_in_place(excess, Lanes{} - flow::largest_excess);
        min_in_place(excess, Lanes{} + flow::largest_excess);
        const Lanes rise = inside ? bulk[q].v * flow::dilatancy * strain * excess : Lanes{};
        for (int d = 0; d < 3; ++d) four.stress[d] -= rise;
      }
      Lanes move = flow::evening * h * h * strain, most = longest / (crowded > 0.0 ? crowded : Lanes{} + longest);
      min_in_place(move, most);
      for (std::size_t d = 0; d < D; ++d) moves[q][d].v = inside ? -move * crowding[d] : Lanes{};
      for (Lanes& none : four.strain) none = Lanes{};
      four.void_ratio = volume / (grains * mass) - 1.0;
      batch.volume[q].v = volume;
    }
  });
}

}  // namespace

template <int D>
void keep_flow_regular(const Setup<D>& setup, double dt, bool in_equilibrium, State<D>& state) {
  if (!setup.regular_flow) return;
  state.since_upkeep += dt;
  if (state.since_upkeep <
      std::max(flow::travel * setup.spacing / setup.stabilisers.sound_speed, flow::substeps * setup.longest_substep))
    return;
  const double interval = state.since_upkeep;
  state.since_upkeep = 0.0;
  Particles<D>& p = state.particles;
  Scratch<D>& scratch = state.scratch;
  see_what_yields(setup, in_equilibrium, state);
  const auto& flows = scratch.flows;
  if (setup.domain.all_of(flows.size(), [&](std::size_t i) { return flows[i] == 0.0; })) return;
  fill_grains<D>(setup.domain, state, scratch);
  stress_slopes<D>(setup.domain, state,
                   setup.domain.any_of(flows.size(), [&](std::size_t i) { return flows[i] < 0.0; }), scratch);
  const auto* const sums = sum_neighbours<D>(state, setup.smoothing_length, scratch);
  const auto treated = [&](Index i) {
    // Soil beside particles that yielded a little is also averaged with them.
    const auto* const around = sums[i].x.data();
    const bool evened =
        flows[i] > 0.0 || std::any_of(around, around + n_components<D>, [](double x) { return x != 0.0; });
    return evened && !state.near.pairs.skips(i) && !state.regions.sleeps(i);
  };
  for_batches(state, treated, [&](Batch& batch) {
    std::array<std::array<Quad, D>, Batch::most / n_lanes> moves;
    even_out<D>(setup, interval, state, sums, batch, moves.data());
    follow_strains(setup, batch, p);  // returns the stress to the yield surface
    for (std::size_t k = 0; k < batch.count; ++k) {
      const Index i = batch.who[k];
      const std::size_t q = k / n_lanes, lane = k % n_lanes;
      p.volume[i] = batch.volume[q].v[lane];
      for (int c = 0; c < 6; ++c) p.stress[i][c] = batch.fours[q].stress[c][lane];
      for (std::size_t d = 0; d < D && i < p.free(); ++d)
        p.position[i][static_cast<Eigen::Index>(d)] += moves[q][d].v[lane];
    }
  });
}

template void keep_flow_regular<2>(const Setup<2>&, double, bool, State<2>&);
template void keep_flow_regular<3>(const Setup<3>&, double, bool, State<3>&);

}  // namespace poretwin::solid
