#include "solid_solver/erosion/erosion.hpp"

#include "common/core/error.hpp"
#include "solid_solver/discretisation/state_arrays.hpp"
#include "solid_solver/dynamics/step.hpp"
#include "solid_solver/numerics/erosion.hpp"

#include <fmt/format.h>

#include <numeric>

namespace poretwin::solid {
namespace {

/// Sum of the lengths of sum_j V_j grad W_ij over the rows below a flat edge along the lattice, times the spacing. Of a
/// row's neighbours those beyond the edge are missing, and the one at m spacings is missing to m rows: sum m^2 F, with
/// F = -W'/r at the places of a row at the distance m. In the limit of close points it is a half.
template <int D>
double edge_of_lattice() {
  constexpr int reach = 2;  // spacings; the support of the kernel is 2.4
  constexpr int across = D == 3 ? reach : 0;
  double sum = 0.0;
  for (int m = 1; m <= reach; ++m)
    for (int i = -reach; i <= reach; ++i)
      for (int k = -across; k <= across; ++k)
        sum -= m * m *
               sph::WendlandC2<D>::derivative_over_r(std::sqrt(m * m + i * i + k * k), points::lengths_per_spacing);
  return sum;
}

/// Removes all particles except those listed, and builds lists and forces anew.
template <int D>
void keep_only(const Setup<D>& setup, std::span<const Index> kept, State<D>& state) {
  const std::size_t n = state.particles.size();
  ParticleArrays arrays;
  for_each_array(setup, state, [&](auto& array, std::size_t each) {
    if (array.empty()) return;
    array.resize(n * each);  // those of the regions have no entries for fixed particles, nodes have more for images
    arrays.add(array, each);
  });
  arrays.reorder(kept);
  for_each_array(state.regions,
                 [free = state.particles.free()](auto& array) { array.resize(std::min(array.size(), free)); });
  state.resistance.clear();
  state.sleep.asleep = false;
  rebuild(setup, state);
  evaluate_forces(setup, state);
  ++state.revision;
}

}  // namespace

template <int D>
std::vector<SurfacePart<D>> surface_parts(const Setup<D>& setup, const State<D>& state) {
  static const double edge = edge_of_lattice<D>();
  const Particles<D>& p = state.particles;
  const double h = setup.smoothing_length, self = sph::WendlandC2<D>::value(0.0, h);
  VecArray<D> gradient(p.size(), Vec<D>::Zero());  // of the coverage [1/m]
  std::vector<SurfacePart<D>> parts(p.size());
  for (std::size_t i = 0; i < p.size(); ++i) parts[i].coverage = p.volume[i] * self;
  for_each_ordered_pair(state.near.pairs, [&](std::size_t i, std::size_t j, std::size_t) {
    const Vec<D> r = state.nodes[i].position - state.nodes[j].position;
    const double distance = r.norm(), volume = state.nodes[j].volume;
    gradient[i] += volume * sph::WendlandC2<D>::derivative_over_r(distance, h) * r;
    parts[i].coverage += volume * sph::WendlandC2<D>::value(distance, h);
  });
  for (std::size_t i = 0; i < p.size(); ++i) {
    const double length = gradient[i].norm();
    if (length > 0.0) parts[i].normal = gradient[i] / length;
    parts[i].per_volume = length / edge;
  }
  return parts;
}

template <int D>
void erode(const Setup<D>& setup, double interval, const OrZero<double>& velocity, State<D>& state) {
  if (!setup.erodes || !velocity.is_allocated()) return;
  const Particles<D>& p = state.particles;
  Eroded& eroded = state.erosion;
  if (eroded.share.empty()) {
    eroded.share.assign(p.size(), 0.0);
    eroded.first_number.resize(p.size());
    std::iota(eroded.first_number.begin(), eroded.first_number.end(), Index{0});
  }
  eroded.shear_stress.assign(p.size(), 0.0);
  const auto parts = surface_parts(setup, state);
  std::vector<Index> kept;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const auto& law = setup.erosion[p.material[i]];
    const Vec<D> water = Eigen::Map<const Vec<D>>(velocity.values().data() + i * D);
    if (law && i < p.free() && !water.isZero(0.0)) {
      const Vec<D> slip = water - p.velocity[i], along = slip - parts[i].normal * parts[i].normal.dot(slip);
      eroded.shear_stress[i] = law->shear_stress(along.norm());
      const double speed = law->speed(eroded.shear_stress[i]);
      eroded.share[i] += interval * parts[i].per_volume * speed;
      if (speed > 0.0 && parts[i].coverage < erosion::least_coverage) eroded.share[i] = 1.0;
    }
    if (eroded.share[i] < 1.0) {
      kept.push_back(static_cast<Index>(i));
      continue;
    }
    eroded.particles += 1.0;
    eroded.grains += p.mass[i] / setup.grain_density[p.material[i]] * setup.grain_share[p.material[i]];
  }
  if (kept.size() == p.size()) return;
  if (kept.size() == p.held)
    throw Error(ExitCode::failure,
                fmt::format("the water has carried off all soil by t = {:.6g} s: expected a shorter case.end_time, or "
                            "soil that lasts",
                            state.time));
  keep_only<D>(setup, kept, state);
}

#define PORETWIN_INSTANTIATE(D)                                                            \
  template std::vector<SurfacePart<D>> surface_parts<D>(const Setup<D>&, const State<D>&); \
  template void erode<D>(const Setup<D>&, double, const OrZero<double>&, State<D>&);
PORETWIN_INSTANTIATE(2)
PORETWIN_INSTANTIATE(3)
#undef PORETWIN_INSTANTIATE

}  // namespace poretwin::solid
