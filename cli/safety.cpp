#include "cli/safety.hpp"

#include "cli/json_output.hpp"
#include "cli/run_folder.hpp"
#include "cli/script.hpp"
#include "cli/text_file.hpp"
#include "common/case/case.hpp"
#include "common/case/materials.hpp"
#include "common/core/error.hpp"
#include "common/numerics/border.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

namespace poretwin::cli {
namespace fs = std::filesystem;
namespace {

constexpr double largest_factor = 100.0;

class Search {
 public:
  Search(const RunOptions& options, double tolerance) : options_(options), tolerance_(tolerance) {}

  Safety run() {
    BorderSearch search;
    search.largest = largest_factor;
    search.tolerance = tolerance_;
    const auto border = find_border(search, [this](double factor) { return stands(factor); });
    Safety& s = safety_;
    if (border) {
      s.stands = border->stands;
      s.fails = border->fails;
      if (std::isinf(s.fails))
        throw CaseError(fmt::format("{}: the soil stands with its strength divided by {}: expected one that fails",
                                    options_.case_file.string(), s.stands));
      if (s.stands == 0.0)
        throw CaseError(fmt::format("{}: the soil fails with its strength multiplied by {}: expected one that stands",
                                    options_.case_file.string(), 1.0 / s.fails));
      s.failing = folder(s.fails);
    }
    std::sort(s.trials.begin(), s.trials.end(), [](const auto& a, const auto& b) { return a.factor < b.factor; });
    if (good()) s.run.exit = 0;
    return std::move(safety_);
  }

 private:
  [[nodiscard]] bool good() const { return safety_.run.ended_well(); }
  [[nodiscard]] fs::path folder(double factor) const { return options_.out / fmt::format("F_{:.4f}", factor); }

  /// Whether the soil stands. Empty where the run gave no answer: it was interrupted, or failed for another reason.
  std::optional<bool> stands(double factor) {
    RunOptions options = options_;
    options.out = folder(factor);
    options.overrides.push_back(fmt::format("solid.strength_reduction={:.17g}", factor));
    options.overrides.emplace_back("solid.initial_rest=true");
    options.overrides.emplace_back("solid.initial_seepage=true");
    options.overrides.emplace_back("case.end_time=1e-9");  // only the initial search for equilibrium is needed
    options.quiet = true;
    options.warnings = false;  // here, soil without equilibrium is a result, not a warning
    options.pictures = false;
    options.restarts = 0;
    options.overwrite = true;
    const RunResult result = run_case(options);
    const double wall = safety_.run.wall + result.wall, cpu = safety_.run.cpu + result.cpu;
    safety_.run = result;
    safety_.run.wall = wall;
    safety_.run.cpu = cpu;
    SafetyTrial trial;
    trial.factor = factor;
    bool searched = false;  // the soil has gone on to the window after the search
    for (const auto& summary : result.summaries)
      for (const auto& [name, value] : summary.counters) {
        if (summary.process != "solid") continue;
        if (name == "rest steps") trial.steps = value;
        if (name == "rest residual") trial.residual = value;
        if (name == "rest found") trial.stands = value == 1.0;
        if (name == "end_time_s") searched = value > 0.0;
        if (name == "rest displacement") trial.displacement = value;
      }
    // Soil that found no rest may not survive the window after the search, either, whose shortness makes its velocities
    // unbounded: the search has given the answer.
    if (searched && !trial.stands && result.exit != static_cast<int>(ExitCode::interrupted)) safety_.run.exit = 0;
    trial.stands = trial.stands && good();
    safety_.trials.push_back(trial);
    if (!options_.quiet && good())
      fmt::print("F = {:<8.4f} {}  {:>6} steps, residual {:.2g}, largest displacement {:.4g} m\n", factor,
                 trial.stands ? "stands" : "fails ", trial.steps, trial.residual, trial.displacement);
    std::fflush(stdout);
    if (!good()) return {};
    return trial.stands;
  }

