// Iterated windows: two masses that move as one, where plain iteration diverges, compared with the monolithic solution.
#include "coupler/acceleration.hpp"
#include "tests/child.hpp"
#include "tests/coupling/coupled_run.hpp"

#include <gtest/gtest.h>
#include <Eigen/LU>

#include <cmath>
#include <tuple>

namespace poretwin::coupling {
namespace {

using Size = std::size_t;

/// Number of passes of x = a + B x until the residual is below 1e-10 of the first one; 0: never.
int passes(AccelerationKind kind, const Eigen::MatrixXd& b) {
  const Eigen::VectorXd a = Eigen::VectorXd::LinSpaced(b.rows(), 1.0, 2.0);
  const auto acceleration = make_acceleration(kind);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(b.rows());
  double first = 0.0;
  for (int k = 1; k <= 200; ++k) {
    const Eigen::VectorXd result = a + b * x;
    const double residual = (result - x).norm();
    if (k == 1) first = residual;
    if (residual <= 1e-10 * first) {
      const Eigen::VectorXd exact = (Eigen::MatrixXd::Identity(b.rows(), b.rows()) - b).lu().solve(a);
      EXPECT_LT((x - exact).norm(), 1e-8 * exact.norm());
      return k;
    }
    if (!(residual < 1e12 * first)) return 0;
    x = acceleration->next(x, result);
  }
  return 0;
}

TEST(Acceleration, OneUnknownIsSolvedBySecants) {
  Eigen::MatrixXd b(1, 1);
  b << -10.0;  // ten times as heavy as the mass that moves it
  EXPECT_EQ(passes(AccelerationKind::none, b), 0);
  EXPECT_EQ(passes(AccelerationKind::aitken, b), 3);
  EXPECT_EQ(passes(AccelerationKind::quasi_newton, b), 3);
  b << -0.1;
  EXPECT_NEAR(passes(AccelerationKind::none, b), 11, 1);
}

TEST(Acceleration, QuasiNewtonNeedsAPassOrTwoMoreThanUnknowns) {
  const Eigen::MatrixXd b = Eigen::Vector<double, 6>(-20.0, -8.0, -3.0, -0.5, 0.2, 0.8).asDiagonal();
  EXPECT_EQ(passes(AccelerationKind::none, b), 0);
  const int quasi_newton = passes(AccelerationKind::quasi_newton, b), aitken = passes(AccelerationKind::aitken, b);
  EXPECT_GT(quasi_newton, 0);
  EXPECT_LE(quasi_newton, 9);
  EXPECT_TRUE(aitken == 0 || aitken > quasi_newton) << aitken;
}

TEST(Acceleration, ARepeatedIterateDoesNoHarm) {
  for (const auto kind : {AccelerationKind::aitken, AccelerationKind::quasi_newton}) {
    const auto acceleration = make_acceleration(kind);
    const Eigen::VectorXd x = Eigen::VectorXd::Constant(3, 1.0), result = Eigen::VectorXd::Constant(3, 2.0);
    for (int k = 0; k < 3; ++k) EXPECT_TRUE(acceleration->next(x, result).allFinite());
  }
}

/// Oscillators far from each other, each of two masses on springs that move as one. The fluid has the first mass: it
/// receives its velocity, and gives the force that this motion needs. The solid has the second mass and receives that
/// force. Both use the trapezoidal rule, so that the converged exchange is the trapezoidal rule for the whole.
struct Oscillators {
  std::vector<double> fluid_mass, solid_mass;                     ///< kg
  std::vector<double> stiffness = std::vector<double>(8, 100.0);  ///< N/m, of either side
  [[nodiscard]] Size size() const { return fluid_mass.size(); }
  [[nodiscard]] double frequency(Size i) const {  // rad/s
    return std::sqrt(2.0 * stiffness[i] / (fluid_mass[i] + solid_mass[i]));
  }
};

class MassPhase final : public Phase {
 public:
  /// `substeps` per window; with `in_time` received values are linear in time, else constant at the value of the
  /// window's end.
  MassPhase(Role role, Oscillators what, int substeps = 1, bool in_time = true)
      : role_(role), what_(std::move(what)), substeps_(substeps), in_time_(in_time) {
    for (Size i = 0; i < what_.size(); ++i) {
      displacement_.push_back(1.0);
      velocity_.push_back(0.0);
      acceleration_.push_back(-std::pow(what_.frequency(i), 2));
    }
  }

  Contract contract() const override {
    const FieldSpec velocity{"velocity", "m/s", 2, Mapping::consistent, "", in_time_},
        force{"force", "N", 2, Mapping::consistent, "", in_time_};
    return {2, "mock", {role_ == Role::fluid ? force : velocity}, {role_ == Role::fluid ? velocity : force}};
  }

