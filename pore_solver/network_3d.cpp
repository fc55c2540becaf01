#include "pore_solver/network_3d.hpp"

#include "common/core/error.hpp"
#include "common/geometry/shapes.hpp"
#include "common/geometry/soil_surface.hpp"
#include "common/geometry/solid.hpp"
#include "pore_solver/cell_sides.hpp"
#include "pore_solver/periods.hpp"
#include "pore_solver/polygon.hpp"
#include "pore_solver/stretch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

namespace poretwin::pore {
namespace space {
namespace {

/// Lengths and areas below this value, in spacings and their squares, are rounding errors.
constexpr double tiny = 1e-9;
/// Largest distance from a plane, in spacings, at which a place counts as on the plane.
constexpr double beside = 1e-3;

/// One side of a cell, and what lies beyond it.
struct CellSide {
  int beyond = 0;   ///< index of a point, or beyond_facet() of a facet of the soil's surface
  Polygon corners;  ///< relative to the cell's point, in spacings
  Point3 outwards;  ///< unit vector
  Point3 centre;
  double area = 0.0, deep = 0.0;  ///< deep: distance of the side's plane from the point
};
constexpr int first_facet = -100;
int beyond_facet(Index facet) { return first_facet - static_cast<int>(facet); }

std::vector<CellSide> sides_of(voro::voronoicell_neighbor& cell, const Stretch& stretch) {
  std::vector<CellSide> sides;
  for_each_side(cell, [&](int beyond, Polygon& corners) {
    for (Point3& x : corners) x = stretch.from(x);
    const Measure m = measure(corners);
    if (m.area < tiny) return;
    // The cell is convex, and its point lies inside it.
    const Point3 outwards = m.normal.dot(m.centre) < 0.0 ? Point3(-m.normal) : m.normal;
    sides.push_back({beyond, corners, outwards, m.centre, m.area, outwards.dot(m.centre)});
  });
  return sides;
}

/// The part of a polygon strictly inside a cell; empty where there is none.
Polygon part_within(const std::vector<CellSide>& sides, Polygon polygon) {
  for (const auto& side : sides) {
    polygon = below(polygon, side.outwards, side.deep - tiny);
    if (polygon.size() < 3) return {};
  }
  return measure(polygon).area > tiny ? polygon : Polygon{};
}

/// Divides a polygon [m] into the parts inside a shape and the parts outside. Boxes along the axes cut it exactly,
/// other shapes to 1/64 of the polygon. slack [m]: how far a box extends beyond what is drawn, so that sides on its
/// border count as inside.
std::pair<std::vector<Polygon>, std::vector<Polygon>> divided(const Polygon& polygon, const Shape& shape,
                                                              double slack) {
  std::pair<std::vector<Polygon>, std::vector<Polygon>> parts;
  if (shape.kind == Shape::Kind::box && !shape.solid) {
    Polygon inside = polygon;
    for (int d = 0; d < 3; ++d)
      for (const double sign : {-1.0, 1.0}) {
        const Point3 direction = sign * Point3::Unit(d);
        const double limit = (sign > 0.0 ? shape.max[d] : -shape.min[d]) + slack;
        if (Polygon rest = below(inside, -direction, -limit); rest.size() >= 3) parts.second.push_back(std::move(rest));
        inside = below(inside, direction, limit);
        if (inside.size() < 3) return parts;
      }
    parts.first.push_back(std::move(inside));
    return parts;
  }
  constexpr int divisions = 2;
  for (auto& triangle : triangles_of(polygon, divisions)) {
    const bool in = contains(shape, (triangle[0] + triangle[1] + triangle[2]) / 3.0, 3);
    (in ? parts.first : parts.second).push_back(std::move(triangle));
  }
  if (parts.second.empty()) parts.first = {polygon};
  if (parts.first.empty()) parts.second = {polygon};
  return parts;
}

class Maker {
 public:
  explicit Maker(const Case& scene)
      : scene_(scene),
        up_(-scene.general.gravity.normalized()),
        spacing_(scene.fluid.particle_spacing),
        stretch_(scene),
        periods_(scene),
        surface_(scene, spacing_) {}

