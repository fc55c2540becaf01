// Makes particles and image planes from the case's shapes and faces.
#pragma once

#include "common/case/case.hpp"
#include "common/core/vector.hpp"
#include "common/particles/images.hpp"

#include <span>
#include <string>

namespace poretwin {

/// Whether x [m] is inside the shape (borders included). Boxes in 2D ignore z.
bool contains(const Shape& shape, const Point3& x, int dimension);

/// The soil in which x [m] lies as the case draws it; where soils touch or overlap, the first; null outside all soil.
const Soil* soil_at(const Case& scene, const Point3& x);

/// Whether x [m] lies in a [[fluid.region]]. Such a place may be in soil or outside it.
bool in_fluid_region(const Case& scene, const Point3& x);

/// Smallest box around the shape.
std::pair<Point3, Point3> bounds(const Shape& shape);

/// Velocity at x of the lowest sloshing mode, along the x axis, of a liquid that fills the shape's box. It is relative
/// to the velocity at the ends of the liquid's surface.
Point3 sloshing_mode(const Shape& shape, const Point3& x, int dimension);

/// Whether the face is an opening that no soil touches (2D), through which particles of water enter and leave.
/// Otherwise the water behind it is still and needs no particles.
bool is_inlet(const Case& scene, const WaterFace& face);

/// Distance [m] of x from a face: from its lines, or (3D) from its part of a plane, before which x must lie; else
/// infinite.
double distance_from(const Face& face, const Point3& x, int dimension);

/// Whether still water that no particles represent lies behind the face, up to the level that a head prescribes or that
/// follows from a basin's balance.
bool is_reservoir(const Case& scene, const WaterFace& face);

/// The upper end of a face, if no wall or other face touches it. Water behind the face that is higher runs over it.
struct Crest {
  Point3 end = Point3::Zero();     ///< m
  double elevation = 0.0;          ///< m
  Point3 inward = Point3::Zero();  ///< unit, level, into the domain; zero where the face itself is level
};
std::optional<Crest> crest_of(const Case& scene, const WaterFace& face);

/// Whether x [m] lies on the side of a face on which its reservoir is. Above the crest, the vertical line through the
/// crest divides the sides.
bool is_behind(const Case& scene, const WaterFace& face, const Point3& x);

/// The reason why water behind a face cannot run over its crest and become particles there; empty if it can.
std::string no_way_over(const Case& scene, const Crest& crest);

/// Particles on a lattice that fills a shape.
template <int D>
struct Lattice {
  VecArray<D> position;  ///< [n] m
  double volume = 0.0;   ///< m^D, of each particle
};

/// Fills a shape. The spacing is stretched a little if the shape's bounding box is not a whole number of spacings.
/// offset: of the first particle from the lower corner, in spacings; jitter: uniform random displacement +- jitter
/// spacings. Points on an edge of a polygon count as outside, since otherwise rounding would decide; but a point that
/// also lies on an edge of a shape that is filled later (`later`) counts as inside.
template <int D>
Lattice<D> fill(const Shape& shape, double spacing, const Point3& offset, double jitter, unsigned seed,
                std::span<const Shape> later = {});

/// Whether lay() moves the particles of a shape (3D): true except for balls and for boxes at any angle.
bool is_packed(const Shape& shape);

/// Fills a shape for a run. In bodies with slanted or curved faces (3D) the particles are then moved until they are
/// evenly spaced.
template <int D>
Lattice<D> lay(const Shape& shape, double spacing, const Point3& offset, double jitter, unsigned seed,
               std::span<const Shape> later = {});

/// The straight pieces of a face as mirror planes. They are extended by `margin` [m] so that corners close.
template <int D>
std::vector<sph::ImagePlane<D>> planes_of(const Face& face, int boundary, double margin);

/// Extends pieces of walls (made without a margin) by `margin` [m] beyond their ends so that corners close. Images are
/// divided at the bisector if the next piece continues straight, turns away from the domain, or turns towards it by
/// less than 75 degrees. In narrower corners only the images of what lies before the next piece continue.
template <int D>
void meet_at_corners(std::span<sph::ImagePlane<D>> planes, double margin);

/// The two planes of every periodic axis of the case, which shift images.
template <int D>
std::vector<sph::ImagePlane<D>> periodic_planes(const General& general, int boundary);

}  // namespace poretwin
