#include "common/case/plates.hpp"

#include "common/case/complaints.hpp"
#include "common/geometry/extent.hpp"
#include "common/geometry/loaded_part.hpp"
#include "common/geometry/overlap.hpp"
#include "common/geometry/pieces.hpp"
#include "common/geometry/shapes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace poretwin {
namespace {

class Plates : Complaints {
 public:
  using Complaints::Complaints;

  void all() const {
    for (std::size_t i = 0; i < scene_.plates.size(); ++i) {
      const Plate& plate = scene_.plates[i];
      const std::string key = fmt::format("plate[{}]", i);
      belongs_here(key);
      if (in_3d_)
        rectangle(plate.face, key);
      else
        line(plate.face, key);
      motion(plate, key);
      if (!(scene_.solid.particle_spacing > 0.0)) continue;  // reported elsewhere
      touches_soil(plate.face, key);
      beside_walls(plate.face, key);
      alone(i, key);
      if (plate.tilts) turns_freely(i, key);
    }
  }

 private:
  /// Refuses plates in cases that cannot compute them.
  void belongs_here(const std::string& key) const {
    if (!scene_.deformable()) fail(key, "with solid.model = \"rigid\" nothing gives way to a plate");
    if (scene_.coupled() && in_3d_) fail(key, "plates in 3D stand beside dry soil only: expected no water");
    if (scene_.coupled() && !scene_.is_field())
      fail(key, "water particles do not see a plate: expected fluid.representation = \"field\", or no water");
    if (scene_.solid.quiet)
      fail(key, "soil that sleeps does not feel a plate that begins to move: expected no [solid.quiet] beside it");
    for (const Gauge& gauge : scene_.gauges)
      if (gauge.kind == "factor_of_safety")
        fail(key, fmt::format("the search of gauge \"{}\" for a factor of safety would hold the plate still: expected "
                              "loads in place of plates",
                              gauge.name));
  }

  void line(const Face& f, const std::string& key) const {
    if (f.within) fail(key + ".within", "belongs to dimension = 3, found dimension = 2");
    const bool plane = given(key + ".point") && given(key + ".normal");
    if (given(key + ".points") == plane || (!plane && (given(key + ".point") || given(key + ".normal"))))
      fail(key,
           "expected either the 2 ends of the plate as 'points', with the soil on the left, or 'point' and "
           "'normal' (into the soil) of a plate without ends");
    if (plane && !(f.normal.norm() > 0.0)) fail(key + ".normal", "expected a direction, found a vector of length zero");
    if (plane) return;
    if (f.points.size() != 2)
      fail(key + ".points",
           fmt::format("a plate is one straight line: expected its 2 ends, found {} points", f.points.size()));
    if (!((f.points[1] - f.points[0]).norm() > 0.0))
      fail(key + ".points", fmt::format("expected 2 different points, found {} twice", shown(f.points[0])));
  }

  /// Refuses, in 3D, anything but a plane across an axis, or the part of it in a box.
  void rectangle(const Face& f, const std::string& key) const {
    if (given(key + ".points") || !given(key + ".point") || !given(key + ".normal"))
      fail(key,
           "expected 'point' and 'normal' (into the soil) of the plate's plane, and a box, 'within', that it fills");
    constexpr double along_axis = 1.0 - 1e-9;
    if (!(f.normal.norm() > 0.0) || f.normal.normalized().cwiseAbs().maxCoeff() < along_axis)
      fail(key + ".normal", "expected a direction along an axis, as the rows of the soil's particles lie");
    if (!f.within) return;
    if (!plain_box(*f.within))
      fail(key + ".within",
           "expected a box along the axes, without turn, scale, move and cuts: a plate in 3D is a rectangle");
    Eigen::Index across = 0;
    f.normal.cwiseAbs().maxCoeff(&across);
    constexpr double least = 2.0;  // spacings
    const Point3 size = f.within->max - f.within->min;
    const double shorter = std::min(size[(across + 1) % 3], size[(across + 2) % 3]);
    if (!(shorter >= (least - 1e-6) * scene_.solid.particle_spacing))
      fail(key + ".within",
           fmt::format("the plate's shorter side is {:.3g} m: expected at least {:.3g} m ({:g} spacings)", shorter,
                       least * scene_.solid.particle_spacing, least));
    const double level = f.point[across];
    if (level < f.within->min[across] || level > f.within->max[across])
      fail(key + ".within", fmt::format("expected a box that contains a part of the plate's plane, found none of {} = "
                                        "{:.6g} m in it",
                                        "xyz"[across], level + scene_.general.origin[across]));
  }

