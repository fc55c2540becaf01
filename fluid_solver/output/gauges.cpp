// The fluid's gauges: values at points, along lines and faces, sums over regions, the balance of water volume.
#include "fluid_solver/output/gauges.hpp"

#include "common/case/gauge_kinds.hpp"
#include "fluid_solver/discretisation/cloud.hpp"
#include "fluid_solver/numerics/readings.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace poretwin::fluid {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr std::array<const char*, 3> axes{"_x", "_y", "_z"};

/// A straight line from a to b, and the normal to its left (2D).
template <int D>
struct Line {
  Vec<D> a, direction;
  double length = 0.0;
  Vec<D> left = Vec<D>::Zero();
  explicit Line(const Gauge& gauge)
      : Line(Vec<D>(gauge.points[0].template head<D>()), Vec<D>(gauge.points[1].template head<D>())) {}
  Line(const Vec<D>& from, const Vec<D>& to) : a(from), direction(to - from), length(direction.norm()) {
    direction /= length;
    left[0] = -direction[1];
    left[1] = direction[0];
  }
  [[nodiscard]] Vec<D> at(double z) const { return a + z * direction; }
};

template <int D>
class Reader {
 public:
  Reader(const Setup<D>& setup, const Faces<D>& faces, const State<D>& state, const Cloud<D>& cloud)
      : setup_(setup),
        ground_(setup.ground),
        boundaries_(faces.boundaries),
        state_(state),
        cloud_(cloud),
        probe_(cloud),
        weight_(setup.weight),
        passed_(poretwin::fluid::passed<D>(state)),
        gamma_(setup.ground.specific_weight()),
        dx_(setup.spacing) {
    if (!setup.coupled && !setup.one_soil) find_soils();
  }

  void read(const Gauge& gauge) {
    const std::string per_width = D == 2 ? "m2" : "m3";
    if (gauge.kind == "point") return points(gauge);
    if (gauge.kind == "front") return add(gauge.name, front(Line<D>(gauge)), "m");
    if (gauge.kind == "discharge") return add(gauge.name, discharge(gauge), per_width + "/s");
    if (gauge.kind == "exit_height") return add(gauge.name, exit_height(Line<D>(gauge)), "m");
    if (gauge.kind == "exit_gradient") return exit_gradient(gauge.name, Line<D>(gauge));
    if (gauge.kind == "pressure_force") return pressure_force(gauge.name, Line<D>(gauge));
    if (gauge.kind == "heave") return add(gauge.name, heave(Line<D>(gauge)), "1");
    if (gauge.kind == "volume") return add(gauge.name, volume(gauge), per_width);
    if (gauge.kind == "balance") return balance(gauge, per_width);
    if (gauge.kind == "level") return add(gauge.name, level(gauge), "m");
    if (gauge.kind == "passed_volume") return add(gauge.name, passed_volume(gauge), per_width);
    if (gauge.kind == "extent") return add(gauge.name, extent(gauge), "m");
    if (gauge.kind == "spread") return add(gauge.name, spread(gauge), "m");
    sums(gauge);
  }
  [[nodiscard]] std::vector<GaugeReading> take() { return std::move(readings_); }

 private:
  void add(std::string name, double value, std::string unit) {
    readings_.push_back({std::move(name), value, std::move(unit)});
  }

  [[nodiscard]] double elevation(const Vec<D>& x) const {
    const double magnitude = weight_.norm();
    return magnitude > 0.0 ? -weight_.dot(x) / magnitude : 0.0;
  }

