// Every step read back through its offsets, as ParaView's VTKHDF reader does, equals what was written.
#include "common/core/error.hpp"
#include "common/output/gauge_log.hpp"
#include "common/output/run_recorder.hpp"
#include "common/output/undo_driver.hpp"
#include "common/output/vtkhdf.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

namespace poretwin {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class Output : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("poretwin-output-" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path folder_;
};

/// A frame of n particles whose numbers identify step, particle and component.
OutputFrame frame_of(std::size_t n, double time) {
  OutputFrame frame;
  frame.time = time;
  frame.count = n;
  const auto base = [time](std::size_t i) { return 1000.0 * time + static_cast<double>(i) + 1.0 / 3.0; };
  frame.position = [base](std::size_t i, double* x) {
    x[0] = base(i);
    x[1] = -base(i);
    x[2] = 0.0;
  };
  frame.fields = {{{"pore_pressure", "Pa", "Pressure of the water", 1}, {}},
                  {{"velocity", "m/s", "Velocity", 3}, {}},
                  {{"effective_stress", "Pa", "Effective stress, compression negative", 6}, {}}};
  for (auto& field : frame.fields)
    field.write = [base, components = field.components](std::size_t i, double* numbers) {
      for (int c = 0; c < components; ++c) numbers[c] = base(i) * (1.0 + c) + 1e-13 * c;
    };
  return frame;
}

/// The numbers of all particles in one array.
std::vector<double> values_of(const OutputFrame& frame, int components, const ParticleWriter& write) {
  const auto each = static_cast<std::size_t>(components);
  std::vector<double> numbers(frame.count * each);
  for (std::size_t i = 0; i < frame.count; ++i) write(i, &numbers[i * each]);
  return numbers;
}

template <class T>
std::vector<T> rows(const std::vector<T>& all, std::int64_t first, std::int64_t count, std::int64_t columns) {
  return {all.begin() + first * columns, all.begin() + (first + count) * columns};
}

void expect_steps(const std::filesystem::path& path, const std::vector<OutputFrame>& frames) {
  const auto file = hdf5::File::open_to_read(path);
  const std::string top = "VTKHDF/", steps = top + "Steps/";
  EXPECT_EQ(file.attribute_text("VTKHDF", "Type"), "UnstructuredGrid");
  EXPECT_THAT(file.attribute_integers("VTKHDF", "Version"), ElementsAre(2, 0));
  ASSERT_THAT(file.attribute_integers("VTKHDF/Steps", "NSteps"), ElementsAre(static_cast<std::int64_t>(frames.size())));
  EXPECT_TRUE(file.is_float64(top + "Points"));
  EXPECT_EQ(file.shape(steps + "CellOffsets"), (std::vector<std::size_t>{frames.size(), 1}));
  EXPECT_EQ(file.shape(steps + "ConnectivityIdOffsets"), (std::vector<std::size_t>{frames.size(), 1}));
  const auto part_offsets = file.read_integers(steps + "PartOffsets");
  const auto point_offsets = file.read_integers(steps + "PointOffsets");
  const auto cell_offsets = file.read_integers(steps + "CellOffsets");
  const auto id_offsets = file.read_integers(steps + "ConnectivityIdOffsets");
  const auto times = file.read_numbers(steps + "Values");
  for (std::size_t s = 0; s < frames.size(); ++s) {
    SCOPED_TRACE(s);
    const auto part = static_cast<std::size_t>(part_offsets[s]);
    EXPECT_EQ(file.read_integers(steps + "NumberOfParts")[s], 1);
    const auto points = file.read_integers(top + "NumberOfPoints")[part];
    const auto cells = file.read_integers(top + "NumberOfCells")[part];
    const auto ids = file.read_integers(top + "NumberOfConnectivityIds")[part];
    ASSERT_EQ(points, static_cast<std::int64_t>(frames[s].count));
    ASSERT_EQ(cells, points);
    ASSERT_EQ(ids, points);
    EXPECT_EQ(times[s], frames[s].time);
    EXPECT_EQ(rows(file.read_numbers(top + "Points"), point_offsets[s], points, 3),
              values_of(frames[s], 3, frames[s].position));
    EXPECT_THAT(rows(file.read_integers(top + "Types"), cell_offsets[s], cells, 1), testing::Each(1));
    // The reader's rule: a step's row of `Offsets` starts at its cell offset, plus one for each part before it.
    const auto offsets = rows(file.read_integers(top + "Offsets"), cell_offsets[s] + part_offsets[s], cells + 1, 1);
    const auto connectivity = rows(file.read_integers(top + "Connectivity"), id_offsets[s], ids, 1);
    for (std::int64_t i = 0; i <= cells; ++i) EXPECT_EQ(offsets[static_cast<std::size_t>(i)], i);
    for (std::int64_t i = 0; i < ids; ++i) EXPECT_EQ(connectivity[static_cast<std::size_t>(i)], i);
    for (const auto& field : frames[s].fields) {
      const auto offset = file.read_integers(steps + "PointDataOffsets/" + field.name)[s];
      EXPECT_EQ(rows(file.read_numbers(top + "PointData/" + field.name), offset, points, field.components),
                values_of(frames[s], field.components, field.write));
    }
  }
}

TEST_F(Output, StepsReadBackAsWrittenWithAnEmptyFirstStepAndChangingCounts) {
  const std::vector<OutputFrame> frames{frame_of(0, 0.0), frame_of(3, 0.1), frame_of(5, 0.2), frame_of(0, 0.3),
                                        frame_of(2, 0.4)};
  {
    VtkHdfWriter writer(folder_ / "fluid.vtkhdf");
    for (const auto& frame : frames) writer.append(frame);
  }
  expect_steps(folder_ / "fluid.vtkhdf", frames);
}

TEST_F(Output, EarlierStepsAreReadableWhileTheRunGoesOn) {
  std::vector<OutputFrame> frames;
  VtkHdfWriter writer(folder_ / "solid.vtkhdf");
  for (int s = 0; s < 3; ++s) {
    frames.push_back(frame_of(4, s));
    writer.append(frames.back());
    // A copy of the bytes is what a crash would leave.
    std::filesystem::copy_file(folder_ / "solid.vtkhdf", folder_ / "copy.vtkhdf",
                               std::filesystem::copy_options::overwrite_existing);
    expect_steps(folder_ / "copy.vtkhdf", frames);
  }
}

TEST_F(Output, SidecarOfManyStepsIsCompleteAtTheEnd) {
  const auto steps = [&] {
    std::ostringstream text;
    text << std::ifstream(folder_ / "many.xmf").rdbuf();
    std::size_t count = 0;
    for (std::size_t at = 0; (at = text.str().find("<Time", at)) != std::string::npos; ++at) ++count;
    return count;
  };
  {
    VtkHdfWriter writer(folder_ / "many.vtkhdf");
    for (int k = 0; k < 210; ++k) {
      writer.append(frame_of(1, k));
      if (k == 50) {
        EXPECT_EQ(steps(), 51u);
      }
    }
    EXPECT_GE(steps(), 197u);
    EXPECT_LT(steps(), 210u);
  }
  EXPECT_EQ(steps(), 210u);
}

TEST_F(Output, FieldsCarryTheirMeaning) {
  VtkHdfWriter(folder_ / "a.vtkhdf").append(frame_of(2, 0.0));
  const auto file = hdf5::File::open_to_read(folder_ / "a.vtkhdf");
  EXPECT_EQ(file.attribute_text("VTKHDF/PointData/effective_stress", "unit"), "Pa");
  EXPECT_EQ(file.attribute_text("VTKHDF/PointData/effective_stress", "components"), "xx yy zz xy yz xz");
  EXPECT_THAT(file.attribute_text("VTKHDF/PointData/effective_stress", "description"),
              HasSubstr("compression negative"));
  EXPECT_EQ(file.shape("VTKHDF/PointData/effective_stress"), (std::vector<std::size_t>{2, 6}));
}

TEST_F(Output, SidecarNamesEverySlab) {
  VtkHdfWriter writer(folder_ / "a.vtkhdf");
  writer.append(frame_of(3, 0.0));
  writer.append(frame_of(0, 0.25));
  writer.append(frame_of(2, 0.5));
  std::ostringstream text;
  text << std::ifstream(folder_ / "a.xmf").rdbuf();
  EXPECT_THAT(text.str(), HasSubstr("CollectionType=\"Temporal\""));
  EXPECT_THAT(text.str(), HasSubstr("<Time Value=\"0.25\"/>"));
  EXPECT_THAT(text.str(), HasSubstr("Dimensions=\"0 3\" NumberType=\"Float\" Precision=\"8\" Format=\"XML\">\n"));
  EXPECT_THAT(text.str(), HasSubstr("<Time Value=\"0.5\"/>"));
  EXPECT_THAT(text.str(), HasSubstr("Format=\"HDF\">a.vtkhdf:/VTKHDF/Points|3 0:1 1:2 3:5 3\n"));
  EXPECT_THAT(text.str(), HasSubstr("<DataItem Dimensions=\"3 2\" Format=\"XML\">3 0 1 1 2 3</DataItem>"));
  EXPECT_THAT(
      text.str(),
      HasSubstr(
          "<DataItem Dimensions=\"5 3\" NumberType=\"Float\" Precision=\"8\" Format=\"HDF\">a.vtkhdf:/VTKHDF/Points"));
}

TEST_F(Output, MisfitFramesAndPathsAreNamed) {
  VtkHdfWriter writer(folder_ / "a.vtkhdf");
  writer.append(frame_of(3, 0.0));
  auto wrong = frame_of(3, 0.1);
  wrong.fields[1].components = 6;
  EXPECT_THROW(writer.append(wrong), FileError);
  wrong.fields.pop_back();
  EXPECT_THROW(writer.append(wrong), FileError);
  auto dotted = frame_of(1, 0.0);
  dotted.fields[0].name = "a.b";
  EXPECT_THROW(VtkHdfWriter(folder_ / "b.vtkhdf").append(dotted), FileError);
  try {
    VtkHdfWriter nowhere(folder_ / "absent" / "c.vtkhdf");
    FAIL();
  } catch (const FileError& error) {
    EXPECT_THAT(error.what(), HasSubstr("absent/c.vtkhdf: creating failed"));
    EXPECT_THAT(error.what(), HasSubstr("No such file or directory"));
  }
}

TEST_F(Output, GaugesKeepEveryDigitAndMergeByTime) {
  const double third = 1.0 / 3.0;
  {
    GaugeLog fluid(folder_ / "gauges.fluid.csv"), solid(folder_ / "gauges.solid.csv");
    fluid.append(0.0, {{"p, base", third, "Pa"}});
    fluid.append(0.2, {{"p, base", std::nan(""), "Pa"}});
    solid.append(0.1, {{"u", -1e-300, "m"}});
  }
  merge_gauges({folder_ / "gauges.fluid.csv", folder_ / "absent.csv", folder_ / "gauges.solid.csv"},
               folder_ / "gauges.csv");
  std::ostringstream text;
  text << std::ifstream(folder_ / "gauges.csv").rdbuf();
  EXPECT_EQ(text.str(),
            "time_s,gauge,value,unit\n0,\"p, base\",0.33333333333333331,Pa\n0.10000000000000001,u,-1e-300,m\n"
            "0.20000000000000001,\"p, base\",nan,Pa\n");
  const auto series = read_gauges(folder_ / "gauges.csv");
  EXPECT_EQ(series.at("p, base").value[0], third);
  EXPECT_TRUE(std::isnan(series.at("p, base").value[1]));
  EXPECT_EQ(series.at("u").unit, "m");
}

TEST_F(Output, RunRecorderLeavesProvenanceAndGauges) {
  Case scene;
  scene.text = "[case]\n# text as read\n";
  scene.overrides = {"a.b=1"};
  {
    auto recorder = make_run_recorder(folder_ / "new" / "run", "fluid", scene);
    recorder->frame(frame_of(2, 0.0));
    recorder->gauges(0.0, {{"front", 0.25, "m"}});
    recorder->gauges(0.5, {{"front", 0.75, "m"}});
    EXPECT_EQ(recorder->files().size(), 3u);
    for (const auto& path : recorder->files()) EXPECT_TRUE(std::filesystem::exists(path)) << path;
  }
  const auto file = hdf5::File::open_to_read(folder_ / "new" / "run" / "fluid.vtkhdf");
  EXPECT_EQ(file.read_text("provenance/case"), scene.text);
  EXPECT_EQ(file.read_text("provenance/overrides"), "a.b=1\n");
  EXPECT_THAT(file.names("provenance"), ElementsAre("build", "case", "host", "overrides", "start_time", "version"));
  EXPECT_THAT(file.read_numbers("gauges/front/value"), ElementsAre(0.25, 0.75));
  EXPECT_EQ(file.attribute_text("gauges/front/value", "unit"), "m");
}

/// A process may die at any moment, also within a frame: the file returns to its last complete frame.
TEST_F(Output, AKilledWriterLosesAtMostTheFrameItWrote) {
  const auto path = folder_ / "killed.vtkhdf";
  std::mt19937 random(1);
  int in_the_middle = 0;
  for (int kill = 0; kill < 40; ++kill) {
    const pid_t writer = ::fork();
    if (writer == 0) {
      VtkHdfWriter file(path);
      for (int k = 0;; ++k) file.append(frame_of(700 + 13 * static_cast<std::size_t>(k % 7), k));
    }
    const auto steps = [&] {
      std::error_code none;
      return std::filesystem::file_size(folder_ / "killed.xmf", none);
    };
    while (static_cast<std::intmax_t>(steps()) <= 1000) ::usleep(200);
    ::usleep(std::uniform_int_distribution<useconds_t>(0, 20'000)(random));
    ::kill(writer, SIGKILL);
    ::waitpid(writer, nullptr, 0);
    if (std::filesystem::file_size(path.string() + ".undo") > 0) ++in_the_middle;
    hdf5::roll_back(path);
    EXPECT_FALSE(std::filesystem::exists(path.string() + ".undo"));
    const auto count = hdf5::File::open_to_read(path).attribute_integers("VTKHDF/Steps", "NSteps").front();
    ASSERT_GE(count, 1);
    std::vector<OutputFrame> frames;
    for (int k = 0; k < count; ++k) frames.push_back(frame_of(700 + 13 * static_cast<std::size_t>(k % 7), k));
    expect_steps(path, frames);
    std::filesystem::remove(folder_ / "killed.xmf");
  }
  EXPECT_GT(in_the_middle, 5) << "hardly any of the kills hit a frame: they tell nothing";
}

/// Readers of a growing file distinguish its states by their stamps, however fast they follow (docs/view.md).
TEST_F(Output, EveryFlushHasAStampOfItsOwn) {
  const auto path = folder_ / "stamped.vtkhdf";
  VtkHdfWriter file(path);
  auto last = std::filesystem::last_write_time(path.string() + ".undo");
  for (int k = 0; k < 30; ++k) {
    file.append(frame_of(2, k));
    EXPECT_EQ(std::filesystem::file_size(path.string() + ".undo"), 0u);
    const auto stamp = std::filesystem::last_write_time(path.string() + ".undo");
    EXPECT_GT(stamp, last) << k;
    last = stamp;
  }
}

/// Wherever the disk becomes full, the writer reports it, closes the file, and its process ends normally. (The HDF5
/// library, if it knew of the failed write, would crash at the end of the process.)
TEST_F(Output, AFullDiskIsNamedAndTheProcessEndsWell) {
  const auto path = folder_ / "full.vtkhdf";
  int complaints = 0;
  for (rlim_t room = 2'000; room < 160'000; room += 2'000) {
    const pid_t child = ::fork();
    if (child == 0) {
      std::signal(SIGXFSZ, SIG_IGN);
      const rlimit limit{room, RLIM_INFINITY};
      ::setrlimit(RLIMIT_FSIZE, &limit);
      int code = 0;
      try {
        VtkHdfWriter writer(path);
        for (int k = 0; k < 12; ++k) writer.append(frame_of(300, 0.5 * k));
      } catch (const FileError& error) {
        code = std::string(error.what()).find("cannot be written: File too large") != std::string::npos ? 5 : 6;
      }
      std::exit(code);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    ASSERT_TRUE(WIFEXITED(status)) << "signal " << WTERMSIG(status) << " with room for " << room << " bytes";
    if (WEXITSTATUS(status) == 0) break;
    EXPECT_EQ(WEXITSTATUS(status), 5) << room;
    ++complaints;
    hdf5::roll_back(path);
    // The side-car is written with the first frame: without it the file has none.
    if (!std::filesystem::remove(folder_ / "full.xmf")) continue;
    const auto file = hdf5::File::open_to_read(path);
    const auto steps = file.read_numbers("VTKHDF/Steps/Values");
    EXPECT_EQ(file.attribute_integers("VTKHDF/Steps", "NSteps"), std::vector<std::int64_t>{std::ssize(steps)});
    EXPECT_EQ(file.shape("VTKHDF/Points").front(), 300 * steps.size());
    for (std::size_t k = 0; k < steps.size(); ++k) EXPECT_EQ(steps[k], 0.5 * static_cast<double>(k));
  }
  EXPECT_GT(complaints, 10);
}

/// From a checkpoint on the record is written again, with the same result whatever had been written after it.
TEST_F(Output, ARecordGoesOnFromItsCheckpoint) {
  Case scene;
  scene.text = "[case]\n";
  const auto reading = [](double t) { return std::vector<GaugeReading>{{"front", t / 3.0, "m"}}; };
  const auto write = [&](Recorder& recorder, int from, int to) {
    for (int k = from; k < to; ++k) {
      recorder.frame(frame_of(3 + static_cast<std::size_t>(k), k));
      recorder.gauges(k, reading(k));
    }
  };
  write(*make_run_recorder(folder_ / "whole", "fluid", scene), 0, 6);
  Archive out;
  {
    auto recorder = make_run_recorder(folder_ / "cut", "fluid", scene);
    write(*recorder, 0, 3);
    recorder->archive(out);
    write(*recorder, 7, 12);
  }
  {
    auto recorder = make_run_recorder(folder_ / "cut", "fluid", scene, true);
    Archive in(out.bytes());
    recorder->archive(in);
    in.expect_end();
    write(*recorder, 3, 6);
  }
  std::vector<OutputFrame> frames;
  for (int k = 0; k < 6; ++k) frames.push_back(frame_of(3 + static_cast<std::size_t>(k), k));
  expect_steps(folder_ / "cut" / "fluid.vtkhdf", frames);
  const auto text = [&](const char* run, const char* file) {
    std::stringstream all;
    all << std::ifstream(folder_ / run / file).rdbuf();
    return all.str();
  };
  EXPECT_EQ(text("cut", "gauges.fluid.csv"), text("whole", "gauges.fluid.csv"));
  EXPECT_EQ(text("cut", "fluid.xmf"), text("whole", "fluid.xmf"));
  const auto file = hdf5::File::open_to_read(folder_ / "cut" / "fluid.vtkhdf");
  EXPECT_THAT(file.read_numbers("gauges/front/time"), ElementsAre(0.0, 1.0, 2.0, 3.0, 4.0, 5.0));
}

TEST_F(Output, ARecordShorterThanItsCheckpointIsRefused) {
  Case scene;
  Archive out;
  {
    auto recorder = make_run_recorder(folder_ / "run", "fluid", scene);
    recorder->frame(frame_of(3, 0.0));
    recorder->gauges(0.0, {{"front", 1.0, "m"}});
    recorder->archive(out);
  }
  std::ofstream(folder_ / "run" / "gauges.fluid.csv") << "time_s\n";
  Archive in(out.bytes());
  EXPECT_THROW(make_run_recorder(folder_ / "run", "fluid", scene, true)->archive(in), FileError);
}

}  // namespace
}  // namespace poretwin
