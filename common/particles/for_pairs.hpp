// The loop over pairs of particles that all physics uses. A body computes one pair independently of its number type: it
// is compiled for single numbers and for four at a time. Threads that share the rows call it.
//
//   for_pairs<SumsOf<n>::template Row>(rows, inputs, [=](const auto& pair, auto& own) {
//     using Number = NumberOf<decltype(pair)>;
//     Number point[4], factor;
//     gather<0, 4>(pair.rows(), point);     // the numbers packed with the other particle
//     take(&kernels[pair.m], factor);       // a number stored for the pair
//     own.sum[0] += factor * (point[3] - pair.self[3]);
//   }, [=](std::size_t i, const auto& own) { result[i] = sum_of_lanes(own.sum[0]); });
//
// Functions that replace operators (sqrt_in_place, max_in_place, any, gather, take, put) have a form for each kind of
// number (common/core/lanes.hpp). Bodies are marked always_inline. Where they write to memory they capture plain
// pointers by value: the compiler assumes that vector stores may change any object that is captured by reference.
#pragma once

#include "common/core/lanes.hpp"
#include "common/core/threads.hpp"
#include "common/core/vector.hpp"

#include <algorithm>
#include <span>
#include <type_traits>

namespace poretwin {

/// A list that contains every pair in both rows, where it acts on the row's particle. Entries of row i: offset[i] ..
/// offset[i + 1], padded to a multiple of four with i itself, which must contribute nothing.
struct FullRows {
  static constexpr bool mutual = false;
  const Index *offset, *index;
  std::size_t n;              ///< rows
  std::size_t worth_threads;  ///< number of rows from which on several threads are worth their overhead

  [[nodiscard]] std::size_t alone(std::size_t i) const { return offset[i]; }
  [[nodiscard]] bool skips(std::size_t) const { return false; }
  /// Length of the list.
  [[nodiscard]] std::size_t n_pairs() const { return offset[n]; }
  /// Calls work(begin, end) for ranges of rows, in parallel.
  template <class Work>
  void share(const Work& work) const {
    parallel_ranges(n, worth_threads, work);
  }
};

/// A list that contains a pair of two particles in one of its two rows, up to entry alone(i) of row i, where it acts on
/// both. Further entries act on the row's particle only. Both parts of a row are padded as in FullRows. The rows are
/// divided into parts, one for each thread: a pair of two parts is stored in both, and acts on one particle in each. Of
/// the rows first .. last - 1 those that are not skipped are visited.
struct HalfRows {
  static constexpr bool mutual = true;
  const Index *offset, *alone_from, *index;
  std::span<const Index> parts;  ///< bounds of the parts
  std::size_t length;            ///< length of the list
  std::size_t first, last;
  const char* skipped = nullptr;  ///< [rows] 1: not visited; null: all rows are visited

  [[nodiscard]] std::size_t alone(std::size_t i) const { return alone_from[i]; }
  [[nodiscard]] bool skips(std::size_t i) const { return skipped != nullptr && skipped[i] != 0; }
  [[nodiscard]] std::size_t n_pairs() const { return length; }
  template <class Work>
  void share(const Work& work) const {
    for_each_part(parts.size() - 1, [&](std::size_t part) {
      work(std::max<std::size_t>(first, parts[part]), std::min<std::size_t>(last, parts[part + 1]));
    });
  }
};

/// The packed numbers of every point that bodies read: all[j].row(), or plain numbers. The cache lines (64 bytes)
/// from_line to to_line - 1 of each point are fetched in advance if the points exceed a core's caches.
template <class Packed, std::size_t from_line = 0, std::size_t to_line = 0>
struct PairInputs {
  const Packed* all;
  std::size_t n = 0;  ///< number of points; used only where lines are fetched
};
template <class Packed>
PairInputs(const Packed*) -> PairInputs<Packed>;

/// One pair, or four pairs of one row: the argument of a body. both: whether it acts on both particles.
template <class In, class Packed, bool acts_on_both>
struct PairAt {
  using Number = typename In::Number;
  using Mask = typename In::Mask;
  static constexpr bool both = acts_on_both;
  std::size_t i;       ///< the row's particle
  std::size_t m;       ///< place of the (first) pair in the list
  const Index* index;  ///< of the other points
  const Packed* all;
  const double* self;  ///< numbers packed with the row's particle