  /// Finds the soil of every point of the cloud. A buffer has the soil in front of its face, an image that of its
  /// original, a particle that in which its pressure was computed (it may have left that soil in the window).
  void find_soils() {
    soil_.resize(cloud_.size(), nullptr);
    for (std::size_t a = 0; a < cloud_.n_real; ++a) {
      const int known = state_.particles.soil[a];
      soil_[a] = known > 0 ? &ground_.strata()[static_cast<std::size_t>(known) - 1] : ground_.at(cloud_.position[a]);
    }
    for (std::size_t b = 0; b < cloud_.column.size(); ++b) {
      const auto& c = state_.columns[cloud_.column[b]];
      soil_[cloud_.n_real + b] = ground_.at(just_inside<D>(ground_, c.foot, c.normal, c.spacing));
    }
    for (std::size_t i = cloud_.n_base; i < cloud_.size(); ++i) soil_[i] = soil_[cloud_.original[i - cloud_.n_base]];
  }
  /// Value and gradient of a field at a place, fitted to points in the same soil. Where two soils meet, the velocity
  /// along the border and the gradient of the pressure across it jump by the ratio of the conductivities. A fit to
  /// points on both sides would be wrong by a good part of the change over one spacing.
  template <class Field>
  [[nodiscard]] typename Probe<D>::Fit fit(const Vec<D>& x, const Field& f, bool of_pressure = false) const {
    const Stratum* here = soil_.empty() ? nullptr : ground_.at(x);
    const bool some = of_pressure && !cloud_.without_pressure.empty();
    if (!here && !some) return probe_.fit(x, f);
    return probe_.fit(
        x, f, [&](Index j) { return (!here || !soil_[j] || soil_[j] == here) && (!some || cloud_.has_pressure(j)); });
  }
  /// Total pressure [Pa] and its gradient. The fit is made without the part of the weight: where few points give no
  /// slope, the value is then the mean of the piezometric pressure.
  [[nodiscard]] typename Probe<D>::Fit pressure(const Vec<D>& x) const {
    auto result = fit(
        x, [&](Index j) { return cloud_.pressure[j] - weight_.dot(cloud_.position[j] - x); }, true);
    result.gradient += weight_;
    return result;
  }

  void points(const Gauge& gauge) {
    for (std::size_t i = 0; i < gauge.points.size(); ++i) {
      const Vec<D> x = gauge.points[i].template head<D>();
      const std::string name = gauge.points.size() > 1 ? fmt::format("{}[{}]", gauge.name, i) : gauge.name;
      if (gauge.quantity == "pore_pressure") add(name, pressure(x).value, "Pa");
      if (gauge.quantity == "pressure_head") add(name, pressure(x).value / gamma_, "m");
      if (gauge.quantity == "head") add(name, pressure(x).value / gamma_ + elevation(x), "m");
      if (gauge.quantity == "degree_of_saturation") {
        const Stratum* here = ground_.at(x);
        const double initial = here ? here->initial_saturation : 0.0;
        add(name, initial + (1.0 - initial) * std::min(1.0, probe_.fullness(x)), "1");
      }
      for (int d = 0; d < D; ++d) {
        const char* axis = axes[static_cast<std::size_t>(d)];
        if (gauge.quantity != "velocity" && gauge.quantity != std::string("velocity") + axis) continue;
        add(gauge.quantity == "velocity" ? name + axis : name,
            fit(x, [&](Index j) { return cloud_.velocity[j][d]; }).value, "m/s");
      }
    }
  }

  /// Pressure [Pa] that the water's surface has in the soil at this place.
  [[nodiscard]] double surface_pressure(const Vec<D>& x) const { return -ground_.suction(x); }

  /// Length of the water along a line [m]. by_fullness: to where half of the kernel is in water; it is too short at the
  /// tip of a wedge, where line and surface meet. by_pressure: to where the pressure falls to that of the surface; it
  /// is a fifth of a spacing too short behind an advancing front, and NaN where the pressure is uniform.
  struct Reach {
    double by_fullness = 0.0, by_pressure = nan;
  };
  [[nodiscard]] double front(const Line<D>& line) const {
    Reach r = reach(line);
    const Probe<D> wide(cloud_, 2.0);
    if (const double inside = under_water(line, wide, r.by_fullness); std::isfinite(inside))
      r.by_pressure = where_pressure_ends(line, wide, inside, r.by_fullness);
    return std::fmax(r.by_fullness, r.by_pressure);
  }
  [[nodiscard]] Reach reach(const Line<D>& line) const {
    // A gap of less than two spacings is loose packing, not the end of the water.
    const double step = 0.5 * dx_, gap = readings::gap * dx_;
    double wet = -step;
    for (double z = 0.0; z < std::max(0.0, wet) + gap && z < line.length; z += step)
      if (probe_.fullness(line.at(z)) >= 0.5) wet = z;
    if (wet < 0.0) return {};
    if (wet + step >= line.length && probe_.fullness(line.at(line.length)) >= 0.5) return {line.length, line.length};
    double dry = std::min(wet + step, line.length);
    while (dry - wet > 1e-3 * dx_) {
      const double middle = 0.5 * (wet + dry);
      (probe_.fullness(line.at(middle)) < 0.5 ? dry : wet) = middle;
    }
    return {wet, where_pressure_ends(line, probe_, std::max(0.0, wet - dx_), wet)};
  }

