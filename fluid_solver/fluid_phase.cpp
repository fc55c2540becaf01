#include "fluid_solver/fluid_phase.hpp"

#include "common/core/error.hpp"
#include "fluid_solver/fluid.hpp"
#include "fluid_solver/packing.hpp"

#include <fmt/format.h>

#include <cmath>

namespace poretwin::fluid {

namespace {

/// Displacement after which a particle's packing counts in full, in spacings.
constexpr double repair_displacement = 0.25;
/// Relative pressure change aimed at per window (rms, of the pressure's range).
constexpr double wanted_change = 0.03;
/// Pressure changes below this share of the hydrostatic range are no reason for shorter windows.
constexpr double hydrostatic_share = 0.05;
constexpr double longest_interval = 8.0;  // s: of slow seepage; with longer ones the ponded front lags

constexpr int periodic_boundary = 31;

}  // namespace

template <int D>
Fluid<D>::Fluid(const Case& scene) : scene_(scene) {
  dx_ = scene.fluid.particle_spacing;
  density_ = scene.water.density;
  weight_ = density_ * scene.general.gravity.head<D>();
  if (!(dx_ > 0.0)) throw CaseError("fluid.particle_spacing must be positive");
  if (scene.fluid.regions.empty() && scene.water_faces.empty())
    throw CaseError("the fluid has nothing to do: no [[fluid.region]] and no [[water_face]]");
  if (scene.walls.size() > 31) throw CaseError("at most 31 walls");
  for (std::size_t w = 0; w < scene.walls.size(); ++w) {
    const auto& wall = scene.walls[w];
    if (wall.water == Wall::ForWater::none) continue;
    if (wall.water == Wall::ForWater::no_slip) no_slip_ |= 1u << w;
    for (const auto& plane : planes_of<D>(wall.face, static_cast<int>(w), 6.0 * dx_)) planes_.push_back(plane);
  }
  for (const auto& plane : periodic_planes<D>(scene.general, periodic_boundary)) planes_.push_back(plane);

  auto& p = state_.particles;
  unsigned seed = scene.fluid.seed;
  double top = -1e300, bottom = 1e300;
  const Vec<D> up = weight_.norm() > 0.0 ? Vec<D>(-weight_.normalized()) : Vec<D>::Zero();
  for (const auto& region : scene.fluid.regions) {
    const auto lattice = fill<D>(region, dx_, scene.fluid.offset, scene.fluid.jitter, seed++);
    for (const auto& x : lattice.position) {
      const Soil* soil = soil_at(scene, to_point3<D>(x));
      const double n = soil ? soil->porosity : 1.0;
      p.add(x, scene.fluid.initial_velocity.head<D>(), n * density_ * lattice.volume, n, lattice.volume, 0.0);
      const double height = up.dot(x) + 0.5 * dx_;
      if (height > top) {
        top = height;
        origin_ = height * up;
      }
      bottom = std::min(bottom, height - dx_);
    }
  }
  const double depth = p.size() > 0 ? top - bottom : dx_;
  // Inviscid free water is slowly unstable: a trace of viscosity on the scale of the particles.
  viscosity_ = std::max(scene.water.kinematic_viscosity, 0.01 * dx_ * std::sqrt(scene.general.gravity.norm() * depth));
  state_.columns = make_columns<D>(scene);
  update_columns<D>(scene_, 0.0, weight_, origin_, state_.columns);
  // The soil looks for its rest under what is published before the first exchange.
  settle(rigid_soil<D>(scene_, p.position));
  saved_ = state_;
}

template <int D>
coupling::Contract Fluid<D>::contract() const {
  return {D, scene_.digest(), coupling::standard_fields(coupling::Role::fluid, D),
          coupling::standard_fields(coupling::Role::solid, D)};
}

template <int D>
coupling::Publication Fluid<D>::publish() const {
  const auto cloud = make_cloud<D>(state_, planes_, weight_, origin_);
  coupling::Publication out;
  out.time = state_.time;
  std::tie(out.proposed_interval, out.limited_by) = time_limit();
  out.points.dimension = D;
  out.points.revision = state_.revision;
  out.points.n_active = cloud.n_real;
  out.points.volume = cloud.volume;
  out.points.smoothing_length = cloud.length;
  out.points.owner = cloud.owner;
  const auto flat = [](const VecArray<D>& from, std::size_t size) {
    std::vector<double> values(size * D, 0.0);
    for (std::size_t a = 0; a < from.size(); ++a)
      for (std::size_t d = 0; d < D; ++d) values[a * D + d] = from[a][static_cast<int>(d)];
    return values;
  };
  out.points.position = flat(cloud.position, cloud.size());
  const auto name = [](std::string_view n) { return std::string(n); };
  out.fields = {{name(coupling::field::pore_pressure), 1, cloud.pressure},
                {name(coupling::field::predicted_solid_velocity), D, flat(cloud.solid_velocity, cloud.size())},
                {name(coupling::field::drag_impulse), D, flat(state_.particles.drag_impulse, cloud.size())},
                {name(coupling::field::soil_fraction), 1, cloud.mask}};
  return out;
}

template <int D>
SoilView<D> Fluid<D>::soil(const coupling::Inbox& inbox) const {
  const auto& x = state_.particles.position;
  const std::size_t n = x.size();
  // A particle about to leave through a face of soil still counts as in it.
  const auto nearest_column = [&](const Vec<D>& point) -> const FaceColumn<D>* {
    for (const auto& c : state_.columns) {
      const double d = c.inside(point);
      if (c.in_soil && std::abs(d) <= c.spacing && (point - c.foot - d * c.normal).norm() <= 1.0001 * c.width)
        return &c;
    }
    return nullptr;
  };
  if (!scene_.coupled()) {
    VecArray<D> where = x;
    for (auto& point : where)
      if (!soil_at(scene_, to_point3<D>(point)))
        if (const auto* c = nearest_column(point)) point = c->foot + 0.25 * c->spacing * c->normal;
    return rigid_soil<D>(scene_, where);
  }
  if (inbox.coverage.size() != n)
    throw PeerError(
        fmt::format("the exchange brought values for {} fluid particles, there are {}", inbox.coverage.size(), n));
  auto complete = inbox;
  if (!state_.columns.empty())
    for (std::size_t a = 0; a < n; ++a)
      if (complete.coverage[a] > 0.3 && nearest_column(x[a])) complete.asymmetry[a] = 0.0;
  return mapped_soil<D>(scene_, complete, n);
}

template <int D>
Stencil<D> Fluid<D>::stencil() const {
  const auto& p = state_.particles;
  const auto buffers = make_buffers(state_.columns);
  auto s = make_stencil<D>(p.position, p.volume, std::span<const Buffer<D>>(buffers), planes_,
                           [&](Index c, const Vec<D>& x) { return state_.columns[c].inside(x); });
  fit_columns(state_.columns, s);
  return s;
}

template <int D>
WindowProblem<D> Fluid<D>::problem(double interval) const {
  WindowProblem<D> in;
  in.interval = interval;
  in.density = density_;
  in.weight = weight_;
  in.origin = origin_;
  in.response = scene_.coupled() && scene_.fluid.skeleton_response;
  in.void_fraction = state_.particles.void_fraction;
  in.velocity = state_.particles.velocity;
  in.source.assign(state_.particles.size(), 0.0);
  for (const auto& c : state_.columns) in.face_pressure.push_back(c.pressure);
  return in;
}

/// Pressure of water at rest: no source, no velocity, the skeleton holds still.
template <int D>
void Fluid<D>::settle(const SoilView<D>& view) {
  auto& p = state_.particles;
  if (p.size() == 0) return;
  const auto s = stencil();
  p.surface = find_surface(s);
  auto in = problem(1.0);
  in.response = false;
  in.tolerance = 1e-8;
  for (auto& v : in.velocity) v.setZero();
  auto still = view;
  for (auto& v : still.velocity) v.setZero();
  WindowSolution<D> out;
  out.pressure = p.pressure;
  WindowSolver<D> solver(s, still, p.surface, in);
  solver.solve(out);
  p.pressure = out.pressure;
}

template <int D>
void Fluid<D>::initialise(const coupling::Inbox& inbox) {
  auto& p = state_.particles;
  const auto view = soil(inbox);
  double stiffest = 0.0;
  for (std::size_t a = 0; a < p.size(); ++a) {
    // The lattice's cells are the particles' bulk volumes; what water they hold follows from the soil as it is.
    p.void_fraction[a] = 1.0 - view.fraction[a];
    p.mass[a] = p.void_fraction[a] * density_ * p.volume[a];
    p.mask[a] = view.mask[a];
    stiffest = std::max(stiffest, view.modulus[a]);
  }
  first_interval_ = stiffest > 0.0 ? 0.2 * dx_ / std::sqrt(stiffest / density_) : 0.0;
  if (scene_.coupled() && scene_.fluid.skeleton_response) state_.controlled = first_interval_;
  settle(view);
  p.solid_velocity = view.velocity;
  ++state_.revision;
}

template <int D>
VecArray<D> Fluid<D>::viscous_velocity(const Stencil<D>& s, const SoilView<D>& view, double interval) const {
  const auto& v = state_.particles.velocity;
  VecArray<D> result = v;
  for (std::size_t a = 0; a < s.n_real; ++a) {
    if (view.mask[a] > 0.5) continue;
    for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k) {
      const Index j = s.other[k], q = s.parent[j];
      if (q >= s.n_real) continue;
      Vec<D> other = v[q];
      if (j >= s.n_base) {
        const auto bits = s.boundaries[j - s.n_base];
        if (bits & no_slip_)
          other = -other;
        else
          other = s.map[j - s.n_base] * other;
      }
      result[a] += interval * viscosity_ * 2.0 * s.volume[j] * s.strength[k] * (other - v[a]);
    }
  }
  return result;
}

