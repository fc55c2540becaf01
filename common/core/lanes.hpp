// Arithmetic on four doubles at a time, without intrinsics: gcc and clang compile the loops over lanes to the widest
// instructions of each machine. They are chosen at run time, so that one binary suits every processor.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace poretwin {

inline constexpr std::size_t n_lanes = 4;
// The alignment is stated explicitly: gcc uses a smaller one for processors without registers of this size.
using Lanes = double __attribute__((vector_size(n_lanes * sizeof(double)), aligned(n_lanes * sizeof(double))));
using LaneMask = long long __attribute__((vector_size(n_lanes * sizeof(long long))));

/// Lanes as an element of containers.
struct alignas(Lanes) Quad {
  Lanes v;
};

// In place: the way in which a vector is returned by value would depend on the instruction set of the caller's code.
[[gnu::always_inline]] inline void sqrt_in_place(Lanes& a) {
  for (std::size_t l = 0; l < n_lanes; ++l) a[l] = std::sqrt(a[l]);
}
[[gnu::always_inline]] inline void max_in_place(Lanes& a, const Lanes& least) { a = a > least ? a : least; }
[[gnu::always_inline]] inline void min_in_place(Lanes& a, const Lanes& most) { a = a < most ? a : most; }
[[gnu::always_inline]] inline bool any(const LaneMask& mask) { return (mask[0] | mask[1] | mask[2] | mask[3]) != 0; }

/// Types for code that is compiled for one particle at a time (InOnes) or for four (InFours). If Lanes itself were the
/// template argument, it would lose its alignment.
struct InOnes {
  using Number = double;
  using Mask = bool;
  static constexpr std::size_t width = 1;
};
struct InFours {
  using Number = Lanes;
  using Mask = LaneMask;
  static constexpr std::size_t width = n_lanes;
};

inline void sqrt_in_place(double& a) { a = std::sqrt(a); }
inline void max_in_place(double& a, double least) { a = a > least ? a : least; }
inline void min_in_place(double& a, double most) { a = a < most ? a : most; }
inline bool any(bool yes) { return yes; }

/// a = function(a), for each of the four numbers.
template <class Function>
[[gnu::always_inline]] inline void apply(const Function& function, Lanes& a) {
  for (std::size_t l = 0; l < n_lanes; ++l) a[l] = function(a[l]);
}
template <class Function>
void apply(const Function& function, double& a) {
  a = function(a);
}

/// Four doubles at any address. `aligned` is beside the alias's name because clang ignores it beside vector_size.
using LooseLanes __attribute__((aligned(sizeof(double)), may_alias)) =
    double __attribute__((vector_size(n_lanes * sizeof(double))));

/// Four floats anywhere in memory, to and from lanes.
using LooseFloats __attribute__((aligned(sizeof(float)), may_alias)) =
    float __attribute__((vector_size(n_lanes * sizeof(float))));
[[gnu::always_inline]] inline void take(const float* from, Lanes& to) {
  // Element by element: gcc 12 converts a vector of floats to doubles in two halves.
  to = Lanes{static_cast<double>(from[0]), static_cast<double>(from[1]), static_cast<double>(from[2]),
             static_cast<double>(from[3])};
}
[[gnu::always_inline]] inline void put(const Lanes& from, float* to) {
  *reinterpret_cast<LooseFloats*>(to) = __builtin_convertvector(from, LooseFloats);
}

inline void take(const float* from, double& to) { to = static_cast<double>(*from); }
inline void put(double from, float* to) { *to = static_cast<float>(from); }

[[gnu::always_inline]] inline void transpose(Lanes& a, Lanes& b, Lanes& c, Lanes& d) {
  const Lanes low_ab = __builtin_shufflevector(a, b, 0, 4, 2, 6), high_ab = __builtin_shufflevector(a, b, 1, 5, 3, 7);
  const Lanes low_cd = __builtin_shufflevector(c, d, 0, 4, 2, 6), high_cd = __builtin_shufflevector(c, d, 1, 5, 3, 7);
  a = __builtin_shufflevector(low_ab, low_cd, 0, 1, 4, 5);
  b = __builtin_shufflevector(high_ab, high_cd, 0, 1, 4, 5);
  c = __builtin_shufflevector(low_ab, low_cd, 2, 3, 6, 7);
  d = __builtin_shufflevector(high_ab, high_cd, 2, 3, 6, 7);
}

/// Four rows of numbers. The same columns are read from each.
template <class Number>
using FourRows = std::array<Number*, n_lanes>;

/// The single row that code for one particle reads in place of four rows.
template <class Number>
struct OneRow {
  Number* row;
};

/// Reads columns first .. first + n - 1 of four rows, one row per lane. Besides these it reads no columns except,
/// possibly, some of the first four.
template <std::size_t first, std::size_t n>
[[gnu::always_inline]] inline void gather(const FourRows<const double>& rows, Lanes* column) {
  constexpr std::size_t taken = n < n_lanes ? n : n_lanes, skipped = first + taken < n_lanes ? 0 : n_lanes - taken;
  Lanes x[n_lanes];
  for (std::size_t l = 0; l < n_lanes; ++l) x[l] = *reinterpret_cast<const LooseLanes*>(rows[l] + first - skipped);
  transpose(x[0], x[1], x[2], x[3]);
  for (std::size_t k = 0; k < taken; ++k) column[k] = x[skipped + k];
  if constexpr (n > n_lanes) gather<first + n_lanes, n - n_lanes>(rows, column + n_lanes);
}

template <std::size_t first, std::size_t n>
void gather(const OneRow<const double>& from, double* column) {
  for (std::size_t k = 0; k < n; ++k) column[k] = from.row[first + k];
}

