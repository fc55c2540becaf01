#include "common/geometry/packing.hpp"

#include "common/core/threads.hpp"
#include "common/geometry/surfaces.hpp"
#include "common/particles/kernel.hpp"
#include "common/particles/neighbours.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace poretwin {
namespace {

// Chosen in a study of a turned box, a cylinder, a ball and the outside of a cube (docs/theory/shaped_walls.md).
// Lengths are in spacings.
constexpr double smoothing = 1.3;   ///< smoothing length of the kernel
constexpr double evening = 0.25;    ///< factor of the step along the gradient of concentration
constexpr double nearest = 0.9;     ///< pairs closer than this repel each other
constexpr double repulsion = 0.75;  ///< strength of this repulsion
constexpr double wall_push = 0.3;   ///< fraction by which a depth below half a spacing is corrected in one step
constexpr double pushed_in = 0.2;   ///< least depth below a face before the first step
constexpr double longest_step = 0.1;
constexpr double at_rest = 1e-3;  ///< the steps end when no particle moves farther
constexpr int most_steps = 60;

}  // namespace

Lattice<3> deepest_in(const Solid& solid, double spacing, const Point3& offset) {
  const Point3 lower = solid.bounds().first, upper = solid.bounds().second;
  std::array<int, 3> count{};
  Point3 step;
  for (std::size_t d = 0; d < 3; ++d) {
    const auto axis = static_cast<Eigen::Index>(d);
    count[d] = std::max(1, static_cast<int>(std::lround((upper - lower)[axis] / spacing)));
    step[axis] = (upper - lower)[axis] / count[d];
  }
  const int nx = count[0], ny = count[1], nz = count[2];
  const std::size_t cells = static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny) * static_cast<std::size_t>(nz);
  const auto place = [&](std::size_t k) {
    const auto i = static_cast<double>(k % static_cast<std::size_t>(nx)),
               j = static_cast<double>(k / static_cast<std::size_t>(nx) % static_cast<std::size_t>(ny)),
               l = static_cast<double>(k / (static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny)));
    return Point3(lower + (Point3(i, j, l) + offset).cwiseProduct(step));
  };
  // Depths are rounded to millionths of a spacing, so that rounding errors decide nothing. A hash of their number
  // decides which of several equally deep points are left out. It scatters them; omitted side by side, they would leave
  // a dent.
  struct Place {
    long above;
    std::size_t scattered, cell;
    bool operator<(const Place& other) const {
      return std::tie(above, scattered, cell) < std::tie(other.above, other.scattered, other.cell);
    }
  };
  std::vector<Place> by_depth(cells);
  parallel_for(cells, [&](std::size_t k) {
    constexpr std::size_t golden = 0x9E3779B97F4A7C15u;  // Knuth's multiplicative hash
    by_depth[k] = {-std::lround(1e6 * solid.depth(place(k), 2.0 * spacing) / spacing), k * golden, k};
  });
  const double wanted = std::max(1.0, std::round(solid.volume() / (spacing * spacing * spacing)));
  const std::size_t n = std::min(cells, static_cast<std::size_t>(wanted));
  std::nth_element(by_depth.begin(), by_depth.begin() + static_cast<std::ptrdiff_t>(n) - 1, by_depth.end());
  by_depth.resize(n);
  std::sort(by_depth.begin(), by_depth.end(), [](const Place& a, const Place& b) { return a.cell < b.cell; });
  Lattice<3> lattice;
  for (const auto& chosen : by_depth) lattice.position.push_back(place(chosen.cell));
  lattice.volume = solid.volume() / static_cast<double>(n);
  return lattice;
}

void pack(const Solid& solid, double spacing, Lattice<3>& lattice) {
  Surfaces surfaces;
  surfaces.add(std::shared_ptr<const Solid>(std::shared_ptr<const Solid>(), &solid), true, 0);
  const double h = smoothing * spacing, range = sph::support_radius * h;
  auto& x = lattice.position;
  const std::size_t n = x.size();
  VecArray<3> all, way(n);
  std::vector<char> at_wall(n);
  // The points nearest to the surface may lie outside the body: they are moved in.
  parallel_for(n, [&](std::size_t a) {
    // In a corner the point is moved away from one face after the other.
    constexpr int most_faces = 8;
    bool moved = true;
    for (int k = 0; k < most_faces && moved; ++k) {
      moved = false;
      for (const auto& part : solid.parts()) {
        const double depth = part.depth(x[a], 2.0 * spacing);
        if (depth >= pushed_in * spacing) continue;
        moved = true;
        const Vec<3> inward = (part.cut_out ? 1.0 : -1.0) * part.mesh.normal(part.mesh.nearest(x[a], HUGE_VAL)->facet);
        x[a] += (pushed_in * spacing - depth) * inward;
      }
    }
  });
  for (int k = 0; k < most_steps; ++k) {
    std::vector<Surfaces::WallPoints> mirrors;
    const auto images = surfaces.images(x, range, &mirrors);
    ScalarArray swelling;
    for (const auto& walls : mirrors) {
      double s = 1.0;
      for (const auto& wall : walls.all()) s *= wall.stretch().determinant();
      swelling.push_back(s);
    }
    all = x;
    all.insert(all.end(), images.position.begin(), images.position.end());
    sph::CellGrid<3> grid;
    grid.build(all, range);
    parallel_for(n, [&](std::size_t a) {
      Vec<3> sum = Vec<3>::Zero();
      grid.for_each_within(x[a], range, [&](Index j, double r2) {
        if (j == a || (j >= n && !Surfaces::sees(x[a], x[images.parent[j - n]], all[j]))) return;
        const Vec<3> r = all[j] - x[a];
        const double distance = std::max(std::sqrt(r2), 1e-3 * spacing);
        sum -= (j >= n ? swelling[j - n] : 1.0) * lattice.volume *
               sph::WendlandC2<3>::derivative_over_r(distance, h) * r;
        sum += repulsion * std::max(0.0, nearest * spacing / distance - 1.0) / (spacing * spacing) * r;
      });
      way[a] = -evening * spacing * spacing * sum;
      const auto walls = surfaces.walls_near(x[a], 0.5 * spacing);
      at_wall[a] = walls.size > 0;
      for (const auto& wall : walls.all()) way[a] += wall_push * (0.5 * spacing - wall.distance) * wall.normal;
      if (const double length = way[a].norm(); length > longest_step * spacing)
        way[a] *= longest_step * spacing / length;
    });
    double longest = 0.0;
    for (const auto& step : way) longest = std::max(longest, step.norm());
    if (longest < at_rest * spacing) break;
    parallel_for(n, [&](std::size_t a) {
      const Vec<3> to = x[a] + way[a];
      if (at_wall[a] == 0 || solid.contains(to)) x[a] = to;
    });
  }
}

}  // namespace poretwin
