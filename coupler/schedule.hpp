// Temporal coupling: who advances when, with whose fields, and what happens when a window is refused.
// Serial, fluid first: the fluid crosses the window with the solid's fields of its start, the solid with the fluid's
// new ones. Parallel: both at the same time, each with the other's fields of its start. Iterated: serial, until the
// solid's fields at the window's end are those that the fluid was given. Settled: serial, and repeated until the solid
// moves as the fluid predicted; from the second pass on the fluid also knows what the last pass found.
// docs/protocol.md shows the sequence.
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
  std::uint64_t passes = 0;                         ///< through both solvers, repeated windows included
  std::uint64_t fields_skipped = 0;                 ///< given, taken by nobody, hence not mapped
  std::uint64_t points_unchanged = 0;               ///< publications without their points
  std::map<std::string, std::uint64_t> limited_by;  ///< what set the window, and how often
  double time = 0.0;                                ///< s
  bool interrupted = false;
  MappingCounts pairs;
  std::vector<SpatialMapping::Account> accounts;
  double checkpointing = 0.0;  ///< s
  std::uint64_t checkpoints = 0;

  /// Counters from which a resumed run continues.
  void archive(Archive& archive) {
    archive(windows, passes, rejected_by_fluid, rejected_by_solid, fields_skipped, points_unchanged, limited_by);
  }
};

struct Serial {};
struct Parallel {};
struct Settled {
  double tolerance = 0.0;  ///< of what the solid reports as `unsettled`
};
using Scheme = std::variant<Serial, Parallel, IterationSettings, Settled>;

/// Passes through one repeated window after which it is refused and tried again at half its length.
inline constexpr unsigned most_passes = 12;

class Schedule {
 public:
  /// `mapping`: make_mapping(), or of points that both solvers share make_paired_mapping(). `progress` may be empty.
  Schedule(Broker& broker, std::unique_ptr<SpatialMapping> mapping, WindowClock::Settings settings,
           std::function<void(const Progress&)> progress = {}, Checkpoints checkpoints = {}, Scheme scheme = {},
           Trace* trace = nullptr);
  ~Schedule();
  Schedule(const Schedule&) = delete;
  Schedule& operator=(const Schedule&) = delete;

  /// Runs from the handshake to the goodbyes. On any failure all participants are notified before the error is thrown.
  void run();
  /// Notes for whom the coupler waits; BrokerOptions::waiting calls it.
  void note_waiting(const std::string& whom);
  [[nodiscard]] ScheduleReport report() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace poretwin::coupling
