#include "cli/metrics.hpp"

#include "common/core/error.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <sstream>
#include <utility>

namespace poretwin::cli {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
const std::vector<std::string> operations{
    "value", "relative", "mean",    "l2",       "profile", "max_abs",        "decay_rate", "monotone",
    "drift", "exceeds",  "curve",   "exit",     "period",  "crossing",       "counter",    "rise",
    "noise", "order",    "largest", "smallest", "damping", "time_of_largest"};

void declare(Keys& keys, VerifyRun& r) {
  keys.text("name", r.name, {"", "Name that metrics refer to, and folder of the run: without `/`, each once.", true});
  keys.text("case", r.case_file, {"", "Case file in the same folder."});
  keys.text("command", r.command,
            {"", "`run`, or `safety`: find the factor of safety, its gauge is `factor_of_safety`."});
  keys.texts("set", r.set, {"", "Overrides, as for `--set`."});
  keys.texts("short", r.short_set, {"", "Further overrides with `--short`."});
  keys.text("when", r.when, {"", "`always`, or `full`: left out with `--short`."});
  keys.integer(
      "histories", r.histories,
      {"",
       "Number of runs: the first as it is, the others with particles displaced by a millionth of a spacing and with "
       "what `vary` lists. Means over them are compared with the references. With `--short` there is one."},
      between(1, false, 1000, false));
  keys.texts("vary", r.vary, {"", "Numbers that differ between histories, KEY=VALUE: `soil.0.cohesion=550`."});
  keys.number("variation", r.variation, {"1", "Largest change of these numbers, relative to the value, up or down."},
              positive());
  keys.texts("figures", r.figures,
             {"", "Fields that a report shows, FIELD or FIELD@TIME in s; absent: the main ones at the end."});
}

void declare(Keys& keys, Metric& m) {
  keys.text("name", m.name, {"", "What is measured.", true});
  keys.text("run", m.run, {"", "The run it is taken from; absent: the first."});
  keys.text("source", m.source, {"", "Where the reference comes from."});
  keys.text(
      "op", m.op,
      {"",
       "`value` (a reading, or with `from` the mean over the range), `relative`, `mean` (over the range; relative "
       "error), `l2`, `profile` (of readings, or with `from` of means over the range), `max_abs`, `decay_rate`, "
       "`damping` (the rate at which whole swings about `limit` lose "
       "their height; relative error), "
       "`monotone`, `drift`, `exceeds`, `curve`, `exit`, `period` "
       "(mean, between upward passages of `limit`; relative error), `crossing` (time at which the readings first pass "
       "`limit`; relative error), `counter` (at most `reference`), `largest` (relative error), `time_of_largest` (of "
       "the parabola through the largest reading and its neighbours; relative error), `smallest` (at least "
       "`reference`), `rise` (greatest climb "
       "above an earlier reading), "
       "`noise` (rms distance from the running mean over `window`) or `order` (the order at which the relative error "
       "of "
       "`decay_rate` falls from the run `coarse` to this one of half its spacing; at least `tolerance`).",
       true});
  keys.text("gauge", m.gauge, {"", "The gauge; for `l2` and `profile`: all of `gauge[i]`."});
  keys.text("counter", m.counter, {"", "With `counter`: process.name as in the run's summary, `solid.rest steps`."});
  keys.texts("gauges", m.gauges, {"", "For `l2` and `profile`: the gauges, one by one."});
  keys.numbers(
      "weights", m.weights,
      {"",
       "Weights with which the readings of `gauge[i]` (or `gauges`) are added: for a mean, a difference, the amplitude "
       "of a mode. Not with `l2` and `profile`."});
  keys.text("plus", m.plus, {"", "A gauge to add first."});
  keys.text("minus", m.minus, {"", "A gauge to subtract first."});
  keys.number("at", m.at, {"s", "Time of the reading; absent: the last."});
  keys.number("from", m.from, {"s", "Start of the range; absent: the first reading."});
  keys.number("to", m.to, {"s", "End of the range; absent: the last reading."});
  keys.number("window", m.window, {"s", "With `noise`: width of the running mean."}, positive());
  keys.text("coarse", m.coarse, {"", "With `order`: the run with twice the spacing."});
  keys.text("baseline", m.baseline, {"", "An earlier run; its value is subtracted from the value of this one."});
  keys.number("scale", m.scale, {"", "Readings are multiplied by it."});
  keys.number("absent", m.absent,
              {"",
               "Stands for readings that are not a number, of a gauge that lies outside its phase: 0 for a pressure "
               "gauge that the water has not reached. Absent: such readings fail."});
  keys.number("limit", m.limit,
              {"", "Value that the readings tend to (`decay_rate`, `monotone`) or pass (`period`, `crossing`)."});
  keys.number("normaliser", m.normaliser,
              {"", "Errors are divided by it (`l2`, `profile`, `drift`, `curve`, `rise`, `noise`)."}, positive());
  keys.text("norm", m.norm, {"", "With `curve` and `profile`: `max` or `rms`."});
  keys.number("reference", m.reference, {"", "The right value."});
  keys.numbers("references", m.references, {"", "The right values of `l2` and `profile`."});
  keys.text("reference_csv", m.reference_csv,
            {"", "File with the right values: last column for `l2` and `profile`, time and value for `curve`."});
  keys.series("curve", m.curve, {"", "The right curve of `curve`, in place of a file."});
  keys.number("align", m.align,
              {"",
               "With `curve`: times of the curve and of the readings are counted from where each first passes this "
               "value."});
  keys.number("tolerance", m.tolerance, {"", "Largest error that passes."}, not_negative());
  keys.number("spread", m.spread,
              {"", "Largest standard deviation over several histories that passes; relative where the tolerance is."},
              positive());
  keys.text("unit", m.unit, {"", "Unit of the value."});
}

void declare(Keys& keys, Figure& f) {
  keys.text("name", f.name, {"", "Name of the picture's file.", true});
  keys.text("title", f.title, {"", "Title above the picture."});
  keys.text("kind", f.kind,
            {"",
             "`fields` (a column for each of `fields`, a row for each of `times`), `outlines` (the water's surface at "
             "`times`, or at the end of each of `runs`), `profile` (arrays of gauges against their places, with the "
             "references of `l2` and `profile`) or `history` (gauges against time, with the references of `value` and "
             "`relative`).",
             true});
  keys.texts("runs", f.runs,
             {"", "Runs that the picture shows; absent: the first. More than one with `outlines` only."});
  keys.texts("fields", f.fields,
             {"",
              "With `fields`: names as for `poretwin plot --field`; PHASE.FIELD where both phases have such a "
              "field."});
  keys.numbers("times", f.times, {"s", "Frames nearest to these times; absent: the last."});
  keys.texts("gauges", f.gauges, {"", "Gauges to draw, with `profile` and `history`."});
  keys.texts("labels", f.labels, {"", "Labels of `gauges`, or of `runs`, in the legend."});
  keys.text("label", f.label, {"", "With `profile` and `history`: label of the axis of the readings, with unit."});
  keys.number("scale", f.scale, {"", "Readings are multiplied by it."});
  keys.text("reference_csv", f.reference_csv,
            {"",
             "File with points to draw as well: columns `x_m` and `y_m`, and `t_s` where each belongs to a time; "
             "without `t_s` they belong to the last."});
  keys.series("points", f.points, {"", "Points to draw, [[x, y], ...], in place of a file."});
  keys.text("drive", f.drive,
            {"", "With `history`: a number of the case file that changes with time, `water_face.0.discharge`."});
  keys.number("drive_scale", f.drive_scale, {"", "Factor on that number."});
  keys.text("drive_label", f.drive_label, {"", "Label of its axis, with unit."});
}

void declare(Keys& keys, VerifyFile& file) {
  keys.text("source", file.source, {"", "Where the references of the case come from."});
  keys.number("wall_s", file.wall, {"s", "Longest wall-clock time of all runs together."}, positive());
  keys.tables("run", "A run of the case; without any, the case as it is.", file.runs,
              [](Keys& inner, VerifyRun& r) { declare(inner, r); });
  keys.tables("metric", "One number compared with its reference.", file.metrics,
              [](Keys& inner, Metric& m) { declare(inner, m); });
  keys.tables("figure", "A picture of the case's runs: of a report, and of `poretwin plot` of the folder they lie in.",
              file.figures, [](Keys& inner, Figure& f) { declare(inner, f); });
}

struct Failure {
  std::string text;
};

bool needs_relative_error(const std::string& op) {
  return op == "relative" || op == "mean" || op == "decay_rate" || op == "damping" || op == "period" ||
         op == "crossing" || op == "largest" || op == "time_of_largest";
}

/// Reading at time t, interpolated linearly; NaN outside the times of the readings, and beside a reading that is NaN.
double reading(const GaugeSeries& series, double t) {
  const auto& times = series.time;
  if (times.empty()) return nan;
  const double slack = 1e-9 * std::max(1.0, std::abs(times.back()));
  if (t < times.front() - slack || t > times.back() + slack) return nan;
  const auto after = std::lower_bound(times.begin(), times.end(), t);
  if (after == times.begin()) return series.value.front();
  if (after == times.end()) return series.value.back();
  const auto i = static_cast<std::size_t>(after - times.begin());
  const double share = (t - times[i - 1]) / (times[i] - times[i - 1]);
  if (share >= 1.0) return series.value[i];
  return series.value[i - 1] + share * (series.value[i] - series.value[i - 1]);
}

/// Splits the text KEY=NUMBER of `vary`; empty where the text has another form.
std::optional<std::pair<std::string, double>> assignment(const std::string& text) {
  const auto sign = text.find('=');
  if (sign == std::string::npos || sign == 0) return std::nullopt;
  char* end = nullptr;
  const char* const number = text.c_str() + sign + 1;
  const double value = std::strtod(number, &end);
  if (end == number || *end != '\0') return std::nullopt;
  return std::pair{text.substr(0, sign), value};
}

/// Error of a value. Operations whose value is itself an error are compared with zero, others with the reference.
double error_of(const Metric& m, double value) {
  if (m.op == "exceeds") return std::max(0.0, m.reference.value_or(0.0) - value);
  if (m.op == "value" || m.op == "exit" || m.op == "max_abs") return std::abs(value - m.reference.value_or(0.0));
  if (m.op == "counter") return std::max(0.0, value - *m.reference);
  if (m.op == "smallest") return std::max(0.0, *m.reference - value);
  if (needs_relative_error(m.op)) return std::abs(value - *m.reference) / std::abs(*m.reference);
  return value;
}

class Judge {
 public:
  Judge(const Metric& metric, const Gauges& gauges, int exit_status, const Counters& counters, const Verdict* base)
      : m_(metric), gauges_(gauges), exit_(exit_status), counters_(counters), base_(base) {}

