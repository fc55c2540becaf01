// Water that several ranks share, as a phase.
#pragma once

#include "common/ranks/shared_phase.hpp"
#include "fluid_solver/discretisation/ranks.hpp"
#include "fluid_solver/fluid_phase.hpp"

namespace poretwin::fluid {

/// Beside soil that moves, the rank that leads gives and takes the fields of the whole water. What it is sent by the
/// other phase it passes on within the calls that take it; the other ranks are called with an empty inbox.
template <int D>
class SharedFluid final : public ranks::SharedPhase<Fluid<D>, D> {
 public:
  using ranks::SharedPhase<Fluid<D>, D>::SharedPhase;
  void initialise(const coupling::Inbox& inbox) override {
    this->collected_ = false;
    this->own_.initialise(share_of(inbox));
  }
  coupling::Outcome advance(const coupling::Window& window, const coupling::Inbox& inbox) override {
    return ranks::SharedPhase<Fluid<D>, D>::advance(window, share_of(inbox));
  }
  [[nodiscard]] std::vector<Warning> warnings() const override { return this->own_.warnings(); }

 private:
  /// The part of the leading rank's inbox that belongs to the particles of this rank. All ranks call this.
  [[nodiscard]] coupling::Inbox share_of(const coupling::Inbox& inbox) const;
};

}  // namespace poretwin::fluid