  /// The last place on a line before `wet`, in the same soil, above which the water is at least as deep as a kernel
  /// reaches, judged by its pressure; NaN if there is none. In the tip of a wedge, one or two rows of particles, the
  /// pressure does not fall as in the water behind it.
  [[nodiscard]] double under_water(const Line<D>& line, const Probe<D>& probe, double wet) const {
    const double deep = sph::support_radius * points::smoothing_ratio * dx_;
    const Stratum* ground = ground_.at(line.at(wet));
    if (!ground) return nan;
    for (double z = wet - dx_; z >= std::max(0.0, wet - readings::under_water_within * dx_); z -= 0.5 * dx_) {
      if (ground_.at(line.at(z)) != ground) break;
      const double p = probe.pressure(line.at(z)).value;
      if (p - surface_pressure(line.at(z)) >= gamma_ * deep) return z;
    }
    return nan;
  }

  /// The place on a line where the pressure, extrapolated with its slope at `inside`, reaches that of the surface. NaN
  /// if the pressure is uniform, or if the place is farther from `wet` than single particles can be from the surface.
  /// In a wedge with a surface that falls by s along its base, uniform flow lowers the pressure by gamma s; two
  /// particles fill its last 2/sqrt(s) spacings.
  [[nodiscard]] double where_pressure_ends(const Line<D>& line, const Probe<D>& probe, double inside,
                                           double wet) const {
    const auto p = probe.pressure(line.at(inside));
    const double slope = p.gradient.dot(line.direction);
    if (!(slope < -readings::least_slope * gamma_)) return nan;
    const double end = std::min(inside + (surface_pressure(line.at(inside)) - p.value) / slope, line.length);
    const double farthest = std::max(1.5, 2.0 / std::sqrt(-slope / gamma_) - 0.5);
    return std::abs(end - wet) < farthest * dx_ ? end : nan;
  }

  /// Discharge [m3/s, 2D: m2/s] through the wet part of a line, positive from its right to its left. Where the last
  /// pressure solve drives all of the flow, the flow of that solve; otherwise computed from the particles' velocities.
  [[nodiscard]] double discharge(const Gauge& gauge) {
    const std::size_t number = discharges_++;
    if (number < state_.section_flow.size()) return state_.section_flow[number];
    const Line<D> line(gauge);
    double from = 0.0, to = front(line);
    if (to == 0.0) {
      to = line.length;
      from = line.length - front(Line<D>(line.at(line.length), line.at(0.0)));
    }
    const int count = std::max(1, static_cast<int>(std::ceil((to - from) / (0.5 * dx_))));
    const auto through = [&](double a, double b) {
      const double flux = fit(line.at(0.5 * (a + b)), [&](Index j) {
                            return cloud_.void_fraction[j] * cloud_.velocity[j].dot(line.left);
                          }).value;
      return std::isfinite(flux) ? (b - a) * flux : 0.0;
    };
    double sum = 0.0;
    for (int i = 0; i < count; ++i) {
      const double a = from + (to - from) * i / count, b = from + (to - from) * (i + 1) / count;
      const double border = border_between(line, a, b);
      sum += through(a, border) + through(border, b);
    }
    return sum;
  }
  /// The place between a and b on a line where the soil at a ends; b if both are in the same soil.
  [[nodiscard]] double border_between(const Line<D>& line, double a, double b) const {
    if (soil_.empty()) return b;
    const Stratum* here = ground_.at(line.at(a));
    if (ground_.at(line.at(b)) == here) return b;
    while (b - a > 1e-6 * dx_) {
      const double middle = 0.5 * (a + b);
      (ground_.at(line.at(middle)) == here ? a : b) = middle;
    }
    return b;
  }

