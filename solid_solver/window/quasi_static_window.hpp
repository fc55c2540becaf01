// A long window of coupled soil that does not move by itself, computed as one step to the equilibrium at its end.
#pragma once

#include "common/coupling/exchange.hpp"
#include "solid_solver/exchange/tracking.hpp"
#include "solid_solver/statics/stiffness.hpp"
#include "solid_solver/window/motion_control.hpp"

#include <memory>

namespace poretwin::solid {

/// Backward Euler: m (u/Dt - v)/Dt = forces(u) + V Z (v_s' - u/Dt) for the displacement u in the window Dt, with the
/// water's impedance Z and the predicted velocity v_s' (tracking.hpp). No member belongs to the saved state: the
/// stiffness is built again where missing, and the other members are valid only between passes through one window.
template <int D>
class QuasiStaticWindow {
 public:
  QuasiStaticWindow() = default;
  /// lattice [m]: initial positions of the particles.
  explicit QuasiStaticWindow(VecArray<D> lattice) : lattice_(std::move(lattice)) {}

  struct Answer {
    coupling::Outcome outcome;
    MotionHint hint;  ///< set where the window is rejected: it has no equilibrium, or inertia matters
  };
  Answer advance(const Setup<D>& setup, const coupling::Window& window, const WaterInput<D>& water,
                 const Tracking<D>& tracking, State<D>& state);

  /// Mean velocity [m/s] of each particle that the last pass through the present window found.
  [[nodiscard]] const VecArray<D>& found() const { return found_; }
  /// Publication::unsettled of the last window: force that the departure from the prediction requires, over the weight.
  [[nodiscard]] double unsettled() const { return unsettled_; }
  void begin_window() { unsettled_ = 0.0; }

 private:
  /// Stiffness of the soil, including the resistance of each particle that a window adds [N/m]. If the last stiffness
  /// is close enough, it is used again.
  const Stiffness<D>& stiffness_with(const Setup<D>& setup, const ScalarArray& resistance, State<D>& state);
  /// Initial positions [m] of the particles that free water has not carried off.
  [[nodiscard]] VecArray<D> lattice_of(const Eroded& eroded) const;
  /// Sets unsettled_ to the departure of the computed motion from the predicted one, if the departure is noticeable.
  void compare_with_prediction(const Setup<D>& setup, double interval, const Tracking<D>& tracking, double reference,
                               State<D>& state);

  /// Sets unsettled_ in a window with water as a field. The field predicts how the soil's volume changes with its
  /// pressure.
  void compare_with_field(const Setup<D>& setup, const coupling::Window& window, const WaterInput<D>& water,
                          const ScalarArray& volume, double reference, const State<D>& state);

  VecArray<D> lattice_, found_;
  ScalarArray found_strain_, found_pressure_;  ///< volumetric strain [1] and pressure [Pa] of the last pass through the
                                               ///< present window, with a field
  double unsettled_ = 0.0;
  std::unique_ptr<Stiffness<D>> stiffness_;
};

}  // namespace poretwin::solid
