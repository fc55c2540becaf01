// The operators are exact for linear fields, also near walls and free surfaces, and forces do the work that is stored
// in strains.
#include "solid_solver/discretisation/operators.hpp"

#include "common/core/lanes.hpp"
#include "solid_solver/dynamics/step.hpp"
#include "solid_solver/dynamics/straining.hpp"
#include "tests/solid/plain_twin.hpp"
#include "tests/solid/scenes.hpp"

#include <gtest/gtest.h>

#include <numeric>
#include <random>

namespace poretwin::solid {
namespace {

using test::column;
using test::ColumnSpec;

/// Soil at time zero, with current lists and kernels.
template <int D>
std::pair<Setup<D>, State<D>> laid(const Case& scene) {
  auto [setup, particles] = set_up<D>(scene);
  State<D> state;
  state.particles = std::move(particles);
  const std::size_t n = state.particles.size();
  state.body.assign(n, Vec<D>::Zero());
  state.force.resize(n);
  state.yielded.assign(n, 0);
  rebuild(setup, state);
  return {std::move(setup), std::move(state)};
}

/// A column with randomly displaced particles.
template <int D>
std::pair<Setup<D>, State<D>> jittered(ColumnSpec spec, double jitter) {
  spec.dimension = D;
  Case scene = column(spec);
  scene.solid.jitter = jitter;
  return laid<D>(scene);
}

template <int D>
void set_velocity(const Setup<D>& setup, State<D>& state, const std::function<Vec<D>(const Vec<D>&)>& v) {
  for (std::size_t i = 0; i < state.particles.size(); ++i) state.particles.velocity[i] = v(state.particles.position[i]);
  fill_nodes(setup, state);
  velocity_gradient<D>(state.near.pairs, state.kernel, state.nodes);
}

template <int D>
void expect_gradient(const State<D>& state, const Mat<D>& exact) {
  for (std::size_t i = 0; i < state.particles.size(); ++i)
    EXPECT_LT((state.nodes[i].gradient - exact).cwiseAbs().maxCoeff(), 1e-11);
}

TEST(VelocityGradient, IsExactForLinearFieldsAtFreeSurfaces) {
  ColumnSpec spec;
  spec.base = Wall::ForSoil::none;
  spec.sides = false;
  auto [setup, state] = jittered<2>(spec, 0.1);
  const Mat<2> exact{{0.3, -0.7}, {0.2, 0.5}};
  set_velocity<2>(setup, state, [&](const Vec<2>& x) { return Vec<2>(exact * x + Vec<2>(1.0, 2.0)); });
  expect_gradient<2>(state, exact);
}

TEST(VelocityGradient, IsExactNearFixedAndRollerWalls) {
  // Fixed base: linear fields that vanish on it. Roller base: no normal velocity, free slip.
  for (const auto base : {Wall::ForSoil::fixed, Wall::ForSoil::roller}) {
    ColumnSpec spec;
    spec.base = base;
    spec.sides = false;
    auto [setup, state] = jittered<2>(spec, 0.1);
    Mat<2> exact{{0.0, 0.4}, {0.0, -0.9}};
    if (base == Wall::ForSoil::roller) exact << 0.4, 0.0, 0.0, -0.9;
    set_velocity<2>(setup, state, [&](const Vec<2>& x) { return Vec<2>(exact * x); });
    expect_gradient<2>(state, exact);
  }
}

TEST(VelocityGradient, IsExactInThreeDimensions) {
  ColumnSpec spec;
  spec.width = spec.height = 0.3;
  spec.sides = false;
  auto [setup, state] = jittered<3>(spec, 0.05);
  const Mat<3> exact{{0.0, 0.0, 0.3}, {0.0, 0.0, -0.2}, {0.0, 0.0, 0.8}};
  set_velocity<3>(setup, state, [&](const Vec<3>& x) { return Vec<3>(exact * x); });
  expect_gradient<3>(state, exact);
}

template <int D>
void expect_adjoint(const ColumnSpec& spec, double jitter) {
  auto [setup, state] = jittered<D>(spec, jitter);
  std::mt19937_64 generator(7);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  auto& p = state.particles;
  for (std::size_t i = 0; i < p.size(); ++i) {
    for (int k = 0; k < 6; ++k) p.stress[i][k] = 1e3 * any(generator);
    for (int d = 0; d < D; ++d) p.velocity[i][d] = any(generator);
  }
  evaluate_forces(setup, state);
  velocity_gradient<D>(state.near.pairs, state.kernel, state.nodes);
  double external = 0.0, stored = 0.0, scale = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    external += p.volume[i] * state.force[i].internal().dot(p.velocity[i]);
    const double power = p.volume[i] * matrix_of<D>(p.stress[i]).cwiseProduct(state.nodes[i].gradient).sum();
    stored -= power;
    scale += std::abs(power);
  }
  EXPECT_NEAR(external, stored, 1e-12 * scale);
}

TEST(ArtificialStress, PartsTheCloseOnesInTensionAndKeepsMomentum) {
  ColumnSpec spec;
  spec.base = Wall::ForSoil::none;
  spec.sides = false;
  Case scene = column(spec);
  auto [setup, particles] = set_up<2>(scene);
  State<2> state;
  state.particles = std::move(particles);
  const std::size_t n = state.particles.size(), moved = n / 2 + 4;  // inside the column
  state.body.assign(n, Vec<2>::Zero());
  const Vec<2> shift(0.0, 0.3 * spec.spacing);  // towards the particle above
  state.particles.position[moved] += shift;
  rebuild(setup, state);
  const auto force = [&](double stress) {
    for (auto& s : state.particles.stress) s << stress, stress, stress, 0.0, 0.0, 0.0;
    VecArray<2> f(n, Vec<2>::Zero());
    add_artificial_stress<2>(state, 0.5, spec.spacing, setup.smoothing_length, f);
    return f;
  };
  for (const auto& f : force(-1000.0)) EXPECT_EQ(f.norm(), 0.0);
  const VecArray<2> pulled = force(1000.0);
  EXPECT_LT(pulled[moved].dot(shift), 0.0);
  Vec<2> sum = Vec<2>::Zero();
  for (std::size_t i = 0; i < n; ++i) sum += state.particles.volume[i] * pulled[i];
  EXPECT_LT(sum.norm(), 1e-10 * state.particles.volume[moved] * pulled[moved].norm());
}

TEST(InternalForce, DoesTheWorkThatStrainsStore) {
  for (const auto base : {Wall::ForSoil::none, Wall::ForSoil::roller, Wall::ForSoil::fixed})
    for (const bool sides : {false, true}) {
      ColumnSpec spec;
      spec.base = base;
      spec.sides = sides;
      spec.height = 0.5;
      expect_adjoint<2>(spec, 0.1);
    }
}

TEST(InternalForce, DoesTheWorkThatStrainsStoreInThreeDimensions) {
  ColumnSpec spec;
  spec.width = spec.height = 0.3;
  expect_adjoint<3>(spec, 0.05);
}

/// Compared with the plain version of the loops: all values random, some soil elastic, some flowing, images on three
/// sides.
template <int D>
void expect_twin(ColumnSpec spec, std::size_t parts = 1) {
  auto [setup, state] = jittered<D>(spec, 0.1);
  setup.parts = parts;
  setup.stabilisers.quadratic = 1.0;
  setup.stabilisers.held = 4.0;  // some pairs beyond it, some not
  rebuild(setup, state);
  std::mt19937_64 generator(11);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  auto& p = state.particles;
  for (std::size_t i = 0; i < p.size(); ++i) {
    for (int k = 0; k < 6; ++k) p.stress[i][k] = 1e3 * any(generator);
    for (int d = 0; d < D; ++d) p.velocity[i][d] = any(generator);
    for (int d = 0; d < D; ++d) p.displacement[i][d] = 1e-3 * any(generator);
    state.nodes[i].deformation = 1e-3 * Mat<D>::NullaryExpr([&](auto, auto) { return any(generator); });
    p.rubbing[i] = i % 5 == 0 ? 0.6F : 0.0F;
    p.plastic_strain[i] = i % 3 == 0 ? 0.0 : i % 3 == 1 ? 0.005 : 0.1;
  }
  ScalarArray pressure(p.size());
  for (double& value : pressure) value = 1e3 * any(generator);
  evaluate_forces(setup, state);
  const auto twin = plain_twin<D>(setup, state);  // with the gradient that the forces used
  velocity_gradient<D>(state.near.pairs, state.kernel, state.nodes);
  const auto push = pressure_gradient_difference<D>(state, pressure),
             pushed = plain_pressure_gradient<D>(setup, state, pressure);
  double force = 0.0, drag = 0.0, gradient = 0.0, steepest = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    force = std::max(force, twin.internal[i].norm());
    drag = std::max(drag, twin.stabilising[i].norm());
    gradient = std::max(gradient, twin.gradient[i].norm());
    steepest = std::max(steepest, pushed[i].norm());
  }
  EXPECT_GT(std::min({force, drag, gradient, steepest}), 0.0);
  for (std::size_t i = 0; i < p.size(); ++i) {
    EXPECT_LT((state.force[i].internal() - twin.internal[i]).norm(), 1e-12 * force);
    EXPECT_LT((state.force[i].stabilising() - twin.stabilising[i]).norm(), 1e-12 * drag);
    EXPECT_LT((state.nodes[i].gradient - twin.gradient[i]).norm(), 1e-12 * gradient);
    EXPECT_LT((push[i] - pushed[i]).norm(), 1e-12 * steepest);
  }
}

