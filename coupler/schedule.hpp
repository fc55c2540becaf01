// Temporal coupling: the order in which solvers advance, the fields they receive, and what follows a refused window.
// Serial: the fluid computes the window first, with the solid's fields at its start; then the solid, with the fluid's
// new fields. Parallel: both compute at the same time, each with the other's fields at the window's start.
// Iterated: serial passes through one window, until the solid's fields at its end equal those that the fluid received.
// Settled: serial passes until the solid moves as the fluid predicted; from the second pass on, the fluid also receives
// the fields with which the solid's last pass ended.
// docs/protocol.md shows the sequence of messages.
#pragma once

#include "common/checkpoint/schedule.hpp"
#include "common/coupling/border.hpp"
#include "common/coupling/summary.hpp"
#include "common/coupling/window_clock.hpp"
#include "coupler/broker.hpp"
#include "coupler/iteration.hpp"
#include "coupler/mapping.hpp"

#include <functional>
#include <map>
#include <memory>
#include <variant>

namespace poretwin::coupling {

struct ScheduleReport {
  double mapping = 0.0;  ///< s
  double wall = 0.0;     ///< s
  std::uint64_t windows = 0;
  std::uint64_t rejected_by_fluid = 0, rejected_by_solid = 0;
  std::uint64_t passes = 0;                         ///< of both solvers, including those of repeated windows
  std::uint64_t fields_skipped = 0;                 ///< given by one side but not taken by the other, hence not mapped
  std::uint64_t points_unchanged = 0;               ///< publications without points, which had not changed
  std::map<std::string, std::uint64_t> limited_by;  ///< what determined the window's length, and how often
  double time = 0.0;                                ///< s
  bool interrupted = false;
  MappingCounts pairs;
  std::vector<SpatialMapping::Account> accounts;
  double checkpointing = 0.0;  ///< s
  std::uint64_t checkpoints = 0;

  /// Writes or reads the counters from which a resumed run continues.
  void archive(Archive& archive) {
    archive(windows, passes, rejected_by_fluid, rejected_by_solid, fields_skipped, points_unchanged, limited_by);
  }
};

struct Serial {};
struct Parallel {};
struct Settled {
  double tolerance = 0.0;  ///< largest accepted value of `unsettled` in the solid's publication
};
using Scheme = std::variant<Serial, Parallel, IterationSettings, Settled>;

/// Number of passes through one window after which the window is refused and repeated with half its length.
inline constexpr unsigned most_passes = 12;

class Schedule {
 public:
  /// `mapping`: make_mapping(), or make_paired_mapping() for points that both solvers share. `progress` may be empty.
  Schedule(Broker& broker, std::unique_ptr<SpatialMapping> mapping, WindowClock::Settings settings,
           std::function<void(const Progress&)> progress = {}, Checkpoints checkpoints = {}, Scheme scheme = {},
           Trace* trace = nullptr);
  ~Schedule();
  Schedule(const Schedule&) = delete;
  Schedule& operator=(const Schedule&) = delete;

  /// Runs from the handshake to the goodbyes. Informs all participants of a failure before it throws the error.
  void run();
  /// Records which participant the coupler waits for; called by BrokerOptions::waiting.
  void note_waiting(const std::string& whom);
  [[nodiscard]] ScheduleReport report() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace poretwin::coupling
