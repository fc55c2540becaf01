#include "pore_solver/output/gauges.hpp"

#include "common/geometry/extent.hpp"
#include "common/geometry/flat_section.hpp"
#include "common/geometry/pieces.hpp"
#include "common/geometry/shapes.hpp"
#include "common/media/retention_law.hpp"
#include "common/media/seepage.hpp"
#include "pore_solver/numerics/readings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace poretwin::pore {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Unit vector into the soil across a line on a face: in 2D to the line's left; in 3D from the border of the cells
/// beside the line to their points.
Point3 into_the_soil(const Case& scene, const Network& network, const Piece& line) {
  if (scene.general.dimension == 2) return line.left();
  Point3 inwards = Point3::Zero();
  for (const Segment& s : network.segments)
    if (distance_from(line, s.centre) < scene.fluid.particle_spacing)
      inwards += s.area * (network.position[s.point] - s.centre);
  const Point3 along = (line.b - line.a).normalized();
  inwards -= inwards.dot(along) * along;
  return inwards.isZero(0.0) ? inwards : inwards.normalized();
}

/// The way of a link from a to b; across a periodic side beside either point.
std::vector<std::pair<Point3, Point3>> ways_of(const Network& network, const Link& link) {
  const Point3 a = network.position[link.a], b = network.position[link.b];
  if (link.shift.isZero(0.0)) return {{a, b}};
  return {{a, b + link.shift}, {a - link.shift, b}};
}

}  // namespace

Gauges::Gauges(const Case& scene, const Network& network) : scene_(scene), network_(network) {
  const Probes probes(scene, network);
  for (const auto& gauge : scene.gauges) {
    Places p;
    if (gauge.kind == "point")
      for (const auto& x : gauge.points) p.points.push_back(probes.at(x));
    if (gauge.kind == "front") p.line = probes.along(gauge.points[0], gauge.points[1]);
    if (gauge.kind == "pressure_force") p.line = probes.along(gauge.points[0], gauge.points[1]);
    if (gauge.kind == "heave") {
      const Point3 up = -scene.general.gravity.normalized();
      double highest = -std::numeric_limits<double>::infinity();
      for (const auto& soil : scene.soils) highest = std::max(highest, extent(soil.shape, up, 2).second);
      for (const auto& x : places_along({gauge.points[0], gauge.points[1]}, 0.5 * scene.fluid.particle_spacing))
        p.above.push_back(probes.along(x, x + std::max(0.0, highest - up.dot(x)) * up));
    }
    if (gauge.kind == "discharge" && scene.general.dimension == 3 && !gauge.points.empty()) {
      const FlatSection section(gauge.points);
      for (std::size_t i = 0; i < network.links.size(); ++i) {
        const Link& link = network.links[i];
        for (const auto& [from, to] : ways_of(network, link))
          if (const double sign = section.crossed(from, to); sign != 0.0) p.crossings.push_back({i, sign});
      }
    } else if (gauge.kind == "discharge" && !gauge.points.empty()) {
      const Piece line{gauge.points[0], gauge.points[1]};
      for (std::size_t i = 0; i < network.links.size(); ++i) {
        for (const auto& [from, to] : ways_of(network, network.links[i])) {
          const Point3 way = to - from;
          const auto met = distance_to(line, from, way.normalized());
          if (met && *met < way.norm()) p.crossings.push_back({i, way.dot(line.left()) > 0.0 ? 1.0 : -1.0});
        }
      }
    }
    if (gauge.kind == "exit_height") {
      const Piece line{gauge.points[0], gauge.points[1]};
      const Point3 normal = into_the_soil(scene, network, line);
      for (std::size_t i = 0; i < 2; ++i) {
        const Point3 inwards =
            (1.0 + static_cast<double>(i)) * readings::exit_depth * scene.fluid.particle_spacing * normal;
        p.beside[i] = probes.along(line.a + inwards, line.b + inwards);
      }
    }
    if (gauge.kind == "exit_gradient") {
      const Piece line{gauge.points[0], gauge.points[1]};
      constexpr double beside = 1e-3;  // spacings
      for (std::size_t i = 0; i < network.segments.size(); ++i)
        if (distance_from(line, network.segments[i].centre) < beside * scene.fluid.particle_spacing)
          p.segments.push_back(i);
    }
    places_.push_back(std::move(p));
  }
}