TEST(PairLoops, AreThoseOfThePlainTwin) {
  for (const auto base : {Wall::ForSoil::none, Wall::ForSoil::roller, Wall::ForSoil::fixed}) {
    ColumnSpec spec;
    spec.base = base;
    expect_twin<2>(spec);
    spec.width = spec.height = 0.3;
    expect_twin<3>(spec);
  }
}

TEST(PairLoops, AreThoseOfThePlainTwinOnThreeThreads) {
  ColumnSpec spec;
  expect_twin<2>(spec, 3);
  spec.width = spec.height = 0.3;
  expect_twin<3>(spec, 3);
}

TEST(PairLoops, AreThoseOfThePlainTwinOnEveryProcessor) {
  const Instructions best = instructions();
  for (const auto lower : {Instructions::scalar, Instructions::plain, Instructions::avx2}) {
    if (lower > best) continue;
    instructions() = lower;
    expect_twin<2>({});
  }
  instructions() = best;
}

TEST(InternalForce, KeepsMomentumWithoutWalls) {
  ColumnSpec spec;
  spec.base = Wall::ForSoil::none;
  spec.sides = false;
  auto [setup, state] = jittered<2>(spec, 0.1);
  std::mt19937_64 generator(3);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  auto& p = state.particles;
  for (std::size_t i = 0; i < p.size(); ++i) {
    for (int k = 0; k < 6; ++k) p.stress[i][k] = 1e3 * any(generator);
    p.velocity[i] = Vec<2>(any(generator), any(generator));
  }
  velocity_gradient<2>(state.near.pairs, state.kernel, state.nodes);
  evaluate_forces(setup, state);
  Vec<2> sum = Vec<2>::Zero();
  double scale = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const Vec<2> f = p.volume[i] * (state.force[i].internal() + state.force[i].stabilising());
    sum += f;
    scale += f.norm();
  }
  EXPECT_LT(sum.norm(), 1e-12 * scale);
}

