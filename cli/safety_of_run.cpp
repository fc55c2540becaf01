#include "cli/safety_of_run.hpp"

#include "cli/json_output.hpp"
#include "cli/run_folder.hpp"
#include "cli/script.hpp"
#include "common/case/case.hpp"
#include "common/case/identity.hpp"
#include "common/case/materials.hpp"
#include "common/core/error.hpp"
#include "common/output/frame_file.hpp"
#include "common/output/gauge_log.hpp"
#include "common/output/safety_row.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

namespace poretwin::cli {
namespace fs = std::filesystem;
namespace {

/// Times of frames count as equal if they differ by less than this fraction of the run's length.
constexpr double rounding = 1e-9;

std::string in_full(double value) { return fmt::format("{:.10g}", value); }

SafetyAtInstant instant_of(const std::string& row) {
  std::vector<std::string> cells;
  std::istringstream stream(row + ",");
  for (std::string cell; std::getline(stream, cell, ',');) cells.push_back(cell);
  if (cells.size() !=
      static_cast<std::size_t>(std::count(safety_columns, safety_columns + std::strlen(safety_columns), ',')) + 1)
    throw FileError(fmt::format("safety.csv: expected the columns {}, found the row {}", safety_columns, row));
  const auto read = [&](std::size_t k) { return cells[k].empty() ? 0.0 : std::strtod(cells[k].c_str(), nullptr); };
  return {read(1),
          read(2),
          read(3),
          read(4),
          read(5),
          cells[6],
          cells[7],
          read(8),
          read(9),
          {read(10), read(11), read(12)},
          {read(13), read(14), read(15)}};
}

/// Reads the rows of safety.csv as they are written.
class Rows {
 public:
  explicit Rows(fs::path file) : file_(std::move(file)) {}
  /// Calls found(instant) for every whole row since the last call.
  template <class Found>
  void read(const Found& found) {
    std::ifstream stream(file_, std::ios::binary);
    stream.seekg(static_cast<std::streamoff>(at_));
    for (std::string line; std::getline(stream, line) && !stream.eof();) {
      if (at_ > 0) found(instant_of(line));  // the first line names the columns
      at_ += line.size() + 1;
    }
  }

