// Soil that several ranks share, as a phase.
#pragma once

#include "common/ranks/shared_phase.hpp"
#include "solid_solver/discretisation/ranks.hpp"
#include "solid_solver/phase.hpp"

namespace poretwin::solid {

/// The rank that leads also searches for rest, in the whole soil.
template <int D>
class SharedSolid final : public ranks::SharedPhase<Solid<D>, D> {
 public:
  using ranks::SharedPhase<Solid<D>, D>::SharedPhase;
  void initialise(const coupling::Inbox& inbox) override;
  [[nodiscard]] std::vector<Warning> warnings() const override;

 private:
  void complete_share(State<D>& share) const override;
  void complete_whole(State<D>& whole) const override;
};

}  // namespace poretwin::solid
