// The solid as a phase of the mixture: windows, exchange fields, output.
#pragma once

#include "common/coupling/phase.hpp"
#include "common/media/seepage.hpp"
#include "solid_solver/exchange/water_answer.hpp"
#include "solid_solver/setup.hpp"
#include "solid_solver/statics/equilibrium.hpp"

namespace poretwin::solid {

template <int D>
class Solid final : public Phase {
 public:
  explicit Solid(const Case& scene);
  [[nodiscard]] coupling::Contract contract() const override;
  [[nodiscard]] coupling::Publication publish() const override;
  [[nodiscard]] std::pair<double, std::string> proposal() const override;
  /// Only searches for equilibrium, of coupled soil, can fail.
  [[nodiscard]] bool may_reject() const override { return scene_.coupled(); }
  void initialise(const coupling::Inbox& inbox) override;
  coupling::Outcome advance(const coupling::Window& window, const coupling::Inbox& inbox) override;
  void save() override { saved_ = state_; }
  void restore() override {
    state_ = saved_;
    position_cache_ = {};
  }
  void archive(Archive& archive) override {
    archive(state_, rest_);
    position_cache_ = {};
  }
  [[nodiscard]] OutputFrame frame() const override;
  [[nodiscard]] std::vector<GaugeReading> gauges() const override;
  [[nodiscard]] std::map<std::string, double> counters() const override;
  [[nodiscard]] std::vector<Warning> warnings() const override;

  /// For tests and tools that look inside.
  [[nodiscard]] const State<D>& state() const { return state_; }
  [[nodiscard]] const Setup<D>& setup() const { return setup_; }

 private:
  /// What depends on the positions alone: evaluated on demand, once for each revision of the positions.
  struct PositionCache {
    std::uint64_t revision = 0;
    ScalarArray coverage;                  ///< [n] own_coverage()
    std::vector<porous::Seepage> seepage;  ///< [n] the law at the void fraction
  };
  PositionCache& position_cache() const;
  const ScalarArray& covered_by_soil() const;
  const std::vector<porous::Seepage>& seepage() const;
  /// Coverage and pressure [Pa] of the water at the soil's points: from the partner, or from the case for soil alone.
  OrZero<double> take_pressure(const coupling::Inbox& inbox, double time);
  [[nodiscard]] bool repeats_windows() const {
    return scene_.predicts() && scene_.coupling.scheme == CouplingCase::Scheme::iterated;
  }
  [[nodiscard]] bool water_is_prescribed() const { return !scene_.pore_pressures.empty(); }
  /// Force [N] of the pore water on particle i: buoyancy -n_s grad p; of water that the case prescribes also the drag.
  [[nodiscard]] Vec<D> water_force(std::size_t i, const Vec<D>& pressure_gradient) const;
  /// Buoyancy and drag [N] of water that flows without inertia: by Eq. (27) the drag is then n (rho_w g - grad p),
  /// whatever its law, and both are n rho_w g - grad p per volume.
  [[nodiscard]] Vec<D> steady_water_force(std::size_t i, const Vec<D>& pressure_gradient) const;
  /// The same with the drag, an impulse [N s] handed over in a window [s].
  [[nodiscard]] Vec<D> water_force(std::size_t i, const Vec<D>& pressure_gradient, const OrZero<double>& impulse,
                                   double interval) const;
  /// Stores the force of pressure and drag at the end of a window, which the published unbalanced force contains.
  void store_water_force(const OrZero<Vec<D>>& gradient, const OrZero<double>& impulse, double interval);
  [[nodiscard]] OrZero<Vec<D>> gradient_of(const OrZero<double>& pressure, double time) const;
  /// Reference position of a particle that is published to the water [m].
  [[nodiscard]] Vec<D> reference_position(std::size_t particle) const;
  /// Below a loaded face: the load is carried by stress and pressure alike, that of the water beyond it left out.
  void share_load(const LoadedPatch<D>& patch, const OrZero<double>& pressure, double time,
                  VecArray<D>& gradient) const;
  [[nodiscard]] double next_load_after(double time) const;
  [[nodiscard]] std::size_t loads_begun(double time) const;
  /// Passes the window asleep, if the soil is and nothing disturbs it.
  bool sleeps_on(Drive<D>& drive, const OrZero<Vec<D>>& gradient, const OrZero<double>& impulse,
                 const coupling::Window& window);
  /// At the end of a window that was computed.
  void fall_asleep_if_quiet(const Drive<D>& drive, double reference);

