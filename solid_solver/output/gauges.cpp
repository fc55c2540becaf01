#include "solid_solver/output/gauges.hpp"

#include "common/core/error.hpp"
#include "solid_solver/dynamics/plate_motion.hpp"
#include "solid_solver/output/deposit.hpp"
#include "solid_solver/output/probe.hpp"
#include "solid_solver/output/readout.hpp"
#include "solid_solver/output/slip_surface.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <string_view>

namespace poretwin::solid {
namespace {

constexpr std::array<std::string_view, 6> tensor_components{"xx", "yy", "zz", "xy", "yz", "xz"};
constexpr std::array<std::string_view, 3> axes{"x", "y", "z"};

/// Index of the component named after `prefix` in `quantity`; empty if there is no such name.
template <std::size_t N>
std::optional<int> component(std::string_view quantity, std::string_view prefix,
                             const std::array<std::string_view, N>& names) {
  if (!quantity.starts_with(prefix)) return std::nullopt;
  quantity.remove_prefix(prefix.size());
  for (std::size_t k = 0; k < N; ++k)
    if (quantity == names[k]) return static_cast<int>(k);
  return std::nullopt;
}

template <int D>
bool within(const Gauge& gauge, const Vec<D>& x) {
  Point3 point = Point3::Zero();
  point.head<D>() = x;
  return !gauge.region || contains(*gauge.region, point, D);
}

/// Mean settlement [m] since the initial rest of the particles at the crest: those that were then in the gauge's
/// region, within half a spacing of the highest of them; NaN if there are none.
template <int D>
double crest_settlement(const Gauge& gauge, const Setup<D>& setup, const State<D>& state) {
  const auto& p = state.particles;
  const Vec<D> up = upwards(setup);
  double crest = -std::numeric_limits<double>::infinity();
  for (const bool summing : {false, true}) {
    double sum = 0.0, count = 0.0;
    for (std::size_t i = 0; i < p.free(); ++i) {
      const Vec<D> since = p.displacement[i] - state.rest_displacement[i];
      const Vec<D> before = p.position[i] - since;
      if (!within<D>(gauge, before)) continue;
      const double level = up.dot(before);
      if (!summing) {
        crest = std::max(crest, level);
      } else if (level > crest - 0.5 * setup.spacing) {
        sum -= up.dot(since);
        count += 1.0;
      }
    }
    if (summing) return count > 0.0 ? sum / count : std::numeric_limits<double>::quiet_NaN();
  }
  return 0.0;
}

/// Length [m] of the parts of a plate that have not come off.
template <int D>
double touching(const PlateSetup<D>& plate, const PlateMotion<D>& motion) {
  if (motion.apart.empty()) return 2.0 * plate.half;
  const auto parts = static_cast<double>(motion.apart.size());
  return 2.0 * plate.half / parts * static_cast<double>(std::ranges::count(motion.apart, char{0}));
}

template <int D>
GaugeReading read_point(const Gauge& gauge, const std::string& name, const Point3& at, const Setup<D>& setup,
                        const State<D>& state) {
  const auto& p = state.particles;
  const Vec<D> x = at.head<D>();
  const std::string_view q = gauge.quantity;
  using Value = std::function<double(std::size_t, const Mat<D>&)>;
  auto reading = [&](Reach reach, const Value& value, std::string unit) {
    return GaugeReading{name, probe<D>(setup, state, x, reach, value), std::move(unit)};
  };
  auto vector_component = [&](const VecArray<D>& values, int k, std::string unit) {
    if (k >= D) return GaugeReading{name, 0.0, std::move(unit)};
    return reading(
        Reach::motion, [&values, k](std::size_t i, const Mat<D>& map) { return map.row(k).dot(values[i]); },
        std::move(unit));
  };
  if (const auto k = component(q, "displacement_", axes)) return vector_component(p.displacement, *k, "m");
  if (const auto k = component(q, "velocity_", axes)) return vector_component(p.velocity, *k, "m/s");
  if (const auto k = component(q, "effective_stress_", tensor_components))
    return reading(
        Reach::material, [&p, k](std::size_t i, const Mat<D>&) { return p.stress[i][*k]; }, "Pa");
  if (const auto k = component(q, "total_stress_", tensor_components))
    return reading(
        Reach::material,
        [&, k](std::size_t i, const Mat<D>&) { return p.stress[i][*k] - (*k < 3 ? state.external.pressure[i] : 0.0); },
        "Pa");
  if (q == "pore_pressure")
    return reading(
        Reach::material, [&](std::size_t i, const Mat<D>&) { return state.external.pressure[i]; }, "Pa");
  if (q == "mobilised_friction")
    return reading(
        Reach::material, [&p](std::size_t i, const Mat<D>&) { return mobilised_friction(p.stress[i]); }, "degrees");
  if (q == "pore_pressure_ratio") {
    const Vec<D> up = upwards(setup);
    return reading(
        Reach::material,
        [&, up](std::size_t i, const Mat<D>&) {
          return pore_pressure_ratio(state.external.pressure[i], up.dot(matrix_of<D>(p.stress[i]) * up));
        },
        "1");
  }
  if (q == "void_fraction")
    return reading(
        Reach::material, [&](std::size_t i, const Mat<D>&) { return void_fraction(setup, p, i); }, "1");
  if (q == "accumulated_plastic_strain")
    return reading(
        Reach::material, [&p](std::size_t i, const Mat<D>&) { return p.plastic_strain[i]; }, "1");
  throw CaseError(
      fmt::format("gauge \"{}\": quantity \"{}\" is not known to the solid; expected displacement_x, velocity_x, "
                  "effective_stress_xx, "
                  "total_stress_xx (or another component), pore_pressure, pore_pressure_ratio, mobilised_friction, "
                  "void_fraction or accumulated_plastic_strain",
                  gauge.name, gauge.quantity));
}

}  // namespace

template <int D>
std::vector<GaugeReading> read_gauges(const Setup<D>& setup, const State<D>& state) {
  std::vector<GaugeReading> readings;
  const auto& p = state.particles;
  for (const auto& gauge : setup.gauges) {
    if (gauge.phase != "solid" || gauge.kind == "factor_of_safety") continue;
    if (gauge.kind == "point" || gauge.kind == "height") {
      for (std::size_t k = 0; k < gauge.points.size(); ++k) {
        const std::string name = gauge.points.size() == 1 ? gauge.name : fmt::format("{}[{}]", gauge.name, k);
        if (gauge.kind == "point")
          readings.push_back(read_point<D>(gauge, name, gauge.points[k], setup, state));
        else
          readings.push_back({name, surface_height<D>(setup, state, gauge.points[k].template head<D>()), "m"});
      }
      continue;
    }
    if (gauge.kind == "front") {
      readings.push_back({gauge.name,
                          front_position<D>(setup, state, gauge.points[0].template head<D>(),
                                            gauge.points[1].template head<D>(), gauge.thickness),
                          "m"});
      continue;
    }
    if (gauge.kind == "slip_surface") {
      readings.push_back({gauge.name, weakest_link<D>(setup, state, gauge.points), "1"});
      continue;
    }
    if (gauge.kind == "stress_noise") {
      readings.push_back({gauge.name, stress_noise<D>(setup, state), "Pa"});
      continue;
    }
    if (gauge.kind == "plate") {
      for (std::size_t k = 0; k < setup.plates.size(); ++k) {
        const PlateSetup<D>& plate = setup.plates[k];
        if (plate.name != gauge.quantity) continue;
        const PlateMotion<D>& motion = p.plates[k];
        readings.push_back({gauge.name, pressing(setup, state, k), D == 2 ? "N/m" : "N"});
        if constexpr (D == 2) readings.push_back({gauge.name + "_along", -plate.along.dot(motion.reaction), "N/m"});
        readings.push_back({gauge.name + "_displacement", plate.normal.dot(motion.displacement), "m"});
        if (!plate.tilts) continue;
        readings.push_back({gauge.name + "_moment", motion.water_moment - motion.moment, "N m/m"});
        readings.push_back({gauge.name + "_rotation", motion.angle, "rad"});
        if (plate.lifts) readings.push_back({gauge.name + "_touching", touching(plate, motion), "m"});
      }
      continue;
    }
    if (gauge.kind == "density_error") {
      readings.push_back({gauge.name, density_error<D>(setup, state), "1"});
      continue;
    }
    if (gauge.kind == "crest_level") {
      const auto counts = [&](const Vec<D>& x) { return within<D>(gauge, x); };
      readings.push_back({gauge.name, crest_level<D>(setup, state, counts), "m"});
      continue;
    }
    Vec<D> momentum = Vec<D>::Zero(), pending = Vec<D>::Zero();
    double kinetic = 0.0, potential = 0.0, stored = 0.0, grains = 0.0, count = 0.0, plastic = 0.0, speed = 0.0,
           displacement = 0.0, uplift = 0.0;
    const Vec<D> up = upwards(setup);
    for (std::size_t i = 0; i < p.free(); ++i) {
      if (!within<D>(gauge, p.position[i])) continue;
      momentum += p.mass[i] * p.velocity[i];
      pending += state.returned_impulse[i];
      kinetic += 0.5 * p.mass[i] * p.velocity[i].squaredNorm();
      potential -= p.mass[i] * setup.gravity.dot(p.position[i]);
      stored += p.volume[i] * strain_energy(p.stress[i], moduli(setup, p, i));
      grains += p.mass[i] / setup.grain_density[p.material[i]] * setup.grain_share[p.material[i]];
      count += 1.0;
      plastic = std::max(plastic, p.plastic_strain[i]);
      speed = std::max(speed, p.velocity[i].norm());
      displacement = std::max(displacement, p.displacement[i].norm());
      uplift = std::max(uplift, up.dot(p.displacement[i] - state.rest_displacement[i]));
    }
    const std::string per = D == 2 ? "/m" : "";
    if (gauge.kind == "momentum" || gauge.kind == "pending_impulse" || gauge.kind == "received_impulse" ||
        gauge.kind == "unexplained_impulse") {
      const Vec<D> received = state.received + pending;
      const Vec<D> sum = gauge.kind == "momentum"           ? momentum
                         : gauge.kind == "pending_impulse"  ? pending
                         : gauge.kind == "received_impulse" ? received
                                                            : Vec<D>(momentum - received - state.from_outside);
      for (int d = 0; d < D; ++d)
        if (gauge.reads_component(d))
          readings.push_back(
              {fmt::format("{}_{}", gauge.name, axes[static_cast<std::size_t>(d)]), sum[d], "N s" + per});
    } else if (gauge.kind == "kinetic_energy") {
      readings.push_back({gauge.name, kinetic, "J" + per});
    } else if (gauge.kind == "energy") {
      readings.push_back({gauge.name, kinetic + potential + stored, "J" + per});
    } else if (gauge.kind == "strain_energy") {
      readings.push_back({gauge.name, stored, "J" + per});
    } else if (gauge.kind == "grain_volume") {
      readings.push_back({gauge.name, grains, D == 2 ? "m2" : "m3"});
    } else if (gauge.kind == "carried_off") {
      readings.push_back({gauge.name, state.erosion.grains, D == 2 ? "m2" : "m3"});
    } else if (gauge.kind == "crest_settlement") {
      readings.push_back({gauge.name, crest_settlement<D>(gauge, setup, state), "m"});
    } else if (gauge.kind == "particles") {
      readings.push_back({gauge.name, count, "1"});
    } else if (gauge.kind == "max_speed") {
      readings.push_back({gauge.name, speed, "m/s"});
    } else if (gauge.kind == "max_displacement") {
      readings.push_back({gauge.name, displacement, "m"});
    } else if (gauge.kind == "max_plastic_strain") {
      readings.push_back({gauge.name, plastic, "1"});
    } else if (gauge.kind == "uplift") {
      readings.push_back({gauge.name, uplift, "m"});
    } else {
      throw CaseError(fmt::format("gauge \"{}\": kind \"{}\" is not known to the solid", gauge.name, gauge.kind));
    }
  }
  return readings;
}

template std::vector<GaugeReading> read_gauges<2>(const Setup<2>&, const State<2>&);
template std::vector<GaugeReading> read_gauges<3>(const Setup<3>&, const State<3>&);

}  // namespace poretwin::solid
