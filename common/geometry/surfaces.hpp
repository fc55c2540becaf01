// Walls of any shape in 3D: for each particle at most three points of the walls, and the particle's images by them. The
// surfaces need no topology (docs/theory/shaped_walls.md).
#pragma once

#include "common/geometry/solid.hpp"
#include "common/particles/images.hpp"

#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace poretwin {

class Surfaces {
 public:
  /// boundary: number that the solver gives the wall, 0..31. domain_inside: the domain is the body's inside.
  void add(std::shared_ptr<const Solid> solid, bool domain_inside, int boundary);
  /// point [m] and normal (unit, into the domain) of a plane.
  void add(const Vec<3>& point, const Vec<3>& normal, int boundary);
  /// Adds the surface of a wall with a shape, or the plane of any other wall.
  void add(const Wall& wall, int boundary);
  [[nodiscard]] bool empty() const { return bodies_.empty() && planes_.empty(); }

  /// A point of a wall that acts as a mirror for a point x.
  struct WallPoint {
    Vec<3> at = Vec<3>::Zero(), normal = Vec<3>::Zero();  ///< m; unit, towards x
    double distance = 0.0;                                ///< m
    int boundary = 0;
    Mat<3> bend = Mat<3>::Zero();  ///< 1/m, S, derivative of the normal along the wall; computed by `images` on request
    /// Ratio of lengths along the wall at the image of x to those at x: (1 - d S)(1 + d S)^-1 with the distance d.
    [[nodiscard]] Mat<3> stretch() const;
  };
  struct WallPoints {
    std::array<WallPoint, 3> point;
    std::size_t size = 0;
    [[nodiscard]] std::span<const WallPoint> all() const { return {point.data(), size}; }
  };
  /// The nearest points of walls within a range [m] of x, in directions that differ by 45 degrees or more.
  [[nodiscard]] WallPoints walls_near(const Vec<3>& x, double range) const;

  /// Images of points by the walls within a range [m] of them. Only points on its original's side of the plane midway
  /// see an image (`sees`). mirrors: if given, it is filled with the wall points by which each image was made,
  /// including the wall's bend at them.
  [[nodiscard]] sph::Images<3> images(std::span<const Vec<3>> points, double range,
                                      std::vector<WallPoints>* mirrors = nullptr) const;
  template <int D>
  static bool sees(const Vec<D>& from, const Vec<D>& original, const Vec<D>& image) {
    const Vec<D> across = original - image;
    return across.dot(2.0 * from - original - image) > -1e-9 * across.squaredNorm();  // a gauge may lie on the wall
  }

  /// Whether a wall is nearer to x than the range [m].
  [[nodiscard]] bool come_near(const Vec<3>& x, double range) const;

  /// Whether x is in the domain: in front of all planes, in all containers and in no obstacle.
  [[nodiscard]] bool holds(const Vec<3>& x) const;
  /// Reflects a point that has moved through walls from `before`, which is in the domain. It ends as far in front of
  /// the wall as it had passed it, but at most `reach` [m]. Its velocity towards the wall [m/s] is set to zero.
  void keep_inside(const Vec<3>& before, double reach, Vec<3>& x, Vec<3>& v) const;

 private:
  /// The walls near each of some points, with the point's number.
  using Found = std::vector<std::pair<Index, WallPoints>>;
  static void find_bends(double range, std::vector<Found>& found);
  struct Body {
    std::shared_ptr<const Solid> solid;
    bool domain_inside;
    int boundary;
  };
  struct Plane {
    Vec<3> point, normal;
    int boundary;
  };
  /// The first intersection of a path with a wall.
  struct Hit {
    double along = 1.0;              ///< fraction of the path
    Vec<3> normal = Vec<3>::Zero();  ///< unit, into the domain
  };
  [[nodiscard]] std::optional<Hit> first_hit(const Vec<3>& from, const Vec<3>& to) const;
  /// Whether a point of a wall is hidden behind other walls, or cut away.
  [[nodiscard]] bool is_covered(const Vec<3>& at, const Body* body, const Solid::Part* part, const Plane* plane) const;
  /// Whether a wall that `from` sees is nearer to the image than the distance [m].
  [[nodiscard]] bool is_cut_off(const Vec<3>& from, const Vec<3>& image, double distance) const;

  std::vector<Body> bodies_;
  std::vector<Plane> planes_;
};

/// A place where a wall is so thin that the kernel reaches through it.
struct ThinPlace {
  Point3 at;         ///< m
  double thickness;  ///< m
};
/// Least thickness of walls [spacings]: the reach of the kernel. Particles on opposite sides of a thinner wall would
/// see each other.
inline constexpr double least_thickness = 2.6;
std::optional<ThinPlace> thin_place(const Shape& shape, Wall::Domain domain, double spacing);

/// A place where a wall turns away from the soil by more than an image can follow, or is curved more strongly than
/// images allow.
struct BentPlace {
  Point3 at;            ///< m
  double turn = 0.0;    ///< degrees, away from the domain; 0 if the curvature is too strong
  double radius = 0.0;  ///< m, of the curvature
};
/// Largest angle [degrees] by which an edge may turn away from moving soil. Beyond such edges there are no images.
inline constexpr double most_turned_away = 25.0;
/// Least radius of curvature of walls beside moving soil [spacings].
inline constexpr double least_radius = 6.0;
/// The first such place of a shape beside soil, of all such places that the soil can reach.
std::optional<BentPlace> bent_place(const Shape& shape, Wall::Domain domain, double spacing,
                                    const std::function<bool(const Point3&)>& in_reach);

}  // namespace poretwin
