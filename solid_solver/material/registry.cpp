// The constitutive model behind each value of solid.model, one line per model, and what they have in common.
#include "solid_solver/material/drucker_prager.hpp"
#include "solid_solver/material/drucker_prager_rate.hpp"
#include "solid_solver/material/elastic.hpp"

#include "common/core/error.hpp"

namespace poretwin::solid {

void ConstitutiveModel::advance(std::span<Four> many) const {
  for (Four& four : many)
    for (std::size_t l = 0; l < n_lanes; ++l) {
      Tensor stress, strain;
      for (int d = 0; d < 6; ++d) {
        stress[d] = four.stress[d][l];
        strain[d] = four.strain[d][l];
      }
      four.plastic[l] = advance(stress, strain, {four.saturation[l], four.void_ratio[l]});
      for (int d = 0; d < 6; ++d) four.stress[d][l] = stress[d];
    }
}

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