  Publication publish() const override {
    Publication out;
    out.time = time_;
    out.points.n_active = what_.size();
    Field field{role_ == Role::fluid ? "force" : "velocity", 2, {}};
    for (Size i = 0; i < what_.size(); ++i) {
      out.points.position.insert(out.points.position.end(), {10.0 * static_cast<double>(i), 0.0});
      out.points.volume.push_back(1.0);
      out.points.smoothing_length.push_back(1.0);
      out.points.owner.push_back(static_cast<double>(i));
      const double force = -what_.stiffness[i] * displacement_[i] - what_.fluid_mass[i] * acceleration_[i];
      field.values.insert(field.values.end(), {role_ == Role::fluid ? force : velocity_[i], 0.0});
    }
    out.fields.push_back(std::move(field));
    return out;
  }

  Outcome advance(const Window& window, const Inbox& inbox) override {
    const double dt = window.interval / substeps_;
    for (int s = 1; s <= substeps_; ++s) {
      const auto told = [&](int step) {
        return inbox.between(role_ == Role::fluid ? "velocity" : "force", step / static_cast<double>(substeps_));
      };
      const auto before = told(s - 1), after = told(s);
      for (Size i = 0; i < what_.size(); ++i) {
        const double k = what_.stiffness[i], m = what_.solid_mass[i], u = displacement_[i], v = velocity_[i];
        if (role_ == Role::fluid)
          velocity_[i] = after[2 * i];
        else
          velocity_[i] = (m * v + 0.5 * dt * (before[2 * i] + after[2 * i]) - dt * k * (u + 0.25 * dt * v)) /
                         (m + 0.25 * dt * dt * k);
        displacement_[i] = u + 0.5 * dt * (v + velocity_[i]);
        acceleration_[i] = 2.0 * (velocity_[i] - v) / dt - acceleration_[i];
      }
    }
    time_ = window.time + window.interval;
    return Outcome::accept();
  }

  void initialise(const Inbox&) override {}
  void save() override { saved_ = {time_, displacement_, velocity_, acceleration_}; }
  void restore() override { std::tie(time_, displacement_, velocity_, acceleration_) = saved_; }
  void archive(Archive& archive) override { archive(time_, displacement_, velocity_, acceleration_); }
  OutputFrame frame() const override { return {}; }
  std::vector<GaugeReading> gauges() const override { return {}; }
  std::map<std::string, double> counters() const override { return {}; }

  const std::vector<double>& displacement() const { return displacement_; }

 private:
  Role role_;
  Oscillators what_;
  int substeps_;
  bool in_time_;
  double time_ = 0.0;
  std::vector<double> displacement_, velocity_, acceleration_;  ///< m, m/s, m/s2
  std::tuple<double, std::vector<double>, std::vector<double>, std::vector<double>> saved_;
};

/// The trapezoidal rule for the whole oscillator.
double monolithic(const Oscillators& what, Size i, double dt, int steps) {
  const double square = std::pow(what.frequency(i), 2);
  double u = 1.0, v = 0.0;
  for (int k = 0; k < steps; ++k) {
    const double then = v;
    v = (v - dt * square * (u + 0.25 * dt * v)) / (1.0 + 0.25 * dt * dt * square);
    u += 0.5 * dt * (then + v);
  }
  return u;
}

void iterate(CoupledRun& run, MassPhase& fluid, MassPhase& solid, AccelerationKind kind, double interval, double end,
             double tolerance = 1e-12) {
  run.settings = {end, interval, 0.0, 0.0};
  run.scheme = IterationSettings{kind, tolerance};
  run.run(&fluid, &solid);
}

/// A solid whose motion in a window depends only on the pass: `unsettled` halves from one pass to the next. A fluid
/// that takes the fields of the solid's last pass.
class SettlingPhase final : public Phase {
 public:
  SettlingPhase(Role role, double gain, bool takes_found = true)
      : role_(role), gain_(gain), takes_found_(takes_found) {}

