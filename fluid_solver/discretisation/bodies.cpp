#include "fluid_solver/discretisation/bodies.hpp"

#include "common/particles/neighbours.hpp"
#include "fluid_solver/discretisation/ranks.hpp"
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

namespace {

/// Completes what is known of each body of water: the least, entry by entry, of what all ranks know of its parts. In
/// each round, what a part knows goes one rank farther. known: of each part on this rank. body [real]: -1 for particles
/// that do not count. visit_copies(a, visit): calls visit(q) for the copies q that touch particle a.
template <class Known, class Copies>
void complete(const Domain& domain, std::span<const int> body, std::vector<Known>& known, const Copies& visit_copies) {
  const std::size_t n = body.size();
  std::vector<Known> said(n, Known::Constant(HUGE_VAL));
  for (bool news = true; domain.any(news);) {
    news = false;
    for (std::size_t a = 0; a < n; ++a)
      if (body[a] >= 0) said[a] = known[static_cast<std::size_t>(body[a])];
    const WithCopies<Known> heard(domain, said);
    for (std::size_t a = 0; a < n; ++a) {
      if (body[a] < 0) continue;
      auto& of = known[static_cast<std::size_t>(body[a])];
      visit_copies(a, [&](std::size_t q) {
        if ((heard[q].array() >= of.array()).all()) return;
        of = of.cwiseMin(heard[q]);
        news = true;
      });
    }
  }
}

/// The extents of the parts of bodies that these particles form.
template <int D>
std::vector<Extent<D>> extents_of(const Setup<D>& setup, std::span<const int> body, std::span<const Vec<D>> x) {
  const Vec<D> up = setup.weight.norm() > 0.0 ? Vec<D>(-setup.weight.normalized()) : Vec<D>::Zero();
  std::vector<Extent<D>> bodies(x.empty() ? 0 : static_cast<std::size_t>(*std::ranges::max_element(body) + 1));
  for (std::size_t a = 0; a < x.size(); ++a) {
    if (body[a] < 0) continue;
    auto& of = bodies[static_cast<std::size_t>(body[a])];
    const double height = up.dot(x[a]) + 0.5 * setup.spacing;
    of.top = std::max(of.top, height);
    of.bottom = std::min(of.bottom, height - setup.spacing);
    of.farthest = std::max(of.farthest, x[a].norm());
    of.lower = of.lower.cwiseMin(x[a]);
    of.upper = of.upper.cwiseMax(x[a]);
  }
  return bodies;
}

}  // namespace

template <int D>
MeasuredBodies<D> measured_bodies(const Setup<D>& setup, const Walls<D>& walls, const Particles<D>& p,
                                  std::span<const char> counts) {
  MeasuredBodies<D> bodies;
  bodies.of = bodies_of<D>(p.position, counts, setup.spacing);
  bodies.extent = extents_of<D>(setup, bodies.of, p.position);
  if (!setup.tiling || !setup.domain.any(!bodies.extent.empty())) return bodies;
  const Domain domain = with_halo(setup, walls, p);
  const ScalarArray own(counts.begin(), counts.end());
  const WithCopies<double> counted(domain, own);
  const WithCopies<Vec<D>> x(domain, p.position);
  VecArray<D> others;
  std::vector<std::size_t> copy;
  for (std::size_t q = p.size(); q < p.size() + domain.copies(); ++q) {
    if (counted[q] == 0.0) continue;
    others.push_back(x[q]);
    copy.push_back(q);
  }
  const double reach = motion::touching * setup.spacing;
  sph::CellGrid<D> grid;
  grid.build(others, reach);
  using Known = Eigen::Matrix<double, 3 + 2 * D, 1>;
  std::vector<Known> known;
  for (const auto& of : bodies.extent) {
    Known one;
    one << -of.top, of.bottom, -of.farthest, of.lower, -of.upper;
    known.push_back(one);
  }
  complete(domain, bodies.of, known, [&](std::size_t a, const auto& visit) {
    grid.for_each_within(p.position[a], reach, [&](std::size_t i, double) { visit(copy[i]); });
  });
  for (std::size_t b = 0; b < known.size(); ++b)
    bodies.extent[b] = {-known[b][0], known[b][1], -known[b][2], known[b].template segment<D>(3),
                        -known[b].template tail<D>()};
  return bodies;
}

template <int D>
void raise_wave_speeds(const Setup<D>& setup, const MeasuredBodies<D>& bodies, Particles<D>& p) {
  for (std::size_t a = 0; a < p.size(); ++a) {
    if (bodies.of[a] < 0) continue;
    const auto& of = bodies.extent[static_cast<std::size_t>(bodies.of[a])];
    p.wave_speed[a] = std::max(p.wave_speed[a], std::sqrt(setup.gravity * (of.top - of.bottom) +
                                                          setup.central_force * of.farthest * of.farthest));
  }
}

