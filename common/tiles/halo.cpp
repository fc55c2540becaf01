#include "common/tiles/halo.hpp"

#include "common/particles/neighbours.hpp"

#include <algorithm>
#include <limits>

namespace poretwin::tiles {

template <int D>
HaloPlan find_halo(const Communicator& all, std::span<const Vec<D>> x, std::span<const GlobalId> ids, double reach,
                   std::span<const Vec<D>> shifts, std::span<const Vec<D>> views) {
  const auto n_ranks = static_cast<std::size_t>(all.size());
  VecArray<D> seen_from(x.begin(), x.end());
  seen_from.insert(seen_from.end(), views.begin(), views.end());
  // What these places of each rank occupy; without any, a box that nothing is near.
  constexpr double infinity = std::numeric_limits<double>::infinity();
  struct Occupied {
    std::array<double, D> lower, upper;
  } own;
  own.lower.fill(infinity);
  own.upper.fill(-infinity);
  for (const auto& place : seen_from)
    for (std::size_t d = 0; d < D; ++d) {
      own.lower[d] = std::min(own.lower[d], place[static_cast<int>(d)]);
      own.upper[d] = std::max(own.upper[d], place[static_cast<int>(d)]);
    }
  const auto boxes = all.gather(std::span<const Occupied>(&own, 1), 'h');

  VecArray<D> moved_by{Vec<D>::Zero()};
  moved_by.insert(moved_by.end(), shifts.begin(), shifts.end());
  // |y - box| < reach. Rounding is monotonous, so that no particle within reach of one in the box is missed.
  const auto near_box = [&](const Vec<D>& y, const Occupied& box) {
    double r2 = 0.0;
    for (std::size_t d = 0; d < D; ++d) {
      const double at = y[static_cast<int>(d)], apart = std::max({box.lower[d] - at, at - box.upper[d], 0.0});
      r2 += apart * apart;
    }
    return r2 < reach * reach;
  };

  // First by boxes: each rank proposes its particles near another's box.
  std::vector<Index> by_id(x.size());
  for (std::size_t i = 0; i < by_id.size(); ++i) by_id[i] = static_cast<Index>(i);
  std::ranges::sort(by_id, {}, [&](Index i) { return ids[i]; });
  std::vector<std::vector<Index>> proposed(n_ranks);
  std::vector<Bytes> to(n_ranks);
  for (std::size_t r = 0; r < n_ranks; ++r) {
    if (r == static_cast<std::size_t>(all.rank())) continue;
    std::vector<double> places;
    for (const Index i : by_id)
      if (std::ranges::any_of(moved_by, [&](const Vec<D>& by) { return near_box(x[i] + by, boxes[r]); })) {
        proposed[r].push_back(i);
        places.insert(places.end(), x[i].data(), x[i].data() + D);
      }
    to[r] = bytes_of(places);
  }
  const std::vector<Bytes> candidates = all.trade(to);

  // Then by particles: it takes those that are within reach of its own, and says which.
  sph::CellGrid<D> grid;
  if (!seen_from.empty()) grid.build(seen_from, reach);
  std::vector<Bytes> answers(n_ranks);
  std::vector<std::size_t> received(n_ranks);
  for (std::size_t r = 0; r < n_ranks; ++r) {
    const auto places = values_of<double>(candidates[r]);
    std::vector<Index> taken;
    for (std::size_t c = 0; c * D < places.size(); ++c) {
      const Vec<D> place = Eigen::Map<const Vec<D>>(places.data() + c * D);
      bool near = false;
      for (const auto& by : moved_by)
        if (!near) grid.for_each_within(place + by, reach, [&](Index, double) { near = true; });
      if (near) taken.push_back(static_cast<Index>(c));
    }
    received[r] = taken.size();
    answers[r] = bytes_of(taken);
  }
  const std::vector<Bytes> wanted = all.trade(answers);

  HaloPlan plan;
  plan.owned = x.size();
  for (std::size_t r = 0; r < n_ranks; ++r) {
    HaloPlan::Neighbour neighbour{static_cast<int>(r), {}, received[r]};
    for (const Index c : values_of<Index>(wanted[r])) neighbour.sent.push_back(proposed[r].at(c));
    plan.halo += neighbour.received;
    if (!neighbour.sent.empty() || neighbour.received > 0) plan.neighbours.push_back(std::move(neighbour));
  }
  return plan;
}

template HaloPlan find_halo(const Communicator&, std::span<const Vec<2>>, std::span<const GlobalId>, double,
                            std::span<const Vec<2>>, std::span<const Vec<2>>);
template HaloPlan find_halo(const Communicator&, std::span<const Vec<3>>, std::span<const GlobalId>, double,
                            std::span<const Vec<3>>, std::span<const Vec<3>>);

}  // namespace poretwin::tiles
