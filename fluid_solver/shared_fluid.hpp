// Water that several ranks share, as a phase. Each rank computes its share; the one that leads collects the whole water
// where it is read as a whole: for frames, gauges and checkpoints.
#pragma once

#include "fluid_solver/fluid_phase.hpp"

#include <memory>
#include <optional>

namespace poretwin::fluid {

/// All ranks call the same functions in the same order, except contract(), save(), restore(), may_reject() and
/// warnings(), which concern one rank. Frames, gauges, counters and checkpoints of the rank that leads are those of the
/// whole water; the others have empty ones. A checkpoint is the one that a single rank would write, so that any number
/// of ranks can go on from it.
template <int D>
class SharedFluid final : public Phase {
 public:
  SharedFluid(const Case& scene, std::shared_ptr<Tiling<D>> tiling);
  [[nodiscard]] coupling::Contract contract() const override { return own_.contract(); }
  [[nodiscard]] coupling::Publication publish() const override;
  [[nodiscard]] std::pair<double, std::string> proposal() const override { return own_.proposal(); }
  [[nodiscard]] bool may_reject() const override { return own_.may_reject(); }
  void initialise(const coupling::Inbox& inbox) override {
    collected_ = false;
    own_.initialise(inbox);
  }
  coupling::Outcome advance(const coupling::Window& window, const coupling::Inbox& inbox) override {
    collected_ = false;
    return own_.advance(window, inbox);
  }
  void save() override { own_.save(); }
  void restore() override {
    collected_ = false;
    own_.restore();
  }
  void archive(Archive& archive) override;
  [[nodiscard]] OutputFrame frame() const override;
  [[nodiscard]] std::vector<GaugeReading> gauges() const override;
  [[nodiscard]] std::map<std::string, double> counters() const override;
  [[nodiscard]] std::vector<Warning> warnings() const override { return own_.warnings(); }

 private:
  /// Brings `whole_` up to date.
  void collect() const;
  /// Gives each rank its share of the whole water.
  void share();

  Fluid<D> own_;
  mutable std::optional<Fluid<D>> whole_;  ///< on the rank that leads: all water, as one rank has it
  mutable bool collected_ = false;         ///< whether `whole_` is up to date; the same on every rank
};

}  // namespace poretwin::fluid
