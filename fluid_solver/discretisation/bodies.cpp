#include "fluid_solver/discretisation/bodies.hpp"

#include "common/particles/neighbours.hpp"
#include "fluid_solver/numerics/motion.hpp"

#include <algorithm>
#include <cmath>

namespace poretwin::fluid {

namespace {

/// Numbers the connected sets of elements a with counts[a], from 0; elements that do not count get -1.
/// visit_neighbours(a, visit) calls visit(b) for all b that touch a.
template <class Neighbours>
std::vector<int> connected(std::size_t n, std::span<const char> counts, const Neighbours& visit_neighbours) {
  std::vector<int> body(n, -1);
  std::vector<std::size_t> found;
  int next = 0;
  for (std::size_t first = 0; first < n; ++first) {
    if (body[first] >= 0 || counts[first] == 0) continue;
    const auto take = [&](std::size_t b) {
      if (body[b] >= 0 || counts[b] == 0) return;
      body[b] = next;
      found.push_back(b);
    };
    take(first);
    while (!found.empty()) {
      const std::size_t a = found.back();
      found.pop_back();
      visit_neighbours(a, take);
    }
    ++next;
  }
  return body;
}

/// Index of the point nearest to x; there must be at least one point.
template <int D>
std::size_t nearest_to(const Vec<D>& x, std::span<const Vec<D>> points) {
  const auto nearest = std::ranges::min_element(points, {}, [&](const Vec<D>& y) { return (x - y).squaredNorm(); });
  return static_cast<std::size_t>(nearest - points.begin());
}

}  // namespace

template <int D>
std::vector<int> bodies_of(std::span<const Vec<D>> x, std::span<const char> counts, double spacing) {
  sph::CellGrid<D> grid;
  grid.build(x, motion::touching * spacing);
  return connected(x.size(), counts, [&](std::size_t a, const auto& take) {
    grid.for_each_within(x[a], motion::touching * spacing, [&](std::size_t b, double) { take(b); });
  });
}

template <int D>
void raise_wave_speeds(const Setup<D>& setup, std::span<const int> body, Particles<D>& p) {
  struct Extent {
    double top = -HUGE_VAL, bottom = HUGE_VAL, farthest = 0.0;
  };
  const Vec<D> up = setup.weight.norm() > 0.0 ? Vec<D>(-setup.weight.normalized()) : Vec<D>::Zero();
  std::vector<Extent> bodies(p.size() > 0 ? static_cast<std::size_t>(*std::ranges::max_element(body) + 1) : 0);
  for (std::size_t a = 0; a < p.size(); ++a) {
    if (body[a] < 0) continue;
    auto& of = bodies[static_cast<std::size_t>(body[a])];
    const double height = up.dot(p.position[a]) + 0.5 * setup.spacing;
    of.top = std::max(of.top, height);
    of.bottom = std::min(of.bottom, height - setup.spacing);
    of.farthest = std::max(of.farthest, p.position[a].norm());
  }
  for (std::size_t a = 0; a < p.size(); ++a) {
    if (body[a] < 0) continue;
    const auto& of = bodies[static_cast<std::size_t>(body[a])];
    p.wave_speed[a] = std::max(p.wave_speed[a], std::sqrt(setup.gravity * (of.top - of.bottom) +
                                                          setup.central_force * of.farthest * of.farthest));
  }
}

template <int D>
void begin_bodies(const Setup<D>& setup, State<D>& state) {
  auto& p = state.particles;
  const auto body = bodies_of<D>(p.position, std::vector<char>(p.size(), 1), setup.spacing);
  raise_wave_speeds<D>(setup, body, p);
  const bool can_leave = setup.coupled && setup.soil_yields && state.inlets.empty();
  std::vector<char> in_soil(p.size(), can_leave ? 1 : 0), at_column(p.size(), 0);  // one per body
  for (std::size_t a = 0; a < p.size(); ++a)
    if (p.void_fraction[a] >= 1.0) in_soil[static_cast<std::size_t>(body[a])] = 0;
  for (auto& c : state.columns) {
    c.provenance = {std::sqrt(setup.gravity * setup.spacing), can_leave};
    if (p.size() == 0) continue;
    const std::size_t a = nearest_to<D>(c.foot, p.position);
    const auto b = static_cast<std::size_t>(body[a]);
    c.provenance = {p.wave_speed[a], in_soil[b] != 0};
    at_column[b] = 1;
  }
  for (std::size_t a = 0; a < p.size(); ++a) {
    const auto b = static_cast<std::size_t>(body[a]);
    p.goes_with_soil[a] = in_soil[b] != 0 && at_column[b] != 0 ? 1 : 0;
  }
}

template <int D>
std::vector<int> bodies_of(const Stencil<D>& s) {
  return connected(s.n_real, std::vector<char>(s.n_real, 1), [&](std::size_t a, const auto& take) {
    for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k)
      if (const Index q = s.parent[s.other[k]]; q < s.n_real) take(q);
  });
}

