// Discrete operators on fields with known derivatives.
#include "fluid_solver/discretisation/operators.hpp"
#include "fluid_solver/boundary/faces.hpp"
#include "fluid_solver/discretisation/free_surface.hpp"
#include "fluid_solver/discretisation/unresolved_pressure.hpp"

#include <gtest/gtest.h>

#include <Eigen/QR>

#include <random>

namespace poretwin::fluid {
namespace {

template <int D>
Stencil<D> box(double jitter, std::size_t count, std::span<const sph::ImagePlane<D>> planes,
               std::vector<Vec<D>>* points = nullptr, bool by_density = false) {
  VecArray<D> x;
  std::mt19937_64 generator(3);
  std::uniform_real_distribution<double> noise(-jitter, jitter);
  const double dx = 1.0 / static_cast<double>(count);
  for (std::size_t k = 0; k < (D == 3 ? count : 1); ++k)
    for (std::size_t j = 0; j < count; ++j)
      for (std::size_t i = 0; i < count; ++i) {
        const std::size_t cell[3] = {i, j, k};
        Vec<D> p;
        for (int d = 0; d < D; ++d) p[d] = (static_cast<double>(cell[d]) + 0.5 + noise(generator)) * dx;
        x.push_back(p);
      }
  if (points) *points = x;
  const ScalarArray volume(x.size(), std::pow(dx, D));
  return make_stencil<D>(x, volume, std::span<const Buffer<D>>(), planes, {}, by_density);
}

template <int D>
std::vector<sph::ImagePlane<D>> walls() {
  std::vector<sph::ImagePlane<D>> planes;
  for (int d = 0; d < D; ++d)
    for (const double side : {0.0, 1.0}) {
      sph::ImagePlane<D> plane;
      plane.point = Vec<D>::Constant(side);
      plane.normal[d] = side > 0.0 ? -1.0 : 1.0;
      plane.boundary = 2 * d + (side > 0.0);
      planes.push_back(plane);
    }
  return planes;
}

template <int D>
void expect_linear_exactness() {
  VecArray<D> x;
  const auto s = box<D>(0.2, 8, {}, &x);
  Vec<D> slope;
  Mat<D> shear;
  for (int i = 0; i < D; ++i) {
    slope[i] = 1.0 + 0.5 * i;
    for (int j = 0; j < D; ++j) shear(i, j) = 0.3 * i - 0.7 * j + (i == j ? 2.0 : 0.0);
  }
  ScalarArray p;
  VecArray<D> v;
  for (const auto& point : x) {
    p.push_back(slope.dot(point) + 3.0);
    v.push_back(shear * point);
  }
  const auto g = pressure_gradient<D>(
      s, p, [](Index) { return 0.0; }, {}, Vec<D>::Zero(), [](std::size_t) { return 0.0; });
  const auto d = divergence<D>(s, v);
  std::size_t sparse = 0;
  for (std::size_t a = 0; a < x.size(); ++a) {
    // At open corners and edges (3D) of the block there are too few neighbours: gradients are reduced there, never
    // amplified.
    if (s.least_moment[a] < 0.3) {
      ++sparse;
      continue;
    }
    EXPECT_LT((g[a] - slope).norm(), 1e-10) << a;
    EXPECT_NEAR(d[a], shear.trace(), 1e-10) << a;
  }
  EXPECT_LE(sparse, D == 2 ? 4u : x.size() / 5);
}

// Disordered points between walls: nothing under a linear pressure, corners included, and what one particle gets others
// give. On a lattice all of a pressure that alternates from point to point, whose gradient is zero. A fit that leaves
// out pairs of the corners (least_pair_moment) sees a linear pressure there.
template <int D>
void expect_only_alternating_pressures_seen() {
  VecArray<D> x;
  const auto planes = walls<D>();
  const auto s = box<D>(0.2, 8, planes, &x);
  const PairMatrix laplacian = fluid::laplacian<D>(s, {});
  const UnresolvedPressure<D> unresolved(s, laplacian);
  ScalarArray linear, disordered;
  std::mt19937_64 generator(5);
  std::uniform_real_distribution<double> noise(-1.0, 1.0);
  for (const auto& point : x) {
    linear.push_back(1.0 + point.dot(Vec<D>::LinSpaced(D, 2.0, -3.0)));
    disordered.push_back(noise(generator));
  }
  ScalarArray plain(x.size());
  laplacian.apply(std::span<const double>(linear), std::span<double>(plain));
  double largest = 0.0, sum = 0.0, size = 0.0;
  for (const double value : plain) largest = std::max(largest, std::abs(value));
  for (const double value : unresolved(linear)) EXPECT_LT(std::abs(value), 1e-9 * largest);
  for (const double value : unresolved(disordered)) {
    sum += value;
    size += std::abs(value);
  }
  EXPECT_LT(std::abs(sum), 1e-6 * size);  // weights are single precision

  const auto lattice = box<D>(0.0, 12, planes, &x);
  const PairMatrix of_lattice = fluid::laplacian<D>(lattice, {});
  ScalarArray alternating;
  for (const auto& point : x)
    alternating.push_back(std::lround((12.0 * point - Vec<D>::Constant(0.5)).sum()) % 2 == 0 ? 1.0 : -1.0);
  plain.assign(x.size(), 0.0);
  of_lattice.apply(std::span<const double>(alternating), std::span<double>(plain));
  const ScalarArray seen = UnresolvedPressure<D>(lattice, of_lattice)(alternating);
  std::size_t inside = 0;
  for (std::size_t a = 0; a < x.size(); ++a) {
    if ((x[a] - Vec<D>::Constant(0.5)).cwiseAbs().maxCoeff() > 0.1) continue;  // no gradient within reach of a wall
    EXPECT_NEAR(seen[a], plain[a], 1e-4 * std::abs(plain[a]));  // so even are weights of single precision
    EXPECT_GT(std::abs(plain[a]), 0.0);
    ++inside;
  }
  EXPECT_EQ(inside, D == 2 ? 4u : 8u);
}

TEST(Operators, PairsShowNoLinearPressureAndAllOfAnAlternatingOne) {
  expect_only_alternating_pressures_seen<2>();
  expect_only_alternating_pressures_seen<3>();
}

TEST(Operators, GradientAndDivergenceAreExactForLinearFields) {
  expect_linear_exactness<2>();
  expect_linear_exactness<3>();
}

TEST(Operators, LaplacianOfACosineBetweenWalls) {
  // cos(pi x) has zero slope at the walls: images impose the Neumann condition.
  const auto planes = walls<2>();
  double previous = 1.0;
  for (const std::size_t count : {std::size_t{16}, std::size_t{32}}) {
    VecArray<2> x;
    const auto s = box<2>(0.0, count, planes, &x);
    const auto m = laplacian<2>(s, {});
    ScalarArray p, y(x.size());
    for (const auto& point : x) p.push_back(std::cos(std::numbers::pi * point.x()));
    m.apply(std::span<const double>(p), std::span<double>(y));
    double worst = 0.0;
    for (std::size_t a = 0; a < x.size(); ++a)
      worst = std::max(worst, std::abs(y[a] / s.volume[a] / (std::numbers::pi * std::numbers::pi) - p[a]));
    EXPECT_LT(worst, 0.06);
    EXPECT_LE(worst, previous);
    previous = worst;
  }
}

TEST(Operators, ImagesFillTheKernelAtWallsAndCorners) {
  const auto planes = walls<3>();
  const auto s = box<3>(0.0, 6, planes);
  for (std::size_t a = 0; a < s.n_real; ++a) {
    EXPECT_NEAR(s.fullness[a], 1.0, 1e-12);
    EXPECT_LT(s.normal[a].norm(), 1e-10);
  }
}

TEST(Operators, LaplacianIsSymmetricWithUnequalVolumes) {
  VecArray<2> x;
  const auto lattice = box<2>(0.3, 8, {}, &x);
  ScalarArray volume(x.size());
  for (std::size_t a = 0; a < x.size(); ++a) volume[a] = lattice.volume[a] * (x[a].x() > 0.5 ? 2.0 : 1.0);
  const auto s = make_stencil<2>(x, volume, std::span<const Buffer<2>>(), {});
  const auto m = laplacian<2>(s, {});
  ScalarArray u, v, mu(x.size()), mv(x.size());
  for (const auto& point : x) {
    u.push_back(std::sin(7.0 * point.x() + point.y()));
    v.push_back(std::cos(3.0 * point.y() - point.x()));
  }
  m.apply(std::span<const double>(u), std::span<double>(mu));
  m.apply(std::span<const double>(v), std::span<double>(mv));
  EXPECT_NEAR(Domain().dot(u, mv), Domain().dot(v, mu), 1e-12 * Domain().norm(u) * Domain().norm(mv));
}

/// Disordered particles of two sizes, beside walls.
template <int D>
Stencil<D> uneven_box(std::size_t count) {
  VecArray<D> x;
  const auto planes = walls<D>();
  const auto lattice = box<D>(0.3, count, planes, &x);
  ScalarArray volume(x.size());
  for (std::size_t a = 0; a < x.size(); ++a) volume[a] = lattice.volume[a] * (x[a][0] > 0.5 ? 2.0 : 1.0);
  return make_stencil<D>(x, volume, std::span<const Buffer<D>>(), planes);
}

TEST(Operators, LaplaciansOfSeveralMobilitiesAreThoseOfEach) {
  const auto s = uneven_box<2>(9);
  ScalarArray one(s.n_real), other(s.n_real);
  for (std::size_t a = 0; a < s.n_real; ++a) {
    one[a] = 1.0 + std::sin(9.0 * s.position[a].x());
    other[a] = s.position[a].y() > 0.6 ? 0.0 : 1e-6;
  }
  const auto all = laplacians<2, 3>(s, {one, other, {}});
  const std::array<PairMatrix, 3> single = {laplacian<2>(s, one), laplacian<2>(s, other), laplacian<2>(s, {})};
  for (std::size_t m = 0; m < 3; ++m) {
    EXPECT_EQ(all[m].weight, single[m].weight);
    EXPECT_EQ(all[m].diagonal, single[m].diagonal);
  }
  // A pair's weight is that of the matrix for unit mobility, times the harmonic mean of the two mobilities.
  for (std::size_t a = 0; a < s.n_real; ++a)
    for (std::size_t k = s.offset[a]; k < s.offset[a + 1]; ++k) {
      const double mean = harmonic(one[a], one[s.parent[s.other[k]]]);
      EXPECT_NEAR(all[0].weight[k], mean * all[2].weight[k], 1e-6 * all[2].weight[k]);
    }
}

/// The results of all loops over pairs.
template <int D>
struct Loops {
  MatArray<D> gradient;
  ScalarArray divergence_of;
  VecArray<D> slope, shared;
  PairMatrix matrix, even;
  /// Computed on the stencil that is given, so that the kernels, which are stored as floats, are the same.
  explicit Loops(const Stencil<D>& on) {
    VecArray<D> v(on.n_real);
    ScalarArray p(on.n_real), mobility(on.n_real), counts(on.n_real);
    for (std::size_t a = 0; a < on.n_real; ++a) {
      for (int d = 0; d < D; ++d) v[a][d] = std::sin(7.0 * on.position[a][d] + on.position[a][(d + 1) % D]);
      p[a] = std::cos(5.0 * on.position[a].x());
      mobility[a] = 1.0 + on.position[a].y();
      counts[a] = on.position[a].x() > 0.5 ? on.volume[a] : 0.0;
    }
    const auto zero = [](std::size_t) { return 0.0; };
    gradient = velocity_gradient<D>(on, v);
    divergence_of = divergence<D>(on, v);
    slope = pressure_gradient<D>(on, p, zero, mobility, Vec<D>::Zero(), zero);
    shared = v;
    share_out<D>(on, counts, shared);
    matrix = laplacian<D>(on, mobility);
    Stencil<D> same = on;
    std::fill(same.volume.begin(), same.volume.end(), on.volume[0]);
    even = laplacian<D>(same, {});
  }
};

template <int D>
void expect_the_same_by_single_pairs() {
  const Stencil<D> stencil = uneven_box<D>(D == 2 ? 12 : 7);
  const Loops<D> fours(stencil);
  const Instructions best = instructions();
  instructions() = Instructions::scalar;
  const Stencil<D> again = uneven_box<D>(D == 2 ? 12 : 7);
  const Loops<D> ones(stencil);
  instructions() = best;
  const double rounding = 1e-12, of_floats = 1e-6;
  for (std::size_t a = 0; a < stencil.n_real; ++a) {
    EXPECT_NEAR(again.fullness[a], stencil.fullness[a], rounding);
    EXPECT_NEAR(again.closest[a], stencil.closest[a], rounding);
    EXPECT_LT((again.correction[a] - stencil.correction[a]).norm(), of_floats);
    EXPECT_LT((ones.gradient[a] - fours.gradient[a]).norm(), rounding * 10.0);
    EXPECT_NEAR(ones.divergence_of[a], fours.divergence_of[a], rounding * 10.0);
    EXPECT_LT((ones.slope[a] - fours.slope[a]).norm(), rounding * 10.0);
    EXPECT_LT((ones.shared[a] - fours.shared[a]).norm(), of_floats);
    EXPECT_NEAR(ones.matrix.diagonal[a], fours.matrix.diagonal[a], of_floats * fours.matrix.diagonal[a]);
    EXPECT_NEAR(ones.even.diagonal[a], fours.even.diagonal[a], of_floats * fours.even.diagonal[a]);
  }
}

TEST(Operators, OnePairAtATimeGivesTheSameAsFour) {
  expect_the_same_by_single_pairs<2>();
  expect_the_same_by_single_pairs<3>();
}

/// Computed pair by pair, from the kernel itself.
template <int D>
void expect_shares(std::size_t count) {
  const auto s = uneven_box<D>(count);
  ScalarArray counts(s.n_real);
  VecArray<D> amounts(s.n_real);
  Vec<D> given = Vec<D>::Zero(), kept = Vec<D>::Zero();
  for (std::size_t a = 0; a < s.n_real; ++a) {
    // The upper half has no weight: particles there neither give nor receive.
    counts[a] = s.position[a][D - 1] > 0.5 ? 0.0 : s.volume[a];
    for (int d = 0; d < D; ++d) amounts[a][d] = std::sin(5.0 * static_cast<double>(a) + d);
    given += amounts[a];
  }
  VecArray<D> plain(s.n_real, Vec<D>::Zero());
  std::size_t stayed = 0;
  for (std::size_t a = 0; a < s.n_real; ++a) {
    const auto part = [&](std::size_t b) {
      const double h = 0.5 * (s.length(a) + s.length(b));
      return counts[b] * Kernel<D>::value((s.position[a] - s.position[b]).norm(), h);
    };
    double sum = 0.0;
    for (std::size_t b = 0; b < s.n_real; ++b) sum += part(b);
    if (sum == 0.0) plain[a] += amounts[a];
    stayed += sum == 0.0 ? 1 : 0;
    for (std::size_t b = 0; b < s.n_real && sum > 0.0; ++b) plain[b] += part(b) / sum * amounts[a];
  }
  EXPECT_GT(stayed, 0u);
  share_out<D>(s, counts, amounts);
  for (std::size_t a = 0; a < s.n_real; ++a) {
    EXPECT_LT((amounts[a] - plain[a]).norm(), 1e-6) << a;  // kernel values are stored as floats
    kept += amounts[a];
  }
  EXPECT_LT((kept - given).norm(), 1e-12 * static_cast<double>(s.n_real));
}

TEST(Operators, WhatIsSharedOutIsKept) {
  expect_shares<2>(16);
  expect_shares<3>(9);
}

template <int D>
void check_bounded_inverse() {
  std::mt19937_64 generator(11);
  std::uniform_real_distribution<double> value(0.0, 1.2), entry(-1.0, 1.0);
  constexpr double least = 0.3;
  for (int i = 0; i < 300; ++i) {
    Mat<D> any;
    for (int d = 0; d < D; ++d)
      for (int e = 0; e < D; ++e) any(d, e) = entry(generator);
    const Mat<D> turn = any.colPivHouseholderQr().householderQ();
    Vec<D> eigen = Vec<D>::Constant(1.0 + 0.05 * entry(generator));
    if (i % 3 != 0)  // every third nearly isotropic, as inside
      for (int d = 0; d < D; ++d) eigen[d] = value(generator);
    const Mat<D> moment = turn * eigen.asDiagonal() * turn.transpose();
    Mat<D> unresolved;
    double smallest = 0.0;
    const Mat<D> inverse = bounded_inverse<D>(moment, least, &unresolved, &smallest);
    const Vec<D> held = eigen.cwiseMax(least);
    EXPECT_LT((inverse - turn * held.cwiseInverse().asDiagonal() * turn.transpose()).norm(), 1e-6);
    EXPECT_LT((unresolved - (Mat<D>::Identity() - inverse * moment)).norm(), 1e-6);
    EXPECT_LE(smallest, eigen.minCoeff() + 1e-7);
    if (smallest < points::inside_moment || D == 2) {
      EXPECT_NEAR(smallest, eigen.minCoeff(), 1e-7);
    }
    EXPECT_NEAR(bounded_inverse<D>(moment, least, nullptr).trace(), inverse.trace(), 1e-9);
  }
}
TEST(Operators, MomentsAreInvertedWhereNeighboursAreEnough) {
  check_bounded_inverse<2>();
  check_bounded_inverse<3>();
}

TEST(Operators, DirectionsWithoutNeighboursAreBlind) {
  // A single row of particles: the direction across it is unresolved.
  VecArray<2> x;
  for (int i = 0; i < 10; ++i) x.emplace_back(0.1 * i, 0.0);
  const ScalarArray volume(x.size(), 0.01);
  const auto s = make_stencil<2>(x, volume, std::span<const Buffer<2>>(), {});
  const Vec<2> fallback(5.0, 7.0);
  ScalarArray p;
  for (const auto& point : x) p.push_back(2.0 * point.x());
  const auto g = pressure_gradient<2>(
      s, p, [](Index) { return 0.0; }, {}, fallback, [](std::size_t) { return 0.0; });
  EXPECT_NEAR(g[5].x(), 2.0, 1e-10);
  EXPECT_NEAR(g[5].y(), 7.0, 1e-10);
}

// Columns of water below a loaded face, closed at the sides and the base; the first row is `offset` spacings below the
// face.
Stencil<2> below_a_face(double offset, VecArray<2>& x) {
  constexpr int count = 8;
  const double dx = 0.1, width = count * dx;
  std::vector<FaceColumn<2>> columns;
  for (int i = 0; i < count; ++i) {
    FaceColumn<2> c;
    c.foot = Vec<2>((i + 0.5) * dx, 0.0);
    c.normal = Vec<2>(0.0, -1.0);
    c.spacing = dx;
    c.width = 0.5 * dx;
    c.volume = dx * dx;
    c.offset = offset * dx;
    c.wet = c.loaded = true;
    columns.push_back(c);
    for (int j = 0; j < count; ++j) x.emplace_back(c.foot.x(), -(offset + j) * dx);
  }
  auto planes = walls<2>();  // left, right, base
  planes.resize(3);
  planes[1].point = Vec<2>(width, 0.0);
  planes[2].point = Vec<2>(0.0, -(offset + count - 0.5) * dx);
  const ScalarArray volume(x.size(), dx * dx);
  const auto buffers = make_buffers(columns);
  auto s = make_stencil<2>(x, volume, std::span<const Buffer<2>>(buffers), planes);
  fit_columns<2>(columns, std::vector<char>(x.size(), 0), s);
  return s;
}

VecArray<2> gradient_below_a_face(const Stencil<2>& s, const ScalarArray& p) {
  return pressure_gradient<2>(
      s, p, [](Index) { return 0.0; }, {}, Vec<2>::Zero(), [](std::size_t) { return 0.0; });
}

TEST(Faces, AWaveIsAddedToThePressure) {
  Case scene;
  WaterFace face;
  face.pressure = Series{{{0.0, 1000.0}}};
  face.wave_amplitude = Series{{{0.0, 200.0}}};
  face.wave_length = 3.0;
  face.wave_period = 2.0;
  scene.water_faces = {face};
  std::vector<FaceColumn<2>> columns(2);
  columns[1].foot = Vec<2>(0.5, 0.0);
  const std::vector<FaceState> states(1);
  const auto at = [&](double t) {
    update_columns<2>(make_water_boundaries(scene), states, t, Vec<2>::Zero(), Vec<2>::Zero(), columns);
    return Vec<2>(columns[0].pressure, columns[1].pressure);
  };
  EXPECT_LT((at(0.0) - Vec<2>(1200.0, 1100.0)).norm(), 1e-9);
  EXPECT_LT((at(1.0) - Vec<2>(800.0, 900.0)).norm(), 1e-9);
  scene.water_faces[0].pressure = Series{{{0.0, 0.0}}};
  at(1.0);
  EXPECT_FALSE(columns[0].wet) << "no water stands behind the face where the pressure is below zero";
}

// At a drained face under an undrained load: the pressure gradients of the first rows carry the whole load.
TEST(Faces, AnEvenPressuresGradientSumsToItsFall) {
  for (const double offset : {0.2, 0.35, 0.5}) {
    VecArray<2> x;
    const auto s = below_a_face(offset, x);
    double sum = 0.0;
    for (const auto& g : gradient_below_a_face(s, ScalarArray(x.size(), 1.0))) sum += g.y() * s.volume[0];
    EXPECT_NEAR(sum, -0.8, 1e-6) << offset;  // 1 Pa over 0.8 m
  }
}

TEST(Faces, SlopesAreExactForLinearPressures) {
  for (const double offset : {0.01, 0.2, 0.5, 0.8, 0.99}) {
    VecArray<2> x;
    const auto s = below_a_face(offset, x);
    ScalarArray p;
    for (const auto& point : x) p.push_back(-3.0 * point.y());
    const auto gradient = gradient_below_a_face(s, p);
    for (std::size_t a = 0; a < x.size(); ++a) {
      if (x[a].y() < -0.3) continue;  // the base changes the slope
      EXPECT_NEAR(gradient[a].y(), -3.0, 1e-5) << offset;
    }
  }
}

// With equal numbers of points in a box, the measured density must not depend on their order.
TEST(Operators, DensityOfOpenWaterHardlyKnowsThePackingsOrder) {
  const auto planes = walls<2>();
  const auto mean = [&](double jitter, bool by_density) {
    const auto s = box<2>(jitter, 20, planes, nullptr, by_density);
    double sum = 0.0;
    for (const double fullness : s.fullness) sum += fullness;
    return sum / static_cast<double>(s.n_real);
  };
  EXPECT_NEAR(mean(0.0, true), 1.0, 1e-12);
  EXPECT_NEAR(mean(0.2, true), 1.0, 0.005);
  EXPECT_GT(mean(0.2, false), 1.01);
}

// A surface row with 23 particles in place of a lattice's 20 is 1.15 spacings thick.
TEST(Operators, TheSurfaceLiesHalfARowsThicknessAboveIt) {
  for (const double more : {1.0, 1.15}) {
    VecArray<2> x;
    for (int i = -30; i <= 30; ++i) x.emplace_back(i / more, 0.0);
    for (int j = 0; j < 6; ++j)
      for (int i = -30; i <= 30; ++i) x.emplace_back(i, -0.5 * more - 0.5 - j);
    const ScalarArray volume(x.size(), 1.0);
    auto s = make_stencil<2>(x, volume, {}, {});
    ScalarArray rows(x.size(), 1.0);
    const auto flags = find_surface<2>(s, std::vector<char>(x.size(), 0), rows, 1.0);
    ASSERT_EQ(flags[30], Surface::surface);
    EXPECT_NEAR(s.surface_distance(30), 0.5 * more, 0.01);
    EXPECT_EQ(s.ghost_distance[30], s.surface_distance(30));
  }
}

// In a splash, a particle above few neighbours, some of them beside it, lies at the surface. Treated as an inner
// particle, it was driven onto them by its own pressure: to 4.8 m/s in twenty windows (dam_break_on_soil).
TEST(Operators, AParticleWithFewNeighboursOnOneSideLiesAtAHole) {
  const VecArray<2> x = {{0.0, 0.0},       {0.963, -0.924},  {1.53, 0.228},   {-1.071, -1.251}, {-1.711, 0.302},
                         {-0.604, -1.759}, {0.158, -1.907},  {1.569, -1.308}, {2.089, 0.366},   {-2.248, -0.551},
                         {0.924, -2.217},  {-1.508, -1.999}, {-2.427, 0.083}};
  auto s = make_stencil<2>(x, ScalarArray(x.size(), 1.0), {}, {});
  s.open_water.assign(x.size(), 0);  // beside soil
  EXPECT_EQ(find_surface<2>(s, std::vector<char>(x.size(), 0))[0], Surface::surface);
}

}  // namespace
}  // namespace poretwin::fluid