  Verdict verdict() const {
    Verdict v;
    v.reference = m_.reference.value_or(0.0);
    try {
      if (m_.op == "exceeds") return exceeds(v);
      v.value = value();
      if (base_ && !base_->complaint.empty()) throw Failure{fmt::format("'{}': {}", m_.baseline, base_->complaint)};
      if (base_) v.value -= base_->value;
      v.error = error_of(m_, v.value);
      v.marks = marks();
    } catch (const Failure& failure) {
      v.value = v.error = nan;
      v.complaint = failure.text;
    }
    v.passed = std::isfinite(v.error) && v.error <= m_.tolerance;
    return v;
  }

 private:
  [[nodiscard]] double value() const {
    if (m_.op == "exit") return exit_;
    if (m_.op == "value") return reading_or_mean(readings());
    if (m_.op == "relative") return at_time(readings());
    if (m_.op == "mean") return mean(readings());
    if (m_.op == "l2" || m_.op == "profile") return profile();
    if (m_.op == "max_abs") return farthest();
    if (m_.op == "decay_rate") return decay_rate();
    if (m_.op == "damping") return damping();
    if (m_.op == "monotone") return moving_away();
    if (m_.op == "drift") return drift();
    if (m_.op == "rise") return rise();
    if (m_.op == "largest") {
      const auto series = within_range(readings());
      return *std::max_element(series.value.begin(), series.value.end());
    }
    if (m_.op == "time_of_largest") return time_of_largest();
    if (m_.op == "smallest") {
      const auto series = within_range(readings());
      return *std::min_element(series.value.begin(), series.value.end());
    }
    if (m_.op == "noise") return noise();
    if (m_.op == "period") return period();
    if (m_.op == "crossing") return crossing();
    if (m_.op == "counter") return counter();
    return curve();
  }
  Verdict exceeds(Verdict v) const {
    try {
      const auto series = within_range(readings());
      v.value = m_.at ? at_time(series) : *std::max_element(series.value.begin(), series.value.end());
      v.error = error_of(m_, v.value);
      v.passed = v.value > v.reference;
    } catch (const Failure& failure) {
      v.value = v.error = nan;
      v.complaint = failure.text;
    }
    return v;
  }

