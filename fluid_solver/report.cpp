// What the fluid shows of itself: output frames, gauges, counters.
#include "fluid_solver/fluid_phase.hpp"

#include "fluid_solver/cloud.hpp"

#include <fmt/format.h>

namespace poretwin::fluid {

template <int D>
OutputFrame Fluid<D>::frame() const {
  const auto& p = state_.particles;
  OutputFrame out;
  out.time = state_.time;
  const auto three = [](const VecArray<D>& from) {
    std::vector<double> values(3 * from.size(), 0.0);
    for (std::size_t a = 0; a < from.size(); ++a)
      for (std::size_t d = 0; d < D; ++d) values[3 * a + d] = from[a][static_cast<int>(d)];
    return values;
  };
  out.position = three(p.position);
  ScalarArray pressure(p.size()), flag(p.size());
  VecArray<D> relative(p.size());
  for (std::size_t a = 0; a < p.size(); ++a) {
    pressure[a] = p.pressure[a] + weight_.dot(p.position[a] - origin_);
    flag[a] = p.surface[a] == Surface::interior ? 0.0 : 1.0;
    relative[a] =
        p.mask[a] > 0.0 ? Vec<D>(p.void_fraction[a] * (p.velocity[a] - p.solid_velocity[a])) : Vec<D>(Vec<D>::Zero());
  }
  out.fields = {
      {"velocity", "m/s", "velocity of the water between the grains (intrinsic)", 3, three(p.velocity)},
      {"pore_pressure", "Pa", "total pressure of the water", 1, pressure},
      {"void_fraction", "1", "n_w, water's share of the volume where saturated; 1 in free water", 1, p.void_fraction},
      {"relative_flux", "m/s", "n (v_w - v_s), the discharge through the skeleton; zero in free water", 3,
       three(relative)},
      {"surface", "1", "1 on the free surface", 1, flag},
  };
  return out;
}

template <int D>
std::vector<GaugeReading> Fluid<D>::gauges() const {
  const auto& p = state_.particles;
  std::vector<GaugeReading> readings;
  const bool any =
      std::any_of(scene_.gauges.begin(), scene_.gauges.end(), [](const Gauge& g) { return g.phase == "fluid"; });
  if (!any) return readings;
  const auto cloud = make_cloud<D>(state_, planes_, weight_, origin_);
  const char* axes[3] = {"_x", "_y", "_z"};
  for (const auto& gauge : scene_.gauges) {
    if (gauge.phase != "fluid") continue;
    const auto inside = [&](std::size_t a) {
      return !gauge.region || contains(*gauge.region, to_point3<D>(p.position[a]), D);
    };
    if (gauge.kind == "point") {
      for (std::size_t i = 0; i < gauge.points.size(); ++i) {
        const Vec<D> x = gauge.points[i].template head<D>();
        const std::string name = gauge.points.size() > 1 ? fmt::format("{}[{}]", gauge.name, i) : gauge.name;
        if (gauge.quantity == "pore_pressure") {
          readings.push_back({name, interpolate(cloud, x, [&](std::size_t j) { return cloud.pressure[j]; }), "Pa"});
          continue;
        }
        for (int d = 0; d < D; ++d) {
          const std::string component = std::string("velocity") + axes[d];
          if (gauge.quantity != "velocity" && gauge.quantity != component) continue;
          readings.push_back({gauge.quantity == "velocity" ? name + axes[d] : name,
                              interpolate(cloud, x, [&](std::size_t j) { return cloud.velocity[j][d]; }), "m/s"});
        }
      }
    } else if (gauge.kind == "front") {
      const Vec<D> a = gauge.points[0].template head<D>(), b = gauge.points[1].template head<D>();
      const double length = (b - a).norm(), step = 0.1 * dx_;
      double before = saturation<D>(cloud, a), front = before < 0.5 ? 0.0 : length;
      for (double z = step; before >= 0.5 && z <= length; z += step) {
        const double now = saturation<D>(cloud, Vec<D>(a + z / length * (b - a)));
        if (now < 0.5) {
          front = z - step * (0.5 - now) / (before - now);
          break;
        }
        before = now;
      }
      readings.push_back({gauge.name, front, "m"});
    } else if (gauge.kind == "volume") {
      double volume = 0.0;
      for (std::size_t a = 0; a < p.size(); ++a)
        if (inside(a)) volume += p.mass[a] / density_;
      // The outermost particle of a column stands half a spacing either way: what of it lies outside the face is no
      // water here.
      for (const auto& c : state_.columns)
        if (!gauge.region || contains(*gauge.region, to_point3<D>(Vec<D>(c.foot + 1e-6 * c.spacing * c.normal)), D))
          volume += c.share(density_);
      readings.push_back({gauge.name, volume, D == 2 ? "m2" : "m3"});
    } else if (gauge.kind == "momentum") {
      Vec<D> sum = Vec<D>::Zero();
      for (std::size_t a = 0; a < p.size(); ++a)
        if (inside(a)) sum += p.mass[a] * p.velocity[a] - p.owed[a];
      for (int d = 0; d < D; ++d) readings.push_back({gauge.name + axes[d], sum[d], "N s"});
    } else if (gauge.kind == "kinetic_energy" || gauge.kind == "potential_energy" || gauge.kind == "energy") {
      const double kinetic = gauge.kind == "potential_energy" ? 0.0 : 0.5;
      const double potential = gauge.kind == "kinetic_energy" ? 0.0 : 1.0;
      const Vec<D> gravity = scene_.general.gravity.head<D>();
      double sum = 0.0;
      for (std::size_t a = 0; a < p.size(); ++a)
        if (inside(a))
          sum += p.mass[a] * (kinetic * p.velocity[a].squaredNorm() +
                              potential * (0.5 * scene_.general.central_force * p.position[a].squaredNorm() -
                                           gravity.dot(p.position[a])));
      readings.push_back({gauge.name, sum, "J"});
    } else if (gauge.kind == "extent") {
      const Vec<D> from = gauge.points[0].template head<D>();
      const Vec<D> along = (gauge.points[1].template head<D>() - from).normalized();
      double furthest = std::numeric_limits<double>::quiet_NaN();
      for (std::size_t a = 0; a < p.size(); ++a)
        if (inside(a))
          furthest = std::fmax(furthest, along.dot(p.position[a] - from) + 0.5 * std::pow(p.volume[a], 1.0 / D));
      readings.push_back({gauge.name, furthest, "m"});
    } else if (gauge.kind == "spread") {
      const Vec<D> along = (gauge.points[1] - gauge.points[0]).template head<D>().normalized();
      double mass = 0.0, first = 0.0, second = 0.0;
      for (std::size_t a = 0; a < p.size(); ++a)
        if (inside(a)) {
          const double s = along.dot(p.position[a]);
          mass += p.mass[a];
          first += p.mass[a] * s;
          second += p.mass[a] * s * s;
        }
      readings.push_back({gauge.name, std::sqrt(std::max(0.0, second / mass - first * first / (mass * mass))), "m"});
    } else if (gauge.kind == "particles") {
      double count = 0.0;
      for (std::size_t a = 0; a < p.size(); ++a) count += inside(a) ? 1.0 : 0.0;
      readings.push_back({gauge.name, count, "1"});
    } else if (gauge.kind == "level" || gauge.kind == "passed_volume") {
      const auto through = passed();
      double sum = 0.0, level = 0.0;
      for (std::size_t f = 0; f < scene_.water_faces.size(); ++f) {
        const auto& face = scene_.water_faces[f];
        if (!gauge.quantity.empty() && face.name != gauge.quantity) continue;
        sum += through[f];
        if (gauge.kind == "level") level = face.discharge ? state_.basin_level[f] : face.head->at(state_.time);
      }
      if (gauge.kind == "level")
        readings.push_back({gauge.name, level, "m"});
      else
        readings.push_back({gauge.name, sum, D == 2 ? "m2" : "m3"});
    } else if (gauge.kind == "max_speed") {
      double fastest = 0.0;
      for (std::size_t a = 0; a < p.size(); ++a)
        if (inside(a)) fastest = std::max(fastest, p.velocity[a].norm());
      readings.push_back({gauge.name, fastest, "m/s"});
    }
  }
  return readings;
}

template <int D>
std::map<std::string, double> Fluid<D>::counters() const {
  const auto& c = state_.counts;
  return {{"particles", static_cast<double>(state_.particles.size())},
          {"windows", c.windows},
          {"pressure iterations", c.pressure_iterations},
          {"multigrid cycles", c.multigrid_cycles},
          {"skeleton iterations", c.skeleton_iterations},
          {"outer iterations", c.outer_iterations},
          {"solves that missed their tolerance", c.unconverged},
          {"list rebuilds", c.stencils},
          {"further rounds of quadratic drag", c.drag_rounds},
          {"born", c.born},
          {"deleted", c.deleted},
          {"lost, far outside", c.lost}};
}

template class Fluid<2>;
template class Fluid<3>;

}  // namespace poretwin::fluid