  Network make() {
    place_points();
    // In the container the spacing is the unit of length. Cells are made in stretched space.
    Point3 lower = Point3::Constant(HUGE_VAL), upper = -lower;
    for (const auto& soil : scene_.soils) {
      const auto [low, high] = bounds(soil.shape);
      lower = lower.cwiseMin(low);
      upper = upper.cwiseMax(high);
    }
    origin_ = lower;
    Point3 low = Point3::Zero(), high = low;
    for (int corner = 0; corner < 8; ++corner) {
      Point3 x = Point3::Zero();
      for (int d = 0; d < 3; ++d)
        if ((corner >> d) & 1) x[d] = (upper[d] - lower[d]) / spacing_;
      low = low.cwiseMin(stretch_.to(x));
      high = high.cwiseMax(stretch_.to(x));
    }
    images_ = periods_.images(net_.position);
    for (const int axis : scene_.general.periodic) {
      low[axis] -= stretch_.to(Periods::reach * Point3::Unit(axis))[axis];
      high[axis] += stretch_.to(Periods::reach * Point3::Unit(axis))[axis];
    }
    const Point3 size = high - low;
    constexpr double points_a_block = 5.0;  // blocks with this number of points are near the fastest for voro++
    const auto blocks = [&](double length) {
      return std::max(1, static_cast<int>(length / std::cbrt(points_a_block)));
    };
    voro::container box(low.x() - 1.0, high.x() + 1.0, low.y() - 1.0, high.y() + 1.0, low.z() - 1.0, high.z() + 1.0,
                        blocks(size.x()), blocks(size.y()), blocks(size.z()), false, false, false, 8);
    for (std::size_t i = 0; i < net_.size(); ++i) {
      const Point3 x = stretch_.to(local(net_.position[i]));
      box.put(static_cast<int>(i), x.x(), x.y(), x.z());
    }
    for (std::size_t i = 0; i < images_.size(); ++i) {
      const Point3 x = stretch_.to(local(net_.position[images_[i].point] + images_[i].shift));
      box.put(static_cast<int>(net_.size() + i), x.x(), x.y(), x.z());
    }
    voro::c_loop_all loop(box);
    voro::voronoicell_neighbor cell;
    if (loop.start()) do {
        if (loop.pid() >= static_cast<int>(net_.size())) continue;  // an image
        if (!box.compute_cell(cell, loop))
          throw CaseError(fmt::format("{}: two points of soil lie in the same place", scene_.path.string()));
        add(static_cast<Index>(loop.pid()), cell);
      } while (loop.inc());
    std::sort(net_.links.begin(), net_.links.end(),
              [](const Link& x, const Link& y) { return std::pair(x.a, x.b) < std::pair(y.a, y.b); });
    std::stable_sort(net_.segments.begin(), net_.segments.end(),
                     [](const Segment& x, const Segment& y) { return x.point < y.point; });
    net_.first_filling.push_back(0);
    for (const auto& filling : filling_) {
      net_.fillings.insert(net_.fillings.end(), filling.begin(), filling.end());
      net_.first_filling.push_back(static_cast<Index>(net_.fillings.size()));
    }
    return std::move(net_);
  }

 private:
  [[nodiscard]] Point3 local(const Point3& x) const { return (x - origin_) / spacing_; }

  /// The points of one soil: those points of a lattice over the soil's box that lie in the soil.
  [[nodiscard]] std::vector<Point3> points_of(std::size_t s) const {
    const Shape& shape = scene_.soils[s].shape;
    const auto& f = scene_.fluid;
    const auto& moving = scene_.solid;
    if (scene_.deformable())  // the points are the soil's particles
      return lay<3>(shape, spacing_, moving.offset, moving.jitter, moving.seed + static_cast<unsigned>(s)).position;
    const unsigned seed = f.seed + static_cast<unsigned>(s);
    if (!is_packed(shape)) return fill<3>(shape, spacing_, f.offset, f.jitter, seed).position;
    Shape around;
    std::tie(around.min, around.max) = bounds(shape);
    std::vector<Point3> points;
    for (const auto& x : fill<3>(around, spacing_, f.offset, f.jitter, seed).position)
      if (shape.solid->depth(x, spacing_) > 1e-6 * spacing_) points.push_back(x);
    return points;
  }

