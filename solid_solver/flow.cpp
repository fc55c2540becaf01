#include "solid_solver/flow.hpp"

#include "solid_solver/pair_loops.hpp"

#include <algorithm>
#include <cmath>

namespace poretwin::solid {
namespace {

constexpr double travel = 3.0;          // of waves between two treatments, in spacings
constexpr double stress_share = 0.5;    // of the neighbours' average
constexpr double volume_share = 0.2;    // of the neighbours' average
constexpr double packing_share = 0.1;   // of the error of sum V W
constexpr double evening = 1.0;         // h^2 of motion per crowding and shear strain
constexpr double longest_move = 0.05;   // in spacings
constexpr double renewing = 0.1;        // shear strain in which a stress is evened out, over the elastic one, tau / G
constexpr double surface = 0.25;        // |sum V grad W| h beyond which a particle lies at a surface (flat: 0.7)
constexpr double dilatancy = 2.0;       // volumetric strain per shear strain and relative density
constexpr double largest_strain = 0.1;  // between two treatments: loose particles see more
constexpr double largest_excess = 0.1;  // of relative density

/// h^2 sum V |W'/r| over a full neighbourhood, in 2D and in 3D.
constexpr double full_weight = 3.5;

/// How many of a stress's components can differ from zero.
template <int D>
constexpr int n_components = D == 2 ? 4 : 6;

/// What the sums read of nodes, four at a time.
template <int D>
void fill_grains(const State<D>& state, Scratch<D>& scratch) {
  const auto& p = state.particles;
  scratch.grains.resize(state.nodes.size());
  auto fill = [&](std::size_t j) {
    const Node<D>& node = state.nodes[j];
    Grain<D>& grain = scratch.grains[j];
    const ImageRule<D>* const image = j < p.size() ? nullptr : &state.near.images[j - p.size()];
    const std::size_t source = image ? image->parent : j;
    grain.position = node.position;
    grain.volume = node.volume;
    grain.mass = node.volume * node.density;
    grain.shown = image && !image->periodic ? 0.0 : p.volume[source];
    grain.swollen = p.volume[source] / p.mass[source];
    grain.flows = scratch.flows[source] ? 1.0 : 0.0;
    grain.stress = p.stress[source].template head<n_components<D>>();
  };
  for_each_side_by_side(p.size(), fill);  // those asleep, too: others feel them
  for (std::size_t j = p.size(); j < state.nodes.size(); ++j) fill(j);
}

/// Stress gradients [Pa/m] of the particles that flow, exact for linear stress up to the soil's surface.
template <int D>
void stress_slopes(const State<D>& state, Scratch<D>& scratch) {
  using G = Grain<D>;
  constexpr std::size_t n_slopes = n_components<D> * D + D * (D + 1) / 2;
  using Own = Sums<n_slopes>;
  constexpr std::size_t n_stress = n_components<D>;
  const std::size_t n = state.particles.size();
  const Pairs& pairs = state.near.pairs;
  const PairView list(pairs);
  const G* const grains = scratch.grains.data();
  const float* const kernels = state.kernel.data();
  Own* const sums = scratch.template zero_sums<n_slopes>(n);
  for_rows_in_lanes(
      pairs, 0, n, [=](std::size_t i) __attribute__((always_inline)) {
        const double* const self = grains[i].row();
        const double shown = grains[i].shown;
        Lanes own[Own::size] = {};
        for_four_pairs(
            list, i, [&](std::size_t m, bool both) __attribute__((always_inline)) {
              const Index* const index = &list.index[m];
              const auto rows = rows_at(grains, index);
              Lanes head[G::at_stress], stress[n_stress], w[D], r[D], felt[Own::size] = {};
              gather<0, G::at_stress>(rows, head);
              if (self[G::at_flows] == 0.0 && !(both && any(head[G::at_flows] > 0.0))) return;
              gather<G::at_stress, n_stress>(rows, stress);
              Lanes k;
              take(&kernels[m], k);
              for (std::size_t d = 0; d < D; ++d) {
                r[d] = self[d] - head[d];
                w[d] = k * r[d];
              }
              std::size_t c = 0;
              for (std::size_t d = 0; d < D; ++d)
                for (std::size_t a = 0; a < n_stress; ++a) felt[c++] = (stress[a] - self[G::at_stress + a]) * w[d];
              for (std::size_t b = 0; b < D; ++b)
                for (std::size_t a = 0; a <= b; ++a) felt[c++] = -r[a] * w[b];
              for (std::size_t q = 0; q < c; ++q) own[q] += head[G::at_shown] * felt[q];
              if (!both) return;
              for (std::size_t q = 0; q < c; ++q) felt[q] *= shown;
              scatter_add<Own::size>(felt, sums_at(sums, index));
            });
        add_lanes<Own::size>(own, sums[i].x.data());
      });
  for_rows(pairs, 0, n, [&](std::size_t i) {
    if (!scratch.flows[i]) return;
    const double* const sum = sums[i].x.data();
    const double* square = sum + n_stress * D;
    Mat<D> moment;
    for (int b = 0; b < D; ++b)
      for (int a = 0; a <= b; ++a) moment(a, b) = moment(b, a) = *square++;
    scratch.grains[i].slope =
        Eigen::Map<const Eigen::Matrix<double, n_components<D>, D>>(sum) * invert_moment<D>(moment);
  });
  for (std::size_t j = n; j < scratch.grains.size(); ++j)
    scratch.grains[j].slope = scratch.grains[state.near.images[j - n].parent].slope;
}

/// Kernel sums around the particles that flow (Around): what neighbours' linear stresses do not explain, how much
/// larger the neighbours' volumes are, how crowded and how covered each place is.
template <int D>
const Sums<Around<D>::size>* sum_neighbours(const State<D>& state, double h, Scratch<D>& scratch) {
  using G = Grain<D>;
  using A = Around<D>;
  using Own = Sums<A::size>;
  constexpr std::size_t n_stress = n_components<D>;
  const std::size_t n = state.particles.size();
  const Pairs& pairs = state.near.pairs;
  const double centre = sph::WendlandC2<D>::value(0.0, h), half_inverse = 0.5 / h;
  const PairView list(pairs);
  const G* const grains = scratch.grains.data();
  const float* const kernels = state.kernel.data();
  const double* const volumes = state.particles.volume.data();
  Own* const sums = scratch.template zero_sums<A::size>(n);
  for_rows_in_lanes(
      pairs, 0, n, [=](std::size_t i) __attribute__((always_inline)) {
        const double* const self = grains[i].row();
        Lanes own[Own::size] = {};
        for_four_pairs(
            list, i, [&](std::size_t m, bool both) __attribute__((always_inline)) {
              const Index* const index = &list.index[m];
              const auto rows = rows_at(grains, index);
              Lanes head[G::at_stress], other[n_stress], slope[n_stress * D], r[D], felt[Own::size] = {},
                                                                                    theirs[Own::size] = {};
              gather<0, G::at_stress>(rows, head);
              const bool flows = self[G::at_flows] > 0.0;
              if (!flows && !(both && any(head[G::at_flows] > 0.0))) return;
              Lanes k;
              take(&kernels[m], k);
              Lanes distance{};
              for (std::size_t d = 0; d < D; ++d) {
                r[d] = self[d] - head[d];
                distance += r[d] * r[d];
              }
              take_root(distance);
              Lanes u = 1.0 - half_inverse * distance;
              raise_to(u, Lanes{});
              const Lanes value = centre * (u * u) * (u * u) * (5.0 - 4.0 * u);
              felt[A::at_cover] = head[G::at_volume] * value;
              theirs[A::at_cover] = self[G::at_volume] * value;
              for (std::size_t d = 0; d < D; ++d) {
                felt[A::at_crowding + d] = head[G::at_mass] * k * r[d];
                theirs[A::at_crowding + d] = -self[G::at_mass] * k * r[d];
              }
              if (flows) {
                gather<G::at_stress, n_stress>(rows, other);
                gather<G::at_slope, n_stress * D>(rows, slope);
                const Lanes weight = -k * head[G::at_flows], they = weight * head[G::at_shown],
                            me = weight * self[G::at_shown];
                for (std::size_t a = 0; a < n_stress; ++a) {
                  Lanes unexplained = other[a] - self[G::at_stress + a];
                  for (std::size_t d = 0; d < D; ++d)
                    unexplained += 0.5 * (self[G::at_slope + n_stress * d + a] + slope[n_stress * d + a]) * r[d];
                  felt[a] = they * unexplained;
                  theirs[a] = -me * unexplained;
                }
                felt[A::at_swelling] = they * (head[G::at_swollen] / self[G::at_swollen] - 1.0);
                theirs[A::at_swelling] = me * (self[G::at_swollen] / head[G::at_swollen] - 1.0);
              }
              // A pair with itself fills the list up.
              const Lanes real = distance > 0.0 ? Lanes{} + 1.0 : Lanes{};
              felt[A::at_cover] *= real;
              for (std::size_t q = 0; q < A::size; ++q) own[q] += felt[q];
              if (!both) return;
              theirs[A::at_cover] *= real;
              scatter_add<Own::size>(theirs, sums_at(sums, index));
            });
        own[A::at_cover][0] += volumes[i] * centre;
        add_lanes<Own::size>(own, sums[i].x.data());
      });
  return sums;
}

}  // namespace

template <int D>
void keep_flow_regular(const Setup<D>& setup, double dt, State<D>& state) {
  if (!setup.regular_flow) return;
  state.since_upkeep += dt;
  if (state.since_upkeep * setup.stabilisers.sound_speed < travel * setup.spacing) return;
  const double interval = state.since_upkeep;
  state.since_upkeep = 0.0;
  Particles<D>& p = state.particles;
  const std::size_t n = p.size();
  Scratch<D>& scratch = state.scratch;
  scratch.flows.resize(n);
  for (std::size_t i = 0; i < n; ++i) scratch.flows[i] = p.plastic_strain[i] > setup.flow_limit;
  if (std::none_of(scratch.flows.begin(), scratch.flows.end(), [](char flows) { return flows; })) return;
  const double h = setup.smoothing_length, scale = h * h / full_weight;
  auto models = [&](std::size_t i) {  // brings the stress back to what the soil can bear
    setup.models[p.material[i]]->advance(p.stress[i], Tensor::Zero(),
                                         condition(setup, p, i, state.external.saturation[i]));
  };
  fill_grains<D>(state, scratch);
  stress_slopes<D>(state, scratch);
  const auto* const sums = sum_neighbours<D>(state, h, scratch);
  for_rows(state.near.pairs, 0, n, [&](std::size_t i) {
    if (!scratch.flows[i] || state.regions.sleeps(i)) return;
    const double density = setup.density[p.material[i]], reference = p.mass[i] / density;
    const double* const around = sums[i].x.data();
    const double cover = around[Around<D>::at_cover] / setup.full_cover;
    const Vec<D> crowding = Eigen::Map<const Vec<D>>(around + Around<D>::at_crowding) / density;
    Tensor& stress = p.stress[i];
    const double mean = trace(stress) / 3.0;
    double& volume = p.volume[i];
    const double shear = interval * 2.0 * root_j2(strain_rate<D>(state.nodes[i].gradient));
    const double elastic = root_j2(stress) / setup.models[p.material[i]]->elasticity().shear;
    const double flowed = shear < renewing * elastic ? shear / (renewing * elastic) : 1.0;
    stress.template head<n_components<D>>() +=
        flowed * stress_share * scale * Eigen::Map<const Eigen::Matrix<double, n_components<D>, 1>>(around);
    volume *= 1.0 + flowed * volume_share * scale * around[Around<D>::at_swelling];
    if (crowding.norm() * h > surface || cover < 0.8) {
      models(i);
      return;
    }
    // In wet soil the water's pressure keeps the volume; a density taken from the positions would squeeze it.
    if (state.external.coverage[i] <= 0.5) volume *= 1.0 - packing_share * (cover - 1.0);
    const double strain = std::min(largest_strain, shear);
    if (setup.constant_volume[p.material[i]]) {
      const double bulk = setup.models[p.material[i]]->elasticity().bulk;
      const double excess = reference / volume - 1.0 + mean / bulk;
      const double rise = bulk * dilatancy * strain * std::clamp(excess, -largest_excess, largest_excess);
      for (int d = 0; d < 3; ++d) stress[d] -= rise;
    }
    models(i);
    if (i >= p.free()) return;
    Vec<D> move = -(evening * strain * h * h) * crowding;
    const double length = move.norm(), most = longest_move * setup.spacing;
    if (length > most) move *= most / length;
    p.position[i] += move;
  });
}

template void keep_flow_regular<2>(const Setup<2>&, double, State<2>&);
template void keep_flow_regular<3>(const Setup<3>&, double, State<3>&);

}  // namespace poretwin::solid
