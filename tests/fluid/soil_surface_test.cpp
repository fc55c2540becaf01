// The surface of soil under free water, with soil whose motion is given.
#include "coupler/mapping.hpp"
#include "fluid_solver/boundary/walls.hpp"
#include "fluid_solver/exchange/soil_exchange.hpp"
#include "fluid_solver/fluid_phase.hpp"
#include "tests/fluid/scenes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

namespace poretwin::fluid {
namespace {

using namespace test;

/// Soil on a base that is compressed evenly at a given rate: a lattice of points with the coupler's own mapping.
struct Compressed {
  double width = 0.25, height = 1.0, spacing = 0.05;
  double speed = 1e-3;  ///< m/s, of its surface
  double porosity = 0.5, conductivity = 1e-3;
  double time = 0.0;

  double stretch() const { return 1.0 - speed * time / height; }
  double top() const { return height * stretch(); }
  double fraction() const { return (1.0 - porosity) / stretch(); }

  /// The soil in a column of water 1.3 m high, without walls.
  Case scene() const {
    Case scene;
    scene.fluid.particle_spacing = scene.solid.particle_spacing = spacing;
    scene.fluid.regions = {box(0.0, 0.0, width, 1.3)};
    Soil clay;
    clay.shape = box(0.0, 0.0, width, height);
    clay.porosity = porosity;
    clay.hydraulic_conductivity = conductivity;
    scene.soils = {clay};
    return scene;
  }