  /// The points are ordered column by column, from the top down. Flow depends most on what lies above, along gravity,
  /// and incomplete factors are accurate in this order.
  void place_points() {
    std::vector<std::pair<Point3, std::size_t>> places;
    for (std::size_t s = 0; s < scene_.soils.size(); ++s) {
      const std::size_t before = places.size();
      for (const auto& x : points_of(s)) places.emplace_back(x, s);
      if (places.size() == before)
        throw CaseError(
            fmt::format("{}: soil[{}] is so thin that no point of the field lies in it; expected a smaller "
                        "fluid.particle_spacing than {} m",
                        scene_.path.string(), s, spacing_));
    }
    const Point3 u = up_.isZero() ? Point3::UnitX() : up_.unitOrthogonal(),
                 v = up_.isZero() ? Point3::UnitY() : up_.cross(u);
    const auto order = [&](const std::pair<Point3, std::size_t>& p) {
      return std::tuple(std::floor(u.dot(p.first) / spacing_), std::floor(v.dot(p.first) / spacing_),
                        -up_.dot(p.first));
    };
    std::stable_sort(places.begin(), places.end(), [&](const auto& p, const auto& q) { return order(p) < order(q); });
    for (const auto& [x, soil] : places) {
      net_.position.push_back(x);
      net_.soil.push_back(soil);
      net_.elevation.push_back(up_.dot(x));
    }
    net_.volume.assign(net_.size(), 0.0);
    filling_.resize(net_.size());
  }

  void add(Index a, voro::voronoicell_neighbor& cell) {
    const Point3 x = net_.position[a];
    // The nearest facets cut the cell first: then the cell no longer reaches the facets behind them.
    std::vector<TriangleMesh::Nearest> near;
    surface_.facets().for_each_near(x, std::sqrt(cell.max_radius_squared()) / stretch_.least() * spacing_,
                                    [&](const TriangleMesh::Nearest& n) { near.push_back(n); });
    std::sort(near.begin(), near.end(), [](const auto& p, const auto& q) {
      return std::tie(p.distance, p.facet) < std::tie(q.distance, q.facet);
    });
    auto sides = sides_of(cell, stretch_);
    // A cell that is still open extends beyond the soil, where parts of facets are no border. Facets that are border
    // all over the cell cut it first; the others are then judged by what is left of the cell.
    for (const auto& pass : in_two_passes(near)) {
      const double share = pass.first;
      const TriangleMesh::Nearest& n = pass.second;
      const auto& triangles = surface_.facets().triangles();
      Polygon facet, drawn;
      for (const Index corner : triangles.facets[n.facet]) drawn.push_back(triangles.points[corner]);
      if (periods_.on_a_side(drawn)) continue;
      for (const Point3& corner : drawn) facet.emplace_back((corner - x) / spacing_);
      const Point3 outwards = surface_.facets().normal(n.facet);
      const double deep = outwards.dot(facet[0]);
      // Facets that the point sees from behind belong to soil beyond a gap, or to a neighbouring soil.
      if (deep < 0.0) continue;
      if (part_within(sides, std::move(facet)).empty()) continue;
      voro::voronoicell_neighbor rest;  // its copy constructor would share memory
      rest = cell;
      const Point3 image = stretch_.to_image(outwards, deep);
      if (!(deep > tiny) || !rest.nplane(image.x(), image.y(), image.z(), beyond_facet(n.facet)))
        throw CaseError(fmt::format("{}: a point of soil lies on the soil's border", scene_.path.string()));
      auto left = sides_of(rest, stretch_);
      const auto section = std::find_if(left.begin(), left.end(),
                                        [&](const CellSide& side) { return side.beyond == beyond_facet(n.facet); });
      if (section == left.end()) continue;
      if (!(open_share(x, *section) > share)) continue;
      cell = rest;
      sides = std::move(left);
    }
    net_.volume[a] = cell.volume() * spacing_ * spacing_ * spacing_ / stretch_.growth();
    filling_[a] = filling(x, sides);
    for (const auto& side : sides) {
      if (side.beyond <= first_facet)
        segments(a, side);
      else if (side.beyond >= static_cast<int>(net_.size()))
        link_across(a, images_[static_cast<std::size_t>(side.beyond) - net_.size()], side);
      else if (side.beyond > static_cast<int>(a))
        link(a, static_cast<Index>(side.beyond), Point3::Zero(), side);
      else if (side.beyond < 0)
        throw CaseError(fmt::format("{}: the border of the soil is not closed near [{:.6g}, {:.6g}, {:.6g}] m",
                                    scene_.path.string(), x.x(), x.y(), x.z()));
    }
  }

