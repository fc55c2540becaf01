#include "fluid_solver/boundary/bed.hpp"

#include "common/core/threads.hpp"
#include "common/particles/neighbours.hpp"
#include "fluid_solver/motion/advection.hpp"
#include "fluid_solver/numerics/bed.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <optional>

namespace poretwin::fluid {

namespace {

/// The particles before each part of the bed, with weights V W, and the sum of each part's weights.
struct Reach {
  std::vector<Index> offset{0}, particle;
  ScalarArray weight, sum;
};

template <int D>
Reach particles_before(const Setup<D>& setup, const State<D>& state) {
  Reach reach;
  const auto& p = state.particles;
  const double h = bed::reach * setup.spacing, radius = sph::support_radius * h;
  sph::CellGrid<D> grid;
  grid.build(p.position, radius);
  for (const auto& part : state.bed) {
    double sum = 0.0;
    grid.for_each_within(part.centre, radius, [&](Index a, double r2) {
      if (part.normal.dot(p.position[a] - part.centre) <= 0.0) return;
      const double w = p.volume[a] * Kernel<D>::value(std::sqrt(r2), h);
      if (w == 0.0) return;
      reach.particle.push_back(a);
      reach.weight.push_back(w);
      sum += w;
    });
    reach.sum.push_back(sum);
    reach.offset.push_back(static_cast<Index>(reach.particle.size()));
  }
  return reach;
}

/// Mean pressure head before part i [m], from the piezometric pressures; zero where the part is dry.
template <int D>
double head_before(const Setup<D>& setup, const Reach& reach, std::size_t i, const State<D>& state) {
  if (reach.sum[i] == 0.0) return 0.0;
  double sum = 0.0;
  for (Index k = reach.offset[i]; k < reach.offset[i + 1]; ++k)
    sum += reach.weight[k] * state.particles.pressure[reach.particle[k]];
  const double pressure = sum / reach.sum[i];
  return std::max(0.0, pressure + setup.weight.dot(state.bed[i].centre - setup.origin)) / setup.weight.norm();
}

/// The particle nearest to a, not removed, near enough to merge with; a itself where there is none.
template <int D>
std::size_t partner_of(const sph::CellGrid<D>& grid, const Setup<D>& setup, const Particles<D>& p,
                       const std::vector<bool>& keep, std::size_t a) {
  std::size_t found = a;
  double nearest = HUGE_VAL;
  grid.for_each_within(p.position[a], bed::merged_within * setup.spacing, [&](Index b, double r2) {
    if (b == a || !keep[b] || r2 >= nearest) return;
    nearest = r2;
    found = b;
  });
  return found;
}

/// Particle b takes over a: mass, volume, momentum and centre of mass are conserved.
template <int D>
void merge(std::size_t a, std::size_t b, Particles<D>& p) {
  const double share = p.mass[a] / (p.mass[a] + p.mass[b]);
  p.position[b] += share * (p.position[a] - p.position[b]);
  p.velocity[b] += share * (p.velocity[a] - p.velocity[b]);
  p.pressure[b] += share * (p.pressure[a] - p.pressure[b]);
  p.mass[b] += p.mass[a];
  p.volume[b] += p.volume[a];
}

/// Unit vector in the direction in which the neighbours of particle a and its images behind walls are fewest: along the
/// eigenvector of the least eigenvalue of their moment, sum F r r^T with F = -W'/r. Neighbours are those in reach of
/// the kernel of half the volume; with all in reach of its own kernel a pond that rose from 5 to 9 rows was 0.3
/// spacings too high (0.01). Rows that grow are stretched, and particles that come into their wide gaps leave the
/// packing even.
template <int D>
Vec<D> roomiest_direction(const Walls<D>& walls, std::size_t a, const Particles<D>& p) {
  const double h = points::smoothing_ratio * spacing_of<D>(p.volume[a]),
               reach = sph::support_radius * points::smoothing_ratio * spacing_of<D>(0.5 * p.volume[a]);
  VecArray<D> near;
  for (const auto& x : p.position)
    if ((x - p.position[a]).squaredNorm() < reach * reach) near.push_back(x);
  const auto images = images_of<D>(near, walls.planes, walls.sight, walls.surfaces.get(), reach);
  near.insert(near.end(), images.position.begin(), images.position.end());
  Mat<D> moment = Mat<D>::Zero();
  for (const auto& x : near) {
    const Vec<D> r = x - p.position[a];
    moment -= Kernel<D>::derivative_over_r(r.norm(), h) * r * r.transpose();
  }
  Eigen::SelfAdjointEigenSolver<Mat<D>> eigen;
  eigen.computeDirect(moment);
  return eigen.eigenvectors().col(0);
}

/// Particle a and a new one share its volume, one of their spacings apart. The centre of mass stays.
template <int D>
void divide(const Walls<D>& walls, std::size_t a, Particles<D>& p) {
  const Vec<D> direction = roomiest_direction<D>(walls, a, p), before = p.position[a];
  p.mass[a] *= 0.5;
  p.volume[a] *= 0.5;
  const double apart = spacing_of<D>(p.volume[a]);
  const auto place = [&](double distance, Vec<D>& v) {
    Vec<D> x = before + distance * direction;
    keep_inside<D>(walls, before, apart, x, v);
    return x;
  };
  Vec<D> v = p.velocity[a];
  p.position[a] = place(-0.5 * apart, p.velocity[a]);
  const Vec<D> x = place(0.5 * apart, v);
  p.add(x, v, p.mass[a], p.void_fraction[a], p.volume[a], p.pressure[a], {p.wave_speed[a], false});
}

/// The part of the bed with its centre nearest to x.
template <int D>
BedPart<D>& nearest_part(const Vec<D>& x, State<D>& state) {
  return *std::min_element(state.bed.begin(), state.bed.end(), [&](const auto& i, const auto& j) {
    return (i.centre - x).squaredNorm() < (j.centre - x).squaredNorm();
  });
}

}  // namespace

template <int D>
BedPassage pass_bed(const Setup<D>& setup, double interval, State<D>& state) {
  const auto& p = state.particles;
  const Reach reach = particles_before(setup, state);
  BedPassage passage{ScalarArray(p.size(), 0.0), ScalarArray(state.bed.size(), 0.0)};
  ScalarArray wanted(state.bed.size(), 0.0);
  const auto for_each = [&](const auto& act) {
    for (std::size_t i = 0; i < state.bed.size(); ++i) {
      if (wanted[i] == 0.0) continue;
      for (Index k = reach.offset[i]; k < reach.offset[i + 1]; ++k)
        act(i, reach.particle[k], wanted[i] * reach.weight[k] / reach.sum[i]);
    }
  };
  for (std::size_t i = 0; i < state.bed.size(); ++i) {
    auto& part = state.bed[i];
    part.mean_time += interval;
    part.head_sum += interval * head_before(setup, reach, i, state);
    // No more than the film, whose sign the rate has.
    wanted[i] = std::copysign(std::min(std::abs(part.rate) * interval, std::abs(part.film)), part.film);
  }
  for_each([&](std::size_t, Index a, double volume) { passage.gained[a] += volume; });
  ScalarArray share(p.size(), 1.0);
  for (std::size_t a = 0; a < p.size(); ++a)
    if (const double most = bed::most_change * p.volume[a]; std::abs(passage.gained[a]) > most)
      share[a] = most / std::abs(passage.gained[a]);
  std::fill(passage.gained.begin(), passage.gained.end(), 0.0);
  for_each([&](std::size_t i, Index a, double volume) {
    passage.gained[a] += share[a] * volume;
    passage.given[i] += share[a] * volume;
  });
  return passage;
}

template <int D>
void add_bed_source(const BedPassage& passage, double interval, const Stencil<D>& s, std::span<double> source) {
  parallel_for(s.n_real, [&](std::size_t a) {
    const double own = Kernel<D>::value(0.0, s.length(a));
    double gained = own * passage.gained[a], volume = own * s.volume[a];
    for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k) {
      const Index j = s.other[k], q = s.parent[j];
      if (q >= s.n_real) continue;
      const double weight = s.value(a, j);
      gained += weight * passage.gained[q];
      volume += weight * s.volume[q];
    }
    source[a] += gained / (volume * interval);
  });
}

