#include "common/case/plates.hpp"

#include "common/case/complaints.hpp"
#include "common/geometry/extent.hpp"
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
      line(plate.face, key);
      motion(plate, key);
      if (!(scene_.solid.particle_spacing > 0.0)) continue;  // reported elsewhere
      touches_soil(plate.face, key);
      beside_walls(plate.face, key);
    }
  }

 private:
  /// Refuses plates in cases that cannot compute them.
  void belongs_here(const std::string& key) const {
    if (scene_.general.dimension != 2) fail(key, "plates are for dimension = 2; expected none in 3D");
    if (!scene_.deformable()) fail(key, "with solid.model = \"rigid\" nothing gives way to a plate");
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
    if (plate.along && plate.surface != Plate::Surface::rough)
      fail(key + ".along", "a smooth plate does not take the soil along: expected surface = \"rough\"");
    if (!plate.force && plate.start) fail(key + ".start", "is the time from which 'force' acts: expected 'force'");
    if (!plate.force && plate.mass)
      fail(key + ".mass", "a plate that moves in a prescribed way needs no mass: expected 'force', or no 'mass'");
  }

  [[nodiscard]] bool soil_at(const Point3& x) const {
    return std::ranges::any_of(scene_.soils, [&](const Soil& soil) { return contains(soil.shape, x, 2); });
  }

  /// Refuses plates that lie away from the soil or inside it, or with a narrow gap before them: images of soil across a
  /// gap would act on the soil as if it touched the plate.
  void touches_soil(const Face& f, const std::string& key) const {
    const double dx = scene_.solid.particle_spacing;
    constexpr double beside = 0.05, reach = 1.5;  // spacings; the kernel reaches the image of a particle at 1.2
    double touched = 0.0;
    const auto look = [&](const Point3& x, const Point3& normal, double length) {
      if (soil_at(x - beside * dx * normal))
        fail(key, fmt::format("soil lies behind the plate at {} m: expected soil only on the side to which the plate "
                              "presses, the left of its line",
                              shown(x)));
      if (soil_at(x + beside * dx * normal))
        touched += length;
      else if (soil_at(x + reach * dx * normal))
        fail(key, fmt::format("a gap is left between the plate and the soil before it at {} m: expected a plate on the "
                              "soil's surface",
                              shown(x)));
    };
    if (f.points.empty()) {
      const Point3 n = f.normal.normalized(), along(-n.y(), n.x(), 0.0);
      Point3 low = Point3::Constant(HUGE_VAL), high = -low;  // extent of all soil along the plate
      for (const Soil& soil : scene_.soils)
        for (const auto& x : fill<2>(soil.shape, dx, {0.5, 0.5, 0.5}, 0.0, 1).position) {
          low.x() = std::min(low.x(), along.head<2>().dot(x));
          high.x() = std::max(high.x(), along.head<2>().dot(x));
        }
      for (double s = low.x(); s <= high.x(); s += dx) look(n.dot(f.point) * n + s * along, n, dx);
    }
    for (const Piece& piece : pieces_of(f)) {
      const auto places = places_along(piece, dx);
      for (const Point3& x : places) look(x, piece.left(), piece.length() / static_cast<double>(places.size()));
    }
    constexpr double parallel = 0.02;  // sine of an angle
    const Point3 along =
        f.points.empty() ? Point3(-f.normal.y(), f.normal.x(), 0.0) : Point3(f.points[1] - f.points[0]);
    const bool on_rows = along.cwiseAbs().head<2>().minCoeff() < parallel * along.norm();
    if (!on_rows &&
        !std::ranges::all_of(scene_.soils, [](const Soil& s) { return turned_rectangle(s.shape).has_value(); }))
      fail(key,
           "the plate lies at an angle to the rows of the soil's particles, and the stress on it would be off by up "
           "to 40 %: expected a plate along x or y, with case.gravity turned instead, or soil drawn as a rectangle");
    constexpr double least = 2.0;  // spacings
    if (touched < (least - 1e-6) * dx)
      fail(key, fmt::format("the plate lies off the soil: {:.3g} m of its line touch soil, expected at least {:.3g} m "
                            "({:g} spacings)",
                            touched, least * dx, least));
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
};

}  // namespace

void check_plates(const Case& scene, const Places& places) { Plates(scene, places).all(); }

}  // namespace poretwin