  /// Each facet twice, with the share of border that it needs to cut: first in a maybe open cell, then in the rest.
  static std::vector<std::pair<double, TriangleMesh::Nearest>> in_two_passes(
      const std::vector<TriangleMesh::Nearest>& near) {
    constexpr double nearly_all = 0.9, most = 0.5;
    std::vector<std::pair<double, TriangleMesh::Nearest>> result;
    for (const double share : {nearly_all, most})
      for (const auto& n : near) result.emplace_back(share, n);
    return result;
  }

  /// The fraction of a cell's section along a facet that is the soil's border, neither hidden by other shapes nor by
  /// other soil. Only the surroundings of the point count, since open cells extend far.
  [[nodiscard]] double open_share(const Point3& x, const CellSide& section) const {
    constexpr int divisions = 1;
    constexpr double reach = 0.8;  // spacings; beyond the middle between neighbours, but before the next point
    Polygon around = section.corners;
    for (int d = 0; d < 3; ++d)
      for (const double sign : {-1.0, 1.0}) around = below(around, sign * Point3::Unit(d), reach);
    if (!(measure(around).area > tiny)) around = section.corners;
    double border = 0.0, all = 0.0;
    for (const auto& triangle : triangles_of(around, divisions)) {
      const Measure m = measure(triangle);
      all += m.area;
      if (surface_.is_open(x + spacing_ * m.centre, section.outwards)) border += m.area;
    }
    return border / all;
  }

  /// The fraction of the cell's volume below the elevations of its corners. Between two elevations the volume is
  /// interpolated linearly.
  [[nodiscard]] std::vector<Filling> filling(const Point3& x, const std::vector<CellSide>& sides) const {
    const double base = up_.dot(x);
    if (up_.isZero()) return {{base, 0.0}, {base, 1.0}};  // without gravity every cell counts as one level
    std::vector<double> levels;
    for (const auto& side : sides)
      for (const auto& corner : side.corners) levels.push_back(up_.dot(corner));
    std::sort(levels.begin(), levels.end());
    constexpr double same = 1e-6;
    levels.erase(std::unique(levels.begin(), levels.end(), [](double p, double q) { return q - p < same; }),
                 levels.end());
    // Cells of disordered points have many corners: even strips are then as good, and cheaper.
    constexpr std::size_t most = 9;
    if (levels.size() > most) {
      const double low = levels.front(), high = levels.back();
      levels.resize(most);
      for (std::size_t i = 0; i < most; ++i) levels[i] = low + (high - low) * static_cast<double>(i) / (most - 1);
    }
    // The volume below a level is a sum of cones: from a point in the level's plane to the parts of the sides below it.
    const auto volume = [&](double level) {
      double sum = 0.0;
      for (const auto& side : sides) {
        const Measure m = measure(below(side.corners, up_, level));
        sum += m.area * side.outwards.dot(m.centre - level * up_) / 3.0;
      }
      return sum;
    };
    std::vector<Filling> result{{base + spacing_ * levels.front(), 0.0}};
    const double whole = volume(levels.back());
    for (std::size_t i = 1; i + 1 < levels.size(); ++i)
      result.push_back({base + spacing_ * levels[i], std::clamp(volume(levels[i]) / whole, result.back().share, 1.0)});
    result.push_back({base + spacing_ * levels.back(), 1.0});
    return result;
  }

  [[nodiscard]] std::pair<double, double> extent(const Polygon& corners) const {
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (const auto& corner : corners) {
      low = std::min(low, up_.dot(corner));
      high = std::max(high, up_.dot(corner));
    }
    return {low, high};
  }

  void link_across(Index a, const Periods::Image& image, const CellSide& side) {
    periods_.expect_on_a_side(net_.position[a] + spacing_ * side.centre, image.shift);
    if (image.counts_for(a)) link(a, image.point, image.shift, side);
  }