template <int D>
void begin_bodies(const Setup<D>& setup, State<D>& state) {
  auto& p = state.particles;
  const auto body = bodies_of<D>(p.position, std::vector<char>(p.size(), 1), setup.spacing);
  raise_wave_speeds<D>(setup, {body, extents_of<D>(setup, body, p.position)}, p);
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

namespace {

template <int D>
std::vector<int> parts_of_bodies(const Stencil<D>& s) {
  return connected(s.n_real, std::vector<char>(s.n_real, 1), [&](std::size_t a, const auto& take) {
    for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k)
      if (const Index q = s.parent[s.other[k]]; q < s.n_real) take(q);
  });
}

/// Numbers from 1 for the bodies that are closed on all ranks, the same on each; 0 for open ones. body [real]: of
/// parts_of_bodies. closed: of each body's part on this rank. A body is named after the lowest id in it.
template <int D>
std::vector<int> numbers_across_ranks(const Stencil<D>& s, std::span<const GlobalId> ids, std::span<const int> body,
                                      std::span<const char> closed) {
  VecArray<2> known(closed.size(), Vec<2>(HUGE_VAL, 0.0));  // of each part: the lowest id in its body; -1: it is open
  for (std::size_t a = 0; a < body.size(); ++a) {
    const auto part = static_cast<std::size_t>(body[a]);
    known[part] = {std::min(known[part][0], static_cast<double>(ids.empty() ? a : ids[a])),
                   closed[part] != 0 ? 0.0 : -1.0};
  }
  complete(s.domain, body, known, [&](std::size_t a, const auto& visit) {
    for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k)
      if (const Index q = s.parent[s.other[k]]; q >= s.n_real && q < s.n_particles) visit(q);
  });
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
NumberedBodies bodies_of(const Stencil<D>& s, std::span<const GlobalId> ids) {
  NumberedBodies bodies{parts_of_bodies<D>(s), 0};
  const auto highest = [](const std::vector<int>& number) {
    return number.empty() ? -1 : *std::ranges::max_element(number);
  };
  bodies.count = static_cast<std::size_t>(highest(bodies.of) + 1);
  if (s.domain.alone()) return bodies;
  const auto number = numbers_across_ranks<D>(s, ids, bodies.of, std::vector<char>(bodies.count, 1));
  for (int& b : bodies.of) b = number[static_cast<std::size_t>(b)] - 1;
  bodies.count = static_cast<std::size_t>(s.domain.max(highest(bodies.of) + 1.0));
  return bodies;
}

template <int D>
void number_closed_bodies(const Stencil<D>& s, State<D>& state) {
  auto& p = state.particles;
  const auto body = parts_of_bodies<D>(s);
  std::vector<char> closed(p.size(), 1);  // one per body
  const auto open = [&](std::size_t a) { closed[static_cast<std::size_t>(body[a])] = 0; };
  for (std::size_t a = 0; a < p.size(); ++a)
    if (p.surface[a] != Surface::interior) open(a);
  // Faces and inlets open the body of water that they touch. Nearly always every body is open by then, and the body at
  // a face or inlet need not be looked for.
  if (s.domain.any(std::ranges::any_of(body, [&](int b) { return closed[static_cast<std::size_t>(b)] != 0; }))) {
    VecArray<D> places;
    for (const auto& c : state.columns) places.push_back(c.foot);
    for (const auto& inlet : state.inlets) places.push_back(inlet.foot);
    ScalarArray own(places.size(), -HUGE_VAL);  // m2, minus the squared distance of the nearest particle
    std::vector<std::size_t> nearest(places.size());
    for (std::size_t i = 0; i < places.size() && p.size() > 0; ++i) {
      nearest[i] = nearest_to<D>(places[i], p.position);
      own[i] = -(places[i] - p.position[nearest[i]]).squaredNorm();
    }
    ScalarArray least = own;
    s.domain.max(least);
    for (std::size_t i = 0; i < places.size() && p.size() > 0; ++i)
      if (own[i] == least[i]) open(nearest[i]);
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

#define PORETWIN_INSTANTIATE(D)                                                                     \
  template std::vector<int> bodies_of<D>(std::span<const Vec<D>>, std::span<const char>, double);   \
  template NumberedBodies bodies_of<D>(const Stencil<D>&, std::span<const GlobalId>);               \
  template MeasuredBodies<D> measured_bodies(const Setup<D>&, const Walls<D>&, const Particles<D>&, \
                                             std::span<const char>);                                \
  template void raise_wave_speeds(const Setup<D>&, const MeasuredBodies<D>&, Particles<D>&);        \
  template void begin_bodies(const Setup<D>&, State<D>&);                                           \
  template void number_closed_bodies(const Stencil<D>&, State<D>&);
PORETWIN_INSTANTIATE(2)
PORETWIN_INSTANTIATE(3)
#undef PORETWIN_INSTANTIATE

}  // namespace poretwin::fluid
