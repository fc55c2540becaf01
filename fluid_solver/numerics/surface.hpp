// Chosen numbers of the free surface and of wetting fronts. What an entry needs: CONTRIBUTING.md.
// Symbols: V bulk volume, W kernel, h smoothing length. The divergence of position is sum V_b (x_b - x_a).grad W.
// (untried) behind a test: not yet seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::fluid::surface {

/// Least eigenvalue of the moment matrix below which a particle lies on no surface.
/// Unit: 1. Test: none known.
inline constexpr double alone = 0.1;

/// Divergence of position over the number of dimensions below which a particle has few neighbours; in soil it then lies
/// at a surface. The least eigenvalue of the moment matrix is no such measure: it is small, too, for a particle that
/// sinks out of a crowded surface. Taken for a surface particle, it would fall freely until it had passed its row, a
/// jolt in a tank at rest every few seconds.
/// Unit: 1. Test: FreeWater.NothingFallsInATankAtRest (untried).
inline constexpr double few = 0.75;
/// Divergence of position over the number of dimensions below which a particle of free water that touches no soil has
/// few neighbours and may lie at a hole. In a splash that falls on a dune, particles that count as inside at 0.5 are
/// driven into their neighbours by their own pressure, and the water gains up to 40 % of the energy of its fall. With
/// 0.6 a film of two rows that runs out gains 8 %, and with 0.75, as beside soil, holes appear inside a column of water
/// that begins to flow, and their pressures are noise (17 % at the wall behind a dam break).
/// Unit: 1. Test: dam_break_on_soil (untried).
inline constexpr double few_in_open_water = 0.55;
/// Divergence of position over the number of dimensions below which a particle has few neighbours at a seepage face.
/// Unit: 1. Test: Seepage.WaterEndsAtASeepageFace (untried).
inline constexpr double few_at_face = 0.9;
/// Divergence of position over the number of dimensions below which a particle has too few neighbours for a pressure.
/// Unit: 1. Test: FreeWater.DropsFallFreely (untried).
inline constexpr double too_few = 0.4;

/// Cosine of the half-angle of the cone about the outward normal that is empty above a particle on a free surface: 60
/// degrees.
/// Unit: 1. Test: none known.
inline constexpr double cone = 0.5;
/// As `cone`, above a particle at a wetting front in soil: 45 degrees. It is narrower since a front is rough on the
/// scale of a spacing.
/// Unit: 1. Test: none known.
inline constexpr double narrow_cone = 0.7071;

/// |sum V grad W| h measures how much of a particle's kernel is empty on one side: least value of a surface particle.
/// At a flat surface it is 0.7.
/// Unit: 1. Test: none known.
inline constexpr double first_row = 0.1;
/// Least |sum V grad W| h of a particle in the row below the surface.
/// Unit: 1. Test: none known.
inline constexpr double second_row = 0.03;

/// Ratio of |sum V grad W| h to the divergence of position from which on a particle with few neighbours lies at a hole,
/// even where other water stands opposite: half of a flat surface's ratio. If it counted as inside, its own pressure
/// would, in a splash, drive it towards its neighbours, which raises that pressure.
/// Unit: 1. Test: Operators.AParticleWithFewNeighboursOnOneSideLiesAtAHole (untried).
inline constexpr double hole = 0.23;

/// Least eigenvalue of a moment matrix that is inverted as it is at the surface, with the ghost of the missing side
/// included.
/// Unit: 1. Test: none known.
inline constexpr double least_inverted = 0.4;

/// Distance of a surface particle from the weighted mean position of its row within reach. Where it is larger, the row
/// ends near the particle and has no reliable thickness.
/// Unit: h. Test: Operators.TheSurfaceLiesHalfARowsThicknessAboveIt (untried).
inline constexpr double balanced_row = 0.15;
/// Difference of a row's thickness from a lattice's beyond which the thickness is not used. Rows at rest gain up to 15
/// %.
/// Unit: 1. Test: none known.
inline constexpr double uneven_row = 0.25;

/// Length of the mean normal of the surface particles within reach from which on they form a plane.
/// Unit: 1. Test: none known.
inline constexpr double plane_enough = 0.9;
/// Cosine between that mean normal and a particle's own normal below which the surface is not the one above the
/// particle.
/// Unit: 1. Test: none known.
inline constexpr double faces_plane = 0.5;

/// Averaging time of the thickness of a row of surface particles: longer than any resolved wave.
/// Unit: times of repair. Test: none known.
inline constexpr double row_memory = 10.0;

}  // namespace poretwin::fluid::surface