  Contract contract() const override {
    const FieldSpec force{"force", "N", 1, Mapping::consistent, ""};
    FieldSpec velocity{"velocity", "m/s", 1, Mapping::consistent, ""};
    if (role_ == Role::solid) return {2, "mock", {velocity}, {force}};
    velocity.found = takes_found_;
    return {2, "mock", {force}, {velocity}};
  }
  Publication publish() const override {
    Publication out;
    out.time = time_;
    out.points.position = {0.0, 0.0};
    out.points.volume = out.points.smoothing_length = {1.0};
    out.points.owner = {0.0};
    out.points.n_active = 1;
    out.fields = {{role_ == Role::fluid ? "force" : "velocity", 1, {value_}}};
    if (role_ == Role::solid) out.unsettled = time_ > 0.0 ? std::pow(gain_, pass_) : 0.0;
    return out;
  }
  Outcome advance(const Window& window, const Inbox& inbox) override {
    pass_ = window.pass;
    if (role_ == Role::fluid) {
      passes.push_back(window.pass);
      given.push_back(inbox.at("velocity").values[0]);
      found.push_back(inbox.found.empty() ? -1.0 : inbox.found_at("velocity").values[0]);
    }
    value_ += 1.0 + window.pass;
    time_ = window.time + window.interval;
    return Outcome::accept();
  }
  void initialise(const Inbox&) override {}
  void save() override { saved_ = {time_, value_}; }
  void restore() override { std::tie(time_, value_) = saved_; }
  void archive(Archive& archive) override { archive(time_, value_); }
  OutputFrame frame() const override { return {}; }
  std::vector<GaugeReading> gauges() const override { return {}; }
  std::map<std::string, double> counters() const override { return {}; }

  std::vector<unsigned> passes;
  std::vector<double> given, found;

