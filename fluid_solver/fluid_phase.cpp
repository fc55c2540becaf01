#include "fluid_solver/fluid_phase.hpp"

#include "common/case/gauge_kinds.hpp"
#include "common/core/error.hpp"
#include "fluid_solver/discretisation/cloud.hpp"
#include "fluid_solver/discretisation/operators.hpp"
#include "fluid_solver/exchange/drag_form.hpp"
#include "fluid_solver/fluid.hpp"
#include "fluid_solver/motion/packing.hpp"
#include "fluid_solver/numerics/exchange.hpp"
#include "fluid_solver/numerics/motion.hpp"
#include "fluid_solver/numerics/pressure.hpp"
#include "fluid_solver/numerics/steps.hpp"
#include "fluid_solver/numerics/surface.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace poretwin::fluid {

namespace {

/// The box around everything in the case, widened by its diagonal on all sides; without bound along periodic axes.
template <int D>
std::pair<Vec<D>, Vec<D>> reach_of(const Case& scene) {
  Vec<D> lower = Vec<D>::Constant(1e300), upper = -lower;
  const auto enclose = [&](const Point3& x) {
    lower = lower.cwiseMin(Vec<D>(x.head<D>()));
    upper = upper.cwiseMax(Vec<D>(x.head<D>()));
  };
  const auto enclose_shape = [&](const Shape& shape) {
    const auto [lo, hi] = bounds(shape);
    enclose(lo);
    enclose(hi);
  };
  const auto enclose_face = [&](const Face& face) {
    for (const auto& x : face.points) enclose(x);
    if (face.points.empty()) enclose(face.point);
  };
  for (const auto& soil : scene.soils) enclose_shape(soil.shape);
  for (const auto& region : scene.fluid.regions) enclose_shape(region);
  for (const auto& wall : scene.walls) enclose_face(wall.face);
  for (const auto& face : scene.water_faces) enclose_face(face.face);
  const double margin = (upper - lower).norm();
  lower.array() -= margin;
  upper.array() += margin;
  for (const int axis : scene.general.periodic) {
    lower[axis] = -1e300;
    upper[axis] = 1e300;
  }
  return {lower, upper};
}

}  // namespace

template <int D>
Fluid<D>::Fluid(const Case& scene, WaterBoundaries boundaries)
    : scene_(scene), ground_(scene), boundaries_(std::move(boundaries)) {
  dx_ = scene.fluid.particle_spacing;
  density_ = scene.water.density;
  Vec<D> bounded = scene.general.gravity.head<D>();
  for (const int axis : scene.general.periodic) std::swap(periodic_gravity_[axis], bounded[axis]);
  weight_ = density_ * bounded;
  if (weight_.norm() > 0.0) gravity_or_standard_ = weight_.norm() / density_;
  if (!(dx_ > 0.0)) throw CaseError("fluid.particle_spacing must be positive");
  if (scene.fluid.regions.empty() && scene.water_faces.empty())
    throw CaseError("the fluid has nothing to do: no [[fluid.region]] and no [[water_face]]");
  if (scene.walls.size() > sill_boundary) throw CaseError(fmt::format("at most {} walls", sill_boundary));
  for (std::size_t w = 0; w < scene.walls.size(); ++w) {
    const auto& wall = scene.walls[w];
    if (wall.water == Wall::ForWater::none) continue;
    if (wall.water == Wall::ForWater::no_slip) no_slip_ |= 1u << w;
    if (wall.soil != Wall::ForSoil::none && wall.soil != Wall::ForSoil::roller) fixed_soil_ |= 1u << w;
  }
  state_.inlets = make_inlets<D>(scene, boundaries_);
  place_pistons();

  std::tie(lower_, upper_) = reach_of<D>(scene);

  auto& p = state_.particles;
  unsigned seed = scene.fluid.seed;
  double top = -1e300, bottom = 1e300, farthest = 0.0;
  const Vec<D> up = weight_.norm() > 0.0 ? Vec<D>(-weight_.normalized()) : Vec<D>::Zero();
  std::span<const Shape> later = scene.fluid.regions;
  for (const auto& region : scene.fluid.regions) {
    later = later.subspan(1);
    const auto lattice = fill<D>(region, dx_, scene.fluid.offset, scene.fluid.jitter, seed++, later);
    p.reserve(p.size() + lattice.position.size(), !scene.water_faces.empty());
    for (const auto& x : lattice.position) {
      const Stratum* soil = ground_.at(x);
      const double n = soil ? soil->fillable_porosity : 1.0;
      p.add(x, initial_velocity(x), n * density_ * lattice.volume, n, lattice.volume, 0.0);
      const double height = up.dot(x) + 0.5 * dx_;
      farthest = std::max(farthest, x.norm());
      if (height > top) {
        top = height;
        origin_ = height * up;
      }
      bottom = std::min(bottom, height - dx_);
    }
  }
  const double depth = p.size() > 0 ? top - bottom : dx_;
  state_.wave_speed =
      std::sqrt(scene.general.gravity.norm() * depth + scene.general.central_force * farthest * farthest);
  state_.columns = make_columns<D>(scene, ground_);
  joints_ = make_joints<D>(scene);
  one_soil_ = ground_.contrast() < porous::one_conductivity;
  for (const auto& c : state_.columns) feet_.push_back(c.foot);
  // Points that lie on a face of soil to rounding belong to the soil.
  const ColumnFinder<D> finder(state_.columns);
  for (std::size_t a = 0; a < p.size(); ++a)
    if (const int i = finder.nearest(p.position[a]); i >= 0) {
      const auto& c = state_.columns[static_cast<std::size_t>(i)];
      if (c.in_soil && std::abs(c.inside(p.position[a])) < 1e-6 * c.spacing) p.mask[a] = 1.0;
    }
  for (const auto& boundary : boundaries_) state_.faces.push_back(boundary->initial());
  for (int f = 0; f < static_cast<int>(boundaries_.size()); ++f)
    if (!is_opening(f) && level_behind(f, 0.0) &&
        std::all_of(state_.columns.begin(), state_.columns.end(),
                    [&](const auto& c) { return c.face != f || c.in_soil; }))
      reservoirs_.push_back(f);
  update_columns<D>(boundaries_, state_.faces, 0.0, weight_, origin_, state_.columns);
  const auto& here = p.void_fraction;
  faces_follow_ = scene.coupled() && scene.solid.model != SolidCase::Model::elastic && !state_.columns.empty() &&
                  state_.inlets.empty() && std::all_of(here.begin(), here.end(), [](double n) { return n < 1.0; });
  // The soil searches its initial equilibrium under the pressure that is published before the first exchange.
  auto view = rigid_soil<D>(ground_, p.position, scene_.fluid.drag);
  solve_hydrostatic(view);
}

