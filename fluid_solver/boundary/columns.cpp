#include "fluid_solver/boundary/columns.hpp"

#include "common/geometry/shapes.hpp"
#include "fluid_solver/discretisation/operators.hpp"
#include "fluid_solver/discretisation/ranks.hpp"
#include "fluid_solver/motion/advection.hpp"
#include "fluid_solver/motion/volume_source.hpp"

#include <cmath>
#include <memory>

namespace poretwin::fluid {

template <int D>
Faces<D>::Faces(const Case& scene, WaterBoundaries what_stands_behind, const State<D>& first)
    : boundaries(std::move(what_stands_behind)) {
  for (const auto& c : first.columns) feet.push_back(c.foot);
  const auto kept = std::make_shared<const Case>(scene);
  for (std::size_t f = 0; f < boundaries.size(); ++f) {
    const int face = static_cast<int>(f);
    if (!is_opening(first, face) && level(first, face, 0.0) &&
        std::all_of(first.columns.begin(), first.columns.end(),
                    [&](const auto& c) { return c.face != face || c.in_soil; }))
      reservoirs_.push_back({face, [kept, f](const Point3& x) { return is_behind(*kept, kept->water_faces[f], x); }});
  }
}

template <int D>
int Faces<D>::taker(const Setup<D>& setup, const State<D>& state, const Vec<D>& x) const {
  const Point3 point = to_point3<D>(x);
  for (const auto& r : reservoirs_)
    if (-setup.weight.dot(x) <= setup.weight.norm() * level(state, r.face, state.time).value() && r.is_behind(point))
      return r.face;
  return -1;
}

template <int D>
void advance_boundaries(const Setup<D>& setup, const Faces<D>& faces, double time, double interval, State<D>& state) {
  const auto through = passed<D>(state);
  for (std::size_t f = 0; f < faces.boundaries.size(); ++f) {
    double leaves = 0.0;
    for (const auto& c : state.columns)
      if (c.face == static_cast<int>(f) && c.wet) leaves += interval * c.speed * c.mass / (setup.density * c.spacing);
    for (const auto& inlet : state.inlets)
      if (inlet.face == static_cast<int>(f)) leaves += interval * inlet.speed * inlet.width;
    faces.boundaries[f]->advance(time, interval, {through[f], leaves}, state.faces[f]);
    faces.boundaries[f]->check(time + interval, state.faces[f]);
  }
}

template <int D>
ScalarArray passed(const State<D>& state) {
  ScalarArray sum(state.faces.size());
  for (std::size_t f = 0; f < sum.size(); ++f) sum[f] = -state.faces[f].taken;
  for (const auto& c : state.columns) sum[static_cast<std::size_t>(c.face)] += c.passed;
  for (const auto& inlet : state.inlets) sum[static_cast<std::size_t>(inlet.face)] += inlet.passed();
  return sum;
}

template <int D>
bool is_quasi_static(const Setup<D>& setup, const FaceColumn<D>& c) {
  return c.drag_dominated && !setup.coupled && setup.scheme == FluidCase::Scheme::projection;
}

namespace {

/// Whether the pressure solve gives the flow through a column: in soil at rest that is full of water, and where drag
/// dominates in a case with soil of one conductivity. Elsewhere the skeleton or inertia carries part of the flow, and
/// the column moves with the water in front of it.
template <int D>
bool flow_is_solved_for(const Setup<D>& setup, const State<D>& state, const FaceColumn<D>& c) {
  return state.full || (is_quasi_static<D>(setup, c) && setup.one_soil);
}

/// The column whose stack of still water moves by the flow through this column.
template <int D>
const FaceColumn<D>& keeper(const State<D>& state, const FaceColumn<D>& c) {
  return c.handed_to < 0 ? c : state.columns[static_cast<std::size_t>(c.handed_to)];
}
template <int D>
FaceColumn<D>& keeper(State<D>& state, FaceColumn<D>& c) {
  return c.handed_to < 0 ? c : state.columns[static_cast<std::size_t>(c.handed_to)];
}
/// Mass of a stack of water per length [kg/m].
template <int D>
double per_length(const FaceColumn<D>& c) {
  return c.mass / c.spacing;
}

/// Adds a volume [m^D] that enters through a column (negative: leaves).
template <int D>
void count(FaceColumn<D>& c, ScalarArray& came, double volume) {
  c.passed += volume;
  came[static_cast<std::size_t>(c.face)] += volume;
}

/// Pressure that drives water in at a column's foot [Pa]: the sum of the water's pressure and the suction of the dry
/// ground behind it.
template <int D>
double driving_pressure(const Setup<D>& setup, const FaceColumn<D>& c) {
  return std::max(0.0, c.pressure + setup.weight.dot(c.foot - setup.origin)) +
         setup.ground.suction(just_inside<D>(setup.ground, c.foot, c.normal, c.spacing));
}

/// Water behind a wet face enters dry ground as a sharp front (Green & Ampt 1911) before a particle represents it:
/// dz/dt = (k/n) (H/z + cos), with the front's depth z = offset - spacing/2, the sum H of the pressure head at the face
/// and the suction head ahead, and cos between gravity and the inward normal. The part with H is integrated exactly.
template <int D>
void wet_dry_ground(const Setup<D>& setup, FaceColumn<D>& c, double interval) {
  const auto speed = infiltration_speed<D>(setup, c);
  const double z = std::max(0.0, c.offset - 0.5 * c.spacing);
  // At most the speed of a jet under the driving pressure, suction included, since suction alone can start a front.
  const double total = driving_pressure<D>(setup, c);
  const double jet = std::sqrt(2.0 * (total + setup.weight.norm() * c.spacing) / setup.density);
  const double deeper = std::min(
      z + jet * interval, std::sqrt(z * z + 2.0 * speed.head * interval) + std::max(0.0, speed.gravity) * interval);
  c.offset = std::min(c.spacing, 0.5 * c.spacing + deeper);
  // Speed of the front and slope of the pressure at the window's end, for the particles that represent the front later.
  const double depth = std::clamp(deeper, faces::least_front_depth * c.spacing, 0.5 * c.spacing);
  c.speed = std::min(jet, speed.head / depth + std::max(0.0, speed.gravity));
  c.slope = -setup.weight.dot(c.normal) - total / depth;
}

}  // namespace

void close_accounts(const ScalarArray& came, Balance& balance) {
  for (const double volume : came) (volume > 0.0 ? balance.in : balance.out) += std::abs(volume);
}

template <int D>
double missing_water(const Setup<D>& setup, const State<D>& state) {
  double stored = 0.0;
  for (const double m : state.particles.mass) stored += m / setup.density;
  for (const auto& c : state.columns) stored += c.share(setup.density);
  for (const auto& inlet : state.inlets) stored += inlet.piston * inlet.width;
  return state.balance.in - state.balance.out - (stored - state.balance.initial);
}

template <int D>
void advance_columns(const Setup<D>& setup, const sph::Sight<D>& sight, const Stencil<D>& s, const SoilView<D>& view,
                     const WindowSolution<D>& solution, double interval, State<D>& state, ScalarArray& came) {
  const auto& p = state.particles;
  if (state.columns.empty()) return;
  const auto motion = moved<D>(state.particles);
  sph::CellGrid<D> grid;
  double widest = 0.0;
  for (const auto& c : state.columns)
    widest = std::max(widest, 2.0 * points::smoothing_ratio * std::max(c.spacing, 2.0 * c.width));
  grid.build(p.position, widest);
  typename sph::Sight<D>::Near near;
  const std::size_t count_of_columns = state.columns.size();
  ScalarArray seen(count_of_columns, 0.0), speeds(count_of_columns, 0.0);  // sums of V W, and of V W times the speed
  for (std::size_t i = 0; i < count_of_columns; ++i) {
    const auto& c = state.columns[i];
    if (!c.wet) continue;
    const Vec<D> probe = c.foot + faces::probe_depth * c.spacing * c.normal;
    const double h = points::smoothing_ratio * spacing_of<D>(c.volume);
    // Where two soils adjoin, only the water of a column's own soil moves it.
    const Stratum* here = setup.ground.strata().size() > 1 && !setup.coupled ? setup.ground.at(probe) : nullptr;
    if (sight.limited()) sight.find_near(probe, sph::support_radius * h, near);
    grid.for_each_within(probe, sph::support_radius * h, [&](Index a, double r2) {
      if (c.in_soil && is_free(state.particles, a)) return;
      if (!near.empty() && !sight.open(probe, p.position[a], near)) return;
      if (const Stratum* there = here ? setup.ground.at(p.position[a]) : nullptr; there != here && there) return;
      const double w = p.volume[a] * Kernel<D>::value(std::sqrt(r2), h);
      seen[i] += w;
      const double spacing = spacing_of<D>(p.volume[a]);
      const double loose = -motion[a] * 0.5 * packing_error<D>(setup, state.particles, s, a, s.fullness[a]) * spacing /
                           repair_time<D>(setup, state.particles, a, view, interval);
      speeds[i] += w * (c.normal.dot(p.velocity[a]) + loose);
    });
  }
  for (auto* sums : {&seen, &speeds}) setup.domain.sum(*sums);
  const ScalarArray slopes = face_slopes<D>(s, p.pressure, [&](Index i) { return state.columns[i].pressure; });
  ScalarArray handed(count_of_columns, 0.0);  // m, motion of each stack by the flow through other columns
  for (std::size_t i = 0; i < count_of_columns; ++i) {
    auto& c = state.columns[i];
    const double speed_before = c.speed;
    // Counts the change of a column that becomes wet or dry because a head reaches or leaves it.
    if (flow_is_solved_for<D>(setup, state, c)) {
      count<D>(c, came, c.share(setup.density) - c.stored);
      c.stored = c.share(setup.density);
    }
    c.speed = 0.0;
    c.slope = 0.0;
    if (!c.wet || (c.handed_to >= 0 && !keeper(state, c).wet)) continue;
    c.slope = s.has_slope(static_cast<Index>(i)) ? slopes[i] : 0.0;
    if (seen[i] < faces::least_seen) {
      if (c.handed_to >= 0) continue;  // the front enters from that other column
      const double before = c.offset;
      wet_dry_ground<D>(setup, c, interval);
      if (flow_is_solved_for<D>(setup, state, c))
        count<D>(c, came, c.mass / setup.density * (c.offset - before) / c.spacing);
      continue;
    }
    const double area = c.volume / c.spacing;
    const double solved = (solution.face_carry[i] + solution.face_flow[i] / area) / c.void_fraction;
    c.speed = flow_is_solved_for<D>(setup, state, c) && std::isfinite(solved) ? solved : speeds[i] / seen[i];
    const double advance =
        interval * (c.speed + (c.in_soil ? look_ahead(state.last_interval, interval) * (c.speed - speed_before) : 0.0));
    if (c.handed_to < 0)
      c.offset += advance;
    else
      handed[static_cast<std::size_t>(c.handed_to)] += advance * per_length(c) / per_length(keeper(state, c));
    if (flow_is_solved_for<D>(setup, state, c)) count<D>(c, came, c.mass / setup.density * advance / c.spacing);
  }
  for (std::size_t i = 0; i < count_of_columns; ++i) state.columns[i].offset += handed[i];
}

/// Returns k/n times the driving head [m2/s], and k/n times the cosine between gravity and the inward normal [m/s].
template <int D>
InfiltrationSpeed infiltration_speed(const Setup<D>& setup, const FaceColumn<D>& c) {
  const double magnitude = setup.weight.norm();
  const Stratum* here = setup.ground.at(just_inside<D>(setup.ground, c.foot, c.normal, c.spacing));
  if (!here) return {};
  const double gamma = setup.ground.specific_weight(), n = here->fillable_porosity;
  const double total = driving_pressure<D>(setup, c);
  // The conductivity with which Darcy's law gives the same discharge when the front is half a spacing inside.
  const double gradient = total / (gamma * 0.5 * c.spacing) + 1.0;
  const double seepage = here->resistance.speed(n * gamma * gradient) / gradient;
  return {seepage * setup.ground.through(c.normal) * total / gamma,
          magnitude > 0.0 ? seepage * setup.ground.through(c.normal, setup.weight) / magnitude : 0.0};
}

/// At a face of soil with air behind it, the water's surface is the face itself. Elsewhere in soil, the suction of the
/// dry ground ahead acts on the water's surface.
template <int D>
void limit_surface(const Setup<D>& setup, const State<D>& state, Stencil<D>& s) {
  const ColumnFinder<D> finder(state.columns);
  const auto& columns = state.columns;
  if (std::any_of(columns.begin(), columns.end(), [](const auto& c) { return c.in_soil && !c.wet; }))
    s.prescribed_surface_distance.allocate(s.n_particles);
  const auto& strata = setup.ground.strata();
  if (std::any_of(strata.begin(), strata.end(), [](const Stratum& soil) { return soil.suction_head != 0.0; }))
    s.surface_pressure.allocate(s.n_particles);
  parallel_for(s.n_real, [&](std::size_t a) {
    if (s.divergence[a] > D || is_free(state.particles, a)) return;
    const double spacing = 2.0 * s.surface_distance(a);
    const int i = finder.nearest(s.position[a]);
    const auto* c = i < 0 ? nullptr : &state.columns[static_cast<std::size_t>(i)];
    const double d = c ? c->inside(s.position[a]) : spacing;
    const bool at_face = c && c->in_soil && !c->wet && d < 0.5 * spacing;
    if (at_face && (!c->provenance.goes_with_soil || d > -faces::deletion_depth * c->spacing)) {
      s.at_face[a] = true;
      s.prescribed_surface_distance.set(a, std::max(d, faces::least_exit_distance * spacing));
    } else if (const double suction = setup.ground.suction(s.position[a]); suction != 0.0) {
      s.surface_pressure.set(a, -suction);
    }
  });
  s.fill_copies(s.prescribed_surface_distance);
  s.fill_copies(s.surface_pressure);
}

/// Water that the soil has left behind belongs to the reservoir: the column moves back to where soil is.
template <int D>
void follow_soil(const Setup<D>& setup, const SoilView<D>& view, State<D>& state) {
  const auto& p = state.particles;
  const ColumnFinder<D> finder(state.columns);
  ScalarArray step(state.columns.size(), 0.0);
  for (std::size_t a = 0; a < p.size(); ++a) {
    if (p.goes_with_soil[a] == 0 || view.coverage[a] >= faces::left_by_soil) continue;
    const int i = finder.nearest(p.position[a]);
    if (i < 0) continue;
    const auto& c = state.columns[static_cast<std::size_t>(i)];
    if (!c.wet || !c.in_soil || c.held) continue;
    step[static_cast<std::size_t>(i)] =
        std::max(step[static_cast<std::size_t>(i)], c.inside(p.position[a]) + 0.5 * c.spacing);
  }
  if (setup.coupled) setup.domain.max(step);
  for (std::size_t i = 0; i < step.size(); ++i) {
    auto& c = state.columns[i];
    if (step[i] <= 0.0) continue;
    c.foot += step[i] * c.normal;
    c.offset = 0.5 * c.spacing;
  }
}

template <int D>
std::vector<StillWater<D>> still_water(const Setup<D>& setup, const Faces<D>& faces,
                                       std::span<const sph::ImagePlane<D>> planes, const State<D>& state) {
  std::vector<StillWater<D>> still;
  const auto add = [&](const FaceColumn<D>& c, const Vec<D>& x) {
    if (setup.weight.dot(x - setup.origin) + c.pressure < 0.0 || setup.ground.at(x)) return;
    for (const auto& plane : planes) {
      const double along = plane.tangent.dot(x);
      const bool beside = plane.to > plane.from && (along < plane.from || along > plane.to);
      if (!beside && plane.normal.dot(x - plane.point) < 0.0) return;
    }
    still.push_back({x, c.volume, c.pressure});
  };
  for (std::size_t i = 0; i < state.columns.size(); ++i) {
    const auto& c = state.columns[i];
    if (!c.provenance.goes_with_soil || !c.wet || !c.in_soil || c.held || !faces.level(state, c.face, state.time))
      continue;
    for (int j = faces::buffers_per_column + 1; j <= faces::reservoir_rows; ++j)
      add(c, c.foot + (c.offset - j * c.spacing) * c.normal);
    if constexpr (D == 2) {
      for (const double side : {-1.0, 1.0}) {
        const Vec<D> next = 2.0 * side * c.width * Vec<D>(-c.normal[1], c.normal[0]);
        if (std::any_of(faces.feet.begin(), faces.feet.end(),
                        [&](const Vec<D>& foot) { return (foot - faces.feet[i] - next).norm() < 1.5 * c.width; }))
          continue;
        for (int k = 1; k <= faces::reservoir_rows; ++k)
          for (int j = 1; j <= faces::reservoir_rows; ++j)
            add(c, c.foot + k * next + (c.offset - j * c.spacing) * c.normal);
      }
    }
  }
  return still;
}

namespace {

/// What a particle that is deleted changes outside, as the numbers that all ranks receive: its id; the index of its
/// column or, below zero, -1 less that of the face whose still water takes it in; its mass [kg]; its distance inside
/// the column's face [m].
enum Departure { departed_id, departed_to, departed_mass, departed_inside, n_departure };

/// Applies the departures of all ranks, in the order in which one rank would: the last particle that passes a column
/// determines where its stack stands.
template <int D>
void let_go(const Setup<D>& setup, std::span<const std::array<double, n_departure>> departures, State<D>& state,
            ScalarArray& crossed) {
  for (const auto& departure : departures) {
    const double volume = departure[departed_mass] / setup.density;
    if (departure[departed_to] < 0.0) {
      state.faces[static_cast<std::size_t>(-1.0 - departure[departed_to])].taken += volume;
      state.balance.out += volume;
      continue;
    }
    const auto i = static_cast<std::size_t>(departure[departed_to]);
    auto& c = state.columns[i];
    if (flow_is_solved_for<D>(setup, state, c) && c.wet) {
      auto& stack = keeper(state, c);
      stack.offset += departure[departed_mass] / per_length(stack);
      continue;
    }
    crossed[i] -= volume;
    if (c.handed_to < 0) c.offset = std::clamp(departure[departed_inside] + c.spacing, 0.0, 0.999 * c.spacing);
  }
}

}  // namespace

template <int D>
void give_birth_and_delete(const Setup<D>& setup, const Faces<D>& faces, const SoilView<D>& view, State<D>& state,
                           ScalarArray& came) {
  auto& p = state.particles;
  const ColumnFinder<D> finder(state.columns);
  std::vector<bool> keep(p.size(), true);
  double lost = 0.0;
  std::vector<std::array<double, n_departure>> departures;
  std::vector<int> nearest(p.size());
  parallel_for(p.size(), [&](std::size_t a) { nearest[a] = finder.nearest(p.position[a]); });
  for (std::size_t a = 0; a < p.size(); ++a) {
    const auto depart = [&](double to, double inside) {
      keep[a] = false;
      departures.push_back({static_cast<double>(id_of(p, a)), to, p.mass[a], inside});
    };
    // Deletes water far outside, if no faster than after a fall: faster water has diverged and is reported.
    if (((p.position[a] - setup.lower).array() < 0.0 || (setup.upper - p.position[a]).array() < 0.0).any() &&
        p.velocity[a].squaredNorm() <= 4.0 * setup.weight.norm() / setup.density * (setup.upper - setup.lower).norm()) {
      keep[a] = false;
      ++lost;
      continue;
    }
    const bool left = p.goes_with_soil[a] != 0 && view.coverage[a] < faces::left_by_soil;
    const bool free = is_free(state.particles, a);
    if (const int f = free ? faces.taker(setup, state, p.position[a]) : -1; f >= 0) {
      depart(-1.0 - f, 0.0);
      continue;
    }
    int i = nearest[a];
    if (i < 0 && left)
      i = static_cast<int>(std::min_element(state.columns.begin(), state.columns.end(),
                                            [&](const auto& b, const auto& c) {
                                              return (b.foot - p.position[a]).squaredNorm() <
                                                     (c.foot - p.position[a]).squaredNorm();
                                            }) -
                           state.columns.begin());
    if (i < 0) continue;
    const auto& c = state.columns[static_cast<std::size_t>(i)];
    // Free water that runs down a face of soil joins the still water behind the face; it does not pass the face.
    if (free && c.in_soil && faces.is_reservoir(c.face)) continue;
    const double d = c.inside(p.position[a]);
    // Soil that slides out of a seepage face carries its water with it.
    const bool passed =
        d < -faces::deletion_depth * c.spacing && (p.goes_with_soil[a] == 0 || c.wet || view.coverage[a] < 0.5);
    // Water that has passed a face is in air or in still water: its pressure, extrapolated with the slope inside, must
    // not be below that of the air.
    if (p.goes_with_soil[a] == 0 && c.in_soil && d < 0.0)
      p.pressure[a] = std::max(p.pressure[a], -setup.weight.dot(p.position[a] - setup.origin));
    if (!passed && !left) continue;
    // Where the flow through the column is solved for, the particle is deleted once this flow has taken out its volume
    // (below). If it is far outside already, its volume is returned to the column.
    if (flow_is_solved_for<D>(setup, state, c) && c.wet && d > -c.spacing) continue;
    depart(i, d);
  }
  ScalarArray crossed(state.columns.size(), 0.0);  // volume of particles that cross each column inwards
  let_go<D>(setup, from_all_ranks(setup, std::move(departures)), state, crossed);
  // The flow takes out the outermost particle of a column, wherever this stands in the first spacing. Beside a wall at
  // which the face ends the velocity is unbounded, and particles are slower than the flow: a column without a particle
  // there takes one of its neighbour's. Distances are measured from half a spacing outside, since rows may be that far
  // ahead of the column; measured from the foot itself, the next row would be nearer.
  for (auto& c : state.columns) {
    if (!flow_is_solved_for<D>(setup, state, c) || !c.wet || c.offset >= -faces::deletion_depth * c.spacing) continue;
    std::size_t found = p.size();
    double nearest_yet = 0.0;
    for (std::size_t a = 0; a < p.size(); ++a) {
      if (!keep[a] || nearest[a] < 0) continue;
      const auto& own = state.columns[static_cast<std::size_t>(nearest[a])];
      if (own.face != c.face || own.inside(p.position[a]) >= faces::outermost_within * own.spacing) continue;
      const double distance = (p.position[a] - c.foot + 0.5 * c.spacing * c.normal).norm();
      if (found != p.size() && distance >= nearest_yet) continue;
      found = a;
      nearest_yet = distance;
    }
    std::vector<std::array<double, 3>> outermost;  // distance, id, mass
    if (found != p.size()) outermost.push_back({nearest_yet, static_cast<double>(id_of(p, found)), p.mass[found]});
    outermost = from_all_ranks(setup, std::move(outermost));
    if (outermost.empty()) continue;
    const auto& [distance, id, mass] = outermost.front();
    if (found != p.size() && static_cast<double>(id_of(p, found)) == id) keep[found] = false;
    c.offset += c.spacing * mass / c.mass;
  }
  const std::size_t had = p.size();
  if (std::ranges::find(keep, false) != keep.end()) p.filter(keep);
  std::array<double, 2> counts{lost, static_cast<double>(had - p.size())};
  setup.domain.sum(counts);
  state.counts.lost += counts[0];
  state.counts.deleted += counts[1];
  for (std::size_t i = 0; i < state.columns.size(); ++i) {
    auto& c = state.columns[i];
    while (c.wet && c.offset >= c.spacing) {  // more than once where volumes were returned
      c.offset -= c.spacing;
      const bool rigid = c.in_soil && !setup.coupled;
      add_particle(
          setup, p,
          rigid ? behind_face<D>(setup.ground, c.foot, c.normal, c.offset) : Vec<D>(c.foot + c.offset * c.normal),
          Vec<D>(c.speed * c.normal), c.mass, c.void_fraction, c.volume, c.pressure + c.slope * c.offset, c.provenance);
      crossed[i] += c.mass / setup.density;
      ++state.counts.born;
    }
    // The part of the stack's outermost particle that lies inside counts as water that has entered.
    if (!flow_is_solved_for<D>(setup, state, c) || !c.wet)
      count<D>(c, came, crossed[i] + c.share(setup.density) - c.stored);
    c.stored = c.share(setup.density);
  }
}

#define PORETWIN_INSTANTIATE(D)                                                                                \
  template struct Faces<D>;                                                                                    \
  template void advance_boundaries(const Setup<D>& setup, const Faces<D>& faces, double time, double interval, \
                                   State<D>& state);                                                           \
  template ScalarArray passed(const State<D>& state);                                                          \
  template bool is_quasi_static(const Setup<D>& setup, const FaceColumn<D>& c);                                \
  template InfiltrationSpeed infiltration_speed(const Setup<D>& setup, const FaceColumn<D>& c);                \
  template void advance_columns(const Setup<D>& setup, const sph::Sight<D>& sight, const Stencil<D>& s,        \
                                const SoilView<D>& view, const WindowSolution<D>& solution, double interval,   \
                                State<D>& state, ScalarArray& came);                                           \
  template void limit_surface(const Setup<D>& setup, const State<D>& state, Stencil<D>& s);                    \
  template void follow_soil(const Setup<D>& setup, const SoilView<D>& view, State<D>& state);                  \
  template void give_birth_and_delete(const Setup<D>& setup, const Faces<D>& faces, const SoilView<D>& view,   \
                                      State<D>& state, ScalarArray& came);                                     \
  template double missing_water(const Setup<D>& setup, const State<D>& state);                                 \
  template std::vector<StillWater<D>> still_water(const Setup<D>& setup, const Faces<D>& faces,                \
                                                  std::span<const sph::ImagePlane<D>> planes, const State<D>& state);
PORETWIN_INSTANTIATE(2)
PORETWIN_INSTANTIATE(3)
#undef PORETWIN_INSTANTIATE

}  // namespace poretwin::fluid