template <int D>
ScalarArray Fluid<D>::moved() const {
  const auto& p = state_.particles;
  ScalarArray result(p.size());
  for (std::size_t a = 0; a < p.size(); ++a) {
    const double spacing = std::pow(p.volume[a], 1.0 / D);
    result[a] = std::min(1.0, (p.position[a] - p.birthplace[a]).norm() / (repair_displacement * spacing));
  }
  return result;
}

/// Time in which a packing error is undone [s]: physical, not a number of windows. In soil, a third of what a unit
/// gradient needs to push water through one spacing; in free water twenty times that of a fall through one.
template <int D>
double Fluid<D>::repair_time(std::size_t a, const SoilView<D>& view) const {
  const double spacing = std::pow(state_.particles.volume[a], 1.0 / D);
  const double g = weight_.norm() > 0.0 ? weight_.norm() / density_ : 9.81;
  return std::max(20.0 * std::sqrt(spacing / g),
                  0.3 * spacing * view.drag[a] / (density_ * g * state_.particles.void_fraction[a]));
}

template <int D>
ScalarArray Fluid<D>::volume_source(const Stencil<D>& s, const SoilView<D>& view, double interval) {
  auto& p = state_.particles;
  ScalarArray source(p.size(), 0.0);
  // A packing error is made good by moving the surface or the inflow; in a closed domain there is neither, and shifting alone
  // evens the packing: pressure would only push on the grains.
  const bool open = std::any_of(p.surface.begin(), p.surface.end(), [](Surface f) { return f != Surface::interior; }) ||
                    std::any_of(state_.columns.begin(), state_.columns.end(), [](const auto& c) { return c.wet; });
  const auto motion = open ? moved() : ScalarArray(p.size(), 0.0);
  for (std::size_t a = 0; a < p.size(); ++a) {
    double excess = s.fullness[a] - 1.0;
    // Near a surface the sum is short by nature, not by error.
    if (excess < 0.0) excess *= std::clamp(1.0 - 5.0 * s.length[a] * s.normal[a].norm(), 0.0, 1.0);
    if (p.surface[a] != Surface::interior) excess = std::max(0.0, excess);
    source[a] = motion[a] * p.void_fraction[a] * excess / repair_time(a, view);
  }
  if (!scene_.coupled() || !scene_.fluid.skeleton_response || state_.last_interval <= 0.0) return source;
  // The soil moved by its own account; what that squeezed beyond the prediction is made good now, no faster than it
  // came.
  VecArray<D> beyond(p.size(), Vec<D>::Zero());
  for (std::size_t a = 0; a < p.size(); ++a) {
    if (view.fraction[a] == 0.0) continue;
    const double aw = p.void_fraction[a] * density_ / state_.last_interval;
    const double e = view.fraction[a] + p.void_fraction[a] * view.drag[a] / (aw + view.drag[a]);
    beyond[a] = e * (view.mean_velocity[a] - p.solid_velocity[a]);
  }
  const auto rate = divergence<D>(s, beyond);
  for (std::size_t a = 0; a < p.size(); ++a) {
    p.volume_debt[a] += state_.last_interval * rate[a];
    const double released = p.volume_debt[a] / std::max(interval, state_.last_interval);
    source[a] -= released;
    p.volume_debt[a] -= released * interval;
  }
  return source;
}