  /// Depth [m] of the water's surface below a place on a face, inwards, up to `deepest`; 0 if water stands at the face.
  [[nodiscard]] double depth(const Vec<D>& x, const Vec<D>& inward, double deepest) const {
    const auto r = reach(Line<D>(x + deepest * inward, x));
    return deepest - (std::isfinite(r.by_pressure) ? r.by_pressure : r.by_fullness);
  }

  /// Elevation [m] at which the water's surface meets a face (domain on its left), searched for from the line's far
  /// end. The surface approaches the face tangentially. A straight line through the places where it is one fifth and
  /// three fifths of a spacing deep is extended to the face.
  [[nodiscard]] double exit_height(const Line<D>& line) const {
    const double shallow = readings::exit_shallow * dx_, deep = readings::exit_deep * dx_, step = 0.1 * dx_;
    double at_deep = line.length, before = nan;
    for (double z = line.length; z >= 0.0; z -= step) {
      const double now = depth(line.at(z), line.left, 2.5 * dx_);
      const auto crossing = [&](double level) { return z + step * (level - now) / (before - now); };
      if (now < deep && !(before < deep)) at_deep = std::isfinite(before) ? crossing(deep) : z;
      if (now < shallow) {
        const double at_shallow = std::isfinite(before) ? crossing(shallow) : z;
        return elevation(line.at(std::max(0.0, at_shallow - 0.5 * (at_deep - at_shallow))));
      }
      before = now;
    }
    return nan;
  }

  /// Largest outward hydraulic gradient at a face (domain on its left) with water inside, and its place along the line
  /// [m]. Where the face looks upwards, also the largest ratio of that gradient to the one that lifts the grains. On a
  /// face inclined by the angle b, the part cos b of the buoyant weight acts across the face.
  void exit_gradient(const std::string& name, const Line<D>& line) {
    double largest = nan, at = nan, over_critical = nan;
    const double upwards = elevation(-line.left);
    const int count = std::max(1, static_cast<int>(line.length / (0.5 * dx_)));
    for (int i = 0; i < count; ++i) {
      const double place = (i + 0.5) * line.length / count;
      const Vec<D> x = line.at(place) + 0.5 * dx_ * line.left;
      if (probe_.fullness(x) < 0.5) continue;
      const auto p = pressure(x);
      const double gradient = (p.gradient - weight_).dot(line.left) / gamma_;
      if (!std::isfinite(p.value)) continue;
      if (const Stratum* soil = ground_.at(x))
        over_critical = std::fmax(over_critical, gradient / (soil->critical_gradient * upwards));
      if (gradient <= largest) continue;
      largest = gradient;
      at = place;
    }
    add(name, largest, "1");
    add(name + "_at", at, "m");
    if (upwards > 1e-9) add(name + "_over_critical", over_critical, "1");
  }

  /// Force of the water's pressure on a line, per width [N/m], and the distance of its line of action from the start of
  /// the line.
  void pressure_force(const std::string& name, const Line<D>& line) {
    const int count = std::max(1, static_cast<int>(std::ceil(line.length / (0.5 * dx_))));
    double force = 0.0, moment = 0.0;
    for (int i = 0; i < count; ++i) {
      const double place = (i + 0.5) * line.length / count, p = pressure(line.at(place)).value;
      if (!(p > 0.0)) continue;
      force += p * line.length / count;
      moment += place * p * line.length / count;
    }
    add(name, force, "N/m");
    add(name + "_at", force > 0.0 ? moment / force : 0.5 * line.length, "m");
  }

