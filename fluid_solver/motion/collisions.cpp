#include "fluid_solver/motion/collisions.hpp"

#include "fluid_solver/numerics/motion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>

namespace poretwin::fluid {
namespace {

/// A pair that is too close: two particles, or one particle and its image (first == second).
template <int D>
struct Hit {
  GlobalId first = 0, second = 0;  ///< ids; where one rank has all particles: indices
  Vec<D> direction;                ///< unit vector from the first to the second
  double share = 0.5;              ///< of the first particle in the change of velocity
  Mat<D> map = Mat<D>::Identity();
  Vec<D> carried = Vec<D>::Zero();  ///< the image's velocity is map v + carried
};

/// The cells in whose order one rank's lists have the neighbours of a particle (sph::CellGrid): those of the grid over
/// all points of all ranks.
template <int D>
struct Cells {
  Vec<D> lower;
  double size;
  [[nodiscard]] std::array<int, D> of(const Vec<D>& x) const {
    std::array<int, D> cell{};  // the last axis first
    for (std::size_t d = 0; d < D; ++d) {
      const auto k = static_cast<int>(D - 1 - d);
      cell[d] = static_cast<int>(std::floor((x[k] - lower[k]) / size));
    }
    return cell;
  }
};
template <int D>
Cells<D> cells_of(const Domain& domain, const Stencil<D>& s) {
  Vec<D> lower = Vec<D>::Constant(HUGE_VAL), upper = -lower;
  double largest = 0.0, own = 0.0;
  for (std::size_t j = 0; j < s.size(); ++j) {
    lower = lower.cwiseMin(s.position[j]);
    upper = upper.cwiseMax(s.position[j]);
    largest = std::max(largest, s.volume[j]);
    own += s.parent[j] < s.n_real ? 1.0 : 0.0;
  }
  for (double& x : lower) x = domain.min(x);
  for (double& x : upper) x = domain.max(x);
  largest = points::smoothing_ratio * spacing_of<D>(domain.max(largest));
  // As CellGrid::build() chooses the cells of find_pairs().
  double size = 0.5 * sph::support_radius * largest;
  const double limit = 4.0 * domain.sum(own) + 64.0;
  for (;; size *= 1.5) {
    double cells = 1.0;
    for (int d = 0; d < D; ++d) cells *= std::floor((upper[d] - lower[d]) / size) + 1.0;
    if (cells <= limit) return {lower, size};
  }
}

/// The hits of this rank's particles, in ascending order of their first particles; of two particles the one with the
/// lower id is the first. in_seepage, id(a), mass(a): of any particle. cells: absent where the rows are in their order
/// already.
template <int D, class Id, class Mass>
std::vector<Hit<D>> hits_of(const Stencil<D>& s, std::span<const char> in_seepage, const std::optional<Cells<D>>& cells,
                            const Id& id, const Mass& mass) {
  std::vector<Hit<D>> hits;
  std::vector<Index> near;
  for (std::size_t a = 0; a < s.n_real; ++a) {
    if (in_seepage[a] != 0 || s.closest[a] * points::smoothing_ratio >= motion::collision) continue;
    near.clear();
    for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k) {
      const Index j = s.other[k], b = s.parent[j];
      const double r2 = (s.position[j] - s.position[a]).squaredNorm(),
                   limit = motion::collision * 0.5 * (s.length(a) + s.length(j)) / points::smoothing_ratio;
      if (r2 >= limit * limit || r2 == 0.0) continue;
      if (b >= s.n_particles || in_seepage[b] != 0) continue;
      if (j < s.n_particles ? id(b) < id(a) : b != a) continue;
      near.push_back(j);
    }
    if (cells)
      std::ranges::sort(near, {}, [&](Index j) {
        const bool image = j >= s.n_particles;
        return std::tuple(cells->of(s.position[j]), image, image ? GlobalId{j} : id(j));
      });
    for (const Index j : near) {
      const Vec<D> ba = s.position[j] - s.position[a];
      const Vec<D> direction = ba / std::sqrt(ba.squaredNorm());
      if (j < s.n_particles)
        hits.push_back({id(a), id(j), direction, mass(j) / (mass(a) + mass(j))});
      else
        hits.push_back({id(a), id(a), direction, 0.5, s.map[j - s.n_base], s.carried[j - s.n_base]});
    }
  }
  return hits;
}

/// Lets the pairs collide one after the other. velocity(id): of the particle with this id.
template <int D, class Velocity>
void collide_in_turn(std::span<const Hit<D>> hits, const Velocity& velocity) {
  for (const Hit<D>& hit : hits) {
    const bool image = hit.first == hit.second;
    Vec<D>& own = velocity(hit.first);
    const Vec<D> other = image ? Vec<D>(hit.map * own + hit.carried) : velocity(hit.second);
    const double approach = hit.direction.dot(own - other);
    if (approach <= 0.0) continue;
    own -= hit.share * approach * hit.direction;
    if (!image) velocity(hit.second) += (1.0 - hit.share) * approach * hit.direction;
  }
}

/// How many numbers other ranks receive for a hit, and for a velocity that hits change.
template <int D>
constexpr std::size_t hit_numbers = 3 + 2 * D + D* D;
template <int D>
constexpr std::size_t moving_numbers = 1 + D;

}  // namespace

