// The fluid's part of the exchange, tested with skeletons that have exact solutions.
#include "common/core/error.hpp"
#include "fluid_solver/fluid_phase.hpp"
#include "tests/fluid/scenes.hpp"
#include "tests/fluid/skeleton_stand_in.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <numeric>

namespace poretwin::fluid {
namespace {

using namespace test;

struct Consolidation {
  double worst_settlement = 0.0, worst_base = 0.0;
  double lowest = 0.0;       // pressure, Pa
  double most_voids = 0.0;   // m2
  double worst_voids = 0.0;  // error of the void volume against grains out less water in through the face, m2
  std::size_t windows = 0;
  std::map<std::string, double> counts;
  double cpu = 0.0;
};

struct Options {
  double window = 1e-3;  // s; 0: as the fluid proposes
  double later = 0.0;    // s, second half of the run, where not 0
  double end = 0.5;      // time factor at the end
  double solid_spacing = 0.01;
  double conductivity = 1e-4;
  double jitter = 0.0;
  double load = 1000.0;  // Pa
  double cavitation = -98986.0;
  bool response = true;
  FluidCase::Scheme scheme = FluidCase::Scheme::projection;
  int sweeps = 1;
};

/// A column of 0.2 m x 0.04 m under a sudden load, drained at the top; returns the largest errors from time factor 0.05
/// on.
Consolidation consolidate(const Options& options) {
  ElasticColumn soil;
  soil.spacing = options.solid_spacing;
  soil.conductivity = options.conductivity;
  soil.load = options.load;
  soil.start();
  const double width = 0.04, dx = 0.01;
  Case scene;
  scene.general.gravity.setZero();
  scene.fluid.particle_spacing = dx;
  scene.fluid.jitter = options.jitter;
  scene.water.cavitation_pressure = options.cavitation;
  scene.fluid.skeleton_response = options.response;
  scene.fluid.scheme = options.scheme;
  scene.fluid.sweeps = options.sweeps;
  scene.fluid.regions = {box(0.0, 0.0, width, soil.height)};
  Soil sand;
  sand.shape = box(0.0, 0.0, width, soil.height);
  sand.porosity = 1.0 - soil.solid_fraction;
  sand.hydraulic_conductivity = soil.conductivity;
  scene.soils = {sand};
  scene.walls = {wall(line(0.0, 0.3, 0.0, 0.0)), wall(line(0.0, 0.0, width, 0.0)), wall(line(width, 0.0, width, 0.3))};
  scene.water_faces = {pressure_face(line(width, soil.height, 0.0, soil.height), 0.0)};
  Fluid<2> fluid(scene);

  const auto inbox = [&] {
    const auto& p = fluid.state().particles;
    const std::size_t n = p.size();
    coupling::Inbox box;
    box.coverage.assign(n, 1.0);
    box.asymmetry.assign(n, 0.0);
    const auto scalar = [&](std::string_view name, double value) {
      box.fields.push_back({std::string(name), 1, std::vector<double>(n, value)});
    };
    const auto vertical = [&](std::string_view name, const std::vector<double>& values, bool zero_at_base) {
      coupling::Field field{std::string(name), 2, std::vector<double>(2 * n, 0.0)};
      for (std::size_t a = 0; a < n; ++a)
        field.values[2 * a + 1] = soil.sample(values, p.position[a].y(), zero_at_base);
      box.fields.push_back(field);
    };
    vertical(coupling::field::solid_velocity, soil.v, true);
    vertical(coupling::field::mean_solid_velocity, soil.mean, true);
    coupling::Field expansion{std::string(coupling::field::volumetric_strain_rate), 1, std::vector<double>(n)};
    for (std::size_t a = 0; a < n; ++a)
      expansion.values[a] = (soil.sample(soil.mean, p.position[a].y() + 0.5 * soil.spacing, true) -
                             soil.sample(soil.mean, p.position[a].y() - 0.5 * soil.spacing, true)) /
                            soil.spacing;
    box.fields.push_back(expansion);
    vertical(coupling::field::unbalanced_force, soil.unbalanced(), false);
    scalar(coupling::field::solid_volume_fraction, soil.solid_fraction);
    scalar(coupling::field::grain_density, soil.grain_density);
    scalar(coupling::field::constrained_modulus, soil.modulus);
    scalar(coupling::field::yielding, 0.0);
    scalar(coupling::field::hydraulic_conductivity, soil.conductivity);
    scalar(coupling::field::forchheimer_coefficient, 0.0);
    vertical(coupling::field::returned_impulse, soil.extra, true);
    auto& returned = box.fields.back().values;
    double total = 0.0;
    for (std::size_t a = 0; a < n; ++a) total += returned[2 * a + 1] *= p.volume[a];
    for (std::size_t a = 0; a < n; ++a) returned[2 * a + 1] *= total != 0.0 ? soil.extra_momentum * width / total : 0.0;
    return box;
  };

  const auto begin = std::chrono::steady_clock::now();
  fluid.initialise(inbox());
  Consolidation result;
  double time = 0.0;
  const double cv = soil.conductivity * soil.modulus / soil.weight_density, H = soil.height;
  const auto columns = static_cast<std::size_t>(std::lround(width / dx));
  while (cv * time / (H * H) < options.end) {
    const bool later = options.later > 0.0 && cv * time / (H * H) > 0.5 * options.end;
    const double dt = later ? options.later : options.window > 0.0 ? options.window : fluid.publish().proposed_interval;
    fluid.advance({result.windows, time, dt}, inbox());
    time += dt;
    ++result.windows;
    const auto published = fluid.publish();
    const auto& p = fluid.state().particles;
    // Averages over the rows of the lattice, then linear interpolation in y.
    if (p.size() % columns != 0) {  // thrown apart: there are no rows
      result.worst_base = HUGE_VAL;
      break;
    }
    const std::size_t rows = p.size() / columns;
    std::vector<double> y(rows), pressure(rows), drag(rows), predicted(rows), change(rows);
    for (std::size_t a = 0; a < rows * columns; ++a) {  // a diverging run may have lost some
      const double w = 1.0 / static_cast<double>(columns);
      const std::size_t row = a / columns;
      y[row] += w * p.position[a].y();
      pressure[row] += w * published.fields[0].values[a];
      predicted[row] += w * p.solid_velocity[a].y();
      change[row] += w * p.solid_change[a].y();
      drag[row] += w * p.drag_impulse[a].y() / (p.volume[a] * dt);
    }
    const auto linear = [&](const std::vector<double>& values) {
      return [&y, values](double at) {
        std::size_t i = 0;
        while (i + 2 < y.size() && y[i + 1] < at) ++i;
        const double w = (at - y[i]) / (y[i + 1] - y[i]);
        return (1.0 - w) * values[i] + w * values[i + 1];
      };
    };
    soil.advance(dt, linear(pressure), linear(drag), linear(predicted), linear(change), 1.0 - soil.solid_fraction);
    const double T = cv * time / (H * H);
    result.lowest = std::min(result.lowest, *std::min_element(p.pressure.begin(), p.pressure.end()));
    const double voids = std::accumulate(p.void_volume.begin(), p.void_volume.end(), 0.0);
    const double came = fluid.state().balance.in - fluid.state().balance.out;
    result.most_voids = std::max(result.most_voids, voids);
    result.worst_voids =
        std::max(result.worst_voids, std::abs(voids + came + width * soil.solid_fraction * soil.settlement()));
    if (T >= 0.05) {
      const double U = soil.settlement() / (soil.load * H / soil.modulus);
      result.worst_settlement = std::max(result.worst_settlement, std::abs(U - terzaghi_consolidation(T)));
      result.worst_base = std::max(result.worst_base, std::abs(pressure[0] / soil.load - terzaghi_base_pressure(T)));
      if (!(result.worst_base < 10.0)) break;
    }
  }
  result.counts = fluid.counters();
  result.cpu = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return result;
}

void report(const char* name, const Options& o, const Consolidation& r) {
  std::printf(
      "%s dt %.0e k %.0e ds %.4f: U %.4f base %.4f windows %zu outer/window %.2f p-it %.1f s-it %.1f cpu %.2f s\n",
      name, o.window, o.conductivity, o.solid_spacing, r.worst_settlement, r.worst_base, r.windows,
      r.counts.at("outer iterations") / static_cast<double>(r.windows),
      r.counts.at("pressure iterations") / static_cast<double>(r.windows),
      r.counts.at("skeleton iterations") / static_cast<double>(r.windows), r.cpu);
}

TEST(Coupled, TerzaghiAtWindowsFromShortToLong) {
  // Bounds follow from the ratio of window to consolidation time (0.98 s): backward Euler determines the error.
  struct Row {
    double window, end, settlement, base;
  };
  for (const auto& row : {Row{1e-4, 0.06, 0.005, 0.005}, Row{1e-3, 0.5, 0.005, 0.005}, Row{4e-3, 0.5, 0.01, 0.01},
                          Row{1e-2, 0.5, 0.02, 0.04}, Row{0.0, 0.5, 0.015, 0.02}}) {
    Options o;
    o.window = row.window;
    o.end = row.end;
    const auto r = consolidate(o);
    report("coincident", o, r);
    EXPECT_LT(r.worst_settlement, row.settlement);
    EXPECT_LT(r.worst_base, row.base);
  }
}

// Soil pulled up by 1000 Pa, whose water cavitates at -500 Pa: the pressure does not fall below that, and the volume of
// the voids is that of the grains that went out through the face less that of the water that came in.
TEST(Coupled, SoilThatDilatesTearsItsWater) {
  // In windows of a few substeps the soil's mean velocity lags behind its last one, which the water used: the
  // difference in volume is applied one window later.
  for (const auto& [window, share] : {std::pair{1e-3, 0.05}, std::pair{2.5e-4, 0.08}}) {
    Options o;
    o.window = window;
    o.end = 0.3;
    o.load = -1000.0;
    const auto whole = consolidate(o);
    o.cavitation = -500.0;
    const auto cavitating = consolidate(o);
    std::printf("cavitating, window %.1e s: lowest %.2f Pa (%.2f whole), voids %.3e m2, off %.3e m2 (%.3e whole)\n",
                window, cavitating.lowest, whole.lowest, cavitating.most_voids, cavitating.worst_voids,
                whole.worst_voids);
    EXPECT_LT(whole.lowest, -900.0);
    EXPECT_EQ(whole.most_voids, 0.0);
    EXPECT_GT(cavitating.lowest, -505.0);
    EXPECT_GT(cavitating.most_voids, 5e-7);
    EXPECT_LT(cavitating.worst_voids, share * cavitating.most_voids);  // measured: 0.04, 0.07
  }
}

TEST(Coupled, ShortWindowsPayForLongOnesNoFasterThanTheyWereMade) {
  Options o;
  o.window = 2e-2;
  o.later = 2e-4;
  o.end = 0.2;
  const auto r = consolidate(o);
  report("from long to short", o, r);
  EXPECT_LT(r.worst_settlement, 0.03);
  // 1.25 when the deferred impulse is applied at once; 0.31 as implemented, of which 0.28 is the impulse that the first
  // long window's stiffness defers.
  EXPECT_LT(r.worst_base, 0.5);
}

/// Soil at rest at all water particles, none above `top`.
coupling::Inbox soil_below(const Fluid<2>& fluid, double top) {
  const auto& p = fluid.state().particles;
  coupling::Inbox box;
  for (const auto& x : p.position) box.coverage.push_back(x.y() < top ? 1.0 : 0.0);
  box.asymmetry.assign(p.size(), 0.0);
  const auto fill = [&](std::string_view name, int components, double value) {
    box.fields.push_back({std::string(name), components, std::vector<double>(components * p.size(), value)});
  };
  for (const auto& name : {coupling::field::solid_velocity, coupling::field::mean_solid_velocity,
                           coupling::field::unbalanced_force, coupling::field::returned_impulse})
    fill(name, 2, 0.0);
  fill(coupling::field::volumetric_strain_rate, 1, 0.0);
  fill(coupling::field::solid_volume_fraction, 1, 0.6);
  fill(coupling::field::grain_density, 1, 2600.0);
  fill(coupling::field::constrained_modulus, 1, 4e6);
  fill(coupling::field::yielding, 1, 0.0);
  fill(coupling::field::hydraulic_conductivity, 1, 1e-4);
  fill(coupling::field::forchheimer_coefficient, 1, 0.0);
  return box;
}

TEST(Faces, FollowSoilThatCanFlow) {
  for (const bool flows : {false, true}) {
    Case scene = ponded_column(0.01);  // soil up to 0.4 m, water up to 0.5 m
    scene.solid.model = flows ? SolidCase::Model::drucker_prager : SolidCase::Model::elastic;
    scene.fluid.regions = {scene.soils[0].shape};
    Fluid<2> fluid(scene);
    // Soil that slides out from under the face finds still water there.
    double highest = 0.0;
    const auto& points = fluid.publish().points;
    for (std::size_t j = 0; j < points.size(); ++j) highest = std::max(highest, points.position[2 * j + 1]);
    EXPECT_NEAR(highest, flows ? 0.495 : 0.435, 0.011);
    fluid.initialise(soil_below(fluid, 1.0));
    const std::size_t before = fluid.state().particles.size();
    if (!flows) continue;
    // Where soil has left, five rows of ten, the water is the reservoir's; the face is at the end of the soil.
    for (std::size_t k = 0; k < 5; ++k)
      fluid.advance({k, 1e-4 * static_cast<double>(k), 1e-4}, soil_below(fluid, 0.39 - 0.01 * static_cast<double>(k)));
    EXPECT_EQ(fluid.state().particles.size(), before - 50);
    for (const auto& c : fluid.state().columns) EXPECT_NEAR(c.foot.y(), 0.35, 1e-3);
  }
}

// Soil reports an expansion although its points do not move. The water takes up the volume, and the prediction closes
// the soil by the part that is applied in the first window: an eighth of the rate, and a quarter of the strain over
// eight windows.
TEST(Coupled, PredictsThatSoilClosesWhatItsOwnAccountOpens) {
  const double expansion = 1e-3, interval = 1e-4;  // 1/s, s
  const auto velocity_below_the_top = [&](double strain_rate) {
    Case scene = ponded_column(0.01);
    scene.solid.model = SolidCase::Model::drucker_prager;
    scene.fluid.regions = {scene.soils[0].shape};
    Fluid<2> fluid(scene);
    const auto soil = [&] {
      auto box = soil_below(fluid, 1.0);
      for (auto& field : box.fields)
        if (field.name == coupling::field::volumetric_strain_rate)
          std::fill(field.values.begin(), field.values.end(), strain_rate);
      return box;
    };
    fluid.initialise(soil());
    for (std::size_t k = 0; k < 2; ++k) fluid.advance({k, interval * static_cast<double>(k), interval}, soil());
    const auto& p = fluid.state().particles;
    double sum = 0.0, count = 0.0;
    for (std::size_t a = 0; a < p.size(); ++a) {
      if (std::abs(p.position[a].y() - 0.3) > 0.02) continue;
      sum += p.solid_velocity[a].y();
      count += 1.0;
    }
    return sum / count;
  };
  // soil_below: n = 0.4, k = 1e-4 m/s; factor: part of the mixture that moves with the skeleton.
  const double n = 0.4, inertia = n * 1000.0 / interval, drag = n * n * 1000.0 * 9.81 / 1e-4;
  const double closes = -33.0 / 256.0 * expansion * (1.0 - n + n * drag / (inertia + drag)) * 0.3;  // m/s, 0.3 m up
  EXPECT_NEAR(velocity_below_the_top(expansion) - velocity_below_the_top(0.0), closes, -0.1 * closes);
}

TEST(Coupled, TerzaghiInNearlyTightSoil) {
  Options o;
  o.window = 2e-2;
  o.conductivity = 1e-5;
  const auto r = consolidate(o);
  report("tight", o, r);
  EXPECT_LT(r.worst_settlement, 0.01);
  EXPECT_LT(r.worst_base, 0.01);
}

TEST(Coupled, TerzaghiWithPointsThatDoNotCoincide) {
  for (const auto& [window, base] : {std::pair{1e-3, 0.01}, std::pair{1e-2, 0.04}}) {
    Options o;
    o.solid_spacing = 0.0077;
    o.jitter = 0.1;
    o.window = window;
    const auto r = consolidate(o);
    report("offset, jittered", o, r);
    EXPECT_LT(r.worst_settlement, 0.02);
    EXPECT_LT(r.worst_base, base);
  }
}

TEST(Coupled, WithoutTheSkeletonsResponseWindowsAreLimited) {
  // The stability limit of serial staggering is 2 (1 - b) R k / gamma_w, b = n_s^2 rho_w / (n R): 1.4e-5 s here.
  Options o;
  o.response = false;
  o.end = 0.06;
  o.window = 1e-5;
  const auto below = consolidate(o);
  report("staggered", o, below);
  EXPECT_LT(below.worst_settlement, 0.005);
  o.window = 1e-4;
  o.cavitation = -1e12;  // cavitation would stop the growth
  try {
    consolidate(o);
    ADD_FAILURE() << "did not diverge";
  } catch (const DivergedError& error) {
    EXPECT_THAT(error.what(), testing::ContainsRegex("(pore_pressure|velocity).* of particle [0-9]+ at \\(.*\\).*; "
                                                     "last good state at t = [0-9.e-]+ s"));
  }
}

TEST(Coupled, ExplicitSweepsConsolidateInTheirOwnWindows) {
  // Explicit sweeps leave water slightly compressible, which keeps the staggering stable beyond its limit, and the base
  // pressure low.
  struct Row {
    double window;
    int sweeps;
    double settlement, base;
  };
  for (const auto& row : {Row{0.0, 1, 0.01, 0.06}, Row{0.0, 10, 0.005, 0.01}, Row{4e-5, 1, 0.03, 0.4}}) {
    Options o;
    o.scheme = FluidCase::Scheme::eisph;
    o.window = row.window;
    o.sweeps = row.sweeps;
    o.end = 0.06;
    const auto r = consolidate(o);
    report("explicit sweeps", o, r);
    EXPECT_LT(r.worst_settlement, row.settlement);
    EXPECT_LT(r.worst_base, row.base);
  }
}

/// Two phases of uniform velocity in a periodic box: only the drag between them acts.
struct Exchange {
  Case scene;
  Exchange(double conductivity) {
    scene.general.gravity.setZero();
    scene.general.domain_max = Point3(0.1, 0.1, 0.0);
    scene.general.periodic = {0, 1};
    scene.fluid.particle_spacing = 0.01;
    scene.fluid.regions = {box(0.0, 0.0, 0.1, 0.1)};
    scene.fluid.initial_velocity = Point3(0.3, -0.1, 0.0);
    Soil sand;
    sand.shape = box(0.0, 0.0, 0.1, 0.1);
    sand.porosity = 0.4;
    sand.hydraulic_conductivity = conductivity;
    scene.soils = {sand};
  }
  /// force [N/m3]: drag of the last window on the skeleton.
  coupling::Inbox inbox(std::size_t n, const Vec<2>& v, const Vec<2>& returned, const Vec<2>& force) const {
    coupling::Inbox box;
    box.coverage.assign(n, 1.0);
    box.asymmetry.assign(n, 0.0);
    const auto scalar = [&](std::string_view name, double value) {
      box.fields.push_back({std::string(name), 1, std::vector<double>(n, value)});
    };
    const auto vector = [&](std::string_view name, const Vec<2>& value) {
      coupling::Field field{std::string(name), 2, {}};
      for (std::size_t a = 0; a < n; ++a) field.values.insert(field.values.end(), {value.x(), value.y()});
      box.fields.push_back(field);
    };
    vector(coupling::field::solid_velocity, v);
    vector(coupling::field::mean_solid_velocity, v);
    scalar(coupling::field::volumetric_strain_rate, 0.0);
    vector(coupling::field::unbalanced_force, force);
    scalar(coupling::field::solid_volume_fraction, 0.6);
    scalar(coupling::field::grain_density, 2600.0);
    scalar(coupling::field::constrained_modulus, 4e6);
    scalar(coupling::field::yielding, 0.0);
    scalar(coupling::field::hydraulic_conductivity, scene.soils[0].hydraulic_conductivity);
    scalar(coupling::field::forchheimer_coefficient,
           porous::seepage_at(scene, scene.soils[0], scene.soils[0].porosity).quadratic);
    vector(coupling::field::returned_impulse, returned);
    return box;
  }
};

TEST(Coupled, DragRelaxesAtItsRateAndKeepsMomentum) {
  for (const double rate_times_dt : {0.001, 0.02, 1.0, 1e4}) {
    const double k = 1e-3, R = 0.6 * 2600.0, Rw = 0.4 * 1000.0;
    const double rate = 9810.0 * 0.4 * 0.4 / k * (1.0 / Rw + 1.0 / R), dt = rate_times_dt / rate;
    const Exchange exchange(k);
    Fluid<2> fluid(exchange.scene);
    Vec<2> solid(-0.05, 0.2), drag = Vec<2>::Zero(), pushed = Vec<2>::Zero(), returned = Vec<2>::Zero();
    const double solid_mass = R * 0.01;
    fluid.initialise(exchange.inbox(100, solid, returned, drag));
    const auto fluid_momentum = [&] {
      Vec<2> sum = Vec<2>::Zero();
      const auto& p = fluid.state().particles;
      for (std::size_t a = 0; a < p.size(); ++a) sum += p.mass[a] * p.velocity[a];
      return sum;
    };
    const Vec<2> total = fluid_momentum() + solid_mass * solid;
    const auto& p = fluid.state().particles;
    Vec<2> slip = p.velocity[0] - solid;
    double time = 0.0;
    // In a long window points move far, and rounding destroys the lattice's symmetry: one window only.
    for (int step = 0; step < (rate_times_dt > 1.0 ? 1 : 10); ++step) {
      fluid.advance({static_cast<std::uint64_t>(step), time, dt}, exchange.inbox(p.size(), solid, returned, drag));
      time += dt;
      Vec<2> impulse = Vec<2>::Zero();
      for (const auto& J : p.drag_impulse) impulse += J;
      drag = impulse / (0.01 * dt);
      // An additional push moves the skeleton beyond the prediction: it is resisted by the inertia of the water that
      // its drag carries along, and in the next window the water follows.
      const Vec<2> push = 0.01 * impulse;
      const double met = Rw * p.entrained_fraction[0] * 0.01;  // kg
      const Vec<2> beyond = push / (solid_mass + met);
      solid += impulse / solid_mass + beyond;
      returned = -met * beyond / static_cast<double>(p.size());
      pushed += push;
      const Vec<2> now = fluid_momentum() + solid_mass * solid + met * beyond - pushed;
      EXPECT_LT((now - total).norm(), 1e-10 * total.norm());
      if (step == 0 && rate_times_dt <= 0.02) {
        const double decay = std::log(slip.norm() / (p.velocity[0] - p.solid_velocity[0]).norm()) / dt;
        EXPECT_NEAR(decay / rate, 1.0, 0.01) << rate_times_dt;
      }
      if (step == 0) {
        EXPECT_LT((p.velocity[0] - p.solid_velocity[0]).norm(), slip.norm());
        EXPECT_GE(slip.dot(p.velocity[0] - p.solid_velocity[0]), -1e-12);  // monotone, without overshoot
      }
    }
  }
}

TEST(Coupled, QuadraticDragFollowsItsClosedFormAndKeepsMomentum) {
  // Relative velocity of two bodies, dw/dt = -(1/Rw + 1/R) (c1 w + c2 w^2): w = A w0 e / (A + B w0 (1 - e)), e = exp(-A
  // t).
  const double k = 0.05, b = 40.0, R = 0.6 * 2600.0, Rw = 0.4 * 1000.0;
  Exchange exchange(k);
  auto& sand = exchange.scene.soils[0];
  sand.seepage_law = &porous::seepage_law("forchheimer");
  sand.own_numbers["forchheimer_coefficient"] = b;
  const double inertia = 1.0 / Rw + 1.0 / R, A = inertia * 9810.0 * 0.16 / k, B = inertia * 9810.0 * 0.064 * b;
  for (const double dt : {5e-5, 5e-4}) {
    Fluid<2> fluid(exchange.scene);
    Vec<2> solid(-0.05, 0.2), returned = Vec<2>::Zero(), drag = Vec<2>::Zero();
    const double solid_mass = R * 0.01;
    fluid.initialise(exchange.inbox(100, solid, returned, drag));
    const auto& p = fluid.state().particles;
    const auto momentum = [&] {
      Vec<2> sum = solid_mass * solid;
      for (std::size_t a = 0; a < p.size(); ++a) sum += p.mass[a] * p.velocity[a];
      return sum;
    };
    const Vec<2> total = momentum(), slip = p.velocity[0] - solid;
    double time = 0.0, worst = 0.0;
    for (std::uint64_t step = 0; time < 0.05; ++step) {
      fluid.advance({step, time, dt}, exchange.inbox(p.size(), solid, returned, drag));
      time += dt;
      drag.setZero();
      for (const auto& J : p.drag_impulse) drag += J / (0.01 * dt);
      solid += dt * drag / R;
      const double e = std::exp(-A * time), w0 = slip.norm();
      const double exact = A * w0 * e / (A + B * w0 * (1.0 - e)), w = (p.velocity[0] - solid).norm();
      worst = std::max(worst, std::abs(w - exact) / w0);
      EXPECT_LT((momentum() - total).norm(), 1e-10 * total.norm());
    }
    std::printf("quadratic drag, window %.0e s: slip off by %.2e of its start\n", dt, worst);
    // Backward Euler has an error of at most 1/(2 e) = 0.184 windows per relaxation time on an exponential.
    EXPECT_LT(worst, 0.2 * dt * (A + B * slip.norm()));
  }
}

TEST(Coupled, RestIsKeptUnderGravity) {
  // A saturated layer below its own water table, whose skeleton carries its buoyant weight: nothing may move.
  Case scene;
  scene.fluid.particle_spacing = 0.01;
  scene.fluid.regions = {box(0.0, 0.0, 0.06, 0.1)};
  Soil sand;
  sand.shape = box(0.0, 0.0, 0.06, 0.1);
  scene.soils = {sand};
  scene.walls = {wall(line(0.0, 0.2, 0.0, 0.0)), wall(line(0.0, 0.0, 0.06, 0.0)), wall(line(0.06, 0.0, 0.06, 0.2))};
  Exchange contents(1e-4);
  Fluid<2> fluid(scene);
  const auto inbox = [&] {
    // In equilibrium: no unbalanced force.
    return contents.inbox(fluid.state().particles.size(), Vec<2>::Zero(), Vec<2>::Zero(), Vec<2>::Zero());
  };
  for (std::size_t a = 0; a < fluid.state().particles.size(); ++a)  // hydrostatic from the first publication on
    EXPECT_NEAR(fluid.publish().fields[0].values[a], 9810.0 * (0.1 - fluid.state().particles.position[a].y()),
                1e-3 * 981.0);
  fluid.initialise(inbox());
  double time = 0.0;
  for (std::uint64_t step = 0; step < 20; ++step) {
    const double dt = fluid.publish().proposed_interval;
    fluid.advance({step, time, dt}, inbox());
    time += dt;
  }
  const auto published = fluid.publish();
  const auto& p = fluid.state().particles;
  for (std::size_t a = 0; a < p.size(); ++a) {
    EXPECT_NEAR(published.fields[0].values[a], 9810.0 * (0.1 - p.position[a].y()), 1e-3 * 981.0);
    EXPECT_LT(p.velocity[a].norm(), 1e-8);
    EXPECT_LT(p.solid_velocity[a].norm(), 1e-8);
  }
}

}  // namespace
}  // namespace poretwin::fluid
