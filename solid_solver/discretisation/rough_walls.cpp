#include "solid_solver/discretisation/rough_walls.hpp"

#include "common/core/error.hpp"
#include "solid_solver/numerics/walls.hpp"

#include <Eigen/Geometry>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace poretwin::solid {
namespace {

struct Piece {
  Vec<2> from, to, tangent, normal;  // the normal points into the soil
  double length;
};

/// Signed distance [m] to the nearest piece, negative behind the walls. At a corner, where two pieces are equally near,
/// the sign is that for the piece with the larger distance along its normal.
double signed_distance(const std::vector<Piece>& pieces, const Vec<2>& x) {
  double nearest = std::numeric_limits<double>::infinity(), best = 0.0;
  for (const auto& piece : pieces) {
    const double along = std::clamp(piece.tangent.dot(x - piece.from), 0.0, piece.length);
    const double distance = (x - piece.from - along * piece.tangent).norm(), side = piece.normal.dot(x - piece.from);
    const double slack = 1e-9 * piece.length;
    if (distance > nearest + slack || (distance > nearest - slack && std::abs(side) <= std::abs(best))) continue;
    nearest = std::min(nearest, distance);
    best = side;
  }
  return best < 0.0 ? -nearest : nearest;
}

bool ends_at(const std::vector<Piece>& pieces, const Piece& self, const Vec<2>& x) {
  return std::any_of(pieces.begin(), pieces.end(), [&](const Piece& other) {
    const double slack = 1e-6 * self.length;
    return &other != &self && ((other.from - x).norm() < slack || (other.to - x).norm() < slack);
  });
}

/// Rows of positions parallel to every piece. At corners rows overlap or leave the wall: positions too close to others
/// or to the wall are omitted.
VecArray<2> rows_behind(const std::vector<Piece>& pieces, double spacing) {
  VecArray<2> kept;
  for (const auto& piece : pieces) {
    const auto count = std::max(1L, std::lround(piece.length / spacing));
    const double step = piece.length / static_cast<double>(count);
    const long before = ends_at(pieces, piece, piece.from) ? walls::rough_rows : 0,
               after = ends_at(pieces, piece, piece.to) ? walls::rough_rows : 0;
    for (int row = 0; row < walls::rough_rows; ++row)
      for (long i = -before; i < count + after; ++i) {
        const Vec<2> x =
            piece.from + (static_cast<double>(i) + 0.5) * step * piece.tangent - (row + 0.5) * spacing * piece.normal;
        if (signed_distance(pieces, x) > -walls::least_depth * spacing) continue;
        const bool crowded = std::any_of(kept.begin(), kept.end(), [&](const Vec<2>& other) {
          return (other - x).squaredNorm() < walls::least_apart * spacing * spacing;
        });
        if (!crowded) kept.push_back(x);
      }
  }
  return kept;
}

/// In 3D, walls are planes without ends. The rows behind rough walls extend over the domain's box and three rows beyond
/// it, where another rough wall may be. Positions behind walls that are not rough are omitted.
VecArray<3> rows_behind(const std::vector<Wall>& walls, const General& general, double spacing) {
  VecArray<3> kept;
  const Point3 beyond = walls::rough_rows * spacing * Point3::Ones();
  const Eigen::AlignedBox3d box(general.domain_min, general.domain_max), grown(box.min() - beyond, box.max() + beyond);
  const auto behind = [](const Wall& wall, const Point3& x) { return wall.face.normal.dot(x - wall.face.point) < 0.0; };
  for (std::size_t k = 0; k < walls.size(); ++k) {
    if (walls[k].soil != Wall::ForSoil::rough) continue;
    const Point3 normal = walls[k].face.normal.normalized();
    int axis = 0;
    normal.cwiseAbs().minCoeff(&axis);
    std::array<Point3, 2> along;
    along[0] = (Point3::Unit(axis) - normal[axis] * normal).normalized();
    along[1] = normal.cross(along[0]);
    std::array<double, 2> from, step;
    std::array<long, 2> before, count;
    for (std::size_t t = 0; t < 2; ++t) {
      const double reach = 0.5 * along[t].cwiseAbs().dot(box.sizes()), centre = along[t].dot(box.center());
      count[t] = std::max(1L, std::lround(2.0 * reach / spacing));
      step[t] = 2.0 * reach / static_cast<double>(count[t]);
      from[t] = centre - reach;
      const bool periodic = std::any_of(general.periodic.begin(), general.periodic.end(),
                                        [&](int a) { return std::abs(along[t][a]) > 1.0 - 1e-9; });
      before[t] = periodic ? 0 : walls::rough_rows;
    }
    const Point3 foot = normal.dot(walls[k].face.point) * normal;
    for (int row = 0; row < walls::rough_rows; ++row)
      for (long i = -before[0]; i < count[0] + before[0]; ++i)
        for (long j = -before[1]; j < count[1] + before[1]; ++j) {
          const Point3 x = foot - (row + 0.5) * spacing * normal +
                           (from[0] + (static_cast<double>(i) + 0.5) * step[0]) * along[0] +
                           (from[1] + (static_cast<double>(j) + 0.5) * step[1]) * along[1];
          bool taken = !grown.contains(x);
          for (std::size_t other = 0; other < walls.size() && !taken; ++other) {
            const bool rough = walls[other].soil == Wall::ForSoil::rough;
            if (walls[other].soil == Wall::ForSoil::none || (rough && other >= k)) continue;
            taken = behind(walls[other], x);
          }
          if (!taken) kept.push_back(x);
        }
  }
  return kept;
}

/// Positions of the fixed particles behind the rough walls. Throws CaseError for a rough wall without ends (in 3D: in a
/// case without a box).
template <int D>
VecArray<D> held_rows(const std::vector<Wall>& walls, const General& general, double spacing) {
  std::vector<Piece> pieces;
  for (const auto& wall : walls) {
    if (wall.soil != Wall::ForSoil::rough) continue;
    if constexpr (D == 3) {
      if ((general.domain_max - general.domain_min).minCoeff() > 0.0) continue;
      throw CaseError(fmt::format(
          "wall \"{}\": soil = \"rough\" holds soil still behind the wall within a box in 3D; expected case.domain_min "
          "below case.domain_max along every axis, found ({}) and ({}); give the box that the soil may reach",
          wall.name, fmt::join(general.domain_min, ", "), fmt::join(general.domain_max, ", ")));
    }
    if (wall.face.points.empty())
      throw CaseError(
          fmt::format("wall \"{}\": soil = \"rough\" needs a wall with ends, expected 'points', found a plane; use "
                      "soil = \"fixed\"",
                      wall.name));
    for (const auto& plane : planes_of<2>(wall.face, 0, 0.0))
      pieces.push_back({plane.point, plane.point + (plane.to - plane.from) * plane.tangent, plane.tangent, plane.normal,
                        plane.to - plane.from});
  }
  if constexpr (D == 3)
    return rows_behind(walls, general, spacing);
  else
    return rows_behind(pieces, spacing);
}

}  // namespace

template <int D>
void hold_soil_behind_rough_walls(const Case& scene, const Setup<D>& setup, Particles<D>& particles) {
  const std::size_t free = particles.size();
  for (const auto& position : held_rows<D>(scene.walls, scene.general, setup.spacing)) {
    std::size_t nearest = 0;
    for (std::size_t i = 1; i < free && setup.models.size() > 1; ++i)  // with one soil all particles are alike
      if ((particles.position[i] - position).squaredNorm() < (particles.position[nearest] - position).squaredNorm())
        nearest = i;
    particles.position.push_back(position);
    particles.mass.push_back(particles.mass[nearest]);
    particles.volume.push_back(particles.volume[nearest]);
    particles.material.push_back(particles.material[nearest]);
  }
  particles.held = particles.size() - free;
}

template void hold_soil_behind_rough_walls<2>(const Case&, const Setup<2>&, Particles<2>&);
template void hold_soil_behind_rough_walls<3>(const Case&, const Setup<3>&, Particles<3>&);

}  // namespace poretwin::solid
