// From the case's shapes and faces to particles and image planes.
#pragma once

#include "common/case/case.hpp"
#include "common/core/vector.hpp"
#include "common/particles/images.hpp"

#include <span>
#include <string>

namespace poretwin {

/// Is x [m] inside the shape (borders included)? Boxes in 2D ignore z.
bool contains(const Shape& shape, const Point3& x, int dimension);

/// Smallest box around the shape.
std::pair<Point3, Point3> bounds(const Shape& shape);

/// Velocity at x of the lowest sloshing mode of a liquid that fills the shape's box, along the x axis, over the
/// velocity at the ends of its surface.
Point3 sloshing_mode(const Shape& shape, const Point3& x, int dimension);

/// Is the face an opening that no soil touches (2D), through which particles of water come and go? Otherwise the water
/// behind it stands still and needs no particles.
bool is_inlet(const Case& scene, const WaterFace& face);

/// Does still water that no particles represent stand behind the face, up to the level that a head prescribes or that
/// follows from a basin's balance?
bool is_reservoir(const Case& scene, const WaterFace& face);

/// The upper end of a face that no wall or other face touches: water behind the face that stands higher runs over it.
struct Crest {
  Point3 end = Point3::Zero();     ///< m
  double elevation = 0.0;          ///< m
  Point3 inward = Point3::Zero();  ///< unit, level, into the domain; zero where the face itself is level
};
std::optional<Crest> crest_of(const Case& scene, const WaterFace& face);

/// Does x [m] lie on the side of a face where its reservoir is? Above the crest, the vertical line through it divides
/// the sides.
bool is_behind(const Case& scene, const WaterFace& face, const Point3& x);

/// The reason why water behind a face cannot run over its crest, as particles from there on; empty where it can.
std::string no_way_over(const Case& scene, const Crest& crest);

/// Particles on a lattice that fills a shape.
template <int D>
struct Lattice {
  VecArray<D> position;  ///< [n] m
  double volume = 0.0;   ///< m^D, of each particle
};

/// Fills a shape; the spacing is stretched a little where the shape's bounding box is not a whole number of spacings.
/// offset: of the first particle from the lower corner, in spacings; jitter: uniform random displacement +- jitter
/// spacings. Points on an edge of a polygon count as outside, since rounding would decide otherwise; but a point that
/// also lies on an edge of a shape that is filled after this one (`later`) counts as inside.
template <int D>
Lattice<D> fill(const Shape& shape, double spacing, const Point3& offset, double jitter, unsigned seed,
                std::span<const Shape> later = {});

/// Whether lay() moves the particles of a shape (3D): true but for balls, and for boxes, turned or not.
bool is_packed(const Shape& shape);

/// Fills a shape for a run: in bodies with slanted or curved faces (3D) the particles are also moved until they lie
/// evenly.
template <int D>
Lattice<D> lay(const Shape& shape, double spacing, const Point3& offset, double jitter, unsigned seed,
               std::span<const Shape> later = {});

/// The straight pieces of a face as mirror planes, extended by `margin` [m] beyond their ends so that corners close.
template <int D>
std::vector<sph::ImagePlane<D>> planes_of(const Face& face, int boundary, double margin);

/// Extends pieces of walls (made without a margin) by `margin` [m] beyond their ends so that corners close. Images are
/// divided at the bisector where the next piece continues straight, turns away from the domain, or turns towards it by
/// less than 75 degrees.
template <int D>
void meet_at_corners(std::span<sph::ImagePlane<D>> planes, double margin);

/// The two shifting planes of every periodic axis of the case.
template <int D>
std::vector<sph::ImagePlane<D>> periodic_planes(const General& general, int boundary);

}  // namespace poretwin