/// Viscosity of free water. Without any it is slowly unstable, so it gets a trace on the scale of the particles.
/// Explicit sweeps transmit sound and need as much as weakly compressible SPH, alpha h c/(2 (D + 2)) with alpha of at
/// least 0.03 and c = 10 sqrt(g H) (Monaghan 1994).
template <int D>
double Fluid<D>::viscosity() const {
  const double share =
      scene_.fluid.scheme == FluidCase::Scheme::projection ? motion::shear_viscosity : motion::sweep_viscosity;
  return std::max(scene_.water.kinematic_viscosity, share * dx_ * state_.wave_speed);
}

template <int D>
Vec<D> Fluid<D>::initial_velocity(const Vec<D>& x) const {
  const auto& fluid = scene_.fluid;
  Vec<D> v = fluid.initial_velocity.head<D>();
  v[0] += fluid.initial_strain * x[0];
  v[1] -= fluid.initial_strain * x[1];
  if (fluid.initial_wave != 0.0)
    v += fluid.initial_wave * sloshing_mode(fluid.regions.front(), to_point3<D>(x), D).template head<D>();
  if (fluid.initial_vortices > 0.0) {
    const auto& box = scene_.general;
    const Vec<2> k = 2.0 * std::numbers::pi / (box.domain_max - box.domain_min).head<2>().array();
    const double a = k[0] * (x[0] - box.domain_min[0]), b = k[1] * (x[1] - box.domain_min[1]);
    v[0] += fluid.initial_vortices * std::sin(a) * std::cos(b);
    v[1] -= fluid.initial_vortices * k[0] / k[1] * std::cos(a) * std::sin(b);
  }
  return v;
}

template <int D>
coupling::Contract Fluid<D>::contract() const {
  auto takes = coupling::standard_fields(coupling::Role::solid, D);
  if (responds())
    for (auto& spec : takes)
      spec.found = spec.name == coupling::field::mean_solid_velocity || spec.name == coupling::field::unbalanced_force;
  return {D, scene_.digest(), coupling::standard_fields(coupling::Role::fluid, D), std::move(takes)};
}

template <int D>
coupling::Publication Fluid<D>::publish() const {
  const auto still = reservoir();
  const auto cloud = make_cloud<D>(state_, planes_, sight_, weight_, origin_, std::span<const StillWater<D>>(still));
  coupling::Publication out;
  out.time = state_.time;
  std::tie(out.proposed_interval, out.limited_by) = proposal();
  out.points.dimension = D;
  out.points.revision = state_.revision;
  out.points.n_active = cloud.n_real;
  out.points.volume = cloud.volume;
  out.points.smoothing_length = cloud.length;
  out.points.owner = cloud.owner;
  // Of the first n points, and zero behind.
  const auto flat = [&cloud](const auto& from, std::size_t n) {
    std::vector<double> values(cloud.size() * D, 0.0);
    for (std::size_t a = 0; a < n; ++a)
      for (std::size_t d = 0; d < D; ++d) values[a * D + d] = from[a][static_cast<int>(d)];
    return values;
  };
  out.points.position = flat(cloud.position, cloud.size());
  std::vector<double> share(cloud.size(), 0.0);
  for (std::size_t a = 0; a < cloud.size(); ++a) share[a] = cloud.surface_share[a];
  const auto name = [](std::string_view n) { return std::string(n); };
  out.fields = {{name(coupling::field::pore_pressure), 1, cloud.pressure},
                {name(coupling::field::predicted_solid_velocity), D, flat(cloud.solid_velocity, cloud.size())},
                {name(coupling::field::predicted_change), D, flat(cloud.solid_change, cloud.size())},
                {name(coupling::field::drag_impulse), D, flat(state_.particles.drag_impulse, cloud.n_real)},
                {name(coupling::field::soil_fraction), 1, cloud.mask},
                {name(coupling::field::surface_gradient), D, flat(cloud.surface_gradient, cloud.size())},
                {name(coupling::field::surface_share), 1, share}};
  return out;
}

/// Whether the skeleton responds inside the pressure solve; explicit sweeps keep its velocity of the last window.
template <int D>
bool Fluid<D>::responds() const {
  return scene_.coupled() && scene_.fluid.skeleton_response && scene_.fluid.scheme == FluidCase::Scheme::projection;
}

template <int D>
SoilView<D> Fluid<D>::soil(const coupling::Inbox& inbox, const SeepageRegime& regime) const {
  const auto& x = state_.particles.position;
  const std::size_t n = x.size();
  // Water that is about to enter or leave the soil through its face still counts as inside; water that runs down the
  // outside of the soil does not.
  const ColumnFinder<D> finder(state_.columns);
  const auto nearest_column = [&](const Vec<D>& point) -> const FaceColumn<D>* {
    const int i = finder.nearest(point);
    if (i < 0) return nullptr;
    const auto& c = state_.columns[static_cast<std::size_t>(i)];
    return c.in_soil && std::abs(c.inside(point)) <= c.spacing ? &c : nullptr;
  };
  if (!scene_.coupled()) {
    VecArray<D> where = x;
    parallel_for(n, [&](std::size_t a) {
      if (auto& point = where[a]; !is_free(a) && !ground_.at(point))
        if (const auto* c = nearest_column(point)) point = just_inside<D>(ground_, c->foot, c->normal, c->spacing);
    });
    auto view = rigid_soil<D>(ground_, where, scene_.fluid.drag);
    if (scene_.fluid.drag_form != FluidCase::DragForm::pointwise) view.drag_form = smoothed_drag<D>(scene_, x);
    return view;
  }
  if (inbox.coverage.size() != n)
    throw PeerError(
        fmt::format("the exchange brought values for {} fluid particles, there are {}", inbox.coverage.size(), n));
  ScalarArray asymmetry = inbox.asymmetry;
  if (!state_.columns.empty())
    for (std::size_t a = 0; a < n; ++a)
      if (inbox.coverage[a] > 0.0 && !is_free(a) && nearest_column(x[a])) asymmetry[a] = 0.0;
  auto view = mapped_soil<D>(scene_, inbox, asymmetry, state_.particles.mask, regime);
  const auto& received = computes_beside() ? state_.particles.previous_coupling_force : state_.particles.coupling_force;
  for (std::size_t a = 0; a < n; ++a)
    if (view.mask[a] > 0.0) view.force.set(a, view.force[a] - received[a]);
  return view;
}

