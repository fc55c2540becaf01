// The interface that a phase implements in order to be run, coupled or alone. The fluid, the solid and mocks implement
// it. drive.hpp runs it.
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

/// Writes all components of one particle to `numbers`.
using ParticleWriter = std::function<void(std::size_t particle, double* numbers)>;

/// Describes a field of the output; it is written to the file's metadata.
struct FieldDeclaration {
  std::string name;  ///< no '/' and no '.'
  std::string unit;
  std::string description;
  int components = 1;  ///< 1, 3 (vectors; z = 0 in 2D) or 6 (symmetric tensors: xx yy zz xy yz xz)
};

struct OutputField : FieldDeclaration {
  ParticleWriter write;  ///< writes all components of the field for one particle
};

/// All output of one phase at one time. It is read particle by particle, so that it is never completely in memory. It
/// is valid until the phase changes.
struct OutputFrame {
  double time = 0.0;
  std::size_t count = 0;    ///< number of particles
  ParticleWriter position;  ///< three numbers, z = 0 in 2D
  std::vector<OutputField> fields;
};

/// Components of one vector per particle, value(i); z = 0 in 2D.
template <int D, class Value>
ParticleWriter write_vectors_by(Value value) {
  return [value](std::size_t i, double* numbers) {
    const Vec<D> vector = value(i);
    for (int d = 0; d < 3; ++d) numbers[d] = d < D ? vector[d] : 0.0;
  };
}
/// As write_vectors_by(), for an array, which must outlive the frame.
template <int D>
ParticleWriter write_vectors(const VecArray<D>& values) {
  return write_vectors_by<D>([&values](std::size_t i) { return values[i]; });
}
/// One number per particle.
template <class Value>
ParticleWriter write_scalars(Value value) {
  return [value](std::size_t i, double* number) { *number = value(i); };
}

struct GaugeReading {
  std::string gauge;
  double value = 0.0;  ///< NaN outside the phase
  std::string unit;
};

/// One phase of the mixture. All calls come from one thread, in the order: initialise, then repeatedly save, advance,
/// if necessary restore, and publish.
class Phase {
 public:
  Phase() = default;
  Phase(const Phase&) = delete;
  Phase& operator=(const Phase&) = delete;
  virtual ~Phase() = default;

  [[nodiscard]] virtual coupling::Contract contract() const = 0;

  /// Fields, points and proposed interval at the current time.
  [[nodiscard]] virtual coupling::Publication publish() const = 0;

  /// The part of a publication that a phase needs alone: the proposed interval [s] and the reason for its limit.
  [[nodiscard]] virtual std::pair<double, std::string> proposal() const {
    auto publication = publish();
    return {publication.proposed_interval, std::move(publication.limited_by)};
  }

  /// Called once, before the first window, with the other phase's fields at time zero (the solid finds its initial
  /// equilibrium here).
  virtual void initialise(const coupling::Inbox& inbox) = 0;

  /// Advances by one window. After a rejection the caller restores the state. Throws DivergedError if no shorter window
  /// would help, and WindowGivenUp if the process is to stop and the window's start is saved.
  virtual coupling::Outcome advance(const coupling::Window& window, const coupling::Inbox& inbox) = 0;

  /// save() stores the complete state (particles, lists that affect results, initial guesses, controllers); restore()
  /// returns to the stored state.
  virtual void save() = 0;
  virtual void restore() = 0;

  /// Whether the phase, run alone, may reject a window. If not, drive_alone() saves its state before long windows only.
  [[nodiscard]] virtual bool may_reject() const { return true; }

  /// Writes the complete state to a checkpoint between windows, or reads it. After reading, the run continues bit by
  /// bit as if it had not been interrupted. A phase that reads has just been made from the same case, and initialise()
  /// is not called.
  virtual void archive(Archive& archive) = 0;

  [[nodiscard]] virtual OutputFrame frame() const = 0;
  [[nodiscard]] virtual std::vector<GaugeReading> gauges() const = 0;

  /// Counters for the run's summary: "particles", "substeps", "pressure iterations", "steps asleep", ...
  [[nodiscard]] virtual std::map<std::string, double> counters() const = 0;

  /// Warnings for the user, with counts since the start of the run. They are read after every accepted window.
  [[nodiscard]] virtual std::vector<Warning> warnings() const { return {}; }
};

}  // namespace poretwin