/// What the soil took beyond the drag comes from the water in its pores. It is shared out among the soil's water within
/// a kernel's reach, none of it to the free water beside the soil, and taken at the rate at which that water's inertia
/// answers to the drag: where drag rules, the pressure already answers for the soil's motion, through the volume debt.
/// The sum of what is owed and taken is kept.
template <int D>
void Fluid<D>::take_back(const Stencil<D>& s, const SoilView<D>& view, double interval) {
  auto& p = state_.particles;
  VecArray<D> owed(p.size(), Vec<D>::Zero());
  for (std::size_t a = 0; a < p.size(); ++a) {
    const Vec<D> mine = p.owed[a] + view.owed[a];
    if (mine.isZero(0.0)) continue;
    const double own = view.mask[a] * p.volume[a] * Kernel<D>::value(0.0, s.length[a]);
    const auto share = [&](Index k) {
      const Index b = s.other[k];
      return b < s.n_real ? view.mask[b] * p.volume[b] * s.value[k] : 0.0;
    };
    double sum = own;
    for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k) sum += share(k);
    owed[a] += sum > 0.0 ? Vec<D>(own / sum * mine) : mine;
    if (!(sum > 0.0)) continue;
    for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k)
      if (const double w = share(k); w > 0.0) owed[s.other[k]] += w / sum * mine;
  }
  for (std::size_t a = 0; a < p.size(); ++a) {
    const double aw = p.void_fraction[a] * density_ / interval;
    const Vec<D> taken = aw / (aw + view.drag[a]) * owed[a];
    p.velocity[a] -= taken / p.mass[a];
    p.owed[a] = owed[a] - taken;
  }
}

