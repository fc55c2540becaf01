// The border between factors at which something stands and at which it fails: bracketed, then bisected.
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

/// Where to look for it.
struct BorderSearch {
  double guess = 1.0;       ///< the first factor tried
  double ratio = 2.0;       ///< of the second to it; squared, up to 2, from trial to trial until both sides are known
  double largest = 100.0;   ///< no border is sought above it and below its inverse: fails = infinity, or stands = 0
  double tolerance = 0.01;  ///< largest width of the bracket, over `fails`
};

/// stands(factor) says whether it does, or nothing to give the search up: then nothing is found.
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
