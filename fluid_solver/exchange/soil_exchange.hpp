// The exchange between water and soil in a window.
#pragma once

#include "common/coupling/exchange.hpp"
#include "fluid_solver/boundary/columns.hpp"
#include "fluid_solver/discretisation/cloud.hpp"
#include "fluid_solver/exchange/soil_view.hpp"
#include "fluid_solver/state.hpp"

namespace poretwin::fluid {

/// The soil at the water's particles: received from the other process, or at rest as the case draws it.
template <int D>
SoilView<D> see_soil(const Setup<D>& setup, std::span<const sph::ImagePlane<D>> planes, const State<D>& state,
                     const coupling::Inbox& inbox, const SeepageRegime& regime);

/// Whether other water fills the pores around particles of free water within reach of soil [n]. It does where the
/// volumes of the water that lies in the soil add up to as much as those of the soil's points, within half of what one
/// particle at the place itself would add, or of the whole where a single point of soil adds less. coverage [n]: by the
/// soil's points. planes: mirrors of the water. All ranks call this.
template <int D>
std::vector<char> find_full_pores(const Setup<D>& setup, std::span<const sph::ImagePlane<D>> planes,
                                  const Particles<D>& p, std::span<const double> coverage);

/// Sets the particles' bulk volumes from the porosity of the soil in which they lie, and stores which soil it is. Their
/// mass stays the same.
template <int D>
void fit_pores(const Setup<D>& setup, const SoilView<D>& view, Particles<D>& p);

/// Fills the pores at the start: a particle's bulk volume is its cell of the lattice, and the porosity at the particle
/// determines its mass.
template <int D>
void fill_pores(const Setup<D>& setup, const SoilView<D>& view, Particles<D>& p);

/// Gives each column in soil the porosity of the water in front of it, where that differs from the porosity of the
/// case: another program may take the place of the solid.
template <int D>
void fit_columns_to_pores(const Setup<D>& setup, State<D>& state);

/// Applies the impulse that the soil returned. Where the soil's velocity departed from the last window's prediction,
/// drag entrains the soil's water by C / (a + C) of the departure, a = n rho / dt (Eq. (27) at that window's pressure).
///
/// The soil's own motion already includes the inertia of that water (Solid::advance), evaluated at the soil's points.
/// The difference between the two evaluations is small and uneven. It is distributed over the soil's water within one
/// kernel support, so that the total momentum is conserved.
template <int D>
void apply_returned_impulse(const Stencil<D>& s, const SoilView<D>& view, State<D>& state);

/// Applies the drag for the window's initial relative velocity to `velocity`, Eq. (75) as corrected, and removes that
/// drag from the solve. Returns the drag's force [N/m3].
template <int D>
VecArray<D> apply_drag(const Setup<D>& setup, const Particles<D>& p, double interval, SoilView<D>& view,
                       VecArray<D>& velocity);

/// Stores the impulse of the drag on the soil. of_prediction [N/m3]: force that apply_drag has applied; empty: zero.
template <int D>
void give_drag_impulse(const Setup<D>& setup, const SoilView<D>& view, std::span<const Vec<D>> of_prediction,
                       double interval, State<D>& state);

/// Adds up what all ranks have exchanged with the soil since `before`; until then each counts its own.
template <int D>
void add_up_exchanged(const Setup<D>& setup, const Exchanged<D>& before, State<D>& state);

/// Stores the force of pressure and drag on the soil, evaluated at the water's points. The soil evaluates the same
/// forces for the balance of forces that it reports. The difference between the two evaluations must not move the soil.
template <int D>
void store_coupling_force(const Setup<D>& setup, const SoilView<D>& view, std::span<const Vec<D>> gradient,
                          double interval, Particles<D>& p);

/// Stores the pressure gradient at the free surface of moving soil, at the edge of soil under free water (at_edge
/// [n]: 1) and at loose grains, for use in place of the soil's own gradient. The latter uses only the pressures at the
/// soil's points and is one-sided at the surface: it turns the pressure that a grain's motion causes into a force in
/// the direction of that motion, and accelerates a departing grain without end.
template <int D>
void store_surface_gradient(const Setup<D>& setup, const Stencil<D>& s, const SoilView<D>& view,
                            std::span<const Vec<D>> gradient, std::span<const char> at_edge, Particles<D>& p);

/// Predicts the skeleton's new velocity explicitly, for schemes in which the skeleton keeps its velocity in the solve
/// (plain staggering).
template <int D>
void predict_explicitly(const Setup<D>& setup, const SoilView<D>& view, std::span<const Vec<D>> gradient,
                        double interval, Particles<D>& p);

/// Stores the change of the skeleton's velocity in the solve. from [n]: the skeleton's velocity before the solve, m/s.
template <int D>
void store_change_of_soil(const OrZero<Vec<D>>& from, Particles<D>& p);

/// Points and fields for the soil's process, without the proposed interval.
template <int D>
coupling::Publication publication(const Cloud<D>& cloud, const State<D>& state);

/// Adds the velocity of the stream of free water and its mask, for soil that erodes. At a particle it is the mean over
/// the free water within twice the kernel's reach, with weights W |v|: water that stands in the notches of the soil's
/// edge, as that which came out of eroded soil, has no part in the stream.
template <int D>
void add_free_water(const Setup<D>& setup, const Cloud<D>& cloud, coupling::Publication& out);

}  // namespace poretwin::fluid
