#include "common/tiles/partition.hpp"

#include "common/core/error.hpp"
#include "common/tiles/mpi.hpp"

#include <fmt/format.h>
#include <zoltan.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

namespace poretwin::tiles {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// What Zoltan asks for: the points of this rank and their loads.
template <int D>
struct Cloud {
  std::span<const Vec<D>> points;
  std::span<const double> load;
  bool equal;  ///< no point has a load: all count alike
};

template <int D>
int count_points(void* cloud, int* code) {
  *code = ZOLTAN_OK;
  return static_cast<int>(static_cast<const Cloud<D>*>(cloud)->points.size());
}

template <int D>
void list_points(void* cloud, int, int, ZOLTAN_ID_PTR global, ZOLTAN_ID_PTR local, int, float* load, int* code) {
  const auto& points = *static_cast<const Cloud<D>*>(cloud);
  for (std::size_t i = 0; i < points.points.size(); ++i) {
    global[i] = local[i] = static_cast<ZOLTAN_ID_TYPE>(i);
    load[i] = points.equal ? 1.0F : static_cast<float>(points.load[i]);
  }
  *code = ZOLTAN_OK;
}

template <int D>
int count_coordinates(void*, int* code) {
  *code = ZOLTAN_OK;
  return D;
}

template <int D>
void list_coordinates(void* cloud, int, int, int n, ZOLTAN_ID_PTR, ZOLTAN_ID_PTR local, int, double* x, int* code) {
  const auto& points = *static_cast<const Cloud<D>*>(cloud);
  for (int i = 0; i < n; ++i)
    for (int d = 0; d < D; ++d) x[i * D + d] = points.points[local[i]][d];
  *code = ZOLTAN_OK;
}

/// Zoltan's memory of a partition, freed on every way out.
struct Zoltan {
  Zoltan_Struct* handle;
  explicit Zoltan(MPI_Comm ranks) : handle(Zoltan_Create(ranks)) {}
  ~Zoltan() { Zoltan_Destroy(&handle); }
  Zoltan(const Zoltan&) = delete;
  Zoltan& operator=(const Zoltan&) = delete;
};

void expect_success(const Communicator& all, int code, const char* call) {
  if (code != ZOLTAN_OK && code != ZOLTAN_WARN)
    throw Error(ExitCode::failure,
                fmt::format("rank {} of {}: {} failed with code {}", all.rank(), all.size(), call, code));
}

/// Tiles with these sides. Zoltan gives sides without a neighbour as the largest number.
template <int D>
std::vector<Box<D>> boxes(std::span<const double> sides) {
  std::vector<Box<D>> tiles(sides.size() / (2 * D));
  const double* next = sides.data();
  const auto open = [](double side) {
    return std::abs(side) == std::numeric_limits<double>::max() ? std::copysign(infinity, side) : side;
  };
  for (auto& tile : tiles) {
    for (int d = 0; d < D; ++d) tile.lower[d] = open(*next++);
    for (int d = 0; d < D; ++d) tile.upper[d] = open(*next++);
  }
  return tiles;
}

/// Sides of all tiles as Zoltan cuts them, [ranks][lower, upper][D], with the same bits on every rank.
template <int D>
std::vector<double> sides_of_tiles(const Communicator& all, Cloud<D> cloud, const char* average_cuts) {
  float version = 0.0F;
  expect_success(all, Zoltan_Initialize(0, nullptr, &version), "Zoltan_Initialize");
  Zoltan zoltan(all.mpi().handle);
  using Setting = std::array<const char*, 2>;
  for (const auto& [name, value] :
       {Setting{"DEBUG_LEVEL", "0"}, Setting{"LB_METHOD", "RCB"}, Setting{"NUM_GID_ENTRIES", "1"},
        Setting{"NUM_LID_ENTRIES", "1"}, Setting{"OBJ_WEIGHT_DIM", "1"}, Setting{"RETURN_LISTS", "NONE"},
        Setting{"KEEP_CUTS", "1"}, Setting{"AVERAGE_CUTS", average_cuts}})
    expect_success(all, Zoltan_Set_Param(zoltan.handle, name, value), name);
  Zoltan_Set_Num_Obj_Fn(zoltan.handle, count_points<D>, &cloud);
  Zoltan_Set_Obj_List_Fn(zoltan.handle, list_points<D>, &cloud);
  Zoltan_Set_Num_Geom_Fn(zoltan.handle, count_coordinates<D>, &cloud);
  Zoltan_Set_Geom_Multi_Fn(zoltan.handle, list_coordinates<D>, &cloud);
  int changes = 0, n_global = 0, n_local = 0, n_in = 0, n_out = 0;
  ZOLTAN_ID_PTR in_global = nullptr, in_local = nullptr, out_global = nullptr, out_local = nullptr;
  int *in_from = nullptr, *in_part = nullptr, *out_to = nullptr, *out_part = nullptr;
  expect_success(all,
                 Zoltan_LB_Partition(zoltan.handle, &changes, &n_global, &n_local, &n_in, &in_global, &in_local,
                                     &in_from, &in_part, &n_out, &out_global, &out_local, &out_to, &out_part),
                 "Zoltan_LB_Partition");

  std::vector<double> sides;
  for (int r = 0; r < all.size(); ++r) {
    int dimensions = 0;
    std::array<double, 3> low{}, high{};
    expect_success(
        all, Zoltan_RCB_Box(zoltan.handle, r, &dimensions, &low[0], &low[1], &low[2], &high[0], &high[1], &high[2]),
        "Zoltan_RCB_Box");
    sides.insert(sides.end(), low.begin(), low.begin() + D);
    sides.insert(sides.end(), high.begin(), high.begin() + D);
  }
  // Rank 0's numbers are used by all.
  const std::size_t n = sides.size();
  sides = all.gather(std::span<const double>(sides), 'c');
  sides.resize(n);
  return sides;
}

/// Whether no place is in two tiles.
template <int D>
bool disjoint(std::span<const Box<D>> tiles) {
  const auto empty = [](const Box<D>& box) { return (box.lower.array() >= box.upper.array()).any(); };
  for (std::size_t r = 0; r < tiles.size(); ++r)
    for (std::size_t s = r + 1; s < tiles.size(); ++s)
      if (!empty(tiles[r]) && !empty(tiles[s]) && (tiles[r].upper.array() > tiles[s].lower.array()).all() &&
          (tiles[s].upper.array() > tiles[r].lower.array()).all())
        return false;
  return true;
}

}  // namespace