  /// Weight of the soil as drawn, and of water in and on it, above a place [Pa]; 0 where no soil is above the place.
  [[nodiscard]] double overburden(const Vec<D>& x) const {
    const double step = 0.25 * dx_;
    const Vec<D> up = -weight_.normalized();
    double weight = 0.0, top = 0.0;
    for (double z = 0.5 * step;; z += step) {
      const Stratum* soil = ground_.at(x + z * up);
      if (soil == nullptr) break;
      const double dry = soil->critical_gradient + 1.0 - soil->porosity;  // weight of the grains, over that of water
      const double wet = soil->initial_saturation +
                         (1.0 - soil->initial_saturation) * std::clamp(probe_.fullness(x + z * up), 0.0, 1.0);
      weight += (dry + soil->porosity * wet) * gamma_ * step;
      top = z + 0.5 * step;
    }
    if (top == 0.0) return 0.0;
    const double on_it = pressure(x + top * up).value;
    return weight + (on_it > 0.0 ? on_it : 0.0);
  }

  /// Ratio of the water's pressure on a line to the weight above the line, both summed over the places with soil above.
  [[nodiscard]] double heave(const Line<D>& line) const {
    const int count = std::max(1, static_cast<int>(std::ceil(line.length / (0.5 * dx_))));
    double pushed = 0.0, weight = 0.0;
    for (int i = 0; i < count; ++i) {
      const Vec<D> x = line.at((i + 0.5) * line.length / count);
      const double above = overburden(x), p = pressure(x).value;
      if (!(above > 0.0)) continue;
      weight += above;
      if (p > 0.0) pushed += p;
    }
    return weight > 0.0 ? pushed / weight : nan;
  }

  [[nodiscard]] bool inside(const Gauge& gauge, const Vec<D>& x) const {
    return !gauge.region || contains(*gauge.region, to_point3<D>(x), D);
  }

  /// The outermost particle of a column may lie up to half a spacing on either side of the face. Its part outside the
  /// face does not count.
  [[nodiscard]] double volume(const Gauge& gauge) const {
    const auto& p = state_.particles;
    double sum = 0.0;
    for (std::size_t a = 0; a < p.size(); ++a)
      if (inside(gauge, p.position[a])) sum += p.mass[a];
    for (const auto& c : state_.columns)
      if (inside(gauge, c.foot + 1e-6 * c.spacing * c.normal)) sum += c.share(1.0);
    for (const auto& inlet : state_.inlets)
      if (inside(gauge, inlet.foot + 1e-6 * inlet.spacing * inlet.normal))
        sum += setup_.density * inlet.piston * inlet.width;
    return sum / setup_.density;
  }

  /// Elevation [m] of the water behind the face that the gauge names.
  [[nodiscard]] double level(const Gauge& gauge) const {
    for (std::size_t f = 0; f < boundaries_.size(); ++f) {
      if (setup_.face_names[f] != gauge.quantity) continue;
      for (const auto& inlet : state_.inlets)
        if (inlet.face == static_cast<int>(f) && !inlet.sill) return inlet.level;
      FaceState now = state_.faces[f];
      boundaries_[f]->advance(state_.time, 0.0, {passed_[f], 0.0}, now);  // adds the volume that has passed since
      return boundaries_[f]->level(state_.time, now).value_or(nan);
    }
    return nan;
  }

  /// Volume that has come in minus volume that has gone out, through the face that the gauge names or through all.
  [[nodiscard]] double passed_volume(const Gauge& gauge) const {
    double sum = 0.0;
    for (std::size_t f = 0; f < boundaries_.size(); ++f)
      if (gauge.quantity.empty() || setup_.face_names[f] == gauge.quantity) sum += passed_[f];
    return sum;
  }

  void balance(const Gauge& gauge, const std::string& unit) {
    const auto& b = state_.balance;
    const double stored = volume({});
    add(gauge.name + "_in", b.in, unit);
    add(gauge.name + "_out", b.out, unit);
    add(gauge.name + "_stored", stored, unit);
    add(gauge.name + "_error", b.in - b.out - (stored - b.initial), unit);
  }

