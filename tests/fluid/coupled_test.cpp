// The fluid's half of the exchange scheme, held against skeletons simple enough to be exact.
#include "fluid_solver/fluid_phase.hpp"
#include "tests/fluid/scenes.hpp"
#include "tests/fluid/skeleton_stand_in.hpp"

#include <gtest/gtest.h>

#include <chrono>

namespace poretwin::fluid {
namespace {

using namespace test;

struct Consolidation {
  double worst_settlement = 0.0, worst_base = 0.0;
  std::size_t windows = 0;
  std::map<std::string, double> counts;
  double cpu = 0.0;
};

struct Options {
  double window = 1e-3;  // s; 0: what the fluid proposes
  double end = 0.5;      // of the time factor
  double solid_spacing = 0.01;
  double conductivity = 1e-4;
  double jitter = 0.0;
  bool response = true;
};

/// A column of 0.2 m x 0.04 m under a sudden load, drained at the top; worst errors from T = 0.05 on.
Consolidation consolidate(const Options& options) {
  ElasticColumn soil;
  soil.spacing = options.solid_spacing;
  soil.conductivity = options.conductivity;
  soil.start();
  const double width = 0.04, dx = 0.01;
  Case scene;
  scene.general.gravity.setZero();
  scene.fluid.particle_spacing = dx;
  scene.fluid.jitter = options.jitter;
  scene.fluid.skeleton_response = options.response;
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
    const auto scalar = [&](std::string_view name, double value) {
      box.fields.push_back({std::string(name), 1, std::vector<double>(n, value)});
    };
    const auto vertical = [&](std::string_view name, const std::vector<double>& values, bool zero_at_base) {
      coupling::Field field{std::string(name), 2, std::vector<double>(2 * n, 0.0)};
      for (std::size_t a = 0; a < n; ++a) field.values[2 * a + 1] = soil.sample(values, p.position[a].y(), zero_at_base);
      box.fields.push_back(field);
    };
    vertical(coupling::field::solid_velocity, soil.v, true);
    vertical(coupling::field::mean_solid_velocity, soil.mean, true);
    vertical(coupling::field::unbalanced_force, soil.force(), false);
    scalar(coupling::field::solid_volume_fraction, soil.solid_fraction);
    scalar(coupling::field::grain_density, soil.grain_density);
    scalar(coupling::field::constrained_modulus, soil.modulus);
    scalar(coupling::field::hydraulic_conductivity, soil.conductivity);
    vertical(coupling::field::returned_impulse, soil.extra, true);
    auto& owed = box.fields.back().values;
    double total = 0.0;
    for (std::size_t a = 0; a < n; ++a) total += owed[2 * a + 1] *= p.volume[a];
    for (std::size_t a = 0; a < n; ++a) owed[2 * a + 1] *= total != 0.0 ? soil.extra_momentum * width / total : 0.0;
    return box;
  };

  const auto begin = std::chrono::steady_clock::now();
  fluid.initialise(inbox());
  Consolidation result;
  double time = 0.0;
  const double cv = soil.conductivity * soil.modulus / soil.weight_density, H = soil.height;
  const auto columns = static_cast<std::size_t>(std::lround(width / dx));
  while (cv * time / (H * H) < options.end) {
    const double dt = options.window > 0.0 ? options.window : fluid.publish().proposed_interval;
    fluid.advance({result.windows, time, dt}, inbox());
    time += dt;
    ++result.windows;
    const auto published = fluid.publish();
    const auto& p = fluid.state().particles;
    // Rows of the lattice, averaged; then linear in y.
    const std::size_t rows = p.size() / columns;
    std::vector<double> y(rows), pressure(rows), drag(rows), predicted(rows);
    for (std::size_t a = 0; a < p.size(); ++a) {
      const double w = 1.0 / static_cast<double>(columns);
      const std::size_t row = a / columns;
      y[row] += w * p.position[a].y();
      pressure[row] += w * published.fields[0].values[a];
      predicted[row] += w * p.solid_velocity[a].y();
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
    soil.advance(dt, linear(pressure), linear(drag), linear(predicted), 1.0 - soil.solid_fraction);
    const double T = cv * time / (H * H);
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
  std::printf("%s dt %.0e k %.0e ds %.4f: U %.4f base %.4f windows %zu outer/window %.2f p-it %.1f s-it %.1f cpu %.2f s\n", name,
              o.window, o.conductivity, o.solid_spacing, r.worst_settlement, r.worst_base, r.windows,
              r.counts.at("outer iterations") / static_cast<double>(r.windows),
              r.counts.at("pressure iterations") / static_cast<double>(r.windows),
              r.counts.at("skeleton iterations") / static_cast<double>(r.windows), r.cpu);
}

TEST(Coupled, TerzaghiAtWindowsFromShortToLong) {
  for (const auto& [window, end] : {std::pair{1e-4, 0.06}, std::pair{1e-3, 0.5}, std::pair{1e-2, 0.5}, std::pair{0.0, 0.5}}) {
    Options o;
    o.window = window;
    o.end = end;
    const auto r = consolidate(o);
    report("coincident", o, r);
    EXPECT_LT(r.worst_settlement, 0.02);
    EXPECT_LT(r.worst_base, 0.02);
  }
}

TEST(Coupled, TerzaghiWithPointsThatDoNotCoincide) {
  Options o;
  o.solid_spacing = 0.0077;
  o.jitter = 0.1;
  const auto r = consolidate(o);
  report("offset, jittered", o, r);
  EXPECT_LT(r.worst_settlement, 0.02);
  EXPECT_LT(r.worst_base, 0.02);
}

}  // namespace
}  // namespace poretwin::fluid