template <int D>
Stencil<D> Fluid<D>::stencil() const {
  const auto& p = state_.particles;
  const auto buffers = make_buffers(state_.columns, true);
  std::vector<char> free(p.size());
  parallel_for(p.size(), [&](std::size_t a) { free[a] = is_free(a); });
  auto s =
      make_stencil<D>(p.position, p.volume, std::span<const Buffer<D>>(buffers), planes_, free, open_water(),
                      scene_.coupled() ? worth_threads_while_others_wait : worth_threads_in_pairs, sight_, joints_);
  fit_columns<D>(state_.columns, free, s, sight_);
  limit_surface(s);
  return s;
}

template <int D>
WindowProblem<D> Fluid<D>::problem(double interval) const {
  WindowProblem<D> in;
  in.interval = interval;
  in.density = density_;
  in.weight = weight_;
  in.origin = origin_;
  in.response = responds();
  in.fixed_soil = fixed_soil_;
  in.void_fraction = state_.particles.void_fraction;
  in.void_volume = state_.particles.void_volume.values();
  const auto& mask = state_.particles.mask;
  if (parallel_all(mask.size(), [&](std::size_t a) { return mask[a] <= 0.5; }))
    in.tolerance = pressure::free_water_tolerance;
  else
    in.tolerance = std::max(in.tolerance / ground_.contrast(), pressure::tightest_tolerance);
  if (scene_.fluid.pressure_tolerance) in.tolerance = *scene_.fluid.pressure_tolerance;
  for (const auto& c : state_.columns) {
    in.face_pressure.push_back(c.pressure);
    in.face_slope.push_back(c.slope);
    in.face_holds.push_back(c.held);
    const Stratum* before =
        scene_.coupled() ? nullptr : ground_.at(just_inside<D>(ground_, c.foot, c.normal, c.spacing));
    in.face_soil.push_back(before ? before->number : -1);
  }
  return in;
}

template <int D>
void Fluid<D>::mark_surface(Stencil<D>& s, std::span<double> rows, double share) {
  auto& p = state_.particles;
  // In soil at rest that is full of water, with water behind every face, no air can come in. A gap of one spacing at
  // the end of a face is then no surface: taken for one, it would draw in the water of several spacings.
  const bool closed = !state_.columns.empty() && p.size() > 0 && (state_.full || state_.time == 0.0) &&
                      std::all_of(state_.columns.begin(), state_.columns.end(),
                                  [&](const auto& c) { return is_quasi_static(c) && c.wet; }) &&
                      parallel_all(p.size(), [&](std::size_t a) { return p.mask[a] > 0.5; });
  const auto flags = find_surface<D>(s, p.in_seepage, rows, share, scene_.coupled(), closed && state_.full);
  s.forget_moments();
  p.surface = flags;
  state_.full = closed && parallel_all(p.size(), [&](std::size_t a) { return flags[a] == Surface::interior; });
}

/// Pressure of water at rest: no source, no velocity, a skeleton that does not move. Solved as one window as long as a
/// fall through the whole scene, so that inertia is negligible in soil. The seepage speed that this pressure drives
/// bounds the first window; no other speed is known yet.
template <int D>
void Fluid<D>::solve_hydrostatic(SoilView<D>& view) {
  auto& p = state_.particles;
  if (p.size() == 0) return;
  auto s = stencil();
  mark_surface(s, {}, 0.0);
  Vec<D> low = p.position[0], high = low;
  for (const auto& x : p.position) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  auto in = problem(std::sqrt(2.0 * ((high - low).norm() + dx_) / gravity_or_standard_));
  in.response = false;
  in.tolerance = pressure::initial_tolerance;
  view.velocity = {};
  view.forget_law();
  WindowSolution<D> out;
  out.pressure = p.pressure;
  solve_window<D>(s, view, p.surface, in, out);
  p.pressure = out.pressure;
  if (scene_.coupled()) store_coupling_force(view, out.gradient, 0.0);
  const double fastest = parallel_max(p.size(), 0.0, [&](std::size_t a) {
    return is_drag_dominated(view, a) ? out.velocity[a].norm() / spacing_of<D>(p.volume[a]) : 0.0;
  });
  state_.window_limits.clear();
  if (fastest > 0.0)
    state_.window_limits.push_back(
        {steps::seepage_courant / fastest, "a quarter spacing per window of seepage that begins"});
}

/// Stores the force of pressure and drag on the soil as evaluated at the water's points. The soil reports its balance
/// of forces with its own evaluation of these forces in it; the difference of the two operators must not move it.
template <int D>
void Fluid<D>::store_coupling_force(const SoilView<D>& view, std::span<const Vec<D>> gradient, double interval) {
  auto& p = state_.particles;
  if (computes_beside()) p.previous_coupling_force = p.coupling_force;
  p.coupling_force.allocate(p.size());
  parallel_for(p.size(), [&](std::size_t a) {
    Vec<D> force = -view.fraction[a] * (gradient[a] + weight_);
    if (interval > 0.0) force += p.drag_impulse[a] / (p.volume[a] * interval);
    p.coupling_force.set(a, force);
  });
  if (computes_beside() && !p.previous_coupling_force.is_allocated()) p.previous_coupling_force = p.coupling_force;
}