  [[nodiscard]] GaugeSeries gauge(const std::string& name) const {
    const auto found = gauges_.find(name);
    if (found == gauges_.end() || found->second.time.empty())
      throw Failure{fmt::format("no readings of gauge '{}'", name)};
    GaugeSeries series = found->second;
    for (double& x : series.value) {
      if (m_.absent && std::isnan(x)) x = *m_.absent;
      x *= m_.scale;
    }
    return series;
  }
  /// Readings of the gauges of a profile, summed with the metric's weights.
  [[nodiscard]] GaugeSeries weighted() const {
    const auto names = along();
    if (names.size() != m_.weights.size())
      throw Failure{
          fmt::format("{} gauges '{}' and {} weights do not match", names.size(), m_.gauge, m_.weights.size())};
    GaugeSeries sum = gauge(names.front());
    for (double& x : sum.value) x *= m_.weights.front();
    for (std::size_t k = 1; k < names.size(); ++k) {
      const GaugeSeries other = gauge(names[k]);
      for (std::size_t i = 0; i < sum.time.size(); ++i) sum.value[i] += m_.weights[k] * reading(other, sum.time[i]);
    }
    return sum;
  }
  [[nodiscard]] GaugeSeries readings() const {
    GaugeSeries series = m_.weights.empty() ? gauge(m_.gauge) : weighted();
    for (const auto& [name, sign] : {std::pair{m_.plus, 1.0}, std::pair{m_.minus, -1.0}}) {
      if (name.empty()) continue;
      const GaugeSeries other = gauge(name);
      for (std::size_t i = 0; i < series.time.size(); ++i) series.value[i] += sign * reading(other, series.time[i]);
    }
    return series;
  }
  [[nodiscard]] GaugeSeries within_range(const GaugeSeries& all) const {
    GaugeSeries part;
    for (std::size_t i = 0; i < all.time.size(); ++i)
      if (all.time[i] >= m_.from.value_or(-HUGE_VAL) && all.time[i] <= m_.to.value_or(HUGE_VAL)) {
        part.time.push_back(all.time[i]);
        part.value.push_back(all.value[i]);
      }
    if (part.time.empty()) throw Failure{fmt::format("no readings of gauge '{}' in the range", m_.gauge)};
    auto lost = std::find_if(part.value.begin(), part.value.end(), [](double x) { return !std::isfinite(x); });
    // A first crossing does not depend on later readings: those from the first NaN on are dropped.
    if (m_.op == "crossing") {
      part.value.erase(lost, part.value.end());
      part.time.resize(part.value.size());
      lost = part.value.end();
    }
    if (part.value.empty() || lost != part.value.end())
      throw Failure{fmt::format("gauge '{}' is not a number in the range", m_.gauge)};
    return part;
  }
  [[nodiscard]] double at_time(const GaugeSeries& series) const {
    const double t = m_.at.value_or(series.time.back());
    const double x = reading(series, t);
    if (!std::isfinite(x)) throw Failure{fmt::format("gauge '{}' has no number at t = {} s", m_.gauge, t)};
    return x;
  }

