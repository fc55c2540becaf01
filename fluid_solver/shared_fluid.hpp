// Water that several ranks share, as a phase.
#pragma once

#include "common/ranks/shared_phase.hpp"
#include "fluid_solver/discretisation/ranks.hpp"
#include "fluid_solver/fluid_phase.hpp"

namespace poretwin::fluid {

template <int D>
class SharedFluid final : public ranks::SharedPhase<Fluid<D>, D> {
 public:
  /// Throws CaseError where the water flows in soil that moves: each rank can compute its part, but the other phase's
  /// fields come for the whole water.
  SharedFluid(const Case& scene, std::shared_ptr<Tiling<D>> tiling);
  [[nodiscard]] coupling::Publication publish() const override;
  void initialise(const coupling::Inbox& inbox) override {
    this->collected_ = false;
    this->own_.initialise(inbox);
  }
  [[nodiscard]] std::vector<Warning> warnings() const override { return this->own_.warnings(); }
};

}  // namespace poretwin::fluid
