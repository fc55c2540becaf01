// Chosen numbers of the sums over pairs of the soil's particles. What an entry needs: CONTRIBUTING.md.
// Symbols: h smoothing length, M constrained modulus, J2 second invariant of the deviatoric stress.
// (untried) behind a test: not yet seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::solid::points {

/// Smoothing length h, as in Bui & Nguyen (2017).
/// Unit: spacings. Test: none known.
inline constexpr double lengths_per_spacing = 1.2;

/// Least eigenvalue of a moment matrix that is inverted as it is, in 2D. Lower eigenvalues are raised to it, so that
/// particles that are nearly alone have a bounded gradient. The corners of a lattice lie above it and stay exact.
/// Unit: 1. Test: VelocityGradient.IsExactForLinearFieldsAtFreeSurfaces (untried).
inline constexpr double least_inverted_2d = 0.2;
/// Least eigenvalue of a moment matrix that is inverted as it is, in 3D.
/// Unit: 1. Test: VelocityGradient.IsExactInThreeDimensions (untried).
inline constexpr double least_inverted_3d = 0.1;

/// |B|^2 / D in soil away from surfaces, with the kernel-gradient correction B and the number D of dimensions. What
/// exceeds it reduces the stiffness at a soft edge (docs/theory/soil.md).
/// Unit: 1. Test: SoftEdges.HaveTheStressOfLowerModuli (untried).
inline constexpr double inside_correction = 1.2;

/// Hourglass control: viscosity against the part of the velocity that is not linear around a particle.
/// Unit: h times the speed of sound. Test: Stabilisers.LeaveUniformStrainRatesAlone (untried).
inline constexpr double hourglass_viscosity = 0.1;
/// Hourglass control: stiffness against the part of the displacement that is not linear around a particle, over the
/// constrained modulus M.
/// Unit: M. Test: LoadedColumn.DisorderCostsLittleStiffness (untried).
inline constexpr double hourglass_stiffness = 0.1;
/// Largest stress of the hourglass stiffness in soil that has yielded; a larger one would act as strength.
/// Unit: sqrt(J2). Test: Stabilisers.HoldASlipSurfaceOfSoilThatYieldedByAThousandthOfItsStress (untried).
inline constexpr double hourglass_bound = 0.003;
/// Plastic strain above which hourglass control is off: it would brake the flow.
/// Unit: 1. Test: none known.
inline constexpr double flow_limit = 0.01;
/// Coefficient alpha of Monaghan's artificial viscosity.
/// Unit: h times the speed of sound. Test: none known.
inline constexpr double artificial_viscosity = 0.1;
/// Coefficient alpha of Monaghan's artificial viscosity where grains that are apart collide. It makes collisions
/// inelastic.
/// Unit: h times the speed of sound. Test: none known.
inline constexpr double collision_viscosity = 1.0;
/// eta^2 of Monaghan's viscosity, which keeps the force between nearly coincident particles finite (Monaghan 1992).
/// Unit: h^2. Test: none known.
inline constexpr double viscosity_softening = 0.01;
/// Bulk viscosity of soil with soft edges (docs/theory/soil.md). It damps the waves that the longer substeps there
/// resolve poorly, and which would disturb the flow and reduce its friction.
/// Unit: spacings times the speed of sound. Test: BulkViscosity.ResistsChangesOfVolumeAlone (untried).
inline constexpr double bulk_viscosity = 0.35;
/// Exponent n of the artificial stress, by which it grows as the particles of a pair approach each other (Gray,
/// Monaghan & Swift 2001). The reason for its value is not on record.
/// Unit: 1. Test: ArtificialStress.PartsTheCloseOnesInTensionAndKeepsMomentum (untried).
inline constexpr double artificial_stress_exponent = 2.55;

/// Pair lists hold pairs up to 2 h plus a margin, the skin. Whether they are still valid is checked tile by tile;
/// particles of tiles that do not touch are at least a tile's width apart. By how much this width exceeds 2 h.
/// Unit: skins. Test: Lists.HoldWhileNeighboursMoveAlong (untried).
inline constexpr double tile_reach = 6.0;

/// Coverage by the kernel (sum V W) below which a place lies outside of the soil. A flat surface has a half, a corner a
/// quarter.
/// Unit: 1. Test: none known.
inline constexpr double outside = 0.15;

}  // namespace poretwin::solid::points
