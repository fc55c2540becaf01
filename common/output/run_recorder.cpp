#include "common/output/run_recorder.hpp"

#include "common/core/error.hpp"
#include "common/output/build_info.hpp"
#include "common/output/gauge_log.hpp"
#include "common/output/vtkhdf.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

namespace poretwin {
namespace {

std::filesystem::path made(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw FileError(fmt::format("{}: the folder cannot be made: {}", folder.string(), error.message()));
  return folder;
}

void write_provenance(hdf5::File& file, const Case& scene) {
  std::string overrides;
  for (const auto& assignment : scene.overrides) overrides += assignment + "\n";
  file.group("provenance");
  file.text("provenance/case", scene.text);
  file.text("provenance/overrides", overrides);
  file.text("provenance/version", version());
  file.text("provenance/build", build());
  file.text("provenance/host", host());
  file.text("provenance/start_time", time_now());
  file.flush();
}

class RunRecorder final : public Recorder {
 public:
  RunRecorder(const std::filesystem::path& out_dir, const std::string& phase, const Case& scene)
      : writer_(made(out_dir) / (phase + ".vtkhdf")), log_(out_dir / ("gauges." + phase + ".csv")) {
    write_provenance(writer_.file(), scene);
  }

  ~RunRecorder() override {
    // The CSV already holds every reading: failing here loses no data, and a destructor must not throw.
    try {
      write_gauges();
    } catch (const std::exception& error) {
      std::fprintf(stderr, "warning: the gauges were not copied into the HDF5 file: %s\n", error.what());
    }
  }

  void frame(const OutputFrame& frame) override { writer_.append(frame); }
  void gauges(double time, const std::vector<GaugeReading>& readings) override { log_.append(time, readings); }
  [[nodiscard]] std::vector<std::string> files() const override {
    return {writer_.path().string(), writer_.sidecar().string(), log_.path().string()};
  }

 private:
  void write_gauges() {
    auto& file = writer_.file();
    if (log_.series().empty()) return;
    file.group("gauges");
    for (const auto& [name, series] : log_.series()) {
      std::string group = name;
      std::replace(group.begin(), group.end(), '/', '_');
      group = "gauges/" + group;
      file.group(group);
      file.dataset(group + "/time", hdf5::Type::float64, 0, 1024).append(series.time);
      file.dataset(group + "/value", hdf5::Type::float64, 0, 1024).append(series.value);
      file.attribute(group + "/time", "unit", "s");
      file.attribute(group + "/time", "description", "Simulated time of the readings");
      file.attribute(group + "/value", "unit", series.unit);
      file.attribute(group + "/value", "description", "Readings of the gauge; NaN outside the phase");
    }
    file.flush();
  }

  VtkHdfWriter writer_;
  GaugeLog log_;
};

}  // namespace

std::unique_ptr<Recorder> make_run_recorder(const std::filesystem::path& out_dir, const std::string& phase_name,
                                            const Case& scene) {
  return std::make_unique<RunRecorder>(out_dir, phase_name, scene);
}

}  // namespace poretwin
