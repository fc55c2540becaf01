// Chosen numbers of the exchange of fields with the soil, on the water's side. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test's name: the test has not yet been seen to fail when the number is halved or doubled.
#pragma once

#include <array>
#include <cstddef>

namespace poretwin::fluid::exchange {

/// The porosity behind a face changes to the one mapped from the soil before it if they differ by at least this value.
/// Unit: 1. Test: Python.AnotherSoilThanTheCaseDrawsIsUsedAtFacesToo (untried).
inline constexpr double same_porosity = 1e-3;
/// A point counts as in soil where the volume fraction of the grains is at least this.
/// Unit: 1. Test: none known.
inline constexpr double least_solid_fraction = 1e-3;

/// Inertia dominates the motion of water in soil where drag needs longer than this time to stop the water: a third of
/// the longest window for a free surface. At a spacing of 2 cm it is 4.5 ms, or a drag rate C / (n rho_w) of 220 1/s:
/// rockfill has about 20 1/s, sand (k = 1e-3 m/s, n = 0.4) 3900 1/s.
/// Unit: sqrt(spacing / g). Test: CoarseSoil.ASlabFallsAgainstItsDrag (untried).
inline constexpr double held_within = 0.1;

/// A place lies outside of the soil where the asymmetry of the soil's points around it exceeds this value. The
/// asymmetry is 0.47 on a flat edge of the soil, in the middle of the ramp from inside to outside.
/// Unit: 1. Test: none known.
inline constexpr double outside_asymmetry = 0.63;
/// Difference of the asymmetry between the ends of the ramp from inside to outside the soil. With it, disorder inside
/// the soil (asymmetry 0.3 at most, for particles anywhere in their cells) does not change the porosity.
/// Unit: 1. Test: none known.
inline constexpr double ramp_width = 0.32;

/// The asymmetry as a polynomial of the distance outside a flat edge: a fit to sums over lattices in 2D and 3D with a
/// smoothing length of 1.2 spacings, from half a spacing inside to one spacing outside.
/// Unit: 1, per spacing of the soil, per its square. Test: SoilSurface.TellsHowFarAPlaceIsFromIt.
inline constexpr std::array<double, 3> asymmetry_outside{0.482, 0.64, 0.14};

/// Coverage at a flat edge of the soil as a function of the asymmetry, 1 - 1.04 times the asymmetry: a fit, to 0.02, to
/// sums over lattices in 2D and 3D with a smoothing length of 1.2 spacings, for asymmetries up to 0.65.
/// Unit: 1. Test: SoilSurface.GrainsApartCountAsTheVolumeTheyHave.
inline constexpr double coverage_slope = 1.04;
/// Coverage over the one of a body, up to which yielding soil is loose and from which on it is a body. Points of a body
/// that are displaced from a lattice by up to 0.4 spacings have 0.77 or more, grains that lie
/// 1.4 spacings from each other have 0.5.
/// Unit: 1. Test: SoilSurface.GrainsApartCountAsTheVolumeTheyHave.
inline constexpr std::array<double, 2> body_density{0.6, 0.8};
/// Spread of the points of yielding soil around a place, up to which they are loose and from which on they form a body:
/// 0 of a single point, 0.3 to 0.4 of two that touch, 0.38 at corners of a body, 0.58 on a flat edge (0.76 in 3D).
/// Unit: smoothing lengths. Test: SoilSurface.WaterSlipsPastAnEdgeButDragsASinglePoint (untried).
inline constexpr std::array<double, 2> body_spread{0.15, 0.3};

/// Asymmetry from which on loose grains do not count; the decrease to zero begins at `outside_asymmetry`. With the
/// whole reach of the kernel (2) water that splashes over a dune gains energy in case dam_break_on_soil. With 0.8 a
/// single grain counts as half of its volume.
/// Unit: 1. Test: SoilSurface.GrainsApartCountAsTheVolumeTheyHave (untried).
inline constexpr double loose_asymmetry = 1.0;

/// Free water enters the pores of tight soil in short windows where the volumes of the water there leave at least this
/// part of what a particle at the place would add. It is 1 where that particle is missing, and 0 where none is.
/// Unit: 1. Test: SoilSurface.FullPoresTakeNoMoreWater.
inline constexpr double least_room = 0.5;
/// Smoothing length of the soil's points, with which the coverage by them is summed (solid_solver/numerics/points.hpp).
/// Unit: spacings of the soil. Test: SoilSurface.FullPoresTakeNoMoreWater (untried).
inline constexpr double soil_smoothing_ratio = 1.2;

/// Smoothing length of the sums (67) and (74) of Bui & Nguyen (2017), who use the same value and kernel (cubic spline).
/// Unit: spacings of the soil. Test: Seepage.SmoothedDragIsAsStrongAsItsKernelSum (untried).
inline constexpr double drag_smoothing_ratio = 1.2;
/// eta^2 of these sums, which keeps the drag between coincident points finite.
/// Unit: h^2. Test: none known.
inline constexpr double drag_softening = 1e-4;

/// In a repeated window a quasi-Newton method extrapolates from the changes between successive passes. It uses at most
/// this number of changes. The reason for the value is not on record.
/// Unit: passes. Test: Passes.ThreeSoftModesAgreeInFiveThoughRepeatedAsTheyAreTheyGrow (untried).
inline constexpr std::size_t most_changes = 8;
/// A change between passes is used only where at least this fraction of it is linearly independent of the other
/// changes. A smaller fraction is a rounding error.
/// Unit: 1. Test: none known.
inline constexpr double independent_change = 1e-6;

/// Averaging time of the difference between the volumetric strain rate that the soil reports and the divergence of the
/// soil's velocity as mapped to the water. In a single window this difference also contains the soil's shortest waves,
/// since the mapping smooths them.
/// Unit: windows. Test: Coupled.PredictsThatSoilClosesWhatItsOwnAccountOpens.
inline constexpr double unseen_strain_windows = 8.0;

}  // namespace poretwin::fluid::exchange