/// Soil with a shear stress of 1 kPa whose upper half is displaced along the lower half by 0.2 spacings: the part of
/// the shear stress that the hourglass stiffness transmits across the slip surface.
double borne_by_control(double plastic_strain) {
  constexpr double tau = 1e3, slip = 0.01;
  ColumnSpec spec;
  spec.width = 2.0;
  spec.base = Wall::ForSoil::none;
  spec.sides = false;
  auto [setup, state] = laid<2>(column(spec));
  auto& p = state.particles;
  const auto above = [&](std::size_t i) { return p.position[i].y() > 0.5 * spec.height; };
  set_velocity<2>(setup, state, [&](const Vec<2>& x) { return Vec<2>(x.y() > 0.5 * spec.height ? slip : 0.0, 0.0); });
  for (std::size_t i = 0; i < p.size(); ++i) {
    p.stress[i] << 0.0, 0.0, 0.0, tau, 0.0, 0.0;
    p.plastic_strain[i] = plastic_strain;
    p.displacement[i] = p.velocity[i];
    state.nodes[i].deformation = state.nodes[i].gradient;
    p.velocity[i].setZero();
  }
  const auto force = [&](double stiffness) {
    setup.stabilisers.hourglass_stiffness = stiffness;
    evaluate_forces(setup, state);
    double sum = 0.0;
    for (std::size_t i = 0; i < p.size(); ++i)
      if (above(i) && std::abs(p.position[i].x() - 0.5 * spec.width) < 0.25 * spec.width)
        sum += p.volume[i] * state.force[i].internal().x();
    return sum;
  };
  const double with = force(setup.stabilisers.hourglass_stiffness), without = force(0.0);
  return (without - with) / (0.5 * spec.width * tau);
}