/// Takes water out of the seepage regime where most of the soil's water around it is not in it (short windows only). A
/// particle left in it would have a gradient that ignores the free surface beside it, while the skeleton there yields:
/// at a pocket in a run-out of tailings that made a pressure of 5 MPa in one window.
template <int D>
void Fluid<D>::flow_together(const Stencil<D>& s) {
  auto& p = state_.particles;
  const auto in_soil = [&](std::size_t a, bool seeping) {
    return p.mask[a] > 0.5 && (p.in_seepage[a] != 0) == seeping;
  };
  if (!scene_.coupled() || parallel_all(p.size(), [&](std::size_t a) { return !in_soil(a, false); })) return;
  const std::vector<char> alone = p.in_seepage;
  parallel_for(p.size(), [&](std::size_t a) {
    if (!in_soil(a, true)) return;
    double free = 0.0, all = 0.0;
    for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k) {
      const Index q = s.parent[s.other[k]];
      if (q >= p.size() || p.mask[q] <= 0.5) continue;
      const double value = s.value(a, s.other[k]);
      all += value;
      if (alone[q] == 0) free += value;
    }
    if (free > 0.5 * all) p.in_seepage[a] = 0;
  });
}

/// Stores the pressure gradient at the free surface of moving soil, which the soil is given in place of its own. Its
/// own gradient knows only pressures at its points. One-sided at the surface, it turns the pressure that a grain's
/// motion causes into a force in the direction of that motion, and a grain that moves off would accelerate without end.
template <int D>
void Fluid<D>::store_surface_gradient(const Stencil<D>& s, std::span<const Vec<D>> gradient) {
  auto& p = state_.particles;
  p.surface_share = {};
  p.surface_gradient = {};
  for (std::size_t a = 0; a < p.size(); ++a) {
    if (p.in_seepage[a] != 0 || p.mask[a] <= 0.5 || s.ghost_distance[a] <= 0.0) continue;
    p.surface_share.set(a, 1.0, p.size());
    p.surface_gradient.set(a, gradient[a] + weight_, p.size());
  }
}

template <int D>
void Fluid<D>::initialise(const coupling::Inbox& inbox) {
  auto& p = state_.particles;
  auto view = soil(inbox, {density_, quasi_static_speed(), true});  // no window yet: water has no past
  for (std::size_t a = 0; a < p.size(); ++a) {
    // The cells of the lattice are the particles' bulk volumes; the soil at each sets the mass of water in it.
    p.void_fraction[a] = 1.0 - view.fraction[a];
    p.mass[a] = p.void_fraction[a] * density_ * p.volume[a];
    p.mask[a] = view.mask[a];
    p.in_seepage[a] =
        in_seepage_regime<D>(view, a, p.velocity[a], spacing_of<D>(p.volume[a]), {density_, quasi_static_speed(), true})
            ? 1
            : 0;
  }
  begin_control(view, 0.0);
  p.solid_velocity = view.velocity;
  solve_hydrostatic(view);
  limit_scheme(view);
  for (const double m : p.mass) state_.balance.initial += m / density_;
  ++state_.revision;
}

/// Whether drag of the soil around particle a dominates its motion, not inertia.
template <int D>
bool Fluid<D>::is_drag_dominated(const SoilView<D>& view, std::size_t a) const {
  return view.mask[a] > 0.5 && !inertia_rules(state_.particles.void_fraction[a], density_, view.drag[a],
                                              spacing_of<D>(state_.particles.volume[a]), weight_.norm() / density_);
}

/// Whether all water is in the seepage regime and dominated by drag: none moves as free water does.
template <int D>
bool Fluid<D>::all_quasi_static(const SoilView<D>& view) const {
  return parallel_all(view.size(),
                      [&](std::size_t a) { return state_.particles.in_seepage[a] != 0 && is_drag_dominated(view, a); });
}

/// Viscosity of the water itself, Eq. (76) as corrected, its pairs amplified as the pressure's are to be exact for a
/// quadratic on average; a von Neumann-Richtmyer term on approaching pairs for impacts, of third order where the flow
/// is smooth; and a viscosity on the part that is not linear in the neighbourhood, for the noise of single particles.
/// All are pairwise antisymmetric among the water they act on. The relative motion of water past tight soil that moves
/// is no noise: the dampings would couple free water to the soil's water, which drag fixes to the soil, so that the
/// opposite impulse would be lost.
template <int D>
VecArray<D> Fluid<D>::forced_velocity(const Stencil<D>& s, const SoilView<D>& view,
                                      std::span<const Mat<D>> velocity_gradient, double interval) const {
  const auto& v = state_.particles.velocity;
  VecArray<D> result;
  if (!periodic_gravity_.isZero(0.0)) {
    result = v;
    parallel_for(result.size(), [&](std::size_t a) { result[a] += interval * periodic_gravity_; });
  }
  // In soil drag damps what the trace of viscosity would damp, unless inertia dominates there as well.
  std::vector<char> damped(s.n_real);
  parallel_for(s.n_real, [&](std::size_t a) { damped[a] = is_drag_dominated(view, a); });
  if (parallel_all(s.n_real, [&](std::size_t a) { return damped[a]; })) return result;
  if (result.empty()) result = v;
  using motion::impact_viscosity;
  const double noise = motion::noise_viscosity * dx_ * state_.wave_speed, viscosity = this->viscosity();
  // The numerical viscosity is a damping, not a property of water: it need not be exact.
  const bool own = viscosity <= scene_.water.kinematic_viscosity;
  const VecArray<D> all = extended<D>(s, v, Carried::yes, no_slip_);
  // Of a point: velocity, velocity gradient, smoothing length, amplification (0: does not count), whether moving soil
  // takes it along.
  constexpr std::size_t at_gradient = D, at_length = at_gradient + D * D, at_amplified = at_length + 1,
                        at_carried = at_amplified + 1;
  PackedPoints<D, at_carried + 1> points(s.size());
  parallel_for(s.size(), [&](std::size_t j) {
    const Index q = s.parent[j];
    const bool real = q < s.n_real;
    Mat<D> gradient = Mat<D>::Zero();
    if (real) gradient = velocity_gradient[q];
    if (real && j >= s.n_base) {
      const Mat<D>& map = s.map[j - s.n_base];
      gradient = s.sticks(j, no_slip_) ? Mat<D>(-gradient * map.transpose()) : Mat<D>(map * gradient * map.transpose());
    }
    double* const row = points[j].x.data();
    Eigen::Map<Vec<D>>{row} = s.position[j];
    Eigen::Map<Vec<D>>{row + D} = all[j];
    Eigen::Map<Mat<D>>{row + D + at_gradient} = gradient;
    row[D + at_length] = s.length(j);
    row[D + at_amplified] = !real ? 0.0 : own ? s.amplification[q] : 1.0;
    row[D + at_carried] = real && !own && damped[q] && state_.particles.in_seepage[q] == 0 ? 1.0 : 0.0;
  });
  for_pairs_in_lanes<D, at_carried + 1, D>(
      s, points,
      [&](std::size_t, const double* self, std::size_t m, const Lanes* w, const Lanes* point, Lanes* sums)
          __attribute__((always_inline)) {
            // w = factor ba: the speed of approach is that of the points times the factor over that of w.
            Lanes factor;
            take(&s.gradient_factor[m], factor);
            Lanes approach{}, size = Lanes{} + 1e-300;
            for (std::size_t d = 0; d < D; ++d) {
              approach -= (point[d] - self[d]) * w[d];
              size += w[d] * w[d];
            }
            sqrt_in_place(size);
            max_in_place(approach, Lanes{});
            const Lanes impact = 0.5 * impact_viscosity * (self[at_length] + point[at_length]) * approach / size;
            const Lanes shear = 0.5 * viscosity * (self[at_amplified] + point[at_amplified]) + impact;
            for (std::size_t d = 0; d < D; ++d) {
              Lanes unexplained = factor * (point[d] - self[d]);
              for (std::size_t e = 0; e < D; ++e)
                unexplained -= 0.5 * (self[at_gradient + d + D * e] + point[at_gradient + d + D * e]) * w[e];
              const Lanes part = shear * factor * (point[d] - self[d]) + noise * unexplained;
              sums[d] += point[at_amplified] > 0.0 && point[at_carried] == self[at_carried] ? part : Lanes{};
            }
          },
      [&](std::size_t a, const double* total) __attribute__((always_inline)) {
        if (damped[a]) return;
        result[a] += 2.0 * interval * Eigen::Map<const Vec<D>>(total);
        result[a] -= interval * scene_.general.central_force * s.position[a];
      });
  return result;
}

