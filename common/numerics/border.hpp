// The critical factor, below which a structure is stable and above which it fails. It is bracketed, then bisected.
#pragma once

#include <limits>
#include <optional>

namespace poretwin {

struct Border {
  double stands = 0.0, fails = std::numeric_limits<double>::infinity();
  [[nodiscard]] double factor() const { return 0.5 * (stands + fails); }
  /// Half the width of the bracket.
  [[nodiscard]] double error() const { return 0.5 * (fails - stands); }
};

/// Parameters of the search.
struct BorderSearch {
  double guess = 1.0;       ///< the first factor tried
  double ratio = 2.0;       ///< second factor over first; squared (at most 2) at each trial until bracketed
  double largest = 100.0;   ///< the search ends above this (fails = infinity) and below its inverse (stands = 0)
  double tolerance = 0.01;  ///< largest width of the bracket, relative to `fails`
};

/// The bracket of the critical factor. stands(factor) returns whether the structure is stable. If it returns nothing,
/// the search is given up, and find_border also returns nothing.
template <class Stands>
std::optional<Border> find_border(const BorderSearch& search, const Stands& stands) {
  Border border;
  const auto widen = [](double& ratio) { ratio = ratio * ratio < 2.0 ? ratio * ratio : 2.0; };
  double factor = search.guess, ratio = search.ratio;
  std::optional<bool> found = stands(factor);
  if (!found) return {};
  const bool above = *found;
  for (;; widen(ratio)) {
    (above ? border.stands : border.fails) = factor;
    if (above ? factor >= search.largest : factor <= 1.0 / search.largest) return border;
    factor = above ? factor * ratio : factor / ratio;
    found = stands(factor);
    if (!found) return {};
    if (*found != above) break;
  }
  (above ? border.fails : border.stands) = factor;
  while (border.fails - border.stands > search.tolerance * border.fails) {
    found = stands(border.factor());
    if (!found) return {};
    (*found ? border.stands : border.fails) = border.factor();
  }
  return border;
}

}  // namespace poretwin
