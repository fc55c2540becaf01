// What a phase must do to be run, coupled or alone: implemented by the fluid, by the solid and by mocks; driven by
// drive.hpp.
#pragma once

#include "common/core/archive.hpp"
#include "common/core/vector.hpp"
#include "common/core/warning.hpp"
#include "common/coupling/exchange.hpp"

#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace poretwin {

/// Writes the numbers of one particle to `numbers`.
using TellParticle = std::function<void(std::size_t particle, double* numbers)>;

/// What a field of the output means (it lands in the file's metadata).
struct FieldDeclaration {
  std::string name;  ///< no '/' and no '.'
  std::string unit;
  std::string description;
  int components = 1;  ///< 1, 3 (vectors; z = 0 in 2D) or 6 (symmetric tensors: xx yy zz xy yz xz)
};

struct OutputField : FieldDeclaration {
  TellParticle tell;  ///< all its components
};

/// All output of one phase at one time, as a file shows it. It is given particle by particle, so that it is never in
/// memory as a whole. Valid until the phase changes.
struct OutputFrame {
  double time = 0.0;
  std::size_t count = 0;  ///< of particles
  TellParticle position;  ///< three numbers, z = 0 in 2D
  std::vector<OutputField> fields;
};

/// Gives an array of vectors, one of each particle, with z = 0 in 2D. The array must outlive the frame.
template <int D>
TellParticle tell_vectors(const VecArray<D>& values) {
  return [&values](std::size_t i, double* numbers) {
    for (int d = 0; d < 3; ++d) numbers[d] = d < D ? values[i][d] : 0.0;
  };
}
/// Gives one number of each particle.
template <class Value>
TellParticle tell_scalars(Value value) {
  return [value](std::size_t i, double* number) { *number = value(i); };
}

struct GaugeReading {
  std::string gauge;
  double value = 0.0;  ///< NaN outside the phase
  std::string unit;
};

/// One phase of the mixture. All calls come from one thread, in the order: initialise, then (save, advance, [restore],
/// publish)*.
class Phase {
 public:
  Phase() = default;
  Phase(const Phase&) = delete;
  Phase& operator=(const Phase&) = delete;
  virtual ~Phase() = default;

  [[nodiscard]] virtual coupling::Contract contract() const = 0;

  /// Fields, points and proposed interval at the current time.
  [[nodiscard]] virtual coupling::Publication publish() const = 0;

  /// The part of a publication that is read where the phase runs alone: the proposed interval [s] and what sets it.
  [[nodiscard]] virtual std::pair<double, std::string> proposal() const {
    auto publication = publish();
    return {publication.proposed_interval, std::move(publication.limited_by)};
  }

  /// Called once, before the first window, with the other side's fields at time zero (the solid finds its rest under
  /// gravity here).
  virtual void initialise(const coupling::Inbox& inbox) = 0;

  /// Advances by one window. On rejection the caller restores. Throws DivergedError when nothing can be saved.
  virtual coupling::Outcome advance(const coupling::Window& window, const coupling::Inbox& inbox) = 0;

  /// save() keeps the complete state (particles, lists that affect results, warm starts, controllers), restore()
  /// returns to it.
  virtual void save() = 0;
  virtual void restore() = 0;

  /// Does it ever reject a window by itself? Where no phase does, no state is saved.
  [[nodiscard]] virtual bool may_reject() const { return true; }

  /// Writes the complete state to a checkpoint and reads it back, between windows: the run goes on bit by bit as if it
  /// had not been interrupted. Loading happens in a phase newly made from the same case, in place of initialise().
  virtual void archive(Archive& archive) = 0;

  [[nodiscard]] virtual OutputFrame frame() const = 0;
  [[nodiscard]] virtual std::vector<GaugeReading> gauges() const = 0;

  /// Counts for the run's summary: "particles", "substeps", "pressure iterations", "steps asleep", ...
  [[nodiscard]] virtual std::map<std::string, double> counters() const = 0;

  /// Warnings for the user, counted since the start; read after every accepted window.
  [[nodiscard]] virtual std::vector<Warning> warnings() const { return {}; }
};

}  // namespace poretwin
