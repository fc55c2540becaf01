// The fluid phase behind the Phase interface: one window at a time, in particles that carry water.
#pragma once

#include "common/coupling/phase.hpp"
#include "fluid_solver/discretisation/cloud.hpp"
#include "fluid_solver/exchange/passes.hpp"
#include "fluid_solver/pressure/window.hpp"
#include "fluid_solver/state.hpp"

#include <functional>

namespace poretwin::fluid {

template <int D>
class Fluid final : public Phase {
 public:
  explicit Fluid(const Case& scene) : Fluid(scene, make_water_boundaries(scene)) {}
  /// boundaries: of the case's water faces, whatever their keys say.
  Fluid(const Case& scene, WaterBoundaries boundaries);

  [[nodiscard]] coupling::Contract contract() const override;
  [[nodiscard]] coupling::Publication publish() const override;
  [[nodiscard]] std::pair<double, std::string> proposal() const override { return time_limit(); }
  [[nodiscard]] bool may_reject() const override { return false; }
  void initialise(const coupling::Inbox& inbox) override;
  coupling::Outcome advance(const coupling::Window& window, const coupling::Inbox& inbox) override;
  void save() override { saved_ = state_; }
  void restore() override {
    state_ = saved_;
    place_pistons();
  }
  void archive(Archive& archive) override {
    archive(state_, first_interval_);
    place_pistons();
  }
  [[nodiscard]] OutputFrame frame() const override;
  [[nodiscard]] std::vector<GaugeReading> gauges() const override;
  [[nodiscard]] std::map<std::string, double> counters() const override;
  [[nodiscard]] std::vector<Warning> warnings() const override;

  [[nodiscard]] const State<D>& state() const { return state_; }

