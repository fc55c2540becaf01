#include "solid_solver/discretisation/boundaries.hpp"

#include "common/core/error.hpp"
#include "common/geometry/thin_walls.hpp"
#include "solid_solver/discretisation/ranks.hpp"
#include "solid_solver/discretisation/turning.hpp"
#include "solid_solver/dynamics/wall_friction.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>
#include <optional>
#include <set>

namespace poretwin::solid {

template <int D>
std::vector<sph::ImagePlane<D>> plate_planes(const Plate& plate) {
  auto planes = planes_of<D>(plate.face, 0, 0.0);
  if constexpr (D == 3)
    if (const auto& part = plate.face.within) {
      Eigen::Index across = 0;
      planes[0].normal.cwiseAbs().maxCoeff(&across);
      const Eigen::Index first = (across + 1) % 3, second = (across + 2) % 3;
      planes[0].tangent = Vec<3>::Unit(first);
      planes[0].from = part->min[first];
      planes[0].to = part->max[first];
      planes[0].second_tangent = Vec<3>::Unit(second);
      planes[0].second_from = part->min[second];
      planes[0].second_to = part->max[second];
    }
  return planes;
}

namespace {

/// Extends a rectangle that reaches a wall or another plate, or goes beyond it, to `margin` [m] behind it (3D).
template <int D>
void close_corners(const std::vector<sph::ImagePlane<D>>& others, double margin, sph::ImagePlane<D>& plate) {
  const Vec<D>&u = plate.tangent, &v = plate.second_tangent;
  const Vec<D> middle =
      plate.at(0.5 * (plate.from + plate.to)) + (0.5 * (plate.second_from + plate.second_to) - v.dot(plate.point)) * v;
  const auto extend = [&](const Vec<D>& along, double& from, double& to) {
    for (const auto& other : others) {
      const double facing = other.normal.dot(along), level = along.dot(other.point);
      if (std::abs(facing) < 0.99 || !other.faces(middle + (level - along.dot(middle)) * along)) continue;
      if (facing > 0.0 && from < level + 1e-3 * margin) from = level - margin;
      if (facing < 0.0 && to > level - 1e-3 * margin) to = level + margin;
    }
  };
  extend(u, plate.from, plate.to);
  extend(v, plate.second_from, plate.second_to);
}

/// Ends planes where a plate begins or ends on the same line or plane and looks to the same side, so that each particle
/// has one image there. Walls have been extended beyond their ends. A particle on the common end itself belongs to the
/// plane before it.
template <int D>
void meet_plates(double margin, Boundaries<D>& boundaries) {
  const std::vector<sph::ImagePlane<D>> drawn = boundaries.planes;
  const double close = 1e-3 * margin, after = 1e-6 * margin;
  /// Ends [from, to] of a plane at an end of the plate's [begin, end].
  const auto meet = [&](double begin, double end, double& from, double& to) {
    const bool first = from + to < begin + end;
    if (first && from < begin - close && to > begin - close) to = begin + after;
    if (!first && to > end + close && from < end + close) from = end + after;
  };
  for (std::size_t k = 0; k < drawn.size(); ++k)
    for (std::size_t j = 0; j < drawn.size(); ++j) {
      const auto &plate = drawn[k], &other = drawn[j];
      const bool same_plane =
          plate.normal.dot(other.normal) > 1.0 - 1e-6 && std::abs(plate.normal.dot(other.point - plate.point)) < close;
      if (j == k || boundaries.plate[k] < 0 || !same_plane || !(plate.to > plate.from) || !(other.to > other.from))
        continue;
      auto& plane = boundaries.planes[j];
      const bool beside =
          D == 2 || (other.second_from < plate.second_to - close && other.second_to > plate.second_from + close);
      if (beside) meet(plate.from, plate.to, plane.from, plane.to);
      if (D == 3 && other.from < plate.to - close && other.to > plate.from + close)
        meet(plate.second_from, plate.second_to, plane.second_from, plane.second_to);
    }
}

/// Adds the plates after the walls. A plate that ends on a wall or on another plate is extended beyond it by `margin`
/// [m], so that the corner is closed. Other ends are free.
template <int D>
void add_plates(const Case& scene, double margin, Boundaries<D>& boundaries) {
  std::vector<sph::ImagePlane<D>> others = boundaries.planes;
  for (const Plate& plate : scene.plates)
    for (auto plane : plate_planes<D>(plate)) {
      if (plane.to > plane.from) {
        plane.from -= 1e-3 * margin;
        plane.to += 1e-3 * margin;
        plane.second_from -= 1e-3 * margin;
        plane.second_to += 1e-3 * margin;
      }
      others.push_back(plane);
    }
  for (std::size_t k = 0; k < scene.plates.size(); ++k)
    for (auto plane : plate_planes<D>(scene.plates[k])) {
      const auto wall_at = [&](double along) {
        const Vec<D> end = plane.at(along);
        return std::ranges::find_if(others, [&](const auto& wall) {
          const bool across = std::abs(wall.normal.dot(plane.normal)) < 0.99;
          return across && std::abs(wall.normal.dot(end - wall.point)) < 1e-3 * margin && wall.faces(end);
        });
      };
      if (D == 3 && plane.to > plane.from) {
        close_corners<D>(others, margin, plane);
      } else if (plane.to > plane.from) {
        const auto first = wall_at(plane.from), last = wall_at(plane.to);
        if (first != others.end()) {
          plane.from -= margin;
          plane.overhangs[0] = {margin, first->piece};
        }
        if (last != others.end()) {
          plane.to += margin;
          plane.overhangs[1] = {margin, last->piece};
        }
      }
      boundaries.kinds.push_back(scene.plates[k].surface == Plate::Surface::rough ? BoundaryKind::fixed
                                                                                  : BoundaryKind::roller);
      boundaries.friction.push_back(0.0);
      boundaries.plate.push_back(static_cast<int>(k));
      boundaries.tilts.push_back(scene.plates[k].tilts ? 1 : 0);
      if (scene.plates[k].tilts) plane.point = plane.at(0.5 * (plane.from + plane.to));
      plane.boundary = static_cast<int>(boundaries.kinds.size()) - 1;
      boundaries.planes.push_back(plane);
    }
  meet_plates(margin, boundaries);
}

}  // namespace

template <int D>
Boundaries<D> with_plates_at(const std::vector<PlateMotion<D>>& plates, Boundaries<D> boundaries) {
  for (std::size_t k = 0; k < boundaries.planes.size(); ++k) {
    if (boundaries.plate[k] < 0) continue;
    const PlateMotion<D>& motion = plates[static_cast<std::size_t>(boundaries.plate[k])];
    auto& plane = boundaries.planes[k];
    plane.point += motion.displacement;
    if (boundaries.tilts[k]) {
      const Mat<D> turned = rotation<D>(motion.angle);
      const double half = 0.5 * (plane.to - plane.from);
      plane.normal = turned * plane.normal;
      plane.tangent = turned * plane.tangent;
      plane.from = plane.tangent.dot(plane.point) - half;
      plane.to = plane.from + 2.0 * half;
      plane.speed = plane.normal.dot(motion.velocity);
      plane.spin = motion.spin;
      continue;
    }
    const double along = plane.tangent.dot(motion.displacement);
    plane.from += along;
    plane.to += along;
    plane.speed = plane.normal.dot(motion.velocity);
  }
  return boundaries;
}

template <int D>
Boundaries<D> make_boundaries(const Case& scene, double margin) {
  using Kind = typename Boundaries<D>::Kind;
  Boundaries<D> boundaries;
  /// Adds a boundary; returns its number.
  const auto number = [&](Kind kind, double friction_angle) {
    boundaries.kinds.push_back(kind);
    boundaries.friction.push_back(std::tan(friction_angle * std::numbers::pi / 180.0));
    boundaries.plate.push_back(-1);
    boundaries.tilts.push_back(0);
    return static_cast<int>(boundaries.kinds.size()) - 1;
  };
  const auto add = [&](std::vector<sph::ImagePlane<D>> planes, Kind kind, double friction_angle) {
    for (auto& plane : planes) {
      plane.boundary = number(kind, friction_angle);
      boundaries.planes.push_back(plane);
    }
  };
  const auto kind_of = [](const Wall& wall) {
    return wall.soil == Wall::ForSoil::fixed        ? Kind::fixed
           : wall.soil == Wall::ForSoil::frictional ? Kind::frictional
                                                    : Kind::roller;
  };
  const auto makes_images = [](const Wall& wall) {
    return wall.soil != Wall::ForSoil::none && wall.soil != Wall::ForSoil::rough;
  };
  std::shared_ptr<Surfaces> surfaces;
  if (D == 3 && std::ranges::any_of(scene.walls, [&](const Wall& wall) { return makes_images(wall) && wall.shape; }))
    surfaces = std::make_shared<Surfaces>();
  boundaries.surfaces = surfaces;
  const bool thin = sight_matters(scene, Keeps::soil);
  add(periodic_planes<D>(scene.general, 0), Kind::periodic, 0.0);
  for (const auto& wall : scene.walls) {
    if (!makes_images(wall) || thin) continue;
    if (!surfaces)
      add(planes_of<D>(wall.face, 0, 0.0), kind_of(wall), wall.friction_angle);
    else
      surfaces->add(wall, number(kind_of(wall), wall.friction_angle));
  }
  if (thin) {
    if constexpr (D == 2)
      for (const auto& side : sides_of_walls(scene, Keeps::soil, margin)) {
        const Wall& wall = scene.walls[static_cast<std::size_t>(side.boundary)];
        add({side}, kind_of(wall), wall.friction_angle);
      }
    boundaries.sight = sph::Sight<D>(boundaries.planes, sight_slack * margin);
  } else {
    meet_at_corners<D>(boundaries.planes, margin);
  }
  add_plates<D>(scene, margin, boundaries);
  if (boundaries.kinds.size() > 32)
    throw CaseError(
        fmt::format("the walls of the soil have {} straight pieces; at most 32 are possible: use fewer corners",
                    boundaries.kinds.size()));
  return boundaries;
}

namespace {

/// The planes behind which an image lies, in the order of its reflections. Periodic sides need no correction.
template <int D>
void find_passed(const Boundaries<D>& boundaries, std::uint32_t numbers, std::vector<Passed<D>>& passed) {
  passed.clear();
  for (std::size_t k = 0; k < boundaries.planes.size(); ++k)
    if ((numbers >> k & 1u) && boundaries.kinds[k] != Boundaries<D>::Kind::periodic)
      passed.push_back({boundaries.kinds[k], boundaries.friction[k], boundaries.plate[k], boundaries.tilts[k] != 0,
                        boundaries.planes[k].normal, boundaries.planes[k].point});
}

/// The planes at which an image is reflected, in this order, for images made in all orders. n: number of particles; k:
/// number of the image.
template <int D>
void find_passed(const Boundaries<D>& boundaries, const sph::Images<D>& images, std::size_t n, std::size_t k,
                 std::vector<Passed<D>>& passed) {
  passed.clear();
  for (std::size_t j = n + k; j >= n; j = images.of[j - n]) {
    const std::size_t b = images.by[j - n];
    passed.push_back({boundaries.kinds[b], boundaries.friction[b], boundaries.plate[b], boundaries.tilts[b] != 0,
                      boundaries.planes[b].normal, boundaries.planes[b].point});
  }
  std::ranges::reverse(passed);
}

/// Replaces neighbours that walls hide from a particle by the particle itself, which contributes nothing.
template <int D>
void hide_behind_walls(const sph::Sight<D>& sight, double reach, std::size_t n_real, std::span<const Vec<D>> position,
                       const sph::Images<D>& images, Pairs& pairs) {
  for_each_part(pairs.n_parts(), [&](std::size_t part) {
    typename sph::Sight<D>::Near walls;
    for (Index i = pairs.part[part]; i < pairs.part[part + 1]; ++i) {
      // Also where no wall is near: an image by both sides of a line lies where the particle itself does.
      sight.find_near(position[i], reach, walls);
      for (Index m = pairs.offset[i]; m < pairs.offset[i + 1]; ++m)
        if (!sight.pairs(i, pairs.index[m], n_real, position, images.by, images.of, walls)) pairs.index[m] = i;
    }
  });
}

/// The points on surfaces at which an image is reflected, in this order.
template <int D>
void find_passed(const Boundaries<D>& boundaries, const Surfaces::WallPoints& mirrors, std::vector<Passed<D>>& passed) {
  passed.clear();
  for (const auto& wall : mirrors.all()) {
    const auto k = static_cast<std::size_t>(wall.boundary);
    passed.push_back({boundaries.kinds[k], boundaries.friction[k], -1, false, wall.normal.template head<D>(),
                      wall.at.template head<D>(), wall.bend.template topLeftCorner<D, D>(),
                      wall.stretch().template topLeftCorner<D, D>()});
  }
}

/// The map of velocities at a wall: mirrored at rollers, reversed at other walls.
template <int D>
Mat<D> reversed_at(const Passed<D>& wall) {
  return wall.kind == BoundaryKind::roller ? Mat<D>(Mat<D>::Identity() - 2.0 * wall.normal * wall.normal.transpose())
                                           : Mat<D>(-Mat<D>::Identity());
}

/// Composes the linear maps of velocities through a chain of walls: mirrored at rollers, reversed at fixed walls, and
/// at frictional walls reversed about the wall slip s, v' = 2 s - v.
template <int D>
void find_velocity_maps(std::span<const Passed<D>> passed, ImageRule<D>& rule) {
  using Kind = BoundaryKind;
  for (const auto& wall : passed) {
    const Vec<D>& n = wall.normal;
    const bool curved = !wall.bend.isZero(0.0);
    Mat<D> reversed = reversed_at(wall);
    if (curved) {
      if (wall.kind == Kind::roller) reversed = (wall.stretch - 2.0 * n * n.transpose()).eval();
      rule.swelling *= wall.stretch.determinant();
      rule.curved = true;
    }
    rule.velocity = (reversed * rule.velocity).eval();
    rule.slip = (reversed * rule.slip).eval();
    if (wall.kind != Kind::frictional) continue;
    rule.slip += 2.0 * (Mat<D>::Identity() - n * n.transpose());
    rule.slips = true;
  }
}

template <int D>
void find_crossings(std::span<const Passed<D>> passed, ImageRule<D>& rule) {
  using Kind = BoundaryKind;
  for (const auto& wall : passed) {
    if (rule.n_crossings == D) break;
    const Vec<D>& n = wall.normal;
    const Mat<D> normal_part = n * n.transpose();
    Crossing<D>& crossing = rule.crossings[rule.n_crossings++];
    crossing.normal = n;
    crossing.level = n.dot(wall.point);
    // Takes the parent's body force to the image. Behind several walls, rule.map reflects it at each of them. At this
    // wall it must not be reflected, since the stress continues across the wall with the slope that the body force
    // causes: the second factor undoes that reflection.
    crossing.share = rule.map * (Mat<D>::Identity() - 2.0 * normal_part);
    if (wall.kind == Kind::roller) crossing.share = normal_part * crossing.share;
    if (wall.kind == Kind::frictional) crossing.friction = wall.friction;
    crossing.bend = wall.bend;
  }
}

/// Force per volume [N/m3] of a stress that follows a curved wall: the divergence of a stress s whose components along
/// and across the wall are the same everywhere along it.
template <int D>
Vec<D> bent_stress(const Crossing<D>& wall, const Mat<D>& s) {
  const Vec<D> pull = s * wall.normal;
  const double across = wall.normal.dot(pull), bend = wall.bend.trace();
  const Vec<D> along = pull - across * wall.normal;
  return (across * bend - wall.bend.cwiseProduct(s).sum()) * wall.normal + bend * along + wall.bend * along;
}

/// Makes an image of x by reflecting it at these walls, in their order, and sets how it follows its parent.
template <int D>
void reflect_at(std::span<const Passed<D>> walls, const Vec<D>& x, ImageRule<D>& rule) {
  Vec<D> image = x;
  const Index parent = rule.parent;
  rule = {};
  rule.parent = parent;
  for (const Passed<D>& wall : walls) {
    image -= 2.0 * wall.normal.dot(image - wall.point) * wall.normal;
    rule.map -= 2.0 * wall.normal * (wall.normal.transpose() * rule.map).eval();
  }
  rule.shift = image - rule.map * x;
  find_velocity_maps<D>(walls, rule);
  find_crossings<D>(walls, rule);
}

/// Turns the reflections of an image behind curved walls, for the motion of its parent to x [m] since the lists were
/// built. The normal at x is the gradient of the distance d from the wall, whose second derivative is S (1 + d S)^-1.
template <int D>
void turn_with_parent(const Vec<D>& x, const BehindCurved<D>& behind, ImageRule<D>& rule) {
  std::array<Passed<D>, D> walls = behind.walls;
  for (std::size_t k = 0; k < behind.size; ++k) {
    Passed<D>& wall = walls[k];
    if (wall.bend.isZero(0.0)) continue;
    const Vec<D> moved = x - wall.from;
    const double at_first = wall.normal.dot(wall.from - wall.point);
    const Vec<D> turned = 0.5 * (wall.bend + wall.stretch * wall.bend) * moved;
    const double distance = at_first + wall.normal.dot(moved) + 0.5 * moved.dot(turned);
    wall.normal = (wall.normal + turned).normalized();
    wall.point = x - distance * wall.normal;
  }
  const double swelling = rule.swelling;
  reflect_at<D>(std::span<const Passed<D>>(walls).first(behind.size), x, rule);
  rule.swelling = swelling;
}

/// Finds how plates carry image `which`: the plates among the walls that it has passed.
template <int D>
void find_plates(std::span<const Passed<D>> passed, const std::vector<PlateMotion<D>>& plates, std::size_t which,
                 ImageRule<D>& rule, std::vector<BehindPlate<D>>& behind) {
  const std::size_t begin = behind.size();
  for (std::size_t w = 0; w < passed.size(); ++w) {
    const Mat<D> normal_part = passed[w].normal * passed[w].normal.transpose();
    const Mat<D> mirror = Mat<D>::Identity() - 2.0 * normal_part;
    const Mat<D> reversed = reversed_at(passed[w]);
    for (std::size_t k = begin; k < behind.size(); ++k) {
      behind[k].velocity = (reversed * behind[k].velocity).eval();
      behind[k].place = (mirror * behind[k].place).eval();
    }
    if (passed[w].plate < 0) continue;
    BehindPlate<D>& now = behind.emplace_back();
    now.image = static_cast<Index>(which);
    now.plate = static_cast<Index>(passed[w].plate);
    now.crossing = static_cast<std::uint32_t>(w);
    now.first = behind.size() == begin + 1;
    now.velocity = Mat<D>::Identity() - reversed;
    now.place = 2.0 * normal_part;
    now.level = passed[w].normal.dot(passed[w].point - plates[now.plate].displacement);
  }
  rule.moves = behind.size() > begin;
  const bool turns = std::ranges::any_of(passed, [](const Passed<D>& wall) { return wall.tilts; });
  for (std::size_t k = begin; k < behind.size(); ++k) behind[k].turns = turns;
  Vec<D> shift = rule.shift;
  for (std::size_t k = begin; k < behind.size(); ++k) shift -= behind[k].place * plates[behind[k].plate].displacement;
  for (std::size_t k = begin; k < behind.size(); ++k) behind[k].shift = shift;
}

/// Moves the images behind plates with the plates to their present places.
template <int D>
void follow_plates(const std::vector<PlateMotion<D>>& plates, Neighbourhood<D>& near) {
  for (const BehindPlate<D>& behind : near.behind_plates) {
    ImageRule<D>& rule = near.images[behind.image];
    const PlateMotion<D>& plate = plates[behind.plate];
    if (behind.turns) continue;  // turn_images() moves it
    if (behind.first) rule.shift = behind.shift;
    rule.shift += behind.place * plate.displacement;
    if (behind.crossing >= rule.n_crossings) continue;
    Crossing<D>& crossing = rule.crossings[behind.crossing];
    crossing.level = behind.level + crossing.normal.dot(plate.displacement);
  }
}

/// Sets the velocities that images behind plates get from the plates.
template <int D>
void carry_images(const std::vector<PlateMotion<D>>& plates, Neighbourhood<D>& near) {
  for (const BehindPlate<D>& behind : near.behind_plates) {
    Vec<D>& carried = near.images[behind.image].carried;
    if (behind.first) carried.setZero();
    carried += behind.velocity * plates[behind.plate].velocity;
    if (behind.turns) carried += plates[behind.plate].spin * behind.spin;
  }
}

/// The walls behind which an image lies, with the plates among them at their present places.
template <int D>
std::vector<Passed<D>> walls_now(const BehindTilting<D>& behind, const std::vector<PlateMotion<D>>& plates,
                                 const std::vector<PlateMotion<D>>& plates_at) {
  std::vector<Passed<D>> walls = behind.walls;
  for (Passed<D>& wall : walls) {
    if (wall.plate < 0) continue;
    const auto k = static_cast<std::size_t>(wall.plate);
    wall.normal = rotation<D>(plates[k].angle - plates_at[k].angle) * wall.normal;
    wall.point += plates[k].displacement - plates_at[k].displacement;
  }
  return walls;
}

/// Turns the reflections of images behind plates that tilt with the plates. In the frame that moves with a plate, the
/// plate is a wall at rest: with its rigid motion W(x) = V + spin x (x - middle), the image at x' of a particle at x
/// has the velocity W(x') + T (v - W(x)).
template <int D>
void turn_images(const VecArray<D>& position, const std::vector<PlateMotion<D>>& plates, Neighbourhood<D>& near) {
  for (const BehindTilting<D>& behind : near.behind_tilting) {
    ImageRule<D>& rule = near.images[behind.image];
    const std::vector<Passed<D>> walls = walls_now(behind, plates, near.plates_at);
    Vec<D> image = position[rule.parent];
    reflect_at<D>(walls, image, rule);
    rule.moves = true;
    std::size_t last = behind.first;
    for (const Passed<D>& wall : walls) {
      const Mat<D> reversed = reversed_at(wall);
      const Vec<D> before = image;
      image -= 2.0 * wall.normal.dot(image - wall.point) * wall.normal;
      for (std::size_t k = behind.first; k < last; ++k) {
        near.behind_plates[k].velocity = (reversed * near.behind_plates[k].velocity).eval();
        near.behind_plates[k].spin = (reversed * near.behind_plates[k].spin).eval();
      }
      if (wall.plate < 0) continue;
      BehindPlate<D>& now = near.behind_plates[last++];
      now.velocity = Mat<D>::Identity() - reversed;
      if (wall.tilts)
        now.spin = spinning<D>() * (image - wall.point) - reversed * (spinning<D>() * (before - wall.point));
    }
  }
}

/// Completes the nodes of images behind plates that tilt: the gradients of velocity and displacement, and the
/// displacement, by the rule of turn_images(). The displacement of a plate at x is D(x) = U + (1 - R^T) (x - middle)
/// with its rotation R, and T is that of the plate before it turned.
template <int D>
void turn_gradients(const Particles<D>& p, Neighbourhood<D>& near, std::vector<Node<D>>& nodes) {
  const std::size_t n = p.with_copies();
  const Mat<D> one = Mat<D>::Identity();
  for (const BehindTilting<D>& behind : near.behind_tilting) {
    ImageRule<D>& rule = near.images[behind.image];
    Mat<D> gradient = nodes[rule.parent].gradient, deformation = nodes[rule.parent].deformation;
    Vec<D> image = p.position[rule.parent], displacement = p.displacement[rule.parent];
    for (const Passed<D>& wall : walls_now(behind, p.plates, near.plates_at)) {
      const Mat<D> mirror = one - 2.0 * wall.normal * wall.normal.transpose(), reversed = reversed_at(wall);
      Mat<D> spin = Mat<D>::Zero(), back = one;  // back: R^T
      Vec<D> moved = Vec<D>::Zero();
      if (wall.plate >= 0) {
        const PlateMotion<D>& plate = p.plates[static_cast<std::size_t>(wall.plate)];
        spin = plate.spin * spinning<D>();
        back = rotation<D>(-plate.angle);
        moved = plate.displacement;
      }
      const Mat<D> first = back * reversed * back.transpose(), turned = one - back;
      const Vec<D> before = image;
      image -= 2.0 * wall.normal.dot(image - wall.point) * wall.normal;
      gradient = (spin + reversed * (gradient - spin) * mirror).eval();
      deformation = (turned + first * (deformation - turned) * mirror).eval();
      displacement =
          (moved + turned * (image - wall.point) + first * (displacement - moved - turned * (before - wall.point)))
              .eval();
    }
    nodes[n + behind.image].gradient = gradient;
    nodes[n + behind.image].deformation = deformation;
    rule.displacement = displacement;
  }
}

/// Takes the pairs of particles with images behind the parts of plates that have come off out of the lists: each such
/// entry is replaced by the particle itself, which contributes nothing. A pair belongs to the part at its middle, so
/// that it is left out for both of its particles.
template <int D>
void leave_apart(const std::vector<PlateMotion<D>>& plates, const Boundaries<D>& boundaries, std::size_t n_real,
                 std::span<const Vec<D>> position, const Neighbourhood<D>& near, Pairs& pairs) {
  std::vector<const sph::ImagePlane<D>*> lifted(near.images.size(), nullptr);
  for (const auto& plane : boundaries.planes) {
    const int plate = boundaries.plate[static_cast<std::size_t>(plane.boundary)];
    if (plate < 0) continue;
    const auto& apart = plates[static_cast<std::size_t>(plate)].apart;
    if (std::ranges::find(apart, char{1}) == apart.end()) continue;
    for (const BehindPlate<D>& behind : near.behind_plates)
      if (static_cast<int>(behind.plate) == plate) lifted[behind.image] = &plane;
  }
  for (std::size_t i = 0; i < pairs.size(); ++i)
    for (std::size_t m = pairs.alone[i]; m < pairs.offset[i + 1]; ++m) {
      const std::size_t j = pairs.index[m];
      if (j < n_real || !lifted[j - n_real]) continue;
      const auto& plane = *lifted[j - n_real];
      const auto plate = static_cast<std::size_t>(boundaries.plate[static_cast<std::size_t>(plane.boundary)]);
      const double along = plane.tangent.dot(0.5 * (position[i] + position[j])) - plane.from;
      if (plates[plate].apart[part_at(plates[plate].apart.size(), plane.to - plane.from, along)])
        pairs.index[m] = static_cast<Index>(i);
    }
}

/// The number of the lowest bit that is set.
std::size_t lowest(std::uint32_t bits) { return static_cast<std::size_t>(std::countr_zero(bits)); }

/// Says which plates bear the forces along a plate that its images exert (docs/theory/plates.md). A smooth plate bears
/// those on particles before it, which cancel, and those on particles beside a free end. Where another wall or plate
/// continues it, its images also act on the particles before that one: these forces cancel with those of the other's
/// images, not among its own.
template <int D>
class AlongPlates {
 public:
  AlongPlates(const Boundaries<D>& boundaries, const sph::Images<D>& images, std::size_t n)
      : boundaries_(boundaries), images_(images), continued_(boundaries.kinds.size(), 0u), before_(n, 0u) {
    for (const auto& a : boundaries.planes)
      for (const auto& b : boundaries.planes) {
        const auto k = static_cast<std::size_t>(a.boundary), other = static_cast<std::size_t>(b.boundary);
        if (boundaries.kinds[other] == BoundaryKind::periodic) continue;
        walls_ |= 1u << other;
        const bool smooth = boundaries.plate[k] >= 0 && boundaries.kinds[k] == BoundaryKind::roller;
        if (k != other && smooth && !boundaries.tilts[k] && a.normal.dot(b.normal) > 0.99) continued_[k] |= 1u << other;
      }
    for (std::size_t k = 0; k < images.size(); ++k)
      if (images.parent[k] < n && std::popcount(passed(k)) == 1) before_[images.parent[k]] |= passed(k);
  }

