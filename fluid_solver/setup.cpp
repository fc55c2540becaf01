#include "fluid_solver/setup.hpp"

#include "common/core/error.hpp"
#include "common/geometry/thin_walls.hpp"
#include "fluid_solver/discretisation/bodies.hpp"
#include "fluid_solver/state.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace poretwin::fluid {

namespace {

/// The box around everything in the case except planes. It is widened on all sides by its diagonal, or by ten diagonals
/// if the case has planes, and unbounded along periodic axes.
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
  // A face given as a plane has no ends, and water in front of it may reach far beyond the rest: hence the wide box.
  bool endless = false;
  const auto enclose_face = [&](const Face& face) {
    for (const auto& x : face.points) enclose(x);
    endless = endless || face.points.empty();
  };
  for (const auto& soil : scene.soils) enclose_shape(soil.shape);
  for (const auto& region : scene.fluid.regions) enclose_shape(region);
  for (const auto& wall : scene.walls)
    if (wall.shape)
      enclose_shape(*wall.shape);
    else
      enclose_face(wall.face);
  for (const auto& face : scene.water_faces) enclose_face(face.face);
  constexpr double far = 10.0;
  const double margin = (endless ? far : 1.0) * (upper - lower).norm();
  lower.array() -= margin;
  upper.array() += margin;
  for (const int axis : scene.general.periodic) {
    lower[axis] = -1e300;
    upper[axis] = 1e300;
  }
  return {lower, upper};
}

/// Refuses what several ranks that share the water cannot compute.
void expect_possible_on_ranks(const Case& scene) {
  const auto refuse = [](bool found, std::string_view what, std::string_view instead) {
    if (found)
      throw CaseError(
          fmt::format("several ranks cannot share this water yet: {}; {}, or run the case on one rank", what, instead));
  };
  refuse(std::ranges::any_of(scene.soils, porous::is_anisotropic), "soil.anisotropy: it has soil in beds",
         "leave the key out");
  refuse(scene.fluid.representation != FluidCase::Representation::particles,
         "fluid.representation is not \"particles\"", "leave the key out");
  refuse(scene.fluid.scheme != FluidCase::Scheme::projection, "fluid.scheme is not \"projection\"",
         "leave the key out");
  for (const Wall& wall : scene.walls)
    refuse(wall.water != Wall::ForWater::none && wall.shape.has_value(),
           fmt::format("[[wall]] \"{}\" has a shape", wall.name), "draw it by lines or planes");
  for (const Gauge& gauge : scene.gauges)
    refuse(gauge.phase == "fluid" && gauge.kind == "unexplained_impulse",
           fmt::format("[[gauge]] \"{}\" is of kind \"unexplained_impulse\"", gauge.name), "leave it out");
}

}  // namespace

template <int D>
std::vector<Lattice<D>> water_lattices(const Case& scene) {
  std::vector<Lattice<D>> result;
  unsigned seed = scene.fluid.seed;
  std::span<const Shape> later = scene.fluid.regions;
  for (const auto& region : scene.fluid.regions) {
    later = later.subspan(1);
    result.push_back(
        lay<D>(region, scene.fluid.particle_spacing, scene.fluid.offset, scene.fluid.jitter, seed++, later));
  }
  return result;
}

template <int D>
Setup<D>::Setup(const Case& scene, std::span<const Lattice<D>> lattices, const Domain& here)
    : domain(here),
      spacing(scene.fluid.particle_spacing),
      soil_spacing(scene.solid.particle_spacing > 0.0 ? scene.solid.particle_spacing : scene.fluid.particle_spacing),
      density(scene.water.density),
      kinematic_viscosity(scene.water.kinematic_viscosity),
      cavitation_pressure(scene.water.cavitation_pressure),
      gravity(scene.general.gravity.norm()),
      central_force(scene.general.central_force),
      acceleration(scene.general.gravity.head<D>()),
      periodic(scene.general.periodic),
      periodic_lower(scene.general.domain_min),
      periodic_length(scene.general.domain_max - scene.general.domain_min),
      scheme(scene.fluid.scheme),
      sweeps(scene.fluid.sweeps),
      pressure_tolerance(scene.fluid.pressure_tolerance),
      coupled(scene.coupled()),
      responds(coupled && scene.fluid.skeleton_response && is_projection()),
      computes_beside(scene.coupling.scheme == CouplingCase::Scheme::parallel),
      soil_yields(scene.can_yield()),
      soil_erodes(scene.erodes()),
      drag(scene.fluid.drag),
      ground(scene),
      one_soil(ground.contrast() < porous::one_conductivity),
      joints(make_joints<D>(scene)),
      digest(scene.digest()),
      gauges(scene.gauges) {
  if (!(spacing > 0.0)) throw CaseError("fluid.particle_spacing must be positive");
  if (scene.fluid.regions.empty() && scene.water_faces.empty())
    throw CaseError("the fluid has nothing to do: no [[fluid.region]] and no [[water_face]]");
  if (ground.beds() && (D == 3 || coupled))
    throw CaseError("soil.anisotropy: water as particles is computed in 2D and in rigid soil only");
  if (scene.walls.size() > sill_boundary) throw CaseError(fmt::format("at most {} walls", sill_boundary));
  Vec<D> bounded = acceleration;
  for (const int axis : periodic) std::swap(periodic_gravity[axis], bounded[axis]);
  weight = density * bounded;
  if (weight.norm() > 0.0) gravity_or_standard = weight.norm() / density;
  std::tie(lower, upper) = reach_of<D>(scene);
  double top = -1e300;
  const Vec<D> up = weight.norm() > 0.0 ? Vec<D>(-weight.normalized()) : Vec<D>::Zero();
  for (const auto& lattice : lattices)
    for (const auto& x : lattice.position) top = std::max(top, up.dot(x) + 0.5 * spacing);
  top = domain.max(top);
  if (top > -1e300) origin = top * up;
  const bool sight = D == 2 && sight_matters(scene, Keeps::water);
  for (std::size_t w = 0; w < scene.walls.size(); ++w) {
    const auto& wall = scene.walls[w];
    if (wall.water == Wall::ForWater::none) continue;
    if (wall.water == Wall::ForWater::no_slip) no_slip |= 1u << w;
    if (wall.soil != Wall::ForSoil::none && wall.soil != Wall::ForSoil::roller) fixed_soil |= 1u << w;
    for (std::size_t i = 0; i + 1 < wall.face.points.size(); ++i)
      pressed_walls.push_back({wall.face.points[i].template head<D>(), wall.face.points[i + 1].template head<D>(),
                               sight && has_two_sides(scene, wall, Keeps::water)});
  }
  for (const auto& face : scene.water_faces) face_names.push_back(face.name);
  for (const auto& load : scene.loads)
    loads.push_back({load.start, load.factor, load.pressure ? std::abs(*load.pressure) : load.traction.norm()});
  if (!coupled && scene.fluid.drag_form != FluidCase::DragForm::pointwise) smoothed_drag.emplace(scene);
}

