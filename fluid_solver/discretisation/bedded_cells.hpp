// Conduction between the particles of water in soil in beds, which conducts better along the beds than across them
// (2D).
#pragma once

#include "common/core/threads.hpp"
#include "common/particles/neighbours.hpp"
#include "fluid_solver/discretisation/stencil.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <limits>
#include <vector>

namespace poretwin::fluid {

/// The Voronoi cells of particles in coordinates y = S x in which the soil conducts equally in all directions
/// (docs/theory/seepage.md#soil-in-beds). S = R^(-1/2), R: conductivity tensor over the conductivity along the beds.
///
/// A pressure that is linear drives through a side of a cell exactly the flow that follows from the difference of the
/// pressures on its two sides. So the sums over the sides of a cell are exact for uniform flow at any arrangement of
/// the particles and any inclination of the beds, all links are positive, and what leaves one particle reaches another.
/// Sums over pairs with kernels cannot have all of this: their weights become negative from a ratio of 4 on (Espanol &
/// Revenga 2003), or they need images that continue the pressure behind walls.
///
/// A cell ends at walls, through which nothing flows and behind which no images are needed, and at the water's surface.
/// Buffers behind faces take part as points.
template <int D>
class BeddedCells {
 public:
  /// A side of a particle's cell, towards another particle, a buffer or the surface.
  struct Side {
    static constexpr Index surface = std::numeric_limits<Index>::max();
    Index other = surface;            ///< particle or buffer, as a point of the stencil
    double conductance = 0.0;         ///< 1, flow through the side over mobility and difference of the pressures
    double shared = 0.0;              ///< conductance that both particles have; that of the matrix
    Vec<D> middle = Vec<D>::Zero();   ///< m, of the side in stretched coordinates, relative to the particle
    Vec<D> towards = Vec<D>::Zero();  ///< m, from the particle to the place of the pressure on the other side
  };

  /// What ends cells and blocks links: walls, lines of sight past them, and the joints at which a face begins.
  struct Walls {
    std::span<const sph::ImagePlane<D>> planes;
    const sph::Sight<D>* sight = nullptr;
    std::span<const Joint<D>> joints;
  };

  BeddedCells() = default;
  /// relative: R. has_cell(a): whether particle a gets a cell. surface_distance(a): distance of the water's surface
  /// from particle a along -normal [m]; 0: none is near.
  template <class HasCell, class SurfaceDistance>
  BeddedCells(const Stencil<D>& s, const Walls& walls, const Mat<D>& relative, const HasCell& has_cell,
              const SurfaceDistance& surface_distance)
      : sides_(s.n_real), to_flux_(s.n_real, Mat<D>::Zero()), has_cell_(s.n_real, 0) {
    static_assert(D == 2);
    const Eigen::SelfAdjointEigenSolver<Mat<D>> eigen(relative);
    stretch_ = eigen.operatorInverseSqrt();
    back_ = eigen.operatorSqrt();
    // Neighbours are up to a kernel's reach away in stretched coordinates whose cells have the same areas.
    const double longest = std::sqrt(eigen.eigenvalues()[1] / eigen.eigenvalues()[0]);
    double reach = 0.0;
    for (std::size_t j = 0; j < s.n_base; ++j) reach = std::max(reach, sph::support_radius * s.length(j));
    sph::CellGrid<D> grid;
    grid.build(std::span<const Vec<D>>(s.position).first(s.n_base), reach * std::sqrt(longest));
    parallel_for(s.n_real, [&](std::size_t a) {
      has_cell_[a] = has_cell(a) ? 1 : 0;
      if (has_cell_[a] != 0) make_cell(s, walls, grid, a, reach * std::sqrt(longest), surface_distance(a));
    });
    for (std::size_t a = 0; a < s.n_real; ++a)
      if (has_cell_[a] != 0)
        for (Side& side : sides_[a]) share(s, a, side);
  }

  [[nodiscard]] bool empty() const { return sides_.empty(); }
  [[nodiscard]] bool has_cell(std::size_t a) const { return !empty() && has_cell_[a] != 0; }
  /// The sides of a particle's cell; of a particle without a cell those of other cells towards it.
  [[nodiscard]] const std::vector<Side>& sides(std::size_t a) const { return sides_[a]; }
  /// Flux [m/s] at particle a from the sum of outflow [m2/s] times `middle` over the sides of its cell: the mean of the
  /// flow over the cell (Perot 2000).
  [[nodiscard]] Vec<D> flux(std::size_t a, const Vec<D>& sum) const { return to_flux_[a] * sum; }
  /// Gradient [Pa/m] of the pressure that drives a flux [m/s] through soil of this mobility.
  [[nodiscard]] Vec<D> gradient(const Vec<D>& flux, double mobility) const {
    return -stretch_ * (stretch_ * flux) / mobility;
  }

 private:
  /// The convex polygon that is left of a cell, in stretched coordinates relative to the particle. Edge i leads from
  /// corner i to the next; `of` is what lies beyond it.
  struct Corner {
    Vec<D> at;
    Index of;
  };
  static constexpr Index wall = Side::surface - 1, nothing = Side::surface - 2;

  /// Cuts off what lies beyond the line normal . y = limit. Returns whether anything does.
  static bool cut(std::vector<Corner>& cell, std::vector<Corner>& rest, const Vec<D>& normal, double limit, Index of) {
    if (std::all_of(cell.begin(), cell.end(), [&](const Corner& c) { return normal.dot(c.at) <= limit; })) return false;
    rest.clear();
    for (std::size_t i = 0; i < cell.size(); ++i) {
      const Corner &here = cell[i], &next = cell[(i + 1) % cell.size()];
      const double beyond = normal.dot(here.at) - limit, next_beyond = normal.dot(next.at) - limit;
      if (beyond <= 0.0) rest.push_back(here);
      if ((beyond <= 0.0) == (next_beyond <= 0.0)) continue;
      const Vec<D> crossing = here.at + beyond / (beyond - next_beyond) * (next.at - here.at);
      rest.push_back({crossing, beyond <= 0.0 ? of : here.of});
    }
    std::swap(cell, rest);
    return true;
  }