  void motion(const Plate& plate, const std::string& key) const {
    const int given_motions = plate.displacement.has_value() + plate.speed.has_value() + plate.force.has_value();
    if (given_motions > 1)
      fail(key,
           "expected one of 'displacement', 'speed' and 'force', found more: a plate moves in a prescribed way or "
           "under a force");
    if (given_motions == 0 && !plate.along)
      fail(key,
           "nothing says how the plate moves: expected 'displacement', 'speed', 'force' or 'along'; soil beside a "
           "plate at rest is soil beside a [[wall]]");
    for (const auto& [series, name] : {std::pair{&plate.displacement, "displacement"}, {&plate.along, "along"}})
      if (*series && (*series)->at(0.0) != 0.0)
        fail(fmt::format("{}.{}", key, name),
             fmt::format("is the way since time zero, at which the plate lies at its line: expected 0 m at 0 s, "
                         "found {:g} m",
                         (*series)->at(0.0)));
    if (plate.along && in_3d_) fail(key + ".along", "belongs to dimension = 2, found dimension = 3");
    if (plate.along && plate.surface != Plate::Surface::rough)
      fail(key + ".along", "a smooth plate does not take the soil along: expected surface = \"rough\"");
    if (plate.start && *plate.start < 0.0)
      fail(key + ".start",
           fmt::format("time begins at 0 s, found {} s: expected none for a force that always acts, under "
                       "which the soil comes to rest before time zero",
                       *plate.start));
    if (!plate.force && plate.start) fail(key + ".start", "is the time from which 'force' acts: expected 'force'");
    if (!plate.force && plate.mass)
      fail(key + ".mass", "a plate that moves in a prescribed way needs no mass: expected 'force', or no 'mass'");
    tilt(plate, key);
  }

  /// Refuses what belongs to a plate that tilts, where it does not, and plates that tilt where they are not computed.
  void tilt(const Plate& plate, const std::string& key) const {
    if (!plate.tilts) {
      for (const auto& [is_given, name] : {std::pair{plate.eccentricity.has_value(), "eccentricity"},
                                           {plate.moment.has_value(), "moment"},
                                           {plate.lifts, "lifts"}})
        if (is_given)
          fail(fmt::format("{}.{}", key, name), "without 'tilts' the plate does not turn: expected tilts = true");
      return;
    }
    const std::string here = key + ".tilts";
    if (in_3d_) fail(here, "belongs to dimension = 2, found dimension = 3");
    if (!plate.force)
      fail(here, "a plate that moves in a prescribed way does not turn: expected 'force', which may be 0");
    if (plate.face.points.empty())
      fail(here, "a plate without ends has no middle to turn about: expected its 2 ends as 'points'");
    if (!scene_.general.periodic.empty())
      fail(here, "plates that turn beside periodic sides were not examined: expected no case.periodic");
    const double half = 0.5 * (plate.face.points[1] - plate.face.points[0]).norm();
    if (plate.eccentricity && std::abs(*plate.eccentricity) >= half)
      fail(key + ".eccentricity", fmt::format("the force acts beside the plate: expected less than half its length, "
                                              "{:g} m, found {:g} m",
                                              half, *plate.eccentricity));
    if (plate.lifts && (scene_.coupled() || !scene_.pore_pressures.empty()))
      fail(key + ".lifts", "the water in the gap under a plate that has come off is not computed: expected dry soil");
  }

