#include "common/geometry/enclosure.hpp"

#include "common/case/amounts.hpp"
#include "common/geometry/extent.hpp"
#include "common/geometry/pieces.hpp"
#include "common/geometry/shapes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace poretwin {
namespace {

/// A straight piece of a wall or of a water face, through which the flood cannot pass. If it is not a `plane`, it
/// extends from a to b (2D).
struct Barrier {
  std::string name;
  Point3 a, b;  ///< its two ends; of a plane: a point on it, and its normal
  bool plane = false;
};

/// Whether the step from x to y crosses the barrier.
bool crossed(const Barrier& barrier, const Point3& x, const Point3& y) {
  if (barrier.plane) return (barrier.b.dot(x - barrier.a) > 0.0) != (barrier.b.dot(y - barrier.a) > 0.0);
  const Point3 r = y - x, s = barrier.b - barrier.a, d = barrier.a - x;
  const double area = cross(r, s);
  if (area == 0.0) return false;
  const double t = cross(d, s) / area, u = cross(d, r) / area;
  const double slack = 1e-3 * r.norm() / s.norm();
  return t >= 0.0 && t <= 1.0 && u >= -slack && u <= 1.0 + slack;
}

/// Looks for a gap through which water could leave the scene, by a flood fill over grid cells: from every source of
/// water down, sideways, and up to the highest level of any source, as far as walls and water faces.
class Flood {
 public:
  explicit Flood(const Case& scene) : scene_(scene), dimension_(scene.general.dimension) {
    const double g = scene.general.gravity.norm();
    if (g > 0.0) up_ = -scene.general.gravity / g;
  }

  std::optional<Leak> leak() {
    if (up_.isZero()) return std::nullopt;
    collect();
    if (walls_ == 0 || !(level_ > -HUGE_VAL)) return std::nullopt;
    lay_cells();
    return spread();
  }

 private:
  static std::string named(const std::string& section, std::size_t i, const std::string& name) {
    return name.empty() ? fmt::format("{}[{}]", section, i) : fmt::format("{}[{}] \"{}\"", section, i, name);
  }

  void enclose(const Point3& x) {
    lower_ = lower_.cwiseMin(x);
    upper_ = upper_.cwiseMax(x);
  }

  void add(const Face& face, const std::string& name) {
    if (face.points.empty()) barriers_.push_back({name, face.point, face.normal, true});
    for (std::size_t i = 0; i + 1 < face.points.size(); ++i)
      barriers_.push_back({name, face.points[i], face.points[i + 1], false});
    for (const auto& x : face.points) enclose(x);
  }

