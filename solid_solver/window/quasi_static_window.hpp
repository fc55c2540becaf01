// A long window of coupled soil that does not move by itself, as one step to the equilibrium at its end.
#pragma once

#include "common/coupling/exchange.hpp"
#include "solid_solver/exchange/tracking.hpp"
#include "solid_solver/statics/stiffness.hpp"
#include "solid_solver/window/motion_control.hpp"

#include <memory>

namespace poretwin::solid {

/// Backward Euler: m (u/Dt - v)/Dt = forces(u) + V Z (v_s' - u/Dt) for the displacement u, with the impedance Z of the
/// water and the velocity v_s' that it predicted (tracking.hpp). What it keeps is made anew when it is missing, or
/// holds between the passes through one window only.
template <int D>
class QuasiStaticWindow {
 public:
  QuasiStaticWindow() = default;
  /// lattice [m]: the particles as they were laid.
  explicit QuasiStaticWindow(VecArray<D> lattice) : lattice_(std::move(lattice)) {}

  struct Answer {
    coupling::Outcome outcome;
    MotionHint hint;  ///< where the window is rejected: it has no equilibrium, or inertia matters
  };
  Answer advance(const Setup<D>& setup, const coupling::Window& window, const WaterInput<D>& water,
                 const Tracking<D>& tracking, State<D>& state);

  /// m/s, mean velocity that the last pass through the present window found.
  [[nodiscard]] const VecArray<D>& found() const { return found_; }
  /// Publication::unsettled of the last window.
  [[nodiscard]] double unsettled() const { return unsettled_; }
  void begin_window() { unsettled_ = 0.0; }

 private:
  /// The soil's stiffness with the resistance that a window adds [N/m]: the last one, where it serves.
  const Stiffness<D>& stiffness_with(const Setup<D>& setup, const ScalarArray& resistance, State<D>& state);
  /// How far the motion found departs from the predicted one, where that is noticeable.
  void compare_with_prediction(const Setup<D>& setup, double interval, const Tracking<D>& tracking, double reference,
                               State<D>& state);

  /// The same with water that is a field, which foresees how the soil's volume follows its pressure.
  void compare_with_field(const Setup<D>& setup, const coupling::Window& window, const WaterInput<D>& water,
                          const ScalarArray& volume, double reference, const State<D>& state);

  VecArray<D> lattice_, found_;
  ScalarArray found_strain_, found_pressure_;  ///< 1, Pa: of the last pass through the present window, with a field
  double unsettled_ = 0.0;
  std::unique_ptr<Stiffness<D>> stiffness_;
};

}  // namespace poretwin::solid