 private:
  Vec<D> initial_velocity(const Vec<D>& x) const;
  /// Solves for the pressure of water at rest in soil at rest; removes the velocities from the view.
  void solve_hydrostatic(SoilView<D>& view);
  /// Stores the force of pressure and drag on the soil [N/m3], which the soil's unbalanced force will contain.
  void store_coupling_force(const SoilView<D>& view, std::span<const Vec<D>> gradient, double interval);
  WindowSolution<D> solve(const Stencil<D>& s, SoilView<D>& view, const WindowProblem<D>& in);
  /// Finds the surface, whose thickness of rows enters `rows` by a share (find_surface).
  void mark_surface(Stencil<D>& s, std::span<double> rows, double share);
  SoilView<D> soil(const coupling::Inbox& inbox, const SeepageRegime& regime) const;
  Stencil<D> stencil() const;
  /// Velocity after what is explicit: shear stress of the water outside soil, and the central force. None: as it is.
  VecArray<D> forced_velocity(const Stencil<D>& s, const SoilView<D>& soil, std::span<const Mat<D>> velocity_gradient,
                              double interval) const;
  /// Volume each particle must give off [1/s]: packing repair, the window's curvature in time and the soil's
  /// deformation beyond the prediction.
  bool is_drag_dominated(const SoilView<D>& soil, std::size_t a) const;
  bool all_quasi_static(const SoilView<D>& soil) const;
  ScalarArray unseen_strain_rate(const Stencil<D>& s, const SoilView<D>& soil, double interval);
  ScalarArray deferred_divergence(const Stencil<D>& s, const SoilView<D>& soil, double interval) const;
  [[nodiscard]] bool open_water() const;
  [[nodiscard]] double packing_error(const Stencil<D>& s, std::size_t a, double full) const;
  ScalarArray volume_source(const Stencil<D>& s, const SoilView<D>& soil, std::span<const Mat<D>> velocity_gradient,
                            double interval);
  /// Displacements that repair the packing where no pressure does [m].
  VecArray<D> repair(const Stencil<D>& s, const SoilView<D>& soil, double interval) const;
  ScalarArray moved() const;
  double free_repair_time(double spacing) const;
  double wave_interval() const;
  [[nodiscard]] double quasi_static_speed() const;
  double central_interval() const;
  double free_interval() const;
  double viscous_interval() const;
  double repair_time(std::size_t a, const SoilView<D>& soil, double interval) const;
  double look_ahead(double interval) const;
  void drift(double interval);
  void displace(std::size_t a, const Vec<D>& d, bool stop_at_walls);
  void move(const Stencil<D>& s, const WindowSolution<D>& solution, std::span<const Mat<D>> velocity_gradient,
            std::span<const Vec<D>> velocity_before, std::span<const Vec<D>> repair, double interval);
  void advance_boundaries(double time, double interval);
  /// Level of the still water behind a face [m]; none: there is no such water.
  [[nodiscard]] std::optional<double> level_behind(int face, double time) const;
  /// Whether real water comes through a face, by a piston.
  [[nodiscard]] bool is_opening(int face) const;
  [[nodiscard]] AllowedChange allowed_change(double longest) const;
  void place_pistons();
  void push_pistons(double interval);
  void set_inlets(double time, double interval);
  void serve_inlets();
  [[nodiscard]] double viscosity() const;
  ScalarArray passed() const;
  /// Of the walls on water and soil, by the water's pressure [N, 2D: N/m].
  [[nodiscard]] Vec<D> wall_force() const;
  void advance_columns(const Stencil<D>& s, const SoilView<D>& soil, const WindowSolution<D>& solution,
                       double interval);
  [[nodiscard]] bool is_quasi_static(const FaceColumn<D>& c) const;
  [[nodiscard]] bool flow_is_solved_for(const FaceColumn<D>& c) const;
  [[nodiscard]] double missing_water() const;
  void count(FaceColumn<D>& c, double volume);
  void close_accounts();
  void wet_dry_ground(FaceColumn<D>& c, double interval) const;
  double driving_pressure(const FaceColumn<D>& c) const;
  InfiltrationSpeed infiltration_speed(const FaceColumn<D>& c) const;
  void limit_surface(Stencil<D>& s) const;
  /// Faces of a prescribed head step back with the soil's surface.
  void follow_soil(const SoilView<D>& soil);
  [[nodiscard]] std::vector<StillWater<D>> reservoir() const;
  [[nodiscard]] bool is_free(std::size_t a) const;
  [[nodiscard]] int taker(const Vec<D>& x) const;
  void give_birth_and_delete(const SoilView<D>& soil);
  void begin_control(const SoilView<D>& view, double interval);
  void control_interval(const ScalarArray& before, double interval);
  void limit_by_acceleration(const SoilView<D>& view, const VecArray<D>& velocity_before, double interval);
  void limit_by_slowing(const VecArray<D>& velocity_before, double interval);
  void limit_scheme(const SoilView<D>& view);
  void limit_by_loads(double now, const std::function<void(double, const std::string&)>& apply) const;
  [[nodiscard]] bool load_begins(double time) const;
  void flow_together(const Stencil<D>& s);
  void store_surface_gradient(const Stencil<D>& s, std::span<const Vec<D>> gradient);
  void apply_returned_impulse(const Stencil<D>& s, const SoilView<D>& view);
  void check_room(double time) const;
  void check_finite(const WindowSolution<D>& solution, double time) const;
  std::pair<double, std::string> time_limit() const;
  [[nodiscard]] bool responds() const;
  /// Whether the soil crosses each window at the same time.
  [[nodiscard]] bool computes_beside() const { return scene_.coupling.scheme == CouplingCase::Scheme::parallel; }
  WindowProblem<D> problem(double interval) const;

  Case scene_;
  Ground<D> ground_;
  WaterBoundaries boundaries_;
  double dx_ = 0.0, density_ = 1000.0, first_interval_ = 0.0;
  double gravity_or_standard_ = 9.81;  ///< m/s2
  /// Weight of water [N/m3] along bounded axes, where it has a potential, and gravity along periodic ones [m/s2].
  Vec<D> weight_ = Vec<D>::Zero(), periodic_gravity_ = Vec<D>::Zero(), origin_ = Vec<D>::Zero();
  std::vector<sph::ImagePlane<D>> planes_;
  sph::Sight<D> sight_;
  std::vector<Joint<D>> joints_;
  bool one_soil_ = true;                        ///< of one conductivity
  ScalarArray came_;                            ///< [faces] through columns in this window so far, m^D
  Vec<D> lower_, upper_;                        ///< beyond, water is lost [m]
  std::uint32_t no_slip_ = 0, fixed_soil_ = 0;  ///< boundary bits
  bool faces_follow_ = false;    ///< all water is in soil that can leave its place: faces stay on its surface
  VecArray<D> feet_;             ///< of the columns, where the case has them
  std::vector<int> reservoirs_;  ///< faces of soil behind which still water stands, in no particles
  State<D> state_, saved_;
  Passes<D> passes_;  ///< through the present window
};

}  // namespace poretwin::fluid