 private:
  Role role_;
  double gain_;
  bool takes_found_;
  double time_ = 0.0, value_ = 0.0;
  unsigned pass_ = 0;
  std::tuple<double, double> saved_;
};

TEST(Settled, AWindowIsRepeatedWithWhatTheLastPassFound) {
  SettlingPhase fluid(Role::fluid, 0.5), solid(Role::solid, 0.5);
  CoupledRun run;
  run.settings = {0.2, 0.1, 0.0, 0.0};
  run.scheme = Settled{0.3};  // reached by the third pass: 1, 0.5, 0.25
  run.run(&fluid, &solid);
  run.expect_success();
  EXPECT_EQ(run.report.windows, 2u);
  EXPECT_EQ(run.report.passes, 6u);
  EXPECT_EQ(fluid.passes, (std::vector<unsigned>{0, 1, 2, 0, 1, 2}));
  // The window's start is unchanged; the passes ended with 1, 2 and 3 more.
  EXPECT_EQ(fluid.given, (std::vector<double>{0.0, 0.0, 0.0, 3.0, 3.0, 3.0}));
  EXPECT_EQ(fluid.found, (std::vector<double>{-1.0, 1.0, 2.0, -1.0, 4.0, 5.0}));
}

TEST(Settled, AFluidThatDoesNotTakeWhatAPassFoundGetsOne) {
  SettlingPhase fluid(Role::fluid, 1.0, false), solid(Role::solid, 1.0);
  CoupledRun run;
  run.settings = {0.2, 0.1, 0.0, 0.0};
  run.scheme = Settled{0.3};
  run.run(&fluid, &solid);
  run.expect_success();
  EXPECT_EQ(run.report.passes, 2u);
  EXPECT_NE(std::find(run.log.begin(), run.log.end(),
                      "coupler: the fluid does not take what a pass found: every window is crossed once"),
            run.log.end());
}

TEST(Settled, WhatNeverSettlesEndsTheRunWithTheReason) {
  SettlingPhase fluid(Role::fluid, 1.0), solid(Role::solid, 1.0);
  CoupledRun run;
  run.settings = {0.2, 0.1, 0.0, 0.0};
  run.scheme = Settled{0.3};
  run.run(&fluid, &solid);
  EXPECT_NE(run.coupler.error.find("1 of the weight missing in the balance, 0.3 allowed, after 12 passes"),
            std::string::npos)
      << run.coupler.error;
  EXPECT_EQ(fluid.passes.size(), 12u * 21u);
}

TEST(Iteration, AHeavyMassDrivenByALightOneNeedsAcceleration) {
  const Oscillators what{{10.0}, {1.0}};
  for (const auto kind : {AccelerationKind::aitken, AccelerationKind::quasi_newton}) {
    MassPhase fluid(Role::fluid, what), solid(Role::solid, what);
    CoupledRun run;
    iterate(run, fluid, solid, kind, 0.01, 1.0);
    run.expect_success();
    EXPECT_EQ(run.report.windows, 100u);
    EXPECT_LE(run.report.passes, 400u);
    EXPECT_NEAR(solid.displacement()[0], monolithic(what, 0, 0.01, 100), 1e-9);
    EXPECT_NEAR(fluid.displacement()[0], solid.displacement()[0], 1e-9);
    EXPECT_NEAR(solid.displacement()[0], std::cos(what.frequency(0)), 5e-3);  // error of the trapezoidal rule itself
  }
  MassPhase fluid(Role::fluid, what), solid(Role::solid, what);
  CoupledRun run;
  iterate(run, fluid, solid, AccelerationKind::none, 0.01, 1.0);
  EXPECT_NE(run.coupler.error.find("not converged after 50 iterations"), std::string::npos) << run.coupler.error;
}

/// The acceleration's state belongs to one window: a checkpoint between two windows need not contain it.
TEST(Iteration, ResumesToTheBit) {
  const Oscillators what{{20.0, 8.0, 3.0, 0.5}, {1.0, 1.0, 1.0, 4.0}};
  const Oscillators one{{10.0}, {1.0}};
  for (const auto kind : {AccelerationKind::aitken, AccelerationKind::quasi_newton}) {
    const auto& masses = kind == AccelerationKind::aitken ? one : what;
    const auto folder = testing_tools::fresh_folder("poretwin-iterated");
    const auto states = [&](std::uint64_t stop_after, bool resume) {
      MassPhase fluid(Role::fluid, masses, 3), solid(Role::solid, masses, 2);
      CoupledRun run;
      run.checkpoints = folder;
      run.checkpoint_every = resume ? no_limit : 0.0;
      run.stop_after = stop_after;
      run.resume = resume;
      iterate(run, fluid, solid, kind, 0.01, 0.3, 1e-10);
      run.expect_success();
      EXPECT_GT(run.report.passes, 2 * run.report.windows);
      Archive archive;
      fluid.archive(archive);
      solid.archive(archive);
      return std::tuple(archive.bytes(), run.report.windows, run.report.passes);
    };
    const auto whole = states(0, false);
    EXPECT_EQ(std::get<1>(whole), 30u);
    EXPECT_EQ(std::get<1>(states(13, false)), 13u);
    EXPECT_TRUE(states(0, true) == whole) << static_cast<int>(kind);
    std::filesystem::remove_all(folder);
  }
}

TEST(Iteration, ALightMassDrivenByAHeavyOneDoesWithout) {
  const Oscillators what{{1.0}, {10.0}};
  MassPhase fluid(Role::fluid, what), solid(Role::solid, what);
  CoupledRun run;
  iterate(run, fluid, solid, AccelerationKind::none, 0.01, 0.5);
  run.expect_success();
  EXPECT_NEAR(solid.displacement()[0], monolithic(what, 0, 0.01, 50), 1e-9);
}

TEST(Iteration, OnePassGivesAnotherAnswerThanTheConvergedOne) {
  const Oscillators what{{1.0}, {10.0}};
  MassPhase fluid(Role::fluid, what), solid(Role::solid, what);
  CoupledRun run;
  run.settings = {0.5, 0.01, 0.0, 0.0};
  run.run(&fluid, &solid);
  run.expect_success();
  EXPECT_EQ(run.report.passes, run.report.windows);
  EXPECT_GT(std::abs(solid.displacement()[0] - monolithic(what, 0, 0.01, 50)), 1e-4);
}

TEST(Iteration, ManyMassesAtOnceAreForQuasiNewton) {
  const Oscillators what{{20.0, 8.0, 3.0, 0.5, 1.0, 12.0}, {1.0, 1.0, 1.0, 1.0, 4.0, 2.0}};
  MassPhase fluid(Role::fluid, what), solid(Role::solid, what);
  CoupledRun run;
  iterate(run, fluid, solid, AccelerationKind::quasi_newton, 0.01, 0.5, 1e-10);
  run.expect_success();
  EXPECT_EQ(run.report.windows, 50u);
  EXPECT_LE(run.report.passes, 50u * 10u);
  for (Size i = 0; i < what.size(); ++i) EXPECT_NEAR(solid.displacement()[i], monolithic(what, i, 0.01, 50), 1e-7) << i;
}

TEST(Iteration, SubstepsSeeWhatIsToldLinearInTime) {
  const Oscillators what{{0.0}, {1.0}};  // a spring in one phase, a mass and a spring in the other
  const auto error = [&](bool in_time, double interval) {
    MassPhase fluid(Role::fluid, what, 4, in_time), solid(Role::solid, what, 5, in_time);
    CoupledRun run;
    iterate(run, fluid, solid, AccelerationKind::quasi_newton, interval, 0.5);
    run.expect_success();
    return std::abs(solid.displacement()[0] - std::cos(0.5 * what.frequency(0)));
  };
  const double coarse = error(true, 0.02), fine = error(true, 0.01);
  EXPECT_NEAR(coarse / fine, 4.0, 1.0) << coarse << " " << fine;
  EXPECT_GT(error(false, 0.01), 5.0 * fine);  // constant values: first order
}

}  // namespace
}  // namespace poretwin::coupling