/// Divergence [1/s] that is deferred to later windows: of free water with one-sided neighbours, before this window's
/// forces act. In windows shorter than half the longest one that the water's motion allows, only the fraction
/// interval / that half is removed. The reason: with few neighbours on one side, a pressure gradient can reverse a
/// divergence and leave it larger, by a few percent per solve whatever the window's length. In much shorter windows it
/// would grow until the water flies apart. The first window removes all of what the water starts with.
template <int D>
ScalarArray Fluid<D>::deferred_divergence(const Stencil<D>& s, const SoilView<D>& view, double interval) const {
  const auto& p = state_.particles;
  ScalarArray deferred(p.size(), 0.0);
  if (scene_.fluid.scheme != FluidCase::Scheme::projection || state_.last_interval <= 0.0) return deferred;
  const double fraction = 1.0 - interval / (0.5 * free_interval());
  if (fraction <= 0.0) return deferred;
  parallel_for(p.size(), [&](std::size_t a) {
    if (p.in_seepage[a] == 0 && !is_drag_dominated(view, a) &&
        s.length(a) * s.normal[a].norm() > motion::even_surroundings)
      deferred[a] = fraction;
  });
  if (parallel_all(p.size(), [&](std::size_t a) { return deferred[a] == 0.0; })) return deferred;
  VecArray<D> flux(p.size());
  parallel_for(p.size(), [&](std::size_t a) {
    flux[a] = p.void_fraction[a] * p.velocity[a] + view.fraction[a] * view.velocity[a];
  });
  const ScalarArray outflow = divergence<D>(s, flux, Carried::yes);
  parallel_for(p.size(), [&](std::size_t a) { deferred[a] *= outflow[a]; });
  return deferred;
}

/// Water without soil, in 2D, its pressure solved for: its density is measured in a way that hardly depends on the
/// order of its particles. Over soil a thin fast layer would gain 1 % of its energy by that; in 3D nothing is gained,
/// and explicit sweeps lose.
template <int D>
bool Fluid<D>::open_water() const {
  return D == 2 && ground_.strata().empty() && scene_.fluid.scheme == FluidCase::Scheme::projection;
}

/// Relative excess of the packing around particle a over a lattice's. full: sum V W over that of a lattice, or the
/// measure that replaces it in open water.
template <int D>
double Fluid<D>::packing_error(const Stencil<D>& s, std::size_t a, double full) const {
  const auto& p = state_.particles;
  if (open_water() && p.surface[a] != Surface::lone)
    if (const double below = depth<D>(s, a); below > 0.0) {
      // The missing side is filled with a lattice; a surface may be loose.
      static const double whole = lattice_density<D>();
      return std::max(0.0,
                      full + lattice_density<D>(0.5 + below * points::smoothing_ratio / s.length(a)) / whole - 1.0);
    }
  double excess = full - 1.0;
  // Near a surface the kernel is cut off, so that a deficit there is no error.
  if (excess < 0.0 && !s.covered[a])
    excess *= std::clamp(1.0 - motion::cut_off * s.length(a) * s.normal[a].norm(), 0.0, 1.0);
  const bool below = s.ghost_distance[a] > 0.0;
  return below || p.surface[a] != Surface::interior ? std::max(0.0, excess) : excess;
}