  const RunOptions& options_;
  double tolerance_;
  Safety safety_;
};

std::string listed(const std::vector<SafetyTrial>& trials) {
  std::string text =
      "# Strength divided by the factor: does the soil come to rest?\nfactor,stands,steps,residual,displacement_m\n";
  for (const auto& t : trials)
    text += fmt::format("{:.6g},{},{:.0f},{:.4g},{:.6g}\n", t.factor, t.stands ? 1 : 0, t.steps, t.residual,
                        t.displacement);
  return text;
}

/// Names of the parts of the case that the search for equilibrium at time zero does not use.
std::string ignored(const Case& scene, const RunOptions& options) {
  std::string text;
  const auto add = [&](const std::string& key) { text += (text.empty() ? "" : ", ") + key; };
  for (const auto& assignment : options.overrides)
    if (assignment.starts_with("case.end_time=") || assignment.starts_with("output.") ||
        assignment.starts_with("solid.strength_reduction=") || assignment.starts_with("solid.initial_rest=") ||
        assignment.starts_with("solid.initial_seepage="))
      add("--set " + assignment);
  const auto changes = [&](const std::optional<Series>& series, const std::string& key) {
    if (series && series->knots.size() > 1) add(key + " after time zero");
  };
  for (std::size_t i = 0; i < scene.water_faces.size(); ++i) {
    const auto& f = scene.water_faces[i];
    changes(f.head, fmt::format("water_face[{}].head", i));
    changes(f.pressure, fmt::format("water_face[{}].pressure", i));
    if (f.discharge) add(fmt::format("water_face[{}].discharge", i));
  }
  for (std::size_t i = 0; i < scene.pore_pressures.size(); ++i) {
    const auto& p = scene.pore_pressures[i];
    changes(p.head, fmt::format("pore_pressure[{}].head", i));
    changes(p.pressure, fmt::format("pore_pressure[{}].pressure", i));
    changes(p.to_head, fmt::format("pore_pressure[{}].to_head", i));
  }
  for (std::size_t i = 0; i < scene.loads.size(); ++i)
    if (scene.loads[i].start) add(fmt::format("load[{}] (it has a start)", i));
  for (std::size_t i = 0; i < scene.plates.size(); ++i) {
    const Plate& plate = scene.plates[i];
    if (plate.start) add(fmt::format("plate[{}] (it has a start)", i));
    for (const auto* series : {&plate.displacement, &plate.speed, &plate.along, &plate.force})
      changes(*series, fmt::format("plate[{}]", i));
  }
  return text;
}

/// Removes the trials of an earlier search, so that they do not mix with those of this one.
void clear_trials(const fs::path& out) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(out, error))
    if (entry.path().filename().string().starts_with("F_") && fs::exists(entry.path() / "run.toml"))
      fs::remove_all(entry.path(), error);
}

}  // namespace

Safety find_safety(const RunOptions& options, double tolerance) {
  const Case scene = read_case(options.case_file, options.overrides);
  if (const auto lack = lacks_strength(scene))
    throw CaseError(fmt::format("{}: key '{}': {}", options.case_file.string(), lack->first, lack->second));
  for (const auto& warning : scene.warnings) fmt::print(stderr, "warning: {}\n", warning);
  if (const auto keys = ignored(scene, options); !keys.empty())
    fmt::print(stderr, "warning: a factor of safety is that of the rest at time zero; without effect: {}\n", keys);
  const FileLock lock = lock_folder(options.out, "poretwin safety " + options.case_name);
  clear_trials(options.out);
  Safety safety = Search(options, tolerance).run();
  if (safety.run.exit != 0) return safety;
  write_file(options.out / "safety.csv", listed(safety.trials));
  write_file(options.out / "gauges.csv",
             fmt::format("time_s,gauge,value,unit\n0,factor_of_safety,{:.6g},1\n", safety.factor()));
  if (options.pictures) {
    const fs::path log = options.out / "plot.log";
    if (draw_pictures({safety.failing.string(), "--phase", "solid", "--field", "accumulated_plastic_strain", "--out",
                       options.out.string()},
                      log) != 0)
      fmt::print(stderr, "warning: no picture was drawn; see {}\n", log.string());
  }
  return safety;
}

std::string safety_text(const Safety& safety) {
  return fmt::format(
      "factor of safety {:.3f} (stands at {:.3f}, fails at {:.3f}); {} trials, {:.2f} s wall, {:.2f} s cpu\n",
      safety.factor(), safety.stands, safety.fails, safety.trials.size(), safety.run.wall, safety.run.cpu);
}

nlohmann::ordered_json safety_json(const RunOptions& options, double tolerance, const Safety& safety) {
  const bool found = safety.run.exit == 0;
  Json json = json_head("safety", safety.run.exit, found ? "end" : safety.run.reason);
  json["case"] = options.case_name;
  json["case_file"] = options.case_file.string();
  json["out"] = options.out.string();
  json["wall_s"] = safety.run.wall;
  json["cpu_s"] = safety.run.cpu;
  json["tolerance"] = tolerance;
  json["factor"] = found ? Json(safety.factor()) : Json(nullptr);
  json["stands"] = found ? Json(safety.stands) : Json(nullptr);
  json["fails"] = found ? Json(safety.fails) : Json(nullptr);
  json["failing_run"] = found ? Json(safety.failing.string()) : Json(nullptr);
  json["trials"] = Json::array();
  for (const auto& t : safety.trials)
    json["trials"].push_back({{"factor", t.factor},
                              {"stands", t.stands},
                              {"steps", json_number(t.steps)},
                              {"residual", json_number(t.residual)},
                              {"displacement_m", json_number(t.displacement)}});
  return json;
}

}  // namespace poretwin::cli
