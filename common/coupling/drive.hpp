// The loops that run a phase: coupled, with a participant as its connection to the coupler, or alone.
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

/// Totals of a run. They are updated continuously, so that they are also available after an exception.
struct DriveReport {
  double computing = 0.0, waiting = 0.0, sending = 0.0, writing = 0.0;  ///< s of wall-clock time
  std::uint64_t windows = 0, rejected = 0;
  std::map<std::string, std::uint64_t> limited_by;  ///< phase alone: reasons that limited windows, and how many
  double time = 0.0;                                ///< s, end of the last accepted window
  bool interrupted = false;
  std::string reason = "end";
  Trace* trace = nullptr;  ///< if set, receives all time spans
  WarningLog warnings;

  /// Saves or restores the counters from which a resumed run continues.
  void archive(Archive& archive) { archive(windows, rejected, limited_by, time, warnings); }
};

/// Joins, then executes the coupler's commands until FINISH. A failure of this phase is reported to all processes
/// (ABORT) and rethrown; a failure of another process arrives as Error with its cause. Without `checkpoints` the
/// participant must not have announced that it keeps checkpoints.
void drive_coupled(Phase& phase, Participant& participant, Recorder& recorder, DriveReport& report,
                   const CheckpointStore* checkpoints = nullptr);
DriveReport drive_coupled(Phase& phase, Participant& participant, Recorder& recorder);

using ProgressCallback = std::function<void(const Progress&)>;

/// Runs a phase alone (with an empty inbox) to the end of the case. A window is as long as the phase proposes and
/// coupling.interval and the output times allow. After a rejection the state is restored and the window repeated with a
/// shorter length. Calls interrupted() between windows. `shortest`: the shortest characteristic time [s] and its name,
/// from shortest_time(); 0: no check for runs that are stuck in tiny windows.
void drive_alone(Phase& phase, const Case& scene, Recorder& recorder, const ProgressCallback& progress,
                 DriveReport& report, Checkpoints checkpoints = {},
                 const std::pair<double, std::string>& shortest = {0.0, ""});
DriveReport drive_alone(Phase& phase, const Case& scene, Recorder& recorder, const ProgressCallback& progress = {});

/// Length [s] with which a rejected window is repeated: the suggested length, but at most half of the one tried.
double retry_interval(double tried, double suggested);

/// Wall-clock time of a window [s] from which on a phase alone saves its state before the next one, also if it never
/// rejects: a signal to stop then need not wait for its end.
inline constexpr double long_window = 0.5;

/// Number of successive rejections of one window after which the run is given up.
inline constexpr int most_rejections = 20;

}  // namespace poretwin::coupling