  /// Mean of the readings over time, with linear interpolation between them.
  [[nodiscard]] double mean(const GaugeSeries& all) const {
    const auto series = within_range(all);
    double sum = 0.0;
    for (std::size_t i = 1; i < series.time.size(); ++i)
      sum += 0.5 * (series.time[i] - series.time[i - 1]) * (series.value[i] + series.value[i - 1]);
    const double span = series.time.back() - series.time.front();
    return span > 0.0 ? sum / span : series.value.front();
  }
  /// With `from` the mean over the range, otherwise the reading at `at`.
  [[nodiscard]] double reading_or_mean(const GaugeSeries& series) const {
    return m_.from ? mean(series) : at_time(series);
  }
  /// Names of the gauges of a profile.
  [[nodiscard]] std::vector<std::string> along() const {
    std::vector<std::string> names = m_.gauges;
    for (std::size_t i = 0; names.size() == i && m_.gauges.empty(); ++i)
      if (const auto name = fmt::format("{}[{}]", m_.gauge, i); gauges_.find(name) != gauges_.end())
        names.push_back(name);
    return names;
  }
  [[nodiscard]] double profile() const {
    const auto names = along();
    if (names.empty() || names.size() != m_.references.size())
      throw Failure{
          fmt::format("{} gauges '{}' and {} references do not match", names.size(), m_.gauge, m_.references.size())};
    double sum = 0.0, most = 0.0;
    for (std::size_t i = 0; i < names.size(); ++i) {
      const double difference = std::abs(reading_or_mean(gauge(names[i])) - m_.references[i]);
      most = std::max(most, difference);
      sum += difference * difference;
    }
    const bool largest = m_.op == "profile" && m_.norm == "max";
    return (largest ? most : std::sqrt(sum / static_cast<double>(names.size()))) / m_.normaliser.value_or(1.0);
  }
  [[nodiscard]] double farthest() const {
    const auto series = within_range(readings());
    const double reference = m_.reference.value_or(0.0);
    return *std::max_element(series.value.begin(), series.value.end(),
                             [&](double a, double b) { return std::abs(a - reference) < std::abs(b - reference); });
  }
  [[nodiscard]] double decay_rate() const {
    const auto series = within_range(readings());
    double n = 0.0, st = 0.0, sy = 0.0, stt = 0.0, sty = 0.0;
    for (std::size_t i = 0; i < series.time.size(); ++i) {
      const double distance = std::abs(series.value[i] - limit());
      if (distance <= 0.0) continue;
      const double t = series.time[i] - series.time.front(), y = -std::log(distance);
      n += 1.0;
      st += t;
      sy += y;
      stt += t * t;
      sty += t * y;
    }
    const double spread = n * stt - st * st;
    if (n < 3.0 || spread <= 0.0) throw Failure{fmt::format("too few readings of gauge '{}' for a rate", m_.gauge)};
    return (n * sty - st * sy) / spread;
  }
  /// Damping rate of an oscillation about `limit`, from its amplitudes: the largest distance from `limit` in each
  /// complete swing between two crossings of `limit`.
  [[nodiscard]] double damping() const {
    const auto series = within_range(readings());
    const auto distance = [&](std::size_t i) { return series.value[i] - limit(); };
    double n = 0.0, st = 0.0, sy = 0.0, stt = 0.0, sty = 0.0;
    std::size_t first = 0;  // index at which the swing begins; 0: none has begun
    for (std::size_t i = 1; i < series.time.size(); ++i) {
      if (distance(i - 1) * distance(i) > 0.0) continue;
      if (first > 0 && i > first + 1) {
        std::size_t top = first;
        for (std::size_t j = first; j < i; ++j)
          if (std::abs(distance(j)) > std::abs(distance(top))) top = j;
        // The amplitude is the maximum of the parabola through the largest reading of the swing and its two neighbours.
        const double a = std::abs(distance(top - 1)), b = std::abs(distance(top)), c = std::abs(distance(top + 1));
        const double bend = a - 2.0 * b + c;
        const double off = bend < 0.0 ? 0.5 * (a - c) / bend : 0.0;  // offset of the parabola's top, in readings
        const double t = series.time[top] + off * (series.time[top] - series.time[top - 1]) - series.time.front();
        const double y = -std::log(b - 0.25 * (a - c) * off);
        n += 1.0;
        st += t;
        sy += y;
        stt += t * t;
        sty += t * y;
      }
      first = i;
    }
    const double spread = n * stt - st * st;
    if (n < 3.0 || spread <= 0.0) throw Failure{fmt::format("fewer than three whole swings of gauge '{}'", m_.gauge)};
    return (n * sty - st * sy) / spread;
  }
  /// Time of the largest reading: that of the top of the parabola through it and its two neighbours.
  [[nodiscard]] double time_of_largest() const {
    const auto series = within_range(readings());
    const auto top =
        static_cast<std::size_t>(std::max_element(series.value.begin(), series.value.end()) - series.value.begin());
    if (top == 0 || top + 1 == series.value.size())
      throw Failure{fmt::format("the largest reading of gauge '{}' is the first or the last", m_.gauge)};
    const double before = series.time[top] - series.time[top - 1], after = series.time[top + 1] - series.time[top];
    const double rise = (series.value[top] - series.value[top - 1]) / before;
    const double fall = (series.value[top] - series.value[top + 1]) / after;
    if (!(rise + fall > 0.0)) return series.time[top];
    return series.time[top] + 0.5 * (rise * after - fall * before) / (rise + fall);
  }
  [[nodiscard]] double moving_away() const {
    const auto series = within_range(readings());
    double away = 0.0, steps = 0.0;
    // Rounding errors about the limit do not count as movement away from it.
    const double slack = 1e-9 * std::abs(series.value.front() - limit());
    for (std::size_t i = 1; i < series.value.size(); ++i) {
      steps += 1.0;
      const double before = series.value[i - 1] - limit(), now = series.value[i] - limit();
      const bool overshot = before * now < 0.0 && std::abs(now) > slack;
      if (std::abs(now) > std::abs(before) + slack || overshot) away += 1.0;
    }
    if (steps < 1.0) throw Failure{fmt::format("too few readings of gauge '{}'", m_.gauge)};
    return away / steps;
  }
  [[nodiscard]] double drift() const {
    const auto series = within_range(readings());
    double most = 0.0;
    for (const double x : series.value) most = std::max(most, std::abs(x - series.value.front()));
    return most / m_.normaliser.value_or(1.0);
  }
  [[nodiscard]] double rise() const {
    const auto series = within_range(readings());
    double lowest = series.value.front(), most = 0.0;
    for (const double x : series.value) {
      lowest = std::min(lowest, x);
      most = std::max(most, x - lowest);
    }
    return most / m_.normaliser.value_or(1.0);
  }
  [[nodiscard]] double noise() const {
    const auto series = within_range(readings());
    const double half = 0.5 * *m_.window;
    double sum = 0.0, count = 0.0;
    for (std::size_t i = 0; i < series.time.size(); ++i) {
      if (series.time[i] - half < series.time.front() || series.time[i] + half > series.time.back()) continue;
      double mean = 0.0, n = 0.0;
      for (std::size_t j = 0; j < series.time.size(); ++j)
        if (std::abs(series.time[j] - series.time[i]) <= half) {
          mean += series.value[j];
          n += 1.0;
        }
      sum += (series.value[i] - mean / n) * (series.value[i] - mean / n);
      count += 1.0;
    }
    if (count == 0.0) throw Failure{fmt::format("the window is longer than the readings of gauge '{}'", m_.gauge)};
    return std::sqrt(sum / count) / m_.normaliser.value_or(1.0);
  }
  [[nodiscard]] double limit() const { return m_.limit.value_or(0.0); }
  /// Time at which the readings cross a value between reading i - 1 and reading i, linear between them.
  [[nodiscard]] static double passage(const GaugeSeries& series, std::size_t i, double value) {
    const double before = series.value[i - 1] - value, now = series.value[i] - value;
    return series.time[i - 1] + before / (before - now) * (series.time[i] - series.time[i - 1]);
  }
  /// Time at which the readings first cross a value.
  [[nodiscard]] static std::optional<double> first_passage(const GaugeSeries& series, double value) {
    for (std::size_t i = 1; i < series.value.size(); ++i) {
      const double before = series.value[i - 1] - value, now = series.value[i] - value;
      if (before * now < 0.0 || (now == 0.0 && before != 0.0)) return passage(series, i, value);
    }
    return std::nullopt;
  }
  [[nodiscard]] double crossing() const {
    if (const auto time = first_passage(within_range(readings()), limit())) return *time;
    throw Failure{fmt::format("gauge '{}' never reaches {}", m_.gauge, limit())};
  }
  /// Mean period, from the first upward crossing of `limit` to the last. A swing counts only if it reaches below the
  /// limit by a fifth of the largest distance from it in this swing and the swing before: small fluctuations about the
  /// limit cause further crossings.
  [[nodiscard]] double period() const {
    constexpr double least = 0.2;
    const auto series = within_range(readings());
    std::vector<double> times;
    double most = 0.0, deepest = 0.0, most_before = 0.0;  // largest distances: since the last crossing; in the swing
                                                          // before
    for (std::size_t i = 1; i < series.value.size(); ++i) {
      const double before = series.value[i - 1] - limit(), now = series.value[i] - limit();
      most = std::max(most, std::abs(before));
      deepest = std::max(deepest, -before);
      if (before >= 0.0 || now < 0.0 || deepest < least * std::max(most, most_before)) continue;
      times.push_back(passage(series, i, limit()));
      most_before = std::exchange(most, 0.0);
      deepest = 0.0;
    }
    if (times.size() < 2) throw Failure{fmt::format("gauge '{}' has no two whole swings around {}", m_.gauge, limit())};
    return (times.back() - times.front()) / static_cast<double>(times.size() - 1);
  }
  [[nodiscard]] double counter() const {
    const auto found = counters_.find(m_.counter);
    if (found == counters_.end()) throw Failure{fmt::format("the run has no counter '{}'", m_.counter)};
    return found->second * m_.scale;
  }
  [[nodiscard]] GaugeSeries curve_as_readings() const {
    GaugeSeries series;
    for (const auto& [t, right] : m_.curve->knots) {
      series.time.push_back(t);
      series.value.push_back(right);
    }
    return series;
  }
  /// Time at which the readings first cross `align`.
  [[nodiscard]] double start_of(const GaugeSeries& series) const {
    if (const auto time = first_passage(series, *m_.align)) return *time;
    throw Failure{fmt::format("gauge '{}' or its curve never reaches {}", m_.gauge, *m_.align)};
  }
  /// Time by which the readings lag behind the curve [s].
  [[nodiscard]] double shift() const { return m_.align ? start_of(readings()) - start_of(curve_as_readings()) : 0.0; }
  /// The points of the curve that are compared, with their times delayed by shift().
  [[nodiscard]] std::vector<std::pair<double, double>> judged_knots() const {
    const double later = shift();
    std::vector<std::pair<double, double>> knots;
    for (const auto& [t, right] : m_.curve->knots)
      if (t >= m_.from.value_or(-HUGE_VAL) && t <= m_.to.value_or(HUGE_VAL)) knots.emplace_back(t + later, right);
    return knots;
  }
  [[nodiscard]] double curve() const {
    const auto series = readings();
    double most = 0.0, sum = 0.0, count = 0.0;
    for (const auto& [t, right] : judged_knots()) {
      const double found = reading(series, t);
      if (!std::isfinite(found)) throw Failure{fmt::format("gauge '{}' has no number at t = {} s", m_.gauge, t)};
      const double e = std::abs(found - right) / m_.normaliser.value_or(std::abs(right));
      most = std::max(most, e);
      sum += e * e;
      count += 1.0;
    }
    if (count == 0.0) throw Failure{"the reference curve has no point in the range"};
    return m_.norm == "rms" ? std::sqrt(sum / count) : most;
  }

