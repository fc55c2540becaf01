#include "cli/verify.hpp"

#include "cli/locate.hpp"
#include "cli/metrics.hpp"
#include "cli/run.hpp"
#include "cli/safety.hpp"
#include "cli/script.hpp"
#include "common/core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

namespace poretwin::cli {
namespace fs = std::filesystem;
namespace {

constexpr int interrupted = static_cast<int>(ExitCode::interrupted);

struct CaseVerdict {
  Json json;
  bool passed = true, stopped = false;
};

/// Verifies one case with all its runs.
class CaseCheck {
 public:
  CaseCheck(const VerifyOptions& options, const CasePlace& place) : options_(options), place_(place) {
    json_ = {{"case", place.name},
             {"folder", place.folder().string()},
             {"source", ""},
             {"passed", true},
             {"wall_s", 0.0},
             {"cpu_s", 0.0},
             {"steps", Json::object()},
             {"particles", Json::object()},
             {"runs", Json::array()},
             {"metrics", Json::array()}};
  }

  CaseVerdict verdict() {
    const VerifyFile file = read_verify(place_.folder() / "verify.toml");
    json_["source"] = file.source;
    bool found = options_.run.empty();
    for (const auto& run : file.runs) {
      if (options_.short_runs && run.when == "full") continue;
      if (!options_.run.empty() && run.name != options_.run) continue;
      found = true;
      execute(file, run);
      if (stopped_) break;
    }
    if (!found) throw CaseError(fmt::format("{}: there is no run '{}'", place_.name, options_.run));
    if (file.wall && wall_ > *file.wall) {
      Metric metric;
      metric.name = "wall-clock time";
      metric.unit = "s";
      Verdict late;
      late.value = wall_;
      late.reference = *file.wall;
      late.error = wall_ - *file.wall;
      late.complaint = "took too long";
      add(metric, late);
    }
    json_["passed"] = passed_;
    json_["wall_s"] = wall_;
    json_["cpu_s"] = cpu_;
    return {json_, passed_, stopped_};
  }

 private:
  /// Results of one history of a run.
  struct History {
    Gauges gauges;
    Counters counters;
    RunResult result;
  };

  void execute(const VerifyFile& file, const VerifyRun& run) {
    const auto wanted = options_.short_runs ? 1 : static_cast<std::size_t>(run.histories);
    std::vector<History> histories;
    for (std::size_t number = 0; number < wanted; ++number) {
      histories.push_back(execute(run, number));
      if (stopped_) return;
    }
    done_[run.name] = histories.front().gauges;
    bool failure_expected = false;
    for (const auto& metric : file.metrics) {
      if (metric.run != run.name) continue;
      failure_expected = failure_expected || metric.op == "exit";
      std::vector<Verdict> verdicts;
      for (const auto& one : histories) verdicts.push_back(judged(metric, one));
      add(metric, judge_mean(metric, verdicts));
    }
    for (const auto& [gauges, counters, result] : histories) {
      if (result.exit == 0 || failure_expected) continue;
      Metric metric;
      metric.name = fmt::format("run '{}' ends well", run.name);
      const auto exit = static_cast<double>(result.exit);
      Verdict failed;
      failed.value = failed.error = exit;
      failed.complaint = result.reason;
      add(metric, failed);
    }
  }

  Verdict judged(const Metric& metric, const History& one) {
    if (metric.op == "order") return judge_order(metric, done_[metric.coarse], one.gauges);
    std::optional<Verdict> base;
    if (!metric.baseline.empty()) {
      base = judge(metric, done_[metric.baseline], 0);
      if (!done_.contains(metric.baseline) || done_[metric.baseline].empty())
        base->complaint = "this run comes first; it has not run, or left no readings";
    }
    return judge(metric, one.gauges, one.result.exit, one.counters, base ? &*base : nullptr);
  }

  History execute(const VerifyRun& run, std::size_t number) {
    RunOptions options;
    options.case_file = place_.folder() / run.case_file;
    options.case_name = place_.name;
    options.out = options_.out / place_.name / (number == 0 ? run.name : fmt::format("{}.{}", run.name, number + 1));
    options.overrides = run.set;
    if (options_.short_runs)
      options.overrides.insert(options.overrides.end(), run.short_set.begin(), run.short_set.end());
    const auto varied = history(run, read_case(options.case_file, options.overrides), number);
    options.overrides.insert(options.overrides.end(), varied.begin(), varied.end());
    options.overrides.insert(options.overrides.end(), options_.overrides.begin(), options_.overrides.end());
    options.programs = options_.programs;
    options.tiles = options_.tiles;
    options.quiet = true;
    options.pictures = false;
    options.restarts = 0;
    options.overwrite = true;  // verification runs are never resumed
    const RunResult result = run.command == "safety" ? find_safety(options, 0.01).run : run_case(options);
    wall_ += result.wall;
    cpu_ += result.cpu;
    if (result.exit == interrupted) {
      stopped_ = true;
      passed_ = false;
      return {{}, {}, result};
    }
    account(run, options.out, result, number == 0);
    Counters counters;
    for (const auto& summary : result.summaries)
      for (const auto* numbers : {&summary.steps, &summary.counters})
        for (const auto& [name, value] : *numbers) counters[fmt::format("{}.{}", summary.process, name)] = value;
    return {read_gauges(options.out / "gauges.csv"), std::move(counters), result};
  }

