#include "fluid_solver/fluid_phase.hpp"

#include "common/case/gauge_kinds.hpp"
#include "common/core/error.hpp"
#include "common/core/threads.hpp"
#include "common/coupling/interrupt.hpp"
#include "fluid_solver/boundary/pistons.hpp"
#include "fluid_solver/discretisation/operators.hpp"
#include "fluid_solver/discretisation/ranks.hpp"
#include "fluid_solver/discretisation/water_stencil.hpp"
#include "fluid_solver/exchange/soil_exchange.hpp"
#include "fluid_solver/fluid.hpp"
#include "fluid_solver/motion/advection.hpp"
#include "fluid_solver/motion/step_limits.hpp"
#include "fluid_solver/motion/viscosity.hpp"
#include "fluid_solver/motion/volume_source.hpp"
#include "fluid_solver/numerics/surface.hpp"
#include "fluid_solver/output/gauges.hpp"
#include "fluid_solver/output/report.hpp"
#include "fluid_solver/pressure/hydrostatic.hpp"
#include "fluid_solver/pressure/water_solve.hpp"
#include "fluid_solver/regimes.hpp"

namespace poretwin::fluid {

template <int D>
Fluid<D>::Fluid(const Case& scene, WaterBoundaries boundaries, const std::vector<Lattice<D>>& lattices, Setup<D> setup)
    : setup_(std::move(setup)),
      state_(first_state<D>(scene, setup_, boundaries, lattices)),
      faces_(scene, std::move(boundaries), state_),
      walls_(scene, state_.inlets) {
  walls_.expect_before(state_.particles.position);
  begin_with_share(setup_, state_.particles);
  // The soil searches for its initial equilibrium under this pressure, published before the first exchange.
  auto view = rigid_soil<D>(setup_.ground, state_.particles.position, setup_.drag);
  solve_hydrostatic(setup_, walls_, view, state_);
}

template <int D>
Fluid<D>::Fluid(const Case& scene, std::shared_ptr<Tiling<D>> tiling)
    : Fluid(scene, make_water_boundaries(scene), water_lattices<D>(scene), std::move(tiling)) {}

template <int D>
Fluid<D>::Fluid(const Case& scene, WaterBoundaries boundaries, const std::vector<Lattice<D>>& lattices,
                std::shared_ptr<Tiling<D>> tiling)
    : Fluid(scene, std::move(boundaries), lattices, Setup<D>(scene, lattices, std::move(tiling))) {}

template <int D>
coupling::Contract Fluid<D>::contract() const {
  auto takes = coupling::standard_fields(coupling::Role::solid, D);
  if (setup_.responds)
    for (auto& spec : takes)
      spec.found = spec.name == coupling::field::mean_solid_velocity || spec.name == coupling::field::unbalanced_force;
  auto gives = coupling::standard_fields(coupling::Role::fluid, D);
  if (setup_.soil_erodes) std::ranges::move(coupling::free_water_fields(D), std::back_inserter(gives));
  return {D, setup_.digest, std::move(gives), std::move(takes)};
}

template <int D>
coupling::Publication Fluid<D>::publish() const {
  const auto still = still_water<D>(setup_, faces_, walls_.planes, state_);
  const auto cloud = make_cloud<D>(state_, walls_, setup_.weight, setup_.origin, std::span<const StillWater<D>>(still));
  auto out = publication<D>(cloud, state_);
  if (setup_.soil_erodes) add_free_water<D>(setup_, cloud, out);
  std::tie(out.proposed_interval, out.limited_by) = proposal();
  return out;
}

template <int D>
std::pair<double, std::string> Fluid<D>::proposal() const {
  return time_limit(setup_, faces_, state_);
}

template <int D>
void Fluid<D>::initialise(const coupling::Inbox& inbox) {
  auto& p = state_.particles;
  const SeepageRegime regime{setup_.density, quasi_static_speed(setup_), true};  // no window has been computed so far
  auto view = see_soil<D>(setup_, walls_.planes, state_, inbox, regime);
  fill_pores(setup_, view, p);
  if (setup_.coupled) fit_columns_to_pores(setup_, state_);
  set_regimes(view, regime, p);
  begin_control(setup_, view, 0.0, state_);
  p.solid_velocity = view.velocity;
  solve_hydrostatic(setup_, walls_, view, state_);
  limit_scheme(setup_, view, state_);
  double own = 0.0;
  for (const double m : p.mass) own += m / setup_.density;
  state_.balance.initial += setup_.domain.sum(own);
  ++state_.revision;
}

template <int D>
coupling::Outcome Fluid<D>::advance(const coupling::Window& window, const coupling::Inbox& inbox) {
  auto& p = state_.particles;
  const double dt = window.interval, end = window.time + dt;
  const Exchanged<D> exchanged_before = state_.exchanged;
  const double proposed = setup_.is_projection() ? dt : proposal().first;

  // The soil as the water sees it, the boundaries, and the first half of the motion.
  const auto regime = seepage_regime(setup_, dt);
  auto view = see_soil<D>(setup_, walls_.planes, state_, inbox, regime);
  view.linearise(p.velocity, view.velocity);
  VecArray<D> velocity_before;
  if (setup_.coupled) velocity_before = p.velocity;  // kept, since the soil's impulse changes the velocity
  fit_pores(setup_, view, p);
  set_regimes(view, regime, p);
  set_inlets(setup_, faces_, walls_, window.time, dt, state_);
  advance_boundaries(setup_, faces_, window.time, dt, state_);
  update_columns<D>(faces_.boundaries, state_.faces, end, setup_.weight, setup_.origin, state_.columns);
  push_pistons(0.5 * dt);
  drift(setup_, walls_, dt, p);

  // Neighbours, the water's surface, and the impulse that the soil returns.
  auto s = water_stencil(setup_, walls_, state_);
  ++state_.counts.stencils;
  flow_together(setup_, s, p);
  mark_surface<D>(setup_, s, p.row, share_of_rows(setup_, dt), state_);
  if (setup_.coupled && !setup_.computes_beside) apply_returned_impulse(s, view, state_);
  check_room(setup_, state_, window.time);

  // The right-hand side and the parameters of the solve.
  auto in = window_problem(setup_, walls_, state_, dt);
  in.cavitation = setup_.cavitation_pressure;
  // Ranks receive signals at different times.
  if (window.saved && !setup_.tiling) in.between_iterations = coupling::give_up_if_interrupted;
  if (setup_.coupled) in.in_seepage = p.in_seepage;
  if (!setup_.is_projection()) {
    in.sweeps = setup_.sweeps;
    in.interval_over_proposed = dt / proposed;
  }
  MatArray<D> gradient;  // empty where all water is quasi-static
  if (!setup_.domain.all(all_quasi_static(setup_, p, view)))
    gradient = velocity_gradient<D>(s, p.velocity, setup_.no_slip);
  auto forced = forced_velocity<D>(setup_, state_, s, view, gradient, dt);
  auto source = volume_source<D>(setup_, state_, s, view, gradient, dt);
  BedPassage passage;
  if (!state_.bed.empty()) {
    passage = pass_bed(setup_, dt, state_);
    add_bed_source<D>(passage, dt, s, source);
  }
  in.source = std::move(source);
  in.deferred_flux = deferred_flux(setup_, state_, view, dt);
  auto besides = catch_up<D>(setup_, view, in.deferred_flux, dt, state_);
  const bool explicit_drag = setup_.scheme == FluidCase::Scheme::eisph_explicit_drag;
  const bool returns =
      setup_.domain.any(view.nonlinear()) || explicit_drag;  // the drag for the window's initial relative velocity is
                                                             // needed again after the solve
  const ScalarArray drag = returns ? view.drag : ScalarArray();
  VecArray<D> drag_of_prediction;
  if (explicit_drag) drag_of_prediction = apply_drag(setup_, p, dt, view, forced);
  in.velocity = forced.empty() ? p.velocity : forced;
  passes_.begin(window.pass, view, setup_.tiling.get());
  if (!passes_.pressure().empty()) in.pressure = p.pressure;
  in.sections = solved_sections(setup_, state_);

  // The solve, and the fields that the soil needs from its result.
  const auto out = solve_with_drag(setup_, s, in, passes_, view, state_);
  check_finite(state_, out, window.time);
  const ScalarArray pressure_before = p.pressure;
  if (!setup_.coupled) velocity_before = p.velocity;
  take_solution(setup_, out, end, state_);
  if (setup_.coupled) {
    give_drag_impulse<D>(setup_, view, drag_of_prediction, dt, state_);
    store_coupling_force<D>(setup_, view, out.gradient, dt, p);
    passes_.end(p.pressure, p.solid_velocity, p.coupling_force);
    store_surface_gradient<D>(setup_, s, view, out.gradient, out.at_edge, p);
  }
  if (returns) view.drag = drag;
  if (setup_.coupled && !setup_.responds) predict_explicitly<D>(setup_, view, out.gradient, dt, p);
  if (asks_for(setup_.gauges, "fluid", "unexplained_impulse")) count_impulse(setup_, walls_, dt, state_);
  if (setup_.coupled) store_change_of_soil(window.pass > 0 ? passes_.found() : view.velocity, p);

  // Limits of the next window, the second half of the motion, and the water that enters and leaves.
  limit_next_window(view, window, pressure_before, velocity_before);
  ScalarArray came(state_.faces.size(), 0.0);
  advance_columns(setup_, walls_.sight, s, view, out, dt, state_, came);
  push_pistons(0.5 * dt);
  const auto evened = repair(setup_, state_, s, view, dt);
  if (besides.empty()) besides.resize(evened.size(), Vec<D>::Zero());
  for (std::size_t a = 0; a < evened.size(); ++a) besides[a] += evened[a];
  move<D>(setup_, walls_, s, out, gradient, velocity_before, besides, passage.gained, dt, state_);
  if (!state_.bed.empty()) change_volumes(setup_, passage, state_);
  follow_soil(setup_, view, state_);
  give_birth_and_delete(setup_, faces_, view, state_, came);
  if (!state_.bed.empty()) even_volumes(setup_, walls_, state_);
  close_accounts(came, state_.balance);
  serve_inlets(setup_, state_);
  walls_.place(state_.inlets);
  if (setup_.coupled) add_up_exchanged(setup_, exchanged_before, state_);
  share_out(setup_, state_.particles);
  state_.time = end;
  state_.last_interval = dt;
  ++state_.revision;
  return coupling::Outcome::accept();
}

template <int D>
void Fluid<D>::push_pistons(double interval) {
  if (state_.inlets.empty()) return;
  fluid::push_pistons(interval, state_);
  walls_.place(state_.inlets);
}

template <int D>
void Fluid<D>::limit_next_window(const SoilView<D>& view, const coupling::Window& window,
                                 const ScalarArray& pressure_before, const VecArray<D>& velocity_before) {
  const double dt = window.interval;
  // Soil that was dry and cannot yield is stable in windows of any length. Control of the window by the noisy pressure
  // there would only shorten windows.
  if (state_.controlled <= 0.0 && setup_.soil_yields) begin_control(setup_, view, dt, state_);
  if (load_begins(setup_, window.time)) begin_control(setup_, view, 0.0, state_);
  control_interval(setup_, pressure_before, dt, state_);
  limit_by_slowing(setup_, velocity_before, dt, state_);
  limit_by_acceleration(setup_, view, velocity_before, dt, state_);
  limit_scheme(setup_, view, state_);
}

template <int D>
void Fluid<D>::archive(Archive& archive) {
  if (setup_.tiling)
    throw Error(ExitCode::failure, "checkpoints hold the water of all ranks, this is one rank's share");
  archive(state_);
  walls_.place(state_.inlets);
}

template <int D>
void Fluid<D>::take_over(State<D> state) {
  state_ = std::move(state);
  walls_.place(state_.inlets);
  begin_with_share(setup_, state_.particles);
}

template <int D>
double Fluid<D>::volume() const {
  double mass = 0.0;
  for (const double m : state_.particles.mass) mass += m;
  return mass / setup_.density;
}

template <int D>
OutputFrame Fluid<D>::frame() const {
  return frame_of(setup_, state_);
}

template <int D>
std::vector<GaugeReading> Fluid<D>::gauges() const {
  return read_gauges(setup_, faces_, walls_, state_);
}

template <int D>
std::map<std::string, double> Fluid<D>::counters() const {
  return counters_of(setup_, state_);
}

template <int D>
std::vector<Warning> Fluid<D>::warnings() const {
  return warnings_of(state_.counts);
}

template class Fluid<2>;
template class Fluid<3>;

std::unique_ptr<Phase> make_fluid(const Case& scene) {
  if (scene.general.dimension == 3) return std::make_unique<Fluid<3>>(scene);
  return std::make_unique<Fluid<2>>(scene);
}

}  // namespace poretwin::fluid