template <int D>
ScalarArray Fluid<D>::volume_source(const Stencil<D>& s, const SoilView<D>& view,
                                    std::span<const Mat<D>> velocity_gradient, double interval) {
  auto& p = state_.particles;
  ScalarArray source = deferred_divergence(s, view, interval);
  // Pressure repairs a packing error by moving the surface or the inflow. A closed domain has neither: shifting alone
  // evens its packing, since pressure would only push on the grains.
  const bool open = !parallel_all(p.size(), [&](std::size_t a) { return p.surface[a] == Surface::interior; }) ||
                    std::any_of(state_.columns.begin(), state_.columns.end(), [](const auto& c) { return c.wet; });
  // Where all soil is full, no flow that pressure drives can even the points out: they are displaced instead (repair).
  const auto motion = open && !state_.full ? moved() : ScalarArray(p.size(), 0.0);
  // Voids opened by cavitation are no packing error.
  const bool cavitates = std::any_of(p.void_volume.begin(), p.void_volume.end(), [](double c) { return c > 0.0; });
  const auto voids_near = [&](std::size_t a) {
    if (!cavitates) return 0.0;
    double sum = p.void_volume[a] / p.void_fraction[a] * Kernel<D>::value(0.0, s.length(a));
    for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k)
      if (const Index q = s.parent[s.other[k]]; q < s.n_real && p.void_volume[q] > 0.0)
        sum += p.void_volume[q] / p.void_fraction[q] * s.value(a, s.other[k]);
    return sum / lattice_fullness<D>();
  };
  parallel_for(p.size(), [&](std::size_t a) {
    const double excess = packing_error(s, a, s.fullness[a] + voids_near(a));
    // In free water the repair of a disordered start begins gradually: at once it would act as an impact.
    const double begun =
        p.in_seepage[a] != 0 ? 1.0 : std::min(1.0, state_.time / free_repair_time(spacing_of<D>(p.volume[a])));
    source[a] += begun * motion[a] * p.void_fraction[a] * excess / repair_time(a, view, interval);
    // Conserves volume to second order in the displacement: det(1 + dt grad v) = 1. Without this term a strain rate s
    // compresses by dt s^2, and its repair adds energy.
    if (p.in_seepage[a] == 0)
      source[a] += std::clamp(0.5 * interval * (velocity_gradient[a] * velocity_gradient[a]).trace(),
                              -motion::most_strain / interval, motion::most_strain / interval);
  });
  if (!responds() || state_.last_interval <= 0.0) return source;
  // The soil moved otherwise than predicted. The volumetric strain beyond the prediction is applied to the water no
  // faster than it accumulated: after a long window, each short one applies only its fraction of it.
  const double came = state_.last_interval, due = std::max(state_.deferred_strain_due, interval);
  state_.deferred_strain_due = std::max({0.0, state_.deferred_strain_due - interval, came - interval});
  if (!p.deferred_strain.is_allocated()) p.deferred_strain.allocate(p.size());
  // What of the mixture's volume goes with the skeleton: the grains and, by their inertia against the drag, the pores.
  const auto follows = [&](std::size_t a) {
    const double aw = p.void_fraction[a] * density_ / came;
    return view.fraction[a] + p.void_fraction[a] * view.drag[a] / (aw + view.drag[a]);
  };
  VecArray<D> beyond(p.size(), Vec<D>::Zero());
  for (std::size_t a = 0; a < p.size(); ++a)
    if (view.fraction[a] > 0.0) beyond[a] = follows(a) * (view.mean_velocity[a] - p.solid_velocity[a]);
  const auto rate = divergence<D>(s, beyond);
  for (std::size_t a = 0; a < p.size(); ++a) {
    const double strain = came * rate[a], applied = strain / std::max(interval, came) + p.deferred_strain[a] / due;
    source[a] -= applied;
    p.deferred_strain.set(a, p.deferred_strain[a] + (strain - applied * interval));
  }
  const auto unseen = unseen_strain_rate(s, view, interval);
  for (std::size_t a = 0; a < p.size(); ++a) source[a] -= follows(a) * unseen[a];
  return source;
}

/// Rate [1/s] at which the soil is to be taken to expand beyond the motion that the water sees. Where rows of soil
/// slide past each other, the soil's kernel sums expand and contract by some 1e-3 of the shear, which the velocity
/// mapped to the water does not show. Undrained soil that expands by 1e-4 loses all its strength, so that what its
/// volume does by its own account is what the water makes room for (decision 0021). It follows over some windows,
/// since each of them also sees the soil's shortest waves, which the mapping smooths; nothing of the strain is lost.
template <int D>
ScalarArray Fluid<D>::unseen_strain_rate(const Stencil<D>& s, const SoilView<D>& view, double interval) {
  auto& p = state_.particles;
  const double came = state_.last_interval;
  state_.usual_interval += (came - state_.usual_interval) / exchange::unseen_strain_windows;
  const double memory = exchange::unseen_strain_windows * std::max({state_.usual_interval, came, interval});
  for (auto* values : {&p.unseen_rate, &p.unseen_strain})
    if (!values->is_allocated()) values->allocate(p.size());
  const auto shown = divergence<D>(s, view.mean_velocity.values());
  ScalarArray applied(p.size());
  parallel_for(p.size(), [&](std::size_t a) {
    bool within = view.mask[a] > 0.0;  // of the soil: at its edge the divergence sees it end
    for (Index k = s.offset[a]; k < s.offset[a + 1] && within; ++k)
      if (const Index q = s.parent[s.other[k]]; q < s.n_real) within = view.mask[q] > 0.0;
    const double rate = within ? view.strain_rate[a] - shown[a] : 0.0;
    const double strain = p.unseen_strain[a] + rate * came;
    // Critically damped, in proportion to the window: a short one that lands on an instant must not jerk the soil.
    const double wanted = rate + strain / (4.0 * memory);
    applied[a] = p.unseen_rate[a] + (wanted - p.unseen_rate[a]) * interval / memory;
    p.unseen_rate.set(a, applied[a]);
    p.unseen_strain.set(a, strain - applied[a] * interval);
  });
  return applied;
}

/// In saturated soil at rest the packing is repaired by displacements without a net volume, so that no water comes or
/// goes through a face. With a pressure, disordered points, whose sum V W exceeds a lattice's, would press water out
/// without end, and the pressure that moves water in one soil would act in all others.
template <int D>
VecArray<D> Fluid<D>::repair(const Stencil<D>& s, const SoilView<D>& view, double interval) const {
  const auto& p = state_.particles;
  if (!state_.full) return {};
  const auto motion = moved();
  ScalarArray share(p.size()), expansion(p.size());
  parallel_for(p.size(), [&](std::size_t a) {
    share[a] = motion[a] * interval / repair_time(a, view, interval);
    expansion[a] = packing_error(s, a, s.fullness[a]);
  });
  const double all = sum_over(p.size(), [&](std::size_t a) { return p.volume[a] * share[a]; });
  const double made = sum_over(p.size(), [&](std::size_t a) { return p.volume[a] * share[a] * expansion[a]; });
  const double mean = all > 0.0 ? made / all : 0.0;
  parallel_for(p.size(), [&](std::size_t a) { expansion[a] = share[a] * (expansion[a] - mean); });
  return expand<D>(s, expansion);
}