/// Reads one column.
[[gnu::always_inline]] inline void gather_one(const FourRows<const double>& rows, std::size_t k, Lanes& column) {
  column = Lanes{rows[0][k], rows[1][k], rows[2][k], rows[3][k]};
}
inline void gather_one(const OneRow<const double>& from, std::size_t k, double& column) { column = from.row[k]; }

/// Sum of weighted vectors of D components, four vectors at a time. The lanes are added in pairs, so that the result is
/// the same on every machine.
template <int D>
struct VectorSum {
  Lanes sums[D] = {};
  [[gnu::always_inline]] void add(const Lanes& weight, const FourRows<const double>& vectors) {
    for (std::size_t d = 0; d < D; ++d)
      sums[d] += weight * Lanes{vectors[0][d], vectors[1][d], vectors[2][d], vectors[3][d]};
  }
  [[nodiscard, gnu::always_inline]] double total(std::size_t d) const {
    return (sums[d][0] + sums[d][1]) + (sums[d][2] + sums[d][3]);
  }
};
/// In 2D two vectors fill the lanes in the order in which they are in memory.
template <>
struct VectorSum<2> {
  Lanes first{}, second{};
  [[gnu::always_inline]] void add(const Lanes& weight, const FourRows<const double>& vectors) {
    using Two __attribute__((aligned(sizeof(double)), may_alias)) =
        double __attribute__((vector_size(2 * sizeof(double))));
    const auto two = [&](std::size_t l) __attribute__((always_inline)) {
      return reinterpret_cast<const Two*>(vectors[l]);
    };
    first +=
        __builtin_shufflevector(weight, weight, 0, 0, 1, 1) * __builtin_shufflevector(*two(0), *two(1), 0, 1, 2, 3);
    second +=
        __builtin_shufflevector(weight, weight, 2, 2, 3, 3) * __builtin_shufflevector(*two(2), *two(3), 0, 1, 2, 3);
  }
  [[nodiscard, gnu::always_inline]] double total(std::size_t d) const {
    return (first[d] + first[2 + d]) + (second[d] + second[2 + d]);
  }
};

/// Adds columns 0 .. n - 1 to four rows. n: a multiple of four. Rows must differ, except where zero is added.
template <std::size_t n>
[[gnu::always_inline]] inline void scatter_add(const Lanes* column, const FourRows<double>& rows) {
  for (std::size_t k = 0; k < n; k += n_lanes) {
    Lanes x[n_lanes] = {column[k], column[k + 1], column[k + 2], column[k + 3]};
    transpose(x[0], x[1], x[2], x[3]);
    for (std::size_t l = 0; l < n_lanes; ++l) *reinterpret_cast<LooseLanes*>(rows[l] + k) += x[l];
  }
}

template <std::size_t n>
void scatter_add(const double* column, const OneRow<double>& to) {
  for (std::size_t k = 0; k < n; ++k) to.row[k] += column[k];
}

/// Adds the sum over a column's lanes to each of n numbers; n is a multiple of four.
template <std::size_t n>
[[gnu::always_inline]] inline void add_lanes(const Lanes* column, double* row) {
  for (std::size_t k = 0; k < n; k += n_lanes) {
    Lanes x[n_lanes] = {column[k], column[k + 1], column[k + 2], column[k + 3]};
    transpose(x[0], x[1], x[2], x[3]);
    *reinterpret_cast<LooseLanes*>(row + k) += (x[0] + x[1]) + (x[2] + x[3]);
  }
}

template <std::size_t n>
void add_lanes(const double* column, double* row) {
  for (std::size_t k = 0; k < n; ++k) row[k] += column[k];
}

/// Sum over a number's lanes, in the same order as in add_lanes.
[[gnu::always_inline]] inline double sum_of_lanes(const Lanes& a) { return (a[0] + a[1]) + (a[2] + a[3]); }
inline double sum_of_lanes(double a) { return a; }
[[gnu::always_inline]] inline double least_of_lanes(const Lanes& a) {
  return std::min(std::min(a[0], a[1]), std::min(a[2], a[3]));
}
inline double least_of_lanes(double a) { return a; }
/// Increases the first lane by `amount`.
[[gnu::always_inline]] inline void add_to_first(double amount, Lanes& a) { a[0] += amount; }
inline void add_to_first(double amount, double& a) { a += amount; }

/// Instruction sets of this machine, as levels of the x86-64 psABI. Tests set a lower level to check the other
/// variants. scalar: loops over pairs (common/particles/for_pairs.hpp) take one pair at a time; else as plain.
enum class Instructions { scalar, plain, avx2, avx512 };
inline Instructions& instructions() {
#if defined(__x86_64__)
  static Instructions found = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                                      __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
                                      __builtin_cpu_supports("avx512vl")
                                  ? Instructions::avx512
                              : __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
                                      __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2")
                                  ? Instructions::avx2
                                  : Instructions::plain;
#else
  static Instructions found = Instructions::plain;
#endif
  return found;
}

#if defined(__x86_64__)
template <class Job>
[[gnu::target("avx2,fma,bmi,bmi2")]] void run_avx2(const Job& job) {
  job();
}
template <class Job>
[[gnu::target("avx2,fma,bmi,bmi2,avx512f,avx512bw,avx512cd,avx512dq,avx512vl")]] void run_avx512(const Job& job) {
  job();
}
#endif
template <class Job>
void run_plain(const Job& job) {
  job();
}

/// Runs a job compiled for this machine. The job and all it calls in its inner loops must be always_inline.
template <class Job>
void run_lanes(const Job& job) {
#if defined(__x86_64__)
  if (instructions() == Instructions::avx512) return run_avx512(job);
  if (instructions() == Instructions::avx2) return run_avx2(job);
#endif
  run_plain(job);
}

}  // namespace poretwin
