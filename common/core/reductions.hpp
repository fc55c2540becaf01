// Sums and maxima over the entries of one rank. Decisions about a whole run need all ranks: there solvers call Domain
// (common/particles/domain.hpp), and only Domain calls these functions.
#pragma once

#include "common/core/threads.hpp"
#include "common/core/vector.hpp"

#include <algorithm>
#include <array>
#include <span>

namespace poretwin::one_rank {

/// Sum of of_block(first, last) over blocks of fixed size in 0 .. n - 1. The result does not depend on the number of
/// threads.
template <class Block>
double sum_in_blocks(std::size_t n, const Block& of_block) {
  constexpr std::size_t block = 8192;
  if (n <= block) return of_block(std::size_t{0}, n);
  ScalarArray sums((n + block - 1) / block);
  parallel_ranges(n, [&](std::size_t first, std::size_t last) {
    // The blocks that begin in this part.
    for (std::size_t i = (first + block - 1) / block; i * block < last; ++i)
      sums[i] = of_block(i * block, std::min(n, (i + 1) * block));
  });
  double sum = 0.0;
  for (const double one : sums) sum += one;
  return sum;
}

inline double dot(std::span<const double> a, std::span<const double> b) {
  return sum_in_blocks(a.size(), [&](std::size_t i, std::size_t last) {
    std::array<double, 4> sum{};
    for (; i + 4 <= last; i += 4)
      for (std::size_t k = 0; k < 4; ++k) sum[k] += a[i + k] * b[i + k];
    for (; i < last; ++i) sum[0] += a[i] * b[i];
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
  });
}

/// Sum of part(i) over 0 .. n - 1.
template <class Part>
double sum_over(std::size_t n, const Part& part) {
  return sum_in_blocks(n, [&](std::size_t i, std::size_t last) {
    double sum = 0.0;
    for (; i < last; ++i) sum += part(i);
    return sum;
  });
}

/// Maximum of `least` and value(i) for all i in 0 .. n - 1; evaluated in parallel.
template <class Value>
double max_over(std::size_t n, double least, const Value& value) {
  const std::size_t parts = small_parts_for(n);
  std::vector<double> most(parts, least);
  for_each_part(parts, [&](std::size_t part) {
    double here = least;
    for (std::size_t i = n * part / parts; i < n * (part + 1) / parts; ++i) here = std::max(here, value(i));
    most[part] = here;
  });
  return *std::max_element(most.begin(), most.end());
}

}  // namespace poretwin::one_rank