template <int D>
coupling::Outcome Fluid<D>::advance(const coupling::Window& window, const coupling::Inbox& inbox) {
  auto& p = state_.particles;
  const double dt = window.interval;
  const auto view = soil(inbox);
  const VecArray<D> velocity_before = p.velocity;
  for (std::size_t a = 0; a < p.size(); ++a) {
    p.void_fraction[a] = 1.0 - view.fraction[a];
    p.volume[a] = p.mass[a] / (p.void_fraction[a] * density_);
    p.mask[a] = view.mask[a];
  }
  update_columns<D>(scene_, window.time + dt, weight_, origin_, state_.columns);
  const auto s = stencil();
  ++state_.counts.stencils;
  p.surface = find_surface(s);
  if (scene_.coupled()) take_back(s, view, dt);

  auto in = problem(dt);
  in.velocity = viscous_velocity(s, view, dt);
  in.source = volume_source(s, view, dt);
  WindowSolution<D> out;
  out.pressure = p.pressure;
  out.solid_velocity = p.solid_velocity;
  WindowSolver<D> solver(s, view, p.surface, in);
  solver.solve(out);
  check_finite(out, window.time);
  state_.counts.windows += 1;
  state_.counts.pressure_iterations += out.pressure_iterations;
  state_.counts.skeleton_iterations += out.skeleton_iterations;
  state_.counts.outer_iterations += out.outer;
  state_.counts.unconverged += out.converged ? 0.0 : 1.0;

  const ScalarArray before = p.pressure;
  p.pressure = out.pressure;
  p.solid_velocity = out.solid_velocity;
  p.velocity = out.velocity;
  for (std::size_t a = 0; a < p.size(); ++a)
    p.drag_impulse[a] = p.volume[a] * view.drag[a] * dt * (out.velocity[a] - out.solid_velocity[a]);
  if (scene_.coupled() && !scene_.fluid.skeleton_response) {
    // Plain staggering: the skeleton was taken as it moved; where it goes now is an explicit guess.
    for (std::size_t a = 0; a < p.size(); ++a)
      if (view.density[a] > 0.0)
        p.solid_velocity[a] += dt / view.density[a] * (view.force[a] - view.fraction[a] * (weight_ + out.gradient[a])) +
                               p.drag_impulse[a] / (p.volume[a] * view.density[a]);
  }
  control_interval(before, dt);
  advance_columns(s, view, dt);
  move(s, out, velocity_before, dt);
  give_birth_and_delete();
  state_.time = window.time + dt;
  state_.last_interval = dt;
  ++state_.revision;
  return coupling::Outcome::accept();
}

