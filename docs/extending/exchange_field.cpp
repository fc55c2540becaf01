// An additional field in the exchange: water passes its temperature to the soil. Both sides name the field in their
// contract; the coupler maps it like any other.
#include "tests/coupling/coupled_run.hpp"

using namespace poretwin;
using namespace poretwin::coupling;

namespace {

const FieldSpec temperature{"temperature", "K", 1, Mapping::consistent, std::string(field::soil_fraction)};

/// Water whose temperature rises to the right.
class WarmWater : public MockPhase {
 public:
  WarmWater() : MockPhase(Role::fluid, 2, still_square(Role::fluid)) {}
  Contract contract() const override {
    Contract c = MockPhase::contract();
    c.gives.push_back(temperature);
    return c;
  }
  Publication publish() const override {
    Publication out = MockPhase::publish();
    Field field{temperature.name, 1, {}};
    for (std::size_t i = 0; i < out.points.size(); ++i)
      field.values.push_back(280.0 + 5.0 * out.points.position[2 * i]);
    out.fields.push_back(field);
    return out;
  }
};

/// Soil that keeps the temperature [K] that it receives at its points.
class Soil : public MockPhase {
 public:
  Soil() : MockPhase(Role::solid, 2, still_square(Role::solid, 0.07)) {}
  Contract contract() const override {
    Contract c = MockPhase::contract();
    c.takes.push_back(temperature);
    return c;
  }
  Outcome advance(const Window& window, const Inbox& inbox) override {
    warmth = inbox.at(temperature.name).values;
    return MockPhase::advance(window, inbox);
  }
  std::vector<double> warmth;
};

TEST(ExchangeField, ArrivesAtTheOthersPoints) {
  WarmWater water;
  Soil soil;
  CoupledRun run;
  run.run(&water, &soil);
  run.expect_success();
  const auto points = soil.publish().points;
  ASSERT_EQ(soil.warmth.size(), points.n_active);
  for (std::size_t i = 0; i < points.n_active; ++i) {
    // At the edge of the water's points a value is limited to the range of its neighbours' values.
    const double x = points.position[2 * i], exact = 280.0 + 5.0 * std::clamp(x, 0.05, 0.95);
    EXPECT_NEAR(soil.warmth[i], exact, x > 0.2 && x < 0.8 ? 1e-9 : 0.05) << x;
  }
}

TEST(ExchangeField, ThatNobodyGivesIsNamed) {
  MockPhase water(Role::fluid, 2, still_square(Role::fluid));
  Soil soil;
  CoupledRun run;
  run.broker.wait_deadline = Milliseconds(300);
  run.run(&water, &soil);
  EXPECT_NE(run.solid.error.find("temperature"), std::string::npos) << run.solid.error;
}

}  // namespace