  void collect() {
    const double spacing = scene_.fluid.particle_spacing;
    for (const auto& soil : scene_.soils) {
      const auto [lower, upper] = bounds(soil.shape);
      enclose(lower);
      enclose(upper);
    }
    for (const auto& region : scene_.fluid.regions) {
      const auto [lower, upper] = bounds(region);
      enclose(lower);
      enclose(upper);
      level_ = std::max(level_, extent(region, up_, dimension_).second);
      const auto particles = [&](const auto& lattice) {
        for (const auto& x : lattice.position) {
          Point3 point = Point3::Zero();
          for (Eigen::Index d = 0; d < x.size(); ++d) point[d] = x[d];
          springs_.push_back(point);
        }
      };
      if (dimension_ == 2)
        particles(fill<2>(region, spacing_to_look_at(region, spacing, 2), {0.5, 0.5, 0.5}, 0.0, 1));
      else
        particles(fill<3>(region, spacing_to_look_at(region, spacing, 3), {0.5, 0.5, 0.5}, 0.0, 1));
    }
    for (std::size_t i = 0; i < scene_.walls.size(); ++i) {
      const auto& wall = scene_.walls[i];
      if (wall.water == Wall::ForWater::none) continue;
      ++walls_;
      if (wall.shape) {
        const auto [lower, upper] = bounds(*wall.shape);
        enclose(lower);
        enclose(upper);
        bodies_.push_back(&wall);
        continue;
      }
      add(wall.face, named("wall", i, wall.name));
    }
    for (std::size_t i = 0; i < scene_.water_faces.size(); ++i) {
      const auto& face = scene_.water_faces[i];
      add(face.face, named("water_face", i, face.name));
      double highest = 0.0;
      if (face.head)
        for (const auto& [time, value] : face.head->knots) level_ = std::max(level_, value);
      if (face.pressure)
        for (const auto& [time, value] : face.pressure->knots)
          highest = std::max(highest, value / (scene_.water.density * scene_.general.gravity.norm()));
      // Water that comes in through an inlet may stand a little above the inlet's upper end.
      const double above = is_inlet(scene_, face) ? 2.0 * spacing : 0.0;
      if (face.discharge)
        for (const auto& x : face.face.points) level_ = std::max(level_, up_.dot(x) + above);
      if (face.outlet) takers_.push_back(&face);
      if (is_reservoir(scene_, face)) {
        takers_.push_back(&face);
        if (const auto crest = crest_of(scene_, face); crest && no_way_over(scene_, *crest).empty()) {
          const bool over = face.basin_area || std::any_of(face.head->knots.begin(), face.head->knots.end(),
                                                           [&](const auto& k) { return k.second > crest->elevation; });
          if (over) {
            level_ = std::max(level_, crest->elevation + 2.0 * spacing);
            springs_.push_back(crest->end + 0.25 * spacing * (crest->inward + up_));
          }
        }
      }
      if (face.outlet) continue;
      // The flood starts from places just inside the face.
      for (std::size_t k = 0; k + 1 < face.face.points.size(); ++k) {
        const Point3 a = face.face.points[k], along = face.face.points[k + 1] - a;
        const Point3 inward = Point3(-along.y(), along.x(), 0.0).normalized();
        const int parts = static_cast<int>(std::clamp(along.norm() / spacing, 1.0, 10000.0));
        for (int p = 0; p < parts; ++p) springs_.push_back(a + (p + 0.5) / parts * along + 0.25 * spacing * inward);
      }
      if (face.pressure)
        for (const auto& x : face.face.points) level_ = std::max(level_, up_.dot(x) + highest);
    }
  }

  void lay_cells() {
    for (const int axis : scene_.general.periodic) {
      lower_[axis] = scene_.general.domain_min[axis];
      upper_[axis] = scene_.general.domain_max[axis];
    }
    constexpr double most = 2e5;
    size_ = 0.5 * scene_.fluid.particle_spacing;
    double volume = 1.0;
    for (int d = 0; d < dimension_; ++d) volume *= (upper_[d] - lower_[d]) / size_ + 6.0;
    if (volume > most) size_ *= std::pow(volume / most, 1.0 / dimension_);
    for (int d = 0; d < dimension_; ++d) {
      // Walls often lie at round coordinates: this margin keeps the centres of cells away from them.
      const double margin = periodic(d) ? 0.0 : 3.37 * size_;
      origin_[d] = lower_[d] - margin + 0.5 * size_;
      count_[static_cast<std::size_t>(d)] =
          std::max(1, static_cast<int>((upper_[d] - lower_[d] + 2.0 * margin) / size_));
    }
  }

  [[nodiscard]] bool periodic(int axis) const {
    const auto& axes = scene_.general.periodic;
    return std::find(axes.begin(), axes.end(), axis) != axes.end();
  }
  [[nodiscard]] Point3 centre(std::size_t cell) const {
    Point3 x = Point3::Zero();
    for (int d = 0; d < dimension_; ++d) {
      const auto n = static_cast<std::size_t>(count_[static_cast<std::size_t>(d)]);
      x[d] = origin_[d] + static_cast<double>(cell % n) * size_;
      cell /= n;
    }
    return x;
  }