template <int D>
void Fluid<D>::check_finite(const WindowSolution<D>& solution, double time) const {
  const auto& x = state_.particles.position;
  for (std::size_t a = 0; a < x.size(); ++a) {
    const char* term = !std::isfinite(solution.pressure[a])      ? "pore_pressure"
                       : !solution.velocity[a].allFinite()       ? "velocity"
                       : !solution.solid_velocity[a].allFinite() ? "predicted_solid_velocity"
                       : solution.velocity[a].norm() > 1e6       ? "velocity (beyond 1e6 m/s)"
                                                                 : nullptr;
    if (term)
      throw DivergedError(fmt::format("fluid: {} of particle {} at ({}) is not finite; last good state at t = {} s",
                                      term, a,
                                      D == 2 ? fmt::format("{:.4g}, {:.4g}", x[a][0], x[a][1])
                                             : fmt::format("{:.4g}, {:.4g}, {:.4g}", x[a][0], x[a][1], x[a][D - 1]),
                                      time));
  }
}

/// Seepage is as slow or fast as its geometry makes it, and the window's velocity belongs to the geometry at its start:
/// motion extrapolates to the middle of the window (Adams-Bashforth of second order), in units of the last change of
/// velocity.
template <int D>
double Fluid<D>::look_ahead(double interval) const {
  return state_.last_interval > 0.0 ? std::min(1.0, 0.5 * interval / state_.last_interval) : 0.0;
}

template <int D>
void Fluid<D>::move(const Stencil<D>& s, const WindowSolution<D>& solution, std::span<const Vec<D>> velocity_before,
                    double interval) {
  auto& p = state_.particles;
  auto motion = moved();
  for (std::size_t a = 0; a < p.size(); ++a) {
    const double spacing = std::pow(p.volume[a], 1.0 / D);
    motion[a] *= std::min(1.0, p.velocity[a].norm() * interval / (0.02 * spacing));
  }
  const auto shift = packing_displacements<D>(s, p.velocity, motion, p.surface, interval);
  for (std::size_t a = 0; a < p.size(); ++a) {
    Vec<D> d = interval * p.velocity[a] + shift[a];
    if (p.mask[a] > 0.5) d += interval * look_ahead(interval) * (p.velocity[a] - velocity_before[a]);
    p.pressure[a] += solution.gradient[a].dot(d);
    p.position[a] += d;
    keep_inside(p.position[a], p.velocity[a], std::pow(p.volume[a], 1.0 / D));
    for (const int axis : scene_.general.periodic) {
      const double length = scene_.general.domain_max[axis] - scene_.general.domain_min[axis];
      const double wrapped = scene_.general.domain_min[axis] +
                             (p.position[a][axis] - scene_.general.domain_min[axis] -
                              length * std::floor((p.position[a][axis] - scene_.general.domain_min[axis]) / length));
      p.birthplace[a][axis] += wrapped - p.position[a][axis];
      p.position[a][axis] = wrapped;
    }
  }
}

/// A particle that slipped through a wall is mirrored back.
template <int D>
void Fluid<D>::keep_inside(Vec<D>& x, Vec<D>& v, double spacing) const {
  for (const auto& plane : planes_) {
    if (plane.kind != sph::ImagePlane<D>::Kind::mirror) continue;
    const double distance = plane.normal.dot(x - plane.point);
    if (distance >= 0.0 || distance < -spacing) continue;
    if (plane.to > plane.from) {
      const double along = plane.tangent.dot(x);
      if (along < plane.from || along > plane.to) continue;
    }
    x -= 2.0 * distance * plane.normal;
    v -= std::min(0.0, plane.normal.dot(v)) * plane.normal;
  }
}

template <int D>
void Fluid<D>::advance_columns(const Stencil<D>& s, const SoilView<D>& view, double interval) {
  const auto& p = state_.particles;
  if (state_.columns.empty()) return;
  const auto motion = moved();
  sph::CellGrid<D> grid;
  double widest = 0.0;
  for (const auto& c : state_.columns)
    widest = std::max(widest, 2.0 * smoothing_ratio * std::max(c.spacing, 2.0 * c.width));
  grid.build(p.position, widest);
  for (std::size_t i = 0; i < state_.columns.size(); ++i) {
    auto& c = state_.columns[i];
    const double speed_before = c.speed;
    c.speed = 0.0;
    c.slope = 0.0;
    if (!c.wet) continue;
    c.slope = face_slope(s, static_cast<Index>(i), p.pressure, c.pressure).value_or(0.0);
    const Vec<D> probe = c.foot + 0.75 * c.spacing * c.normal;
    const double h = smoothing_ratio * std::pow(c.volume, 1.0 / D);
    double sum = 0.0, speed = 0.0;
    grid.for_each_within(probe, sph::support_radius * h, [&](Index a, double r2) {
      const double w = p.volume[a] * Kernel<D>::value(std::sqrt(r2), h);
      sum += w;
      const double spacing = std::pow(p.volume[a], 1.0 / D);
      speed +=
          w * (c.normal.dot(p.velocity[a]) + motion[a] * 0.5 * (1.0 - s.fullness[a]) * spacing / repair_time(a, view));
    });
    if (sum < 0.05) {
      wet_dry_ground(c, interval);
      continue;
    }
    c.speed = speed / sum;
    c.offset += interval * (c.speed + (c.in_soil ? look_ahead(interval) * (c.speed - speed_before) : 0.0));
  }
}

