// What passes between the water and the soil in a window.
#pragma once

#include "common/coupling/exchange.hpp"
#include "fluid_solver/boundary/columns.hpp"
#include "fluid_solver/discretisation/cloud.hpp"
#include "fluid_solver/exchange/soil_view.hpp"
#include "fluid_solver/state.hpp"

namespace poretwin::fluid {

/// The soil at the water's particles: as the exchange brought it, or as it is drawn.
template <int D>
SoilView<D> see_soil(const Setup<D>& setup, const State<D>& state, const coupling::Inbox& inbox,
                     const SeepageRegime& regime);

/// Fits the particles' bulk volumes to the pores of the soil that they are in, their mass kept.
template <int D>
void fit_pores(const Setup<D>& setup, const SoilView<D>& view, Particles<D>& p);

/// Fills the pores at the start: the cells of the lattice are the particles' bulk volumes, the soil at each sets the
/// mass of water in it.
template <int D>
void fill_pores(const Setup<D>& setup, const SoilView<D>& view, Particles<D>& p);

/// Gives each column in soil the pores that the water before it is in, where they are not as drawn: the solid may be
/// another program.
template <int D>
void fit_columns_to_pores(const Setup<D>& setup, State<D>& state);

/// Applies the impulse that the soil returned. Where the soil's velocity departed from the last window's prediction,
/// drag takes its water along by C / (a + C) of the departure, a = n rho / dt (Eq. (27) at that window's pressure). The
/// soil has already met the inertia of that water (Solid::advance), evaluated at its own points. The difference between
/// the two evaluations is small and uneven; it is distributed over the soil's water within one kernel support, so that
/// the total momentum is conserved.
template <int D>
void apply_returned_impulse(const Stencil<D>& s, const SoilView<D>& view, State<D>& state);

/// Applies the drag of the window's start to the prediction `velocity`, Eq. (75) as corrected, and leaves none to the
/// solve; returns its force [N/m3].
template <int D>
VecArray<D> apply_drag(const Setup<D>& setup, const Particles<D>& p, double interval, SoilView<D>& view,
                       VecArray<D>& velocity);

/// Stores the impulse of the drag on the soil. of_prediction [N/m3]: force already applied; empty: none.
template <int D>
void give_drag_impulse(const Setup<D>& setup, const SoilView<D>& view, std::span<const Vec<D>> of_prediction,
                       double interval, State<D>& state);

/// Stores the force of pressure and drag on the soil as evaluated at the water's points. The soil reports its balance
/// of forces with its own evaluation of these forces in it; the difference of the two operators must not move it.
template <int D>
void store_coupling_force(const Setup<D>& setup, const SoilView<D>& view, std::span<const Vec<D>> gradient,
                          double interval, Particles<D>& p);

/// Stores the pressure gradient at the free surface of moving soil, which the soil is given in place of its own. Its
/// own gradient knows only pressures at its points. One-sided at the surface, it turns the pressure that a grain's
/// motion causes into a force in the direction of that motion, and a grain that moves off would accelerate without end.
template <int D>
void store_surface_gradient(const Setup<D>& setup, const Stencil<D>& s, std::span<const Vec<D>> gradient,
                            Particles<D>& p);

/// Plain staggering: the skeleton kept its velocity in the solve; its new velocity is predicted explicitly.
template <int D>
void predict_explicitly(const Setup<D>& setup, const SoilView<D>& view, std::span<const Vec<D>> gradient,
                        double interval, Particles<D>& p);

/// Stores by how much the solve changed the skeleton's velocity; from [n]: what it began with, m/s.
template <int D>
void store_change_of_soil(const OrZero<Vec<D>>& from, Particles<D>& p);

/// What the soil's process is given, its proposal left out.
template <int D>
coupling::Publication publication(const Cloud<D>& cloud, const State<D>& state);

}  // namespace poretwin::fluid
