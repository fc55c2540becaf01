#include "joint_solver/output/joined_frame.hpp"

#include <algorithm>
#include <limits>

namespace poretwin::joint {
namespace {

/// Values of the first for the first `count` particles, and of the second for the others; of an absent one NaN.
ParticleWriter one_after_other(std::size_t count, ParticleWriter first, ParticleWriter second, int components) {
  return [=](std::size_t i, double* numbers) {
    const ParticleWriter& write = i < count ? first : second;
    if (write)
      write(i < count ? i : i - count, numbers);
    else
      std::fill(numbers, numbers + components, std::numeric_limits<double>::quiet_NaN());
  };
}

}  // namespace

OutputFrame joined(OutputFrame free, OutputFrame ground) {
  const std::size_t n = free.count;
  OutputFrame out;
  out.time = free.time;
  out.count = n + ground.count;
  out.position = one_after_other(n, free.position, ground.position, 3);
  for (const auto& field : free.fields) {
    const auto same = std::find_if(ground.fields.begin(), ground.fields.end(),
                                   [&](const OutputField& other) { return other.name == field.name; });
    const ParticleWriter second = same == ground.fields.end() ? ParticleWriter() : same->write;
    out.fields.push_back({field, one_after_other(n, field.write, second, field.components)});
  }
  for (const auto& field : ground.fields)
    if (std::none_of(free.fields.begin(), free.fields.end(),
                     [&](const OutputField& other) { return other.name == field.name; }))
      out.fields.push_back({field, one_after_other(n, ParticleWriter(), field.write, field.components)});
  out.fields.push_back({{"in_soil", "1", "1: a point of the field in the soil; 0: a particle of free water", 1},
                        write_scalars([n](std::size_t i) { return i < n ? 0.0 : 1.0; })});
  return out;
}

}  // namespace poretwin::joint
