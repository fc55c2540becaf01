// How many copies of particles a tile's halo holds, and what an exchange sends: measured, and as the geometry says.
// Run by hand: `ninja tile_halos && mpirun -n RANKS bin/tile_halos D SIDE REACH`, for SIDE^D particles and a reach of
// REACH spacings. The figures are in docs/decisions/0038-ranks-over-mpi.md.
#include "common/tiles/halo.hpp"
#include "common/tiles/partition.hpp"
#include "tests/tiles/ranks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <numbers>

using namespace poretwin;
using namespace poretwin::tiles;

namespace {

/// Number of points in the halo of a tile inside many others: a cube of n^D points and a layer around it with round
/// edges and corners. The outermost points lie half a spacing inside the cube, so that the layer is as much thinner
/// than `reach` [spacings].
double expected_halo(int dimensions, double n, double reach) {
  constexpr double pi = std::numbers::pi;
  const double k = reach - 0.5;
  if (dimensions == 2) return 4.0 * k * n + pi * k * k;
  return 6.0 * k * n * n + 3.0 * pi * k * k * n + 4.0 / 3.0 * pi * k * k * k;
}

template <int D>
void measure(const Communicator& all, std::size_t side, double reach) {
  const auto whole = scattered<D>(side);
  VecArray<D> x;
  std::vector<GlobalId> ids;
  for (auto i = static_cast<std::size_t>(all.rank()); i < whole.size(); i += static_cast<std::size_t>(all.size())) {
    x.push_back(whole[i]);
    ids.push_back(i);
  }
  const auto partition = bisect<D>(all, x, ScalarArray(x.size(), 1.0));
  ParticleArrays arrays;
  arrays.add(x);
  const auto moved = migrate(all, partition.owners(x, all.rank()), ids, arrays);
  Traffic before = all.traffic();
  const MpiRanks ranks(all, find_halo<D>(all, x, ids, reach / static_cast<double>(side)));
  const Traffic finding{all.traffic().messages - before.messages, all.traffic().bytes - before.bytes};
  ScalarArray values(ranks.plan().owned + ranks.plan().halo);
  before = all.traffic();
  ranks.exchange(values, 1);
  const std::array<double, 7> own{static_cast<double>(ranks.plan().owned),
                                  static_cast<double>(ranks.plan().halo),
                                  static_cast<double>(all.traffic().messages - before.messages),
                                  static_cast<double>(all.traffic().bytes - before.bytes),
                                  static_cast<double>(finding.messages),
                                  static_cast<double>(finding.bytes),
                                  static_cast<double>(moved.left)};
  const auto of_ranks = all.gather(std::span<const double>(own));
  if (all.rank() > 0) return;
  const auto largest = [&](std::size_t k) {
    double most = 0.0;
    for (std::size_t i = k; i < of_ranks.size(); i += own.size()) most = std::max(most, of_ranks[i]);
    return most;
  };
  const double n = std::pow(std::pow(side, D) / all.size(), 1.0 / D);
  fmt::print(
      "{}D, {} ranks, largest of any rank: {} owned, halo {} (inner tile by geometry {:.0f}); an exchange of one "
      "number: {} messages, {} bytes; to find the halo: {} messages, {} bytes\n",
      D, all.size(), largest(0), largest(1), expected_halo(D, n, reach), largest(2), largest(3), largest(4),
      largest(5));
}

}  // namespace

int main(int argc, char** argv) {
  return run_as_rank(argc, argv, [&](const Communicator& all) {
    if (argc != 4) {
      fmt::print(stderr, "usage: tile_halos D SIDE REACH\n");
      return 2;
    }
    const auto side = static_cast<std::size_t>(std::atoi(argv[2]));
    const double reach = std::atof(argv[3]);
    if (std::atoi(argv[1]) == 2)
      measure<2>(all, side, reach);
    else
      measure<3>(all, side, reach);
    return 0;
  });
}
