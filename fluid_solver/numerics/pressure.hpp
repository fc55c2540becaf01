// Chosen numbers of the window's pressure solve and of explicit sweeps. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test's name: the test has not yet been seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::fluid::pressure {

/// Relative residual at which the pressure solve ends where no water is in soil. The front and the energy of a dam
/// break are the same with 1e-4.
/// Unit: 1. Test: FreeWater.DamBreakKeepsItsEnergy (untried).
inline constexpr double free_water_tolerance = 1e-3;
/// Lower bound of the solve's tolerance in soils of different conductivity. The tolerance is relative to the flow that
/// the most permeable soil could have, while the least permeable one may limit the actual flow. So the tolerance is
/// divided by the contrast of the conductivities; below this bound rounding errors would exceed it.
/// Unit: 1. Test: Seepage.SoilsInSeriesAndSideBySide (untried).
inline constexpr double tightest_tolerance = 1e-11;
/// Relative residual of the solve for the initial pressures. The reason for the value is not on record.
/// Unit: 1. Test: none known.
inline constexpr double initial_tolerance = 1e-8;

/// Residual at which a solve with a responding skeleton ends, relative to the change of pressure in the window.
/// Unit: 1. Test: Coupled.TerzaghiInNearlyTightSoil (untried).
inline constexpr double response_tolerance = 1e-2;
/// Residual at which the solve for the skeleton's velocity ends, relative to the change of that velocity or, where
/// larger, to the velocity that drag alone would give the skeleton. 1e-2 would visibly change the pressure of nearly
/// tight soil at rest, and the momentum (docs/notebook/fluid.md).
/// Unit: 1. Test: Coupled.DragRelaxesAtItsRateAndKeepsMomentum (untried).
inline constexpr double skeleton_tolerance = 1e-3;
/// Where pressure and skeleton velocity are solved for together, a solve for each of them preconditions the iteration.
/// These two solves end at this residual.
/// Unit: 1. Test: none known (iterations, not results).
inline constexpr double preconditioner_tolerance = 1e-1;
/// The skeleton responds in the pressure solve where its bulk density, over the density of water, exceeds this.
/// Unit: 1. Test: none known.
inline constexpr double least_responding = 1e-6;

/// In a solve a tangent replaces the quadratic drag. A window is solved again where the error (rms) of this tangent,
/// over the sum of inertia and drag, exceeds this value.
/// Unit: 1. Test: Coupled.QuadraticDragFollowsItsClosedFormAndKeepsMomentum (untried).
inline constexpr double drag_tolerance = 0.02;
/// Largest number of solves in a window with quadratic drag. The reason for the value is not on record.
/// Unit: solves. Test: none known.
inline constexpr int most_drag_rounds = 10;

/// Width of an aggregate of particles in the skeleton's coarse space. Widths of 4 to 6 take the least CPU time, in
/// embankment_seepage and in rockfill_dam.
/// Unit: spacings. Test: none known (time, not results).
inline constexpr double aggregate_width = 5.0;
/// Number of iterations for the pressure with the diagonal preconditioner alone. A solve that needs no more iterations
/// is faster without a coarse space.
/// Unit: iterations. Test: none known (time, not results).
inline constexpr int iterations_without_aggregates = 4;
/// Multigrid takes over after this number of iterations of conjugate gradients with aggregates. From 10,000 particles
/// on, that many take as long as a whole solve by multigrid with its setup (measured: 55 to 80, multigrid_timing.cpp).
/// Unit: iterations. Test: FreeWater.ItsSolvesTakeFewIterationsAtAnySize (untried).
inline constexpr int patience = 70;
/// After a solve of at most this number of multigrid cycles, the next starts with the diagonal preconditioner.
/// Unit: cycles. Test: none known (time, not results).
inline constexpr int few_cycles = 2;
/// Increment of the diagonal of the aggregates' matrix, over that diagonal. It applies where nothing prescribes a mean
/// pressure, so that the matrix is singular.
/// Unit: 1. Test: none known.
inline constexpr double regularisation = 1e-8;

/// Largest number of rounds in which the set of cavitating particles is found.
/// Unit: rounds. Test: none known.
inline constexpr int most_cavitation_rounds = 30;
/// Margin of the cavitating set, over the cavitation pressure. Water joins the set below the cavitation pressure by
/// this margin; it remains while its voids still open by this margin. The margin is larger than the error of a solve.
/// Unit: 1. Test: none known.
inline constexpr double cavitation_tolerance = 1e-4;
/// Weight with which a matrix row fixes the pressure of a cavitating particle, over the row's diagonal.
/// Unit: 1. Test: none known.
inline constexpr double cavitating_weight = 1e6;
/// Weight with which a matrix row fixes a prescribed pressure, over the row's diagonal.
/// Unit: 1. Test: none known.
inline constexpr double pinned_weight = 1e3;

/// A particle has too few neighbours for a correction of its pairs' weights by direction where the mean eigenvalue of
/// its moment matrix is at most this value.
/// Unit: 1. Test: none known.
inline constexpr double even_from = 0.75;
/// Largest relative change of a pair's weight in the corrections by direction and along borders between soils. A pair
/// keeps at least a tenth of its weight.
/// Unit: 1. Test: Seepage.SoilsSideBySideDoNotHoldEachOther (untried).
inline constexpr double most_stretched = 0.9;
/// Number of iterations in which WindowSolver::free_along_borders finds how much the matrix's weights of pairs beside a
/// border between two soils change. In each iteration the two rows of particles on either side of the border influence
/// each other.
/// Unit: rounds. Test: none known.
inline constexpr int border_rounds = 4;

/// Relaxation factor of a sweep. The largest eigenvalue of a graph Laplacian over its diagonal is 1.2 on a lattice and
/// at most 2 (for two particles without other neighbours), which is the limit of stability without relaxation.
/// Unit: 1. Test: Eisph.SweepsTendToTheSolution (untried).
inline constexpr double sweep_relaxation = 0.8;
/// Largest apparent compression of free water at the present pressures, as a fraction of its volume: 1 %, as in weakly
/// compressible SPH (Monaghan 1994: a speed of sound ten times that of the flow). With 3 % the front of a dam break is
/// off by 2 cm of 1.9 m.
/// Unit: 1. Test: Eisph.WindowsFollowFromTheCompressionOfASweep (untried).
inline constexpr double free_compression = 0.01;
/// Largest apparent compression of water in soil at the present pressures, as a fraction of its volume. In soil such a
/// compression only delays the flow: 10 % shifts a wetting front by 0.15 %.
/// Unit: 1. Test: Eisph.WindowsFollowFromTheCompressionOfASweep (untried).
inline constexpr double soil_compression = 0.1;

/// Least part of a pair of soil and free water that counts as soil, so that the edge does not fall on a particle.
/// Unit: length of the pair. Test: SoilSurface.PassesTheWaterOfSoilThatIsCompressed (untried).
inline constexpr double least_inside = 0.05;

}  // namespace poretwin::fluid::pressure
