// Chosen numbers of the sums over pairs of the soil's particles. What an entry needs: CONTRIBUTING.md.
// Symbols: h smoothing length, M constrained modulus, J2 second invariant of the deviatoric stress.
// (untried) behind a test's name: the test has not yet been seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::solid::points {

/// Smoothing length h, as in Bui & Nguyen (2017).
/// Unit: spacings. Test: none known.
inline constexpr double lengths_per_spacing = 1.2;

/// A moment matrix is inverted as it is in 2D where its least eigenvalue is at least this. Lower eigenvalues are raised
/// to it, which bounds the gradient of particles nearly alone. The corners of a lattice lie above it and stay exact.
/// Unit: 1. Test: VelocityGradient.IsExactForLinearFieldsAtFreeSurfaces.
inline constexpr double least_inverted_2d = 0.2;
/// In 3D a moment matrix is inverted as it is where its least eigenvalue is at least this value.
/// Unit: 1. Test: none known.
inline constexpr double least_inverted_3d = 0.1;

/// Value of |B|^2 / D in soil away from surfaces, with the kernel-gradient correction B and the number D of dimensions.
/// An excess over this value reduces the stiffness at a soft edge (docs/theory/soil.md).
/// Unit: 1. Test: SoftEdges.HaveTheStressOfLowerModuli.
inline constexpr double inside_correction = 1.2;

/// Hourglass control: viscosity against the part of the velocity that is not linear around a particle.
/// Unit: h times the speed of sound. Test: none known.
inline constexpr double hourglass_viscosity = 0.1;
/// Hourglass control: stiffness against the part of the displacement that is not linear around a particle, over the
/// constrained modulus M.
/// Unit: M. Test: none known.
inline constexpr double hourglass_stiffness = 0.1;
/// Largest stress of the hourglass stiffness in soil that has yielded. A larger one would act as added strength.
/// Unit: sqrt(J2). Test: Stabilisers.HoldASlipSurfaceOfSoilThatYieldedByAThousandthOfItsStress.
inline constexpr double hourglass_bound = 0.003;
/// Hourglass control is off where the plastic strain exceeds this value: it would brake the flow.
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
/// Bulk viscosity of soil with soft edges (docs/theory/soil.md). It damps the waves that the longer substeps of such
/// soil resolve poorly; these waves would disturb the flow and reduce its friction.
/// Unit: spacings times the speed of sound. Test: none known.
inline constexpr double bulk_viscosity = 0.35;
/// Exponent n of the artificial stress, by which it grows as the particles of a pair approach each other (Gray,
/// Monaghan & Swift 2001). The reason for its value is not on record.
/// Unit: 1. Test: none known.
inline constexpr double artificial_stress_exponent = 2.55;

/// Pair lists contain pairs up to 2 h plus a margin, the skin. Their validity is checked tile by tile; particles of two
/// tiles that do not touch are at least a tile's width apart. The width exceeds 2 h by this length.
/// Unit: skins. Test: none known.
inline constexpr double tile_reach = 6.0;

/// A place lies outside of the soil where the coverage by the kernel (sum V W) is below this value. The coverage is a
/// half on a flat surface and a quarter in a corner.
/// Unit: 1. Test: none known.
inline constexpr double outside = 0.15;

}  // namespace poretwin::solid::points
