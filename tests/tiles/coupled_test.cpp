// Water beside soil that moves, shared by several ranks: what the coupler hears of it.
#include "fluid_solver/fluid.hpp"
#include "fluid_solver/numerics/pressure.hpp"
#include "tests/tiles/loaded_column.hpp"

#include <optional>

namespace poretwin::fluid::test {
namespace {

using coupling::Inbox;
using coupling::Publication;

constexpr double interval = 2e-4;  // s
constexpr std::uint64_t windows = 5, passes = 3;

/// What loaded_soil() sends to the active points of a publication. The solid fraction differs from point to point, so
/// that no two could be exchanged unnoticed. In a repeated window the soil has found another motion each time.
Inbox answer(const Publication& water, bool yields, std::uint64_t pass) {
  VecArray<2> places;
  for (std::size_t a = 0; a < water.points.n_active; ++a)
    places.emplace_back(water.points.position[2 * a], water.points.position[2 * a + 1]);
  Inbox box = loaded_soil(places, yields);
  for (auto& field : box.fields) {
    if (field.name == coupling::field::solid_volume_fraction)
      for (std::size_t a = 0; a < places.size(); ++a) field.values[a] += 0.02 * std::sin(37.0 * static_cast<double>(a));
    if (pass == 0 ||
        (field.name != coupling::field::mean_solid_velocity && field.name != coupling::field::unbalanced_force))
      continue;
    coupling::Field found = field;
    for (std::size_t a = 0; a < places.size(); ++a)
      found.values[2 * a + 1] =
          0.1 * field.values[2 * a + 1] - 1e-3 * std::sin(static_cast<double>(5 * pass) * places[a].y());
    box.found.push_back(std::move(found));
  }
  return box;
}

/// Takes part in windows that are repeated, as in a coupled run. Returns the publications after initialise() and after
/// the last pass through each window.
std::vector<Publication> take_part(Phase& water, bool yields) {
  water.initialise(answer(water.publish(), yields, 0));
  std::vector<Publication> said{water.publish()};
  for (std::uint64_t step = 0; step < windows; ++step) {
    water.save();
    std::optional<Publication> now;
    for (std::uint64_t pass = 0; pass < passes; ++pass) {
      if (pass > 0) water.restore();
      water.advance({step + 1, interval * static_cast<double>(step), interval, static_cast<unsigned>(pass), true},
                    answer(said.back(), yields, pass));
      now = water.publish();
    }
    said.push_back(std::move(*now));
  }
  return said;
}

void expect_near(const std::vector<double>& found, const std::vector<double>& expected, double allowed,
                 const std::string& what) {
  EXPECT_EQ(found.size(), expected.size()) << what;
  if (found.size() != expected.size()) return;
  double by = 0.0, most = 0.0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    by = std::max(by, std::abs(found[i] - expected[i]));
    most = std::max(most, std::abs(expected[i]));
  }
  EXPECT_LE(by, allowed * most) << what;
}

struct Setting {
  const char* name;
  bool yields;
  void (*set)(Case&);
};

class SharedBesideSoil : public testing::TestWithParam<Setting> {};

/// Every rank makes the same calls. The ranks that do not lead have empty publications, and send nothing.
TEST_P(SharedBesideSoil, PublishesAsOneProcess) {
  const bool yields = GetParam().yields;
  Case scene = loaded_column(yields);
  GetParam().set(scene);
  scene.loads.emplace_back();
  scene.loads[0].start = interval * static_cast<double>(windows);
  scene.loads[0].traction = {0.0, -1e3, 0.0};
  const auto part = [&] { return make_shared_fluid<2>(scene, across<2>(1, 0.0, 0.4)); };
  const auto ranks = part();
  const std::vector<Publication> shared = take_part(*ranks, yields);
  Archive saved;
  ranks->archive(saved);
  const auto later = part();
  Archive stored(saved.bytes());
  later->archive(stored);
  const Publication resumed = later->publish();
  const double proposed = later->proposal().first;
  if (all_ranks().rank() > 0) return;
  const auto whole = make_fluid(scene);
  const auto alone = take_part(*whole, yields);
  ASSERT_EQ(shared.size(), alone.size());
  for (std::size_t k = 0; k < alone.size(); ++k) {
    const Publication &a = shared[k], &b = alone[k];
    const double first = k == 0 ? 1e-9 : 1.0;  // nothing has been solved for but the pressure
    EXPECT_EQ(a.points.n_active, b.points.n_active);
    EXPECT_EQ(a.points.revision, b.points.revision);
    EXPECT_EQ(a.limited_by, b.limited_by);
    EXPECT_NEAR(a.proposed_interval, b.proposed_interval, 1e-2 * first * b.proposed_interval);
    expect_near(a.points.position, b.points.position, 1e-6 * first, "position");
    expect_near(a.points.volume, b.points.volume, 1e-4 * first, "volume");
    ASSERT_EQ(a.fields.size(), b.fields.size());
    for (std::size_t f = 0; f < b.fields.size(); ++f) {
      const bool is_pressure = b.fields[f].name == coupling::field::pore_pressure;
      // Later all follow from solves that end at a residual of the response tolerance.
      expect_near(a.fields[f].values, b.fields[f].values,
                  k > 0         ? pressure::response_tolerance
                  : is_pressure ? 1e-6
                                : 1e-11,
                  b.fields[f].name);
    }
  }
  if (scene.fluid.skeleton_response) {
    EXPECT_EQ(shared.back().limited_by, "a load that begins");
  }
  EXPECT_EQ(whole->counters().contains("s: first cavitation"), scene.water.cavitation_pressure > 0.0);
  // From a checkpoint the run goes on with the same windows and values.
  stored.expect_end();
  EXPECT_EQ(proposed, resumed.proposed_interval);
  EXPECT_EQ(resumed.proposed_interval, shared.back().proposed_interval);
  EXPECT_EQ(resumed.limited_by, shared.back().limited_by);
  EXPECT_EQ(resumed.points.position, shared.back().points.position);
  for (std::size_t f = 0; f < resumed.fields.size(); ++f)
    EXPECT_EQ(resumed.fields[f].values, shared.back().fields[f].values) << resumed.fields[f].name;
}

constexpr Setting settings[] = {
    {"Drains", false, [](Case&) {}},
    {"Yields", true, [](Case&) {}},
    {"ComputesBeside", false, [](Case& scene) { scene.coupling.scheme = CouplingCase::Scheme::parallel; }},
    {"DoesNotRespond", false, [](Case& scene) { scene.fluid.skeleton_response = false; }},
    {"Cavitates", false, [](Case& scene) { scene.water.cavitation_pressure = 500.0; }},
};
INSTANTIATE_TEST_SUITE_P(Soil, SharedBesideSoil, testing::ValuesIn(settings),
                         [](const auto& setting) { return setting.param.name; });

}  // namespace
}  // namespace poretwin::fluid::test