// If every pair across it were restrained by the whole bound, the surface would carry (2 / pi) 0.3 % of the shear
// stress: half of int |r_y| W' dV over int r W' dV / 2 = 1.
TEST(Stabilisers, HoldASlipSurfaceOfSoilThatYieldedByAThousandthOfItsStress) {
  EXPECT_GT(borne_by_control(0.0), 0.1);  // without the bound: additional strength
  EXPECT_GT(borne_by_control(0.005), 0.0012);
  EXPECT_LT(borne_by_control(0.005), 0.0024);
  EXPECT_EQ(borne_by_control(0.02), 0.0);
}

TEST(Stabilisers, LeaveUniformStrainRatesAlone) {
  ColumnSpec spec;
  spec.base = Wall::ForSoil::none;
  spec.sides = false;
  auto [setup, state] = jittered<2>(spec, 0.1);
  setup.stabilisers.artificial = 0.0;
  const Mat<2> exact{{0.3, -0.7}, {0.2, 0.5}};
  set_velocity<2>(setup, state, [&](const Vec<2>& x) { return Vec<2>(exact * x); });
  evaluate_forces(setup, state);
  for (const auto& f : state.force)
    EXPECT_LT(f.stabilising().norm(), 1e-6);  // relative to 1e3 kg/m3 x 60 m/s x 1/s / 0.05 m = 1e6
}

/// A block without walls that deforms with the same gradient everywhere, its stresses zero.
template <int D>
std::pair<Setup<D>, State<D>> deforming_block(const Mat<D>& gradient, SolidCase::Model model) {
  ColumnSpec spec;
  spec.dimension = D;
  spec.width = spec.height = 0.5;
  spec.base = Wall::ForSoil::none;
  spec.sides = false;
  Case scene = column(spec);
  scene.solid.model = model;
  scene.soils[0].friction_angle = 30.0;
  auto block = laid<D>(scene);
  set_velocity<D>(block.first, block.second, [&](const Vec<D>& x) { return Vec<D>(gradient * x); });
  return block;
}

template <int D>
double share_at_edge(const State<D>& state, std::size_t i) {
  return std::min(1.0, 1.2 * D / state.nodes[i].correction().squaredNorm());
}

template <int D>
void expect_lower_moduli_at_edges() {
  Mat<D> gradient = Mat<D>::Zero();
  gradient.row(0).setConstant(0.2);
  gradient(1, 1) = -0.5;
  auto [setup, state] = deforming_block<D>(gradient, SolidCase::Model::elastic);
  State<D> stiff = state;
  strain<D>(setup, 1e-3, 1e-3, stiff);
  setup.soft_edges = true;
  strain<D>(setup, 1e-3, 1e-3, state);
  double least = 1.0;
  for (std::size_t i = 0; i < state.particles.size(); ++i) {
    const double share = share_at_edge(state, i);
    const Vec<D> from_middle = state.particles.position[i] - Vec<D>::Constant(0.25);
    if (from_middle.cwiseAbs().maxCoeff() < 0.15) {
      EXPECT_EQ(share, 1.0) << "two rows and more inside";
    }
    least = std::min(least, share);
    const Tensor expected = share * stiff.particles.stress[i];
    EXPECT_LT((state.particles.stress[i] - expected).norm(), 1e-12 * expected.norm());
    EXPECT_EQ(state.particles.volume[i], stiff.particles.volume[i]);
  }
  EXPECT_LT(least, 0.2) << "in the corners";
}

TEST(SoftEdges, HaveTheStressOfLowerModuli) {
  expect_lower_moduli_at_edges<2>();
  expect_lower_moduli_at_edges<3>();
}

TEST(SoftEdges, CountAllOfThePlasticStrain) {
  // Cohesionless soil that is pulled apart has no stress: all its strain is plastic, for any moduli.
  auto [setup, state] = deforming_block<2>(Mat<2>{{0.4, 0.0}, {0.0, 0.1}}, SolidCase::Model::drucker_prager);
  State<2> stiff = state;
  strain<2>(setup, 1e-3, 1e-3, stiff);
  setup.soft_edges = true;
  strain<2>(setup, 1e-3, 1e-3, state);
  for (std::size_t i = 0; i < state.particles.size(); ++i) {
    EXPECT_GT(stiff.particles.plastic_strain[i], 1e-4);
    EXPECT_NEAR(state.particles.plastic_strain[i], stiff.particles.plastic_strain[i], 1e-15);
  }
}

