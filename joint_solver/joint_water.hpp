// Free water as particles and the water in rigid soil as a field, in one phase in the fluid's role. Each is a solver of
// its own, which knows nothing of the other; this one carries pressures to the ground and volumes both ways.
//
// The ground steps once for several windows of the free water, by the mean of its pressure over them. What the ground
// takes and gives becomes a film on the surface, which the particles take over during the next step of the ground.
// Water is therefore conserved to rounding: particles + film + field. The film is what passes in one step of the
// ground.
#pragma once

#include "common/case/case.hpp"
#include "common/coupling/phase.hpp"
#include "fluid_solver/fluid_phase.hpp"
#include "pore_solver/pore_phase.hpp"

#include <memory>

namespace poretwin::joint {

class JointWater final : public Phase {
 public:
  explicit JointWater(const Case& scene);

  [[nodiscard]] coupling::Contract contract() const override;
  [[nodiscard]] coupling::Publication publish() const override;
  [[nodiscard]] std::pair<double, std::string> proposal() const override;
  [[nodiscard]] bool may_reject() const override { return false; }
  void initialise(const coupling::Inbox& inbox) override;
  coupling::Outcome advance(const coupling::Window& window, const coupling::Inbox& inbox) override;
  void save() override {
    free_.save();
    ground_.save();
    saved_ = state_;
  }
  void restore() override {
    free_.restore();
    ground_.restore();
    state_ = saved_;
  }
  void archive(Archive& archive) override { archive(free_, ground_, state_); }
  [[nodiscard]] OutputFrame frame() const override;
  [[nodiscard]] std::vector<GaugeReading> gauges() const override;
  [[nodiscard]] std::map<std::string, double> counters() const override;
  [[nodiscard]] std::vector<Warning> warnings() const override { return free_.warnings(); }

  [[nodiscard]] const fluid::Fluid<2>& free_water() const { return free_; }
  [[nodiscard]] const pore::PoreWater& ground() const { return ground_; }
  /// Volume of water on the surface that is in neither part [m2]; negative where the ground has taken more than the
  /// particles have given.
  [[nodiscard]] double film() const;
  /// Volume of all water [m2].
  [[nodiscard]] double stored() const { return free_.volume() + film() + ground_.stored(); }

 private:
  struct State {
    double since = 0.0;    ///< s, length of the windows since the last step of the ground
    double next = 0.0;     ///< s, wanted length of the next step of the ground
    double initial = 0.0;  ///< m2, water at time zero
  };
  /// Advances the ground to a time [s], and chooses the length of its next step.
  void step_ground(double time);
  /// Whether a frame or a reading may be due at a time [s].
  [[nodiscard]] bool is_instant_of_output(double time) const;
  void read_both(const Gauge& gauge, std::vector<GaugeReading>& readings) const;

  Case scene_;
  fluid::Fluid<2> free_;
  pore::PoreWater ground_;
  std::vector<pore::PoreWater::Opening> openings_;
  State state_, saved_;
};

std::unique_ptr<Phase> make_joint_water(const Case& scene);

}  // namespace poretwin::joint