/// Water behind a wet face enters dry ground as a sharp front, before there is a particle to carry it (Green & Ampt
/// 1911): dz/dt = (k/n) (H/z + cos), H the pressure head at the face, z = offset - spacing/2; the head's part is
/// integrated exactly.
template <int D>
void Fluid<D>::wet_dry_ground(FaceColumn<D>& c, double interval) const {
  const auto speed = infiltration_speed(c);
  const double z = std::max(0.0, c.offset - 0.5 * c.spacing);
  const double deeper = std::sqrt(z * z + 2.0 * speed.head * interval) + std::max(0.0, speed.gravity) * interval;
  c.offset = std::min(c.spacing, 0.5 * c.spacing + deeper);
  c.speed = (deeper - z) / interval;
}

/// k/n times the pressure head at the face [m2/s], and k/n times the cosine between gravity and the way in [m/s].
template <int D>
InfiltrationSpeed Fluid<D>::infiltration_speed(const FaceColumn<D>& c) const {
  const double magnitude = weight_.norm();
  const Soil* here = soil_at(scene_, to_point3<D>(c.foot + 0.25 * c.spacing * c.normal));
  if (!here) return {};
  const double total = std::max(0.0, c.pressure + weight_.dot(c.foot - origin_));
  const double seepage = here->hydraulic_conductivity / here->porosity;
  const double gamma = magnitude > 0.0 ? magnitude : density_ * 9.81;
  return {seepage * total / gamma, magnitude > 0.0 ? seepage * weight_.dot(c.normal) / magnitude : 0.0};
}

template <int D>
void Fluid<D>::give_birth_and_delete() {
  auto& p = state_.particles;
  if (state_.columns.empty()) return;
  std::vector<bool> keep(p.size(), true);
  bool any = false;
  for (std::size_t a = 0; a < p.size(); ++a) {
    for (auto& c : state_.columns) {
      const double d = c.inside(p.position[a]);
      if (d >= -deletion_depth * c.spacing || d < -3.0 * c.spacing) continue;
      const Vec<D> lateral = p.position[a] - c.foot - d * c.normal;
      if (lateral.norm() > c.width * 1.0001) continue;
      keep[a] = false;
      any = true;
      c.offset = std::clamp(d + c.spacing, 0.0, 0.999 * c.spacing);
      break;
    }
  }
  if (any) {
    const std::size_t had = p.size();
    p.filter(keep);
    state_.counts.deleted += static_cast<double>(had - p.size());
  }
  for (auto& c : state_.columns) {
    if (!c.wet || c.offset < c.spacing) continue;
    c.offset -= c.spacing;
    const Soil* here = soil_at(scene_, to_point3<D>(c.foot + 0.25 * c.spacing * c.normal));
    const double n = here ? here->porosity : 1.0;
    p.add(c.foot + c.offset * c.normal, c.speed * c.normal, c.mass, n, c.volume, c.pressure + c.slope * c.offset);
    ++state_.counts.born;
  }
}

/// Next interval from the pressure change of this one; never from a clock.
template <int D>
void Fluid<D>::control_interval(const ScalarArray& before, double interval) {
  const auto& now = state_.particles.pressure;
  if (state_.controlled <= 0.0 || now.empty()) return;
  const auto& x = state_.particles.position;
  double sum = 0.0, lower = now[0], upper = now[0], lightest = weight_.dot(x[0]), heaviest = lightest;
  for (std::size_t a = 0; a < now.size(); ++a) {
    lightest = std::min(lightest, weight_.dot(x[a]));
    heaviest = std::max(heaviest, weight_.dot(x[a]));
    sum += (now[a] - before[a]) * (now[a] - before[a]);
    lower = std::min(lower, now[a]);
    upper = std::max(upper, now[a]);
  }
  for (const auto& c : state_.columns)
    if (c.wet) {
      lower = std::min(lower, c.pressure);
      upper = std::max(upper, c.pressure);
    }
  state_.widest_range = std::max(state_.widest_range, upper - lower);
  // Water at rest has no range of its own: rounding must not shorten its windows.
  const double range = std::max({upper - lower, 1e-3 * state_.widest_range, hydrostatic_share * (heaviest - lightest)});
  state_.pressure_change = range > 0.0 ? std::sqrt(sum / static_cast<double>(now.size())) / range : 0.0;
  const double target =
      state_.pressure_change > 0.0 ? interval * wanted_change / state_.pressure_change : longest_interval;
  state_.controlled = std::clamp(std::clamp(target, 0.3 * state_.controlled, 1.5 * state_.controlled), first_interval_,
                                 longest_interval);
}

