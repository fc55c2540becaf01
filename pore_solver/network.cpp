#include "pore_solver/network.hpp"

#include "common/core/error.hpp"
#include "common/geometry/pieces.hpp"
#include "common/geometry/shapes.hpp"
#include "common/geometry/soil_outline.hpp"
#include "pore_solver/cell_sides.hpp"
#include "pore_solver/network_3d.hpp"
#include "pore_solver/periods.hpp"
#include "pore_solver/stretch.hpp"
#include "pore_solver/wells.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

namespace poretwin::pore {
namespace {

/// Lengths below this value, in spacings, are rounding errors.
constexpr double tiny = 1e-9;

/// A straight part of the soil's border, with the soil on its left, and the face and the rain of the case along this
/// part.
struct BorderPart {
  Piece piece;
  std::size_t line = 0;  ///< number of the straight line on which it lies
  std::size_t face = Segment::none, rain = Segment::none;
};

class Border {
 public:
  explicit Border(const Case& scene) : scene_(scene), spacing_(scene.fluid.particle_spacing) {
    std::vector<Face> faces;
    for (const auto& face : scene.water_faces) faces.push_back(face.face);
    for (const auto& rain : scene.rains) faces.push_back(rain.face);
    const Periods periods(scene);
    for (const auto& [piece, soil, line] : soil_outline(scene, spacing_, faces)) {
      if (periods.on_a_side(std::array{piece.a, piece.b})) continue;
      const Point3 middle = 0.5 * (piece.a + piece.b), inwards = piece.left();
      parts_.push_back({piece, line, owner(scene.water_faces, middle, inwards), owner(scene.rains, middle, inwards)});
    }
  }
  [[nodiscard]] const std::vector<BorderPart>& parts() const { return parts_; }

  /// Moves the border with the points, whose positions as the case draws them are `drawn`, and at present `now`.
  /// Before that, divides the border into parts of at most a spacing.
  void move(const std::vector<Point3>& drawn, const std::vector<Point3>& now) {
    std::vector<BorderPart> moved;
    std::size_t lines = 0;
    for (const auto& part : parts_) {
      const Piece& whole = part.piece;
      const auto pieces = static_cast<int>(std::ceil(whole.length() / spacing_ - tiny));
      for (int i = 0; i < pieces; ++i) {
        const auto end = [&](int k) {
          const Point3 x = whole.a + (whole.b - whole.a) * k / pieces;
          return Point3(x + displacement(x, drawn, now));
        };
        moved.push_back({{end(i), end(i + 1)}, lines++, part.face, part.rain});
      }
    }
    parts_ = std::move(moved);
  }

 private:
  /// Mean displacement of the points around a place of the border.
  [[nodiscard]] Point3 displacement(const Point3& x, const std::vector<Point3>& drawn,
                                    const std::vector<Point3>& now) const {
    constexpr double reach = 1.6;  // spacings; beside a corner the nearest point is at 0.7
    Point3 sum = Point3::Zero();
    double weights = 0.0;
    for (std::size_t a = 0; a < drawn.size(); ++a) {
      const double near = 1.0 - (drawn[a] - x).norm() / (reach * spacing_);
      if (near <= 0.0) continue;
      sum += near * near * (now[a] - drawn[a]);
      weights += near * near;
    }
    return weights > 0.0 ? Point3(sum / weights) : sum;
  }

  /// The last item whose face lies at this place of the border and points inwards; Segment::none where there is none.
  template <class Items>
  [[nodiscard]] std::size_t owner(const Items& items, const Point3& x, const Point3& inwards) const {
    constexpr double parallel = 0.999;
    std::size_t found = Segment::none;
    for (std::size_t i = 0; i < items.size(); ++i) {
      const Face& face = items[i].face;
      const auto looks = [&](const Point3& normal) { return normal.dot(inwards) > parallel; };
      bool here = face.points.empty() && looks(face.normal.normalized()) &&
                  std::abs(face.normal.normalized().dot(x - face.point)) < beside_outline * spacing_;
      for (const auto& piece : pieces_of(face))
        here = here || (looks(piece.left()) && distance_from(piece, x) < beside_outline * spacing_);
      if (here) found = i;
    }
    return found;
  }

