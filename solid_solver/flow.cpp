#include "solid_solver/flow.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace poretwin::solid {
namespace {

constexpr double travel = 3.0;          // of waves between two treatments, in spacings
constexpr double stress_share = 0.5;    // of the neighbours' average
constexpr double volume_share = 0.2;    // of the neighbours' average
constexpr double packing_share = 0.1;   // of the error of sum V W
constexpr double evening = 1.0;         // h^2 of motion per crowding and shear strain
constexpr double longest_move = 0.05;   // in spacings
constexpr double surface = 0.25;        // |sum V grad W| h beyond which a particle lies at a surface (flat: 0.7)
constexpr double dilatancy = 2.0;       // volumetric strain per shear strain and relative density
constexpr double largest_strain = 0.1;  // between two treatments: loose particles see more
constexpr double largest_excess = 0.1;  // of relative density

/// h^2 sum V |W'/r| over a full neighbourhood, in 2D and in 3D.
constexpr double full_weight = 3.5;

/// The particle whose stress and volume node j shows: itself, its original across a periodic side; none behind walls.
template <int D>
std::optional<std::size_t> source_of(const State<D>& state, std::size_t j) {
  const std::size_t n = state.particles.size();
  if (j < n) return j;
  const ImageRule<D>& rule = state.near.images[j - n];
  return rule.periodic ? std::optional<std::size_t>(rule.parent) : std::nullopt;
}

/// How many of a stress's components can differ from zero.
template <int D>
constexpr int n_components = D == 2 ? 4 : 6;
template <int D>
using Components = Eigen::Matrix<double, n_components<D>, 1>;

template <int D>
Components<D> components(const Tensor& t) {
  return t.template head<n_components<D>>();
}

/// Stress gradients [Pa/m] of the particles that flow, exact for linear stress up to the soil's surface.
template <int D>
void stress_slopes(const State<D>& state, Scratch<D>& scratch) {
  const auto& p = state.particles;
  const std::size_t n = p.size();
  scratch.slope.assign(n, Eigen::Matrix<double, n_components<D>, D>::Zero());
  scratch.moment.assign(n, Mat<D>::Zero());
  for_each_pair(state.near.pairs, [&](std::size_t i, std::size_t node, std::size_t m, bool both) {
    const auto j = source_of(state, node);
    if (!j || !(scratch.flows[i] || (both && scratch.flows[*j]))) return;
    const Vec<D> r = state.nodes[i].position - state.nodes[node].position, w = state.kernel[m] * r;
    const Eigen::Matrix<double, n_components<D>, D> rise =
        (components<D>(p.stress[*j]) - components<D>(p.stress[i])) * w.transpose();
    const Mat<D> square = r * w.transpose();
    scratch.slope[i] += p.volume[*j] * rise;
    scratch.moment[i] -= p.volume[*j] * square;
    if (!both) return;
    scratch.slope[*j] += p.volume[i] * rise;
    scratch.moment[*j] -= p.volume[i] * square;
  });
  for (std::size_t i = 0; i < n; ++i)
    if (scratch.flows[i]) scratch.slope[i] = (scratch.slope[i] * invert_moment<D>(scratch.moment[i])).eval();
}

/// Kernel sums around the particles that flow: what neighbours' linear stresses do not explain, how much larger the
/// neighbours' volumes are, how crowded and how covered each place is.
template <int D>
void sum_neighbours(const State<D>& state, double h, Scratch<D>& scratch) {
  const auto& p = state.particles;
  const std::size_t n = p.size();
  scratch.noise.assign(n, Components<D>::Zero());
  scratch.swelling.assign(n, 0.0);
  scratch.crowding.assign(n, Vec<D>::Zero());
  scratch.cover.resize(n);
  for (std::size_t i = 0; i < n; ++i) scratch.cover[i] = p.volume[i] * sph::WendlandC2<D>::value(0.0, h);
  for_each_pair(state.near.pairs, [&](std::size_t i, std::size_t node, std::size_t m, bool both) {
    const Node<D>&self = state.nodes[i], &other = state.nodes[node];
    const bool own = scratch.flows[i], theirs = both && scratch.flows[node];
    if (!own && !theirs) return;
    const Vec<D> r = self.position - other.position;
    const double k = state.kernel[m], value = sph::WendlandC2<D>::value(r.norm(), h);
    scratch.crowding[i] += (other.volume * other.density * k) * r;
    scratch.cover[i] += other.volume * value;
    if (both) {
      scratch.crowding[node] -= (self.volume * self.density * k) * r;
      scratch.cover[node] += self.volume * value;
    }
    const auto j = source_of(state, node);
    if (!j || !own || !scratch.flows[*j]) return;
    const Components<D> noise = k * (components<D>(p.stress[*j]) - components<D>(p.stress[i]) +
                                     0.5 * ((scratch.slope[i] + scratch.slope[*j]) * r));
    const double ratio = p.volume[*j] * p.mass[i] / (p.mass[*j] * p.volume[i]);
    scratch.noise[i] -= p.volume[*j] * noise;
    scratch.swelling[i] -= p.volume[*j] * k * (ratio - 1.0);
    if (!both) return;
    scratch.noise[*j] += p.volume[i] * noise;
    scratch.swelling[*j] -= p.volume[i] * k * (1.0 / ratio - 1.0);
  });
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
    setup.models[p.material[i]]->advance(
        p.stress[i], Tensor::Zero(),
        {state.external.saturation[i], setup.grain_density[p.material[i]] * p.volume[i] / p.mass[i] - 1.0});
  };
  stress_slopes<D>(state, scratch);
  sum_neighbours<D>(state, h, scratch);
  for (std::size_t i = 0; i < n; ++i) {
    if (!scratch.flows[i]) continue;
    const double density = setup.density[p.material[i]], reference = p.mass[i] / density;
    const Vec<D> crowding = scratch.crowding[i] / density;
    Tensor& stress = p.stress[i];
    const double mean = trace(stress) / 3.0;
    double& volume = p.volume[i];
    stress.template head<n_components<D>>() += stress_share * scale * scratch.noise[i];
    volume *= 1.0 + volume_share * scale * scratch.swelling[i];
    if (crowding.norm() * h > surface || scratch.cover[i] < 0.8) {
      models(i);
      continue;
    }
    // In wet soil the water's pressure keeps the volume; a density taken from the positions would squeeze it.
    if (state.external.coverage[i] <= 0.5) volume *= 1.0 - packing_share * (scratch.cover[i] - 1.0);
    const double strain = std::min(largest_strain, interval * 2.0 * root_j2(strain_rate<D>(p.gradient[i])));
    if (setup.constant_volume[p.material[i]]) {
      const double bulk = setup.models[p.material[i]]->elasticity().bulk;
      const double excess = reference / volume - 1.0 + mean / bulk;
      const double rise = bulk * dilatancy * strain * std::clamp(excess, -largest_excess, largest_excess);
      for (int d = 0; d < 3; ++d) stress[d] -= rise;
    }
    models(i);
    if (i >= p.free()) continue;
    Vec<D> move = -(evening * strain * h * h) * crowding;
    const double length = move.norm(), most = longest_move * setup.spacing;
    if (length > most) move *= most / length;
    p.position[i] += move;
  }
}

template void keep_flow_regular<2>(const Setup<2>&, double, State<2>&);
template void keep_flow_regular<3>(const Setup<3>&, double, State<3>&);

}  // namespace poretwin::solid