class Gauges::Reader {
 public:
  Reader(const Gauges& gauges, const FlowModel& flow, const Stepper& stepper, const State& state)
      : scene_(gauges.scene_), network_(gauges.network_), flow_(flow), stepper_(stepper), state_(state) {}

  void read(const Gauge& gauge, const Places& places) {
    if (gauge.kind == "point") return points(gauge, places);
    if (gauge.kind == "front") return add(gauge.name, front(gauge, places.line), "m");
    if (gauge.kind == "discharge") return add(gauge.name, discharge(gauge, places), volume_unit() + "/s");
    if (gauge.kind == "exit_height") return add(gauge.name, exit_height(gauge, places), "m");
    if (gauge.kind == "exit_gradient") return exit_gradient(gauge, places);
    if (gauge.kind == "pressure_force") return pressure_force(gauge.name, places.line);
    if (gauge.kind == "heave") return add(gauge.name, heave(places), "1");
    if (gauge.kind == "volume") return add(gauge.name, volume(gauge), volume_unit());
    if (gauge.kind == "balance") return balance(gauge);
    if (gauge.kind == "level") return add(gauge.name, level(gauge), "m");
    if (gauge.kind == "basin") return basin(gauge);
    if (gauge.kind == "particles") return add(gauge.name, static_cast<double>(network_.size()), "1");
    const auto through_faces = [](const Account& a) { return a.in - a.out; };
    if (gauge.kind == "passed_volume") {
      const bool of_well =
          !gauge.quantity.empty() && std::any_of(scene_.wells.begin(), scene_.wells.end(),
                                                 [&](const Well& well) { return well.name == gauge.quantity; });
      return add(gauge.name,
                 of_well ? sum(gauge, scene_.wells, &Stepper::Along::well, through_faces)
                         : sum(gauge, scene_.water_faces, &Stepper::Along::face, through_faces),
                 volume_unit());
    }
    const auto of_rain = [&](auto part) {
      add(gauge.name, sum(gauge, scene_.rains, &Stepper::Along::rain, part), volume_unit());
    };
    if (gauge.kind == "infiltration") of_rain([](const Account& a) { return a.infiltration; });
    if (gauge.kind == "evaporation") of_rain([](const Account& a) { return a.evaporation; });
    if (gauge.kind == "runoff") of_rain([](const Account& a) { return a.runoff; });
  }
  [[nodiscard]] std::vector<GaugeReading> take() { return std::move(readings_); }

 private:
  [[nodiscard]] std::string volume_unit() const { return scene_.general.dimension == 3 ? "m3" : "m2"; }
  void add(std::string name, double value, std::string unit) {
    readings_.push_back({std::move(name), value, std::move(unit)});
  }
  [[nodiscard]] double head(const Probe& probe) const {
    return probe.of([&](Index a) { return flow_.pressure_head(a); });
  }
  [[nodiscard]] double degree(Index a) const { return saturation(state_, a); }
  [[nodiscard]] double degree_of_saturation(Index a) const {
    const double initial = scene_.soils[network_.soil[a]].initial_saturation;
    return initial + (1.0 - initial) * degree(a);
  }

  void points(const Gauge& gauge, const Places& places) {
    const Point3 up = -scene_.general.gravity.normalized();
    for (std::size_t i = 0; i < places.points.size(); ++i) {
      const auto& probe = places.points[i];
      const std::string name = gauge.points.size() > 1 ? fmt::format("{}[{}]", gauge.name, i) : gauge.name;
      const double psi = probe ? head(*probe) : nan;
      if (gauge.quantity == "pressure_head") add(name, psi, "m");
      if (gauge.quantity == "head") add(name, psi + up.dot(gauge.points[i]), "m");
      if (gauge.quantity == "pore_pressure") add(name, porous::specific_weight(scene_) * psi, "Pa");
      const auto borne = [&](Index a) { return porous::specific_weight(scene_) * flow_.borne_head(a).value; };
      if (gauge.quantity == "borne_pressure") add(name, probe ? probe->of(borne) : nan, "Pa");
      if (gauge.quantity == "degree_of_saturation")
        add(name, probe ? std::clamp(probe->of([&](Index a) { return degree_of_saturation(a); }), 0.0, 1.0) : nan, "1");
      if (gauge.quantity == "water_content")
        add(name, probe ? probe->of([&](Index a) { return state_.water[a] / network_.volume[a]; }) : nan, "1");
    }
  }