  const Case& scene_;
  double spacing_;
  std::vector<BorderPart> parts_;
};

/// One side of a cell's cross-section, and what lies beyond it.
struct CellSide {
  int beyond = 0;  ///< index of a point, or beyond_line() of a line of the border
  Piece piece;     ///< relative to the cell's point
};
constexpr int first_line = -100;
int beyond_line(std::size_t line) { return first_line - static_cast<int>(line); }

std::vector<CellSide> sides_of(voro::voronoicell_neighbor& cell, const Stretch& stretch) {
  std::vector<CellSide> sides;
  for_each_side(cell, [&](int beyond, std::vector<Point3>& corners) {
    for (Point3& x : corners) {
      x.z() = 0.0;
      x = stretch.from(x);
    }
    // The side is the line between the two corners that are farthest apart.
    Piece piece{corners[0], corners[0]};
    for (const Point3& x : corners)
      if ((x - piece.a).norm() > (piece.b - piece.a).norm()) piece.b = x;
    constexpr int lower_lid = -5, upper_lid = -6;
    if (beyond != lower_lid && beyond != upper_lid && piece.length() > tiny) sides.push_back({beyond, piece});
  });
  return sides;
}

/// Whether more than a single point of a straight piece lies within the cross-section.
bool enters(const std::vector<CellSide>& sides, const Piece& piece) {
  double from = 0.0, to = 1.0;
  for (const auto& side : sides) {
    // The cell's point, the origin, lies on the inner side.
    Point3 outwards(side.piece.b.y() - side.piece.a.y(), side.piece.a.x() - side.piece.b.x(), 0.0);
    outwards.normalize();
    if (outwards.dot(side.piece.a) < 0.0) outwards = -outwards;
    const double a = outwards.dot(piece.a - side.piece.a), b = outwards.dot(piece.b - side.piece.a);
    if (a > -tiny && b > -tiny) return false;
    if (a > 0.0) from = std::max(from, a / (a - b));
    if (b > 0.0) to = std::min(to, a / (a - b));
  }
  return (to - from) * piece.length() > tiny;
}

class Maker {
 public:
  explicit Maker(const Case& scene)
      : scene_(scene),
        up_(-scene.general.gravity.normalized()),
        spacing_(scene.fluid.particle_spacing),
        stretch_(scene),
        periods_(scene),
        border_(scene) {}

  Network make() {
    place_points();
    return connect();
  }
  Network make(const Network& drawn, const std::vector<Point3>& now) {
    moved_ = true;
    border_.move(drawn.position, now);
    net_.position = now;
    net_.soil = drawn.soil;
    for (const auto& x : now) net_.elevation.push_back(up_.dot(x));
    net_.volume.assign(net_.size(), 0.0);
    filling_.resize(net_.size());
    return connect();
  }

