#include "common/media/erosion_law.hpp"
#include "common/media/excess_shear.hpp"

namespace poretwin::porous {

const std::deque<ErosionLaw>& erosion_laws() {
  static const std::deque<ErosionLaw> laws{excess_shear()};
  return laws;
}

Erosion::Erosion(const ErosionCase& given, double density)
    : law_(given.law ? given.law : &erosion_laws().front()),
      friction_factor_(given.friction_factor),
      density_(density) {
  for (const LawParameter& parameter : law_->parameters) parameters_.push_back(parameter.in(given.numbers));
}

}  // namespace poretwin::porous
