// The table of materials, with one row each, and functions common to all models.
#include "solid_solver/material/drucker_prager.hpp"
#include "solid_solver/material/drucker_prager_rate.hpp"
#include "solid_solver/material/elastic.hpp"
#include "solid_solver/material/modified_cam_clay.hpp"
#include "solid_solver/material/mohr_coulomb.hpp"
#include "solid_solver/material/mu_i.hpp"
#include "solid_solver/material/umat.hpp"

#include "common/core/error.hpp"

#include <fmt/format.h>

namespace poretwin::solid {
namespace {

struct Row {
  Material material;
  MaterialFactory make;
};

template <class Model>
std::unique_ptr<ConstitutiveModel> make(const Soil& soil) {
  return std::make_unique<Model>(soil);
}

std::vector<Row>& table() {
  using enum Material::Strength;
  static std::vector<Row> rows{{{"elastic", none, {}}, make<LinearElastic>},
                               {{"drucker_prager", cohesion_and_friction, {}}, make<DruckerPrager>},
                               {{"drucker_prager_rate", cohesion_and_friction, {}}, make<DruckerPragerRate>},
                               {{"mohr_coulomb", cohesion_and_friction, {}}, make<MohrCoulomb>},
                               {ModifiedCamClay::row(), make<ModifiedCamClay>},
                               {MuI::row(), make<MuI>},
                               {{"umat", own, {}, &Umat::judge}, make<Umat>}};
  return rows;
}

}  // namespace

bool add_material(Material row, MaterialFactory make) {
  table().push_back({std::move(row), make});
  return true;
}

std::unique_ptr<ConstitutiveModel> make_constitutive(MaterialName model, const Soil& soil) {
  for (const Row& row : table())
    if (row.material.name == model.name) return row.make(soil);
  throw CaseError(fmt::format("model \"{}\": no material has this name, so there is no solid phase", model.name));
}

void ConstitutiveModel::advance(std::span<Four> many) const {
  const std::size_t size = state_size();
  std::vector<double> state(size);
  for (std::size_t q = 0; q < many.size(); ++q)
    for (std::size_t l = 0; l < n_lanes; ++l) {
      Four& four = many[q];
      Tensor stress, strain;
      for (int d = 0; d < 6; ++d) {
        stress[d] = four.stress[d][l];
        strain[d] = four.strain[d][l];
      }
      for (std::size_t k = 0; k < size; ++k) state[k] = four.state[k].v[l];
      try {
        four.plastic[l] =
            advance(stress, strain, {four.saturation[l], four.void_ratio[l], four.duration, four.viscosity}, state);
      } catch (MaterialFailure& failure) {
        failure.place = q * n_lanes + l;
        throw;
      }
      for (std::size_t k = 0; k < size; ++k) four.state[k].v[l] = state[k];
      for (int d = 0; d < 6; ++d) four.stress[d][l] = stress[d];
    }
}

Elasticity ConstitutiveModel::moduli_under(double pressure) const {
  std::vector<double> state(state_size());
  Tensor stress = Tensor::Zero();
  stress.head<3>().setConstant(-pressure);
  initial(stress, state);
  return moduli(stress, state);
}

}  // namespace poretwin::solid

namespace poretwin {

double constrained_modulus(MaterialName material, const Soil& soil, double pressure) {
  return solid::make_constitutive(material, soil)->moduli_under(pressure).constrained();
}

std::vector<Material> materials() {
  std::vector<Material> all;
  for (const auto& row : solid::table()) all.push_back(row.material);
  return all;
}

}  // namespace poretwin