/// Applies the impulse that the soil returned. Where the soil's velocity departed from the last window's prediction,
/// drag takes its water along by C / (a + C) of the departure, a = n rho / dt (Eq. (27) at that window's pressure). The
/// soil has already met the inertia of that water (Solid::advance), evaluated at its own points. The difference between
/// the two evaluations is small and uneven; it is distributed over the soil's water within one kernel support, so that
/// the total momentum is conserved.
template <int D>
void Fluid<D>::apply_returned_impulse(const Stencil<D>& s, const SoilView<D>& view) {
  auto& p = state_.particles;
  VecArray<D> left(p.size());
  ScalarArray counts(p.size());
  for (std::size_t a = 0; a < p.size(); ++a) {
    counts[a] = view.mask[a] * p.volume[a];
    left[a] = -view.returned_impulse[a];
    state_.exchanged.received += left[a];
    if (view.mask[a] <= 0.0) continue;
    const Vec<D> along = p.entrained_fraction[a] * (view.velocity[a] - p.solid_velocity[a]);
    p.velocity[a] += along;
    left[a] -= p.mass[a] * along;
  }
  share_out<D>(s, counts, left);
  for (std::size_t a = 0; a < p.size(); ++a) p.velocity[a] += left[a] / p.mass[a];
}

/// Solves one window; with a quadratic drag repeatedly (Newton), about the relative velocity just found, until the
/// tangent meets the law.
template <int D>
WindowSolution<D> Fluid<D>::solve(const Stencil<D>& s, SoilView<D>& view, const WindowProblem<D>& in) {
  const auto& p = state_.particles;
  const bool nonlinear = view.nonlinear();
  WindowSolution<D> out;
  out.multigrid = state_.multigrid;
  for (int round = 1;; ++round) {
    const bool again = !passes_.pressure().empty();
    out.pressure = again ? passes_.pressure() : p.pressure;
    out.solid_velocity = p.solid_velocity;
    if (again) out.solid_velocity.values() = passes_.predicted();
    solve_window<D>(s, view, p.surface, in, out);
    if (!nonlinear || round == pressure::most_drag_rounds) break;
    double error = 0.0, whole = 0.0;
    for (std::size_t a = 0; a < p.size(); ++a) {
      const Vec<D> slip = out.velocity[a] - out.solid_velocity[a];
      const Vec<D> right = view.drag_force(a, slip);
      const double aw = p.void_fraction[a] * density_ / in.interval;
      error += p.volume[a] * (view.drag[a] * slip - view.drag_offset[a] - right).squaredNorm();
      whole += p.volume[a] * (aw * out.velocity[a] + right).squaredNorm();
    }
    if (error <= pressure::drag_tolerance * pressure::drag_tolerance * whole) break;
    view.linearise(out.velocity, out.solid_velocity);
    ++state_.counts.drag_rounds;
  }
  return out;
}

