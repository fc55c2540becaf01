// Runs of a case by several ranks, led by rank 0 as by the only process, against the same run by one process.
#include "common/ranks/led_phase.hpp"
#include "common/coupling/drive.hpp"
#include "common/tiles/mpi_tiling.hpp"
#include "solid_solver/solid.hpp"
#include "tests/tiles/ranks.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

namespace poretwin::ranks {
namespace {

namespace fs = std::filesystem;
using tiles::all_ranks;

/// Keeps all numbers of frames and gauges.
class NumbersRecorder final : public Recorder {
 public:
  std::map<std::string, std::vector<double>> numbers;  ///< of each field and of each gauge, in the order of time
  std::vector<std::size_t> particles;                  ///< of each frame
  void frame(const OutputFrame& frame) override {
    particles.push_back(frame.count);
    const auto keep = [&](const std::string& name, int components, const ParticleWriter& write) {
      auto& all = numbers[name];
      for (std::size_t i = 0; i < frame.count; ++i) {
        all.resize(all.size() + static_cast<std::size_t>(components));
        write(i, &*all.end() - components);
      }
    };
    keep("position", 3, frame.position);
    for (const auto& field : frame.fields) keep(field.name, field.components, field.write);
  }
  void gauges(double, const std::vector<GaugeReading>& readings) override {
    for (const auto& r : readings) numbers["gauge " + r.gauge].push_back(r.value);
  }
  void archive(Archive& archive) override { archive(numbers, particles); }
  [[nodiscard]] std::vector<std::string> files() const override { return {}; }
};

/// The largest difference, over the largest value; NaN are equal to NaN.
double difference(const std::vector<double>& one, const std::vector<double>& other) {
  if (one.size() != other.size()) return std::numeric_limits<double>::infinity();
  double by = 0.0, most = 0.0;
  for (std::size_t i = 0; i < one.size(); ++i) {
    if (std::isnan(one[i]) != std::isnan(other[i])) return std::numeric_limits<double>::infinity();
    if (std::isnan(one[i])) continue;
    by = std::max(by, std::abs(one[i] - other[i]));
    most = std::max(most, std::abs(one[i]));
  }
  return by > 0.0 ? by / most : 0.0;
}

class LedSoil : public testing::Test {
 protected:
  static Case read(const std::string& name, const std::vector<std::string>& overrides) {
    return read_case(fs::path(PORETWIN_SOURCE_DIR) / "cases" / name / "case.toml", overrides);
  }
  static std::unique_ptr<Phase> part(const Case& scene) {
    return solid::make_shared_solid<2>(scene, std::make_shared<tiles::MpiTiling<2>>(all_ranks(), 0.1));
  }
  /// What is done with a phase that all ranks compute; rank 0 does it.
  static void led(const Case& scene, const std::function<void(Phase&)>& with) {
    if (all_ranks().rank() > 0) return follow(all_ranks(), part);
    Leader leader(all_ranks());
    {
      const auto phase = leader.make(scene, part);
      with(*phase);
    }
    leader.end(0);
  }
  /// Compares all numbers of two runs on rank 0. allowed: largest difference of each field over its largest value.
  static void expect_same(const NumbersRecorder& shared, const NumbersRecorder& alone, double allowed) {
    if (all_ranks().rank() > 0) return;
    EXPECT_EQ(shared.particles, alone.particles);
    EXPECT_EQ(shared.numbers.size(), alone.numbers.size());
    for (const auto& [name, numbers] : alone.numbers) {
      const auto found = shared.numbers.find(name);
      if (found == shared.numbers.end()) {
        ADD_FAILURE() << name << " is missing";
        continue;
      }
      EXPECT_LE(difference(found->second, numbers), allowed) << name;
    }
  }
  static constexpr double rounding = 1e-9;
};

TEST_F(LedSoil, IsRecordedAsByOneProcess) {
  const Case scene = read("column_collapse", {"solid.particle_spacing=0.01", "case.end_time=0.04",
                                              "output.interval=0.02", "output.gauge_interval=0.01"});
  NumbersRecorder shared, alone;
  double particles = 0.0;
  led(scene, [&](Phase& phase) {
    const auto report = coupling::drive_alone(phase, scene, shared);
    EXPECT_EQ(report.time, 0.04);
    particles = phase.counters().at("particles");
  });
  if (all_ranks().rank() > 0) return;
  const auto one = solid::make_solid(scene);
  coupling::drive_alone(*one, scene, alone);
  EXPECT_EQ(particles, one->counters().at("particles"));
  EXPECT_EQ(alone.particles.size(), 3u);
  EXPECT_EQ(alone.numbers.at("gauge tip").size(), 5u);
  expect_same(shared, alone, rounding);
}

/// The rest is found by rank 0 alone and then shared: gravity has settled the slope before time zero.
TEST_F(LedSoil, BeginsFromARest) {
  const Case scene = read("cohesive_slope", {"solid.particle_spacing=1"});
  NumbersRecorder shared, alone;
  led(scene, [&](Phase& phase) {
    coupling::drive_alone(phase, scene, shared);
    EXPECT_GT(phase.counters().at("rest steps"), 10.0);
  });
  if (all_ranks().rank() > 0) return;
  coupling::drive_alone(*solid::make_solid(scene), scene, alone);
  expect_same(shared, alone, rounding);
  EXPECT_GT(std::abs(alone.numbers.at("gauge crest").back()), 1e-3);
}

/// Checkpoints hold the whole soil: ranks, and one process, go on from it as if the run had not been interrupted. The
/// impulse from outside is a sum over the time before and after.
TEST_F(LedSoil, GoesOnFromACheckpoint) {
  const fs::path source = fs::path(PORETWIN_SOURCE_DIR) / "cases" / "column_collapse" / "case.toml";
  const fs::path file = fs::temp_directory_path() / fmt::format("poretwin-led-{}.toml", all_ranks().size());
  if (all_ranks().rank() == 0) {
    std::ifstream from(source);
    std::ofstream to(file);
    to << from.rdbuf();
    for (const std::string kind : {"momentum", "unexplained_impulse"})
      to << "\n[[gauge]]\nname = \"" + kind + "\"\nphase = \"solid\"\nkind = \"" + kind + "\"\n";
  }
  const std::vector<std::string> coarse{"solid.particle_spacing=0.01", "case.end_time=0.04", "output.interval=0.04",
                                        "output.gauge_interval=0.04"};
  const Case scene = read_case(all_ranks().rank() == 0 ? file : source, coarse);
  constexpr std::uint64_t middle = 10, last = 20;
  const auto advance = [](Phase& phase, std::uint64_t from, std::uint64_t to) {
    for (std::uint64_t k = from; k < to; ++k) phase.advance({k + 1, 2e-3 * static_cast<double>(k), 2e-3}, {});
  };
  Archive saved;
  NumbersRecorder uninterrupted, resumed, by_one;
  led(scene, [&](Phase& phase) {
    phase.initialise({});
    advance(phase, 0, middle);
    phase.archive(saved);
    advance(phase, middle, last);
    uninterrupted.gauges(0.0, phase.gauges());
    uninterrupted.frame(phase.frame());
  });
  const auto go_on = [&](Phase& phase, NumbersRecorder& recorder) {
    Archive stored(saved.bytes());
    phase.archive(stored);
    stored.expect_end();
    advance(phase, middle, last);
    recorder.gauges(0.0, phase.gauges());
    recorder.frame(phase.frame());
  };
  led(scene, [&](Phase& phase) { go_on(phase, resumed); });
  fs::remove(file);
  if (all_ranks().rank() > 0) return;
  go_on(*solid::make_solid(scene), by_one);
  for (NumbersRecorder* recorder : {&uninterrupted, &resumed, &by_one}) {
    const double momentum = std::abs(recorder->numbers.at("gauge momentum_y").back());
    EXPECT_GT(momentum, 0.01);
    for (const std::string axis : {"x", "y"}) {  // rounding: not to be compared
      const auto unexplained = recorder->numbers.extract("gauge unexplained_impulse_" + axis);
      EXPECT_LT(std::abs(unexplained.mapped().back()), rounding * momentum);
    }
  }
  expect_same(resumed, uninterrupted, rounding);
  expect_same(by_one, uninterrupted, rounding);
}

TEST_F(LedSoil, IsNotLedAfterAnErrorOfTheLeader) {
  if (all_ranks().rank() > 0) {  // hears of the call
    static_cast<void>(all_ranks().from_first({}));
    return;
  }
  Leader leader(all_ranks());
  EXPECT_THROW(leader.call(Call::save, []() -> void { throw DivergedError("here"); }), DivergedError);
  EXPECT_TRUE(leader.failed());
  EXPECT_THROW(leader.end(4), Error);
}

}  // namespace
}  // namespace poretwin::ranks