  [[nodiscard]] std::vector<Mark> marks() const {
    if (!m_.plus.empty() || !m_.minus.empty() || !m_.weights.empty() || base_ || m_.scale == 0.0) return {};
    std::vector<Mark> found;
    const auto add = [&](const std::string& name, double t, double right, double off_by_time, double off_by) {
      found.push_back({name, t, right / m_.scale, off_by_time, off_by / std::abs(m_.scale)});
    };
    const auto judged_at = [&](const std::string& name) { return m_.at.value_or(gauge(name).time.back()); };
    if (m_.op == "value" && !m_.from)
      add(m_.gauge, judged_at(m_.gauge), *m_.reference, 0.0, m_.tolerance);
    else if (m_.op == "relative")
      add(m_.gauge, judged_at(m_.gauge), *m_.reference, 0.0, m_.tolerance * std::abs(*m_.reference));
    else if (m_.op == "crossing")
      add(m_.gauge, *m_.reference, limit(), m_.tolerance * std::abs(*m_.reference), 0.0);
    else if (m_.op == "curve")
      for (const auto& [t, right] : judged_knots()) add(m_.gauge, t, right, 0.0, 0.0);
    else if (m_.op == "l2" || m_.op == "profile")
      for (std::size_t i = 0; const auto& name : along()) add(name, judged_at(name), m_.references[i++], 0.0, 0.0);
    return found;
  }