  std::optional<Leak> spread() {
    constexpr std::size_t unseen = static_cast<std::size_t>(-1);
    std::array<std::size_t, 3> stride{1, 1, 1};
    std::size_t cells = 1;
    for (std::size_t d = 0; d < static_cast<std::size_t>(dimension_); ++d) {
      stride[d] = cells;
      cells *= static_cast<std::size_t>(count_[d]);
    }
    std::vector<std::size_t> from(cells, unseen), queue;
    for (const auto& x : springs_) {
      // The flood starts in the cell that contains x, if no barrier lies between x and the cell's centre.
      std::size_t cell = 0;
      bool inside = true;
      for (int d = 0; d < dimension_; ++d) {
        const auto n = count_[static_cast<std::size_t>(d)];
        const auto i = static_cast<int>(std::lround((x[d] - origin_[d]) / size_));
        inside = inside && i >= 0 && i < n;
        cell += static_cast<std::size_t>(std::max(0, i)) * stride[static_cast<std::size_t>(d)];
      }
      if (!inside || from[cell] != unseen || blocked(x, centre(cell)) || taken(x) || in_body(centre(cell))) continue;
      from[cell] = cell;
      queue.push_back(cell);
    }
    for (std::size_t head = 0; head < queue.size(); ++head) {
      const std::size_t cell = queue[head];
      const Point3 x = centre(cell);
      for (int d = 0; d < dimension_; ++d)
        for (const int step : {-1, 1}) {
          const auto axis = static_cast<std::size_t>(d);
          const auto at = static_cast<int>(cell / stride[axis] % static_cast<std::size_t>(count_[axis]));
          if (at + step < 0 || at + step >= count_[axis]) {
            if (periodic(d) || step * up_[d] > 0.5 || held_beyond(x, step * Point3::Unit(d))) continue;
            return leak_through(cell, from);
          }
          Point3 y = x;
          y[d] += step * size_;
          if (up_.dot(y) > level_ - 2.0 * size_) continue;  // a full basin may overflow: water above its rim is no leak
          const std::size_t next = step > 0 ? cell + stride[axis] : cell - stride[axis];
          if (from[next] != unseen || blocked(x, y) || taken(y)) continue;
          if (meets_body(x, y) && in_body(y)) {
            from[next] = next;
            continue;
          }
          from[next] = cell;
          queue.push_back(next);
        }
    }
    return std::nullopt;
  }

  /// Whether a plane, possibly far outside the grid, stops water that leaves the grid from x in this direction.
  [[nodiscard]] bool held_beyond(const Point3& x, const Point3& direction) const {
    return std::any_of(barriers_.begin(), barriers_.end(), [&](const Barrier& b) {
      const double towards = b.b.dot(direction);
      return b.plane && towards != 0.0 && b.b.dot(b.a - x) / towards > 0.0;
    });
  }

  /// Whether x lies in the body of a wall with a shape.
  [[nodiscard]] bool in_body(const Point3& x) const {
    return std::any_of(bodies_.begin(), bodies_.end(), [&](const Wall* wall) {
      return contains(*wall->shape, x, 3) != (wall->domain == Wall::Domain::inside);
    });
  }

  /// Whether the step from x to y crosses a surface of a wall with a shape.
  [[nodiscard]] bool meets_body(const Point3& x, const Point3& y) const {
    return std::any_of(bodies_.begin(), bodies_.end(), [&](const Wall* wall) {
      const auto& parts = wall->shape->solid->parts();
      return std::any_of(parts.begin(), parts.end(),
                         [&](const Solid::Part& part) { return part.mesh.crossing(x, y).has_value(); });
    });
  }

  /// Whether water at x has left the domain through an outlet or the face of a reservoir. False where x lies below the
  /// lower end of the face, where water arrives only through a gap, which is a leak.
  [[nodiscard]] bool taken(const Point3& x) const {
    return std::any_of(takers_.begin(), takers_.end(), [&](const WaterFace* face) {
      const auto& points = face->face.points;
      return !points.empty() && up_.dot(x) > std::min(up_.dot(points.front()), up_.dot(points.back())) &&
             is_behind(scene_, *face, x);
    });
  }
  [[nodiscard]] bool blocked(const Point3& x, const Point3& y) const {
    return std::any_of(barriers_.begin(), barriers_.end(), [&](const Barrier& b) { return crossed(b, x, y); });
  }