template <int D>
Partition<D>::Partition(int ranks)
    : tiles_(static_cast<std::size_t>(ranks), {Vec<D>::Constant(infinity), Vec<D>::Constant(infinity)}) {
  tiles_[0].lower = Vec<D>::Constant(-infinity);
}

template <int D>
int Partition<D>::owner(const Vec<D>& x, int guess) const {
  const auto holds = [&](const Box<D>& box) {
    return (x.array() > box.lower.array()).all() && (x.array() <= box.upper.array()).all();
  };
  if (holds(tiles_[static_cast<std::size_t>(guess)])) return guess;
  for (std::size_t r = 0; r < tiles_.size(); ++r)
    if (holds(tiles_[r])) return static_cast<int>(r);
  std::string place;
  for (int d = 0; d < D; ++d) place += fmt::format("{}{:g}", d == 0 ? "" : ", ", x[d]);
  throw DivergedError(fmt::format("a particle is at ({}) m, which no tile holds", place));
}

template <int D>
std::vector<int> Partition<D>::owners(std::span<const Vec<D>> x, int guess) const {
  std::vector<int> found(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) found[i] = owner(x[i], guess);
  return found;
}

template <int D>
Partition<D> bisect(const Communicator& all, std::span<const Vec<D>> points, std::span<const double> load) {
  struct Sums {
    double load, points;
    char sound;
  };
  Sums own{0.0, static_cast<double>(points.size()), points.size() == load.size()};
  for (const auto& x : points) own.sound = own.sound && x.allFinite();
  for (const double one : load) {
    own.load += one;
    own.sound = own.sound && one >= 0.0 && one <= std::numeric_limits<float>::max();
  }
  Sums sum{0.0, 0.0, true};
  const auto of_ranks = all.gather(std::span<const Sums>(&own, 1), 'b');
  for (std::size_t r = 0; r < of_ranks.size(); ++r) {
    if (!of_ranks[r].sound)
      throw DivergedError(fmt::format(
          "space cannot be cut: rank {} has a point at no finite place, or a load that is negative or not finite", r));
    sum.load += of_ranks[r].load;
    sum.points += of_ranks[r].points;
  }
  if (all.size() == 1 || sum.points == 0.0) return Partition<D>(all.size());

  const Cloud<D> cloud{points, load, sum.load == 0.0};
  // AVERAGE_CUTS: cuts lie between points, and not on one, so that a row of a lattice is not divided by rounding
  // errors. Where one side of a cut has no points, as with fewer points than ranks, such a mean lies far outside, and
  // parts of that side overlap others; cuts on points do not.
  for (const char* const average : {"1", "0"}) {
    const auto tiles = boxes<D>(sides_of_tiles<D>(all, cloud, average));
    if (disjoint<D>(tiles)) return Partition<D>(tiles);
  }
  throw Error(ExitCode::failure, "space cannot be cut: two of Zoltan's tiles overlap");
}

double imbalance(const Communicator& all, double load) {
  double sum = 0.0, most = 0.0;
  for (const double one : all.gather(std::span<const double>(&load, 1), 'i')) {
    sum += one;
    most = std::max(most, one);
  }
  return sum > 0.0 ? most * all.size() / sum - 1.0 : 0.0;
}

template class Partition<2>;
template class Partition<3>;
template Partition<2> bisect(const Communicator&, std::span<const Vec<2>>, std::span<const double>);
template Partition<3> bisect(const Communicator&, std::span<const Vec<3>>, std::span<const double>);

}  // namespace poretwin::tiles