  coupling::Publication publish(std::uint64_t revision) const {
    coupling::Publication out;
    auto& p = out.points;
    p.revision = revision;
    const int reach = 4, across = static_cast<int>(std::lround(width / spacing)),
              up = static_cast<int>(std::lround(height / spacing));
    std::vector<double> row;  // undisturbed height
    for (int active = 1; active >= 0; --active)
      for (int j = -reach; j < up; ++j)
        for (int i = -reach; i < across + reach; ++i) {
          const bool inside = i >= 0 && i < across && j >= 0;
          if (inside != (active == 1)) continue;
          const double y = (j + 0.5) * spacing;
          p.position.insert(p.position.end(), {(i + 0.5) * spacing, y * stretch()});
          p.volume.push_back(spacing * spacing * stretch());
          p.smoothing_length.push_back(1.2 * spacing);
          p.owner.push_back(inside ? static_cast<double>(p.volume.size() - 1) : -1.0);
          p.n_active += inside ? 1 : 0;
          row.push_back(y);
        }
    const std::size_t n = p.size();
    for (const auto& spec : coupling::standard_fields(coupling::Role::solid, 2)) {
      const auto components = static_cast<std::size_t>(spec.components);
      coupling::Field field{spec.name, spec.components, std::vector<double>(n * components, 0.0)};
      for (std::size_t j = 0; j < n; ++j) {
        if (spec.name == coupling::field::solid_velocity || spec.name == coupling::field::mean_solid_velocity)
          field.values[2 * j + 1] = -speed * row[j] / height;
        else if (spec.name == coupling::field::volumetric_strain_rate)
          field.values[j] = -speed / (height * stretch());
        else if (spec.name == coupling::field::solid_volume_fraction)
          field.values[j] = fraction();
        else if (spec.name == coupling::field::grain_density)
          field.values[j] = 2650.0;
        else if (spec.name == coupling::field::hydraulic_conductivity)
          field.values[j] = conductivity;
      }
      out.fields.push_back(std::move(field));
    }
    return out;
  }
};

/// Lets all the soil yield.
void yield(coupling::Publication& soil) {
  for (auto& field : soil.fields)
    if (field.name == coupling::field::yielding) std::fill(field.values.begin(), field.values.end(), 1.0);
}

/// Water particles at given places, as the mapping takes them.
coupling::PointSet points_at(std::span<const Vec<2>> places, double spacing) {
  coupling::PointSet points;
  points.dimension = 2;
  points.revision = 1;
  points.n_active = places.size();
  for (const auto& place : places) {
    points.position.insert(points.position.end(), {place.x(), place.y()});
    points.owner.push_back(static_cast<double>(points.volume.size()));
    points.volume.push_back(spacing * spacing);
    points.smoothing_length.push_back(1.3 * spacing);
  }
  return points;
}

TEST(SoilSurface, TellsHowFarAPlaceIsFromIt) {
  // From half a spacing inside to one spacing outside, wherever the place is along the surface.
  const Compressed soil;
  const auto from = soil.publish(1);
  const auto specs = coupling::standard_fields(coupling::Role::solid, 2);
  std::vector<double> distance;  // spacings
  VecArray<2> places;
  for (double along : {0.0, 0.2, 0.5})
    for (double d = -0.5; d <= 1.0; d += 0.125) {
      distance.push_back(d);
      places.push_back(Vec<2>(2.0 + along, soil.height / soil.spacing + d) * soil.spacing);
    }
  const auto inbox = coupling::make_mapping(2)->map(coupling::Role::solid, from.points, from.fields, specs,
                                                    points_at(places, soil.spacing));
  for (std::size_t a = 0; a < distance.size(); ++a)
    EXPECT_NEAR(distance_outside(inbox.asymmetry[a], soil.spacing), distance[a] * soil.spacing, 0.02 * soil.spacing)
        << distance[a];
}

TEST(SoilSurface, WaterSlipsPastAnEdgeButDragsASinglePoint) {
  // Tight soil that moves: a flat edge a fifth of a spacing below the water, and one point half a spacing beside it.
  Compressed soil;
  soil.speed = 1.0;
  const fluid::Setup<2> setup(soil.scene(), {});
  const auto specs = coupling::standard_fields(coupling::Role::solid, 2);
  const auto drag_at = [&](const coupling::Publication& from, const Vec<2>& place) {
    const auto inbox = coupling::make_mapping(2)->map(coupling::Role::solid, from.points, from.fields, specs,
                                                      points_at(std::vector{place}, soil.spacing));
    const std::vector<double> before{0.3};
    const SeepageRegime regime{1000.0, 1e-3, false};
    return mapped_soil<2>(setup, inbox, inbox.asymmetry, before, std::vector<char>{0}, regime).drag[0];
  };
  auto from = soil.publish(1);
  EXPECT_EQ(drag_at(from, Vec<2>(2.5, 20.2) * soil.spacing), 0.0);
  yield(from);
  EXPECT_EQ(drag_at(from, Vec<2>(2.5, 20.2) * soil.spacing), 0.0);
  // Of all points only the one in the middle of the top row is left where it is.
  const Vec<2> point = Vec<2>(2.5, 19.5) * soil.spacing;
  for (std::size_t i = 0; i < from.points.size(); ++i)
    if ((Vec<2>(from.points.position[2 * i], from.points.position[2 * i + 1]) - point).norm() > 1e-9)
      from.points.position[2 * i] += 100.0 + 10.0 * static_cast<double>(i);
  EXPECT_GT(drag_at(from, point + Vec<2>(0.0, 0.5 * soil.spacing)), 1e5);
  // Loose grains have grown, and a wall on which they lie shows their images: they cover as much water as an edge does.
  for (auto& volume : from.points.volume) volume *= 3.0;
  EXPECT_GT(drag_at(from, point + Vec<2>(0.0, 0.5 * soil.spacing)), 1e5);
}

TEST(SoilSurface, GrainsApartCountAsTheVolumeTheyHave) {
  // Membership of a lattice of water around grains, wherever these lie between its points. [spacings]
  const Compressed soil;
  const fluid::Setup<2> setup(soil.scene(), {});
  const auto specs = coupling::standard_fields(coupling::Role::solid, 2);
  const auto memberships = [&](const VecArray<2>& grains, const VecArray<2>& places) {
    auto from = soil.publish(1);
    auto& p = from.points;
    p.n_active = grains.size();
    p.position.clear();
    for (const auto& grain : grains)
      p.position.insert(p.position.end(), {grain.x() * soil.spacing, grain.y() * soil.spacing});
    for (auto* values : {&p.volume, &p.smoothing_length, &p.owner}) values->resize(grains.size());
    for (auto& field : from.fields) field.values.resize(grains.size() * static_cast<std::size_t>(field.components));
    yield(from);
    VecArray<2> scaled;
    for (const auto& place : places) scaled.push_back(place * soil.spacing);
    const auto inbox =
        coupling::make_mapping(2)->map(coupling::Role::solid, p, from.fields, specs, points_at(scaled, soil.spacing));
    const std::vector<double> before(places.size(), 0.0);
    return mapped_soil<2>(setup, inbox, inbox.asymmetry, before, std::vector<char>(places.size(), 0),
                          SeepageRegime{1000.0, 1.0, false})
        .mask;
  };
  const auto expect_volume = [&](const char* name, const VecArray<2>& grains, double least, double most) {
    for (const double x : {0.0, 0.25, 0.5})
      for (const double y : {0.1, 0.4}) {
        VecArray<2> water;
        for (int i = -6; i < 18; ++i)
          for (int j = -6; j < 18; ++j) water.push_back(Vec<2>(i + x, j + y));
        const auto mask = memberships(grains, water);
        const double counted = std::accumulate(mask.begin(), mask.end(), 0.0) / static_cast<double>(grains.size());
        EXPECT_GT(counted, least) << name << " at " << x << ", " << y;
        EXPECT_LT(counted, most) << name << " at " << x << ", " << y;
      }
  };
  // Too much soil makes the prediction unstable, too little only softer: of one or two grains the outermost part is
  // left out.
  expect_volume("one grain", {Vec<2>(0.0, 0.0)}, 0.4, 0.95);
  expect_volume("two that touch", {Vec<2>(0.0, 0.0), Vec<2>(1.0, 0.0)}, 0.3, 1.05);
  const auto lattice = [](int n, double distance, double disorder) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> shift(-disorder, disorder);
    VecArray<2> grains;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {
        const double dx = shift(random), dy = shift(random);
        grains.push_back(Vec<2>(i * distance + dx, j * distance + dy));
      }
    return grains;
  };
  expect_volume("grains apart", lattice(8, 1.42, 0.2), 0.85, 1.2);
  const auto body = lattice(10, 1.0, 0.3);
  expect_volume("a disordered body", body, 0.85, 1.05);
  VecArray<2> inside;
  for (double x = 2.0; x < 7.0; x += 0.37) inside.push_back(Vec<2>(x, 9.0 - x));
  for (const double mask : memberships(body, inside)) EXPECT_EQ(mask, 1.0);
  const VecArray<2> rows = {Vec<2>(4.3, 8.9), Vec<2>(4.3, 9.9)};  // on both sides of a flat edge
  const auto mask = memberships(lattice(10, 1.0, 0.0), rows);
  EXPECT_EQ(mask[0], 1.0);
  EXPECT_EQ(mask[1], 0.0);
}

TEST(SoilSurface, FullPoresTakeNoMoreWater) {
  // A particle of free water that has come a quarter of a spacing into soil, in the middle of its surface or at a wall:
  // in full pores it stays outside, and the soil is not counted twice. It comes in where a particle is missing.
  const Compressed soil;
  auto scene = soil.scene();
  scene.walls = {wall(line(0.0, 2.0, 0.0, 0.0)), wall(line(0.0, 0.0, soil.width, 0.0)),
                 wall(line(soil.width, 0.0, soil.width, 2.0))};
  const fluid::Setup<2> setup(scene, {});
  const Walls<2> walls(scene, {});
  const auto from = soil.publish(1);
  const auto specs = coupling::standard_fields(coupling::Role::solid, 2);
  struct Seen {
    bool full;
    double mask;
  };
  const auto seen = [&](const Vec<2>& place, std::span<const Vec<2>> missing) {
    Particles<2> water;
    const double cell = soil.spacing * soil.spacing;
    const auto add = [&](const Vec<2>& x, double mask) {
      water.add(x, Vec<2>::Zero(), 1000.0 * cell, 1.0, cell, 0.0, {});
      water.mask.back() = mask;
    };
    add(place, 0.0);
    for (std::size_t j = 0; j < from.points.n_active; ++j) {
      const Vec<2> x(from.points.position[2 * j], from.points.position[2 * j + 1]);
      if (std::ranges::none_of(missing, [&](const Vec<2>& m) { return (m - x).norm() < 1e-9; })) add(x, 1.0);
    }
    const auto inbox = coupling::make_mapping(2)->map(coupling::Role::solid, from.points, from.fields, specs,
                                                      points_at(water.position, soil.spacing));
    const auto full = find_full_pores<2>(setup, walls.planes, water, inbox.coverage);
    const auto view = mapped_soil<2>(setup, inbox, inbox.asymmetry, water.mask, full, {1000.0, 1e-3, false});
    return Seen{full[0] != 0, view.mask[0]};
  };
  const double top = soil.height - 0.5 * soil.spacing;
  for (const double x : {0.5, 1.0, 2.5, 3.0}) {  // spacings from a wall
    const Vec<2> place(x * soil.spacing, soil.height - 0.25 * soil.spacing);
    EXPECT_TRUE(seen(place, {}).full) << x;
    EXPECT_EQ(seen(place, {}).mask, 0.0) << x;
    VecArray<2> missing;
    for (const double column : {0.5, 2.5})
      if (std::abs(column - x) < 0.1) missing.push_back({column * soil.spacing, top});
    if (missing.empty()) continue;
    EXPECT_FALSE(seen(place, missing).full) << x;
    EXPECT_GT(seen(place, missing).mask, 0.9) << x;
  }
  // Dry soil takes water.
  EXPECT_FALSE(seen(Vec<2>(2.5, 3.5) * soil.spacing,
                    [&] {
                      VecArray<2> all;
                      for (std::size_t j = 0; j < from.points.n_active; ++j)
                        all.emplace_back(from.points.position[2 * j], from.points.position[2 * j + 1]);
                      return all;
                    }())
                   .full);
}

TEST(SoilSurface, PassesTheWaterOfSoilThatIsCompressed) {
  // n v + n_s s = 0 in the soil and v = 0 above, wherever the soil's surface stands among the rows of water. The
  // gradient of the excess pressure is gamma_w s / k. With the mean of both sides at the surface, the free water beside
  // it moves at more than 3 times the speed of the surface, and its level rises by 15 mm.
  Compressed soil;
  Case scene = soil.scene();
  scene.walls = {wall(line(0.0, 2.0, 0.0, 0.0)), wall(line(0.0, 0.0, soil.width, 0.0)),
                 wall(line(soil.width, 0.0, soil.width, 2.0))};
  Fluid<2> fluid(scene);
  const auto mapping = coupling::make_mapping(2);
  std::uint64_t step = 0;
  const auto inbox = [&] {
    const auto from = soil.publish(step + 1);
    return mapping->map(coupling::Role::solid, from.points, from.fields,
                        coupling::standard_fields(coupling::Role::solid, 2), fluid.publish().points);
  };
  fluid.initialise(inbox());
  const double slope = 9810.0 * soil.speed / (soil.conductivity * soil.height);
  double worst_pressure = 0.0, worst_speed = 0.0, highest = 0.0;
  for (; soil.time < 80.0; ++step) {
    const double dt = fluid.publish().proposed_interval;
    fluid.advance({step, soil.time, dt}, inbox());
    soil.time += dt;
    if (soil.time < 2.0) continue;
    const auto& p = fluid.state().particles;
    const double top = soil.top();
    double level = 0.0, above = 0.0;  // pressure of the free water
    for (std::size_t a = 0; a < p.size(); ++a)
      if (p.mask[a] == 0.0) {
        level += p.pressure[a];
        above += 1.0;
        worst_speed = std::max(worst_speed, p.velocity[a].norm());
      }
    level /= above;
    highest = std::max(highest, std::abs(level));
    for (std::size_t a = 0; a < p.size(); ++a) {
      const double y = p.position[a].y();
      if (y > top) continue;
      const double exact = slope / soil.stretch() * 0.5 * (top * top - y * y);
      worst_pressure = std::max(worst_pressure, std::abs(p.pressure[a] - level - exact));
    }
  }
  std::printf("pressure off by %.1f Pa, free water at most at %.2e m/s, its level off by %.1f mm, %d windows\n",
              worst_pressure, worst_speed, highest / 9.81, static_cast<int>(step));
  EXPECT_LT(worst_pressure, 0.2 * slope * soil.spacing);
  EXPECT_LT(worst_speed, 2.5 * soil.speed);  // while a row passes the edge
  EXPECT_LT(highest / 9810.0, 0.15 * soil.spacing);
}

}  // namespace
}  // namespace poretwin::fluid
