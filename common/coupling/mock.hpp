// A phase made of formulas. It is a partner in tests of the coupler and of each solver, and a substitute for a missing
// solver.
#pragma once

#include "common/coupling/phase.hpp"
#include "common/output/recorder.hpp"

#include <chrono>
#include <functional>
#include <map>

namespace poretwin::coupling {

/// Points of a square lattice that fills [lower, lower + extent], half a spacing from its edges. All points are active.
PointSet lattice_points(int dimension, const std::vector<double>& lower, const std::vector<double>& extent,
                        double spacing, double smoothing_per_spacing = 1.3);

/// Value of a component of the named field at the position x [dimension] and time t [s].
using FieldFormula = std::function<double(const std::string& name, int component, const double* x, double t)>;

/// A publication of the standard contract with field values by a formula. Without a formula, soil_fraction is 1 and
/// solid_volume_fraction 0.6.
Publication formula_publication(Role role, double t, PointSet points, const FieldFormula& formula = {});

/// Faults of the mock, and the steps at which they occur. Steps count from 1; 0: never.
struct MockKnobs {
  std::map<std::uint64_t, int> rejections;      ///< step -> number of times in a row that its window is rejected
  std::uint64_t nan_at = 0;                     ///< the values published after this step include a NaN
  std::string nan_field{field::pore_pressure};  ///< field whose value at the last point is then NaN
  std::uint64_t die_at = 0;                     ///< throws MockDeath inside this step, without a message to the coupler
  std::uint64_t diverge_at = 0;                 ///< throws DivergedError inside this step
  std::uint64_t freeze_at = 0;                  ///< calls on_freeze inside this step, then sleeps for freeze_for
  std::chrono::milliseconds freeze_for{0};
  std::function<void()> on_freeze;
  std::chrono::milliseconds per_step{0};  ///< sleeps this long in every step
  std::string digest = "mock";
};

/// Not derived from std::exception, so that no code that reports errors catches it: the effect is that of kill -9.
struct MockDeath {};

class MockPhase : public Phase {
 public:
  using Formula = std::function<Publication(double t)>;
  MockPhase(Role role, int dimension, Formula formula, MockKnobs knobs = {});

  [[nodiscard]] Contract contract() const override;
  [[nodiscard]] Publication publish() const override;
  void initialise(const Inbox& inbox) override;
  Outcome advance(const Window& window, const Inbox& inbox) override;
  void save() override;
  void restore() override;
  void archive(Archive& archive) override { archive(state_); }
  [[nodiscard]] OutputFrame frame() const override;
  [[nodiscard]] std::vector<GaugeReading> gauges() const override;
  [[nodiscard]] std::map<std::string, double> counters() const override;

  // Calls and inputs of the mock, which tests check.
  struct Seen {
    std::vector<Window> windows;  ///< all attempts, including repeated ones
    std::vector<Inbox> inboxes;   ///< of initialise, then of every attempt at a window
    int restores = 0;
  };
  [[nodiscard]] const Seen& seen() const { return seen_; }
  [[nodiscard]] double time() const { return state_.time; }
  void set_contract(Contract contract) { contract_ = std::move(contract); }

 private:
  struct State {
    double time = 0.0;
    std::uint64_t step = 0;
  };
  Role role_;
  Formula formula_;
  MockKnobs knobs_;
  Contract contract_;
  State state_, saved_;
  Seen seen_;
};

/// Stores in memory the records of a driver.
class MemoryRecorder final : public Recorder {
 public:
  struct Readings {
    double time = 0.0;
    std::vector<GaugeReading> readings;
  };
  std::vector<double> frames;  ///< s, time of each frame
  std::vector<Readings> series;
  void frame(const OutputFrame& frame) override { frames.push_back(frame.time); }
  void gauges(double time, const std::vector<GaugeReading>& readings) override { series.push_back({time, readings}); }
  void archive(Archive& archive) override { archive(frames, series); }
  [[nodiscard]] std::vector<std::string> files() const override { return {}; }
};

}  // namespace poretwin::coupling
