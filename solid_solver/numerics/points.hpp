// Chosen numbers of the sums over pairs of soil's points. What an entry needs: CONTRIBUTING.md.
// (untried) behind a test: not yet seen to fail when the number is halved or doubled.
#pragma once

namespace poretwin::solid::points {

/// Smoothing length, as in Bui & Nguyen (2017).
/// Unit: spacings. Test: none known.
inline constexpr double lengths_per_spacing = 1.2;

/// Least eigenvalue of a moment that is inverted in full, in 2D: particles that are nearly alone keep a bounded
/// gradient. Corners of a lattice lie above it, so that they stay exact.
/// Unit: 1. Test: VelocityGradient.IsExactForLinearFieldsAtFreeSurfaces (untried).
inline constexpr double least_inverted_2d = 0.2;
/// Least eigenvalue of a moment that is inverted in full, in 3D.
/// Unit: 1. Test: VelocityGradient.IsExactInThreeDimensions (untried).
inline constexpr double least_inverted_3d = 0.1;

/// |B|^2 / D, of the correction B, that soil away from surfaces comes to: what exceeds it softens an edge.
/// Unit: 1. Test: SoftEdges.HaveTheStressOfLowerModuli (untried).
inline constexpr double inside_correction = 1.2;

/// Hourglass control: a viscosity on the part of the velocity that is not linear around a particle.
/// Unit: h times the speed of sound. Test: Stabilisers.LeaveUniformStrainRatesAlone (untried).
inline constexpr double hourglass_viscosity = 0.1;
/// Hourglass control: a stiffness on the part of the displacement that is not linear around a particle.
/// Unit: M. Test: LoadedColumn.DisorderCostsLittleStiffness (untried).
inline constexpr double hourglass_stiffness = 0.1;
/// Largest stress of that stiffness in soil that has yielded, where more would act as strength.
/// Unit: sqrt(J2). Test: Stabilisers.HoldASlipSurfaceOfSoilThatYieldedByAThousandthOfItsStress (untried).
inline constexpr double hourglass_bound = 0.003;
/// Plastic strain above which hourglass control is off: it would brake the flow.
/// Unit: 1. Test: none known.
inline constexpr double flow_limit = 0.01;
/// alpha of Monaghan's artificial viscosity.
/// Unit: h times the speed of sound. Test: none known.
inline constexpr double artificial_viscosity = 0.1;
/// alpha of Monaghan's artificial viscosity where grains that are apart collide: inelastically.
/// Unit: h times the speed of sound. Test: none known.
inline constexpr double collision_viscosity = 1.0;
/// eta^2 of these viscosities, which keeps pairs that nearly coincide finite (Monaghan 1992).
/// Unit: h^2. Test: none known.
inline constexpr double viscosity_softening = 0.01;
/// Viscosity of soil with soft edges against changes of volume: waves that long substeps resolve poorly disturb the
/// flow and reduce its friction.
/// Unit: spacings times the speed of sound. Test: BulkViscosity.ResistsChangesOfVolumeAlone (untried).
inline constexpr double bulk_viscosity = 0.35;
/// n of the artificial stress, with which it grows as pairs come close (Gray, Monaghan & Swift 2001). No reason on
/// record.
/// Unit: 1. Test: ArtificialStress.PartsTheCloseOnesInTensionAndKeepsMomentum (untried).
inline constexpr double artificial_stress_exponent = 2.55;

/// Width of the tiles in which lists are checked, over two smoothing lengths: particles of tiles that do not touch are
/// farther apart than 2 h by so much.
/// Unit: skins. Test: Lists.HoldWhileNeighboursMoveAlong (untried).
inline constexpr double tile_reach = 6.0;

/// Coverage by the kernel below which a place is outside of the soil: a flat surface has half of the kernel's weight, a
/// corner a quarter.
/// Unit: 1. Test: none known.
inline constexpr double outside = 0.15;

}  // namespace poretwin::solid::points
