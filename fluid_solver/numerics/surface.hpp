// Chosen numbers of the free surface and of wetting fronts. What an entry needs: CONTRIBUTING.md.
// Symbols: V bulk volume, W kernel, h smoothing length. The divergence of position is sum V_b (x_b - x_a).grad W.
// (untried) behind a test's name: the test has not yet been seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::fluid::surface {

/// A particle lies on no surface where the least eigenvalue of its moment matrix is below this value.
/// Unit: 1. Test: none known.
inline constexpr double alone = 0.1;

/// A particle has few neighbours where the divergence of position over the number of dimensions is below this; in soil
/// it then lies at a surface. The least eigenvalue of the moment matrix does not show this: it is also small for a
/// particle that sinks out of a crowded surface. If that particle counted as one of the surface, it would fall freely
/// through its row, and a tank at rest would be jolted every few seconds.
/// Unit: 1. Test: FreeWater.NothingFallsInATankAtRest (untried).
inline constexpr double few = 0.75;
/// A particle of free water that touches no soil has few neighbours, and may lie at a hole, where the divergence of
/// position over the number of dimensions is below this. In a splash that falls on a dune, with 0.5 some particles
/// count as inside and are driven into their neighbours by their own pressure: the water gains up to 40 % of the energy
/// of its fall. With 0.6 a film of two rows that runs out gains 8 %. With 0.75, as beside soil, holes appear inside a
/// column of water that begins to flow, and their pressures are noise (17 % at the wall behind a dam break).
/// Unit: 1. Test: dam_break_on_soil (untried).
inline constexpr double few_in_open_water = 0.55;
/// At a seepage face, this value replaces `few`.
/// Unit: 1. Test: Seepage.WaterEndsAtASeepageFace (untried).
inline constexpr double few_at_face = 0.9;
/// A particle has too few neighbours for a pressure where the same ratio as for `few` is below this value.
/// Unit: 1. Test: FreeWater.DropsFallFreely (untried).
inline constexpr double too_few = 0.4;

/// A particle of free water can lie on the surface only where the cone about its outward normal is empty. This is the
/// cosine of the cone's half-angle, which is 60 degrees.
/// Unit: 1. Test: none known.
inline constexpr double cone = 0.5;
/// As `cone`, for a particle at a wetting front in soil: 45 degrees. This cone is narrower because a front is rough on
/// the scale of a spacing.
/// Unit: 1. Test: none known.
inline constexpr double narrow_cone = 0.7071;

/// |sum V grad W| h measures how much of a particle's kernel is empty on one side. A surface particle has at least this
/// value; at a flat surface it is 0.7.
/// Unit: 1. Test: none known.
inline constexpr double first_row = 0.1;
/// Least |sum V grad W| h of a particle in the row below the surface.
/// Unit: 1. Test: none known.
inline constexpr double second_row = 0.03;

/// A particle with few neighbours lies at a hole where the ratio of |sum V grad W| h to the divergence of position is
/// at least this, even if other water stands opposite. At a flat surface the ratio is twice as large. In a splash, the
/// pressure of a particle that counted as inside would drive it towards its neighbours, which raises that pressure.
/// Unit: 1. Test: Operators.AParticleWithFewNeighboursOnOneSideLiesAtAHole (untried).
inline constexpr double hole = 0.23;

/// At the surface a moment matrix, which includes the ghost of the missing side, is inverted as it is where its least
/// eigenvalue is at least this.
/// Unit: 1. Test: none known.
inline constexpr double least_inverted = 0.4;

/// Largest distance between a surface particle and the weighted mean position of its row within reach. Where it is
/// larger, the row ends near the particle and has no reliable thickness.
/// Unit: h. Test: Operators.TheSurfaceLiesHalfARowsThicknessAboveIt (untried).
inline constexpr double balanced_row = 0.15;
/// Largest difference between the thickness of a row and that of a lattice's row. Where it is larger, the thickness is
/// not used. Rows at rest become up to 15 % thicker.
/// Unit: 1. Test: none known.
inline constexpr double uneven_row = 0.25;

/// The surface particles within reach form a plane where the length of their mean normal is at least this value.
/// Unit: 1. Test: none known.
inline constexpr double plane_enough = 0.9;
/// Where the cosine between that mean normal and a particle's own normal is below this value, the surface is not the
/// one above the particle.
/// Unit: 1. Test: none known.
inline constexpr double faces_plane = 0.5;

/// Averaging time of the thickness of a row of surface particles: longer than any resolved wave.
/// Unit: times in which free water's packing is repaired. Test: none known.
inline constexpr double row_memory = 10.0;

}  // namespace poretwin::fluid::surface
