// The object to which a driver writes frames and gauges of a phase: files in a run folder, or memory in a test.
#pragma once

#include "common/core/archive.hpp"
#include "common/coupling/phase.hpp"

#include <string>
#include <vector>

namespace poretwin {

class Recorder {
 public:
  Recorder() = default;
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;
  virtual ~Recorder() = default;
  /// Appends one frame. It is durable when the function returns: a later crash leaves it readable. Throws FileError.
  virtual void frame(const OutputFrame& frame) = 0;
  virtual void gauges(double time, const std::vector<GaugeReading>& readings) = 0;
  /// Saves or restores, for a checkpoint, the length of the output. Before saving, the output is made durable. After
  /// restoring, later output is removed.
  virtual void archive(Archive& archive) = 0;
  /// Files written so far, for the summary.
  [[nodiscard]] virtual std::vector<std::string> files() const = 0;
};

}  // namespace poretwin