  const Metric& m_;
  const Gauges& gauges_;
  int exit_;
  const Counters& counters_;
  const Verdict* base_;
};

class VerifyChecker {
 public:
  VerifyChecker(const std::filesystem::path& path, const Places& places) : path_(path), places_(places) {}

  void fill(VerifyFile& file) const {
    if (file.runs.empty()) {
      file.runs.emplace_back();
      file.runs.back().name = "default";
    }
    for (std::size_t i = 0; i < file.runs.size(); ++i) {
      name_of_run(file, i);
      word(fmt::format("run[{}].when", i), file.runs[i].when, {"always", "full"});
      word(fmt::format("run[{}].command", i), file.runs[i].command, {"run", "safety"});
      for (const auto& text : file.runs[i].vary)
        if (!assignment(text))
          fail(fmt::format("run[{}].vary", i), fmt::format("expected KEY=NUMBER, found \"{}\"", text));
    }
    if (file.metrics.empty()) fail("metric", "expected one [[metric]] or more");
    for (std::size_t i = 0; i < file.metrics.size(); ++i) metric(file, file.metrics[i], fmt::format("metric[{}]", i));
    for (std::size_t i = 0; i < file.figures.size(); ++i) figure(file, file.figures[i], fmt::format("figure[{}]", i));
  }