namespace {

/// Numbers from 1 for the bodies that are closed on all ranks, the same on each; 0 for open ones. body [real]: of
/// bodies_of. closed: of each body's part on this rank.
///
/// A body is named after the lowest id in it. In each round, what a part knows of its body goes one rank farther.
template <int D>
std::vector<int> numbers_across_ranks(const Stencil<D>& s, std::span<const GlobalId> ids, std::span<const int> body,
                                      std::span<const char> closed) {
  const std::size_t n = body.size();
  VecArray<2> known(closed.size(), Vec<2>(HUGE_VAL, 0.0));  // of each part: the lowest id in its body; 1: it is open
  for (std::size_t a = 0; a < n; ++a) {
    auto& of = known[static_cast<std::size_t>(body[a])];
    of = {std::min(of[0], static_cast<double>(ids.empty() ? a : ids[a])),
          closed[static_cast<std::size_t>(body[a])] != 0 ? 0.0 : 1.0};
  }
  VecArray<2> said(n);
  for (bool news = true; s.domain.any(news);) {
    news = false;
    for (std::size_t a = 0; a < n; ++a) said[a] = known[static_cast<std::size_t>(body[a])];
    const auto heard = s.template with_copies<Vec<2>>(said);
    for (std::size_t a = 0; a < n; ++a) {
      auto& of = known[static_cast<std::size_t>(body[a])];
      for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k) {
        const Index q = s.parent[s.other[k]];
        if (q < s.n_real || q >= s.n_particles || (heard[q][0] >= of[0] && heard[q][1] <= of[1])) continue;
        of = {std::min(of[0], heard[q][0]), std::max(of[1], heard[q][1])};
        news = true;
      }
    }
  }
  std::vector<int> number(closed.size(), 0);
  double last = -1.0;
  for (int next = 1;; ++next) {
    double lowest = HUGE_VAL;
    for (const auto& of : known)
      if (of[1] == 0.0 && of[0] > last) lowest = std::min(lowest, of[0]);
    last = s.domain.min(lowest);
    if (!(last < HUGE_VAL)) return number;
    for (std::size_t b = 0; b < known.size(); ++b)
      if (known[b][1] == 0.0 && known[b][0] == last) number[b] = next;
  }
}

}  // namespace

template <int D>
void number_closed_bodies(const Stencil<D>& s, State<D>& state) {
  auto& p = state.particles;
  const auto body = bodies_of<D>(s);
  std::vector<char> closed(p.size(), 1);  // one per body
  const auto open = [&](std::size_t a) { closed[static_cast<std::size_t>(body[a])] = 0; };
  for (std::size_t a = 0; a < p.size(); ++a)
    if (p.surface[a] != Surface::interior) open(a);
  // Faces and inlets open the body of water that they touch. Nearly always every body is open by then, and the body at
  // a face or inlet need not be looked for.
  if (std::ranges::any_of(body, [&](int b) { return closed[static_cast<std::size_t>(b)] != 0; })) {
    for (const auto& c : state.columns) open(nearest_to<D>(c.foot, p.position));
    for (const auto& inlet : state.inlets) open(nearest_to<D>(inlet.foot, p.position));
  }
  p.closed_body = {};
  if (s.domain.alone()) {
    for (std::size_t a = 0; a < p.size(); ++a)
      if (closed[static_cast<std::size_t>(body[a])] != 0) p.closed_body.set(a, body[a] + 1, p.size());
    return;
  }
  const auto number = numbers_across_ranks<D>(s, p.share.ids, body, closed);
  if (!s.domain.any(std::ranges::any_of(number, [](int of) { return of > 0; }))) return;
  p.closed_body.allocate(p.size());
  for (std::size_t a = 0; a < p.size(); ++a) p.closed_body.set(a, number[static_cast<std::size_t>(body[a])]);
}

#define PORETWIN_INSTANTIATE(D)                                                                   \
  template std::vector<int> bodies_of<D>(std::span<const Vec<D>>, std::span<const char>, double); \
  template std::vector<int> bodies_of<D>(const Stencil<D>&);                                      \
  template void raise_wave_speeds(const Setup<D>&, std::span<const int>, Particles<D>&);          \
  template void begin_bodies(const Setup<D>&, State<D>&);                                         \
  template void number_closed_bodies(const Stencil<D>&, State<D>&);
PORETWIN_INSTANTIATE(2)
PORETWIN_INSTANTIATE(3)
#undef PORETWIN_INSTANTIATE

}  // namespace poretwin::fluid
