// From end to end: particles move through the tiles for 50 steps, with migration, halos and new tiles, and give the
// densities of one rank bit by bit; a system of equations over them has the solution of one rank.
#include "common/numerics/csr.hpp"
#include "common/particles/kernel.hpp"
#include "common/particles/neighbours.hpp"
#include "common/tiles/halo.hpp"
#include "common/tiles/partition.hpp"
#include "tests/tiles/ranks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

namespace poretwin::tiles {
namespace {

template <int D>
struct Scene {
  std::size_t side;                       ///< particles along a side of the unit square or cube
  double share = 0.15;                    ///< imbalance of the numbers of particles at which space is cut anew
  Vec<D> drift = Vec<D>::Constant(0.15);  ///< of the whole run [m]
  double vortex = 0.15;                   ///< largest displacement by the vortex in the whole run [m]
  [[nodiscard]] double dx() const { return 1.0 / static_cast<double>(side); }
  [[nodiscard]] double h() const { return 1.25 * dx(); }
  [[nodiscard]] double radius() const { return sph::support_radius * h(); }
  [[nodiscard]] double skin() const { return 0.9 * dx(); }
  static constexpr int steps = 50;

  /// Mass of a particle [kg], and where a step moves it.
  [[nodiscard]] static double mass(GlobalId id) { return 1.0 + 0.3 * std::sin(static_cast<double>(id)); }
  [[nodiscard]] Vec<D> moved(const Vec<D>& x) const {
    constexpr double pi = std::numbers::pi;
    Vec<D> by = drift;
    by[0] -= vortex * std::sin(pi * x[1]) * std::cos(pi * x[0]);
    by[1] += vortex * std::cos(pi * x[1]) * std::sin(pi * x[0]);
    return x + by / steps;
  }
};

/// Neighbours of the first `owned` of the points x, in ascending order of their ids, so that sums over them have the
/// same bits however the points are numbered here.
template <int D>
sph::PairList neighbours(const VecArray<D>& x, const std::vector<GlobalId>& ids, std::size_t owned, double radius) {
  auto pairs = sph::find_pairs<D>(std::span(x).first(owned), x, ScalarArray(x.size(), radius));
  for (std::size_t a = 0; a < owned; ++a)
    std::sort(pairs.index.begin() + pairs.offset[a], pairs.index.begin() + pairs.offset[a + 1],
              [&](Index i, Index j) { return ids[i] < ids[j]; });
  return pairs;
}

/// Density of particle a [kg/m^D], including its own share.
template <int D>
double density(const VecArray<D>& x, const ScalarArray& mass, const sph::PairList& pairs, double h, std::size_t a) {
  double sum = 0.0;
  for (const Index j : pairs.of(a)) sum += mass[j] * sph::WendlandC2<D>::value((x[a] - x[j]).norm(), h);
  return sum;
}

/// Solves (L + s) u = b, L: the Laplacian of the graph of pairs with weights of the kernel, s = 0.02. b: a function of
/// the ids. Returns u of the owned particles.
template <int D>
ScalarArray solve(const Domain& domain, const VecArray<D>& x, const std::vector<GlobalId>& ids,
                  const sph::PairList& pairs, double h, int& iterations) {
  const std::size_t n = pairs.size();
  ScalarArray weight(pairs.index.size(), 0.0);
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t k = pairs.offset[a]; k < pairs.offset[a + 1]; ++k)
      if (const Index j = pairs.index[k]; ids[j] != ids[a])
        weight[k] = sph::WendlandC2<D>::value((x[a] - x[j]).norm(), h) / sph::WendlandC2<D>::value(0.0, h);
  ScalarArray b(n), u(n, 0.1);
  for (std::size_t a = 0; a < n; ++a) b[a] = std::cos(0.7 * static_cast<double>(ids[a]));
  const auto apply = [&](std::span<const double> p, std::span<double> q) {
    for (std::size_t a = 0; a < n; ++a) {
      double sum = 0.0;
      for (std::size_t k = pairs.offset[a]; k < pairs.offset[a + 1]; ++k) sum += weight[k] * (p[a] - p[pairs.index[k]]);
      q[a] = sum + 0.02 * p[a];
    }
  };
  const auto plain = [](std::span<const double> r, std::span<double> z) { std::copy(r.begin(), r.end(), z.begin()); };
  const auto report = conjugate_gradients(domain, apply, plain, b, u, 1e-14 * domain.norm(b), 500);
  EXPECT_TRUE(report.converged);
  iterations = report.iterations;
  return u;
}

/// Counts of a run, the same on every rank.
struct Events {
  double rebuilt = 0, migrated = 0, cut = 0, halo = 0;
  std::vector<double> owned;  ///< particles of each rank at the end
};

/// fixed: tiles that are kept; none: they are cut by load.
template <int D>
Events run(const Scene<D>& scene, const std::optional<Partition<D>>& fixed = {}) {
  const auto& all = all_ranks();
  // What one rank computes of all particles, whose numbers are their ids.
  VecArray<D> whole = scattered<D>(scene.side);
  std::vector<GlobalId> whole_ids(whole.size());
  ScalarArray whole_mass(whole.size());
  for (std::size_t i = 0; i < whole.size(); ++i) {
    whole_ids[i] = i;
    whole_mass[i] = scene.mass(i);
  }

  // Each rank begins with every P-th particle, wherever it is.
  VecArray<D> x, at;
  std::vector<GlobalId> ids, halo_ids;
  ScalarArray mass;
  for (std::size_t i = static_cast<std::size_t>(all.rank()); i < whole.size();
       i += static_cast<std::size_t>(all.size())) {
    x.push_back(whole[i]);
    ids.push_back(i);
    mass.push_back(whole_mass[i]);
  }
  ParticleArrays arrays;
  arrays.add(x).add(mass);
  Partition<D> partition = fixed ? *fixed : bisect<D>(all, x, ScalarArray(x.size(), 1.0));
  MpiRanks ranks(all);
  sph::PairList pairs;
  std::vector<std::size_t> inner, outer;  // rows without and with neighbours in the halo
  Events events;

  for (int step = 0; step <= scene.steps; ++step) {
    const std::size_t owned = ids.size();
    const bool first = step == 0;
    if (first ||
        lists_outdated<D>(ranks.domain(), std::span(x).first(owned), std::span(at).first(owned), scene.skin())) {
      x.resize(owned);
      mass.resize(owned);
      if (!first && !fixed && imbalance(all, static_cast<double>(owned)) > scene.share) {
        partition = bisect<D>(all, x, ScalarArray(owned, 1.0));
        events.cut += 1;
      }
      const auto moved = migrate(all, partition.owners(x, all.rank()), ids, arrays);
      if (!first) events.migrated += static_cast<double>(moved.left);
      ranks = MpiRanks(all, find_halo<D>(all, x, ids, scene.radius() + scene.skin()));
      const auto& plan = ranks.plan();
      x.resize(plan.owned + plan.halo);
      mass.resize(plan.owned + plan.halo);
      halo_ids = ids;
      halo_ids.resize(plan.owned + plan.halo);
      ranks.end_exchange(ranks.begin_exchange(std::span(x), 1));
      ranks.end_exchange(ranks.begin_exchange(std::span(halo_ids), 1));
      ranks.exchange(mass, 1);
      at = x;
      pairs = neighbours<D>(x, halo_ids, plan.owned, scene.radius() + scene.skin());
      inner.clear();
      outer.clear();
      for (std::size_t a = 0; a < plan.owned; ++a) {
        const bool inside = std::ranges::all_of(pairs.of(a), [&](Index j) { return j < plan.owned; });
        (inside ? inner : outer).push_back(a);
      }
      events.rebuilt += 1;
      events.halo += static_cast<double>(plan.halo);
    }
    const std::size_t n = ids.size();

    // Densities: the halo's places are on their way while inner rows are computed.
    ScalarArray rho(n);
    auto exchange = ranks.begin_exchange(std::span(x), 1);
    for (const std::size_t a : inner) rho[a] = density<D>(x, mass, pairs, scene.h(), a);
    ranks.end_exchange(std::move(exchange));
    for (const std::size_t a : outer) rho[a] = density<D>(x, mass, pairs, scene.h(), a);

    const auto whole_pairs = sph::find_pairs<D>(whole, whole, ScalarArray(whole.size(), scene.radius()));
    for (std::size_t a = 0; a < n; ++a) {
      EXPECT_EQ(x[a], whole[ids[a]]) << "step " << step << ", particle " << ids[a];
      EXPECT_EQ(rho[a], density<D>(whole, whole_mass, whole_pairs, scene.h(), ids[a]))
          << "step " << step << ", particle " << ids[a];
    }
    EXPECT_EQ(ranks.domain().sum(static_cast<double>(n)), static_cast<double>(whole.size()));

    if (step == 0 || step == scene.steps) {
      int iterations = 0, whole_iterations = 0;
      const ScalarArray u = solve<D>(ranks.domain(), x, halo_ids, pairs, scene.h(), iterations);
      const ScalarArray expected = solve<D>({}, whole, whole_ids, whole_pairs, scene.h(), whole_iterations);
      EXPECT_GT(whole_iterations, 20);
      EXPECT_LE(std::abs(iterations - whole_iterations), 1);
      double largest = 0.0;
      for (const double value : expected) largest = std::max(largest, std::abs(value));
      for (std::size_t a = 0; a < n; ++a) EXPECT_NEAR(u[a], expected[ids[a]], 1e-12 * largest) << "particle " << ids[a];
    }
    for (std::size_t a = 0; a < n; ++a) x[a] = scene.moved(x[a]);
    for (auto& place : whole) place = scene.moved(place);
  }
  std::array<double, 2> sums{events.migrated, events.halo};
  ranks.sum(sums);
  events.migrated = sums[0];
  const auto owned = static_cast<double>(ids.size());
  events.owned = all.gather(std::span<const double>(&owned, 1));
  events.halo = sums[1] / events.rebuilt;
  return events;
}

template <int D>
void expect_one_rank_s_results(std::size_t side) {
  const Scene<D> scene{side};
  const Events events = run(scene);
  if (all_ranks().rank() == 0)
    std::printf(
        "%d ranks: lists made %g times, %g particles migrated, tiles cut anew %g times, halo %g particles of all "
        "ranks\n",
        all_ranks().size(), events.rebuilt, events.migrated, events.cut, events.halo);
  // What is to be tested did happen: lists were kept for a while, particles migrated, tiles were cut anew.
  EXPECT_LT(events.rebuilt, scene.steps / 2);
  EXPECT_GT(events.rebuilt, 5.0);
  if (all_ranks().size() == 1) return;
  EXPECT_GT(events.migrated, 0.1 * std::pow(side, D));
  EXPECT_GT(events.cut, 0.0);
}

TEST(Motion, DensitiesAndSolutionsAreThoseOfOneRank2D) { expect_one_rank_s_results<2>(24); }
TEST(Motion, DensitiesAndSolutionsAreThoseOfOneRank3D) { expect_one_rank_s_results<3>(9); }

TEST(Motion, ATileThatAllParticlesLeaveTakesPart) {
  // Slabs across the drift, which carries all particles out of the first.
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const auto& all = all_ranks();
  std::vector<Box<2>> slabs(static_cast<std::size_t>(all.size()),
                            {Vec<2>::Constant(-infinity), Vec<2>::Constant(infinity)});
  for (int r = 0; r + 1 < all.size(); ++r)
    slabs[static_cast<std::size_t>(r)].upper[0] = slabs[static_cast<std::size_t>(r) + 1].lower[0] = 0.3 * (r + 1);
  Scene<2> scene{16};
  scene.drift = {0.75, 0.0};
  scene.vortex = 0.0;
  const Events events = run<2>(scene, Partition<2>(slabs));
  for (int r = 0; r + 1 < all.size(); ++r) {
    const double n = events.owned[static_cast<std::size_t>(r)];
    EXPECT_EQ(n == 0.0, r < 2) << n << " particles of rank " << r;
  }
}

}  // namespace
}  // namespace poretwin::tiles