  /// A place on a plate, for the part of it around: normal into the soil, length [m] or area [m2] of the part.
  struct Place {
    Point3 at, normal;
    double size = 0.0;
  };
  /// Places about a spacing apart all over a plate, as far as soil reaches.
  [[nodiscard]] std::vector<Place> places_on(const Face& f) const {
    const double dx = scene_.solid.particle_spacing;
    std::vector<Place> places;
    if (in_3d_) {
      Face whole = f;
      if (!f.within) {
        whole.within.emplace();
        whole.within->min = Point3::Constant(-HUGE_VAL);
        whole.within->max = Point3::Constant(HUGE_VAL);
      }
      const LoadedPart part = loaded_part(scene_, whole);
      if (!(part.area() > 0.0)) return places;
      const Point3 n = f.normal.normalized(), size = part.high - part.low;
      const auto cells = [&](int axis) { return std::max(1, static_cast<int>(std::ceil(size[axis] / dx))); };
      const int rows = cells(part.axes[0]), columns = cells(part.axes[1]);
      for (int p = 0; p < rows; ++p)
        for (int q = 0; q < columns; ++q) {
          Point3 x = part.low;
          x[part.axes[0]] += (p + 0.5) / rows * size[part.axes[0]];
          x[part.axes[1]] += (q + 0.5) / columns * size[part.axes[1]];
          places.push_back({x, n, part.area() / (rows * columns)});
        }
      return places;
    }
    if (f.points.empty()) {
      const Point3 n = f.normal.normalized(), along(-n.y(), n.x(), 0.0);
      Point3 low = Point3::Constant(HUGE_VAL), high = -low;  // extent of all soil along the plate
      for (const Soil& soil : scene_.soils)
        for (const auto& x : fill<2>(soil.shape, dx, {0.5, 0.5, 0.5}, 0.0, 1).position) {
          low.x() = std::min(low.x(), along.head<2>().dot(x));
          high.x() = std::max(high.x(), along.head<2>().dot(x));
        }
      for (double s = low.x(); s <= high.x(); s += dx) places.push_back({n.dot(f.point) * n + s * along, n, dx});
    }
    for (const Piece& piece : pieces_of(f)) {
      const auto along = places_along(piece, dx);
      for (const Point3& x : along)
        places.push_back({x, piece.left(), piece.length() / static_cast<double>(along.size())});
    }
    return places;
  }

  /// Refuses plates that lie away from the soil or inside it, or with a narrow gap before them: images of soil across a
  /// gap would act on the soil as if it touched the plate.
  void touches_soil(const Face& f, const std::string& key) const {
    const double dx = scene_.solid.particle_spacing;
    constexpr double beside = 0.05, reach = 1.5;  // spacings; the kernel reaches the image of a particle at 1.2
    double touched = 0.0;
    for (const Place& part : places_on(f)) {
      if (soil_at(scene_, part.at - beside * dx * part.normal))
        fail(key, fmt::format("soil lies behind the plate at {} m: expected soil only on the side to which the plate "
                              "presses{}",
                              shown(part.at), in_3d_ ? "" : ", the left of its line"));
      if (soil_at(scene_, part.at + beside * dx * part.normal))
        touched += part.size;
      else if (soil_at(scene_, part.at + reach * dx * part.normal))
        fail(key, fmt::format("a gap is left between the plate and the soil before it at {} m: expected a plate on the "
                              "soil's surface",
                              shown(part.at)));
    }
    if (in_3d_) {
      if (std::ranges::any_of(scene_.soils,
                              [](const Soil& s) { return s.shape.solid || s.shape.kind != Shape::Kind::box; }))
        fail(key,
             "soil of another shape is packed, and its stress on a plate was not examined: expected boxes along the "
             "axes");
    } else {
      constexpr double parallel = 0.02;  // sine of an angle
      const Point3 along =
          f.points.empty() ? Point3(-f.normal.y(), f.normal.x(), 0.0) : Point3(f.points[1] - f.points[0]);
      const bool on_rows = along.cwiseAbs().head<2>().minCoeff() < parallel * along.norm();
      if (!on_rows &&
          !std::ranges::all_of(scene_.soils, [](const Soil& s) { return turned_rectangle(s.shape).has_value(); }))
        fail(key,
             "the plate lies at an angle to the rows of the soil's particles, and the stress on it would be off by up "
             "to 40 %: expected a plate along x or y, with case.gravity turned instead, or soil drawn as a rectangle");
    }
    constexpr double spacings = 2.0;
    const double least = std::pow(spacings * dx, in_3d_ ? 2.0 : 1.0);
    if (touched < (1.0 - 1e-6) * least)
      fail(key, fmt::format("the plate lies off the soil: {:.3g} {} touch soil, expected at least {:.3g} {} ({:g} {})",
                            touched, in_3d_ ? "m2 of it" : "m of its line", least, in_3d_ ? "m2" : "m", spacings,
                            in_3d_ ? "spacings square" : "spacings"));
  }

