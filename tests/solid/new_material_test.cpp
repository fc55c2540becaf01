// A material in one file and one table row (docs/extending/stiffening.cpp): selected in a case, exact, its state saved.
#include "common/core/error.hpp"
#include "tests/solid/scenes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

namespace poretwin::solid {
namespace {

using testing::HasSubstr;

constexpr double doubling = 4e-4, weight = 0.6 * 2600.0 * 9.81;  // N/m3

/// A column under its weight, read from a file, with a row of elastic soil at its base.
Case stiffening_column(const std::string& doubling_strain) {
  const auto path = std::filesystem::temp_directory_path() / "poretwin_stiffening.toml";
  std::ofstream(path) << R"([case]
end_time = 1
[solid]
model = "elastic"
particle_spacing = 0.05
[[soil]]
min = [0, 0]
max = [0.4, 0.05]
youngs_modulus = 3e7
[[soil]]
min = [0, 0.05]
max = [0.4, 1.05]
youngs_modulus = 3e7
model = "stiffening"
doubling_strain = )" << doubling_strain
                      << R"(
[[wall]]
points = [[0, 2], [0, 0], [0.4, 0], [0.4, 2]]
)";
  return read_case(path);
}

/// Compression c at a depth [m]: M (c + c^2 / 2 d) = weight depth.
double compression(const Solid<2>& solid, double depth) {
  const double strain = weight * depth / solid.setup().models[1]->initial_moduli().constrained();
  return doubling * (std::sqrt(1.0 + 2.0 * strain / doubling) - 1.0);
}

TEST(NewMaterial, IsChosenInTheCaseAndBringsItsKey) {
  const Case scene = stiffening_column("4e-4");
  EXPECT_EQ(scene.soils[1].own("doubling_strain"), doubling);
  EXPECT_EQ(scene.soils[0].own("doubling_strain"), 0.01);
  EXPECT_TRUE(scene.can_yield());
  EXPECT_THAT(case_reference(), HasSubstr("`doubling_strain`"));
  try {
    stiffening_column("0");
    ADD_FAILURE() << "read";
  } catch (const CaseError& error) {
    EXPECT_THAT(error.what(), HasSubstr("'soil[1].doubling_strain': expected a number > 0, found 0"));
  }
}

TEST(NewMaterial, SettlesAsItsModuliSay) {
  Solid<2> solid(stiffening_column("4e-4"));
  solid.initialise({});
  const auto& p = solid.state().particles;
  const auto published = solid.publish();
  const auto& modulus = test::field_of(published, coupling::field::constrained_modulus).values;
  const double loose = solid.setup().models[1]->initial_moduli().constrained();
  // Displacements at 0.225 and 0.875 m depth: away from the surface and from the elastic row, which kernels would
  // include.
  constexpr double upper_depth = 0.225, lower_depth = 0.875;
  double upper = 0.0, lower = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const double depth = 1.05 - (p.position[i].y() - p.displacement[i].y());
    if (p.material[i] == 0) {
      EXPECT_DOUBLE_EQ(modulus[i], loose);
      continue;
    }
    EXPECT_NEAR(modulus[i], loose * (1.0 + p.state_of(i)[0] / doubling), 1e-9 * loose) << depth;
    if (std::abs(depth - upper_depth) < 1e-9) upper = p.displacement[i].y();
    if (std::abs(depth - lower_depth) < 1e-9) lower = p.displacement[i].y();
  }
  double due = 0.0;
  constexpr int cells = 1000;
  constexpr double each = (lower_depth - upper_depth) / cells;
  for (int k = 0; k < cells; ++k) due += compression(solid, upper_depth + (k + 0.5) * each) * each;
  EXPECT_NEAR(lower - upper, due, 5e-3 * due);
}

TEST(NewMaterial, IsSavedRestoredAndArchived) {
  const Case scene = stiffening_column("4e-4");
  Solid<2> solid(scene);
  solid.initialise({});
  const auto bytes = [](Solid<2>& of) {
    Archive archive;
    of.archive(archive);
    return archive.bytes();
  };
  const std::string before = bytes(solid);
  solid.save();
  const ScalarArray compressed = solid.state().particles.material_state;
  const auto kick = [](Solid<2>& of) { of.advance({0, of.state().time, 1e-2}, {}); };
  kick(solid);
  EXPECT_NE(solid.state().particles.material_state, compressed);
  const std::string after = bytes(solid);
  solid.restore();
  EXPECT_EQ(solid.state().particles.material_state, compressed);
  Solid<2> resumed(scene);
  Archive archive(before);
  resumed.archive(archive);
  kick(resumed);
  EXPECT_EQ(bytes(resumed), after);
}

}  // namespace
}  // namespace poretwin::solid
