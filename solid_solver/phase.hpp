// The solid as a phase of the mixture: the sequence of computations in one window.
#pragma once

#include "common/coupling/phase.hpp"
#include "solid_solver/statics/rest.hpp"
#include "solid_solver/statics/safety.hpp"
#include "solid_solver/window/quasi_static_window.hpp"

namespace poretwin::solid {

template <int D>
class Solid final : public Phase {
 public:
  /// domain: the part of the soil that this process computes; the case contains only this part's soils.
  explicit Solid(const Case& scene, const Domain& domain = {});
  /// One of several ranks that share the soil of the case. Frames, gauges and counters are of this rank's particles.
  Solid(const Case& scene, std::shared_ptr<Tiling<D>> tiling);
  [[nodiscard]] coupling::Contract contract() const override;
  [[nodiscard]] coupling::Publication publish() const override;
  [[nodiscard]] std::pair<double, std::string> proposal() const override;
  /// Windows can be rejected only if the soil is coupled: without a fluid, no equilibria are searched for in windows.
  [[nodiscard]] bool may_reject() const override { return setup_.coupling.coupled; }
  void initialise(const coupling::Inbox& inbox) override;
  coupling::Outcome advance(const coupling::Window& window, const coupling::Inbox& inbox) override;
  void save() override;
  void restore() override;
  void archive(Archive& archive) override;
  [[nodiscard]] OutputFrame frame() const override;
  [[nodiscard]] std::vector<GaugeReading> gauges() const override;
  [[nodiscard]] std::map<std::string, double> counters() const override;
  [[nodiscard]] std::vector<Warning> warnings() const override;

  /// For tests and tools that inspect the state.
  [[nodiscard]] const State<D>& state() const { return state_; }
  /// For ranks that share the soil (shared_solid.hpp): this state takes the place of the present one.
  void take_over(State<D> state);
  [[nodiscard]] const RestReport& rest() const { return rest_; }
  [[nodiscard]] const Setup<D>& setup() const { return setup_; }

 private:
  /// Computes the soil's motion in a window.
  coupling::Outcome cross(const coupling::Window& window, const WaterInput<D>& water);

  Solid(const Case& scene, std::pair<Setup<D>, Particles<D>> made);

  std::string digest_;  ///< of the case
  Setup<D> setup_;
  State<D> state_, saved_;
  RestReport rest_;
  QuasiStaticWindow<D> quasi_static_;
  MotionHint hint_;              ///< from the windows rejected since the state was saved
  mutable SafetyRecord safety_;  ///< of the last factor of safety that was evaluated
  mutable PositionCache<D> cache_;
};

}  // namespace poretwin::solid
