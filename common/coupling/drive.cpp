#include "common/coupling/drive.hpp"

#include "common/core/memory.hpp"
#include "common/coupling/interrupt.hpp"
#include "common/coupling/window_clock.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <new>

namespace poretwin::coupling {
namespace {

/// An activity of which the time is measured.
struct Activity {
  const char* name;
  double DriveReport::*seconds;
};
constexpr Activity computing{"computing", &DriveReport::computing}, waiting{"waiting", &DriveReport::waiting},
    sending{"sending", &DriveReport::sending}, writing{"writing", &DriveReport::writing};

/// Runs f and adds its duration to the report, also when f throws.
template <class F>
decltype(auto) timed(DriveReport& report, const Activity& activity, F&& f) {
  const Span span(report.*activity.seconds, report.trace, activity.name);
  return f();
}

/// Advances by a window, or rejects it where the phase gives it up.
Outcome advance_or_give_up(Phase& phase, const Window& window, const Inbox& inbox) {
  try {
    return phase.advance(window, inbox);
  } catch (const WindowGivenUp& given_up) {
    return Outcome::reject(window.interval, given_up.what());
  }
}

/// Keeps back the frame and gauges of a window until the window is known to be final.
class PendingRecord {
 public:
  PendingRecord(const Phase& phase, Recorder& recorder, DriveReport& report)
      : phase_(phase), recorder_(recorder), report_(report) {}
  void ask(bool frame, bool gauges) {
    frame_ = frame;
    gauges_ = gauges;
    frame_written_ = gauges_written_ = false;
  }
  void forget() { frame_ = gauges_ = false; }
  void archive(Archive& archive) { archive(frame_, gauges_, frame_written_, gauges_written_); }
  void write() {
    report_.warnings.note(report_.time, phase_.warnings());
    write_now(frame_, gauges_);
  }
  /// Writes frame and gauges even where none were requested, but not twice for the same state.
  void write_now(bool frame, bool gauges) {
    timed(report_, writing, [&] {
      // Gauges first: frames show some of the values that gauge readings compute.
      if (gauges && !gauges_written_) {
        const auto readings = phase_.gauges();
        report_.warnings.note_readings(readings);
        recorder_.gauges(report_.time, readings);
      }
      if (frame && !frame_written_) recorder_.frame(phase_.frame());
    });
    frame_written_ = frame_written_ || frame;
    gauges_written_ = gauges_written_ || gauges;
    forget();
  }

 private:
  const Phase& phase_;
  Recorder& recorder_;
  DriveReport& report_;
  bool frame_ = false, gauges_ = false, frame_written_ = false, gauges_written_ = false;
};

class CoupledRun {
 public:
  CoupledRun(Phase& phase, Participant& participant, Recorder& recorder, DriveReport& report,
             const CheckpointStore* checkpoints)
      : phase_(phase),
        participant_(participant),
        recorder_(recorder),
        report_(report),
        pending_(phase, recorder, report),
        checkpoints_(checkpoints) {}

  void run() {
    timed(report_, waiting, [&] { participant_.join(); });
    publish();
    for (;;) {
      const Command command = timed(report_, waiting, [&] { return participant_.receive(); });
      switch (command.kind) {
        case Command::Kind::initialise:
          initialise(command);
          break;
        case Command::Kind::resume:
          resume(command);
          break;
        case Command::Kind::checkpoint:
          write_checkpoint(command);
          break;
        case Command::Kind::advance:
          advance(command);
          break;
        case Command::Kind::restore:
          restore();
          break;
        case Command::Kind::finish:
          finish(command);
          return;
      }
    }
  }

 private:
  void publish() {
    Publication publication = timed(report_, computing, [&] { return phase_.publish(); });
    timed(report_, sending, [&] { participant_.publish(std::move(publication)); });
  }

  void initialise(const Command& command) {
    if (checkpoints_) checkpoints_->keep_only({});
    timed(report_, computing, [&] { phase_.initialise(command.inbox); });
    keep_freed_memory();
    publish();
    pending_.ask(command.record_frame, command.record_gauges);
    pending_.write();
  }

  void archive(Archive& archive) { archive(phase_, recorder_, report_, pending_); }

  void write_checkpoint(const Command& command) {
    if (!checkpoints_) throw PeerError("the coupler asks for a checkpoint, none was promised");
    pending_.write();
    timed(report_, writing, [&] {
      // Old checkpoints are removed before the new one is written. `keep` does not name the new one yet: the coupler
      // lists it only after this process has reported it.
      checkpoints_->keep_only(command.keep);
      Archive state;
      archive(state);
      checkpoints_->write({command.checkpoint, command.window.step, report_.time}, state);
    });
    participant_.confirm_checkpoint(command.checkpoint);
  }

  void resume(const Command& command) {
    if (!checkpoints_) throw PeerError("the coupler asks to resume, no checkpoint was promised");
    timed(report_, writing, [&] {
      Archive state = checkpoints_->read(command.checkpoint);
      archive(state);
      state.expect_end();
    });
    publish();
    keep_freed_memory();
  }

  void advance(const Command& command) {
    pending_.write();
    advanced_ = false;
    const Outcome outcome = timed(report_, computing, [&] {
      phase_.save();
      Window window = command.window;
      window.saved = true;
      return advance_or_give_up(phase_, window, command.inbox);
    });
    if (!outcome.accepted) {
      ++report_.rejected;
      timed(report_, sending, [&] { participant_.reject(outcome); });
      return;
    }
    publish();
    before_ = report_.time;
    ++report_.windows;
    report_.time = command.window.time + command.window.interval;
    advanced_ = true;
    pending_.ask(command.record_frame, command.record_gauges);
  }