template <int D>
void change_volumes(const Setup<D>& setup, const BedPassage& passage, State<D>& state) {
  auto& p = state.particles;
  for (std::size_t a = 0; a < p.size(); ++a) {
    p.volume[a] += passage.gained[a];
    p.mass[a] += setup.density * passage.gained[a];
  }
  for (std::size_t i = 0; i < state.bed.size(); ++i) state.bed[i].film -= passage.given[i];
}

template <int D>
void even_volumes(const Setup<D>& setup, const Walls<D>& walls, State<D>& state) {
  auto& p = state.particles;
  const double usual = std::pow(setup.spacing, D);
  const std::size_t n = p.size();
  std::vector<bool> keep(n, true);
  std::optional<sph::CellGrid<D>> grid;
  for (std::size_t a = 0; a < n; ++a) {
    if (!keep[a] || p.volume[a] >= bed::least_volume * usual) continue;
    if (!grid) grid.emplace().build(p.position, bed::merged_within * setup.spacing);
    const std::size_t b = partner_of(*grid, setup, p, keep, a);
    auto& part = nearest_part(p.position[a], state);
    const bool on_bed = (p.position[a] - part.centre).norm() < sph::support_radius * bed::reach * setup.spacing;
    if (b != a)
      merge(a, b, p);
    else if (on_bed && p.volume[a] < bed::last_volume * usual)
      part.film += p.mass[a] / setup.density;
    else
      continue;
    keep[a] = false;
    ++state.counts.deleted;
  }
  for (std::size_t a = 0; a < n; ++a) {
    if (!keep[a] || p.volume[a] <= bed::most_volume * usual) continue;
    divide<D>(walls, a, p);
    ++state.counts.born;
  }
  keep.resize(p.size(), true);
  p.filter(keep);
  // A part from which no particle is in reach makes one when its film suffices. It stands half a spacing before the
  // bed.
  std::optional<Reach> reach;
  for (std::size_t i = 0; i < state.bed.size(); ++i) {
    auto& part = state.bed[i];
    if (part.film < usual) continue;
    if (!reach) reach = particles_before(setup, state);
    if (reach->offset[i + 1] > reach->offset[i]) continue;
    const Vec<D> x = part.centre + 0.5 * setup.spacing * part.normal;
    p.add(x, Vec<D>::Zero(), setup.density * usual, 1.0, usual, -setup.weight.dot(x - setup.origin),
          {std::sqrt(setup.gravity * setup.spacing), false});
    part.film -= usual;
    ++state.counts.born;
  }
}