  /// A long window of soil that does not move by itself, as one step of backward Euler to the equilibrium at its end:
  /// m (u/Dt - v)/Dt = forces(u) + V Z (v_s' - u/Dt) for the displacement u. Rejects the window where there is none.
  coupling::Outcome advance_at_rest(const coupling::Window& window, const OrZero<Vec<D>>& gradient,
                                    const OrZero<double>& impulse, const Drive<D>& tracking,
                                    std::span<const double> goes_along, std::span<const WaterAnswer> answers,
                                    double dissipated);
  /// Windows up to this follow the waves in the soil; in longer ones it is led from equilibrium to equilibrium [s].
  [[nodiscard]] double followed_window() const;
  /// Whether the soil's motion, or what it changed by since `before` (none: all of it) [m/s], holds a noticeable part
  /// of the energy dissipated meanwhile [J], and more than creep at a speed [m/s] would.
  [[nodiscard]] bool inertia_matters(std::span<const Vec<D>> before, double dissipated, double slow) const;
  /// Work of the stress on the plastic shear since `plastic_before` [J].
  [[nodiscard]] double plastic_work(std::span<const double> plastic_before) const;
  /// How far the soil's motion in a window is drained: wholly in the time of consolidation over its height,
  /// H^2 gamma_w / (k M), not at all in a fifth of it: there its dilation sets the next window's pressure and that its
  /// motion, and to take it as going on, or to pay for it at once, overdoes it. Between them by degrees: soil that
  /// creeps through a sudden change of that falls.
  [[nodiscard]] double drained_fraction(double interval) const;
  /// Stores the plastic shear ratio of the window, times `factor`; `plastic_before`: plastic strain at its start.
  void store_plastic_shear_ratio(std::span<const double> plastic_before, double interval, double factor);
  /// Forces on the particles [N] over their weight, rms over all but a local part of the soil that holds water.
  [[nodiscard]] double over_weight(const Drive<D>& tracking, std::span<const double> force, double reference) const;
  /// What holds the soil to the predicted motion after a window's first pass and is no inertia of the water: neither
  /// phase bears it. Over the weight.
  [[nodiscard]] double unborne(const Drive<D>& tracking, std::span<const double> goes_along, double reference) const;
  /// How far the soil's motion in a window that is repeated departs from the predicted one: the force that the pressure
  /// would answer with, less where it drains, over the weight.
  [[nodiscard]] double unsettled(double interval, const Drive<D>& tracking, std::span<const WaterAnswer> answers,
                                 double reference);
  /// Strain of every particle's volume in a window of the predicted motion.
  [[nodiscard]] ScalarArray predicted_strain(double interval, const Drive<D>& tracking);
  /// Rate at which these velocities of the particles [m/s] change their volumes [1/s].
  [[nodiscard]] ScalarArray dilation_of(VecArray<D> velocity);
  /// The soil's stiffness with the resistance that a window adds [N/m]: the last one, where it serves.
  const Stiffness<D>& stiffness_with(const ScalarArray& resistance);

  Case scene_;
  Setup<D> setup_;
  State<D> state_, saved_;
  RestReport rest_;
  VecArray<D> found_;       ///< m/s, mean velocity that the last pass through the present window found
  double unsettled_ = 0.0;  ///< of the last window: Publication::unsettled
  VecArray<D> lattice_;     ///< m, the particles of coupled soil as they were laid
  std::unique_ptr<Stiffness<D>> stiffness_;
  mutable PositionCache position_cache_;
};

}  // namespace poretwin::solid