 private:
  Network connect() {
    std::set<std::pair<Index, Index>> seen;
    // In the container the unit of length, and the layer's thickness, is the spacing. Cells are in stretched space.
    Point3 lower = Point3::Constant(HUGE_VAL), upper = -lower;
    for (const auto& part : border_.parts()) {
      lower = lower.cwiseMin(part.piece.a);
      upper = upper.cwiseMax(part.piece.a);
    }
    origin_ = lower;
    Point3 low = Point3::Zero(), high = low;
    for (const double x : {0.0, upper.x() - lower.x()})
      for (const double y : {0.0, upper.y() - lower.y()}) {
        const Point3 corner = stretch_.to(Point3(x, y, 0.0) / spacing_);
        low = low.cwiseMin(corner);
        high = high.cwiseMax(corner);
      }
    images_ = periods_.images(net_.position);
    for (const int axis : scene_.general.periodic) {
      low[axis] -= stretch_.to(Periods::reach * Point3::Unit(axis))[axis];
      high[axis] += stretch_.to(Periods::reach * Point3::Unit(axis))[axis];
    }
    const Point3 size = high - low;
    constexpr double points_a_block = 5.0;
    const auto blocks = [&](double length) {
      return std::max(1, static_cast<int>(length / std::sqrt(points_a_block)));
    };
    voro::container box(low.x() - 1.0, high.x() + 1.0, low.y() - 1.0, high.y() + 1.0, -0.5, 0.5, blocks(size.x()),
                        blocks(size.y()), 1, false, false, false, 8);
    for (std::size_t i = 0; i < net_.size(); ++i) {
      const Point3 x = stretch_.to(local(net_.position[i]));
      box.put(static_cast<int>(i), x.x(), x.y(), 0.0);
    }
    for (std::size_t i = 0; i < images_.size(); ++i) {
      const Point3 x = stretch_.to(local(net_.position[images_[i].point] + images_[i].shift));
      box.put(static_cast<int>(net_.size() + i), x.x(), x.y(), 0.0);
    }
    voro::c_loop_all loop(box);
    voro::voronoicell_neighbor cell;
    if (loop.start()) do {
        if (loop.pid() >= static_cast<int>(net_.size())) continue;  // an image
        if (!box.compute_cell(cell, loop))
          throw CaseError(fmt::format("{}: two points of soil lie in the same place", scene_.path.string()));
        add(static_cast<Index>(loop.pid()), cell);
      } while (loop.inc());
    const auto order = [](const Link& x, const Link& y) { return std::pair(x.a, x.b) < std::pair(y.a, y.b); };
    std::sort(net_.links.begin(), net_.links.end(), order);
    std::stable_sort(net_.segments.begin(), net_.segments.end(),
                     [](const Segment& x, const Segment& y) { return x.point < y.point; });
    net_.first_filling.push_back(0);
    for (const auto& filling : filling_) {
      net_.fillings.insert(net_.fillings.end(), filling.begin(), filling.end());
      net_.first_filling.push_back(static_cast<Index>(net_.fillings.size()));
    }
    return std::move(net_);
  }

  [[nodiscard]] Point3 local(const Point3& x) const {
    Point3 y = (x - origin_) / spacing_;
    y.z() = 0.0;
    return y;
  }

  /// The points are ordered column by column, from the top down. Flow depends most on what lies above, along gravity,
  /// and incomplete factors are accurate in this order.
  void place_points() {
    struct Place {
      Point3 at;
      std::size_t soil;
    };
    std::vector<Place> places;
    std::vector<Shape> shapes;
    for (const auto& soil : scene_.soils) shapes.push_back(soil.shape);
    const auto& f = scene_.fluid;
    const auto& moving = scene_.solid;  // in moving soil the points are the soil's particles
    const bool moves = scene_.deformable();
    for (std::size_t s = 0; s < shapes.size(); ++s) {
      const auto lattice =
          fill<2>(shapes[s], spacing_, moves ? moving.offset : f.offset, moves ? moving.jitter : f.jitter,
                  (moves ? moving.seed : f.seed) + static_cast<unsigned>(s), std::span(shapes).subspan(s + 1));
      for (const auto& x : lattice.position) places.push_back({Point3(x.x(), x.y(), 0.0), s});
    }
    const Point3 across(up_.y(), -up_.x(), 0.0);
    const auto column = [&](const Place& p) { return std::floor(across.dot(p.at) / spacing_); };
    std::stable_sort(places.begin(), places.end(), [&](const Place& p, const Place& q) {
      return std::pair(column(p), -up_.dot(p.at)) < std::pair(column(q), -up_.dot(q.at));
    });
    for (const auto& p : places) {
      net_.position.push_back(p.at);
      net_.soil.push_back(p.soil);
      net_.elevation.push_back(up_.dot(p.at));
    }
    net_.volume.assign(net_.size(), 0.0);
    filling_.resize(net_.size());
  }