template <int D>
std::vector<BedWater> water_before_bed(const Setup<D>& setup, const State<D>& state) {
  const Reach reach = particles_before(setup, state);
  std::vector<BedWater> water(state.bed.size());
  // A part above the water's level has particles in its reach, but none of their water.
  const auto for_each_wet = [&](const auto& act) {
    for (std::size_t i = 0; i < state.bed.size(); ++i)
      for (Index k = reach.offset[i]; k < reach.offset[i + 1] && water[i].head > 0.0; ++k)
        act(i, reach.particle[k], reach.weight[k]);
  };
  for (std::size_t i = 0; i < state.bed.size(); ++i) {
    const auto& part = state.bed[i];
    water[i].head = part.mean_time > 0.0 ? part.head_sum / part.mean_time : head_before(setup, reach, i, state);
  }
  ScalarArray all(state.particles.size(), 0.0);
  for_each_wet([&](std::size_t, Index a, double weight) { all[a] += weight; });
  for_each_wet(
      [&](std::size_t i, Index a, double weight) { water[i].volume += state.particles.volume[a] * weight / all[a]; });
  return water;
}

template <int D>
void turn_over(std::span<const double> film, double within, State<D>& state) {
  for (std::size_t i = 0; i < state.bed.size(); ++i) {
    auto& part = state.bed[i];
    part.film = film[i];
    part.rate = film[i] / within;
    part.head_sum = part.mean_time = 0.0;
  }
}

#define PORETWIN_INSTANTIATE(D)                                                                  \
  template BedPassage pass_bed(const Setup<D>&, double, State<D>&);                              \
  template void add_bed_source(const BedPassage&, double, const Stencil<D>&, std::span<double>); \
  template void change_volumes(const Setup<D>&, const BedPassage&, State<D>&);                   \
  template void even_volumes(const Setup<D>&, const Walls<D>&, State<D>&);                       \
  template std::vector<BedWater> water_before_bed(const Setup<D>&, const State<D>&);             \
  template void turn_over(std::span<const double>, double, State<D>&);
PORETWIN_INSTANTIATE(2)
PORETWIN_INSTANTIATE(3)
#undef PORETWIN_INSTANTIATE

}  // namespace poretwin::fluid
