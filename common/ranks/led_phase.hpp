// A phase that several ranks compute together. Rank 0 leads: it alone reads arguments, speaks with the coupler, writes
// files and decides when the run ends, as if it were the only process. The other ranks follow: they make the calls of
// the phase that rank 0 makes.
#pragma once

#include "common/case/case.hpp"
#include "common/coupling/phase.hpp"
#include "common/tiles/communicator.hpp"

#include <functional>
#include <memory>

namespace poretwin::ranks {

using MakePart = std::function<std::unique_ptr<Phase>(const Case&)>;

/// Calls of a phase that all ranks make together, and the end of the run.
enum class Call {
  make,
  initialise,
  publish,
  propose,
  advance,
  save,
  restore,
  write_state,
  read_state,
  frame,
  gauges,
  counters,
  end
};

/// Rank 0's way to announce calls to the others. It must outlive the phases that it makes.
class Leader {
 public:
  explicit Leader(const tiles::Communicator& all) : all_(all) {}
  /// The phase of the case, as if it were computed by this process alone: all ranks make their parts, and every later
  /// call is passed on to them. Throws what the part throws.
  std::unique_ptr<Phase> make(const Case& scene, const MakePart& part);
  /// Lets the others end. Throws, with the exit code that this rank's work had, where a call failed on this rank only:
  /// the others wait for messages that will not come, and end when this process does.
  void end(int code);

  /// Announces a call, with its arguments, to the other ranks, then makes it on this one.
  template <class Make, class... Arguments>
  auto call(Call what, Make&& make, Arguments... arguments) {
    Archive said;
    said(what, arguments...);
    announce(said.bytes());
    try {
      return make();
    } catch (...) {
      failed_ = true;
      throw;
    }
  }
  /// Whether a call failed: the other ranks hear of no further one.
  [[nodiscard]] bool failed() const { return failed_; }
  void at_step(std::uint64_t step) const { all_.at_step(step); }

 private:
  void announce(const std::string& call) const;

  const tiles::Communicator& all_;
  bool failed_ = false;
};

/// Makes the calls that rank 0 announces, until the end. Throws what this rank's part throws; so that rank 0, where it
/// meets the same error, can report it and end the run, the exception leaves a second later.
void follow(const tiles::Communicator& all, const MakePart& part);

}  // namespace poretwin::ranks
