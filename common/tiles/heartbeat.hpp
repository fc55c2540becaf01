// Signs of life among the ranks of one solver, so that a rank that has stopped does not keep the others waiting.
#pragma once

#include "common/tiles/communicator.hpp"

#include <memory>

namespace poretwin::tiles {

/// While this lives, a thread of its own sends a datagram (UDP) to the next rank four times a second and listens to the
/// previous one. A rank that is not heard of for 2 s has been stopped, or its machine or network is gone: it is named
/// on stderr, and the run ends with exit code 3. A rank that computes for long keeps sending and is waited for. A
/// process that was itself stopped or asleep begins to listen anew. Machines whose names cannot be resolved from each
/// other are named on stderr, and nothing is sent between them. All ranks create and destroy it.
class Heartbeat {
 public:
  explicit Heartbeat(const Communicator& all);
  ~Heartbeat();
  Heartbeat(const Heartbeat&) = delete;
  Heartbeat& operator=(const Heartbeat&) = delete;

 private:
  class Pulse;
  std::unique_ptr<Pulse> pulse_;
};

}  // namespace poretwin::tiles
