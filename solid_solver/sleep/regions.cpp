#include "solid_solver/sleep/regions.hpp"

#include "solid_solver/discretisation/ranks.hpp"
#include "solid_solver/numerics/sleep.hpp"
#include "solid_solver/sleep/quiet.hpp"

#include <algorithm>
#include <cmath>

namespace poretwin::solid {
namespace {

/// Bounds below which soil counts as at rest, and above which a change of force counts as a disturbance.
template <int D>
struct Bounds {
  double way;     ///< time of an elastic wave through the soil [s]
  double moved;   ///< largest displacement of calm soil [m]
  double work;    ///< largest dissipation of calm soil [J/kg]: `regions`
                  ///< times the elastic energy under its weight
  double push;    ///< change of a force from outside, per mass, that wakes a particle [m/s2]
  double within;  ///< factor on `push` for forces of neighbours, which act on only a few rows of the soil's height
  double around;  ///< width of the soil that is woken around a disturbance [m]
  explicit Bounds(const Setup<D>& setup) {
    const double g = setup.gravity.norm(), rest = setup.quiet.regions * g;
    way = setup.height / setup.stabilisers.sound_speed;
    moved = 0.5 * rest * std::pow(sleep::calm_after * way, 2);
    work = 0.5 * rest * g * way * way;
    push = setup.quiet.wake_above * g;
    within = setup.height / (2.0 * setup.spacing);
    around = sleep::margin * setup.range();
  }
};

/// Positions of disturbances or activity, for queries whether one of them lies within `reach` [m].
template <int D>
class Places {
 public:
  Places(const VecArray<D>& places, double reach) : reach_(reach) { grid_.build(places, reach); }
  [[nodiscard]] bool near(const Vec<D>& x) const {
    bool found = false;
    grid_.for_each_within(x, reach_, [&](Index, double) { found = true; });
    return found;
  }