  /// Distance [m] from the line's start at which the pressure head falls to the value that the gauge names. In soil
  /// without capillarity, the length full of water (partly full cells in proportion) is also computed, and the larger
  /// distance is taken: the pressure shows the position of a water table, the saturation that of a front, and each of
  /// them is too short rather than too long.
  [[nodiscard]] double front(const Gauge& gauge, const ProbeLine& line) const {
    if (line.place.empty()) return 0.0;
    const double by_pressure = where_head_ends(line, gauge.pressure_head);
    const bool sharp = porous::retention_law(scene_.soils.front()).curve == nullptr;
    return sharp ? std::max(by_pressure, full_length(line)) : by_pressure;
  }
  [[nodiscard]] double where_head_ends(const ProbeLine& line, double least) const {
    double before = head(line.probe.front());
    if (before < least) return line.place.front();
    for (std::size_t i = 1; i < line.place.size(); ++i) {
      const double now = head(line.probe[i]);
      if (now < least)
        return line.place[i - 1] + (line.place[i] - line.place[i - 1]) * (before - least) / (before - now);
      before = now;
    }
    return line.place.back();
  }
  [[nodiscard]] double full_length(const ProbeLine& line) const {
    double full = line.place.front(), before = 1.0;
    for (std::size_t i = 0; i < line.place.size(); ++i) {
      const double share = std::clamp(line.probe[i].of([&](Index a) { return degree(a); }), 0.0, 1.0);
      if (i > 0) full += 0.5 * (before + share) * (line.place[i] - line.place[i - 1]);
      if (share == 0.0) return full;
      before = share;
    }
    // Where water leaves a slope, the last cell never fills up to its highest corner: it counts as full if half full.
    return degree(line.probe.back().point[0]) >= 0.5 ? line.place.back() : full;
  }

  /// Discharge through the gauge's line, or the inflow through the face (or from the well) that the gauge names.
  [[nodiscard]] double discharge(const Gauge& gauge, const Places& places) const {
    double sum = 0.0;
    for (const auto& crossing : places.crossings) sum += crossing.sign * state_.flow[crossing.link];
    for (std::size_t i = 0; gauge.points.empty() && i < network_.segments.size(); ++i) {
      const std::size_t face = network_.segments[i].face, well = network_.segments[i].well;
      if (face != Segment::none && scene_.water_faces[face].name == gauge.quantity) sum += state_.inflow[i];
      if (well != Segment::none && scene_.wells[well].name == gauge.quantity) sum -= state_.inflow[i];
    }
    return sum;
  }

