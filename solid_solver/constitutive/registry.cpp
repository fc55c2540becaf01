// Which constitutive model each value of solid.model means: one line per model.
#include "solid_solver/constitutive/drucker_prager.hpp"
#include "solid_solver/constitutive/drucker_prager_rate.hpp"
#include "solid_solver/constitutive/elastic.hpp"

#include "common/core/error.hpp"

namespace poretwin::solid {

std::unique_ptr<ConstitutiveModel> make_constitutive(SolidCase::Model model, const Soil& soil) {
  switch (model) {
    case SolidCase::Model::elastic:
      return std::make_unique<LinearElastic>(soil);
    case SolidCase::Model::drucker_prager:
      return std::make_unique<DruckerPrager>(soil);
    case SolidCase::Model::drucker_prager_rate:
      return std::make_unique<DruckerPragerRate>(soil);
    case SolidCase::Model::rigid:
      break;
  }
  throw CaseError(
      "solid.model = \"rigid\": a rigid skeleton needs no solid phase; expected \"elastic\", \"drucker_prager\" or "
      "\"drucker_prager_rate\"");
}

}  // namespace poretwin::solid
