// Basins behind faces of the field: their level against exact solutions, and their balance.
#include "tests/pore/scenes.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace poretwin::pore::test {
namespace {

constexpr double k = 1e-4, L = 0.5, dx = 0.05;  // m/s, m, m

/// A basin of constant area from `bottom` up.
WaterFace basin_face(Face face, double bottom, double area, double level) {
  WaterFace f = head_face(std::move(face), level);
  f.name = "basin";
  f.discharge = constant(0.0);
  f.basin_area = Series{{{bottom, area}}};
  return f;
}
Soil saturated(bool curve) { return curve ? van_genuchten(0.05, 0.4, 3.5, 2.8, k) : sharp(0.4, k); }

/// A saturated column of the height L with a head at its base, and a basin on its top.
Case permeameter(bool curve, double area, double level, double head, double end) {
  Case scene = column(saturated(curve), L, dx, end);
  scene.fluid.initial_water_table = level;
  scene.water_faces = {basin_face(top_of(dx, L), L, area, level), head_face(base_of(dx), head)};
  scene.gauges = {gauge("level", "level", {}, "basin"), gauge("water", "basin", {}, "basin"),
                  gauge("seeped", "passed_volume", {}, "basin"), gauge("soil", "balance")};
  return scene;
}

/// The water of the basin that is named "basin", less what the gauges say about it, over `scale` [m2].
void expect_balance(const PoreWater& water, double scale) {
  EXPECT_LT(std::abs(reading(water, "water_error")), 1e-10 * scale);
  EXPECT_LT(std::abs(reading(water, "soil_error")), 1e-10 * scale);
  EXPECT_EQ(reading(water, "water_seeped"), reading(water, "seeped"));
}

TEST(FieldBasin, AFallingHeadIsExponential) {
  // h = h2 + (h0 - h2) exp(-k A t / (a L)), with the column's area A and the standpipe's area a.
  const double h0 = 1.5, h2 = 0.7, area = 0.4 * dx, rate = k * dx / (area * L);
  for (const bool curve : {false, true}) {
    PoreWater water(permeameter(curve, area, h0, h2, 3.0 / rate));
    for (const double t : {0.3, 1.0, 3.0}) {
      run_to(water, t / rate);
      EXPECT_NEAR(reading(water, "level"), h2 + (h0 - h2) * std::exp(-t), 2e-4 * (h0 - h2)) << t << ", curve " << curve;
      EXPECT_NEAR(area * (h0 - reading(water, "level")), reading(water, "seeped"), 1e-10 * area * h0);
    }
    expect_balance(water, area * h0);
  }
}

TEST(FieldBasin, AFallingHeadInSpaceIsExponential) {
  const double h0 = 1.5, h2 = 0.7, area = 0.4 * dx * dx, rate = k * dx * dx / (area * L);
  Shape shape;
  shape.min = Point3::Zero();
  shape.max = {dx, dx, L};
  Case scene = scene_of(saturated(false), shape, dx, 1.0 / rate);
  scene.general.dimension = 3;
  scene.general.gravity = {0.0, 0.0, -9.81};
  scene.fluid.initial_water_table = h0;
  Face top, base;
  top.point = {0.0, 0.0, L};
  top.normal = {0.0, 0.0, -1.0};
  base.normal = {0.0, 0.0, 1.0};
  scene.water_faces = {basin_face(top, L, area, h0), head_face(base, h2)};
  scene.gauges = {gauge("level", "level", {}, "basin")};
  PoreWater water(scene);
  run_to(water, 1.0 / rate);
  EXPECT_NEAR(reading(water, "level"), h2 + (h0 - h2) * std::exp(-1.0), 2e-4 * (h0 - h2));
}

TEST(FieldBasin, TwoBasinsJoinedBySoilFindTheirMean) {
  // The difference of the levels decays with k H / L (1 / A1 + 1 / A2), H the layer's thickness.
  const double H = 0.2, first = 0.6, second = 0.3, A1 = 0.3, A2 = 0.1, rate = k * H / L * (1.0 / A1 + 1.0 / A2);
  Case scene = scene_of(saturated(false), box(0.0, 0.0, L, H), dx, 3.0 / rate);
  scene.fluid.initial_water_table = first;
  scene.water_faces = {basin_face(line(0.0, H, 0.0, 0.0), 0.0, A1, first),
                       basin_face(line(L, 0.0, L, H), 0.0, A2, second)};
  scene.water_faces[1].name = "other";
  scene.gauges = {gauge("level", "level", {}, "basin"), gauge("other", "level", {}, "other"),
                  gauge("water", "basin", {}, "basin"), gauge("soil", "balance")};
  PoreWater water(scene);
  for (const double t : {0.5, 3.0}) {
    run_to(water, t / rate);
    const double one = reading(water, "level"), two = reading(water, "other");
    EXPECT_NEAR(one - two, (first - second) * std::exp(-t), 3e-4 * (first - second)) << t;
    EXPECT_NEAR(A1 * one + A2 * two, A1 * first + A2 * second, 1e-7 * A1 * first);  // less what the soil took
  }
  EXPECT_LT(std::abs(reading(water, "water_error")), 1e-10 * A1 * first);
}

TEST(FieldBasin, APitFillsFromTheSoilAndRainAndSpills) {
  // A h' = k B (H - h) / L + Q + r A: a column of the width B under the pit's bed, with the head H at its base.
  const double area = 0.2, H = 1.0, Q = 2e-6, r = 5e-6, spill = 0.8;
  const double rate = k * dx / (area * L), rest = H + (Q + r * area) / (k * dx / L);
  Case scene = permeameter(false, area, L, H, 10.0 / rate);
  WaterFace& pit = scene.water_faces[0];
  pit.discharge = constant(Q);
  pit.basin_rain = constant(r);
  pit.spill_level = spill;
  PoreWater water(scene);
  const double half = 0.2 / rate;
  run_to(water, half);
  EXPECT_NEAR(reading(water, "level"), rest + (L - rest) * std::exp(-rate * half), 2e-4 * (rest - L));
  EXPECT_EQ(reading(water, "water_spilled"), 0.0);
  EXPECT_NEAR(reading(water, "water_in"), (Q + r * area) * half, 1e-10 * Q * half);
  // At the spill level what comes in runs off.
  run_to(water, 10.0 / rate);
  const double full = std::log((rest - L) / (rest - spill)) / rate, more = Q + r * area + k * dx * (H - spill) / L;
  EXPECT_EQ(reading(water, "level"), spill);
  EXPECT_NEAR(reading(water, "water_stored"), area * (spill - L), 1e-10 * area);
  EXPECT_NEAR(reading(water, "water_spilled"), more * (10.0 / rate - full), 2e-4 * more * full);
  expect_balance(water, more * 10.0 / rate);
}

TEST(FieldBasin, ATableOfAreasIsFollowed) {
  // A(h) h' = k B (H - h) / L with A growing from 0.1 to 0.3 m over half a metre.
  const double H = 1.2, end = 8e3;
  Case scene = permeameter(false, 0.1, L, H, end);
  scene.water_faces[0].basin_area = Series{{{L, 0.1}, {L + 0.5, 0.3}}};
  double h = L;
  const auto speed = [&](double level) { return k * dx * (H - level) / L / (0.1 + 0.4 * (level - L)); };
  constexpr int steps = 2000;
  for (int i = 0; i < steps; ++i) {
    const double dt = end / steps, a = speed(h), b = speed(h + 0.5 * dt * a), c = speed(h + 0.5 * dt * b);
    h += dt / 6.0 * (a + 2.0 * b + 2.0 * c + speed(h + dt * c));
  }
  PoreWater water(scene);
  run_to(water, end);
  EXPECT_NEAR(reading(water, "level"), h, 2e-4 * (h - L));
}

TEST(FieldBasin, ADryBasinPassesItsRainToTheSoil) {
  // Rain of a tenth of the conductivity soaks in at once; then evaporation finds no water to take.
  for (const bool curve : {false, true}) {
    const double r = 0.1 * k, stops = 3600.0, end = 7200.0;
    Case scene = permeameter(curve, dx, L, 0.0, end);
    scene.fluid.initial_water_table = 0.0;
    scene.water_faces[0].basin_rain = Series{{{0.0, r}, {stops, r}, {stops + 1e-6, -r}}};
    PoreWater water(scene);
    run_to(water, end);
    EXPECT_EQ(reading(water, "level"), L);
    EXPECT_NEAR(reading(water, "water_in"), r * dx * stops, 1e-9 * r * dx * stops);
    EXPECT_NEAR(reading(water, "water_seeped"), r * dx * stops, 1e-6 * r * dx * stops);
    EXPECT_NEAR(reading(water, "water_out"), 0.0, 1e-6 * r * dx * stops);
    expect_balance(water, r * dx * stops);
  }
}

TEST(FieldBasin, ABasinCanBeDrawnEmpty) {
  // More is drawn off than comes out of the soil: the basin runs dry and gives what comes.
  const double area = 0.1, H = 1.0, end = 2e4;
  Case scene = permeameter(false, area, 0.8, H, end);
  scene.water_faces[0].discharge = constant(-5e-5);
  PoreWater water(scene);
  run_to(water, end);
  EXPECT_EQ(reading(water, "level"), L);
  EXPECT_NEAR(reading(water, "water_stored"), 0.0, 1e-12);
  EXPECT_NEAR(reading(water, "water_out"), area * 0.3 - reading(water, "seeped"), 1e-10 * area);
  EXPECT_LT(reading(water, "water_out"), 0.9 * 5e-5 * end);
  run_to(water, end);
  expect_balance(water, area);
}

TEST(FieldBasin, ALongStepTakesNoMoreThanThereIs) {
  // A shallow basin over dry soil that takes its water at once, in a single window.
  Case scene = permeameter(true, dx, L + 0.002, 0.0, 1e4);
  scene.fluid.initial_water_table = -1.0;
  PoreWater water(scene);
  run_to(water, 1e4);
  EXPECT_NEAR(reading(water, "water_stored"), 0.0, 1e-6 * 0.002 * dx);  // the accuracy of the search for the level
  EXPECT_EQ(reading(water, "water_out"), 0.0);
  EXPECT_NEAR(reading(water, "water_seeped"), 0.002 * dx, 1e-6 * 0.002 * dx);
  expect_balance(water, 0.002 * dx);
}

TEST(FieldBasin, AResumedRunGoesOnToTheBit) {
  const Case scene = permeameter(false, 0.4 * dx, 1.5, 0.7, 4e3);
  PoreWater whole(scene), first(scene), second(scene);
  run_to(first, 2e3);
  Archive saved;
  first.archive(saved);
  Archive loaded(saved.bytes());
  second.archive(loaded);
  run_to(whole, 2e3);
  run_to(whole, 4e3);
  run_to(second, 4e3);
  EXPECT_EQ(whole.state().level, second.state().level);
  EXPECT_EQ(whole.state().basin[0].stored, second.state().basin[0].stored);
}

}  // namespace
}  // namespace poretwin::pore::test
