// Water that comes and goes through columns of buffers.
#include "fluid_solver/fluid_phase.hpp"

#include "common/geometry/shapes.hpp"
#include "fluid_solver/discretisation/operators.hpp"

#include <cmath>

namespace poretwin::fluid {

/// What stands behind the faces at the end of a window, the flow through them taken as it was in the last one.
template <int D>
void Fluid<D>::advance_boundaries(double time, double interval) {
  const auto through = passed();
  for (std::size_t f = 0; f < boundaries_.size(); ++f) {
    double leaves = 0.0;
    for (const auto& c : state_.columns)
      if (c.face == static_cast<int>(f) && c.wet) leaves += interval * c.speed * c.mass / (density_ * c.spacing);
    for (const auto& inlet : state_.inlets)
      if (inlet.face == static_cast<int>(f)) leaves += interval * inlet.speed * inlet.width;
    boundaries_[f]->advance(time, interval, {through[f], leaves}, state_.faces[f]);
    boundaries_[f]->check(time + interval, state_.faces[f]);
  }
}

template <int D>
std::optional<double> Fluid<D>::level_behind(int face, double time) const {
  const auto f = static_cast<std::size_t>(face);
  return boundaries_[f]->level(time, state_.faces[f]);
}

/// Volume that has come in through each face, less what has gone out [m^D].
template <int D>
ScalarArray Fluid<D>::passed() const {
  ScalarArray sum(state_.faces.size());
  for (std::size_t f = 0; f < sum.size(); ++f) sum[f] = -state_.faces[f].taken;
  for (const auto& c : state_.columns) sum[static_cast<std::size_t>(c.face)] += c.passed;
  for (const auto& inlet : state_.inlets) sum[static_cast<std::size_t>(inlet.face)] += inlet.passed();
  return sum;
}

/// Whether water flows quasi-statically through a column into soil at rest: drag-dominated, its pressure solved for.
template <int D>
bool Fluid<D>::is_quasi_static(const FaceColumn<D>& c) const {
  return c.drag_dominated && !scene_.coupled() && scene_.fluid.scheme == FluidCase::Scheme::projection;
}

/// Whether the flow through a column is part of the pressure solve: where it is quasi-static, in soil of one
/// conductivity or full of water. Elsewhere the skeleton or inertia carries part of it, and the column moves as the
/// water in front of it does.
template <int D>
bool Fluid<D>::flow_is_solved_for(const FaceColumn<D>& c) const {
  return is_quasi_static(c) && (one_soil_ || state_.full);
}

/// Counts water that comes in through a column, or goes out.
template <int D>
void Fluid<D>::count(FaceColumn<D>& c, double volume) {
  c.passed += volume;
  came_.resize(state_.faces.size(), 0.0);
  came_[static_cast<std::size_t>(c.face)] += volume;
}

/// What came through a face in the window, less what went: from column to column it goes in and out with the packing.
template <int D>
void Fluid<D>::close_accounts() {
  for (double& volume : came_) {
    (volume > 0.0 ? state_.balance.in : state_.balance.out) += std::abs(volume);
    volume = 0.0;
  }
}

/// What the faces' account has let in beyond what the particles' water has grown by [m^D].
template <int D>
double Fluid<D>::missing_water() const {
  double stored = 0.0;
  for (const double m : state_.particles.mass) stored += m / density_;
  for (const auto& c : state_.columns) stored += c.share(density_);
  for (const auto& inlet : state_.inlets) stored += inlet.piston * inlet.width;
  return state_.balance.in - state_.balance.out - (stored - state_.balance.initial);
}

template <int D>
void Fluid<D>::advance_columns(const Stencil<D>& s, const SoilView<D>& view, const WindowSolution<D>& solution,
                               double interval) {
  const auto& p = state_.particles;
  if (state_.columns.empty()) return;
  const auto motion = moved();
  sph::CellGrid<D> grid;
  double widest = 0.0;
  for (const auto& c : state_.columns)
    widest = std::max(widest, 2.0 * points::smoothing_ratio * std::max(c.spacing, 2.0 * c.width));
  grid.build(p.position, widest);
  typename sph::Sight<D>::Near near;
  for (std::size_t i = 0; i < state_.columns.size(); ++i) {
    auto& c = state_.columns[i];
    const double speed_before = c.speed;
    // A column that a head has reached or left holds water or none.
    if (flow_is_solved_for(c)) {
      count(c, c.share(density_) - c.stored);
      c.stored = c.share(density_);
    }
    c.speed = 0.0;
    c.slope = 0.0;
    if (!c.wet) continue;
    c.slope = face_slope(s, static_cast<Index>(i), p.pressure, c.pressure).value_or(0.0);
    const Vec<D> probe = c.foot + faces::probe_depth * c.spacing * c.normal;
    const double h = points::smoothing_ratio * spacing_of<D>(c.volume);
    double sum = 0.0, speed = 0.0;
    // Of two soils side by side each moves its own columns.
    const Stratum* here = ground_.strata().size() > 1 && !scene_.coupled() ? ground_.at(probe) : nullptr;
    if (sight_.limited()) sight_.find_near(probe, sph::support_radius * h, near);
    grid.for_each_within(probe, sph::support_radius * h, [&](Index a, double r2) {
      if (c.in_soil && is_free(a)) return;
      if (!near.empty() && !sight_.open(probe, p.position[a], near)) return;
      if (const Stratum* there = here ? ground_.at(p.position[a]) : nullptr; there != here && there) return;
      const double w = p.volume[a] * Kernel<D>::value(std::sqrt(r2), h);
      sum += w;
      const double spacing = spacing_of<D>(p.volume[a]);
      const double loose =
          -motion[a] * 0.5 * packing_error(s, a, s.fullness[a]) * spacing / repair_time(a, view, interval);
      speed += w * (c.normal.dot(p.velocity[a]) + loose);
    });
    if (sum < faces::least_seen) {
      const double before = c.offset;
      wet_dry_ground(c, interval);
      if (flow_is_solved_for(c)) count(c, c.mass / density_ * (c.offset - before) / c.spacing);
      continue;
    }
    const double area = c.volume / c.spacing;
    const double solved = (solution.face_carry[i] + solution.face_flow[i] / area) / c.void_fraction;
    c.speed = flow_is_solved_for(c) && std::isfinite(solved) ? solved : speed / sum;
    const double advance = interval * (c.speed + (c.in_soil ? look_ahead(interval) * (c.speed - speed_before) : 0.0));
    c.offset += advance;
    if (flow_is_solved_for(c)) count(c, c.mass / density_ * advance / c.spacing);
  }
}

/// What drives water in at a column's foot: the water's pressure and the suction of the dry ground behind it [Pa].
template <int D>
double Fluid<D>::driving_pressure(const FaceColumn<D>& c) const {
  return std::max(0.0, c.pressure + weight_.dot(c.foot - origin_)) +
         ground_.suction(just_inside<D>(ground_, c.foot, c.normal, c.spacing));
}

/// Water behind a wet face enters dry ground as a sharp front, before there is a particle to carry it (Green & Ampt
/// 1911): dz/dt = (k/n) (H/z + cos), H the pressure head at the face and the suction head ahead, z = offset -
/// spacing/2; the head's part is integrated exactly.
template <int D>
void Fluid<D>::wet_dry_ground(FaceColumn<D>& c, double interval) const {
  const auto speed = infiltration_speed(c);
  const double z = std::max(0.0, c.offset - 0.5 * c.spacing);
  // No faster than a jet from the head that drives it, suction included: a front starts under suction alone.
  const double total = driving_pressure(c);
  const double jet = std::sqrt(2.0 * (total + weight_.norm() * c.spacing) / density_);
  const double deeper = std::min(
      z + jet * interval, std::sqrt(z * z + 2.0 * speed.head * interval) + std::max(0.0, speed.gravity) * interval);
  c.offset = std::min(c.spacing, 0.5 * c.spacing + deeper);
  // At the window's end, for the particles that take over.
  const double depth = std::clamp(deeper, faces::least_front_depth * c.spacing, 0.5 * c.spacing);
  c.speed = std::min(jet, speed.head / depth + std::max(0.0, speed.gravity));
  c.slope = -weight_.dot(c.normal) - total / depth;
}

/// k/n times the head that drives [m2/s], and k/n times the cosine between gravity and the way in [m/s].
template <int D>
InfiltrationSpeed Fluid<D>::infiltration_speed(const FaceColumn<D>& c) const {
  const double magnitude = weight_.norm();
  const Stratum* here = ground_.at(just_inside<D>(ground_, c.foot, c.normal, c.spacing));
  if (!here) return {};
  const double gamma = ground_.specific_weight(), n = here->fillable_porosity;
  const double total = driving_pressure(c);
  // Darcy's conductivity of the same discharge at the gradient that the front meets half a spacing in.
  const double gradient = total / (gamma * 0.5 * c.spacing) + 1.0;
  const double seepage = here->resistance.speed(n * gamma * gradient) / gradient;
  return {seepage * total / gamma, magnitude > 0.0 ? seepage * weight_.dot(c.normal) / magnitude : 0.0};
}

/// Nothing holds the water at a face of soil without water behind it but the air: there its surface is the face itself.
/// Elsewhere in soil it is drawn on by the suction of the dry ground ahead.
template <int D>
void Fluid<D>::limit_surface(Stencil<D>& s) const {
  const ColumnFinder<D> finder(state_.columns);
  const auto& columns = state_.columns;
  if (std::any_of(columns.begin(), columns.end(), [](const auto& c) { return c.in_soil && !c.wet; }))
    s.prescribed_surface_distance.allocate(s.n_real);
  const auto& strata = ground_.strata();
  if (std::any_of(strata.begin(), strata.end(), [](const Stratum& soil) { return soil.suction_head != 0.0; }))
    s.surface_pressure.allocate(s.n_real);
  parallel_for(s.n_real, [&](std::size_t a) {
    if (s.divergence[a] > D || is_free(a)) return;
    const double spacing = 2.0 * s.surface_distance(a);
    const int i = finder.nearest(s.position[a]);
    const auto* c = i < 0 ? nullptr : &state_.columns[static_cast<std::size_t>(i)];
    const double d = c ? c->inside(s.position[a]) : spacing;
    const bool at_face = c && c->in_soil && !c->wet && d < 0.5 * spacing;
    if (at_face && (!faces_follow_ || d > -faces::deletion_depth * c->spacing)) {
      s.at_face[a] = true;
      s.prescribed_surface_distance.set(a, std::max(d, faces::least_exit_distance * spacing));
    } else if (const double suction = ground_.suction(s.position[a]); suction != 0.0) {
      s.surface_pressure.set(a, -suction);
    }
  });
}

/// Water that the soil has left belongs to the reservoir: the column steps back to where there is soil.
template <int D>
void Fluid<D>::follow_soil(const SoilView<D>& view) {
  const auto& p = state_.particles;
  const ColumnFinder<D> finder(state_.columns);
  std::vector<double> step(state_.columns.size(), 0.0);
  for (std::size_t a = 0; a < p.size(); ++a) {
    if (view.coverage[a] >= faces::left_by_soil) continue;
    const int i = finder.nearest(p.position[a]);
    if (i < 0) continue;
    const auto& c = state_.columns[static_cast<std::size_t>(i)];
    if (!c.wet || !c.in_soil || c.held) continue;
    step[static_cast<std::size_t>(i)] =
        std::max(step[static_cast<std::size_t>(i)], c.inside(p.position[a]) + 0.5 * c.spacing);
  }
  for (std::size_t i = 0; i < step.size(); ++i) {
    auto& c = state_.columns[i];
    if (step[i] <= 0.0) continue;
    c.foot += step[i] * c.normal;
    c.offset = 0.5 * c.spacing;
  }
}

/// The still water behind faces, as far as soil may slide into it: the columns' rows beyond those that the water's own
/// operators need, and more columns where a face ends in the open. Its piezometric pressure is the face's.
template <int D>
std::vector<StillWater<D>> Fluid<D>::reservoir() const {
  std::vector<StillWater<D>> still;
  if (!faces_follow_) return still;
  const auto add = [&](const FaceColumn<D>& c, const Vec<D>& x) {
    if (weight_.dot(x - origin_) + c.pressure < 0.0 || ground_.at(x)) return;
    for (const auto& plane : planes_) {
      const double along = plane.tangent.dot(x);
      const bool beside = plane.to > plane.from && (along < plane.from || along > plane.to);
      if (!beside && plane.normal.dot(x - plane.point) < 0.0) return;
    }
    still.push_back({x, c.volume, c.pressure});
  };
  for (std::size_t i = 0; i < state_.columns.size(); ++i) {
    const auto& c = state_.columns[i];
    if (!c.wet || !c.in_soil || c.held || !level_behind(c.face, state_.time)) continue;
    for (int j = faces::buffers_per_column + 1; j <= faces::reservoir_rows; ++j)
      add(c, c.foot + (c.offset - j * c.spacing) * c.normal);
    if constexpr (D == 2) {
      for (const double side : {-1.0, 1.0}) {
        const Vec<D> next = 2.0 * side * c.width * Vec<D>(-c.normal[1], c.normal[0]);
        if (std::any_of(feet_.begin(), feet_.end(),
                        [&](const Vec<D>& foot) { return (foot - feet_[i] - next).norm() < 1.5 * c.width; }))
          continue;
        for (int k = 1; k <= faces::reservoir_rows; ++k)
          for (int j = 1; j <= faces::reservoir_rows; ++j)
            add(c, c.foot + k * next + (c.offset - j * c.spacing) * c.normal);
      }
    }
  }
  return still;
}

/// Does particle a belong to no soil? Where faces follow the soil all water is the soil's or the reservoirs'.
template <int D>
bool Fluid<D>::is_free(std::size_t a) const {
  return !faces_follow_ && state_.particles.mask[a] <= 0.5;
}

/// The face behind which still water takes in what is at x, below its level; -1: none. Above a crest the sill's piston
/// does that.
template <int D>
int Fluid<D>::taker(const Vec<D>& x) const {
  const Point3 point = to_point3<D>(x);
  for (const int f : reservoirs_)
    if (-weight_.dot(x) <= weight_.norm() * level_behind(f, state_.time).value() &&
        is_behind(scene_, scene_.water_faces[static_cast<std::size_t>(f)], point))
      return f;
  return -1;
}

template <int D>
void Fluid<D>::give_birth_and_delete(const SoilView<D>& view) {
  auto& p = state_.particles;
  const ColumnFinder<D> finder(state_.columns);
  std::vector<bool> keep(p.size(), true);
  bool any = false;
  ScalarArray crossed(state_.columns.size(), 0.0);  // in particles, inwards
  std::vector<int> nearest(p.size());
  parallel_for(p.size(), [&](std::size_t a) { nearest[a] = finder.nearest(p.position[a]); });
  for (std::size_t a = 0; a < p.size(); ++a) {
    // Far outside, and no faster than a fall makes it: water that diverges is not hushed up.
    if (((p.position[a] - lower_).array() < 0.0 || (upper_ - p.position[a]).array() < 0.0).any() &&
        p.velocity[a].squaredNorm() <= 4.0 * weight_.norm() / density_ * (upper_ - lower_).norm()) {
      keep[a] = false;
      any = true;
      ++state_.counts.lost;
      continue;
    }
    const bool left = faces_follow_ && view.coverage[a] < faces::left_by_soil;
    const bool free = is_free(a);
    if (const int f = free ? taker(p.position[a]) : -1; f >= 0) {
      keep[a] = false;
      any = true;
      state_.faces[static_cast<std::size_t>(f)].taken += p.mass[a] / density_;
      state_.balance.out += p.mass[a] / density_;
      continue;
    }
    int i = nearest[a];
    if (i < 0 && left)
      i = static_cast<int>(std::min_element(state_.columns.begin(), state_.columns.end(),
                                            [&](const auto& b, const auto& c) {
                                              return (b.foot - p.position[a]).squaredNorm() <
                                                     (c.foot - p.position[a]).squaredNorm();
                                            }) -
                           state_.columns.begin());
    if (i < 0) continue;
    auto& c = state_.columns[static_cast<std::size_t>(i)];
    // Water that runs down the soil's face passes it by, to the still water behind it.
    if (free && c.in_soil && std::find(reservoirs_.begin(), reservoirs_.end(), c.face) != reservoirs_.end()) continue;
    const double d = c.inside(p.position[a]);
    // Soil that slides out of a seepage face takes its water along.
    const bool passed = d < -faces::deletion_depth * c.spacing && (!faces_follow_ || c.wet || view.coverage[a] < 0.5);
    // What has passed a face is in the air or in still water; its pressure, carried along with the slope inside, is not
    // below the air's.
    if (!faces_follow_ && c.in_soil && d < 0.0)
      p.pressure[a] = std::max(p.pressure[a], -weight_.dot(p.position[a] - origin_));
    if (!passed && !left) continue;
    if (flow_is_solved_for(c) && c.wet) {
      // It goes when the flow through the column has taken it (below). Far outside it is given back to the column.
      if (d > -c.spacing) continue;
      keep[a] = false;
      any = true;
      c.offset += c.spacing * p.mass[a] / c.mass;
      continue;
    }
    keep[a] = false;
    any = true;
    crossed[static_cast<std::size_t>(i)] -= p.mass[a] / density_;
    c.offset = std::clamp(d + c.spacing, 0.0, 0.999 * c.spacing);
  }
  // What the flow has taken out through a column is its outermost particle, wherever in the first spacing that stands:
  // beside a wall on which the face ends the velocity has no bound, and particles move more slowly than the flow. Where
  // a column has none there left, its neighbour's goes. Distances are from half a spacing outside: rows may be that far
  // ahead of the column, and from the foot itself the row behind them would be nearer.
  for (auto& c : state_.columns) {
    if (!flow_is_solved_for(c) || !c.wet || c.offset >= -faces::deletion_depth * c.spacing) continue;
    std::size_t found = p.size();
    double nearest_yet = 0.0;
    for (std::size_t a = 0; a < p.size(); ++a) {
      if (!keep[a] || nearest[a] < 0) continue;
      const auto& own = state_.columns[static_cast<std::size_t>(nearest[a])];
      if (own.face != c.face || own.inside(p.position[a]) >= faces::outermost_within * own.spacing) continue;
      const double distance = (p.position[a] - c.foot + 0.5 * c.spacing * c.normal).norm();
      if (found != p.size() && distance >= nearest_yet) continue;
      found = a;
      nearest_yet = distance;
    }
    if (found == p.size()) continue;
    keep[found] = false;
    any = true;
    c.offset += c.spacing * p.mass[found] / c.mass;
  }
  if (any) {
    const std::size_t had = p.size();
    p.filter(keep);
    state_.counts.deleted += static_cast<double>(had - p.size());
  }
  for (std::size_t i = 0; i < state_.columns.size(); ++i) {
    auto& c = state_.columns[i];
    while (c.wet && c.offset >= c.spacing) {  // several where some were given back
      c.offset -= c.spacing;
      const bool rigid = c.in_soil && !scene_.coupled();
      p.add(rigid ? behind_face<D>(ground_, c.foot, c.normal, c.offset) : Vec<D>(c.foot + c.offset * c.normal),
            c.speed * c.normal, c.mass, c.void_fraction, c.volume, c.pressure + c.slope * c.offset);
      crossed[i] += c.mass / density_;
      ++state_.counts.born;
    }
    // The part of the stack's outermost particle that is inside counts as water that came.
    if (!flow_is_solved_for(c) || !c.wet) count(c, crossed[i] + c.share(density_) - c.stored);
    c.stored = c.share(density_);
  }
}

template class Fluid<2>;
template class Fluid<3>;

}  // namespace poretwin::fluid