  /// shift: from b to the image of b with which a is linked; zero for b itself.
  void link(Index a, Index b, const Point3& shift, const CellSide& side) {
    const Point3 x = net_.position[a];
    const Point3 way = net_.position[b] + shift - x;
    const auto along = [&](Index i) { return stretch_.between(scene_, scene_.soils[net_.soil[i]], way); };
    const auto [low, high] = extent(side.corners);
    const double z = up_.dot(x);
    net_.links.push_back({a, b, side.area * spacing_ * spacing_ / way.norm(), along(a), along(b),
                          x + spacing_ * side.centre, z + spacing_ * low, z + spacing_ * high, shift, up_.dot(shift)});
  }

  /// Adds the segments of a cell's side on the border: one for each combination of a face and a rain along it.
  void segments(Index a, const CellSide& side) {
    struct Owned {
      Polygon part;
      std::size_t face = Segment::none, rain = Segment::none;
    };
    Polygon whole;
    for (const auto& corner : side.corners) whole.push_back(net_.position[a] + spacing_ * corner);
    std::vector<Owned> parts{{whole}};
    // The last item at a place owns it.
    const auto give = [&](const auto& items, std::size_t Owned::*owner) {
      for (std::size_t i = 0; i < items.size(); ++i) {
        Face plane = items[i].face;
        plane.within.reset();
        const auto& within = items[i].face.within;
        if (plane.normal.isZero() && !within) continue;
        if (owner == &Owned::rain && !(up_.dot(side.outwards) > tiny)) continue;  // rain falls on upward sides only
        const SoilSurface::Place place{net_.position[a] + spacing_ * side.centre, side.outwards};
        if (!lies_along(plane, place, beside * spacing_)) continue;
        std::vector<Owned> next;
        for (auto& owned : parts) {
          if (!within) {
            owned.*owner = i;
            next.push_back(std::move(owned));
            continue;
          }
          auto [in, out] = divided(owned.part, *within, 1e-6 * spacing_);
          for (auto& part : out) next.push_back({std::move(part), owned.face, owned.rain});
          for (auto& part : in) {
            next.push_back({std::move(part), owned.face, owned.rain});
            next.back().*owner = i;
          }
        }
        parts = std::move(next);
      }
    };
    give(scene_.water_faces, &Owned::face);
    give(scene_.rains, &Owned::rain);
    const std::size_t before = net_.segments.size();
    for (const auto& owned : parts) {
      if (owned.face == Segment::none && owned.rain == Segment::none) continue;
      const Measure m = measure(owned.part);
      if (m.area < 1e-5 * spacing_ * spacing_) continue;  // cut off by the slack of a box only
      const auto [low, high] = extent(owned.part);
      const auto same = [&](const Segment& s) { return s.face == owned.face && s.rain == owned.rain; };
      auto found = std::find_if(net_.segments.begin() + static_cast<std::ptrdiff_t>(before), net_.segments.end(), same);
      if (found == net_.segments.end()) {
        Segment s;
        s.point = a;
        s.face = owned.face;
        s.rain = owned.rain;
        s.low = low;
        s.high = high;
        net_.segments.push_back(s);
        found = net_.segments.end() - 1;
      }
      found->centre = (found->area * found->centre + m.area * m.centre) / (found->area + m.area);
      found->area += m.area;
      found->low = std::min(found->low, low);
      found->high = std::max(found->high, high);
    }
    for (std::size_t i = before; i < net_.segments.size(); ++i) {
      Segment& s = net_.segments[i];
      s.level_area = s.area * std::max(0.0, up_.dot(side.outwards));
      s.transmissibility = s.area / (spacing_ * side.deep);
      s.across = Stretch::through(scene_, scene_.soils[net_.soil[a]], side.outwards);
    }
  }

  const Case& scene_;
  Point3 up_;
  double spacing_;
  Stretch stretch_;
  Periods periods_;
  std::vector<Periods::Image> images_;
  SoilSurface surface_;
  Point3 origin_ = Point3::Zero();
  Network net_;
  std::vector<std::vector<Filling>> filling_;  ///< for each cell
};

}  // namespace
}  // namespace space

Network make_network_3d(const Case& scene) { return space::Maker(scene).make(); }

}  // namespace poretwin::pore