  void account(const VerifyRun& run, const fs::path& folder, const RunResult& result, bool shown) {
    Json one = {{"name", run.name},      {"folder", folder.string()}, {"figures", run.figures},     {"windows", 0.0},
                {"wall_s", result.wall}, {"cpu_s", result.cpu},       {"particles", Json::object()}};
    for (const auto& summary : result.summaries) {
      for (const auto& [name, value] : summary.steps) {
        auto& total = json_["steps"][fmt::format("{}.{}", summary.process, name)];
        total = (total.is_number() ? total.get<double>() : 0.0) + value;
        if (name == "windows") one["windows"] = std::max(one["windows"].get<double>(), value);
      }
      for (const auto& [name, value] : summary.counters)
        if (name == "particles") {
          auto& most = json_["particles"][summary.process];
          most = std::max(most.is_number() ? most.get<double>() : 0.0, value);
          one["particles"][summary.process] = value;
        }
    }
    if (shown) json_["runs"].push_back(std::move(one));
  }

  void add(const Metric& metric, const Verdict& v) {
    passed_ = passed_ && v.passed;
    Json marks = Json::array();
    for (const auto& mark : v.marks)
      marks.push_back({mark.gauge, mark.time, mark.value, mark.time_error, mark.value_error});
    json_["metrics"].push_back({{"name", metric.name},
                                {"run", metric.run},
                                {"gauge", metric.gauge},
                                {"value", json_number(v.value)},
                                {"reference", json_number(v.reference)},
                                {"error", json_number(v.error)},
                                {"tolerance", metric.tolerance},
                                {"unit", metric.unit},
                                {"spread", json_number(v.spread)},
                                {"histories", v.histories},
                                {"passed", v.passed},
                                {"marks", std::move(marks)}});
    const std::string scatter =
        v.histories > 1 ? fmt::format("  mean of {}, +- {:.2g}", v.histories, v.spread) : std::string();
    fmt::print("{:<22} {:<44} {:>12.5g} {:>12.5g} {:>10.3g} {:>10.3g}  {:<6} {}{}\n", place_.name, metric.name, v.value,
               v.reference, v.error, metric.tolerance, metric.unit, v.passed ? "pass" : "FAIL", scatter);
    if (!v.complaint.empty()) fmt::print("    {}\n", v.complaint);
    std::fflush(stdout);
  }

  const VerifyOptions& options_;
  CasePlace place_;
  Json json_;
  bool passed_ = true, stopped_ = false;
  double wall_ = 0.0, cpu_ = 0.0;
  std::map<std::string, Gauges> done_;  ///< gauges of the completed runs, by name
};

}  // namespace

int verify(const VerifyOptions& options, JsonOutput& json) {
  const bool all = options.which == "all";
  const auto names = all ? case_names("verify.toml") : std::vector<std::string>{options.which};
  fmt::print("{:<22} {:<44} {:>12} {:>12} {:>10} {:>10}  {:<6}\n", "case", "metric", "value", "reference", "error",
             "tolerance", "unit");
  Json results = Json::array();
  bool passed = true;
  for (const auto& name : names) {
    const auto verdict = CaseCheck(options, find_case(name)).verdict();
    results.push_back(verdict.json);
    passed = passed && verdict.passed;
    if (json.wanted()) json.write(all ? results : results.front());
    if (verdict.stopped) {
      fmt::print(stderr, "{}: interrupted; the cases and runs that were to come are not judged\n", name);
      return interrupted;
    }
  }
  if (!options.report.empty()) {
    fs::create_directories(options.report);
    const fs::path file = options.report / "results.json";
    JsonOutput page;
    page.open("verify", file.string());
    page.write(results);
    run_script("cli/verify_page.py", {file.string(), options.report.string()}, options.report / "report.log");
  }
  fmt::print("{}\n", passed ? "all pass" : "NOT all pass");
  return passed ? 0 : static_cast<int>(ExitCode::in_doubt);
}

}  // namespace poretwin::cli