 private:
  [[noreturn]] void fail(const std::string& key, const std::string& message) const {
    auto found = places_.find(key);
    if (found == places_.end()) found = places_.find(key.substr(0, key.find('.')));
    throw CaseError(
        fmt::format("{}: key '{}': {}", found != places_.end() ? found->second : path_.string(), key, message));
  }
  void word(const std::string& key, const std::string& found, const std::vector<std::string>& words) const {
    if (std::find(words.begin(), words.end(), found) == words.end())
      fail(key, fmt::format("expected \"{}\", found \"{}\"", fmt::join(words, "\" or \""), found));
  }
  /// A run is the folder of its name, in that of the case; further histories of it are NAME.2, NAME.3, ..
  void name_of_run(const VerifyFile& file, std::size_t i) const {
    const std::string& name = file.runs[i].name;
    const std::string key = fmt::format("run[{}].name", i);
    if (name.empty() || name == "." || name == ".." || name.find('/') != std::string::npos)
      fail(key, fmt::format("expected the name of a folder without '/', found \"{}\"", name));
    for (std::size_t j = 0; j < file.runs.size(); ++j) {
      const VerifyRun& other = file.runs[j];
      if (j < i && other.name == name)
        fail(key, fmt::format("\"{}\" is the name of another [[run]], too: give each its own", name));
      for (int history = 2; history <= other.histories; ++history)
        if (name == fmt::format("{}.{}", other.name, history))
          fail(key, fmt::format("\"{}\" is the folder of history {} of run \"{}\", too: choose another name", name,
                                history, other.name));
    }
  }
  void metric(const VerifyFile& file, Metric& m, const std::string& key) const {
    if (m.run.empty()) m.run = file.runs.front().name;
    if (std::none_of(file.runs.begin(), file.runs.end(), [&](const VerifyRun& r) { return r.name == m.run; }))
      fail(key + ".run", fmt::format("no [[run]] is named \"{}\"", m.run));
    if (std::find(operations.begin(), operations.end(), m.op) == operations.end())
      fail(key + ".op", fmt::format("\"{}\" is not known; did you mean \"{}\"?", m.op, nearest(m.op, operations)));
    if (m.op == "counter" && m.counter.empty()) fail(key + ".counter", "is missing");
    if (m.op != "exit" && m.op != "counter" && m.gauge.empty() && m.gauges.empty()) fail(key + ".gauge", "is missing");
    if (!m.weights.empty() && (m.op == "l2" || m.op == "profile"))
      fail(key + ".weights", fmt::format("has no meaning for \"{}\", which takes each gauge by itself", m.op));
    if (!m.weights.empty() && !m.gauges.empty() && m.weights.size() != m.gauges.size())
      fail(key + ".weights",
           fmt::format("expected one for each of the {} gauges, found {}", m.gauges.size(), m.weights.size()));
    const bool relative = needs_relative_error(m.op);
    const bool single =
        m.op == "value" || m.op == "exceeds" || m.op == "exit" || m.op == "counter" || m.op == "smallest";
    if ((relative || single) && !m.reference) fail(key + ".reference", "is missing");
    if (relative && *m.reference == 0.0) fail(key + ".reference", "a relative error needs a reference other than zero");
    if (m.norm != "max" && m.norm != "rms")
      fail(key + ".norm", fmt::format("expected \"max\" or \"rms\", found \"{}\"", m.norm));
    if (!m.reference_csv.empty()) from_csv(m, key);
    if (m.op == "noise" && !m.window) fail(key + ".window", "is missing");
    if (m.op == "order" &&
        std::none_of(file.runs.begin(), file.runs.end(), [&](const VerifyRun& r) { return r.name == m.coarse; }))
      fail(key + ".coarse", fmt::format("no [[run]] is named \"{}\"", m.coarse));
    if (!m.baseline.empty()) {
      const auto place = [&](const std::string& name) {
        return std::find_if(file.runs.begin(), file.runs.end(), [&](const VerifyRun& r) { return r.name == name; });
      };
      if (place(m.baseline) >= place(m.run))
        fail(key + ".baseline", fmt::format("expected a [[run]] before \"{}\", found \"{}\"", m.run, m.baseline));
    }
    if (m.op == "curve" && !m.curve) fail(key + ".curve", "expected 'reference_csv' or 'curve'");
    if ((m.op == "l2" || m.op == "profile") && m.references.empty())
      fail(key + ".references", "expected 'reference_csv' or 'references'");
  }
  void figure(const VerifyFile& file, const Figure& f, const std::string& key) const {
    word(key + ".kind", f.kind, {"fields", "outlines", "profile", "history"});
    if (f.name.empty() || f.name.find('/') != std::string::npos)
      fail(key + ".name", fmt::format("expected the name of a file without '/', found \"{}\"", f.name));
    for (const auto& name : f.runs)
      if (std::none_of(file.runs.begin(), file.runs.end(), [&](const VerifyRun& r) { return r.name == name; }))
        fail(key + ".runs", fmt::format("no [[run]] is named \"{}\"", name));
    if (f.runs.size() > 1 && f.kind != "outlines")
      fail(key + ".runs", fmt::format("\"{}\" shows one run, found {}", f.kind, f.runs.size()));
    if (f.kind == "fields" && f.fields.empty()) fail(key + ".fields", "is missing");
    if ((f.kind == "profile" || f.kind == "history") && f.gauges.empty()) fail(key + ".gauges", "is missing");
    const auto& named = f.kind == "outlines" ? f.runs : f.gauges;
    if (!f.labels.empty() && f.labels.size() != named.size())
      fail(key + ".labels", fmt::format("expected one for each of the {}, found {}", named.size(), f.labels.size()));
  }
  void from_csv(Metric& m, const std::string& key) const {
    const auto rows = read_csv(path_.parent_path() / m.reference_csv);
    if (m.op == "curve") m.curve.emplace();
    for (const auto& row : rows) {
      if (m.op == "curve" && row.size() < 2) fail(key + ".reference_csv", "expected columns time, value");
      if (m.op == "curve")
        m.curve->knots.emplace_back(row[0], row[1]);
      else
        m.references.push_back(row.back());
    }
  }