  /// The plates that bear the forces along `plate` of image k on particle i.
  [[nodiscard]] std::array<int, 2> of(int plate, std::size_t i, std::size_t k) const {
    if (std::popcount(passed(k)) > 1) return {-1, -1};  // in a corner: the other wall
    const std::size_t own = lowest(passed(k));
    const std::uint32_t beside = before_[i] & continued_[own];
    if (beside == 0u || (before_[i] & passed(k)) != 0u) return {plate, plate};
    const std::size_t other = lowest(beside);
    const int next = boundaries_.plate[other];
    return {boundaries_.kinds[other] == BoundaryKind::roller && next >= 0 ? plate : next, next};
  }

 private:
  /// The walls behind which image k lies, as bits.
  [[nodiscard]] std::uint32_t passed(std::size_t k) const { return images_.boundaries[k] & walls_; }

  const Boundaries<D>& boundaries_;
  const sph::Images<D>& images_;
  std::uint32_t walls_ = 0u;              ///< all but periodic sides, as bits
  std::vector<std::uint32_t> continued_;  ///< by boundary: the boundaries that can continue it
  std::vector<std::uint32_t> before_;     ///< by particle: the boundaries before which it lies
};

/// Lists the pairs of particles with images behind each plate, by the plates that bear their forces.
template <int D>
void list_plate_pairs(const Boundaries<D>& boundaries, const sph::Images<D>& images, std::size_t n_plates,
                      Neighbourhood<D>& near) {
  near.plate_pairs.clear();
  if (n_plates == 0) return;
  const std::size_t n = near.pairs.size();
  const AlongPlates<D> along(boundaries, images, n);
  for (std::size_t plate = 0; plate < n_plates; ++plate) {
    std::vector<char> behind(near.images.size(), 0);
    for (const BehindPlate<D>& b : near.behind_plates)
      if (b.plate == plate) behind[b.image] = 1;
    const auto bearers = [&](std::size_t i, Index j) -> std::optional<std::array<int, 2>> {
      if (j < n || !behind[j - n]) return {};
      return along.of(static_cast<int>(plate), i, j - n);
    };
    std::set<std::array<int, 2>> all;
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t m = near.pairs.alone[i]; m < near.pairs.offset[i + 1]; ++m)
        if (const auto found = bearers(i, near.pairs.index[m])) all.insert(*found);
    for (const auto& these : all) {
      PlatePairs& list = near.plate_pairs.emplace_back();
      list.plate = static_cast<Index>(plate);
      list.along = these;
      list.pairs.part = near.pairs.part;
      for (std::size_t i = 0; i < n; ++i) {
        auto& index = list.pairs.index;
        list.pairs.alone.push_back(static_cast<Index>(index.size()));
        for (std::size_t m = near.pairs.alone[i]; m < near.pairs.offset[i + 1]; ++m)
          if (bearers(i, near.pairs.index[m]) == these) index.push_back(near.pairs.index[m]);
        while (index.size() % n_lanes != 0) index.push_back(static_cast<Index>(i));
        list.pairs.offset.push_back(static_cast<Index>(index.size()));
      }
    }
  }
}

}  // namespace