  /// Elevation [m] at which the water table meets a face. Near that point, the depth of the water table below the face
  /// grows with the distance to the power of 3/2, as for any free surface that ends at a seepage face. The point is
  /// extrapolated from the distances at two depths.
  [[nodiscard]] double exit_height(const Gauge& gauge, const Places& places) const {
    const Point3 up = -scene_.general.gravity.normalized();
    std::array<double, 2> at{};
    for (std::size_t i = 0; i < 2; ++i) {
      const ProbeLine& line = places.beside[i];
      // Searched for from above: the first place with positive pressure.
      const bool rises = up.dot(gauge.points[1] - gauge.points[0]) > 0.0;
      double before = nan;
      at[i] = nan;
      for (std::size_t j = 0; j < line.place.size() && std::isnan(at[i]); ++j) {
        const std::size_t k = rises ? line.place.size() - 1 - j : j;
        const double now = head(line.probe[k]);
        if (now >= 0.0 && before < 0.0) {
          const std::size_t last = rises ? k + 1 : k - 1;
          at[i] = line.place[k] + (line.place[last] - line.place[k]) * now / (now - before);
        }
        before = now;
      }
    }
    const double ratio = std::cbrt(4.0);  // ratio of the distances at twice a depth and at that depth
    const double place = at[0] - (at[1] - at[0]) / (ratio - 1.0);
    return up.dot(gauge.points[0] + place * (gauge.points[1] - gauge.points[0]).normalized());
  }
  /// Largest outward flow per area, divided by the saturated conductivity, and its place along the line [m]. Where the
  /// face looks upwards, also the largest ratio of that gradient to the one that lifts the grains. On a face inclined
  /// by the angle b, the part cos b of the buoyant weight acts across the face.
  void exit_gradient(const Gauge& gauge, const Places& places) {
    double largest = nan, at = nan, over_critical = nan;
    const Piece line{gauge.points[0], gauge.points[1]};
    const double upwards = scene_.general.gravity.normalized().dot(line.left());
    for (const std::size_t i : places.segments) {
      if (!(state_.inflow[i] < 0.0)) continue;
      const Segment& s = network_.segments[i];
      const Soil& soil = scene_.soils[network_.soil[s.point]];
      const double conductivity = s.across * porous::seepage_at(scene_, soil, soil.porosity).conductivity;
      const double gradient = -state_.inflow[i] / s.area / conductivity;
      over_critical = std::fmax(over_critical, gradient / (porous::critical_gradient(scene_, soil) * upwards));
      if (gradient <= largest) continue;
      largest = gradient;
      at = (s.centre - line.a).dot((line.b - line.a).normalized());
    }
    add(gauge.name, largest, "1");
    add(gauge.name + "_at", at, "m");
    if (upwards > 1e-9) add(gauge.name + "_over_critical", over_critical, "1");
  }

  /// Force of the water's pressure on a line, per width [N/m], and the distance of its line of action from the line's
  /// start. The pressure is linear between the places of the line; places outside the soil do not count.
  void pressure_force(const std::string& name, const ProbeLine& line) {
    double force = 0.0, moment = 0.0;
    for (std::size_t i = 1; i < line.place.size(); ++i) {
      const double from = line.place[i - 1], to = line.place[i];
      if (to - from > 1.5 * line.step) continue;
      const auto pressure = [&](std::size_t k) {
        return porous::specific_weight(scene_) * std::max(0.0, head(line.probe[k]));
      };
      const double part = 0.5 * (pressure(i - 1) + pressure(i)) * (to - from);
      force += part;
      moment += 0.5 * (from + to) * part;
    }
    add(name, force, "N/m");
    add(name + "_at", force > 0.0 ? moment / force : 0.5 * line.length, "m");
  }

  /// Weight of the soil, and of the water in and on it, above the start of a line that leads upwards [Pa]; 0 where no
  /// soil is above it.
  [[nodiscard]] double overburden(const ProbeLine& line) const {
    double weight = 0.0;
    const auto bulk = [&](const Probe& probe) {
      const Soil& soil = scene_.soils[network_.soil[probe.point[0]]];
      const double wet = std::clamp(probe.of([&](Index a) { return degree_of_saturation(a); }), 0.0, 1.0);
      return (1.0 - soil.porosity) * soil.grain_density / scene_.water.density + soil.porosity * wet;
    };
    std::size_t last = 0;
    for (; last + 1 < line.place.size() && line.place[last + 1] - line.place[last] < 1.5 * line.step; ++last)
      weight += 0.5 * (bulk(line.probe[last]) + bulk(line.probe[last + 1])) * line.step;
    if (last == 0) return 0.0;
    return porous::specific_weight(scene_) * (weight + std::max(0.0, head(line.probe[last])));
  }

  /// Ratio of the water's pressure on a line to the weight above the line, both summed over the places with soil above.
  [[nodiscard]] double heave(const Places& places) const {
    double pushed = 0.0, weight = 0.0;
    for (const auto& line : places.above) {
      const double above = overburden(line);
      if (!(above > 0.0) || line.place.front() > 0.0) continue;
      weight += above;
      pushed += porous::specific_weight(scene_) * std::max(0.0, head(line.probe.front()));
    }
    return weight > 0.0 ? pushed / weight : nan;
  }