  void add(Index a, voro::voronoicell_neighbor& cell) {
    const Point3 x = local(net_.position[a]);
    const auto relative = [&](const Piece& piece) { return Piece{local(piece.a) - x, local(piece.b) - x}; };
    // The nearest parts of the border cut the cell first: then the cell no longer reaches the parts beyond them.
    std::vector<std::pair<double, const BorderPart*>> near;
    const double reach = std::sqrt(cell.max_radius_squared()) / stretch_.least();
    for (const auto& part : border_.parts())
      if (const double distance = distance_from(relative(part.piece), Point3::Zero()); distance < reach)
        near.emplace_back(distance, &part);
    std::stable_sort(near.begin(), near.end(), [](const auto& p, const auto& q) { return p.first < q.first; });
    auto sides = sides_of(cell, stretch_);
    std::set<std::size_t> cut;
    for (const auto& [distance, part] : near) {
      const Piece piece = relative(part->piece);
      if (cut.contains(part->line) || !enters(sides, piece)) continue;
      const Point3 outwards = -piece.left();
      const double deep = outwards.dot(piece.a);
      const Point3 image = stretch_.to_image(outwards, deep);
      if (!(deep > tiny) || !cell.nplane(image.x(), image.y(), 0.0, beyond_line(part->line)))
        throw CaseError(fmt::format("{}: a point of soil lies on the soil's border", scene_.path.string()));
      cut.insert(part->line);
      sides = sides_of(cell, stretch_);
    }
    net_.volume[a] = cell.volume() * spacing_ * spacing_ / stretch_.growth();
    filling_[a] = filling(x, sides);
    for (const auto& side : sides) {
      const Piece piece{net_.position[a] + spacing_ * side.piece.a, net_.position[a] + spacing_ * side.piece.b};
      if (side.beyond <= first_line)
        segments(a, piece, static_cast<std::size_t>(first_line - side.beyond));
      else if (side.beyond >= static_cast<int>(net_.size()))
        link_across(a, images_[static_cast<std::size_t>(side.beyond) - net_.size()], piece);
      else if (side.beyond > static_cast<int>(a))
        link(a, static_cast<Index>(side.beyond), Point3::Zero(), piece);
      else if (side.beyond < 0)
        throw CaseError(fmt::format("{}: the border of the soil is not closed", scene_.path.string()));
    }
  }

  /// The fraction of the cell's area below each of its corners. Between the elevations of two corners the area is
  /// interpolated linearly.
  [[nodiscard]] std::vector<Filling> filling(const Point3& x, const std::vector<CellSide>& sides) const {
    std::vector<double> levels;
    for (const auto& side : sides)
      for (const auto& end : {side.piece.a, side.piece.b}) levels.push_back(up_.dot(end));
    std::sort(levels.begin(), levels.end());
    levels.erase(std::unique(levels.begin(), levels.end(), [](double p, double q) { return q - p < 1e-6; }),
                 levels.end());
    const Point3 across(up_.y(), -up_.x(), 0.0);
    /// Width of the cell at an elevation within it.
    const auto width = [&](double level) {
      double least = HUGE_VAL, most = -HUGE_VAL;
      for (const auto& [beyond, piece] : sides) {
        const double p = up_.dot(piece.a) - level, q = up_.dot(piece.b) - level;
        if (p * q > 0.0 || p == q) continue;
        const double s = across.dot(piece.a + p / (p - q) * (piece.b - piece.a));
        least = std::min(least, s);
        most = std::max(most, s);
      }
      return std::max(0.0, most - least);
    };
    const double base = up_.dot(origin_) + spacing_ * up_.dot(x);
    std::vector<Filling> result{{base + spacing_ * levels.front(), 0.0}};
    for (std::size_t i = 0; i + 1 < levels.size(); ++i)
      result.push_back({base + spacing_ * levels[i + 1],
                        result.back().share + (levels[i + 1] - levels[i]) * width(0.5 * (levels[i] + levels[i + 1]))});
    if (result.size() == 1) result.push_back({base, 1.0});  // without gravity every cell counts as one level
    const double whole = result.back().share;
    for (auto& f : result) f.share /= whole;
    return result;
  }