template <int D>
void wrap_periodic(const Boundaries<D>& boundaries, VecArray<D>& positions) {
  for (std::size_t k = 0; k < boundaries.planes.size(); ++k) {
    if (boundaries.kinds[k] != Boundaries<D>::Kind::periodic) continue;
    const auto& side = boundaries.planes[k];
    for (auto& x : positions)
      if (side.normal.dot(x - side.point) < 0.0) x += side.shift;
  }
}

template <int D>
void keep_before_walls(const Boundaries<D>& boundaries, double reach, const Neighbourhood<D>& near,
                       Particles<D>& particles) {
  if constexpr (D == 3) {
    if (boundaries.surfaces) {
      if (near.built_at.size() != particles.size()) return;  // before the first step
      parallel_for(particles.free(), [&](std::size_t i) {
        const Vec<3> before = near.built_at[i].template cast<double>();
        boundaries.surfaces->keep_inside(before, reach, particles.position[i], particles.velocity[i]);
      });
      return;
    }
  }
  if (boundaries.sight.limited()) {
    if (near.built_at.size() != particles.size()) return;  // before the first step
    for (std::size_t i = 0; i < particles.free(); ++i)
      boundaries.sight.keep_inside(near.built_at[i].template cast<double>(), particles.position[i],
                                   particles.velocity[i]);
    return;
  }
  for (std::size_t i = 0; i < particles.free(); ++i)
    sph::keep_inside<D>(boundaries.planes, reach, particles.position[i], particles.velocity[i]);
}