template <int D>
std::pair<double, std::string> Fluid<D>::time_limit() const {
  const auto& p = state_.particles;
  std::pair<double, std::string> limit{longest_interval, "slow seepage"};
  const auto apply = [&](double interval, const char* why) {
    if (interval < limit.first) limit = {interval, why};
  };
  if (state_.controlled > 0.0) apply(state_.controlled, "pressure change per window");
  double fastest = 0.0;
  bool free_surface = false;
  for (std::size_t a = 0; a < p.size(); ++a) {
    fastest = std::max(fastest, p.velocity[a].norm() / std::pow(p.volume[a], 1.0 / D));
    free_surface = free_surface || (p.mask[a] < 0.5 && p.surface[a] != Surface::interior);
  }
  for (const auto& c : state_.columns) fastest = std::max(fastest, std::abs(c.speed) / c.spacing);
  if (fastest > 0.0) apply(0.25 / fastest, "a quarter spacing per window at the highest speed");
  if (free_surface && weight_.norm() > 0.0)
    apply(0.3 * std::sqrt(dx_ * density_ / weight_.norm()), "gravity waves of one spacing on the free surface");
  // A face with nothing behind it yet: the time in which the front comes half a spacing in.
  if (p.size() == 0)
    for (const auto& c : state_.columns) {
      if (!c.wet) continue;
      const auto speed = infiltration_speed(c);
      const double half = 0.5 * c.spacing;
      if (speed.head > 0.0) apply(0.5 * half * half / speed.head, "first wetting of dry ground");
      if (speed.gravity > 0.0) apply(half / speed.gravity, "first wetting of dry ground");
    }
  return limit;
}

template <int D>
OutputFrame Fluid<D>::frame() const {
  const auto& p = state_.particles;
  OutputFrame out;
  out.time = state_.time;
  const auto three = [](const VecArray<D>& from) {
    std::vector<double> values(3 * from.size(), 0.0);
    for (std::size_t a = 0; a < from.size(); ++a)
      for (std::size_t d = 0; d < D; ++d) values[3 * a + d] = from[a][static_cast<int>(d)];
    return values;
  };
  out.position = three(p.position);
  ScalarArray pressure(p.size()), flag(p.size());
  VecArray<D> relative(p.size());
  for (std::size_t a = 0; a < p.size(); ++a) {
    pressure[a] = p.pressure[a] + weight_.dot(p.position[a] - origin_);
    flag[a] = p.surface[a] == Surface::interior ? 0.0 : 1.0;
    relative[a] =
        p.mask[a] > 0.0 ? Vec<D>(p.void_fraction[a] * (p.velocity[a] - p.solid_velocity[a])) : Vec<D>(Vec<D>::Zero());
  }
  out.fields = {
      {"velocity", "m/s", "velocity of the water between the grains (intrinsic)", 3, three(p.velocity)},
      {"pore_pressure", "Pa", "total pressure of the water", 1, pressure},
      {"void_fraction", "1", "n_w, water's share of the volume where saturated; 1 in free water", 1, p.void_fraction},
      {"relative_flux", "m/s", "n (v_w - v_s), the discharge through the skeleton; zero in free water", 3,
       three(relative)},
      {"surface", "1", "1 on the free surface", 1, flag},
  };
  return out;
}

