// Properties that must hold for any two clouds of points; a failure is reduced to the smallest clouds that show it.
#include "common/particles/kernel.hpp"
#include "tests/coupling/cloud_pairs.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace poretwin::coupling {
namespace {

using Size = std::size_t;

rc::Gen<double> between(double low, double high) {
  constexpr int steps = 1 << 20;
  return rc::gen::map(rc::gen::inRange(0, steps), [=](int k) { return low + (high - low) * k / steps; });
}

/// Up to 40 points in a unit box, with any smoothing lengths and volumes, some of them ghosts.
PointSet any_cloud(int dimension) {
  const auto n = *rc::gen::inRange<Size>(0, 40);
  PointSet points;
  points.dimension = dimension;
  points.position = *rc::gen::container<std::vector<double>>(n * static_cast<Size>(dimension), between(0.0, 1.0));
  points.volume = *rc::gen::container<std::vector<double>>(n, between(1e-4, 0.05));
  points.smoothing_length = *rc::gen::container<std::vector<double>>(n, between(0.05, 0.4));
  points.n_active = *rc::gen::inRange<Size>(0, n + 1);
  for (Size i = 0; i < n; ++i)
    points.owner.push_back(i < points.n_active || points.n_active == 0 || i % 3 == 0
                               ? (i < points.n_active ? static_cast<double>(i) : -1.0)
                               : static_cast<double>(i % points.n_active));
  return points;
}

std::vector<double> any_values(Size n) { return *rc::gen::container<std::vector<double>>(n, between(-100.0, 100.0)); }

/// The cloud in another order: active points are exchanged with active points, ghosts with ghosts.
PointSet reordered(const PointSet& points, const std::vector<Size>& order) {
  const auto d = static_cast<Size>(points.dimension);
  PointSet out = points;
  std::vector<Size> place(order.size());
  for (Size k = 0; k < order.size(); ++k) place[order[k]] = k;
  for (Size k = 0; k < order.size(); ++k) {
    const Size from = order[k];
    std::copy_n(points.position.begin() + static_cast<std::ptrdiff_t>(from * d), d,
                out.position.begin() + static_cast<std::ptrdiff_t>(k * d));
    out.volume[k] = points.volume[from];
    out.smoothing_length[k] = points.smoothing_length[from];
    const double owner = points.owner[from];
    out.owner[k] = owner < 0.0 ? -1.0 : static_cast<double>(place[static_cast<Size>(owner)]);
  }
  return out;
}

std::vector<Size> any_order(const PointSet& points) {
  std::vector<Size> order(points.size());
  std::iota(order.begin(), order.end(), Size{0});
  const auto seed = *rc::gen::inRange<Size>(1, 1000);
  // A walk through either part in steps of `seed` is a sufficient permutation, and can be reduced to the identity.
  const auto shuffle = [seed](auto first, auto last) {
    const auto n = static_cast<Size>(last - first);
    for (Size i = 0; i < n; ++i)
      std::swap(first[static_cast<std::ptrdiff_t>(i)], first[static_cast<std::ptrdiff_t>((i * seed + seed - 1) % n)]);
  };
  shuffle(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(points.n_active));
  shuffle(order.begin() + static_cast<std::ptrdiff_t>(points.n_active), order.end());
  return order;
}

template <int D>
double distance(const PointSet& a, Size i, const PointSet& b, Size j) {
  double sum = 0.0;
  for (Size c = 0; c < D; ++c) sum += std::pow(a.position[i * D + c] - b.position[j * D + c], 2);
  return std::sqrt(sum);
}

std::vector<double> mapped(const CloudPairs<2>& pairs, const std::vector<double>& values) {
  const Field field{"f", 1, values};
  const std::vector<const Field*> fields = {&field};
  return pairs.consistent(fields, {}).front().values;
}

template <int D>
void partition_of_unity() {
  const auto source = any_cloud(D), target = any_cloud(D);
  CloudPairs<D> pairs;
  pairs.update(source, target);
  const double value = *between(-100.0, 100.0);
  const Field field{"f", 1, std::vector<double>(source.size(), value)};
  const std::vector<const Field*> fields = {&field};
  const auto result = pairs.consistent(fields, {}).front().values;
  RC_ASSERT(result.size() == target.n_active);
  for (Size i = 0; i < target.n_active; ++i) {
    double coverage = 0.0;
    for (Size j = 0; j < source.size(); ++j)
      coverage +=
          source.volume[j] * sph::WendlandC2<D>::value(distance<D>(source, j, target, i), source.smoothing_length[j]);
    RC_ASSERT(std::abs(pairs.coverage()[i] - coverage) <= 1e-12 * (1.0 + coverage));
    const double expected = pairs.coverage()[i] > 0.0 ? value : 0.0;
    RC_ASSERT(std::abs(result[i] - expected) <= 1e-11 * std::abs(value));
  }
}

RC_GTEST_PROP(MappingProperties, PartitionOfUnityAndConstantsIn2D, ()) { partition_of_unity<2>(); }
RC_GTEST_PROP(MappingProperties, PartitionOfUnityAndConstantsIn3D, ()) { partition_of_unity<3>(); }

RC_GTEST_PROP(MappingProperties, NothingLeavesTheRangeOfWhatWasGiven, ()) {
  const auto source = any_cloud(2), target = any_cloud(2);
  CloudPairs<2> pairs;
  pairs.update(source, target);
  const auto values = any_values(source.size());
  if (values.empty()) return;
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const auto result = mapped(pairs, values);
  for (Size i = 0; i < result.size(); ++i)
    if (pairs.coverage()[i] > 0.0) RC_ASSERT(result[i] >= *low - 1e-9 && result[i] <= *high + 1e-9);
}

RC_GTEST_PROP(MappingProperties, WhatIsGivenIsDeliveredOrKept, ()) {
  const auto receiver = any_cloud(2), giver = any_cloud(2);
  CloudPairs<2> pairs;
  pairs.update(receiver, giver);
  const Field amounts{"J", 2, any_values(2 * giver.size())};
  const std::vector<double> carried = any_values(2);
  const auto delivery = pairs.conservative(amounts, carried);
  for (Size c = 0; c < 2; ++c) {
    double given = carried[c], size = std::abs(carried[c]), got = delivery.undelivered[c];
    for (Size i = 0; i < giver.n_active; ++i) {
      given += amounts.values[2 * i + c];
      size += std::abs(amounts.values[2 * i + c]);
    }
    for (Size j = 0; j < receiver.n_active; ++j) {
      got += delivery.values[2 * j + c];
      size += std::abs(delivery.values[2 * j + c]);
    }
    RC_ASSERT(std::abs(given - got) <= 1e-13 * size);
  }
}

RC_GTEST_PROP(MappingProperties, TheOrderOfPointsDoesNotMatter, ()) {
  const auto source = any_cloud(2), target = any_cloud(2);
  const auto source_order = any_order(source), target_order = any_order(target);
  const auto values = any_values(source.size());
  std::vector<double> other_values(values.size());
  for (Size k = 0; k < source_order.size(); ++k) other_values[k] = values[source_order[k]];
  CloudPairs<2> pairs, other;
  pairs.update(source, target);
  other.update(reordered(source, source_order), reordered(target, target_order));
  const auto result = mapped(pairs, values), other_result = mapped(other, other_values);
  for (Size k = 0; k < other_result.size(); ++k) RC_ASSERT(std::abs(other_result[k] - result[target_order[k]]) <= 1e-8);
}

/// Where nothing is balanced, the shares of amounts are the transpose of the interpolation's weights.
RC_GTEST_PROP(MappingProperties, OneGiverSharesOutByTheWeightsThatWouldAverageAtIt, ()) {
  const auto receiver = any_cloud(2);
  PointSet giver;
  giver.position = *rc::gen::container<std::vector<double>>(2, between(0.0, 1.0));
  giver.volume = {1e-3};
  giver.smoothing_length = {0.1};
  giver.owner = {0.0};
  giver.n_active = 1;
  CloudPairs<2> pairs;
  pairs.update(receiver, giver);
  const auto delivery = pairs.conservative({"J", 1, {1.0}}, {});
  double least = 0.0;
  for (const double share : delivery.values) least = std::min(least, share);
  RC_ASSERT(least >= 0.0);
  RC_ASSERT(std::abs(std::accumulate(delivery.values.begin(), delivery.values.end(), delivery.undelivered[0]) - 1.0) <
            1e-13);
  RC_ASSERT((delivery.undelivered[0] == 0.0 || delivery.undelivered[0] == 1.0));
}

}  // namespace
}  // namespace poretwin::coupling
