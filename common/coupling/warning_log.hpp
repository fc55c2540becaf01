// The warnings of a run: each is logged at its first occurrence, and all are counted for the summary. A gauge without
// any reading also causes a warning.
#pragma once

#include "common/core/archive.hpp"
#include "common/core/warning.hpp"
#include "common/coupling/phase.hpp"

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace poretwin::coupling {

class WarningLog {
 public:
  /// `say`: writes one line to the log. `gauges`: names of the case's gauges that this process reads.
  void begin(std::function<void(const std::string&)> say, std::vector<std::string> gauges);
  /// Adds the phase's warnings at this time [s], with their counts since the start.
  void note(double time, const std::vector<Warning>& warnings);
  void note_readings(const std::vector<GaugeReading>& readings);
  /// At the run's end: warns of gauges that were never read or never had a value.
  void note_gauges(double time);
  [[nodiscard]] const std::vector<Warning>& all() const { return warnings_; }
  [[nodiscard]] bool result_in_doubt() const;
  void archive(Archive& archive);

 private:
  struct Series {
    double readings = 0.0, values = 0.0;  ///< all readings; readings that are not NaN
  };
  std::function<void(const std::string&)> say_;
  std::vector<std::string> gauges_;
  std::vector<Warning> warnings_;
  std::map<std::string, Series> series_;
};

}  // namespace poretwin::coupling