  [[nodiscard, gnu::always_inline]] static const double* row_of(const Packed& point) {
    if constexpr (std::is_same_v<Packed, double>)
      return &point;
    else
      return point.row();
  }
  /// The numbers at row(j) of each other point j, for gather() and gather_one().
  template <class RowAt>
  [[nodiscard, gnu::always_inline]] auto rows_of(const RowAt& row) const {
    if constexpr (In::width == 1)
      return OneRow<const double>{row(index[0])};
    else
      return FourRows<const double>{row(index[0]), row(index[1]), row(index[2]), row(index[3])};
  }
  /// The numbers packed with the other points.
  [[nodiscard, gnu::always_inline]] auto rows() const {
    const Packed* const points = all;
    return rows_of([points](Index j) __attribute__((always_inline)) { return row_of(points[j]); });
  }
  /// Adds the first n numbers (n: a multiple of four) to the numbers at sums(j) of each other particle j.
  template <std::size_t n, class Sums>
  [[gnu::always_inline]] void give(const Number* theirs, const Sums& sums) const {
    if constexpr (In::width == 1)
      scatter_add<n>(theirs, OneRow<double>{sums(index[0])});
    else
      scatter_add<n>(theirs, {sums(index[0]), sums(index[1]), sums(index[2]), sums(index[3])});
  }
  /// x = f(j, x) for the number of each other point j.
  template <class F>
  [[gnu::always_inline]] void apply(const F& f, Number& x) const {
    if constexpr (In::width == 1)
      x = f(index[0], x);
    else
      for (std::size_t l = 0; l < In::width; ++l) x[l] = f(index[l], x[l]);
  }
  /// Calls f(j, m) for each other point j and the pair's place m in the list.
  template <class F>
  [[gnu::always_inline]] void for_each(const F& f) const {
    for (std::size_t l = 0; l < In::width; ++l) f(index[l], m + l);
  }
};

template <class Pair>
using NumberOf = typename std::remove_cvref_t<Pair>::Number;
template <class Pair>
using MaskOf = typename std::remove_cvref_t<Pair>::Mask;

/// What a loop stores for a row during its pairs: n sums. Other kinds of rows are also constructed from the particle's
/// packed numbers.
template <std::size_t n>
struct SumsOf {
  static constexpr std::size_t size = (n + n_lanes - 1) / n_lanes * n_lanes;
  template <class In>
  struct Row {
    typename In::Number sum[size] = {};
    explicit Row(const double*) {}
    /// Adds the sums to `size` numbers.
    [[gnu::always_inline]] void add_to(double* numbers) const { add_lanes<size>(sum, numbers); }
  };
};

/// Visits the pairs of the rows begin .. end - 1 with numbers of the kind In.
template <template <class> class Row, class In, bool fetches, class Rows, class Packed, std::size_t from_line,
          std::size_t to_line, class Body, class Finish>
[[gnu::always_inline]] inline void visit_rows(const Rows& rows, const PairInputs<Packed, from_line, to_line>& inputs,
                                              std::size_t begin, std::size_t end, const Body& body,
                                              const Finish& finish) {
  const Index* const index = rows.index;
  const Packed* const all = inputs.all;
  const std::size_t last_pairs = fetches ? rows.n_pairs() - n_lanes : 0;
  const auto fetch_ahead = [=](std::size_t m) __attribute__((always_inline)) {
    constexpr std::size_t ahead = 64, line = 64;
    const Index* const later = &index[std::min(m + ahead, last_pairs)];
    for (std::size_t l = 0; l < n_lanes; ++l)
      for (std::size_t k = from_line; k < to_line; ++k)
        __builtin_prefetch(reinterpret_cast<const char*>(&all[later[l]]) + k * line);
  };
  for (std::size_t i = begin; i < end; ++i) {
    if (rows.skips(i)) continue;
    const double* const self = PairAt<In, Packed, false>::row_of(all[i]);
    Row<In> own(self);
    const std::size_t alone = rows.alone(i), stop = rows.offset[i + 1];
    std::size_t m = rows.offset[i];
    if constexpr (Rows::mutual)
      for (; m < alone; m += In::width) {
        if constexpr (fetches) fetch_ahead(m);
        body(PairAt<In, Packed, true>{i, m, &index[m], all, self}, own);
      }
    for (m = alone; m < stop; m += In::width) {
      if constexpr (fetches) fetch_ahead(m);
      body(PairAt<In, Packed, false>{i, m, &index[m], all, self}, own);
    }
    finish(i, own);
  }
}

/// For every row: makes Row<In> own, calls body(pair, own) for its pairs, then finish(i, own). Threads share the rows.
/// Pairs are taken four at a time, compiled for this machine's vector instructions.
template <template <class> class Row, class Rows, class Packed, std::size_t from_line, std::size_t to_line, class Body,
          class Finish>
void for_pairs(const Rows& rows, const PairInputs<Packed, from_line, to_line>& inputs, const Body& body,
               const Finish& finish) {
  const auto run = [&](auto fetches) {
    rows.share([&](std::size_t begin, std::size_t end) {
      if (instructions() == Instructions::scalar)
        return visit_rows<Row, InOnes, false>(rows, inputs, begin, end, body, finish);
      run_lanes([=]() __attribute__((always_inline)) {
        const Rows here = rows;
        const Body pairs = body;
        const Finish done = finish;
        visit_rows<Row, InFours, decltype(fetches)::value>(here, inputs, begin, end, pairs, done);
      });
    });
  };
  constexpr std::size_t many = 16384;
  if constexpr (to_line > from_line)
    if (inputs.n > many) return run(std::true_type{});
  run(std::false_type{});
}

}  // namespace poretwin