template <int D>
std::vector<GaugeReading> Fluid<D>::gauges() const {
  const auto& p = state_.particles;
  std::vector<GaugeReading> readings;
  const bool any =
      std::any_of(scene_.gauges.begin(), scene_.gauges.end(), [](const Gauge& g) { return g.phase == "fluid"; });
  if (!any) return readings;
  const auto cloud = make_cloud<D>(state_, planes_, weight_, origin_);
  const char* axes[3] = {"_x", "_y", "_z"};
  for (const auto& gauge : scene_.gauges) {
    if (gauge.phase != "fluid") continue;
    const auto inside = [&](std::size_t a) {
      return !gauge.region || contains(*gauge.region, to_point3<D>(p.position[a]), D);
    };
    if (gauge.kind == "point") {
      for (std::size_t i = 0; i < gauge.points.size(); ++i) {
        const Vec<D> x = gauge.points[i].template head<D>();
        const std::string name = gauge.points.size() > 1 ? fmt::format("{}[{}]", gauge.name, i) : gauge.name;
        if (gauge.quantity == "pore_pressure") {
          readings.push_back({name, interpolate(cloud, x, [&](std::size_t j) { return cloud.pressure[j]; }), "Pa"});
          continue;
        }
        for (int d = 0; d < D; ++d) {
          const std::string component = std::string("velocity") + axes[d];
          if (gauge.quantity != "velocity" && gauge.quantity != component) continue;
          readings.push_back({gauge.quantity == "velocity" ? name + axes[d] : name,
                              interpolate(cloud, x, [&](std::size_t j) { return cloud.velocity[j][d]; }), "m/s"});
        }
      }
    } else if (gauge.kind == "front") {
      const Vec<D> a = gauge.points[0].template head<D>(), b = gauge.points[1].template head<D>();
      const double length = (b - a).norm(), step = 0.1 * dx_;
      double before = saturation<D>(cloud, a), front = before < 0.5 ? 0.0 : length;
      for (double z = step; before >= 0.5 && z <= length; z += step) {
        const double now = saturation<D>(cloud, Vec<D>(a + z / length * (b - a)));
        if (now < 0.5) {
          front = z - step * (0.5 - now) / (before - now);
          break;
        }
        before = now;
      }
      readings.push_back({gauge.name, front, "m"});
    } else if (gauge.kind == "volume") {
      double volume = 0.0;
      for (std::size_t a = 0; a < p.size(); ++a)
        if (inside(a)) volume += p.mass[a] / density_;
      // The outermost particle of a column stands half a spacing either way: what of it lies outside the face is no
      // water here.
      for (const auto& c : state_.columns)
        if (c.wet &&
            (!gauge.region || contains(*gauge.region, to_point3<D>(Vec<D>(c.foot + 1e-6 * c.spacing * c.normal)), D)))
          volume += c.mass / density_ * (c.offset / c.spacing - 0.5);
      readings.push_back({gauge.name, volume, D == 2 ? "m2" : "m3"});
    } else if (gauge.kind == "momentum") {
      Vec<D> sum = Vec<D>::Zero();
      for (std::size_t a = 0; a < p.size(); ++a)
        if (inside(a)) sum += p.mass[a] * p.velocity[a] - p.owed[a];
      for (int d = 0; d < D; ++d) readings.push_back({gauge.name + axes[d], sum[d], "N s"});
    } else if (gauge.kind == "kinetic_energy") {
      double sum = 0.0;
      for (std::size_t a = 0; a < p.size(); ++a)
        if (inside(a)) sum += 0.5 * p.mass[a] * p.velocity[a].squaredNorm();
      readings.push_back({gauge.name, sum, "J"});
    } else if (gauge.kind == "particles") {
      double count = 0.0;
      for (std::size_t a = 0; a < p.size(); ++a) count += inside(a) ? 1.0 : 0.0;
      readings.push_back({gauge.name, count, "1"});
    } else if (gauge.kind == "max_speed") {
      double fastest = 0.0;
      for (std::size_t a = 0; a < p.size(); ++a)
        if (inside(a)) fastest = std::max(fastest, p.velocity[a].norm());
      readings.push_back({gauge.name, fastest, "m/s"});
    }
  }
  return readings;
}

template <int D>
std::map<std::string, double> Fluid<D>::counters() const {
  const auto& c = state_.counts;
  return {{"particles", static_cast<double>(state_.particles.size())},
          {"windows", c.windows},
          {"pressure iterations", c.pressure_iterations},
          {"skeleton iterations", c.skeleton_iterations},
          {"outer iterations", c.outer_iterations},
          {"solves that missed their tolerance", c.unconverged},
          {"list rebuilds", c.stencils},
          {"born", c.born},
          {"deleted", c.deleted}};
}

template class Fluid<2>;
template class Fluid<3>;

std::unique_ptr<Phase> make_fluid(const Case& scene) {
  if (scene.general.dimension == 3) return std::make_unique<Fluid<3>>(scene);
  return std::make_unique<Fluid<2>>(scene);
}

}  // namespace poretwin::fluid