/// A collision changes the velocities with which the next one begins. Every rank therefore gathers the hits of all
/// ranks, which are few, and lets all of them collide in the order in which one rank would: of the first particles by
/// their ids, and with each of them in the order of its row.
template <int D>
void collide(const Setup<D>& setup, const Stencil<D>& s, Particles<D>& p) {
  const auto is_close = [&](std::size_t a) {
    return p.in_seepage[a] == 0 && s.closest[a] * points::smoothing_ratio < motion::collision;
  };
  if (!setup.domain.any_of(s.n_real, is_close)) return;
  if (!setup.tiling) {
    const auto hits = hits_of<D>(
        s, p.in_seepage, {}, [](std::size_t a) { return GlobalId{a}; }, [&](std::size_t a) { return p.mass[a]; });
    collide_in_turn<D>(hits, [&](GlobalId a) -> Vec<D>& { return p.velocity[a]; });
    return;
  }
  const auto& ids = p.share.ids;
  const ScalarArray own_ids(ids.begin(), ids.end());
  const auto all_ids = s.template with_copies<double>(own_ids);
  const auto mass = s.template with_copies<double>(p.mass);
  const auto hits = hits_of<D>(
      s, s.flags_with_copies(p.in_seepage), cells_of(setup.domain, s),
      [&](std::size_t a) { return static_cast<GlobalId>(all_ids[a]); }, [&](std::size_t a) { return mass[a]; });
  ScalarArray said, moving;
  const auto put = [](ScalarArray& to, const auto& numbers) {
    to.insert(to.end(), numbers.data(), numbers.data() + numbers.size());
  };
  for (const Hit<D>& hit : hits) {
    for (const double x : {static_cast<double>(hit.first), static_cast<double>(hit.second), hit.share})
      said.push_back(x);
    put(said, hit.direction);
    put(said, hit.carried);
    put(said, hit.map);
  }
  for (std::size_t a = 0; a < p.size(); ++a) {
    if (!is_close(a)) continue;
    moving.push_back(static_cast<double>(ids[a]));
    put(moving, p.velocity[a]);
  }
  said = setup.tiling->gather_numbers(said);
  moving = setup.tiling->gather_numbers(moving);
  std::vector<Hit<D>> all(said.size() / hit_numbers<D>);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const double* from = said.data() + i * hit_numbers<D>;
    all[i].first = static_cast<GlobalId>(from[0]);
    all[i].second = static_cast<GlobalId>(from[1]);
    all[i].share = from[2];
    all[i].direction = Eigen::Map<const Vec<D>>(from + 3);
    all[i].carried = Eigen::Map<const Vec<D>>(from + 3 + D);
    all[i].map = Eigen::Map<const Mat<D>>(from + 3 + 2 * D);
  }
  // Those of one particle come from one rank, in order.
  std::ranges::stable_sort(all, {}, [](const Hit<D>& hit) { return hit.first; });
  std::map<GlobalId, Vec<D>> velocity;
  for (std::size_t i = 0; i < moving.size(); i += moving_numbers<D>)
    velocity[static_cast<GlobalId>(moving[i])] = Eigen::Map<const Vec<D>>(moving.data() + i + 1);
  collide_in_turn<D>(all, [&](GlobalId id) -> Vec<D>& { return velocity.at(id); });
  for (std::size_t a = 0; a < p.size(); ++a)
    if (is_close(a)) p.velocity[a] = velocity.at(ids[a]);
}

template void collide(const Setup<2>&, const Stencil<2>&, Particles<2>&);
template void collide(const Setup<3>&, const Stencil<3>&, Particles<3>&);

}  // namespace poretwin::fluid