template <int D>
coupling::Outcome Fluid<D>::advance(const coupling::Window& window, const coupling::Inbox& inbox) {
  auto& p = state_.particles;
  const bool sweeps = scene_.fluid.scheme != FluidCase::Scheme::projection;
  const double dt = window.interval, proposed = sweeps ? time_limit().first : dt;
  const SeepageRegime regime{density_, quasi_static_speed(), dt > wave_interval()};
  auto view = soil(inbox, regime);
  view.linearise(p.velocity, view.velocity);
  VecArray<D> velocity_before;
  if (scene_.coupled()) velocity_before = p.velocity;  // the soil's impulse changes it
  parallel_for(p.size(), [&](std::size_t a) {
    p.void_fraction[a] = 1.0 - view.fraction[a];
    p.volume[a] = p.mass[a] / (p.void_fraction[a] * density_);
    p.mask[a] = view.mask[a];
    p.in_seepage[a] = in_seepage_regime<D>(view, a, p.velocity[a], spacing_of<D>(p.volume[a]), regime) ? 1 : 0;
  });
  set_inlets(window.time, dt);
  advance_boundaries(window.time, dt);
  update_columns<D>(boundaries_, state_.faces, window.time + dt, weight_, origin_, state_.columns);
  push_pistons(0.5 * dt);
  drift(dt);
  auto s = stencil();
  ++state_.counts.stencils;
  flow_together(s);
  mark_surface(s, p.row, std::min(1.0, dt / (surface::row_memory * free_repair_time(dx_))));
  if (scene_.coupled() && !computes_beside()) apply_returned_impulse(s, view);
  check_room(window.time);

  auto in = problem(dt);
  in.cavitation = scene_.water.cavitation_pressure;
  if (scene_.coupled()) in.in_seepage = p.in_seepage;
  MatArray<D> gradient;  // empty where all water is quasi-static
  if (!all_quasi_static(view)) gradient = velocity_gradient<D>(s, p.velocity, no_slip_);
  VecArray<D> forced = forced_velocity(s, view, gradient, dt);
  in.source = volume_source(s, view, gradient, dt);
  const auto& scheme = scene_.fluid.scheme;
  if (sweeps) {
    in.sweeps = scene_.fluid.sweeps;
    in.interval_over_proposed = dt / proposed;
  }
  VecArray<D> drag_force;  // of the prediction
  const bool explicit_drag = scheme == FluidCase::Scheme::eisph_explicit_drag;
  const bool returns = view.nonlinear() || explicit_drag;  // to the drag the window began with
  const ScalarArray drag = returns ? view.drag : ScalarArray();
  if (explicit_drag) {
    drag_force.resize(p.size());
    if (forced.empty()) forced = p.velocity;
    // Eq. (75) as corrected: the drag belongs to the prediction.
    for (std::size_t a = 0; a < p.size(); ++a) {
      drag_force[a] = drag[a] * (forced[a] - view.velocity[a]) - view.drag_offset[a];
      forced[a] -= dt / (p.void_fraction[a] * density_) * drag_force[a];
    }
    view.resistance.assign(p.size(), {});
    view.linearise(p.velocity, view.velocity);
  }
  in.velocity = forced.empty() ? p.velocity : forced;
  passes_.begin(window.pass, view);
  if (!passes_.pressure().empty()) in.pressure = p.pressure;
  auto out = solve(s, view, in);
  check_finite(out, window.time);
  state_.counts.windows += 1;
  state_.multigrid = out.multigrid;
  state_.counts.pressure_iterations += out.pressure_iterations;
  state_.counts.multigrid_cycles += out.multigrid_cycles;
  state_.counts.skeleton_iterations += out.skeleton_iterations;
  state_.counts.outer_iterations += out.outer;
  state_.counts.unconverged += out.converged ? 0.0 : 1.0;

  // Copied, not moved: moving would fragment the memory of the state's arrays.
  const ScalarArray before = p.pressure;
  if (!scene_.coupled()) velocity_before = p.velocity;
  p.pressure = out.pressure;
  p.solid_velocity = out.solid_velocity;
  p.velocity = out.velocity;
  p.void_volume = out.void_volume;
  if (const auto cavitating = static_cast<double>(
          std::count_if(p.void_volume.begin(), p.void_volume.end(), [](double c) { return c > 0.0; }));
      cavitating > 0.0) {
    if (state_.counts.cavitating == 0.0) state_.counts.first_cavitation = window.time + dt;
    state_.counts.cavitating = std::max(state_.counts.cavitating, cavitating);
  }
  if (scene_.coupled()) {
    p.drag_impulse.allocate(p.size());
    p.entrained_fraction.allocate(p.size());
    parallel_for(p.size(), [&](std::size_t a) {
      Vec<D> force = view.drag[a] * (p.velocity[a] - p.solid_velocity[a]) - view.drag_offset[a];
      if (!drag_force.empty()) force += drag_force[a];
      p.drag_impulse.set(a, p.volume[a] * dt * force);
      p.entrained_fraction.set(a, view.drag[a] / (p.void_fraction[a] * density_ / dt + view.drag[a]));
    });
    for (std::size_t a = 0; a < p.size(); ++a) {
      state_.exchanged.received -= p.drag_impulse[a];
      state_.exchanged.drag_work -= p.drag_impulse[a].dot(p.velocity[a] - p.solid_velocity[a]);
    }
    store_coupling_force(view, out.gradient, dt);
    passes_.end(p.pressure, p.solid_velocity, p.coupling_force);
    store_surface_gradient(s, out.gradient);
  }
  if (returns) view.drag = drag;
  if (scene_.coupled() && !responds()) {
    // Plain staggering: the skeleton kept its velocity in the solve; its new velocity is predicted explicitly.
    for (std::size_t a = 0; a < p.size(); ++a)
      if (view.density[a] > 0.0)
        p.solid_velocity.values()[a] +=
            dt / view.density[a] * (view.force[a] - view.fraction[a] * (weight_ + out.gradient[a])) +
            p.drag_impulse[a] / (p.volume[a] * view.density[a]);
  }
  if (asks_for(scene_.gauges, "fluid", "unexplained_impulse")) {
    state_.exchanged.from_outside += dt * wall_force();
    for (const double m : p.mass) state_.exchanged.from_outside += dt * m * scene_.general.gravity.head<D>();
  }
  if (scene_.coupled()) {
    p.solid_change.allocate(p.size());
    const auto& from = window.pass > 0 ? passes_.found() : view.velocity;
    for (std::size_t a = 0; a < p.size(); ++a) p.solid_change.set(a, p.solid_velocity[a] - from[a]);
  }
  // Soil that was dry and cannot yield allows windows of any length; its noise would only shorten them.
  if (state_.controlled <= 0.0 && scene_.solid.model != SolidCase::Model::elastic) begin_control(view, dt);
  if (load_begins(window.time)) begin_control(view, 0.0);
  control_interval(before, dt);
  limit_by_slowing(velocity_before, dt);
  limit_by_acceleration(view, velocity_before, dt);
  limit_scheme(view);
  advance_columns(s, view, out, dt);
  push_pistons(0.5 * dt);
  move(s, out, gradient, velocity_before, repair(s, view, dt), dt);
  if (faces_follow_) follow_soil(view);
  give_birth_and_delete(view);
  close_accounts();
  serve_inlets();
  state_.time = window.time + dt;
  state_.last_interval = dt;
  ++state_.revision;
  return coupling::Outcome::accept();
}

/// Throws where inflow meets walls that are already full of water.
template <int D>
void Fluid<D>::check_room(double time) const {
  const auto& p = state_.particles;
  double inflow = 0.0;
  for (const auto& inlet : state_.inlets) inflow += inlet.speed * inlet.width;
  if (inflow == 0.0 || p.size() == 0 ||
      std::any_of(p.surface.begin(), p.surface.end(), [](Surface f) { return f != Surface::interior; }) ||
      std::any_of(state_.columns.begin(), state_.columns.end(), [](const auto& c) { return c.wet; }))
    return;
  throw DivergedError(
      fmt::format("fluid: at t = {:.4g} s water fills all the room between the walls, and the inlets still ask for "
                  "{:.4g} m2/s; give "
                  "it an outlet, a free surface or less discharge",
                  time, inflow));
}

template <int D>
void Fluid<D>::check_finite(const WindowSolution<D>& solution, double time) const {
  const auto& x = state_.particles.position;
  const auto wrong = [&](std::size_t a) {
    return !std::isfinite(solution.pressure[a])      ? "pore_pressure"
           : !solution.velocity[a].allFinite()       ? "velocity"
           : !solution.solid_velocity[a].allFinite() ? "predicted_solid_velocity"
           : solution.velocity[a].norm() > 1e6       ? "velocity (beyond 1e6 m/s)"
                                                     : nullptr;
  };
  if (parallel_all(x.size(), [&](std::size_t a) { return wrong(a) == nullptr; })) return;
  for (std::size_t a = 0; a < x.size(); ++a) {
    if (const char* term = wrong(a))
      throw DivergedError(fmt::format("fluid: {} of particle {} at ({}) is not finite; last good state at t = {} s",
                                      term, a,
                                      D == 2 ? fmt::format("{:.4g}, {:.4g}", x[a][0], x[a][1])
                                             : fmt::format("{:.4g}, {:.4g}, {:.4g}", x[a][0], x[a][1], x[a][D - 1]),
                                      time));
  }
}

template class Fluid<2>;
template class Fluid<3>;

std::unique_ptr<Phase> make_fluid(const Case& scene) {
  if (scene.general.dimension == 3) return std::make_unique<Fluid<3>>(scene);
  return std::make_unique<Fluid<2>>(scene);
}

}  // namespace poretwin::fluid
