#include "fluid_solver/discretisation/ranks.hpp"

#include "common/particles/images.hpp"
#include "fluid_solver/discretisation/stencil.hpp"

namespace poretwin::fluid {
namespace {

/// The arrays that any rank uses, with an entry for each of this rank's particles.
template <int D>
ParticleArrays arrays_of(const Setup<D>& setup, Particles<D>& p) {
  ScalarArray in_use;
  p.for_each_sparse_array([&](const auto& array) { in_use.push_back(array.is_allocated() ? 1.0 : 0.0); });
  setup.domain.sum(in_use);
  ParticleArrays arrays;
  p.for_each_dense_array([&](auto& array) { arrays.add(array); });
  auto used = in_use.begin();
  p.for_each_sparse_array([&](auto& array) {
    if (*used++ == 0.0) return;
    if (!array.is_allocated()) array.allocate(p.size());
    arrays.add(array.values());
  });
  return arrays;
}

}  // namespace

template <int D>
void begin_with_share(const Setup<D>& setup, Particles<D>& p) {
  if (!setup.tiling) return;
  std::vector<Index> own;
  for (std::size_t a = 0; a < p.size(); ++a)
    if (setup.tiling->begins_with(a)) own.push_back(static_cast<Index>(a));
  p.share.next = p.size();
  arrays_of(setup, p).reorder(own);
  p.share.ids.assign(own.begin(), own.end());
  share_out(setup, p);
}

template <int D>
void share_out(const Setup<D>& setup, Particles<D>& p) {
  if (setup.tiling) setup.tiling->send_to_owners(p.position, p.share.ids, arrays_of(setup, p));
}

template <int D>
Domain with_halo(const Setup<D>& setup, const Walls<D>& walls, const Particles<D>& p) {
  if (!setup.tiling) return setup.domain;
  const double largest = setup.domain.max_over(p.size(), 0.0, [&](std::size_t a) { return p.volume[a]; });
  // Images past lines of sight are made by mirrors in any order: as if all mirrors stood several times in a row.
  std::vector<sph::ImagePlane<D>> planes;
  for (int k = 0; k < (walls.sight.limited() ? sph::most_reflections : 1); ++k)
    planes.insert(planes.end(), walls.planes.begin(), walls.planes.end());
  return with_halo<D>(setup, planes, p, sph::support_radius * points::smoothing_ratio * spacing_of<D>(largest));
}

template <int D>
Domain with_halo(const Setup<D>& setup, std::span<const sph::ImagePlane<D>> planes, const Particles<D>& p,
                 double reach) {
  if (!setup.tiling) return setup.domain;
  const auto views = sph::places_that_see_images<D>(planes, reach, p.position);
  const std::size_t copies = setup.tiling->find_copies(p.position, p.share.ids, reach, views);
  return {setup.tiling->ranks(), p.size(), copies};
}

template <int D>
State<D> collected(const Setup<D>& setup, const State<D>& state) {
  State<D> whole = state;
  auto& p = whole.particles;
  const ParticleArrays arrays = arrays_of(setup, p);
  setup.tiling->send_to_leader(p.share.ids, arrays);
  p.share = {};
  return whole;
}

#define PORETWIN_INSTANTIATE(D)                                                                                 \
  template void begin_with_share(const Setup<D>&, Particles<D>&);                                               \
  template void share_out(const Setup<D>&, Particles<D>&);                                                      \
  template Domain with_halo(const Setup<D>&, const Walls<D>&, const Particles<D>&);                             \
  template Domain with_halo(const Setup<D>&, std::span<const sph::ImagePlane<D>>, const Particles<D>&, double); \
  template State<D> collected(const Setup<D>&, const State<D>&);
PORETWIN_INSTANTIATE(2)
PORETWIN_INSTANTIATE(3)
#undef PORETWIN_INSTANTIATE

}  // namespace poretwin::fluid