  void restore() {
    timed(report_, computing, [&] { phase_.restore(); });
    pending_.forget();
    if (!advanced_) return;
    // This phase accepted the window, but the other did not.
    advanced_ = false;
    --report_.windows;
    ++report_.rejected;
    report_.time = before_;
  }

  void finish(const Command& command) {
    pending_.write();
    pending_.write_now(command.record_frame, command.record_gauges);
    report_.reason = command.reason;
    report_.interrupted = command.reason == "interrupted";
    if (!report_.interrupted) report_.warnings.note_gauges(report_.time);
    participant_.bye(command.reason);
  }

  Phase& phase_;
  Participant& participant_;
  Recorder& recorder_;
  DriveReport& report_;
  PendingRecord pending_;
  const CheckpointStore* checkpoints_;
  double before_ = 0.0;
  bool advanced_ = false;
};

}  // namespace

double retry_interval(double tried, double suggested) {
  return suggested > 0.0 && std::isfinite(suggested) ? std::min(suggested, 0.5 * tried) : 0.5 * tried;
}

void drive_coupled(Phase& phase, Participant& participant, Recorder& recorder, DriveReport& report,
                   const CheckpointStore* checkpoints) {
  const std::string who(to_string(participant.role()));
  try {
    CoupledRun(phase, participant, recorder, report, checkpoints).run();
  } catch (const Error& error) {
    // The coupler already knows that a peer failed, or is gone itself; a second report does no harm.
    participant.abort(error.what(), error.code());
    throw;
  } catch (const std::bad_alloc&) {
    participant.abort("out of memory", ExitCode::failure);
    throw;
  } catch (const std::exception& error) {
    participant.abort(error.what(), ExitCode::failure);
    throw;
  }
}

DriveReport drive_coupled(Phase& phase, Participant& participant, Recorder& recorder) {
  DriveReport report;
  drive_coupled(phase, participant, recorder, report);
  return report;
}

void drive_alone(Phase& phase, const Case& scene, Recorder& recorder, const ProgressCallback& progress,
                 DriveReport& report, Checkpoints checkpoints, const std::pair<double, std::string>& shortest) {
  WindowClock clock({scene.general.end_time, scene.coupling.interval, scene.output.interval,
                     scene.output.gauge_interval, shortest.first, shortest.second});
  PendingRecord record(phase, recorder, report);
  const Inbox nothing;
  std::uint64_t step = 0;
  int rejections = 0;
  double limit = no_limit, took = long_window;  // took: s of wall-clock time, for the last window
  CheckpointSchedule schedule(checkpoints);
  auto archive = [&](Archive& state) { state(phase, recorder, report, record, clock, step); };
  auto write_checkpoint = [&] {
    timed(report, writing, [&] {
      const std::string name = schedule.name(step);
      Archive state;
      archive(state);
      checkpoints.store->write({name, step, clock.time()}, state);
      schedule.committed(name);
      checkpoints.store->keep_only(schedule.kept());
    });
  };
  if (checkpoints.resume) {
    const auto found = checkpoints.store->whole();
    if (found.empty()) throw FileError("nothing to resume from: expected a checkpoint in the run's folder, found none");
    Archive state = checkpoints.store->read(found.front().name);
    archive(state);
    state.expect_end();
    std::vector<std::string> names;
    for (const auto& checkpoint : found) names.push_back(checkpoint.name);
    schedule.set_kept(names);
  } else {
    if (checkpoints.store) checkpoints.store->keep_only({});
    timed(report, computing, [&] { phase.initialise(nothing); });
    record.write();
    record.write_now(true, true);
  }
  keep_freed_memory();
  while (!clock.finished() && !interrupted()) {
    const auto [proposed, cause] = timed(report, computing, [&] { return phase.proposal(); });
    const auto plan = clock.plan(std::min(proposed, limit));
    const bool saved = phase.may_reject() || took >= long_window;
    const Window window{.step = step + 1, .time = plan.start, .interval = plan.interval, .saved = saved};
    const double before = report.computing;
    const Outcome outcome = timed(report, computing, [&] {
      if (saved) phase.save();
      return advance_or_give_up(phase, window, nothing);
    });
    took = report.computing - before;
    if (!outcome.accepted) {
      ++report.rejected;
      if (++rejections > most_rejections)
        throw DivergedError(fmt::format("window {} from t = {:g} s was rejected {} times, last at {:g} s: {}",
                                        window.step, window.time, rejections, window.interval, outcome.reason));
      if (saved) timed(report, computing, [&] { phase.restore(); });
      limit = retry_interval(plan.interval, outcome.suggested_interval);
      continue;
    }
    rejections = 0;
    limit = no_limit;
    ++step;
    ++report.windows;
    const std::string held_by = plan.interval < 0.999 * proposed ? "output instant or coupling.interval" : cause;
    ++report.limited_by[held_by];
    clock.accept(plan, held_by);
    report.time = clock.time();
    record.ask(plan.record_frame, plan.record_gauges);
    record.write();
    if (progress) progress({clock.time(), clock.end(), step, plan.interval, ""});
    if (schedule.due() && !clock.finished()) write_checkpoint();
  }
  if (!clock.finished()) {
    if (checkpoints.store) write_checkpoint();
    report.interrupted = true;
    report.reason = "interrupted";
    record.write_now(true, true);
  }
  if (!report.interrupted) report.warnings.note_gauges(report.time);
}

DriveReport drive_alone(Phase& phase, const Case& scene, Recorder& recorder, const ProgressCallback& progress) {
  DriveReport report;
  drive_alone(phase, scene, recorder, progress, report);
  return report;
}

}  // namespace poretwin::coupling
