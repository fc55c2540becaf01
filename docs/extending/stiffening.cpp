// A soil that stiffens as it is compressed: the example of material.md.
#include "solid_solver/material/model.hpp"

namespace poretwin::solid {
namespace {

/// Linear elasticity whose moduli grow linearly with the volumetric compression, up to twice those of loose soil.
class Stiffening final : public ConstitutiveModel {
 public:
  using ConstitutiveModel::advance;
  explicit Stiffening(const Soil& soil) : loose_(Elasticity::of(soil)), doubling_(soil.own("doubling_strain")) {}

  // One state variable per particle: its volumetric compression since the start [1].
  [[nodiscard]] std::size_t state_size() const override { return 1; }
  void initial(const Tensor& /*stress*/, std::span<double> state) const override { state[0] = 0.0; }

  double advance(Tensor& stress, const Tensor& strain, const Condition& /*condition*/,
                 std::span<double> state) const override {
    const double before = state[0];
    state[0] -= trace(strain);
    at(0.5 * (before + state[0])).add_stress(strain.data(), stress.data());  // exact: the moduli are linear
    return 0.0;                                                              // no plastic strain
  }

  [[nodiscard]] Elasticity moduli(const Tensor& /*stress*/, std::span<const double> state) const override {
    return at(state[0]);
  }
  [[nodiscard]] Elasticity stiffest(double /*pressure*/) const override { return at(doubling_); }

 private:
  [[nodiscard]] Elasticity at(double compression) const {
    const double times = 1.0 + std::clamp(compression / doubling_, 0.0, 1.0);
    return {times * loose_.bulk, times * loose_.shear};
  }

  Elasticity loose_;  ///< moduli of soil that is not compressed [Pa]
  double doubling_;   ///< volumetric compression at which the moduli have doubled [1]
};

// The row in the table of materials. For a model that any case may name it stands in
// solid_solver/material/registry.cpp instead.
[[maybe_unused]] const bool in_table = add_material(
    {"stiffening",
     Material::Strength::own,
     {{"doubling_strain", 0.01, {"", "Compression at which the moduli have doubled (stiffening)."}, positive()}}},
    [](const Soil& soil) -> std::unique_ptr<ConstitutiveModel> { return std::make_unique<Stiffening>(soil); });

}  // namespace
}  // namespace poretwin::solid