 private:
  fs::path file_;
  std::size_t at_ = 0;
};

std::string line_of(const SafetyAtInstant& instant, int dimension) {
  std::string text = fmt::format("t = {:<12} s  F = ", in_full(instant.time));
  if (std::isinf(instant.factor)) return text + fmt::format("above {:g}: nothing fails", instant.stands);
  text += instant.stands > 0.0 ? fmt::format("{:.3f} +- {:.3f}", instant.factor, instant.error)
                               : fmt::format("below {:.3g}", instant.fails);
  text += fmt::format("  {} fails", instant.soil);
  if (!instant.face.empty()) text += fmt::format(" at '{}'", instant.face);
  const auto& t = instant.towards;
  text += dimension == 2
              ? fmt::format(", {:.3g} m2 towards ({:.2f}, {:.2f})", instant.volume, t[0], t[1])
              : fmt::format(", {:.3g} m3 towards ({:.2f}, {:.2f}, {:.2f})", instant.volume, t[0], t[1], t[2]);
  const double rest = 100.0 * (1.0 - instant.share);  // percent
  return rest < 0.5 ? text : text + fmt::format("; {:.0f} % of the motion is on another side", rest);
}

/// The case of the run. Throws where the case has changed since the run, or where its frames cannot give a factor.
Case case_of(const fs::path& run, const RunRecord& record) {
  if (!fs::exists(record.case_file))
    throw FileError(
        fmt::format("{}: its case file {} is not there any more: expected it with the content that the run "
                    "had",
                    run.string(), record.case_file));
  Case scene = read_case(record.case_file, record.overrides);
  for (const auto& [name, value] : case_identity(scene)) {
    const auto was = std::ranges::find(record.identity, name, &RunIdentity::value_type::first);
    if (was != record.identity.end() && was->second != value)
      throw CaseError(fmt::format("{}: {}: the case has changed since the run: undo the change, or run it again",
                                  run.string(), record.case_file));
  }
  if (const auto lack = lacks_strength(scene))
    throw CaseError(fmt::format("{}: {}: key '{}': {}", run.string(), record.case_file, lack->first, lack->second));
  if (!scene.plates.empty())
    throw CaseError(
        fmt::format("{}: {}: key 'plate[0]': frames do not hold where plates are, without which no factor can "
                    "be found: expected loads in place of plates",
                    run.string(), record.case_file));
  for (std::size_t i = 0; i < scene.walls.size(); ++i)
    if (scene.walls[i].soil == Wall::ForSoil::rough)
      throw CaseError(
          fmt::format("{}: {}: key 'wall[{}].soil': frames do not hold the rows of soil behind rough walls, without "
                      "which no factor "
                      "can be found: expected another kind of wall; or give the case a gauge of kind "
                      "\"factor_of_safety\" and run it "
                      "again",
                      run.string(), record.case_file, i));
  return scene;
}

/// Deletes what an earlier search left in the folder.
void clear(const fs::path& out) {
  std::error_code error;
  for (const char* file :
       {"safety.csv", "gauges.csv", "gauges.solid.csv", "solid.vtkhdf", "solid.xmf", "solid.summary.json"})
    fs::remove(out / file, error);
  for (const auto& entry : fs::directory_iterator(out, error))
    if (entry.path().extension() == ".png") fs::remove(entry.path(), error);
}

Program program_of(const SafetyOfRunOptions& options, const fs::path& out, const RunRecord& record,
                   const std::vector<std::size_t>& frames) {
  Program program;
  program.name = "solid";
  program.file = options.programs / "poretwin-solid";
  program.arguments = {"--alone",
                       "--case",
                       record.case_file,
                       "--out",
                       out.string(),
                       "--safety-of",
                       (options.run / "solid.vtkhdf").string(),
                       "--tolerance",
                       fmt::format("{}", options.tolerance)};
  for (const std::size_t frame : frames)
    program.arguments.insert(program.arguments.end(), {"--frame", std::to_string(frame)});
  for (const auto& assignment : record.overrides)
    program.arguments.insert(program.arguments.end(), {"--set", assignment});
  program.environment = {{"OMP_NUM_THREADS", std::to_string(available_threads())}};
  program.log = out / "log" / "solid.log";
  return program;
}

/// Draws the soil that fails at the instant with the least factor, and the factor against time.
void draw(const SafetyOfRun& safety) {
  const SafetyAtInstant* least = safety.least();
  if (least == nullptr) return;
  const fs::path log = safety.out / "log" / "plot.log";
  bool drawn = std::isinf(least->factor) ||
               draw_pictures({safety.out.string(), "--phase", "solid", "--field", "failing_strain", "--time",
                              fmt::format("{:.17g}", least->time), "--out", safety.out.string()},
                             log) == 0;
  if (safety.instants.size() > 1)
    drawn =
        draw_pictures({safety.out.string(), "--gauge", "factor_of_safety", "--out", safety.out.string()}, log) == 0 &&
        drawn;
  if (!drawn) fmt::print(stderr, "warning: not all pictures were drawn; see {}\n", log.string());
}

}  // namespace

const SafetyAtInstant* SafetyOfRun::least() const {
  const auto found = std::ranges::min_element(instants, {}, &SafetyAtInstant::factor);
  return found == instants.end() ? nullptr : &*found;
}

bool is_run_folder(const fs::path& path) { return fs::is_directory(path) && fs::exists(path / "run.toml"); }

std::vector<std::size_t> frames_at(std::span<const double> times, const Instants& instants,
                                   const std::function<void(const std::string&)>& say) {
  const double first = times.front(), last = times.back(), slack = rounding * std::max(std::abs(last), 1e-300);
  std::set<std::size_t> frames;
  const auto take = [&](double time) {
    if (!(time >= first - slack && time <= last + slack))
      throw CaseError(
          fmt::format("--at: expected times from {} to {} s, between the run's first and last frame, found {}",
                      in_full(first), in_full(last), in_full(time)));
    const std::size_t frame = nearest_to(times, time);
    if (std::abs(times[frame] - time) > slack)
      say(fmt::format("no frame at {} s: the nearest is taken, at {} s", in_full(time), in_full(times[frame])));
    frames.insert(frame);
  };
  for (const double time : instants.at) take(time);
  if (instants.every) {
    // Where more instants than frames are asked for, several would take the same frame: the step is increased.
    const double widest = (last - first) / static_cast<double>(times.size());
    const double step = *instants.every * std::max(1.0, std::floor(widest / *instants.every));
    for (double k = std::ceil((first - slack) / step); k * step <= last + slack; k += 1.0) take(k * step);
  }
  if (instants.at.empty() && !instants.every) frames.insert(times.size() - 1);
  return {frames.begin(), frames.end()};
}

SafetyOfRun find_safety_of_run(const SafetyOfRunOptions& options) {
  const fs::path& run = options.run;
  const auto record = read_run_record(run);
  if (!record) throw FileError(fmt::format("{}: expected the folder of a run, found no run.toml in it", run.string()));
  const FileLock lock = lock_ended_run(run, "poretwin safety " + run.string());
  const Case scene = case_of(run, *record);
  const fs::path file = run / "solid.vtkhdf";
  if (!fs::exists(file))
    throw FileError(fmt::format("{}: expected the frames of the soil, found no such file: {}", file.string(),
                                record->exit ? "the run failed before its first frame" : "the run never ended"));
  const FrameFile stored(file);
  if (stored.times().empty())
    throw FileError(
        fmt::format("{}: expected frames of the soil, found none: the run ended before its first", file.string()));
  SafetyOfRun safety;
  safety.case_name = record->case_name;
  safety.case_file = record->case_file;
  safety.out = options.out.empty() ? run / safety_folder : options.out;
  const auto frames = frames_at(stored.times(), options.instants,
                                [](const std::string& line) { fmt::print(stderr, "poretwin: {}\n", line); });
  if (is_run_folder(safety.out))
    throw FileError(
        fmt::format("{}: expected a folder that is not a run's; choose another --out", safety.out.string()));
  const FileLock own = lock_folder(safety.out, "poretwin safety " + run.string());
  clear(safety.out);
  std::error_code error;
  fs::create_directories(safety.out / "log", error);
  if (error) throw FileError(fmt::format("{}: the folder cannot be made: {}", safety.out.string(), error.message()));
  const auto start = std::chrono::steady_clock::now();
  Rows rows(safety.out / "safety.csv");
  const auto read = [&] {
    rows.read([&](const SafetyAtInstant& instant) {
      safety.instants.push_back(instant);
      if (!options.quiet) fmt::print("{}\n", line_of(instant, scene.general.dimension));
      std::fflush(stdout);
    });
  };
  const Watched watched = run_together(
      {program_of(options, safety.out, *record, frames)}, [](const std::string&) {}, [&](bool) { read(); });
  read();
  safety.wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  for (const auto& ended : watched.ended) safety.cpu += ended.cpu;
  if (const Ended* cause = root_cause(watched.ended)) {
    const bool stopped = watched.interrupted || cause->status == static_cast<int>(ExitCode::interrupted);
    safety.exit = stopped              ? static_cast<int>(ExitCode::interrupted)
                  : cause->signal != 0 ? static_cast<int>(ExitCode::failure)
                                       : cause->status;
    safety.reason = stopped ? "interrupted; the factors found so far are in safety.csv" : reason_of(*cause);
  }
  merge_gauges({safety.out / "gauges.solid.csv"}, safety.out / "gauges.csv");
  if (options.pictures && safety.exit == 0) draw(safety);
  return safety;
}

std::string safety_of_run_text(const SafetyOfRun& safety) {
  const SafetyAtInstant* least = safety.least();
  if (least == nullptr) return {};
  const std::string factor = std::isinf(least->factor) ? fmt::format("above {:g}", least->stands)
                             : least->stands > 0.0     ? fmt::format("{:.3f}", least->factor)
                                                       : fmt::format("below {:.3g}", least->fails);
  return fmt::format(
      "least factor of safety {} at t = {} s (stands at {:.3f}, fails at {:.3f}); {} instant{}, "
      "{:.2f} s wall, {:.2f} s cpu; {}\n",
      factor, in_full(least->time), least->stands, least->fails, safety.instants.size(),
      safety.instants.size() == 1 ? "" : "s", safety.wall, safety.cpu, (safety.out / "safety.csv").string());
}

nlohmann::ordered_json safety_of_run_json(const SafetyOfRunOptions& options, const SafetyOfRun& safety) {
  Json json = json_head("safety", safety.exit, safety.exit == 0 ? "end" : safety.reason);
  json["run"] = options.run.string();
  json["case"] = safety.case_name;
  json["case_file"] = safety.case_file;
  json["out"] = safety.out.string();
  json["wall_s"] = safety.wall;
  json["cpu_s"] = safety.cpu;
  json["tolerance"] = options.tolerance;
  json["instants"] = Json::array();
  for (const auto& instant : safety.instants) {
    Json one{{"time_s", instant.time},   {"factor", json_number(instant.factor)}, {"error", json_number(instant.error)},
             {"stands", instant.stands}, {"fails", json_number(instant.fails)},   {"failing", nullptr}};
    if (!instant.soil.empty())
      one["failing"] = {
          {"soil", instant.soil},       {"face", instant.face.empty() ? Json(nullptr) : Json(instant.face)},
          {"share", instant.share},     {"volume", instant.volume},
          {"centre_m", instant.centre}, {"towards", instant.towards}};
    json["instants"].push_back(std::move(one));
  }
  return json;
}

}  // namespace poretwin::cli