  void sums(const Gauge& gauge) {
    const auto& p = state_.particles;
    const Vec<D>& gravity = setup_.acceleration;
    Vec<D> momentum = Vec<D>::Zero();
    double kinetic = 0.0, potential = 0.0, count = 0.0, fastest = 0.0, lowest = nan;
    for (std::size_t a = 0; a < p.size(); ++a) {
      const Vec<D>& x = p.position[a];
      if (!inside(gauge, x)) continue;
      momentum += p.mass[a] * p.velocity[a];
      kinetic += 0.5 * p.mass[a] * p.velocity[a].squaredNorm();
      potential += p.mass[a] * (0.5 * setup_.central_force * x.squaredNorm() - gravity.dot(x));
      fastest = std::max(fastest, p.velocity[a].norm());
      lowest = std::fmin(lowest, cloud_.pressure[a]);
      count += 1.0;
    }
    if (gauge.kind == "received_impulse") momentum = state_.exchanged.received;
    if (gauge.kind == "unexplained_impulse") momentum -= state_.exchanged.received + state_.exchanged.from_outside;
    if (gauge.kind == "momentum" || gauge.kind == "received_impulse" || gauge.kind == "unexplained_impulse")
      for (int d = 0; d < D; ++d)
        if (gauge.reads_component(d)) add(gauge.name + axes[static_cast<std::size_t>(d)], momentum[d], "N s");
    if (gauge.kind == "kinetic_energy") add(gauge.name, kinetic, "J");
    if (gauge.kind == "potential_energy") add(gauge.name, potential, "J");
    if (gauge.kind == "drag_work") add(gauge.name, state_.exchanged.drag_work, "J");
    if (gauge.kind == "energy") add(gauge.name, kinetic + potential, "J");
    if (gauge.kind == "particles") add(gauge.name, count, "1");
    if (gauge.kind == "max_speed") add(gauge.name, fastest, "m/s");
    if (gauge.kind == "min_pressure") add(gauge.name, lowest, "Pa");
  }

  /// Position [m] of the end of the water in the line's direction.
  ///
  /// Half a spacing beyond the foremost particle is right only for a blunt front. In the tongue of a flood, a wedge, it
  /// is 0.7 spacings too short at a slope of 30 degrees. In a wedge the volume ahead of a place grows with the square
  /// of its distance from the tip: the place with 8 particles ahead is twice as far from the tip as the place with 2.
  /// At a blunt front of height H, the result of this rule is 4 dx/H spacings too short.
  [[nodiscard]] double extent(const Gauge& gauge) const {
    const Line<D> line(gauge);
    const auto& p = state_.particles;
    std::vector<std::pair<double, double>> foremost;  // position, volume
    for (std::size_t a = 0; a < p.size(); ++a)
      if (inside(gauge, p.position[a])) foremost.emplace_back(line.direction.dot(p.position[a] - line.a), p.volume[a]);
    if (foremost.empty()) return nan;
    const std::size_t n = std::min(foremost.size(), readings::foremost);
    std::partial_sort(foremost.begin(), foremost.begin() + static_cast<std::ptrdiff_t>(n), foremost.end(),
                      std::greater<>());
    const double unit = foremost[0].second, tip = foremost[0].first + 0.5 * spacing_of<D>(unit);
    if (static_cast<double>(n) < readings::far_from_tip + 1.0) return tip;  // only a few drops of water
    const auto place = [&](double ahead) {
      double lower = foremost[n - 1].first - spacing_of<D>(unit), upper = tip;
      for (int step = 0; step < 50; ++step) {
        const double middle = 0.5 * (lower + upper);
        double sum = 0.0;
        for (std::size_t i = 0; i < n; ++i)
          sum += foremost[i].second *
                 std::clamp((foremost[i].first - middle) / spacing_of<D>(foremost[i].second) + 0.5, 0.0, 1.0);
        (sum > ahead * unit ? lower : upper) = middle;
      }
      return lower;
    };
    return 2.0 * place(readings::near_tip) - place(readings::far_from_tip);
  }