  [[nodiscard]] double volume(const Gauge& gauge) const {
    double sum = 0.0;
    for (std::size_t a = 0; a < network_.size(); ++a)
      if (!gauge.region || contains(*gauge.region, network_.position[a], scene_.general.dimension))
        sum += state_.water[a];
    return sum;
  }

  void balance(const Gauge& gauge) {
    Account all;
    double gained = 0.0;
    for (const auto& account : state_.accounts) {
      all.in += account.in + account.infiltration;
      all.out += account.out + account.evaporation;
      gained += account.gained();
    }
    const double stored = volume({});
    add(gauge.name + "_in", all.in, volume_unit());
    add(gauge.name + "_out", all.out, volume_unit());
    add(gauge.name + "_stored", stored, volume_unit());
    add(gauge.name + "_error", gained - (stored - state_.initial_water), volume_unit());
  }

  [[nodiscard]] double level(const Gauge& gauge) const {
    for (const auto& face : scene_.water_faces)
      if (face.name == gauge.quantity && face.head && !face.basin_area) return face.head->at(state_.time);
    for (const auto& well : scene_.wells)
      if (well.name == gauge.quantity && well.head) return well.head->at(state_.time);
    const auto k = own_level(gauge);
    return k ? state_.level[*k] : nan;
  }
  /// Index in State::level of the basin or well that the gauge names; empty if there is none.
  [[nodiscard]] std::optional<std::size_t> own_level(const Gauge& gauge) const {
    const auto& all = stepper_.boundaries();
    for (std::size_t b = 0; b < all.size(); ++b) {
      const std::size_t face = all[b].face, well = all[b].well;
      if ((face != Segment::none && scene_.water_faces[face].name == gauge.quantity) ||
          (well != Segment::none && scene_.wells[well].name == gauge.quantity))
        return stepper_.level_of(b);
    }
    return std::nullopt;
  }

  /// Volumes of a basin's water.
  void basin(const Gauge& gauge) {
    const auto k = own_level(gauge);
    if (!k) return;
    const BasinWater& water = state_.basin[*k];
    const double seeped = sum(gauge, scene_.water_faces, &Stepper::Along::face,
                              [](const Account& account) { return account.in - account.out; });
    const double gained = water.in - water.out - water.spilled - seeped;
    add(gauge.name + "_stored", water.stored, volume_unit());
    add(gauge.name + "_in", water.in, volume_unit());
    add(gauge.name + "_out", water.out, volume_unit());
    add(gauge.name + "_spilled", water.spilled, volume_unit());
    add(gauge.name + "_seeped", seeped, volume_unit());
    add(gauge.name + "_error", gained - (water.stored - water.first), volume_unit());
  }

  /// Sum of one entry of the accounts, over the boundaries with the item that the gauge names, or over all boundaries.
  template <class Items, class Part>
  [[nodiscard]] double sum(const Gauge& gauge, const Items& items, std::size_t Stepper::Along::*item,
                           const Part& part) const {
    double total = 0.0;
    for (std::size_t b = 0; b < state_.accounts.size(); ++b) {
      const std::size_t i = stepper_.boundaries()[b].*item;
      if (gauge.quantity.empty() || (i != Segment::none && items[i].name == gauge.quantity))
        total += part(state_.accounts[b]);
    }
    return total;
  }

  const Case& scene_;
  const Network& network_;
  const FlowModel& flow_;
  const Stepper& stepper_;
  const State& state_;
  std::vector<GaugeReading> readings_;
};

std::vector<GaugeReading> Gauges::read(const FlowModel& flow, const Stepper& stepper, const State& state) const {
  Reader reader(*this, flow, stepper, state);
  for (std::size_t i = 0; i < scene_.gauges.size(); ++i) reader.read(scene_.gauges[i], places_[i]);
  return reader.take();
}

}  // namespace poretwin::pore