template <int D>
void build_neighbourhood(const Boundaries<D>& boundaries, double range, std::size_t n_parts,
                         const Particles<D>& particles, std::span<const char> asleep, Neighbourhood<D>& near) {
  near.built_at.resize(particles.size());
  near.lower = near.upper = particles.size() > 0 ? particles.position.front() : Vec<D>(Vec<D>::Zero());
  for (std::size_t i = 0; i < particles.size(); ++i) {
    near.built_at[i] = particles.position[i].template cast<float>();
    near.lower = near.lower.cwiseMin(particles.position[i]);
    near.upper = near.upper.cwiseMax(particles.position[i]);
  }
  sph::Images<D> images;
  std::vector<Surfaces::WallPoints> mirrors;  // of surfaces, by image
  if constexpr (D == 3)
    if (boundaries.surfaces) images = boundaries.surfaces->images(particles.position, range, &mirrors);
  const std::span<const Vec<D>> positions(particles.position);
  const std::span<const sph::ImagePlane<D>> planes(boundaries.planes);
  const bool thin = boundaries.sight.limited();
  if (thin)
    images = sph::images_in_all_orders<D>(positions, planes, range);
  else if (!boundaries.surfaces)
    images = sph::make_images<D>(positions, planes, range);
  near.images.assign(images.size(), {});
  near.behind_curved.clear();
  near.behind_plates.clear();
  near.behind_tilting.clear();
  near.plates_at = particles.plates;
  VecArray<D> sources = particles.position;
  sources.insert(sources.end(), images.position.begin(), images.position.end());
  std::vector<Passed<D>> passed;
  for (std::size_t k = 0; k < images.size(); ++k) {
    ImageRule<D>& rule = near.images[k];
    rule.parent = images.parent[k];
    rule.map = images.map[k];
    rule.shift = images.position[k] - rule.map * particles.position[rule.parent];
    if (boundaries.surfaces)
      find_passed(boundaries, mirrors[k], passed);
    else if (thin)
      find_passed(boundaries, images, particles.size(), k, passed);
    else
      find_passed(boundaries, images.boundaries[k], passed);
    find_velocity_maps<D>(passed, rule);
    find_crossings<D>(passed, rule);
    const std::size_t first = near.behind_plates.size();
    find_plates<D>(passed, particles.plates, k, rule, near.behind_plates);
    if (first < near.behind_plates.size() && near.behind_plates[first].turns)
      near.behind_tilting.push_back({static_cast<Index>(k), static_cast<Index>(first), passed});
    rule.periodic = passed.empty();
    if (!rule.curved) continue;
    BehindCurved<D>& behind = near.behind_curved.emplace_back();
    behind.image = static_cast<Index>(k);
    for (Passed<D>& wall : passed) {
      wall.from = particles.position[rule.parent];
      behind.walls[behind.size++] = wall;
    }
  }
  std::span<const Index> originals;
  if (boundaries.surfaces) originals = images.parent;
  pair_up<D>(sources, particles.free(), particles.size(), range, n_parts, asleep, originals, near.pairs,
             particles.share.at_rest);
  if (thin) hide_behind_walls<D>(boundaries.sight, range, particles.size(), sources, images, near.pairs);
  if (!near.behind_tilting.empty()) {
    turn_images(particles.position, particles.plates, near);
    leave_apart<D>(particles.plates, boundaries, particles.size(), sources, near, near.pairs);
  }
  if (boundaries.surfaces) list_views(near.pairs, images.parent, near.views);
  list_plate_pairs(boundaries, images, particles.plates.size(), near);
}

