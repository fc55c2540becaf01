// Both solvers on one scene, joined by the coupler in one process.
#pragma once

#include "fluid_solver/fluid_phase.hpp"
#include "solid_solver/solid.hpp"
#include "tests/coupling/coupled_run.hpp"

namespace poretwin::fluid::test {

struct BothSolvers {
  explicit BothSolvers(const Case& scene) : fluid(scene), soil(solid::make_solid(scene)) {
    run.broker.case_digest = scene.digest();
    run.settings = {scene.general.end_time, std::nullopt, 0.0, 0.0};
  }
  /// Runs to the scene's end, with the settings that `run` has by then; expects that all three end well.
  void run_to_end() {
    run.run(&fluid, soil.get());
    run.expect_success();
  }

  Fluid<2> fluid;
  std::unique_ptr<Phase> soil;
  coupling::CoupledRun run;
};

}  // namespace poretwin::fluid::test
