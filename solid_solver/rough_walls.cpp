#include "solid_solver/rough_walls.hpp"

#include "common/core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace poretwin::solid {
namespace {

constexpr int rows = 3;  // as deep as the kernel reaches, h = 1.2 spacings

struct Piece {
  Vec<2> from, to, tangent, normal;  // normal into the soil
  double length;
};

/// Signed distance to the nearest piece, negative behind the walls. Where two pieces are equally near (a corner) the
/// one seen more squarely tells the side.
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

/// Rows parallel to every piece; round corners they overlap or leave the wall, and what is too near is left out.
VecArray<2> rows_behind(const std::vector<Piece>& pieces, double spacing) {
  VecArray<2> kept;
  for (const auto& piece : pieces) {
    const auto count = std::max(1L, std::lround(piece.length / spacing));
    const double step = piece.length / static_cast<double>(count);
    const long before = ends_at(pieces, piece, piece.from) ? rows : 0,
               after = ends_at(pieces, piece, piece.to) ? rows : 0;
    for (int row = 0; row < rows; ++row)
      for (long i = -before; i < count + after; ++i) {
        const Vec<2> x =
            piece.from + (static_cast<double>(i) + 0.5) * step * piece.tangent - (row + 0.5) * spacing * piece.normal;
        if (signed_distance(pieces, x) > -0.4 * spacing) continue;
        const bool crowded = std::any_of(kept.begin(), kept.end(), [&](const Vec<2>& other) {
          return (other - x).squaredNorm() < 0.5 * spacing * spacing;
        });
        if (!crowded) kept.push_back(x);
      }
  }
  return kept;
}

}  // namespace

template <int D>
void hold_soil_behind_rough_walls(const std::vector<Wall>& walls, const Setup<D>& setup, Particles<D>& particles) {
  std::vector<Piece> pieces;
  for (const auto& wall : walls) {
    if (wall.soil != Wall::ForSoil::rough) continue;
    if (D != 2 || wall.face.points.empty())
      throw CaseError(fmt::format(
          "wall \"{}\": soil = \"rough\" needs a wall with ends, expected dimension = 2 and 'points', found a plane; "
          "use soil = \"fixed\"",
          wall.name));
    for (const auto& plane : planes_of<2>(wall.face, 0, 0.0))
      pieces.push_back({plane.point, plane.point + (plane.to - plane.from) * plane.tangent, plane.tangent, plane.normal,
                        plane.to - plane.from});
  }
  if (pieces.empty()) return;
  const std::size_t free = particles.size();
  for (const auto& x : rows_behind(pieces, setup.spacing)) {
    std::size_t nearest = 0;
    Vec<D> position = Vec<D>::Zero();
    position.template head<2>() = x;
    for (std::size_t i = 1; i < free; ++i)
      if ((particles.position[i] - position).squaredNorm() < (particles.position[nearest] - position).squaredNorm())
        nearest = i;
    particles.position.push_back(position);
    particles.mass.push_back(particles.mass[nearest]);
    particles.volume.push_back(particles.volume[nearest]);
    particles.material.push_back(particles.material[nearest]);
  }
  particles.held = particles.size() - free;
}

template void hold_soil_behind_rough_walls<2>(const std::vector<Wall>&, const Setup<2>&, Particles<2>&);
template void hold_soil_behind_rough_walls<3>(const std::vector<Wall>&, const Setup<3>&, Particles<3>&);

}  // namespace poretwin::solid
