#include "solid_solver/discretisation/ranks.hpp"

#include "solid_solver/discretisation/state_arrays.hpp"

#include <algorithm>
#include <cmath>

namespace poretwin::solid {
namespace {

/// Calls visit(sum) for every sum over particles in the state, of which each rank has the part of its own.
template <int D, class Visit>
void for_each_sum(State<D>& state, const Visit& visit) {
  for (double* sum : {&state.regions.watched, &state.regions.slept}) visit(*sum);
  for (int d = 0; d < D; ++d) visit(state.from_outside[d]);
}

/// After particles have moved between ranks: counts the fixed ones, which have the highest ids and no part in regions
/// that sleep.
template <int D>
void count_held(GlobalId first_held, State<D>& state) {
  Particles<D>& p = state.particles;
  const auto is_held = [&](GlobalId id) { return id >= first_held; };
  p.held = static_cast<std::size_t>(std::ranges::count_if(p.share.ids, is_held));
  for_each_array(state.regions,
                 [n = p.share.ids.size() - p.held](auto& array) { array.resize(std::min(array.size(), n)); });
}

/// The arrays that any rank uses, with an entry for each of this rank's n particles: also for fixed ones, and without
/// copies and images.
template <int D>
ParticleArrays arrays_of(const Setup<D>& setup, State<D>& state, std::size_t n) {
  ScalarArray in_use;
  for_each_array(setup, state, [&](const auto& array, std::size_t) { in_use.push_back(array.empty() ? 0.0 : 1.0); });
  setup.domain.sum(in_use);
  ParticleArrays arrays;
  auto used = in_use.begin();
  for_each_array(setup, state, [&](auto& array, std::size_t each) {
    if (*used++ == 0.0) return;
    array.resize(n * each);
    arrays.add(array, each);
  });
  return arrays;
}

}  // namespace

template <int D>
void begin_with_share(const Setup<D>& setup, State<D>& state) {
  if (!setup.tiling) return;
  Particles<D>& p = state.particles;
  const ParticleArrays arrays = arrays_of(setup, state, p.size());
  p.share.first_held = p.free();
  std::vector<Index> own;
  for (std::size_t i = 0; i < p.size(); ++i)
    if (setup.tiling->begins_with(i)) own.push_back(static_cast<Index>(i));
  arrays.reorder(own);
  p.share.ids.assign(own.begin(), own.end());
  count_held(p.share.first_held, state);
  // What has been summed so far belongs to the rank that leads: the ranks' parts add up to the whole.
  if (!setup.tiling->leads()) for_each_sum(state, [](double& sum) { sum = 0.0; });
}

template <int D>
void share_out(const Setup<D>& setup, State<D>& state) {
  if (!setup.tiling) return;
  Particles<D>& p = state.particles;
  RankShare& share = p.share;
  const ParticleArrays arrays = arrays_of(setup, state, share.ids.size());
  share.copies = 0;
  setup.tiling->send_to_owners(p.position, share.ids, arrays);
  count_held(share.first_held, state);
  const std::size_t n = p.size(), n_free = p.free();

  const VecArray<D> views = sph::places_that_see_images<D>(setup.boundaries.planes, setup.range(), p.position);
  const std::size_t copies = setup.tiling->find_copies(p.position, share.ids, setup.range(), views), all = n + copies;
  for (auto* vectors : {&p.position, &p.displacement, &p.velocity, &state.body}) vectors->resize(all, Vec<D>::Zero());
  for (auto* slips : {&p.slip, &p.slipped, &p.wall_slope})
    if (setup.boundaries.any_frictional()) slips->resize(all, Vec<D>::Zero());
  for (auto* numbers : {&p.mass, &p.plastic_strain}) numbers->resize(all, 0.0);
  p.stress.resize(all, Tensor::Zero());
  share.copies = copies;
  // What fill_nodes() does not bring up to date.
  fill_copies(setup.domain, std::span(p.position));
  fill_copies(setup.domain, std::span(p.mass));
  ScalarArray rests(all, 0.0);
  for (std::size_t i = 0; i < n; ++i) rests[i] = i >= n_free || state.regions.sleeps(i) ? 1.0 : 0.0;
  fill_copies(setup.domain, std::span(rests));
  share.at_rest.assign(copies, 0);
  std::transform(rests.begin() + static_cast<std::ptrdiff_t>(n), rests.end(), share.at_rest.begin(),
                 [](double rest) { return rest > 0.0 ? char{1} : char{0}; });
}

template <int D>
State<D> collected(const Setup<D>& setup, const State<D>& state) {
  State<D> whole = state;
  Particles<D>& p = whole.particles;
  const ParticleArrays arrays = arrays_of(setup, whole, p.size());
  setup.tiling->send_to_leader(p.share.ids, arrays);
  count_held(p.share.first_held, whole);
  p.share = {};
  whole.near = {};
  whole.kernel.clear();
  for_each_sum(whole, [&](double& sum) { sum = setup.domain.sum(sum); });
  return whole;
}

template State<2> collected<2>(const Setup<2>&, const State<2>&);
template State<3> collected<3>(const Setup<3>&, const State<3>&);
template void begin_with_share<2>(const Setup<2>&, State<2>&);
template void begin_with_share<3>(const Setup<3>&, State<3>&);
template void share_out<2>(const Setup<2>&, State<2>&);
template void share_out<3>(const Setup<3>&, State<3>&);

}  // namespace poretwin::solid