template <int D>
Setup<D>::Setup(const Case& scene, std::span<const Lattice<D>> lattices, std::shared_ptr<Tiling<D>> tiles)
    : Setup(scene, lattices, Domain(tiles->ranks(), 0, 0)) {
  expect_possible_on_ranks(scene);
  tiling = std::move(tiles);
}

namespace {

template <int D>
Vec<D> initial_velocity(const Case& scene, const Vec<D>& x) {
  const auto& fluid = scene.fluid;
  Vec<D> v = fluid.initial_velocity.head<D>();
  v[0] += fluid.initial_strain * x[0];
  v[1] -= fluid.initial_strain * x[1];
  if (fluid.initial_wave != 0.0)
    v += fluid.initial_wave * sloshing_mode(fluid.regions.front(), to_point3<D>(x), D).template head<D>();
  if (fluid.initial_vortices > 0.0) {
    const auto& box = scene.general;
    const Vec<2> k = 2.0 * std::numbers::pi / (box.domain_max - box.domain_min).head<2>().array();
    const double a = k[0] * (x[0] - box.domain_min[0]), b = k[1] * (x[1] - box.domain_min[1]);
    v[0] += fluid.initial_vortices * std::sin(a) * std::cos(b);
    v[1] -= fluid.initial_vortices * k[0] / k[1] * std::cos(a) * std::sin(b);
  }
  return v;
}

}  // namespace

template <int D>
State<D> first_state(const Case& scene, const Setup<D>& setup, const WaterBoundaries& boundaries,
                     std::span<const Lattice<D>> lattices) {
  State<D> state;
  auto& p = state.particles;
  for (const auto& lattice : lattices) {
    p.reserve(p.size() + lattice.position.size(), !scene.water_faces.empty());
    for (const auto& x : lattice.position) {
      const Stratum* soil = setup.ground.at(x);
      const double n = soil ? soil->fillable_porosity : 1.0;
      p.add(x, initial_velocity<D>(scene, x), n * setup.density * lattice.volume, n, lattice.volume, 0.0, {});
    }
  }
  state.inlets = make_inlets<D>(scene, boundaries);
  state.columns = make_columns<D>(scene, setup.ground);
  begin_bodies(setup, state);
  // Points that lie on a face of soil, to within rounding, belong to the soil.
  const ColumnFinder<D> finder(state.columns);
  for (std::size_t a = 0; a < p.size(); ++a)
    if (const int i = finder.nearest(p.position[a]); i >= 0) {
      const auto& c = state.columns[static_cast<std::size_t>(i)];
      if (c.in_soil && std::abs(c.inside(p.position[a])) < 1e-6 * c.spacing) p.mask[a] = 1.0;
    }
  for (const auto& boundary : boundaries) state.faces.push_back(boundary->initial());
  update_columns<D>(boundaries, state.faces, 0.0, setup.weight, setup.origin, state.columns);
  return state;
}

#define PORETWIN_INSTANTIATE(D)                                 \
  template std::vector<Lattice<D>> water_lattices(const Case&); \
  template struct Setup<D>;                                     \
  template State<D> first_state(const Case&, const Setup<D>&, const WaterBoundaries&, std::span<const Lattice<D>>);
PORETWIN_INSTANTIATE(2)
PORETWIN_INSTANTIATE(3)
#undef PORETWIN_INSTANTIATE

}  // namespace poretwin::fluid