template <int D>
void fill_nodes(const Setup<D>& setup, State<D>& state) {
  Particles<D>& p = state.particles;
  Neighbourhood<D>& near = state.near;
  std::vector<Node<D>>& nodes = state.nodes;
  const Stabilisers& stabilisers = setup.stabilisers;
  const double stiffness = stabilisers.hourglass_stiffness * stabilisers.modulus;
  const double softness = stiffness > 0.0 ? stabilisers.held / stiffness : 0.0;
  const std::size_t n = p.with_copies();
  nodes.resize(n + near.images.size());
  for_rows(near.pairs, 0, p.size(), [&](std::size_t i) {
    Node<D>& node = nodes[i];
    node.position = p.position[i];
    node.velocity = p.velocity[i];
    node.volume = p.volume[i];
    node.density = p.mass[i] / p.volume[i];
    double even = state.backing[i];
    if (stabilisers.bulk > 0.0 && p.rubbing[i] <= 0.0F) {
      double share = 1.0;
      edge_stiffness<D>(node.upper.data(), share);
      even += share * share * stabilisers.bulk * node.density * node.gradient.trace();
    }
    node.flux.noalias() = (matrix_of<D>(p.stress[i]) + even * Mat<D>::Identity()) * node.correction();
    // The displacement of soil that was in suspension does not tell how far its grains are strained.
    const bool settled = std::isfinite(setup.contact_volume[p.material[i]]);
    node.hourglass_level = settled                      ? Node<D>::yielded
                           : p.plastic_strain[i] <= 0.0 ? Node<D>::elastic
                           : p.plastic_strain[i] <= setup.flow_limit
                               ? Node<D>::yielded + softness * root_j2(p.stress[i])
                               : Node<D>::flows;
    node.rubbing = static_cast<double>(p.rubbing[i]);
  });
  fill_copies(setup.domain, std::span(nodes).first(n));
  for (auto* vectors : {&p.velocity, &p.displacement, &state.body}) fill_copies(setup.domain, std::span(*vectors));
  if (setup.boundaries.any_frictional())
    for (auto* slips : {&p.slip, &p.slipped, &p.wall_slope}) fill_copies(setup.domain, std::span(*slips));
  fill_copies(setup.domain, std::span(p.stress));
  fill_copies(setup.domain, std::span(p.plastic_strain));
  parallel_for(near.behind_curved.size(), [&](std::size_t k) {
    ImageRule<D>& rule = near.images[near.behind_curved[k].image];
    turn_with_parent<D>(p.position[rule.parent], near.behind_curved[k], rule);
  });
  follow_plates(p.plates, near);
  turn_images(p.position, p.plates, near);
  carry_images(p.plates, near);
  for (std::size_t k = 0; k < near.images.size(); ++k) {
    ImageRule<D>& rule = near.images[k];
    Node<D>& node = nodes[n + k];
    node = nodes[rule.parent];
    node.position = rule.map * nodes[rule.parent].position + rule.shift;
    node.velocity = rule.moved(p.velocity[rule.parent], p.slip) + rule.carried;
    node.gradient = rule.velocity * nodes[rule.parent].gradient * rule.map.transpose();
    rule.displacement = rule.moved(p.displacement[rule.parent], p.slipped);
    node.deformation = rule.velocity * nodes[rule.parent].deformation * rule.map.transpose();
    if (near.views.offset.empty())
      node.flux = rule.velocity * nodes[rule.parent].flux * rule.map.transpose();
    else
      node.flux.setZero();  // the parent bears this stress: see pull_back
    if (rule.curved) {
      node.volume *= rule.swelling;
      // No hourglass control: the soil may have come along the wall from a place with another normal. Then its
      // displacement has no mirror image, and neither has the rotation of soil that follows the wall.
      node.hourglass_level = Node<D>::flows;
    }
    for (std::size_t c = 0; c < rule.n_crossings; ++c) {
      const Crossing<D>& wall = rule.crossings[c];
      const double distance = wall.normal.dot(nodes[rule.parent].position) - wall.level;
      const Vec<D> row = rule.map * (nodes[rule.parent].correction() * (rule.map.transpose() * wall.normal));
      Vec<D> slope = state.body[rule.parent];
      if (std::isfinite(wall.friction)) slope += p.wall_slope[rule.parent];
      if (rule.curved && (std::isinf(wall.friction) || p.wall_slope[rule.parent].isZero(0.0)))
        slope += bent_stress<D>(wall, matrix_of<D>(p.stress[rule.parent]));
      const double reach = distance * slope_carried<D>(p, rule.parent, wall.normal, distance, slope);
      node.flux += 2.0 * reach * (wall.share * slope) * row.transpose();
      if (std::isinf(wall.friction)) continue;
      const WallShear<D> shear = wall_shear<D>(p.stress[rule.parent], wall.normal, reach, slope);
      node.flux -= 2.0 * shear.excess(wall.friction) * (wall.share * shear.traction) * row.transpose();
      if (rule.n_crossings > 1 || p.slip[rule.parent].isZero(0.0)) continue;
      // Slipping soil is mirrored along the wall as at a roller, so that only friction resists soil that spreads along
      // the wall.
      const Mat<D> along = (Mat<D>::Identity() - wall.normal * wall.normal.transpose()) * rule.map.transpose();
      if (near.views.offset.empty()) node.flux += rule.slip * nodes[rule.parent].flux * along;
      node.gradient += rule.slip * nodes[rule.parent].gradient * along;
      node.deformation += rule.slip * nodes[rule.parent].deformation * along;
    }
  }
  for (const BehindPlate<D>& behind : near.behind_plates)
    if (!behind.turns) near.images[behind.image].displacement += behind.velocity * p.plates[behind.plate].displacement;
  turn_gradients(p, near, nodes);
}

