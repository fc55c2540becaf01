#include "common/coupling/warning_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace poretwin::coupling {

void WarningLog::begin(std::function<void(const std::string&)> say, std::vector<std::string> gauges) {
  say_ = std::move(say);
  gauges_ = std::move(gauges);
}

void WarningLog::note(double time, const std::vector<Warning>& warnings) {
  for (const auto& warning : warnings) {
    if (!(warning.count > 0.0)) continue;
    const auto known = std::find_if(warnings_.begin(), warnings_.end(),
                                    [&](const Warning& other) { return other.what == warning.what; });
    if (known != warnings_.end()) {
      known->count = warning.count;
      known->result_in_doubt = known->result_in_doubt || warning.result_in_doubt;
      continue;
    }
    warnings_.push_back(warning);
    if (say_)
      say_(fmt::format("warning: {} ({:g} by t = {:g} s){}{}", warning.what, warning.count, time,
                       warning.detail.empty() ? "" : ": ", warning.detail));
  }
}

void WarningLog::note_readings(const std::vector<GaugeReading>& readings) {
  for (const auto& reading : readings) {
    auto& series = series_[reading.gauge];
    series.readings += 1.0;
    series.values += std::isnan(reading.value) ? 0.0 : 1.0;
  }
}

void WarningLog::note_gauges(double time) {
  const auto listed = [](const std::vector<std::string>& names) {
    std::string text;
    for (const auto& name : names) text += (text.empty() ? "" : ", ") + name;
    return text;
  };
  std::vector<std::string> absent, empty;
  for (const auto& gauge : gauges_) {
    // A gauge with several points or components has one series for each: name[0], name_x.
    const bool read = std::any_of(series_.begin(), series_.end(), [&](const auto& entry) {
      const std::string& name = entry.first;
      return name == gauge || (name.starts_with(gauge) && (name[gauge.size()] == '[' || name[gauge.size()] == '_'));
    });
    if (!read) absent.push_back(gauge);
  }
  for (const auto& [name, series] : series_)
    if (series.values == 0.0) empty.push_back(name);
  if (series_.empty() && gauges_.empty()) return;
  note(time, {{"gauges without any reading", static_cast<double>(absent.size()), listed(absent), false},
              {"gauges without a value in any reading", static_cast<double>(empty.size()),
               listed(empty) + ": nan throughout: what they read was never at their places", false}});
}

bool WarningLog::result_in_doubt() const {
  return std::any_of(warnings_.begin(), warnings_.end(), [](const Warning& w) { return w.result_in_doubt; });
}

void WarningLog::archive(Archive& archive) { archive(warnings_, series_); }

}  // namespace poretwin::coupling
