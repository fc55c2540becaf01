// The operations of verify.toml: each computes one number from a run's gauges and compares it with a reference.
#pragma once

#include "common/case/keys.hpp"
#include "common/output/gauge_log.hpp"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace poretwin::cli {

/// [[metric]] of verify.toml.
struct Metric {
  std::string name, run, source, op, gauge, counter, plus, minus, unit, norm = "max", reference_csv, coarse, baseline;
  std::vector<std::string> gauges;
  std::vector<double> references, weights;
  std::optional<double> at, from, to, limit, normaliser, reference, window, align, absent;
  std::optional<Series> curve;
  std::optional<double> spread;
  double scale = 1.0, tolerance = 0.0;
};

/// [[run]] of verify.toml.
struct VerifyRun {
  std::string name, case_file = "case.toml", when = "always", command = "run";
  std::vector<std::string> set, short_set, figures, vary;
  std::int64_t histories = 1;
  double variation = 0.01;
};

/// [[figure]] of verify.toml, drawn by cli/figures.py.
struct Figure {
  std::string name, title, kind, reference_csv, label, drive, drive_label;
  std::vector<std::string> runs, fields, gauges, labels;
  std::vector<double> times;
  std::optional<Series> points;
  double scale = 1.0, drive_scale = 1.0;
};

struct VerifyFile {
  std::string source;
  std::optional<double> wall;  ///< largest wall-clock time of all runs together [s]
  std::vector<VerifyRun> runs;
  std::vector<Metric> metrics;
  std::vector<Figure> figures;
};

/// A point that a gauge should reach, drawn in pictures: time and value in the gauge's unit, with the errors that the
/// metric's tolerance allows.
struct Mark {
  std::string gauge;
  double time = 0.0, value = 0.0, time_error = 0.0, value_error = 0.0;
};

/// Result of a metric. A value that is NaN never passes.
struct Verdict {
  double value = 0.0, reference = 0.0, error = 0.0;
  bool passed = false;
  std::string complaint;  ///< why there is no value, or why the value does not count
  double spread = 0.0;    ///< standard deviation over several histories
  std::size_t histories = 1;
  std::vector<Mark> marks;  ///< times and values that readings should have, where the operation gives them
};

using Gauges = std::map<std::string, GaugeSeries>;
using Counters = std::map<std::string, double>;  ///< "solid.substeps", ...

/// Reads and checks a verify.toml; curves and references in CSV files are looked up beside it. Throws CaseError,
/// FileError.
VerifyFile read_verify(const std::filesystem::path& path);

/// Evaluates one metric from a run's gauges, exit status and counters. base: the verdict of the same metric in the run
/// that it names as `baseline`.
Verdict judge(const Metric& metric, const Gauges& gauges, int exit_status, const Counters& counters = {},
              const Verdict* base = nullptr);

/// Compares the mean of a metric over several histories (runs with slightly perturbed input) with its reference, and
/// gives their standard deviation. If one history has no value, the verdict has none.
Verdict judge_mean(const Metric& metric, const std::vector<Verdict>& histories);

/// The overrides of the case in history `number` of a run. History 0 has none. In others particles are displaced at
/// random by a millionth of a spacing, with `number` as seed, and values in `vary` change by up to the variation.
std::vector<std::string> history(const VerifyRun& run, const Case& scene, std::size_t number);

/// Observed order of convergence of `decay_rate` from a coarse run to a fine one with half its spacing.
Verdict judge_order(const Metric& metric, const Gauges& coarse, const Gauges& fine);

/// Columns of a CSV file; comments after '#' and a heading are skipped. Throws FileError.
std::vector<std::vector<double>> read_csv(const std::filesystem::path& path);

/// All keys of verify.toml as a table in Markdown.
std::string verify_reference();

}  // namespace poretwin::cli