TEST(Suspension, HasTheStressOfItsStrainFromTheContactOn) {
  // Porosity 0.4 at first, contact at 0.376: at 0.6 / 0.624 of the initial volume.
  auto [setup, state] = deforming_block<2>(Mat<2>{{0.0, 0.3}, {0.0, -1.0}}, SolidCase::Model::elastic);
  const double contact = 0.6 / 0.624, dt = 1e-3, modulus = setup.models[0]->initial_moduli().constrained();
  setup.contact_volume[0] = contact;
  auto& p = state.particles;
  const std::size_t middle = p.size() / 2;
  const double initial = p.volume[middle];
  for (int step = 0; step < 60; ++step) {
    const double before = p.volume[middle] / initial, stress = p.stress[middle][1], shear = p.stress[middle][3];
    strain<2>(setup, dt, dt, state);
    const double now = p.volume[middle] / initial;
    ASSERT_NEAR(now, std::pow(1.0 - dt, step + 1), 1e-12);
    EXPECT_EQ(in_suspension(setup, p, middle), now > contact);
    if (now > contact) {
      EXPECT_EQ(p.stress[middle].norm(), 0.0);
    } else if (before > contact) {
      EXPECT_NEAR(p.stress[middle][1], -modulus * dt * (contact - now) / (before - now), 1e-9 * modulus * dt);
    } else {
      EXPECT_NEAR(p.stress[middle][1] - stress, -modulus * dt, 1e-2 * modulus * dt) << "the stress turns a little";
      EXPECT_GT(p.stress[middle][3], shear);
    }
  }
  EXPECT_LT(p.volume[middle], contact * initial);
  // Grains that come apart again lose their stress.
  set_velocity<2>(setup, state, [](const Vec<2>& x) { return Vec<2>(0.0, 1.0 * x[1]); });
  for (int step = 0; step < 60; ++step) strain<2>(setup, dt, dt, state);
  EXPECT_TRUE(in_suspension(setup, p, middle));
  EXPECT_EQ(p.stress[middle].norm(), 0.0);
}

TEST(BulkViscosity, ResistsChangesOfVolumeAlone) {
  const Mat<2> shear{{0.3, -0.7}, {0.2, -0.3}}, swelling{{0.3, -0.7}, {0.2, 0.5}};
  for (const Mat<2>& gradient : {shear, swelling}) {
    auto [setup, state] = deforming_block<2>(gradient, SolidCase::Model::elastic);
    setup.stabilisers.bulk = 0.5;  // m2/s
    state.particles.stress[7] << -100.0, -200.0, -50.0, 30.0, 0.0, 0.0;
    state.particles.rubbing[8] = 0.5F;  // moving apart: it only collides
    evaluate_forces(setup, state);
    for (std::size_t i = 0; i < state.particles.size(); ++i) {
      const Mat<2> B = state.nodes[i].correction();
      const double density = state.particles.mass[i] / state.particles.volume[i], share = share_at_edge(state, i);
      const double pressure = i == 8 ? 0.0 : share * share * 0.5 * density * gradient.trace();
      const Mat<2> expected = (matrix_of<2>(state.particles.stress[i]) + pressure * Mat<2>::Identity()) * B;
      EXPECT_LT((state.nodes[i].flux - expected).norm(), 1e-9 * (1.0 + expected.norm()));
    }
  }
}

TEST(PressureGradient, DifferenceFormIsExactForLinearPressureEverywhere) {
  ColumnSpec spec;
  auto [setup, state] = jittered<2>(spec, 0.1);
  ScalarArray p;
  for (const auto& x : state.particles.position) p.push_back(5e3 - 300.0 * x.x() - 9810.0 * x.y());
  for (const auto& g : pressure_gradient_difference<2>(state, p)) EXPECT_LT((g - Vec<2>(-300.0, -9810.0)).norm(), 1e-7);
}

/// Without walls, or with rollers on all sides but the top.
std::vector<ColumnSpec> free_or_on_rollers() {
  ColumnSpec free;
  free.height = 0.5;
  free.base = Wall::ForSoil::none;
  free.sides = false;
  ColumnSpec held = free;
  held.base = Wall::ForSoil::roller;
  held.sides = true;
  return {free, held};
}

template <int D>
std::vector<Index> all_of(const State<D>& state) {
  std::vector<Index> all(state.particles.size());
  std::iota(all.begin(), all.end(), Index{0});
  return all;
}