  const std::filesystem::path& path_;
  const Places& places_;
};

}  // namespace

VerifyFile read_verify(const std::filesystem::path& path) {
  VerifyFile file;
  Places places;
  read_keys(
      parse_document(read_text(path), path.string()), [&](Keys& keys) { declare(keys, file); }, &places);
  VerifyChecker(path, places).fill(file);
  return file;
}

Verdict judge(const Metric& metric, const Gauges& gauges, int exit_status, const Counters& counters,
              const Verdict* base) {
  return Judge(metric, gauges, exit_status, counters, base).verdict();
}

Verdict judge_mean(const Metric& metric, const std::vector<Verdict>& histories) {
  Verdict v = histories.front();
  if (histories.size() == 1) return v;
  const auto n = static_cast<double>(histories.size());
  v.histories = histories.size();
  v.value = 0.0;
  for (const auto& one : histories) {
    v.value += one.value / n;
    if (v.complaint.empty()) v.complaint = one.complaint;
  }
  double squares = 0.0;
  for (const auto& one : histories) squares += (one.value - v.value) * (one.value - v.value);
  v.spread = std::sqrt(squares / (n - 1.0));
  v.error = error_of(metric, v.value);
  v.passed = std::isfinite(v.error) && (metric.op == "exceeds" ? v.value > v.reference : v.error <= metric.tolerance);
  if (!metric.spread || !v.passed) return v;
  const double allowed = *metric.spread * (needs_relative_error(metric.op) ? std::abs(*metric.reference) : 1.0);
  if (v.spread <= allowed) return v;
  v.passed = false;
  v.complaint = fmt::format("the histories spread by {:.3g}, {:.3g} allowed", v.spread, allowed);
  return v;
}

std::vector<std::string> history(const VerifyRun& run, const Case& scene, std::size_t number) {
  std::vector<std::string> set;
  if (number == 0) return set;
  for (const char* phase : {"fluid", "solid"}) {
    if (phase == std::string_view("fluid") ? !scene.has_water() : scene.soils.empty()) continue;
    set.push_back(fmt::format("{}.jitter=1e-6", phase));
    set.push_back(fmt::format("{}.seed={}", phase, number));
  }
  // Multiples of the golden ratio, modulo 1, fill the range evenly, however many there are.
  const double turn = 0.6180339887498949 * static_cast<double>(number);
  const double share = 2.0 * (turn - std::floor(turn)) - 1.0;
  for (const auto& text : run.vary) {
    const auto [key, value] = assignment(text).value();
    set.push_back(fmt::format("{}={:.12g}", key, value * (1.0 + run.variation * share)));
  }
  return set;
}

Verdict judge_order(const Metric& metric, const Gauges& coarse, const Gauges& fine) {
  Metric rate = metric;
  rate.op = "decay_rate";
  const Verdict before = judge(rate, coarse, 0), now = judge(rate, fine, 0);
  Verdict v;
  v.reference = metric.tolerance;
  v.value = std::log2(before.error / now.error);
  v.error = std::max(0.0, metric.tolerance - v.value);
  v.passed = v.value >= metric.tolerance;
  v.complaint = before.complaint.empty() ? now.complaint : before.complaint;
  return v;
}

std::vector<std::vector<double>> read_csv(const std::filesystem::path& path) {
  std::istringstream stream(read_text(path));
  std::vector<std::vector<double>> rows;
  bool heading_allowed = true;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos || line[0] == '#') continue;
    std::vector<double> row;
    std::istringstream cells(line);
    bool good = true;
    for (std::string cell; std::getline(cells, cell, ',');) {
      char* end = nullptr;
      row.push_back(std::strtod(cell.c_str(), &end));
      good = good && end != cell.c_str();
    }
    if (good)
      rows.push_back(row);
    else if (!heading_allowed)
      throw FileError(
          fmt::format("{}:{}: expected numbers separated by commas, found '{}'", path.string(), number, line));
    heading_allowed = false;
  }
  return rows;
}

std::string verify_reference() {
  VerifyFile file;
  return describe_keys([&](Keys& keys) { declare(keys, file); });
}

}  // namespace poretwin::cli
