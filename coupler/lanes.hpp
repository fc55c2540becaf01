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

/// Does this machine have AVX2 and FMA? Tests switch it off to judge the plain form too.
inline bool& wide_lanes() {
#if defined(__x86_64__)
  static bool wide = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#else
  static bool wide = false;
#endif
  return wide;
}

template <class Job>
void run_plain(const Job& job) {
  job();
}
#if defined(__x86_64__)
template <class Job>
[[gnu::target("arch=x86-64-v4")]] void run_wide(const Job& job) {
  job();
}
#endif

/// Runs a job compiled for this machine. Mark the job, and all it calls in its inner loops, always_inline.
template <class Job>
void run_lanes(const Job& job) {
#if defined(__x86_64__)
  if (wide_lanes()) return run_wide(job);
#endif
  run_plain(job);
}

}  // namespace poretwin::coupling
