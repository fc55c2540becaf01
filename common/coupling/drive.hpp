// The loops that run a phase: coupled, by a participant, or alone.
#pragma once

#include "common/case/case.hpp"
#include "common/checkpoint/schedule.hpp"
#include "common/coupling/participant.hpp"
#include "common/coupling/phase.hpp"
#include "common/coupling/summary.hpp"
#include "common/coupling/trace.hpp"
#include "common/coupling/warning_log.hpp"
#include "common/output/recorder.hpp"

#include <functional>
#include <map>

namespace poretwin::coupling {

/// What happened in a run; filled as it goes, so that it is there after an exception too.
struct DriveReport {
  double computing = 0.0, waiting = 0.0, sending = 0.0, writing = 0.0;  ///< s
  std::uint64_t windows = 0, rejected = 0;
  std::map<std::string, std::uint64_t> limited_by;  ///< of a phase alone: what set the window, and how often
  double time = 0.0;                                ///< s, end of the last accepted window
  bool interrupted = false;
  std::string reason = "end";
  Trace* trace = nullptr;  ///< what happens goes there too
  WarningLog warnings;

  /// Counters from which a resumed run continues.
  void archive(Archive& archive) { archive(windows, rejected, limited_by, time, warnings); }
};

/// Joins, then obeys the coupler until FINISH. Failures of the phase are reported to everybody (ABORT) and rethrown;
/// failures of others arrive as Error with the named cause.
/// Without `checkpoints` the participant must not have promised to keep any.
void drive_coupled(Phase& phase, Participant& participant, Recorder& recorder, DriveReport& report,
                   const CheckpointStore* checkpoints = nullptr);
DriveReport drive_coupled(Phase& phase, Participant& participant, Recorder& recorder);

using ProgressCallback = std::function<void(const Progress&)>;

/// Runs a phase without a partner (empty inbox) to the case's end. Windows are as long as the phase proposes,
/// coupling.interval and output instants allow; a rejected one is restored and repeated shorter. Asks interrupted()
/// between windows.
/// `shortest`: the shortest time in which the case moves, and of what (shortest_time()); 0: no check for windows that
/// are stuck.
void drive_alone(Phase& phase, const Case& scene, Recorder& recorder, const ProgressCallback& progress,
                 DriveReport& report, Checkpoints checkpoints = {},
                 const std::pair<double, std::string>& shortest = {0.0, ""});
DriveReport drive_alone(Phase& phase, const Case& scene, Recorder& recorder, const ProgressCallback& progress = {});

/// The length with which a rejected window is repeated: the suggested one, at most half of the one tried.
double retry_interval(double tried, double suggested);

/// Refusals of one window in a row after which the run is given up.
inline constexpr int most_rejections = 20;

}  // namespace poretwin::coupling
