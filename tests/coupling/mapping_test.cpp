// The mapping is compared with a slow, simple version of itself; properties: constants, linear fields, conservation,
// permutations, empty sets.
#include "common/coupling/mock.hpp"
#include "common/particles/kernel.hpp"
#include "coupler/pairing.hpp"
#include "tests/coupling/cloud_pairs.hpp"

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

namespace poretwin::coupling {
namespace {

using Size = std::size_t;

/// A disordered cloud: lattice points displaced by up to `shake` spacings, with different smoothing lengths; the last
/// tenth are ghosts.
PointSet cloud(int dimension, double size, double spacing, unsigned seed, double shake = 0.3) {
  const std::vector<double> zero(static_cast<Size>(dimension), 0.0), extent(static_cast<Size>(dimension), size);
  PointSet points = lattice_points(dimension, zero, extent, spacing);
  std::mt19937_64 generator(seed);
  std::uniform_real_distribution<double> uniform(-shake * spacing, shake * spacing), ratio(0.9, 1.1);
  for (auto& x : points.position) x += uniform(generator);
  for (auto& h : points.smoothing_length) h *= ratio(generator);
  points.n_active = points.size() - points.size() / 10;
  for (Size i = points.n_active; i < points.size(); ++i)
    points.owner[i] = i % 2 ? -1.0 : static_cast<double>(i % points.n_active);
  return points;
}

template <int D>
Vec<D> at(const PointSet& points, Size i) {
  return Eigen::Map<const Vec<D>>(points.position.data() + i * D);
}

std::vector<double> random_values(Size n, unsigned seed) {
  std::mt19937_64 generator(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::vector<double> values(n);
  for (auto& v : values) v = uniform(generator);
  return values;
}

/// The simple version: all pairs, and the weighted least-squares plane as a regression with Eigen's LDLT.
template <int D>
double plain_value(const PointSet& source, const std::vector<double>& f, const std::vector<double>& mask,
                   const Vec<D>& x) {
  double m0 = 0.0, mean_f = 0.0, length = 0.0, low = INFINITY, high = -INFINITY;
  Vec<D> mean = Vec<D>::Zero();
  auto weight = [&](Size j) {
    const double h = source.smoothing_length[j];
    return source.volume[j] * sph::WendlandC2<D>::value((at<D>(source, j) - x).norm(), h) *
           (mask.empty() ? 1.0 : mask[j]);
  };
  for (Size j = 0; j < source.size(); ++j) {
    const double w = weight(j);
    if (w <= 0.0) continue;
    m0 += w;
    mean_f += w * f[j];
    mean += w * (at<D>(source, j) - x);
    length += w * source.smoothing_length[j];
    low = std::min(low, f[j]);
    high = std::max(high, f[j]);
  }
  if (!(m0 > 1e-12)) return 0.0;
  mean_f /= m0;
  mean /= m0;
  length /= m0;
  Mat<D> covariance = Mat<D>::Zero();
  Vec<D> moment = Vec<D>::Zero();
  for (Size j = 0; j < source.size(); ++j) {
    const Vec<D> d = at<D>(source, j) - x - mean;
    covariance += weight(j) / m0 * d * d.transpose();
    moment += weight(j) / m0 * (f[j] - mean_f) * d;
  }
  const double spread = Eigen::SelfAdjointEigenSolver<Mat<D>>(covariance).eigenvalues()[0] / (length * length);
  const double share = std::clamp((spread - slope_off) / (slope_full - slope_off), 0.0, 1.0);
  if (share == 0.0) return mean_f;
  return std::clamp(mean_f - share * covariance.ldlt().solve(moment).dot(mean), low, high);
}

template <int D>
void compare_with_twin(const PointSet& source, const PointSet& target, const std::vector<double>& mask) {
  CloudPairs<D> pairs;
  pairs.update(source, target);
  const Field f{"f", 1, random_values(source.size(), 5)};
  const std::vector<const Field*> fields = {&f};
  const auto mapped = pairs.consistent(fields, mask).at(0);
  ASSERT_EQ(mapped.values.size(), target.n_active);
  for (Size i = 0; i < target.n_active; ++i)
    ASSERT_NEAR(mapped.values[i], plain_value<D>(source, f.values, mask, at<D>(target, i)), 1e-12) << "target " << i;
}

TEST(Mapping, AgreesWithThePlainTwin) {
  auto target = cloud(2, 1.3, 0.06, 2);  // partly outside the source
  const auto source = cloud(2, 1.0, 0.05, 1);
  compare_with_twin<2>(source, target, {});
  auto mask = random_values(source.size(), 3);
  for (auto& m : mask) m = std::max(0.0, m);
  compare_with_twin<2>(source, target, mask);
  compare_with_twin<3>(cloud(3, 0.6, 0.1, 3), cloud(3, 0.7, 0.09, 4), {});
}

TEST(Mapping, AllSetsOfInstructionsAgree) {
  const auto source = cloud(3, 0.6, 0.1, 3), target = cloud(3, 0.7, 0.09, 4);
  const Field f{"f", 3, random_values(3 * std::max(source.size(), target.size()), 5)};
  CloudPairs<3> pairs;
  pairs.update(source, target);
  const auto best = instructions();
  const auto wide = pairs.consistent({&f}, {}).at(0).values, wide_shares = pairs.conservative(f, {}).values;
  for (const auto lower : {Instructions::plain, Instructions::avx2}) {
    if (lower >= best) continue;
    instructions() = lower;
    const auto values = pairs.consistent({&f}, {}).at(0).values, shares = pairs.conservative(f, {}).values;
    for (Size i = 0; i < wide.size(); ++i) EXPECT_NEAR(wide[i], values[i], 1e-12);
    for (Size i = 0; i < wide_shares.size(); ++i) EXPECT_NEAR(wide_shares[i], shares[i], 1e-12);
  }
  instructions() = best;
}

TEST(Mapping, CoverageIsTheSumOfWeights) {
  const auto source = cloud(2, 1.0, 0.05, 1, 0.0), target = cloud(2, 1.4, 0.07, 2);
  CloudPairs<2> pairs;
  pairs.update(source, target);
  for (Size i = 0; i < target.n_active; ++i) {
    double sum = 0.0;
    for (Size j = 0; j < source.size(); ++j)
      sum += source.volume[j] *
             sph::WendlandC2<2>::value((at<2>(source, j) - at<2>(target, i)).norm(), source.smoothing_length[j]);
    EXPECT_NEAR(pairs.coverage()[i], sum, 1e-12);
  }
}

TEST(Mapping, SpreadTellsAPointFromAnEdge) {
  const auto spread_at = [](PointSet source, double x, double y) {
    PointSet place = lattice_points(2, {x - 0.05, y - 0.05}, {0.1, 0.1}, 0.1);
    for (auto* points : {&source, &place}) points->smoothing_length.assign(points->size(), 0.12);
    CloudPairs<2> pairs;
    pairs.update(source, place);
    return pairs.interpolate({}, {}).spread.at(0);
  };
  const auto square = [](double width, double height) { return lattice_points(2, {0.0, 0.0}, {width, height}, 0.1); };
  EXPECT_NEAR(spread_at(square(0.1, 0.1), 0.09, 0.05), 0.0, 1e-7);        // one point
  EXPECT_NEAR(spread_at(square(0.2, 0.1), 0.1, 0.05), 0.5 / 1.2, 1e-12);  // between two
  EXPECT_NEAR(spread_at(square(2.0, 2.0), 1.05, 2.0), 0.57, 1e-3);        // a flat edge
  EXPECT_NEAR(spread_at(square(2.0, 2.0), 1.05, 1.05), 0.737, 1e-3);      // inside
  EXPECT_EQ(spread_at(square(0.1, 0.1), 1.0, 1.0), 0.0);                  // uncovered
}

template <int D>
void constants_and_planes(double size, double spacing) {
  const auto source = cloud(D, size, spacing, 1), target = cloud(D, 1.3 * size, 0.9 * spacing, 2);
  Field constant{"c", 1, std::vector<double>(source.size(), 7.25)}, plane{"p", D, {}};
  Vec<D> slope = Vec<D>::LinSpaced(1.0, 2.0);
  for (Size j = 0; j < source.size(); ++j)
    for (int c = 0; c < D; ++c) plane.values.push_back(3.0 + (c + 1) * slope.dot(at<D>(source, j)));
  CloudPairs<D> pairs;
  pairs.update(source, target);
  const std::vector<const Field*> fields = {&constant, &plane};
  const auto mapped = pairs.consistent(fields, {});
  Size inside = 0;
  for (Size i = 0; i < target.n_active; ++i) {
    const bool covered = pairs.coverage()[i] > 0.0;
    EXPECT_NEAR(mapped[0].values[i], covered ? 7.25 : 0.0, 1e-12);
    const Vec<D> x = at<D>(target, i);
    if (x.minCoeff() < spacing || x.maxCoeff() > size - spacing) continue;
    ++inside;
    for (int c = 0; c < D; ++c)
      EXPECT_NEAR(mapped[1].values[i * D + static_cast<Size>(c)], 3.0 + (c + 1) * slope.dot(x), 1e-11);
  }
  EXPECT_GT(inside, 50u);
}

TEST(Mapping, ConstantsAreExactEverywherePlanesInside) {
  constants_and_planes<2>(1.0, 0.05);
  constants_and_planes<3>(0.8, 0.1);
}

TEST(Mapping, NeverLeavesTheRangeOfTheNeighbours) {
  const auto source = cloud(2, 1.0, 0.05, 1), target = cloud(2, 1.3, 0.03, 2);
  Field plane{"p", 1, {}};
  for (Size j = 0; j < source.size(); ++j) plane.values.push_back(1e4 * (1.0 - at<2>(source, j)[1]));
  const auto [low, high] = std::minmax_element(plane.values.begin(), plane.values.end());
  CloudPairs<2> pairs;
  pairs.update(source, target);
  const std::vector<const Field*> fields = {&plane};
  const auto mapped = pairs.consistent(fields, {}).at(0);
  for (Size i = 0; i < target.n_active; ++i) {
    if (pairs.coverage()[i] == 0.0) continue;
    EXPECT_GE(mapped.values[i], *low - 1e-9);  // rounding of means of numbers near 1e4
    EXPECT_LE(mapped.values[i], *high + 1e-9);
  }
}

TEST(Mapping, OnePointAndARowOfPointsFallBackToTheMean) {
  for (const double length : {0.1, 1.0}) {
    const auto source = lattice_points(2, {0.0, 0.0}, {length, 0.1}, 0.1), target = cloud(2, 1.0, 0.05, 2);
    CloudPairs<2> pairs;
    pairs.update(source, target);
    const Field f{"f", 1, std::vector<double>(source.size(), 2.0)};
    const std::vector<const Field*> fields = {&f};
    const auto mapped = pairs.consistent(fields, {}).at(0);
    for (Size i = 0; i < target.n_active; ++i)
      EXPECT_NEAR(mapped.values[i], pairs.coverage()[i] > 0.0 ? 2.0 : 0.0, 1e-13);
  }
}

TEST(Mapping, AmountsAreConserved) {
  const auto giver = cloud(2, 1.3, 0.06, 2), receiver = cloud(2, 1.0, 0.05, 1);
  CloudPairs<2> pairs;
  pairs.update(receiver, giver);  // the weights by which receivers would be interpolated to givers
  Field amounts{"impulse", 2, random_values(2 * giver.size(), 9)};
  const std::vector<double> carried = {0.5, -2.0};
  const auto delivery = pairs.conservative(amounts, carried);
  ASSERT_EQ(delivery.values.size(), 2 * receiver.n_active);
  for (Size c = 0; c < 2; ++c) {
    double given = carried[c], size = std::abs(carried[c]), got = 0.0;
    for (Size i = 0; i < giver.n_active; ++i) {
      given += amounts.values[2 * i + c];
      size += std::abs(amounts.values[2 * i + c]);
    }
    for (Size j = 0; j < receiver.n_active; ++j) got += delivery.values[2 * j + c];
    EXPECT_NEAR(got + delivery.undelivered[c], given, 1e-14 * size);
    EXPECT_NEAR(got, delivery.delivered[c], 1e-14 * size);
    EXPECT_NE(delivery.undelivered[c], 0.0);  // some givers are far from every receiver
  }
  // The simple version: a dense matrix of kernel weights over receivers and their ghosts, balanced column by column
  // where givers surround a receiver, then distributed row by row.
  const Size rows = giver.n_active, columns = receiver.n_active;
  Eigen::MatrixXd w = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(columns));
  Eigen::VectorXd lengths = Eigen::VectorXd::Zero(w.cols());
  std::vector<Vec<2>> moment(columns, Vec<2>::Zero());
  for (Size i = 0; i < rows; ++i)
    for (Size j = 0; j < receiver.size(); ++j) {
      if (receiver.owner[j] < 0.0) continue;
      const Vec<2> r = at<2>(giver, i) - at<2>(receiver, j);
      const double value = receiver.volume[j] * sph::WendlandC2<2>::value(r.norm(), receiver.smoothing_length[j]);
      const auto owner = static_cast<Eigen::Index>(receiver.owner[j]);
      w(static_cast<Eigen::Index>(i), owner) += value;
    }
  // Whether givers surround a receiver: their images behind walls count.
  for (Size j = 0; j < columns; ++j)
    for (Size i = 0; i < giver.size(); ++i) {
      const double owner = i < rows ? static_cast<double>(i) : giver.owner[i];
      if (owner < 0.0 || owner >= static_cast<double>(rows)) continue;
      const Vec<2> r = at<2>(giver, i) - at<2>(receiver, j);
      const double value = receiver.volume[j] * sph::WendlandC2<2>::value(r.norm(), receiver.smoothing_length[j]);
      lengths[static_cast<Eigen::Index>(j)] += value * receiver.smoothing_length[j];
      moment[j] += value * r;
    }
  const auto volumes = Eigen::Map<const Eigen::VectorXd>(giver.volume.data(), w.rows());
  Eigen::VectorXd scale = Eigen::VectorXd::Ones(w.cols());
  const auto shares = [&] {
    Eigen::MatrixXd out = w * scale.asDiagonal();
    for (Eigen::Index i = 0; i < w.rows(); ++i) {
      const double total = out.row(i).sum();
      out.row(i) *= total > 1e-12 ? 1.0 / total : 0.0;
    }
    return out;
  };
  for (int round = 0; round < balancing_rounds; ++round) {
    const Eigen::VectorXd load = shares().transpose() * volumes;
    for (Eigen::Index j = 0; j < w.cols(); ++j)
      if (load[j] > 0.0 && moment[static_cast<Size>(j)].norm() <= inside_asymmetry * lengths[j])
        scale[j] = std::clamp(scale[j] * receiver.volume[static_cast<Size>(j)] / load[j], 0.25, 4.0);
  }
  Eigen::VectorXd given(w.rows());
  for (Eigen::Index i = 0; i < w.rows(); ++i) given[i] = amounts.values[2 * static_cast<Size>(i)];
  const Eigen::VectorXd plain = shares().transpose() * given;
  const auto alone = pairs.conservative(amounts, {});
  for (Size j = 0; j < receiver.n_active; ++j)
    EXPECT_NEAR(alone.values[2 * j], plain[static_cast<Eigen::Index>(j)], 1e-12);
}

TEST(Mapping, AnEvenGivingArrivesEvenlyInsideDisorderedPoints) {
  auto giver = cloud(2, 2.0, 0.05, 2, 0.25), receiver = cloud(2, 2.0, 0.05, 1, 0.25);
  for (auto* points : {&giver, &receiver}) {  // no ghosts here
    points->n_active = points->size();
    std::iota(points->owner.begin(), points->owner.end(), 0.0);
  }
  CloudPairs<2> pairs;
  pairs.update(receiver, giver);
  const auto delivery = pairs.conservative(Field{"impulse", 1, giver.volume}, {});
  for (Size j = 0; j < receiver.size(); ++j) {
    const Vec<2> x = at<2>(receiver, j);
    if (x.minCoeff() < 0.3 || x.maxCoeff() > 1.7) continue;
    EXPECT_NEAR(delivery.values[j] / receiver.volume[j], 1.0, 0.02) << j;  // without balancing, shares scatter by 0.2
  }
}

TEST(Mapping, AWallIsNoEdgeForAnEvenGiving) {
  // Four columns between walls, seven rows with free sides: every receiver of a row gets the same. Where the rows at
  // the free sides were balanced in the middle columns only, those beside the walls got 8 % less.
  PointSet points;
  const double spacing = 0.1;
  for (const bool real : {true, false})
    for (int column = -3; column < 7; ++column)
      for (int row = 0; row < 7; ++row) {
        const int mirrored = column < 0 ? -1 - column : column > 3 ? 7 - column : column;
        if ((mirrored == column) != real) continue;
        points.position.insert(points.position.end(), {(column + 0.5) * spacing, (row + 0.5) * spacing});
        points.volume.push_back(spacing * spacing);
        points.smoothing_length.push_back(1.3 * spacing);
        points.owner.push_back(mirrored * 7 + row);
        points.n_active += real ? 1 : 0;
      }
  PointSet receivers = points;
  for (Size c = 1; c < receivers.position.size(); c += 2) receivers.position[c] += 0.01 * spacing;
  CloudPairs<2> pairs;
  pairs.update(receivers, points);
  const auto delivery = pairs.conservative(Field{"impulse", 1, points.volume}, {});
  for (Size j = 0; j < receivers.n_active; ++j)
    EXPECT_NEAR(delivery.values[j] / delivery.values[7 + j % 7], 1.0, 2e-3) << j;
}

TEST(Mapping, NothingToReceiveIsKeptAndDeliveredLater) {
  auto mapping = make_mapping(2);
  const std::vector<FieldSpec> takes = {{"impulse", "N s", 2, coupling::Mapping::conservative, ""}};
  const auto giver = cloud(2, 1.0, 0.1, 1), nobody = PointSet{}, receiver = cloud(2, 1.0, 0.1, 2);
  const std::vector<Field> amounts = {{"impulse", 2, std::vector<double>(2 * giver.size(), 1.0)}};
  const double total = static_cast<double>(giver.n_active);
  EXPECT_TRUE(mapping->map(Role::fluid, giver, amounts, takes, nobody).at("impulse").values.empty());
  EXPECT_NEAR(mapping->accounts().at(0).undelivered[0], total, 1e-12 * total);
  const auto inbox = mapping->map(Role::fluid, giver, amounts, takes, receiver);
  const auto& values = inbox.at("impulse").values;
  double got = 0.0;
  for (Size j = 0; j < receiver.n_active; ++j) got += values[2 * j];
  const auto& account = mapping->accounts().at(0);
  EXPECT_NEAR(got + account.undelivered[0], 2.0 * total, 1e-13 * total);
  EXPECT_LT(account.undelivered[0], 0.2 * total);
  EXPECT_NEAR(account.given[0], account.delivered[0] + account.undelivered[0], 1e-13 * total);
}

/// The same points in another order, with one more point of the solid; then moved far away from each other.
TEST(Mapping, PairedPointsTakeTheirPartnersValuesHoweverTheyMove) {
  const PointSet fluid = lattice_points(2, {0.0, 0.0}, {1.0, 1.0}, 0.1);
  PointSet solid = fluid;
  const Size n = fluid.size();
  for (Size i = 0; i < n; ++i)
    for (Size d = 0; d < 2; ++d) solid.position[2 * i + d] = fluid.position[2 * (n - 1 - i) + d];
  solid.position.insert(solid.position.end(), {1.05, 0.95});  // nearest to the fluid's last point
  for (auto* array : {&solid.volume, &solid.smoothing_length, &solid.owner}) array->push_back(array->back());
  solid.owner.back() = static_cast<double>(n);
  solid.n_active = n + 1;
  const std::vector<FieldSpec> takes = {{"f", "1", 1, coupling::Mapping::consistent, ""}};
  const Field f{"f", 1, random_values(n, 5)}, g{"f", 1, random_values(n + 1, 6)};
  const auto mapping = make_paired_mapping(2);
  for (int round = 0; round < 2; ++round) {
    const auto at_solid = mapping->map(Role::fluid, fluid, {f}, takes, solid).at("f").values;
    const auto at_fluid = mapping->map(Role::solid, solid, {g}, takes, fluid).at("f").values;
    ASSERT_EQ(at_solid.size(), n + 1);
    ASSERT_EQ(at_fluid.size(), n);
    for (Size i = 0; i < n; ++i) {
      EXPECT_EQ(at_solid[i], f.values[n - 1 - i]);
      EXPECT_EQ(at_fluid[i], g.values[n - 1 - i]);
    }
    EXPECT_EQ(at_solid[n], f.values[n - 1]);
    for (Size i = 0; i < solid.size(); ++i) solid.position[2 * i] *= 5.0;
  }
}

TEST(Mapping, PointsThatAreNotTheSameAreMappedAsClouds) {
  const PointSet fluid = lattice_points(2, {0.0, 0.0}, {1.0, 1.0}, 0.1),
                 solid = lattice_points(2, {0.05, 0.05}, {1.0, 1.0}, 0.1);
  const std::vector<FieldSpec> takes = {{"f", "1", 1, coupling::Mapping::consistent, ""}};
  const Field f{"f", 1, random_values(fluid.size(), 5)};
  EXPECT_EQ(make_paired_mapping(2)->map(Role::fluid, fluid, {f}, takes, solid).at("f").values,
            make_mapping(2)->map(Role::fluid, fluid, {f}, takes, solid).at("f").values);
}

TEST(Mapping, TheOrderOfPointsDoesNotMatter) {
  const auto source = cloud(2, 1.0, 0.05, 1), target = cloud(2, 1.0, 0.06, 2);
  std::vector<Size> order(source.size());
  std::iota(order.begin(), order.end(), Size{0});
  std::shuffle(order.begin(), order.end(), std::mt19937_64(4));
  const Field f{"f", 1, random_values(source.size(), 5)};
  auto shuffled = source;
  Field g = f;
  for (Size k = 0; k < order.size(); ++k) {
    for (Size d = 0; d < 2; ++d) shuffled.position[2 * k + d] = source.position[2 * order[k] + d];
    shuffled.smoothing_length[k] = source.smoothing_length[order[k]];
    g.values[k] = f.values[order[k]];
  }
  CloudPairs<2> a, b;
  a.update(source, target);
  b.update(shuffled, target);
  const std::vector<const Field*> fa = {&f}, fb = {&g};
  const auto va = a.consistent(fa, {}).at(0).values, vb = b.consistent(fb, {}).at(0).values;
  for (Size i = 0; i < va.size(); ++i) EXPECT_NEAR(va[i], vb[i], 1e-12);
}

TEST(Mapping, ReusedListsGiveWhatFreshOnesGive) {
  auto source = cloud(2, 1.0, 0.05, 1), target = cloud(2, 1.2, 0.06, 2);
  CloudPairs<2> kept;
  const Field f{"f", 1, random_values(std::max(source.size(), target.size()), 5)};
  const std::vector<const Field*> fields = {&f};
  const auto step = random_values(source.position.size(), 6);
  for (int k = 0; k < 40; ++k) {
    for (Size p = 0; p < source.position.size(); ++p) source.position[p] += 0.001 * step[p];
    for (auto& h : source.smoothing_length) h *= 1.0005;
    if (k % 7 == 6) {  // the moving cloud loses a point, the other is unchanged
      source.position.resize(source.position.size() - 2);
      for (auto* values : {&source.volume, &source.smoothing_length, &source.owner}) values->pop_back();
    }
    if (k % 5 == 3)
      for (auto& v : source.volume) v *= 1.01;
    if (k == 20)
      for (auto& x : target.position) x += 0.02;
    CloudPairs<2> fresh;
    kept.update(source, target);
    fresh.update(source, target);
    const auto a = kept.consistent(fields, {}).at(0).values, b = fresh.consistent(fields, {}).at(0).values;
    ASSERT_EQ(a, b) << "step " << k;  // bit by bit: the age of a list must not change a result
    ASSERT_EQ(kept.conservative(f, {}).values, fresh.conservative(f, {}).values) << "step " << k;
    kept.update(source, target);  // nothing has moved: the weights are kept
    ASSERT_EQ(kept.consistent(fields, {}).at(0).values, b) << "step " << k;
  }
  EXPECT_GT(kept.reuses(), 20u);
  EXPECT_GT(kept.rebuilds(), 2u);
}

TEST(Mapping, FieldsThatAreZeroEverywhereStayZeroAndDoNotDisturbOthers) {
  const auto source = cloud(2, 1.0, 0.05, 1), target = cloud(2, 1.3, 0.06, 2);
  const Size n = source.size();
  const Field zero{"z", 2, std::vector<double>(2 * n, 0.0)}, negative{"n", 1, std::vector<double>(n, -0.0)},
      f{"f", 2, random_values(2 * n, 5)}, g{"g", 1, random_values(n, 6)};
  auto mask = random_values(n, 3);
  for (auto& m : mask) m = std::max(0.0, m);
  CloudPairs<2> pairs;
  pairs.update(source, target);
  for (const std::span<const double> weights : {std::span<const double>(), std::span<const double>(mask)}) {
    const auto alone = pairs.consistent({&f, &g}, weights),
               among = pairs.consistent({&zero, &f, &negative, &g}, weights);
    ASSERT_EQ(among.size(), 4u);
    EXPECT_EQ(among[0].values, std::vector<double>(2 * target.n_active, 0.0));
    EXPECT_EQ(among[1].values, alone[0].values);
    EXPECT_EQ(among[2].values, std::vector<double>(target.n_active, 0.0));
    EXPECT_EQ(among[3].values, alone[1].values);
    for (Size c = 0; c < 4; ++c) EXPECT_EQ(among[c].name, (std::array{"z", "f", "n", "g"})[c]);
  }
}

TEST(Mapping, EmptySetsOnEitherSide) {
  const PointSet none;
  const auto some = cloud(2, 1.0, 0.1, 1);
  const Field empty{"f", 1, {}}, full{"f", 1, std::vector<double>(some.size(), 1.0)};
  CloudPairs<2> pairs;
  pairs.update(none, some);
  const std::vector<const Field*> from_none = {&empty};
  EXPECT_EQ(pairs.consistent(from_none, {}).at(0).values, std::vector<double>(some.n_active, 0.0));
  EXPECT_EQ(pairs.coverage(), std::vector<double>(some.n_active, 0.0));
  pairs.update(some, none);
  const std::vector<const Field*> from_some = {&full};
  EXPECT_TRUE(pairs.consistent(from_some, {}).at(0).values.empty());
  pairs.update(some, some);
  EXPECT_NEAR(pairs.consistent(from_some, {}).at(0).values[5], 1.0, 1e-13);
}

TEST(Mapping, PropertiesComeFromTheNearestPoint) {
  // Two soils with values ten thousand times apart: no point of the water may get a mean of them.
  const auto soil = cloud(2, 1.0, 0.1, 5, 0.2), water = cloud(2, 1.4, 0.07, 6);
  Field k{"k", 1, {}};
  for (Size j = 0; j < soil.size(); ++j) k.values.push_back(at<2>(soil, j).y() < 0.5 ? 1e-7 : 1e-3);
  CloudPairs<2> pairs;
  pairs.update(soil, water);
  const auto mapped = pairs.nearest({&k}).at(0).values;
  for (Size i = 0; i < water.n_active; ++i) {
    double most = 0.0, value = 0.0;
    for (Size j = 0; j < soil.size(); ++j) {
      const double w = soil.volume[j] *
                       sph::WendlandC2<2>::value((at<2>(soil, j) - at<2>(water, i)).norm(), soil.smoothing_length[j]);
      if (w > most) most = w, value = k.values[j];
    }
    if (most < 1e-9) continue;  // the rim of a support
    EXPECT_NEAR(mapped[i] / value, 1.0, 1e-12) << i;
  }
}

}  // namespace
}  // namespace poretwin::coupling
