// Chosen numbers of the free surface and of wetting fronts. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test: not yet seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::fluid::surface {

/// Least eigenvalue of the moment below which a particle is on no surface.
/// Unit: 1. Test: none known.
inline constexpr double alone = 0.1;

/// Divergence of position over D below which a particle's neighbours are few: in soil it then lies at a surface. The
/// least eigenvalue of the moment does not show it: a particle that sinks out of a crowded surface has a small one,
/// too; it would fall freely until it had passed its row, a jolt in a tank at rest every few seconds.
/// Unit: 1. Test: FreeWater.NothingFallsInATankAtRest (untried).
inline constexpr double few = 0.75;
/// Divergence of position over D below which a particle's neighbours are few at a seepage face.
/// Unit: 1. Test: Seepage.WaterEndsAtASeepageFace (untried).
inline constexpr double few_at_face = 0.9;
/// Divergence of position over D below which a particle's neighbours are too few for a pressure.
/// Unit: 1. Test: FreeWater.DropsFallFreely (untried).
inline constexpr double too_few = 0.4;

/// Cosine of half the opening of the cone about the outward normal that is empty above a particle on a free surface: 60
/// degrees.
/// Unit: 1. Test: none known.
inline constexpr double cone = 0.5;
/// Cosine of half the opening of the empty cone above a front in soil, which is rough on the scale of a spacing: 45
/// degrees.
/// Unit: 1. Test: none known.
inline constexpr double narrow_cone = 0.7071;

/// Least |sum V grad W| h that a missing side makes of a surface particle; a flat surface makes 0.7.
/// Unit: 1. Test: none known.
inline constexpr double first_row = 0.1;
/// Least
/// sum V grad W
/// h that a missing side makes of a particle in the row below the surface.
/// Unit: 1. Test: none known.
inline constexpr double second_row = 0.03;

/// Ratio of
/// sum V grad W
/// h to the divergence of position, half of a flat surface's, from which on a particle with few neighbours lies at a
/// hole, even where other water stands opposite. Taken for a particle inside, it would, in a splash, be driven to its
/// neighbours by its own pressure, which raises that pressure.
/// Unit: 1. Test: Operators.AParticleWithFewNeighboursOnOneSideLiesAtAHole (untried).
inline constexpr double hole = 0.23;

/// Least eigenvalue inverted at the surface, the ghost counted.
/// Unit: 1. Test: none known.
inline constexpr double least_inverted = 0.4;

/// Distance of the centre of a surface's row from its particle beyond which the row ends there and has no reliable
/// thickness.
/// Unit: h. Test: Operators.TheSurfaceLiesHalfARowsThicknessAboveIt (untried).
inline constexpr double balanced_row = 0.15;
/// Departure of a row's thickness from a lattice's beyond which it is none: at rest rows gain up to 15 %.
/// Unit: 1. Test: none known.
inline constexpr double uneven_row = 0.25;

/// Length of the mean of the normals of surface particles in reach from which on these make a plane.
/// Unit: 1. Test: none known.
inline constexpr double plane_enough = 0.9;
/// Cosine between that mean and a particle's own normal below which the surface is not the one above the particle.
/// Unit: 1. Test: none known.
inline constexpr double faces_plane = 0.5;

/// Averaging time of the thickness of a surface's row: longer than any wave that is resolved.
/// Unit: times of repair. Test: none known.
inline constexpr double row_memory = 10.0;

}  // namespace poretwin::fluid::surface