  /// Refuses plates of one name, of which a gauge would read one only, and a plate under another plate or a load: both
  /// would act on the same row of soil.
  void alone(std::size_t i, const std::string& key) const {
    const Plate& plate = scene_.plates[i];
    const double dx = scene_.solid.particle_spacing;
    own_name(scene_.plates, i, "plate");
    for (std::size_t j = 0; j < i; ++j)
      if (const auto place = shared_place(plate.face, scene_.plates[j].face, dx))
        fail(key, fmt::format("lies on plate[{}] at {} m: expected one plate at each place", j, shown(*place)));
    for (std::size_t j = 0; j < scene_.loads.size(); ++j)
      if (const auto place = shared_place(plate.face, scene_.loads[j].face, dx))
        fail(key,
             fmt::format("lies on load[{}] at {} m, which acts on the soil and not on the plate: expected its force "
                         "in 'force' of the plate, or a load beside the plate",
                         j, shown(*place)));
  }

  /// Refuses plates that tilt and are not free to do so: an end on a wall or on another plate would rub or jam there,
  /// and half of a footing does not turn at its plane of symmetry. Also a water face on such a plate.
  void turns_freely(std::size_t i, const std::string& key) const {
    const double dx = scene_.solid.particle_spacing;
    const auto gap = [](const Face& other, const Point3& x) {
      double least = HUGE_VAL;
      if (other.points.empty() && !other.normal.isZero())
        least = std::abs(other.normal.normalized().dot(x - other.point));
      for (const Piece& piece : pieces_of(other)) least = std::min(least, distance_from(piece, x));
      return least;
    };
    const auto expect_free = [&](const Face& other, const std::string& name) {
      for (const Point3& end : scene_.plates[i].face.points)
        if (gap(other, end) < 0.99 * dx)
          fail(key + ".tilts",
               fmt::format("its end {} m lies {:.3g} m off {}, which does not let it turn: expected both "
                           "ends a spacing or more away",
                           shown(end), gap(other, end), name));
    };
    for (std::size_t w = 0; w < scene_.walls.size(); ++w)
      if (scene_.walls[w].soil != Wall::ForSoil::none)
        expect_free(scene_.walls[w].face, named("wall", w, scene_.walls[w].name));
    for (std::size_t j = 0; j < scene_.plates.size(); ++j)
      if (j != i) expect_free(scene_.plates[j].face, named("plate", j, scene_.plates[j].name));
    for (std::size_t j = 0; j < scene_.water_faces.size(); ++j)
      if (shared_place(scene_.plates[i].face, scene_.water_faces[j].face, dx))
        fail(key + ".tilts", fmt::format("{} lies on it and would not turn with it: expected a tight plate",
                                         named("water_face", j, scene_.water_faces[j].name)));
  }