template <int D>
void fill_velocities(const Setup<D>& setup, State<D>& state) {
  Particles<D>& p = state.particles;
  Neighbourhood<D>& near = state.near;
  std::vector<Node<D>>& nodes = state.nodes;
  const std::size_t n = p.with_copies();
  carry_images(p.plates, near);
  fill_copies(setup.domain, std::span(p.velocity));
  if (setup.boundaries.any_frictional()) fill_copies(setup.domain, std::span(p.slip));
  for_rows(near.pairs, 0, p.size(), [&](std::size_t i) { nodes[i].velocity = p.velocity[i]; });
  for (std::size_t j = p.size(); j < n; ++j) nodes[j].velocity = p.velocity[j];
  for (std::size_t k = 0; k < near.images.size(); ++k) {
    const ImageRule<D>& rule = near.images[k];
    nodes[n + k].velocity = rule.moved(p.velocity[rule.parent], p.slip) + rule.carried;
  }
}

template std::vector<sph::ImagePlane<2>> plate_planes<2>(const Plate&);
template std::vector<sph::ImagePlane<3>> plate_planes<3>(const Plate&);
template struct Boundaries<2>;
template struct Boundaries<3>;
template Boundaries<2> make_boundaries<2>(const Case&, double);
template Boundaries<3> make_boundaries<3>(const Case&, double);
template Boundaries<2> with_plates_at<2>(const std::vector<PlateMotion<2>>&, Boundaries<2>);
template Boundaries<3> with_plates_at<3>(const std::vector<PlateMotion<3>>&, Boundaries<3>);
template void wrap_periodic<2>(const Boundaries<2>&, VecArray<2>&);
template void wrap_periodic<3>(const Boundaries<3>&, VecArray<3>&);
template void keep_before_walls<2>(const Boundaries<2>&, double, const Neighbourhood<2>&, Particles<2>&);
template void keep_before_walls<3>(const Boundaries<3>&, double, const Neighbourhood<3>&, Particles<3>&);
template void build_neighbourhood<2>(const Boundaries<2>&, double, std::size_t, const Particles<2>&,
                                     std::span<const char>, Neighbourhood<2>&);
template void build_neighbourhood<3>(const Boundaries<3>&, double, std::size_t, const Particles<3>&,
                                     std::span<const char>, Neighbourhood<3>&);
template void fill_nodes<2>(const Setup<2>&, State<2>&);
template void fill_nodes<3>(const Setup<3>&, State<3>&);
template void fill_velocities<2>(const Setup<2>&, State<2>&);
template void fill_velocities<3>(const Setup<3>&, State<3>&);

}  // namespace poretwin::solid
