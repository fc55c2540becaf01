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

template <int D>
using Slope = Eigen::Matrix<double, 6, D>;

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

/// Stress gradient [Pa/m], exact for linear stress up to the soil's surface.
template <int D>
Slope<D> stress_slope(const State<D>& state, std::size_t i) {
  const auto& pairs = state.near.pairs;
  const auto& p = state.particles;
  Mat<D> moment = Mat<D>::Zero();
  Slope<D> raw = Slope<D>::Zero();
  for (Index m = pairs.offset[i]; m < pairs.offset[i + 1]; ++m) {
    const auto j = source_of(state, pairs.index[m]);
    if (!j) continue;
    const Vec<D> r = state.nodes[i].position - state.nodes[pairs.index[m]].position;
    const Vec<D> w = (p.volume[*j] * state.kernel[m]) * r;
    raw += (p.stress[*j] - p.stress[i]) * w.transpose();
    moment -= r * w.transpose();
  }
  return raw * invert_moment<D>(moment);
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
  const auto& pairs = state.near.pairs;
  const std::size_t n = p.size();
  auto flows = [&](std::size_t i) { return p.plastic_strain[i] > setup.flow_limit; };
  std::vector<Slope<D>> slope(n, Slope<D>::Zero());
  bool any = false;
  for (std::size_t i = 0; i < n; ++i) {
    if (!flows(i)) continue;
    slope[i] = stress_slope<D>(state, i);
    any = true;
  }
  if (!any) return;

  const double h = setup.smoothing_length, scale = h * h / full_weight;
  std::vector<Tensor> stress = p.stress;
  ScalarArray volume = p.volume;
  for (std::size_t i = 0; i < n; ++i) {
    if (!flows(i)) continue;
    const double density = setup.density[p.material[i]], reference = p.mass[i] / density;
    Tensor noise = Tensor::Zero();
    double swelling = 0.0, cover = p.volume[i] * sph::WendlandC2<D>::value(0.0, h);
    Vec<D> crowding = Vec<D>::Zero();
    for (Index m = pairs.offset[i]; m < pairs.offset[i + 1]; ++m) {
      const Node<D>& other = state.nodes[pairs.index[m]];
      const Vec<D> r = state.nodes[i].position - other.position;
      crowding += (other.mass / density * state.kernel[m]) * r;
      cover += other.volume * sph::WendlandC2<D>::value(r.norm(), h);
      const auto j = source_of(state, pairs.index[m]);
      if (!j || !flows(*j)) continue;
      const double weight = -p.volume[*j] * state.kernel[m];
      noise += weight * (p.stress[*j] - p.stress[i] + 0.5 * ((slope[i] + slope[*j]) * r));
      swelling += weight * (p.volume[*j] * p.mass[i] / (p.mass[*j] * p.volume[i]) - 1.0);
    }
    stress[i] += stress_share * scale * noise;
    volume[i] *= 1.0 + volume_share * scale * swelling;
    if (crowding.norm() * h > surface || cover < 0.8) continue;
    volume[i] *= 1.0 - packing_share * (cover - 1.0);
    const double strain = std::min(largest_strain, interval * 2.0 * root_j2(strain_rate<D>(p.gradient[i])));
    if (setup.constant_volume[p.material[i]]) {
      const double bulk = setup.models[p.material[i]]->elasticity().bulk;
      const double excess = reference / volume[i] - 1.0 + trace(p.stress[i]) / (3.0 * bulk);
      const double rise = bulk * dilatancy * strain * std::clamp(excess, -largest_excess, largest_excess);
      for (int d = 0; d < 3; ++d) stress[i][d] -= rise;
    }
    if (i >= p.free()) continue;
    Vec<D> move = -(evening * strain * h * h) * crowding;
    const double length = move.norm(), most = longest_move * setup.spacing;
    if (length > most) move *= most / length;
    p.position[i] += move;
  }
  p.stress.swap(stress);
  p.volume.swap(volume);
}

template void keep_flow_regular<2>(const Setup<2>&, double, State<2>&);
template void keep_flow_regular<3>(const Setup<3>&, double, State<3>&);

}  // namespace poretwin::solid