// sum V v . grad p = - sum V p div v for any p and v and any disorder of the points.
TEST(PressureGradient, AdjointFormDoesTheWorkOfTheStrains) {
  for (const ColumnSpec& spec : free_or_on_rollers()) {
    auto [setup, state] = jittered<2>(spec, 0.2);
    std::mt19937_64 generator(7);
    std::uniform_real_distribution<double> any(-1.0, 1.0);
    const std::size_t n = state.particles.size();
    ScalarArray pressure(n);
    for (double& p : pressure) p = 1e3 * any(generator);
    set_velocity<2>(setup, state, [&](const Vec<2>&) { return Vec<2>(any(generator), any(generator)); });
    VecArray<2> gradient(n, Vec<2>::Constant(1e30));  // overwritten
    pressure_gradient_adjoint<2>(state, pressure, all_of(state), gradient);
    double done = 0.0, stored = 0.0, scale = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      done += state.particles.volume[i] * state.particles.velocity[i].dot(gradient[i]);
      stored -= state.particles.volume[i] * pressure[i] * state.nodes[i].gradient.trace();
      scale += std::abs(state.particles.volume[i] * pressure[i] * state.nodes[i].gradient.trace());
    }
    EXPECT_NEAR(done, stored, 1e-12 * scale);
    EXPECT_GT(std::abs(stored), 1e-3 * scale);
  }
}

// Inside a lattice, away from its surfaces; particles that are not selected keep their values.
TEST(PressureGradient, AdjointFormIsExactForLinearPressureInside) {
  ColumnSpec spec;
  auto [setup, state] = jittered<2>(spec, 0.0);
  std::vector<Index> inside;
  ScalarArray pressure;
  for (std::size_t i = 0; i < state.particles.size(); ++i) {
    const auto& x = state.particles.position[i];
    pressure.push_back(5e3 - 300.0 * x.x() - 9810.0 * x.y());
    if (std::abs(x.y() - 0.5) < 0.2 && std::abs(x.x() - 0.2) < 0.03) inside.push_back(static_cast<Index>(i));
  }
  VecArray<2> gradient(state.particles.size(), Vec<2>(1.0, 2.0));
  pressure_gradient_adjoint<2>(state, pressure, inside, gradient);
  ASSERT_GT(inside.size(), 6u);
  for (const Index i : inside) EXPECT_LT((gradient[i] - Vec<2>(-300.0, -9810.0)).norm(), 1e-7);
  EXPECT_EQ(gradient[0], Vec<2>(1.0, 2.0));
}

// A load on undrained water: load and pressure balance on every particle, whatever the arrangement.
TEST(PressureGradient, AdjointFormCarriesALoadRowByRow) {
  ColumnSpec spec;
  Case scene = column(spec);
  scene.loads = {test::top_load(spec, 1e3)};
  scene.solid.jitter = 0.2;
  auto [setup, particles] = set_up<2>(scene);
  State<2> state;
  state.particles = std::move(particles);
  state.body.assign(state.particles.size(), Vec<2>::Zero());
  rebuild(setup, state);
  const auto load = load_forces<2>(setup, state, 0.0);
  VecArray<2> gradient(state.particles.size(), Vec<2>::Zero());
  const auto& loaded = setup.loads.front().particles;
  pressure_gradient_adjoint<2>(state, ScalarArray(state.particles.size(), 1e3), loaded, gradient);
  double sum = 0.0;
  for (const Index i : loaded) {
    sum += load[i].y();
    EXPECT_NEAR(load[i].y(), state.particles.volume[i] * gradient[i].y(), 1e-10 * 1e3 * spec.width);
  }
  EXPECT_LT(sum, -0.8e3 * spec.width);  // most of the load, on points so uneven
}

TEST(PressureGradient, SumFormPushesSurfaceParticlesOut) {
  ColumnSpec spec;
  auto [setup, state] = jittered<2>(spec, 0.0);
  const ScalarArray p(state.particles.size(), 1e4);  // uniform: no force should result
  const auto gradient = pressure_gradient_sum<2>(state, p, Vec<2>(0.0, 0.0));
  double top = 0.0, inside = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const double y = state.particles.position[i].y();
    if (y > 0.95) top = gradient[i].y();
    if (y < 0.8) inside = std::max(inside, gradient[i].norm());
  }
  EXPECT_LT(inside, 1e-6);
  EXPECT_LT(top, -1e5);  // the force is minus this, outward
}

}  // namespace
}  // namespace poretwin::solid