 private:
  sph::CellGrid<D> grid_;
  double reach_;
};

/// Whether the forces on the sleeping particle i, or its saturation, have changed by more than the bounds.
template <int D>
bool is_disturbed(const Setup<D>& setup, const Bounds<D>& bounds, const Drive<D>& drive, const State<D>& state,
                  std::size_t i) {
  const Particles<D>& p = state.particles;
  const Regions<D>& regions = state.regions;
  if (setup.softened_by_water[p.material[i]] &&
      std::abs(state.external.saturation[i] - regions.saturation[i]) > sleep::softening)
    return true;
  const double push = bounds.push * p.mass[i];
  if ((force_from_outside(drive, i) - regions.outside[i]).norm() > push) return true;
  return !state.near.pairs.skips(i) &&
         (p.volume[i] * state.force[i].internal() - regions.mark[i]).norm() > bounds.within * push;
}

/// Records which particles have moved or yielded. Returns their positions, and those of sleeping particles that were
/// disturbed, of all ranks.
template <int D>
VecArray<D> disturbances(const Setup<D>& setup, const Bounds<D>& bounds, const Drive<D>& drive, State<D>& state) {
  const Particles<D>& p = state.particles;
  Regions<D>& regions = state.regions;
  VecArray<D> places;
  for (std::size_t i = 0; i < p.free(); ++i) {
    if (regions.sleeps(i)) {
      if (is_disturbed(setup, bounds, drive, state, i)) places.push_back(p.position[i]);
      continue;
    }
    const double work = root_j2(p.stress[i]) * (p.plastic_strain[i] - regions.sheared[i]);
    const bool moved = (p.displacement[i] - regions.mark[i]).squaredNorm() > bounds.moved * bounds.moved;
    if (!moved && work < bounds.work * setup.density[p.material[i]]) continue;
    regions.mark[i] = p.displacement[i];
    regions.sheared[i] = p.plastic_strain[i];
    regions.last_active[i] = regions.clock;
    places.push_back(p.position[i]);
  }
  return of_all_ranks(setup, std::move(places));
}

/// Wakes sleeping particles within reach of one of the places, and particles around them. Returns whether any woke on
/// any rank.
template <int D>
bool wake_near(const Setup<D>& setup, const Bounds<D>& bounds, const VecArray<D>& places, State<D>& state) {
  const Particles<D>& p = state.particles;
  Regions<D>& regions = state.regions;
  if (!setup.domain.any(!regions.asleep.empty()) || !setup.domain.any(!places.empty())) return false;
  const Places<D> happening(places, setup.range());
  VecArray<D> affected;
  for (std::size_t i = 0; i < p.free(); ++i)
    if (regions.sleeps(i) && happening.near(p.position[i])) affected.push_back(p.position[i]);
  affected = of_all_ranks(setup, std::move(affected));
  if (!setup.domain.any(!affected.empty())) return false;
  const Places<D> waking(affected, bounds.around);
  for (std::size_t i = 0; i < p.free(); ++i) {
    if (!regions.sleeps(i) || !waking.near(p.position[i])) continue;
    regions.asleep[i] = 0;
    regions.mark[i] = p.displacement[i];
    regions.last_active[i] = regions.clock - sleep::calm_after * bounds.way;  // it still counts as calm
  }
  return true;
}

/// Lets calm particles fall asleep if all around them are calm, too. Returns whether any fell asleep on any rank.
template <int D>
bool fall_asleep(const Setup<D>& setup, const Bounds<D>& bounds, const Drive<D>& drive, State<D>& state) {
  Particles<D>& p = state.particles;
  Regions<D>& regions = state.regions;
  const double since = regions.clock - sleep::asleep_after * bounds.way;
  VecArray<D> restless;
  for (std::size_t i = 0; i < p.free(); ++i)
    if (!regions.sleeps(i) && regions.last_active[i] > since) restless.push_back(p.position[i]);
  const bool some_calm = restless.size() < p.free();
  const Places<D> happening(of_all_ranks(setup, std::move(restless)), bounds.around);
  bool any = false;
  for (std::size_t i = 0; i < p.free() && some_calm; ++i) {
    if (regions.sleeps(i) || regions.last_active[i] > since || happening.near(p.position[i])) continue;
    regions.asleep.resize(p.free(), 0);
    regions.asleep[i] = 1;
    regions.mark[i] = p.volume[i] * state.force[i].internal();
    regions.outside[i] = force_from_outside(drive, i);
    regions.saturation.set(i, state.external.saturation[i], p.free());
    p.velocity[i].setZero();
    state.nodes[i].gradient.setZero();
    if (!p.slip.empty()) p.slip[i].setZero();
    any = true;
  }
  return setup.domain.any(any);
}

/// Builds lists and forces anew after the set of sleeping particles has changed.
template <int D>
void renew(const Setup<D>& setup, State<D>& state) {
  auto& asleep = state.regions.asleep;
  if (!setup.domain.any(std::any_of(asleep.begin(), asleep.end(), [](char sleeps) { return sleeps; }))) asleep.clear();
  rebuild_lists(setup, state);
  for (std::size_t i = 0; i < state.particles.free(); ++i)
    if (state.near.pairs.skips(i)) state.particles.velocity[i].setZero();
  evaluate_forces(setup, state);
}

}  // namespace

template <int D>
void watch_regions(const Setup<D>& setup, const Drive<D>& drive, double dt, State<D>& state) {
  const Particles<D>& p = state.particles;
  Regions<D>& regions = state.regions;
  if (setup.quiet.regions <= 0.0) return;
  regions.clock += dt;
  const double passed = regions.clock - regions.last_activity_check;
  if (passed * setup.stabilisers.sound_speed < sleep::travel * setup.spacing) return;
  regions.last_activity_check = regions.clock;
  if (setup.domain.all(regions.last_active.empty())) {
    const auto flows = [&](double plastic) { return plastic > setup.flow_limit; };
    if (!setup.domain.any(std::any_of(p.plastic_strain.begin(), p.plastic_strain.end(), flows))) return;
    regions.last_active.assign(p.free(), regions.clock);
    regions.mark = p.displacement;
    regions.outside.assign(p.free(), Vec<D>::Zero());
    regions.sheared = p.plastic_strain;
    regions.saturation = state.external.saturation;
    regions.calm.assign(p.free(), 0);
  }
  regions.watched += passed * static_cast<double>(p.free());
  regions.slept += passed * static_cast<double>(std::count(regions.asleep.begin(), regions.asleep.end(), char{1}));
  const Bounds<D> bounds(setup);
  bool changed = wake_near(setup, bounds, disturbances(setup, bounds, drive, state), state);
  if (regions.clock - regions.last_sleep_check > sleep::between_checks * bounds.way) {
    regions.last_sleep_check = regions.clock;
    changed = fall_asleep(setup, bounds, drive, state) || changed;
  }
  for (std::size_t i = 0; i < p.free(); ++i)
    regions.calm[i] = regions.last_active[i] <= regions.clock - sleep::calm_after * bounds.way;
  if (changed) renew(setup, state);
}

template <int D>
void wake_regions(const Setup<D>& setup, State<D>& state) {
  Regions<D>& regions = state.regions;
  const bool any = setup.domain.any(!regions.asleep.empty());
  regions.last_active.clear();
  regions.asleep.clear();
  regions.calm.clear();
  if (any) renew(setup, state);
}

#define PORETWIN_INSTANTIATE(D)                                                        \
  template void watch_regions<D>(const Setup<D>&, const Drive<D>&, double, State<D>&); \
  template void wake_regions<D>(const Setup<D>&, State<D>&);
PORETWIN_INSTANTIATE(2)
PORETWIN_INSTANTIATE(3)
#undef PORETWIN_INSTANTIATE

}  // namespace poretwin::solid
