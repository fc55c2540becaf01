#include "solid_solver/material/element.hpp"

#include "common/core/error.hpp"
#include "solid_solver/numerics/material.hpp"

#include <fmt/format.h>
#include <Eigen/QR>

namespace poretwin::solid {

const std::vector<LaboratoryTest>& laboratory_tests() {
  static const std::vector<LaboratoryTest> tests{
      {"triaxial", "triaxial compression, drained: the cell pressure is held", false, false},
      {"triaxial_undrained", "the same at constant volume", false, true},
      {"isotropic", "the same stress from all sides", false, false},
      {"oedometer", "compression without lateral strain", false, false},
      {"plane_strain", "compression in plane strain, drained: the lateral stress is held", false, false},
      {"plane_strain_undrained", "the same at constant volume", false, true},
      {"simple_shear", "simple shear, drained: the vertical stress is held, there is no lateral strain", true, false},
      {"simple_shear_undrained", "the same at constant volume", true, true}};
  return tests;
}

const LaboratoryTest& laboratory_test(std::string_view name) {
  std::string names;
  for (const LaboratoryTest& test : laboratory_tests()) {
    if (test.name == name) return test;
    names += fmt::format("{}{}", names.empty() ? "" : ", ", test.name);
  }
  throw CaseError(fmt::format("test \"{}\": expected one of {}", name, names));
}

Element::Element(const Soil& soil, const ConstitutiveModel& model, const Tensor& stress, double viscosity)
    : model_(model),
      start_(stress),
      stress_(stress),
      state_(model.state_size()),
      initial_void_ratio_(soil.porosity / (1.0 - soil.porosity)),
      saturation_(soil.initial_saturation),
      viscosity_(viscosity) {
  model.initial(stress, state_);
}

double Element::void_ratio() const { return (1.0 + initial_void_ratio_) * std::exp(trace(strain_)) - 1.0; }

double Element::excess_pore_pressure(const LaboratoryTest& test) const {
  const int held = test.shears ? 1 : 0;
  return test.undrained ? stress_[held] - start_[held] : 0.0;
}

/// Four conditions on the increments of the strains xx, yy, zz and xy: strain . increment + stress . (stress after the
/// increment) = value.
struct Element::Control {
  Eigen::Matrix4d strain = Eigen::Matrix4d::Zero(), stress = Eigen::Matrix4d::Zero();
  Eigen::Vector4d value = Eigen::Vector4d::Zero();

  /// Sets all conditions but the last, by which the test is controlled.
  Control(const LaboratoryTest& test, const Tensor& start) {
    int row = 0;
    const auto no_strain = [&](int component) { strain(row++, component) = 1.0; };
    const auto held = [&](int component) {
      stress(row, component) = 1.0;
      value[row++] = start[component];
    };
    const auto equal = [&](Eigen::Matrix4d& of, int a, int b) {
      of(row, a) = 1.0;
      of(row++, b) = -1.0;
    };
    const bool plane = test.name.starts_with("plane_strain"), triaxial = test.name.starts_with("triaxial");
    if (!test.shears) no_strain(xy);
    if (test.name == "isotropic") {
      equal(stress, xx, yy);
      equal(stress, zz, yy);
      return;
    }
    if (triaxial && test.undrained)
      equal(strain, xx, zz);
    else if (triaxial)
      held(zz);
    else
      no_strain(zz);
    if (!plane && !triaxial) no_strain(xx);
    if (test.name == "oedometer") return;
    if (test.undrained)
      strain.row(row).head<3>().setOnes();
    else
      held(test.shears ? yy : xx);
  }
  static constexpr int xx = 0, yy = 1, zz = 2, xy = 3, last = 3;
};

void Element::strain_by(const LaboratoryTest& test, double step, double duration) {
  Control control(test, start_);
  control.strain(Control::last, test.shears ? Control::xy : Control::yy) = test.shears ? 2.0 : 1.0;
  control.value[Control::last] = step;
  follow(control, duration);
}

void Element::load_to(const LaboratoryTest& test, double target) {
  Control control(test, start_);
  control.stress(Control::last, test.shears ? Control::xy : Control::yy) = 1.0;
  if (test.undrained && !test.shears) control.stress(Control::last, Control::xx) = -1.0;
  control.value[Control::last] = target;
  follow(control, std::numeric_limits<double>::infinity());
}

void Element::follow(const Control& control, double duration) {
  const Condition condition{saturation_, void_ratio(), duration, viscosity_};
  Tensor stress;
  std::vector<double> state;
  double plastic = 0.0;
  const auto attempt = [&](const Eigen::Vector4d& strain) -> Eigen::Vector4d {
    stress = stress_;
    state = state_;
    Tensor increment = Tensor::Zero();
    increment.head<4>() = strain;
    plastic = model_.advance(stress, increment, condition, state);
    return stress.head<4>();
  };
  // Residuals of stress are divided by the constrained modulus, so that they compare with strains.
  const double modulus = model_.moduli(stress_, state_).constrained();
  const auto left = [&](const Eigen::Vector4d& strain, const Eigen::Vector4d& reached) -> Eigen::Vector4d {
    Eigen::Vector4d rest = control.strain * strain + control.stress * reached - control.value;
    for (int row = 0; row < 4; ++row)
      if (!control.stress.row(row).isZero()) rest[row] /= modulus;
    return rest;
  };
  Eigen::Vector4d strain = Eigen::Vector4d::Zero();
  Eigen::Vector4d rest = left(strain, attempt(strain));
  const double tolerance = element::reached * std::max(rest.cwiseAbs().maxCoeff(), element::reached);
  for (int round = 0; rest.cwiseAbs().maxCoeff() > tolerance; ++round) {
    if (round == element::rounds)
      throw DivergedError(fmt::format(
          "no strain keeps the conditions of the test after an axial strain of {:g} and a shear of {:g}: the "
          "soil bears no more, or its steps are too long",
          -strain_[1], 2.0 * strain_[3]));
    const double probe = element::probe * std::max(strain.cwiseAbs().maxCoeff(), rest.cwiseAbs().maxCoeff());
    Eigen::Matrix4d slope;
    const Eigen::Vector4d here = attempt(strain);
    for (int c = 0; c < 4; ++c) {
      const Eigen::Vector4d moved = strain + probe * Eigen::Vector4d::Unit(c);
      slope.col(c) = (left(moved, attempt(moved)) - left(strain, here)) / probe;
    }
    // On an edge of the yield surface, lateral strains are not unique: the smallest are taken.
    Eigen::CompleteOrthogonalDecomposition<Eigen::Matrix4d> solver;
    solver.setThreshold(element::singular);
    const Eigen::Vector4d towards = solver.compute(slope).solve(-rest);
    // The correction is shortened if it would increase the residual, as at the corner where the soil begins to yield.
    double share = 1.0;
    Eigen::Vector4d next;
    for (;; share *= 0.5) {
      next = left(strain + share * towards, attempt(strain + share * towards));
      if (next.norm() < rest.norm() || share < element::least_share) break;
    }
    strain += share * towards;
    rest = next;
  }
  attempt(strain);
  stress_ = stress;
  state_ = state;
  strain_.head<4>() += strain;
  plastic_ += plastic;
}

}  // namespace poretwin::solid
