#include "common/output/run_recorder.hpp"

#include "common/core/error.hpp"
#include "common/output/build_info.hpp"
#include "common/output/gauge_log.hpp"
#include "common/output/vtkhdf.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <optional>

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

/// Makes what was written to the file survive a loss of power.
void sync(const std::filesystem::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool good = descriptor >= 0 && ::fsync(descriptor) == 0;
  const int error = errno;
  if (descriptor >= 0) ::close(descriptor);
  if (!good) throw FileError(fmt::format("{}: cannot be written: {}", path.string(), std::strerror(error)));
}

class RunRecorder final : public Recorder {
 public:
  RunRecorder(const std::filesystem::path& out_dir, const std::string& phase, const Case& scene, bool to_resume)
      : particles_(made(out_dir) / (phase + ".vtkhdf")),
        gauges_(out_dir / ("gauges." + phase + ".csv")),
        scene_(scene) {
    if (!to_resume) begin();
  }

  ~RunRecorder() override {
    // The CSV already contains every reading, so that a failure here loses no data; and a destructor must not throw.
    try {
      if (writer_) write_gauges();
    } catch (const std::exception& error) {
      std::fprintf(stderr, "warning: the gauges were not copied into the HDF5 file: %s\n", error.what());
    }
  }

  void frame(const OutputFrame& frame) override {
    begin();
    const Point3& origin = scene_.general.origin;
    if (origin.isZero()) return writer_->append(frame);
    OutputFrame moved = frame;
    moved.position = [&](std::size_t i, double* x) {
      frame.position(i, x);
      for (int d = 0; d < 3; ++d) x[d] += origin[d];
    };
    writer_->append(moved);
  }
  void gauges(double time, const std::vector<GaugeReading>& readings) override {
    begin();
    log_->append(time, readings);
  }
  void archive(Archive& archive) override {
    if (archive.loading()) {
      writer_.emplace(particles_, archive);
      log_.emplace(gauges_, archive);
      if (writer_->file().has("gauges")) writer_->file().remove("gauges");
      return;
    }
    begin();
    archive(*writer_, *log_);
    sync(particles_);
    sync(gauges_);
  }
  [[nodiscard]] std::vector<std::string> files() const override {
    if (!writer_) return {};
    return {particles_.string(), writer_->sidecar().string(), gauges_.string()};
  }

 private:
  void begin() {
    if (writer_) return;
    writer_.emplace(particles_);
    log_.emplace(gauges_);
    write_provenance(writer_->file(), scene_);
  }
  void write_gauges() {
    auto& file = writer_->file();
    if (log_->series().empty()) return;
    file.group("gauges");
    for (const auto& [name, series] : log_->series()) {
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

  std::filesystem::path particles_, gauges_;
  Case scene_;
  std::optional<VtkHdfWriter> writer_;
  std::optional<GaugeLog> log_;
};

}  // namespace

std::unique_ptr<Recorder> make_run_recorder(const std::filesystem::path& out_dir, const std::string& phase_name,
                                            const Case& scene, bool to_resume) {
  return std::make_unique<RunRecorder>(out_dir, phase_name, scene, to_resume);
}

}  // namespace poretwin
