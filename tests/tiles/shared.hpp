// A phase that ranks share, beside the whole, which each rank also computes alone.
#pragma once

#include "common/case/case.hpp"
#include "common/coupling/exchange.hpp"
#include "common/tiles/mpi_tiling.hpp"
#include "tests/tiles/ranks.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <set>
#include <utility>

namespace poretwin::tiles {

template <class Part, int D>
struct SharedAndWhole {
  /// What the other phase sends to particles at these places in a window; absent: there is no other phase.
  using Sent = std::function<coupling::Inbox(const VecArray<D>& places)>;

  SharedAndWhole(const Case& scene, std::shared_ptr<MpiTiling<D>> tiles, Sent what = {})
      : tiling(std::move(tiles)), sent(std::move(what)), whole(scene), part(scene, tiling) {
    whole.initialise(inbox(whole));
    part.initialise(inbox(part));
  }
  [[nodiscard]] coupling::Inbox inbox(const Part& of) const {
    return sent ? sent(of.state().particles.position) : coupling::Inbox();
  }
  void expect_each_particle_on_one_rank() const {
    const auto ids = all_ranks().gather_all(part.state().particles.share.ids);
    EXPECT_EQ(ids.size(), whole.state().particles.size());
    EXPECT_EQ(std::set<GlobalId>(ids.begin(), ids.end()).size(), ids.size());
  }
  [[nodiscard]] double left() const { return part.setup().domain.sum(static_cast<double>(tiling->left())); }

  std::shared_ptr<MpiTiling<D>> tiling;
  Sent sent;
  Part whole, part;
  std::uint64_t step = 0;
};

template <int D>
std::shared_ptr<MpiTiling<D>> across(int axis, double from, double to) {
  return std::make_shared<MpiTiling<D>>(all_ranks(), slabs<D>(axis, from, to));
}

}  // namespace poretwin::tiles
