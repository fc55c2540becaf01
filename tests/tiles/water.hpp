// Water that several ranks share, beside the whole water, which every rank also computes alone.
#pragma once

#include "fluid_solver/fluid_phase.hpp"
#include "tests/fluid/scenes.hpp"
#include "tests/tiles/shared.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace poretwin::fluid::test {

using tiles::across;
using tiles::all_ranks;
using tiles::MpiTiling;

inline constexpr double dx = 0.02;

inline Case still() {
  Case scene;
  scene.solid.model = SolidCase::Model::rigid;
  scene.fluid.particle_spacing = dx;
  scene.fluid.pressure_tolerance = 1e-14;
  scene.fluid.jitter = 0.1;  // no sums whose order does not matter
  return scene;
}

/// Largest differences between particles and those of the whole water: of position over the spacing, of velocity and
/// pressure over the largest value of the whole. Faces: of the places of columns and pistons over the spacing, and of
/// the volumes that have passed them over a particle's.
struct Errors {
  double position = 0.0, velocity = 0.0, pressure = 0.0, faces = 0.0;
  [[nodiscard]] double largest() const { return std::max({position, velocity, pressure, faces}); }
  void print(const char* who, double time) const {
    if (all_ranks().rank() == 0)
      std::printf("%d ranks, t = %.3g s: %s: position %.1e, velocity %.1e, pressure %.1e, faces %.1e\n",
                  all_ranks().size(), time, who, position, velocity, pressure, faces);
  }
};

/// Difference between the faces' states on this rank and those of the whole, as Errors::faces.
template <int D>
double face_differences(const State<D>& whole, const State<D>& part) {
  double most = 0.0;
  const auto differ = [&](double a, double b, double over) { most = std::max(most, std::abs(a - b) / over); };
  EXPECT_EQ(part.columns.size(), whole.columns.size());
  for (std::size_t i = 0; i < whole.columns.size(); ++i) {
    const auto &a = part.columns[i], &b = whole.columns[i];
    EXPECT_EQ(a.wet, b.wet) << "column " << i;
    differ(a.offset, b.offset, b.spacing);
    differ(a.passed, b.passed, b.volume);
  }
  for (std::size_t i = 0; i < whole.inlets.size(); ++i) {
    const auto &a = part.inlets[i], &b = whole.inlets[i];
    const double spacing = b.sill ? b.width : b.spacing;
    differ(a.piston, b.piston, spacing);
    differ(a.level, b.level, spacing);
    differ(a.net, b.net, b.width * spacing);
  }
  EXPECT_EQ(part.full, whole.full);
  return most;
}

/// id_of(k): which particle of the whole water particle k is. Masses must be equal to the bit.
template <int D, class IdOf>
Errors differences(const Particles<D>& whole, const Particles<D>& part, double spacing, const IdOf& id_of) {
  Errors error;
  double fastest = 0.0, most_pressed = 0.0;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    fastest = std::max(fastest, whole.velocity[i].norm());
    most_pressed = std::max(most_pressed, std::abs(whole.pressure[i]));
  }
  const auto differ = [](double& found, double by, double over) {
    if (!(by <= found * over)) found = by / over;
  };
  for (std::size_t k = 0; k < part.size(); ++k) {
    const std::size_t i = id_of(k);
    if (i >= whole.size()) {
      ADD_FAILURE() << "the whole has no particle " << i;
      continue;
    }
    EXPECT_EQ(part.mass[k], whole.mass[i]) << "particle " << i;
    EXPECT_EQ(part.surface[k], whole.surface[i]) << "particle " << i;
    EXPECT_EQ(part.closed_body[k] > 0, whole.closed_body[i] > 0) << "particle " << i;
    EXPECT_NEAR(part.void_volume[k], whole.void_volume[i], 1e-6 * whole.volume[i]) << "particle " << i;
    differ(error.position, (part.position[k] - whole.position[i]).norm(), spacing);
    differ(error.velocity, (part.velocity[k] - whole.velocity[i]).norm(), fastest);
    differ(error.pressure, std::abs(part.pressure[k] - whole.pressure[i]), most_pressed);
  }
  return error;
}

/// Kernels and the matrix are stored in single precision. Where positions differ by rounding, some of these round the
/// other way, and a difference of 1e-16 becomes one of 1e-8. So does that between one rank and the same water under a
/// gravity that differs by 1e-14 (`twin`).
inline constexpr double scatter = 1e-6;

template <int D>
struct Shared : tiles::SharedAndWhole<Fluid<D>, D> {
  using Base = tiles::SharedAndWhole<Fluid<D>, D>;
  using Base::Base, Base::part, Base::whole, Base::step;
  /// Advances both by the windows that the whole proposes, of at most `longest` [s].
  void run(std::size_t windows, double longest = HUGE_VAL) {
    for (std::size_t k = 0; k < windows; ++k, ++step) {
      const double dt = std::min(whole.proposal().first, longest), time = whole.state().time;
      EXPECT_NEAR(std::min(part.proposal().first, longest), dt, 1e-6 * dt);
      whole.advance({step, time, dt}, this->inbox(whole));
      part.advance({step, time, dt}, this->inbox(part));
    }
  }
  /// Differences on all ranks. Expects that every particle is on one rank.
  Errors errors() const {
    const Particles<D>& own = part.state().particles;
    // Ids ascend in the order of the whole's particles, of which some have been deleted.
    auto ids = all_ranks().gather_all(own.share.ids);
    std::ranges::sort(ids);
    Errors error = differences<D>(whole.state().particles, own, part.setup().spacing, [&](std::size_t k) {
      return static_cast<std::size_t>(std::ranges::lower_bound(ids, own.share.ids[k]) - ids.begin());
    });
    error.faces = face_differences<D>(whole.state(), part.state());
    this->expect_each_particle_on_one_rank();
    const auto& domain = part.setup().domain;
    for (double* one : {&error.position, &error.velocity, &error.pressure, &error.faces}) *one = domain.max(*one);
    error.print("shared", part.state().time);
    const Counts &one = whole.state().counts, &all = part.state().counts;
    if (all_ranks().rank() == 0)
      std::printf("iterations %g and %g, cycles of multigrid %g and %g, unconverged %g and %g\n",
                  one.pressure_iterations, all.pressure_iterations, one.multigrid_cycles, all.multigrid_cycles,
                  one.unconverged, all.unconverged);
    EXPECT_EQ(all.unconverged, one.unconverged);
    for (const auto count : {&Counts::born, &Counts::deleted, &Counts::lost}) EXPECT_EQ(all.*count, one.*count);
    return error;
  }
  /// `first` windows without a difference beyond rounding, and as many more as make twenty.
  void expect_as_whole(double longest, std::size_t first = 10) {
    run(first, longest);
    EXPECT_LT(errors().largest(), 1e-9);
    run(20 - first, longest);
    EXPECT_LT(errors().largest(), scatter);
  }
};

}  // namespace poretwin::fluid::test
