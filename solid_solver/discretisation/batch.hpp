// Particles of one soil, four at a time. Work on single particles that ends in their constitutive model uses them.
#pragma once

#include "common/core/error.hpp"
#include "common/core/threads.hpp"
#include "solid_solver/setup.hpp"
#include "solid_solver/state.hpp"

#include <fmt/format.h>

#include <array>
#include <exception>
#include <mutex>
#include <vector>

namespace poretwin::solid {

/// Up to `most` particles. The last particle is repeated up to a multiple of four.
struct Batch {
  static constexpr std::size_t most = 256;
  Index soil = 0;
  std::size_t count = 0;
  std::array<Index, most> who;
  std::array<Four, most / n_lanes> fours;
  std::array<Quad, most / n_lanes> volume;     ///< m^D, new volume
  std::array<Quad, most / n_lanes> stiffness;  ///< factors on the elastic moduli, applied to the strains
  std::vector<Quad> state;                     ///< state variables of the material, consecutive for each group of four
  [[nodiscard]] std::size_t n_fours() const { return (count + n_lanes - 1) / n_lanes; }
};

/// The work of for_batches() on one part of the rows.
template <int D, class Wanted, class Treat>
void treat_part(const State<D>& state, std::size_t part, const Wanted& wanted, const Treat& treat) {
  const Pairs& pairs = state.near.pairs;
  Batch batch;
  const auto finish = [&] {
    if (batch.count == 0) return;
    for (std::size_t k = batch.count; k < batch.n_fours() * n_lanes; ++k) batch.who[k] = batch.who[batch.count - 1];
    treat(batch);
    batch.count = 0;
  };
  for (Index i = pairs.part[part]; i < pairs.part[part + 1]; ++i) {
    if (!wanted(i)) continue;
    const Index soil = state.particles.material[i];
    if (batch.count == Batch::most || soil != batch.soil) finish();
    batch.soil = soil;
    batch.who[batch.count++] = i;
  }
  finish();
}

/// Calls treat(batch) for all particles i for which wanted(i) holds, with the parts of the rows in parallel. wanted(i)
/// must not depend on the effect of treat() on other particles. Rethrows the exception of the lowest part that threw.
template <int D, class Wanted, class Treat>
void for_batches(const State<D>& state, const Wanted& wanted, const Treat& treat) {
  const Pairs& pairs = state.near.pairs;
  std::exception_ptr failed;  // of the lowest part; an exception must not leave its thread
  std::size_t failed_part = pairs.n_parts();
  std::mutex writing;
  for_each_part(pairs.n_parts(), [&](std::size_t part) {
    try {
      treat_part(state, part, wanted, treat);
    } catch (...) {
      const std::lock_guard lock(writing);
      if (part < failed_part) failed = std::current_exception();
      failed_part = std::min(failed_part, part);
    }
  });
  if (failed) std::rethrow_exception(failed);
}

/// Applies the material to a batch's strains: updates the stresses in the batch and the particles' state variables.
/// Throws DivergedError where the material fails.
template <int D>
void follow_strains(const Setup<D>& setup, Batch& batch, Particles<D>& particles) {
  const ConstitutiveModel& model = *setup.models[batch.soil];
  const std::size_t size = model.state_size();
  batch.state.resize(batch.n_fours() * size);
  for (std::size_t q = 0; q < batch.n_fours(); ++q) batch.fours[q].state = batch.state.data() + q * size;
  for (std::size_t k = 0; k < batch.n_fours() * n_lanes && size > 0; ++k)
    for (std::size_t s = 0; s < size; ++s)
      batch.fours[k / n_lanes].state[s].v[k % n_lanes] = particles.state_of(batch.who[k])[s];
  try {
    model.advance(std::span(batch.fours).first(batch.n_fours()));
  } catch (const MaterialFailure& failure) {
    const Index who = batch.who[failure.place];
    std::string where;
    for (int d = 0; d < D; ++d) where += fmt::format("{}{:.6g}", d > 0 ? ", " : "", particles.position[who][d]);
    throw DivergedError(fmt::format("soil[{}] at particle {} ({}) m: {}", batch.soil, who, where, failure.what));
  }
  for (std::size_t k = 0; k < batch.count && size > 0; ++k)
    for (std::size_t s = 0; s < size; ++s)
      particles.state_of(batch.who[k])[s] = batch.fours[k / n_lanes].state[s].v[k % n_lanes];
}

/// The packed data of four particles.
template <class Packed>
[[gnu::always_inline]] inline FourRows<const double> rows_at(const Packed* all, const Index* index) {
  return {all[index[0]].row(), all[index[1]].row(), all[index[2]].row(), all[index[3]].row()};
}

/// One value of each of four particles.
template <class Values>
[[gnu::always_inline]] inline void take_each(const Values& values, const Index* i, Lanes& taken) {
  taken = Lanes{values[i[0]], values[i[1]], values[i[2]], values[i[3]]};
}

/// The stresses of four particles.
[[gnu::always_inline]] inline void take_stresses(const std::vector<Tensor>& stress, const Index* i, Lanes* taken) {
  gather<0, 6>({stress[i[0]].data(), stress[i[1]].data(), stress[i[2]].data(), stress[i[3]].data()}, taken);
}

}  // namespace poretwin::solid