  /// Root mean square distance [m] of the water from its mean position, in the line's direction.
  [[nodiscard]] double spread(const Gauge& gauge) const {
    const Line<D> line(gauge);
    const auto& p = state_.particles;
    double mass = 0.0, first = 0.0, second = 0.0;
    for (std::size_t a = 0; a < p.size(); ++a) {
      if (!inside(gauge, p.position[a])) continue;
      const double s = line.direction.dot(p.position[a]);
      mass += p.mass[a];
      first += p.mass[a] * s;
      second += p.mass[a] * s * s;
    }
    return std::sqrt(std::max(0.0, second / mass - first * first / (mass * mass)));
  }

  const Setup<D>& setup_;
  const Ground<D>& ground_;
  const WaterBoundaries& boundaries_;
  const State<D>& state_;
  const Cloud<D>& cloud_;
  Probe<D> probe_;
  std::vector<const Stratum*> soil_;  ///< for each point of the cloud; empty where all soils conduct alike, or move
  Vec<D> weight_;
  ScalarArray passed_;
  double gamma_ = 0.0, dx_ = 0.0;
  std::size_t discharges_ = 0;  ///< number of gauges of this kind that have been read
  std::vector<GaugeReading> readings_;
};

}  // namespace

/// Force that the water's pressure exerts on walls, taken on water and soil [N, 2D: N/m].
template <int D>
Vec<D> wall_force(const Setup<D>& setup, const Walls<D>& walls, const State<D>& state) {
  Vec<D> force = Vec<D>::Zero();
  const auto cloud = make_cloud<D>(state, walls, setup.weight, setup.origin, {}, 0, setup.ground.beds().has_value());
  const Probe<D> probe(cloud);
  for (const auto& wall : setup.pressed_walls) {
    const Line<D> line(wall.from, wall.to);
    const auto count = static_cast<int>(std::ceil(2.0 * line.length / setup.spacing));
    const double step = line.length / count;
    const Vec<D> behind = -1e-6 * setup.spacing * line.left;
    for (int k = 0; k < count; ++k) {
      const Vec<D> x = line.at((k + 0.5) * step);
      if (const double p = probe.pressure(x).value; std::isfinite(p)) force += step * p * line.left;
      if (!wall.both_sides) continue;
      if (const double p = probe.pressure(x + behind).value; std::isfinite(p)) force -= step * p * line.left;
    }
  }
  return force;
}

template <int D>
void count_impulse(const Setup<D>& setup, const Walls<D>& walls, double interval, State<D>& state) {
  state.exchanged.from_outside += interval * wall_force(setup, walls, state);
  for (const double m : state.particles.mass) state.exchanged.from_outside += interval * m * setup.acceleration;
}

template <int D>
std::vector<GaugeReading> read_gauges(const Setup<D>& setup, const Faces<D>& faces, const Walls<D>& walls,
                                      const State<D>& state) {
  const bool any =
      std::any_of(setup.gauges.begin(), setup.gauges.end(), [](const Gauge& g) { return g.phase == "fluid"; });
  if (!any) return {};
  const auto cloud =
      make_cloud<D>(state, walls, setup.weight, setup.origin, {}, setup.no_slip, setup.ground.beds().has_value());
  Reader<D> reader(setup, faces, state, cloud);
  for (const auto& gauge : setup.gauges)
    if (gauge.phase == "fluid") reader.read(gauge);
  return reader.take();
}

#define PORETWIN_INSTANTIATE(D)                                                                                       \
  template void count_impulse(const Setup<D>&, const Walls<D>&, double, State<D>&);                                   \
  template std::vector<GaugeReading> read_gauges(const Setup<D>& setup, const Faces<D>& faces, const Walls<D>& walls, \
                                                 const State<D>& state);
PORETWIN_INSTANTIATE(2)
PORETWIN_INSTANTIATE(3)
#undef PORETWIN_INSTANTIATE

}  // namespace poretwin::fluid