  /// Refuses plates that cross walls or lie on them, and ends that nearly meet a wall.
  void beside_walls(const Face& f, const std::string& key) const {
    const double dx = scene_.solid.particle_spacing;
    for (std::size_t w = 0; w < scene_.walls.size(); ++w) {
      const Wall& wall = scene_.walls[w];
      if (wall.soil == Wall::ForSoil::none) continue;
      const std::string name = named("wall", w, wall.name);
      if (wall.soil == Wall::ForSoil::rough)
        fail(key, fmt::format("{} has rows of soil behind it, which no plate would meet: expected soil = \"fixed\" "
                              "beside plates",
                              name));
      if (in_3d_) {
        beside_wall_in_3d(f, wall, key, name);
        continue;
      }
      for (const Piece& plate : pieces_of(f))
        for (const Piece& piece : pieces_of(wall.face)) {
          for (const Point3& end : {plate.a, plate.b}) {
            const double gap = distance_from(piece, end);
            if (gap > 0.01 * dx && gap < 0.99 * dx)
              fail(key, fmt::format("its end {} m lies {:.3g} m off {}: expected it on the wall, or a spacing or more "
                                    "away",
                                    shown(end), gap, name));
          }
          const double from = piece.left().dot(plate.a - piece.a), to = piece.left().dot(plate.b - piece.a);
          const Point3 along = (piece.b - piece.a).normalized();
          const double first = along.dot(plate.a - piece.a), last = along.dot(plate.b - piece.a);
          const bool parallel = std::max(std::abs(from), std::abs(to)) < 0.01 * dx;
          const double common = std::min(std::max(first, last), piece.length()) - std::max(std::min(first, last), 0.0);
          const auto crosses = [&] {
            if (from * to >= 0.0 || std::min(std::abs(from), std::abs(to)) < 0.01 * dx) return false;
            const double at = first + (last - first) * from / (from - to);
            return at > 0.01 * dx && at < piece.length() - 0.01 * dx;
          };
          if ((parallel && common > 0.01 * dx) || crosses())
            fail(key, fmt::format("{} {}: expected a plate between walls, which may end on them",
                                  parallel ? "lies on" : "crosses", name));
        }
    }
  }
  /// Refuses, in 3D, plates that cross or lie on walls at an angle to the axes or with a shape, and rims that nearly
  /// meet a wall. A rim that reaches beyond a wall ends on it.
  void beside_wall_in_3d(const Face& f, const Wall& wall, const std::string& key, const std::string& name) const {
    const double dx = scene_.solid.particle_spacing;
    if (wall.shape)
      fail(key, fmt::format("{} has a shape: expected walls by 'point' and 'normal' beside plates", name));
    const Point3 n = f.normal.normalized(), m = wall.face.normal.normalized();
    if (std::abs(n.dot(m)) > 0.02) {
      if (std::abs(n.dot(f.point - wall.face.point)) < 0.01 * dx)
        fail(key, fmt::format("lies on {}: expected a plate between walls, which may end on them", name));
      return;
    }
    if (!f.within) return;
    for (const int axis : {0, 1, 2})
      if (std::abs(m[axis]) > 0.99) {
        const double rim = m[axis] > 0.0 ? f.within->min[axis] : f.within->max[axis];
        const double gap = m[axis] * (rim - wall.face.point[axis]);
        if (gap > 0.01 * dx && gap < 0.99 * dx)
          fail(key,
               fmt::format("its rim at {} = {:.6g} m lies {:.3g} m off {}: expected it on the wall, or a spacing or "
                           "more away",
                           "xyz"[axis], rim + scene_.general.origin[axis], gap, name));
      }
  }

  bool in_3d_ = scene_.general.dimension == 3;
};

}  // namespace

void check_plates(const Case& scene, const Places& places) { Plates(scene, places).all(); }

}  // namespace poretwin
