// Visits the members of any aggregate in their order. The compiler counts the members, so that code need not list them
// and cannot forget one.
#pragma once

#include <cstddef>
#include <utility>

namespace poretwin {
namespace detail {

/// Converts to any type from which a member is initialised.
struct Anything {
  template <class T>
  operator T() const;  // NOLINT: never defined, used in unevaluated code only
};

template <class T, std::size_t... I>
constexpr bool takes(std::index_sequence<I...>) {
  return requires { T{(static_cast<void>(I), std::declval<Anything>())...}; };
}

}  // namespace detail

/// Largest number of members that the structured bindings below cover.
inline constexpr std::size_t most_fields = 40;

/// Number of members of an aggregate, searched for between `least` and `most`. It is the largest number of initialisers
/// that the aggregate's braces accept.
template <class T, std::size_t least = 0, std::size_t most = most_fields + 1>
constexpr std::size_t count_fields() {
  constexpr std::size_t middle = (least + most + 1) / 2;
  if constexpr (least == most)
    return least;
  else if constexpr (detail::takes<T>(std::make_index_sequence<middle>{}))
    return count_fields<T, middle, most>();
  else
    return count_fields<T, least, middle - 1>();
}

/// Calls f(member...) with all members of an aggregate as arguments.
template <class T, class F>
void with_fields(T& x, F&& f) {
  constexpr std::size_t n = count_fields<T>();
  static_assert(n > 0 && n <= most_fields, "too many members: group some of them, or raise most_fields");
  if constexpr (n == 1) {
    auto& [a] = x;
    f(a);
  } else if constexpr (n == 2) {
    auto& [a, b] = x;
    f(a, b);
  } else if constexpr (n == 3) {
    auto& [a, b, c] = x;
    f(a, b, c);
  } else if constexpr (n == 4) {
    auto& [a, b, c, d] = x;
    f(a, b, c, d);
  } else if constexpr (n == 5) {
    auto& [a, b, c, d, e] = x;
    f(a, b, c, d, e);
  } else if constexpr (n == 6) {
    auto& [a, b, c, d, e, f_] = x;
    f(a, b, c, d, e, f_);
  } else if constexpr (n == 7) {
    auto& [a, b, c, d, e, f_, g] = x;
    f(a, b, c, d, e, f_, g);
  } else if constexpr (n == 8) {
    auto& [a, b, c, d, e, f_, g, h] = x;
    f(a, b, c, d, e, f_, g, h);
  } else if constexpr (n == 9) {
    auto& [a, b, c, d, e, f_, g, h, i] = x;
    f(a, b, c, d, e, f_, g, h, i);
  } else if constexpr (n == 10) {
    auto& [a, b, c, d, e, f_, g, h, i, j] = x;
    f(a, b, c, d, e, f_, g, h, i, j);
  } else if constexpr (n == 11) {
    auto& [a, b, c, d, e, f_, g, h, i, j, k] = x;
    f(a, b, c, d, e, f_, g, h, i, j, k);
  } else if constexpr (n == 12) {
    auto& [a, b, c, d, e, f_, g, h, i, j, k, l] = x;
    f(a, b, c, d, e, f_, g, h, i, j, k, l);
  } else if constexpr (n == 13) {
    auto& [a, b, c, d, e, f_, g, h, i, j, k, l, m] = x;
    f(a, b, c, d, e, f_, g, h, i, j, k, l, m);
  } else if constexpr (n == 14) {
    auto& [a, b, c, d, e, f_, g, h, i, j, k, l, m, n_] = x;
    f(a, b, c, d, e, f_, g, h, i, j, k, l, m, n_);
  } else if constexpr (n == 15) {
    auto& [a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o] = x;
    f(a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o);
  } else if constexpr (n == 16) {
    auto& [a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p] = x;
    f(a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p);
  } else if constexpr (n == 17) {
    auto& [a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q] = x;
    f(a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q);
  } else if constexpr (n == 18) {
    auto& [a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r] = x;
    f(a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r);
  } else if constexpr (n == 19) {
    auto& [a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s] = x;
    f(a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s);
  } else if constexpr (n == 20) {
    auto& [a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t] = x;
    f(a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t);
  } else if constexpr (n == 21) {
    auto& [a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u] = x;
    f(a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u);
  } else if constexpr (n == 22) {
    auto& [a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v] = x;
    f(a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v);
  } else if constexpr (n == 23) {
    auto& [a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v, w] = x;
    f(a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v, w);
  } else if constexpr (n == 24) {
    auto& [a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v, w, x_] = x;
    f(a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v, w, x_);
  } else if constexpr (n == 25) {
    auto& [a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v, w, x_, y] = x;
    f(a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v, w, x_, y);
  } else if constexpr (n == 26) {
    auto& [a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v, w, x_, y, z] = x;
    f(a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v, w, x_, y, z);
  } else if constexpr (n == 27) {
    auto& [a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v, w, x_, y, z, aa] = x;
    f(a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v, w, x_, y, z, aa);
  } else if constexpr (n == 28) {
    auto& [a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v, w, x_, y, z, aa, ab] = x;
    f(a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v, w, x_, y, z, aa, ab);
  } else if constexpr (n == 29) {
    auto& [a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v, w, x_, y, z, aa, ab, ac] = x;
    f(a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v, w, x_, y, z, aa, ab, ac);
  } else if constexpr (n == 30) {
    auto& [a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v, w, x_, y, z, aa, ab, ac, ad] = x;
    f(a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v, w, x_, y, z, aa, ab, ac, ad);
  } else if constexpr (n == 31) {
    auto& [a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v, w, x_, y, z, aa, ab, ac, ad, ae] = x;
    f(a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v, w, x_, y, z, aa, ab, ac, ad, ae);
  } else if constexpr (n == 32) {
    auto& [a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v, w, x_, y, z, aa, ab, ac, ad, ae, af] = x;
    f(a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v, w, x_, y, z, aa, ab, ac, ad, ae, af);
  } else if constexpr (n == 33) {
    auto& [a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v, w, x_, y, z, aa, ab, ac, ad, ae, af,
           ag] = x;
    f(a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v, w, x_, y, z, aa, ab, ac, ad, ae, af, ag);
  } else if constexpr (n == 34) {
    auto& [a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v, w, x_, y, z, aa, ab, ac, ad, ae, af, ag,
           ah] = x;
    f(a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v, w, x_, y, z, aa, ab, ac, ad, ae, af, ag, ah);
  } else if constexpr (n == 35) {
    auto& [a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v, w, x_, y, z, aa, ab, ac, ad, ae, af, ag,
           ah, ai] = x;
    f(a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v, w, x_, y, z, aa, ab, ac, ad, ae, af, ag, ah,
      ai);
  } else if constexpr (n == 36) {
    auto& [a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v, w, x_, y, z, aa, ab, ac, ad, ae, af, ag,
           ah, ai, aj] = x;
    f(a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v, w, x_, y, z, aa, ab, ac, ad, ae, af, ag, ah,
      ai, aj);
  } else if constexpr (n == 37) {
    auto& [a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v, w, x_, y, z, aa, ab, ac, ad, ae, af, ag,
           ah, ai, aj, ak] = x;
    f(a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v, w, x_, y, z, aa, ab, ac, ad, ae, af, ag, ah,
      ai, aj, ak);
  } else if constexpr (n == 38) {
    auto& [a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v, w, x_, y, z, aa, ab, ac, ad, ae, af, ag,
           ah, ai, aj, ak, al] = x;
    f(a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v, w, x_, y, z, aa, ab, ac, ad, ae, af, ag, ah,
      ai, aj, ak, al);
  } else if constexpr (n == 39) {
    auto& [a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v, w, x_, y, z, aa, ab, ac, ad, ae, af, ag,
           ah, ai, aj, ak, al, am] = x;
    f(a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v, w, x_, y, z, aa, ab, ac, ad, ae, af, ag, ah,
      ai, aj, ak, al, am);
  } else if constexpr (n == 40) {
    auto& [a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v, w, x_, y, z, aa, ab, ac, ad, ae, af, ag,
           ah, ai, aj, ak, al, am, an] = x;
    f(a, b, c, d, e, f_, g, h, i, j, k, l, m, n_, o, p, q, r, s, t, u, v, w, x_, y, z, aa, ab, ac, ad, ae, af, ag, ah,
      ai, aj, ak, al, am, an);
  }
}

}  // namespace poretwin
