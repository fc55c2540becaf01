// Four doubles at a time, without intrinsics: loops over lanes that gcc and clang turn into the widest instructions of
// the machine they run on. The choice is made at run time, so that one binary serves every processor.
#pragma once

#include <cmath>
#include <cstddef>

namespace poretwin::coupling {

inline constexpr std::size_t n_lanes = 4;
// The alignment is said again because gcc takes a smaller one for processors without registers of this size.
using Lanes = double __attribute__((vector_size(n_lanes * sizeof(double)), aligned(n_lanes * sizeof(double))));
using LaneMask = long long __attribute__((vector_size(n_lanes * sizeof(long long))));

/// Lanes in a container.
struct alignas(Lanes) Quad {
  Lanes v;
};

// In place: vectors returned by value would depend on the instruction set a caller is compiled for.
[[gnu::always_inline]] inline void take_root(Lanes& a) {
  for (std::size_t l = 0; l < n_lanes; ++l) a[l] = std::sqrt(a[l]);
}
[[gnu::always_inline]] inline void raise_to(Lanes& a, const Lanes& least) { a = a > least ? a : least; }
[[gnu::always_inline]] inline void lower_to(Lanes& a, const Lanes& most) { a = a < most ? a : most; }
[[gnu::always_inline]] inline bool any(const LaneMask& mask) { return (mask[0] | mask[1] | mask[2] | mask[3]) != 0; }

/// What this machine has, by the levels of the x86-64 psABI. Tests set it lower to judge the other forms too.
enum class Instructions { plain, avx2, avx512 };
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

/// Runs a job compiled for this machine. Mark the job, and all it calls in its inner loops, always_inline.
template <class Job>
void run_lanes(const Job& job) {
#if defined(__x86_64__)
  if (instructions() == Instructions::avx512) return run_avx512(job);
  if (instructions() == Instructions::avx2) return run_avx2(job);
#endif
  run_plain(job);
}

}  // namespace poretwin::coupling
