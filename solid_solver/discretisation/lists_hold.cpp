#include "solid_solver/discretisation/lists_hold.hpp"

#include "common/core/threads.hpp"
#include "solid_solver/numerics/points.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>

namespace poretwin::solid {
namespace {

/// Smallest and largest displacement [m], by component, of a tile's particles since the lists were built. A tile is
/// points::tile_reach skins plus two smoothing lengths wide.
template <int D>
struct Moved {
  Vec<D> low = Vec<D>::Constant(std::numeric_limits<double>::infinity()), high = -low;
  void add(const Moved& other) {
    low = low.cwiseMin(other.low);
    high = high.cwiseMax(other.high);
  }
  /// Upper bound of the relative displacement [m] of two particles, one from this tile and one from the other.
  [[nodiscard]] double against(const Moved& other) const {
    return (high - other.low).cwiseMax(other.high - low).cwiseMax(0.0).norm();
  }
};

template <int D>
Vec<D> moved_by(const Particles<D>& p, const Neighbourhood<D>& near, std::size_t i) {
  return p.position[i] - near.built_at[i].template cast<double>();
}

template <int D>
class Tiles {
 public:
  Tiles(const Neighbourhood<D>& near, double size) : lower_(near.lower), per_metre_(1.0 / size) {
    double all = 1.0;
    for (std::size_t d = 0; d < D; ++d) {
      const double extent = (near.upper - near.lower)[static_cast<Eigen::Index>(d)];
      const double count = std::floor(per_metre_ * extent) + 1.0;
      all *= count;
      if (all > static_cast<double>(near.built_at.size()) + 64.0) return;
      count_[d] = static_cast<long>(count);
    }
    n_ = static_cast<std::size_t>(all);
  }
  /// False where grains have flown so far that there would be too many tiles: the lists are then rebuilt.
  [[nodiscard]] bool are_few() const { return n_ > 0; }

  /// Whether relative displacements within each tile and between neighbouring tiles stay within the skin.
  [[nodiscard]] bool move_along(const Particles<D>& p, const Neighbourhood<D>& near, double skin) const {
    const std::size_t n = p.size(), parts = near.pairs.n_parts();
    std::vector<std::vector<Moved<D>>> moved(parts, std::vector<Moved<D>>(n_));
    for_each_part(parts, [&](std::size_t part) {
      for (std::size_t i = n * part / parts; i < n * (part + 1) / parts; ++i) {
        const Vec<D> by = moved_by(p, near, i);
        moved[part][tile(near.built_at[i].template cast<double>())].add({by, by});
      }
    });
    for (std::size_t part = 1; part < parts; ++part)
      for (std::size_t k = 0; k < n_; ++k) moved[0][k].add(moved[part][k]);
    std::array<long, D> at{};
    for (std::size_t k = 0; k < n_; ++k) {
      if (!touching_move_along(moved[0], k, at, skin)) return false;
      for (std::size_t d = 0; d < D && ++at[d] == count_[d]; ++d) at[d] = 0;
    }
    return true;
  }

 private:
  [[nodiscard]] std::size_t tile(const Vec<D>& x) const {
    long k = 0;
    for (std::size_t d = D; d-- > 0;) {
      const auto place = static_cast<long>(per_metre_ * (x - lower_)[static_cast<Eigen::Index>(d)]);
      k = k * count_[d] + std::clamp(place, 0L, count_[d] - 1);
    }
    return static_cast<std::size_t>(k);
  }
  /// The same check, for tile k at the place `at` and its neighbours with a higher number.
  bool touching_move_along(const std::vector<Moved<D>>& moved, std::size_t k, const std::array<long, D>& at,
                           double skin) const {
    constexpr int n_around = D == 2 ? 9 : 27;
    for (int code = n_around / 2; code < n_around; ++code) {
      long other = 0, stride = 1;
      bool inside = true;
      for (std::size_t d = 0, rest = static_cast<std::size_t>(code); d < D; ++d, rest /= 3) {
        const long place = at[d] + static_cast<long>(rest % 3) - 1;
        inside = inside && place >= 0 && place < count_[d];
        other += stride * place;
        stride *= count_[d];
      }
      if (inside && moved[k].against(moved[static_cast<std::size_t>(other)]) > skin) return false;
    }
    return true;
  }

  Vec<D> lower_;
  double per_metre_;
  std::array<long, D> count_{};
  std::size_t n_ = 0;
};

}  // namespace

template <int D>
bool lists_hold(const Setup<D>& setup, const Particles<D>& p, const Neighbourhood<D>& near) {
  const double reach = sph::support_radius * setup.smoothing_length, far = 0.5 * points::tile_reach * setup.skin;
  double plates_moved = 0.0;  // m
  for (std::size_t k = 0; k < p.plates.size(); ++k) {
    const PlateMotion<D>&now = p.plates[k], &before = near.plates_at[k];
    if (now.apart != before.apart) return false;
    const double by_turning = std::abs(now.angle - before.angle) * (setup.plates[k].half + reach);
    plates_moved = std::max(plates_moved, (now.displacement - before.displacement).norm() + by_turning);
  }
  // An image moves by twice the displacement of its plate, in addition to that of its parent.
  const double most = 0.5 * setup.skin - plates_moved;
  if (most < 0.25 * setup.skin) return false;
  if (plates_moved > 0.0 || setup.tiling)
    return parallel_all(p.free(), [&](std::size_t i) { return !(moved_by(p, near, i).norm() > most); });
  std::atomic<bool> still{true};
  const bool near_enough = parallel_all(p.free(), [&](std::size_t i) {
    const double square = moved_by(p, near, i).squaredNorm();
    if (!(square > 0.25 * setup.skin * setup.skin)) return true;  // values that are not finite are reported elsewhere
    still.store(false, std::memory_order_relaxed);
    if (square > far * far) return false;
    if constexpr (D == 3)
      if (setup.boundaries.surfaces) return !setup.boundaries.surfaces->come_near(p.position[i], reach);
    return std::ranges::all_of(setup.boundaries.planes, [&](const auto& plane) {
      return std::abs(plane.normal.dot(p.position[i] - plane.point)) >= reach;
    });
  });
  if (!near_enough || still) return near_enough;
  const Tiles<D> tiles(near, reach + points::tile_reach * setup.skin);
  return tiles.are_few() && tiles.move_along(p, near, setup.skin);
}

template bool lists_hold<2>(const Setup<2>&, const Particles<2>&, const Neighbourhood<2>&);
template bool lists_hold<3>(const Setup<3>&, const Particles<3>&, const Neighbourhood<3>&);

}  // namespace poretwin::solid