  void link_across(Index a, const Periods::Image& image, const Piece& piece) {
    periods_.expect_on_a_side(0.5 * (piece.a + piece.b), image.shift);
    if (image.counts_for(a)) link(a, image.point, image.shift, piece);
  }

  /// shift: from b to the image of b with which a is linked; zero for b itself.
  void link(Index a, Index b, const Point3& shift, const Piece& face) {
    const Point3 way = net_.position[b] + shift - net_.position[a];
    for (const auto& wall : scene_.walls) {
      if (wall.water == Wall::ForWater::none) continue;
      for (const auto& piece : pieces_of(wall.face))
        for (const Point3& from : {net_.position[a], Point3(net_.position[a] - shift)})
          if (const auto met = distance_to(piece, from, way.normalized()); met && *met < way.norm()) return;
    }
    const double p = up_.dot(face.a), q = up_.dot(face.b);
    const auto along = [&](Index i) { return stretch_.between(scene_, scene_.soils[net_.soil[i]], way); };
    net_.links.push_back({a, b, face.length() / way.norm(), along(a), along(b), 0.5 * (face.a + face.b), std::min(p, q),
                          std::max(p, q), shift, up_.dot(shift)});
  }

  /// Adds the segments of a cell's side on the border: one for each part of the border with a face or rain.
  void segments(Index a, const Piece& side, std::size_t line) {
    for (const auto& part : border_.parts()) {
      if (part.line != line || (part.face == Segment::none && part.rain == Segment::none)) continue;
      const Point3 along = (part.piece.b - part.piece.a).normalized();
      double from = along.dot(side.a - part.piece.a), to = along.dot(side.b - part.piece.a);
      if (from > to) std::swap(from, to);
      // On a border that has moved, a side may lie along several parts: it belongs to the nearest part.
      if (!moved_) {
        from = std::max(from, 0.0);
        to = std::min(to, part.piece.length());
      }
      if (to - from < tiny * spacing_) continue;
      const Point3 first = part.piece.a + from * along, last = part.piece.a + to * along;
      Segment s;
      s.point = a;
      s.face = part.face;
      s.rain = part.rain;
      s.area = to - from;
      s.level_area = s.area * std::max(0.0, -up_.dot(part.piece.left()));
      s.transmissibility = s.area / part.piece.left().dot(net_.position[a] - part.piece.a);
      s.across = Stretch::through(scene_, scene_.soils[net_.soil[a]], part.piece.left());
      s.centre = 0.5 * (first + last);
      s.low = std::min(up_.dot(first), up_.dot(last));
      s.high = std::max(up_.dot(first), up_.dot(last));
      net_.segments.push_back(s);
    }
  }

  const Case& scene_;
  Point3 up_;
  double spacing_;
  Stretch stretch_;
  Periods periods_;
  std::vector<Periods::Image> images_;
  Border border_;
  bool moved_ = false;
  Point3 origin_ = Point3::Zero();
  Network net_;
  std::vector<std::vector<Filling>> filling_;  ///< for each cell
};

}  // namespace

Network make_network(const Case& scene) {
  Network network = scene.general.dimension == 3 ? make_network_3d(scene) : Maker(scene).make();
  add_wells(scene, network);
  return network;
}

Network make_network(const Case& scene, const Network& drawn, const std::vector<Point3>& now) {
  try {
    return Maker(scene).make(drawn, now);
  } catch (const CaseError&) {
    throw DivergedError("the soil has moved so far that its surface has folded over its points: a field ends here");
  }
}

}  // namespace poretwin::pore