  /// The leak that ends in this cell: a place on the water's path, and the free ends of boundaries nearest to it.
  [[nodiscard]] Leak leak_through(std::size_t cell, const std::vector<std::size_t>& from) const {
    std::vector<Point3> way{centre(cell)};
    for (; from[cell] != cell; cell = from[cell]) way.push_back(centre(from[cell]));
    Leak leak{way.front(), {}};
    std::vector<std::pair<double, std::pair<std::string, Point3>>> ends;
    for (const auto& b : barriers_) {
      if (b.plane) continue;
      for (const auto& x : {b.a, b.b}) {
        const auto meets = [&](const Barrier& other) {
          if (&other == &b) return false;
          if (other.plane) return std::abs(other.b.normalized().dot(x - other.a)) < 0.01 * size_;
          const Point3 s = other.b - other.a;
          const double along = std::clamp(s.dot(x - other.a) / s.squaredNorm(), 0.0, 1.0);
          return (other.a + along * s - x).norm() < 0.01 * size_;
        };
        if (std::any_of(barriers_.begin(), barriers_.end(), meets)) continue;
        double nearest = HUGE_VAL;
        for (const auto& y : way) nearest = std::min(nearest, (y - x).norm());
        ends.push_back({nearest, {b.name, x}});
      }
    }
    std::stable_sort(ends.begin(), ends.end(), [](const auto& p, const auto& q) { return p.first < q.first; });
    if (ends.empty()) return leak;
    leak.ends.push_back(ends.front().second);
    const auto beside = [&](const Point3& x) {
      return *std::min_element(way.begin(), way.end(),
                               [&](const Point3& p, const Point3& q) { return (p - x).norm() < (q - x).norm(); });
    };
    const Point3 first = ends.front().second.second;
    leak.at = beside(first);
    // The second end must belong to another boundary.
    ends.erase(std::remove_if(ends.begin() + 1, ends.end(),
                              [&](const auto& end) { return end.second.first == ends.front().second.first; }),
               ends.end());
    if (ends.size() == 1) return leak;
    // The second end is the other side of the gap, unless water or soil lies between the two ends.
    const Point3 second = ends[1].second.second, middle = 0.5 * (first + second);
    if (through_ground(first, second) || (beside(middle) - middle).norm() > 0.5 * (second - first).norm() + size_)
      return leak;
    leak.ends.push_back(ends[1].second);
    leak.at = beside(middle);
    return leak;
  }

  /// Whether soil or water lies on both sides of the line somewhere.
  [[nodiscard]] bool through_ground(const Point3& a, const Point3& b) const {
    const auto ground = [&](const Point3& x) { return soil_at(scene_, x) || in_fluid_region(scene_, x); };
    const Point3 aside = 0.25 * size_ * Point3(a.y() - b.y(), b.x() - a.x(), 0.0).normalized();
    constexpr int parts = 20;
    for (int k = 1; k < parts; ++k) {
      const Point3 x = a + static_cast<double>(k) / parts * (b - a);
      if (ground(x + aside) && ground(x - aside)) return true;
    }
    return false;
  }

  const Case& scene_;
  int dimension_;
  Point3 up_ = Point3::Zero();
  Point3 lower_ = Point3::Constant(HUGE_VAL), upper_ = Point3::Constant(-HUGE_VAL), origin_ = Point3::Zero();
  std::vector<Barrier> barriers_;
  std::vector<Point3> springs_;
  std::vector<const WaterFace*> takers_;  ///< outlets and reservoirs' faces, which take water
  std::vector<const Wall*> bodies_;       ///< walls with a shape
  std::size_t walls_ = 0;
  double level_ = -HUGE_VAL, size_ = 0.0;
  std::array<int, 3> count_{1, 1, 1};
};

}  // namespace

std::optional<Leak> find_leak(const Case& scene) { return Flood(scene).leak(); }

}  // namespace poretwin
