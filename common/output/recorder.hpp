// Where a driver puts what a phase shows: files in a run folder, or memory in a test.
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
  /// Appends one frame; durable when it returns (a crash later leaves it readable). Throws FileError.
  virtual void frame(const OutputFrame& frame) = 0;
  virtual void gauges(double time, const std::vector<GaugeReading>& readings) = 0;
  /// Writes or reads, for a checkpoint, how far the output has come. Before writing the output is made durable; after
  /// reading, what was recorded later is removed.
  virtual void archive(Archive& archive) = 0;
  /// Files written so far, for the summary.
  [[nodiscard]] virtual std::vector<std::string> files() const = 0;
};

}  // namespace poretwin