  /// Whether the wall ends the cells of particles at x. It does not where it ends and a face goes on.
  static bool ends_cells(const Walls& walls, const sph::ImagePlane<D>& plane, const Vec<D>& x) {
    if (plane.kind != sph::ImagePlane<D>::Kind::mirror || plane.normal.dot(x - plane.point) < 0.0 || !plane.faces(x))
      return false;
    return std::none_of(walls.joints.begin(), walls.joints.end(), [&](const Joint<D>& joint) {
      return joint.boundary == plane.boundary && joint.normal.dot(plane.normal) > 1.0 - 1e-9 &&
             joint.along.dot(x - joint.at) > 0.0;
    });
  }

  void make_cell(const Stencil<D>& s, const Walls& walls, const sph::CellGrid<D>& grid, std::size_t a, double reach,
                 double surface_distance) {
    thread_local std::vector<Corner> cell, rest;
    const Vec<D>& x = s.position[a];
    cell.clear();
    for (const auto& [i, j] : {std::pair{-1.0, -1.0}, {1.0, -1.0}, {1.0, 1.0}, {-1.0, 1.0}})
      cell.push_back({stretch_ * Vec<D>(0.5 * reach * i, 0.5 * reach * j), nothing});
    for (const auto& plane : walls.planes)
      if (ends_cells(walls, plane, x)) cut(cell, rest, -back_ * plane.normal, plane.normal.dot(x - plane.point), wall);
    Vec<D> outwards = Vec<D>::Zero();  // to the surface's nearest point, in stretched coordinates
    if (surface_distance > 0.0 && !s.normal[a].isZero(0.0)) {
      const Vec<D> normal = -(back_ * s.normal[a].normalized());
      outwards = surface_distance / normal.squaredNorm() * normal;
      cut(cell, rest, normal, surface_distance, Side::surface);
    }
    thread_local typename sph::Sight<D>::Near near;
    near.clear();
    if (walls.sight && walls.sight->limited()) walls.sight->find_near(x, reach, near);
    const auto farthest = [&] {
      double most = 0.0;
      for (const Corner& corner : cell) most = std::max(most, corner.at.squaredNorm());
      return most;
    };
    double corners = farthest();  // m2
    grid.for_each_within(x, reach, [&](Index j, double) {
      if (j == a) return;
      const Vec<D> y = stretch_ * (s.position[j] - x);
      const double square = y.squaredNorm();
      if (square >= 4.0 * corners) return;
      if (!near.empty() &&
          !walls.sight->open(s.position[std::min<Index>(a, j)], s.position[std::max<Index>(a, j)], near))
        return;
      if (cut(cell, rest, y, 0.5 * square, j)) corners = farthest();
    });
    const double growth = stretch_.determinant();
    Mat<D> moment = Mat<D>::Zero();
    double area = 0.0;
    for (std::size_t i = 0; i < cell.size(); ++i) {
      const Vec<D> from = cell[i].at, along = cell[(i + 1) % cell.size()].at - from;
      const Vec<D> normal(along[1], -along[0]);  // outwards, times the side's length
      const Vec<D> middle = from + 0.5 * along;
      area += 0.5 * normal.dot(middle);
      if (cell[i].of == nothing) continue;
      moment += middle * normal.transpose();
      if (cell[i].of == wall) continue;
      Side side;
      side.other = cell[i].of;
      side.middle = middle;
      side.towards = side.other == Side::surface ? back_ * outwards : Vec<D>(s.position[side.other] - x);
      const double distance = (stretch_ * side.towards).norm();
      if (distance > 0.0) side.conductance = side.shared = along.norm() / (distance * growth);
      sides_[a].push_back(side);
    }
    // Of a closed cell the moment is its area times the unit matrix. Where a side is missing, at a hole, the flux is
    // that of uniform flow through the others.
    if (!(std::abs(moment.determinant()) > points::least_inverted * points::least_inverted * area * area))
      moment = area * Mat<D>::Identity();
    if (area > 0.0) to_flux_[a] = growth * back_ * moment.inverse();
  }

  /// Gives both particles of a pair the mean of their cells' conductances. These differ only where the water's surface
  /// cuts the two cells differently, or where a neighbour is out of reach.
  void share(const Stencil<D>& s, std::size_t a, Side& side) {
    const Index q = side.other;
    if (q >= s.n_real) return;
    auto back = std::find_if(sides_[q].begin(), sides_[q].end(), [&](const Side& i) { return i.other == a; });
    if (back != sides_[q].end() && q < a) return;  // q has shared it already
    if (back == sides_[q].end()) {
      Side none;
      none.other = static_cast<Index>(a);
      none.towards = -side.towards;
      sides_[q].push_back(none);
      back = sides_[q].end() - 1;
    }
    if (has_cell(q)) side.shared = 0.5 * (side.conductance + back->conductance);
    back->shared = side.shared;
  }

  Mat<D> stretch_ = Mat<D>::Identity(), back_ = Mat<D>::Identity();  ///< S and its inverse
  std::vector<std::vector<Side>> sides_;                             ///< [real]
  MatArray<D> to_flux_;                                              ///< [real] 1/m2
  std::vector<char> has_cell_;                                       ///< [real]
};

}  // namespace poretwin::fluid
