#include "solid_solver/setup.hpp"

#include "common/case/gauge_kinds.hpp"
#include "common/core/error.hpp"
#include "common/geometry/loaded_part.hpp"
#include "common/geometry/pieces.hpp"
#include "common/geometry/thin_walls.hpp"
#include "common/media/seepage.hpp"
#include "solid_solver/discretisation/rough_walls.hpp"
#include "solid_solver/material/cone.hpp"
#include "solid_solver/numerics/points.hpp"
#include "solid_solver/numerics/steps.hpp"
#include "solid_solver/numerics/walls.hpp"

#include <Eigen/Geometry>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

namespace poretwin::solid {
namespace {

/// Number of parts into which this number of particles is divided, for any number of threads. With more and smaller
/// parts, more pairs would cross the border between parts and be stored twice.
std::size_t parts_of(std::size_t particles) {
  constexpr std::size_t worth_two = 3072, least = 4096, most = 16;
  return particles < worth_two ? 1 : std::clamp(particles / least, std::size_t{2}, most);
}

/// Sorts new particles in `box` into slices across its longest extent, so that parts have short borders.
template <int D>
void lay_in_slices(const Eigen::AlignedBox<double, D>& box, double spacing, Particles<D>& particles) {
  int longest = 0;
  box.sizes().maxCoeff(&longest);
  const auto slice = [&](Index i) { return std::floor((particles.position[i] - box.min())[longest] / spacing + 0.5); };
  std::vector<Index> order(particles.size());
  std::iota(order.begin(), order.end(), Index{0});
  std::ranges::stable_sort(order, {}, slice);
  ParticleArrays arrays;
  arrays.add(particles.position).add(particles.mass).add(particles.volume).add(particles.material).reorder(order);
}

/// Whether no surface of the soil carries stress: grains without cohesion and without loads, on rough walls (with rows
/// of fixed particles behind them), beside upright rollers only. The stiffness at such surfaces may be reduced.
template <int D>
bool surfaces_carry_nothing(const Case& scene, const Setup<D>& setup) {
  using Kind = typename Boundaries<D>::Kind;
  const auto& planes = setup.boundaries.planes;
  const auto& kinds = setup.boundaries.kinds;
  bool plain = !scene.coupled() && scene.loads.empty() && scene.plates.empty() && !setup.boundaries.surfaces;
  for (std::size_t k = 0; k < planes.size(); ++k)
    plain = plain && (kinds[k] == Kind::periodic ||
                      (kinds[k] == Kind::roller && std::abs(planes[k].normal.dot(upwards(setup))) < 1e-9));
  return plain && std::ranges::all_of(setup.loose_friction, [](float tangent) { return tangent > 0.0F; });
}

/// Weight of the densest soil over the whole height, plus all loads [Pa]: the pressure from which pressure-dependent
/// stiffnesses are evaluated.
template <int D>
double weight_of_all(const Case& scene, const Setup<D>& setup) {
  double loads = 0.0;
  for (const Load& load : scene.loads) loads += load.pressure ? std::abs(*load.pressure) : load.traction.norm();
  return *std::ranges::max_element(setup.density) * setup.gravity.norm() * setup.height + loads;
}

/// Courant number of the substeps of moving soil (docs/theory/steps.md). Measured limits of stability: 1.07 at the tips
/// of wedges that walls with image particles cut off, 1.24 at faces, 1.6 in disordered soil with soft edges (3D: 1.5).
template <int D>
double courant_number(const Case& scene, const Setup<D>& setup) {
  if (scene.coupled()) return steps::careful;
  return !setup.soft_edges ? steps::courant : D == 2 ? steps::courant_soft_2d : steps::courant_soft_3d;
}

/// sum V W at a point of a lattice, the point itself included: 1.018 in 2D, 1.017 in 3D.
template <int D>
double lattice_cover() {
  constexpr int reach = 2;  // spacings; the support of the kernel is 2.4
  constexpr int across = D == 3 ? reach : 0;
  double sum = 0.0;
  for (int i = -reach; i <= reach; ++i)
    for (int j = -reach; j <= reach; ++j)
      for (int k = -across; k <= across; ++k)
        sum += sph::WendlandC2<D>::value(std::sqrt(i * i + j * j + k * k), points::lengths_per_spacing);
  return sum;
}

/// Length [m] of the part of a line beside which soil lies; 0 for a plane.
double length_along_soil(const Case& scene, const Face& face, double spacing) {
  const auto beside_soil = [&](const Point3& x, const Point3& inward) {
    constexpr std::array depths{walls::beside_line, -walls::beside_line, walls::farthest_load, -walls::farthest_load};
    return std::ranges::any_of(depths, [&](double depth) { return soil_at(scene, x + depth * spacing * inward); });
  };
  double length = 0.0;
  for (const Piece& piece : pieces_of(face)) {
    const auto samples = static_cast<std::size_t>(std::ceil(piece.length() / (walls::line_step * spacing)));
    std::size_t found = 0;
    for (std::size_t k = 0; k < samples; ++k) {
      const double share = (static_cast<double>(k) + 0.5) / static_cast<double>(samples);
      if (beside_soil(piece.a + share * (piece.b - piece.a), piece.left())) ++found;
    }
    length += piece.length() * static_cast<double>(found) / static_cast<double>(samples);
  }
  return length;
}

/// Distance [m] of x from a piece of a line, and how far [m] x lies before its first end and behind its last one.
struct Beside {
  double distance = 0.0, before = 0.0, behind = 0.0;
};
template <int D>
Beside beside(const sph::ImagePlane<D>& piece, const Vec<D>& x) {
  const double across = piece.normal.dot(x - piece.point);
  if (!(piece.to > piece.from)) return {std::abs(across), 0.0, 0.0};
  const double along = piece.tangent.dot(x), before = piece.from - along, behind = along - piece.to;
  return {std::hypot(across, std::max({before, behind, 0.0})), before, behind};
}

/// Attaches a load's traction to the particles near its face, each on the nearest straight piece of the face. reach [m]
/// is two kernel supports: a surface changes the correction within one support, and the force of a unit stress within
/// two supports.
template <int D>
void attach_load(const Case& scene, std::size_t which, double reach, double margin, const VecArray<D>& positions,
                 Setup<D>& setup) {
  const Load& load = scene.loads[which];
  if (load.on_all_sides()) {
    LoadedPatch<D>& patch = setup.loads.emplace_back();
    patch.pressure = load.pressure.value_or(0.0);
    if (load.start) patch.start = *load.start;
    patch.factor = load.factor;
    patch.load = which;
    patch.particles.resize(positions.size());
    std::iota(patch.particles.begin(), patch.particles.end(), Index{0});
    return;
  }
  std::optional<LoadedPart> part;
  if (load.face.within) part = loaded_part(scene, load.face);
  const double length = part ? part->area() : length_along_soil(scene, load.face, setup.spacing);
  const auto is_under = [&](const Vec<D>& x) {
    if constexpr (D == 3) return !part || part->covers(x);
    return true;
  };
  const bool closed = load.face.points.size() > 2 && load.face.points.front() == load.face.points.back();
  const auto planes = planes_of<D>(load.face, 0, margin);
  std::vector<LoadedPatch<D>> patches(planes.size());
  for (std::size_t k = 0; k < planes.size(); ++k) {
    patches[k].traction = load.pressure ? Vec<D>(*load.pressure * planes[k].normal) : Vec<D>(load.traction.head<D>());
    patches[k].normal = planes[k].normal;
    patches[k].level = planes[k].normal.dot(planes[k].point);
    if (load.start) patches[k].start = *load.start;
    patches[k].factor = load.factor;
    patches[k].load = which;
    patches[k].length = length;
    const Vec<D> middle =
        planes[k].to > planes[k].from
            ? Vec<D>(planes[k].point +
                     0.5 * (planes[k].from + planes[k].to - 2.0 * planes[k].tangent.dot(planes[k].point)) *
                         planes[k].tangent)
            : planes[k].point;
    for (const WaterFace& face : scene.water_faces)
      for (const auto& other : planes_of<D>(face.face, 0, margin)) {
        const double along = other.tangent.dot(middle);
        const bool beside = other.to > other.from && (along < other.from || along > other.to);
        if (!beside && std::abs(other.normal.dot(middle - other.point)) <= 1e-6 * setup.spacing)
          patches[k].water_face = face;
      }
  }
  for (std::size_t i = 0; i < positions.size(); ++i) {
    double nearest = reach;
    std::size_t best = planes.size();
    for (std::size_t k = 0; k < planes.size(); ++k) {
      const Beside place = beside<D>(planes[k], positions[i]);
      if (place.distance >= nearest) continue;
      nearest = place.distance;
      const bool beyond_an_end =
          !closed && ((k == 0 && place.before > 0.0) || (k + 1 == planes.size() && place.behind > 0.0));
      best = beyond_an_end ? planes.size() : k;
    }
    if (best < planes.size() && is_under(positions[i])) patches[best].particles.push_back(static_cast<Index>(i));
  }
  bool any = false;
  for (auto& patch : patches) {
    if (patch.particles.empty()) continue;
    any = true;
    setup.loads.push_back(std::move(patch));
  }
  if (!any)
    throw CaseError(
        fmt::format("load \"{}\": no soil particle lies within {:.4g} m of its face; move the face to the soil's "
                    "surface",
                    load.name, reach));
}

/// Refuses what several ranks that share the soil cannot compute.
void expect_possible_on_ranks(const Case& scene) {
  const auto refuse = [](bool found, std::string_view what, std::string_view instead) {
    if (found)
      throw CaseError(
          fmt::format("several ranks cannot share this soil yet: {}; {}, or run the case on one rank", what, instead));
  };
  refuse(scene.coupled() || !scene.pore_pressures.empty(), "water acts on it", "leave out the water");
  refuse(!scene.plates.empty(), "[[plate]]: plates press on it", "leave out the plates");
  refuse(scene.solid.artificial_stress > 0.0, "solid.artificial_stress is above 0", "set it to 0");
  for (const Wall& wall : scene.walls) {
    if (wall.soil == Wall::ForSoil::none) continue;
    const std::string name = fmt::format("[[wall]] \"{}\" ", wall.name);
    refuse(wall.shape.has_value(), name + "has a shape", "draw it by lines or planes");
  }
  refuse(sight_matters(scene, Keeps::soil), "a [[wall]] is a line with soil on both sides",
         "let soil lie on one side of it");
}

}  // namespace

template <int D>
Setup<D> weaker(const Setup<D>& setup, double factor) {
  Setup<D> weak = setup;
  for (std::size_t s = 0; s < weak.soils.size(); ++s) {
    const MaterialName model = *weak.soils[s].model;
    weak.soils[s] = weakened(weak.soils[s], factor, material(model).keys);
    weak.models[s] = make_constitutive(model, weak.soils[s]);
  }
  return weak;
}

template <int D>
std::pair<Setup<D>, Particles<D>> set_up(const Case& scene, const Domain& domain) {
  Setup<D> setup;
  setup.domain = domain;
  Particles<D> particles;
  setup.spacing = scene.solid.particle_spacing;
  if (!(setup.spacing > 0.0))
    throw CaseError(fmt::format("solid.particle_spacing: expected a length above 0 m, found {}", setup.spacing));
  setup.smoothing_length = points::lengths_per_spacing * setup.spacing;
  setup.full_cover = lattice_cover<D>();
  // The skin ends just below the lattice neighbours at a distance of sqrt(8) spacings. So lists of flowing soil last as
  // long as possible without additional pairs in soil at rest.
  setup.skin = scene.solid.list_skin * setup.spacing;
  setup.can_yield = scene.can_yield();
  setup.regular_flow = scene.solid.regular_flow;
  setup.quiet = scene.solid.quiet.value_or(Quiet{});
  if (!scene.general.periodic.empty()) setup.quiet.regions = 0.0;
  setup.stabilisers.artificial = scene.solid.artificial_viscosity;
  setup.stabilisers.quadratic = scene.solid.quadratic_viscosity;
  setup.stabilisers.artificial_stress = scene.solid.artificial_stress;
  setup.stabilisers.hourglass_viscosity = scene.solid.hourglass_viscosity;
  setup.stabilisers.hourglass_stiffness = scene.solid.hourglass_stiffness;
  setup.gravity = scene.general.gravity.head<D>();
  setup.water = {.density = scene.water.density,
                 .kinematic_viscosity = scene.water.kinematic_viscosity,
                 .weight = porous::specific_weight(scene),
                 .drags = scene.fluid.drag,
                 .gradient = scene.solid.pressure_gradient,
                 .prescribed = scene.pore_pressures,
                 .is_field = scene.is_field(),
                 .faces = scene.is_field() ? scene.water_faces : std::vector<WaterFace>(),
                 .dimension = D,
                 .gravity = scene.general.gravity};
  setup.coupling = {.coupled = scene.coupled(),
                    .predicts = scene.predicts(),
                    .repeats = scene.predicts() && scene.coupling.scheme == CouplingCase::Scheme::iterated,
                    .keep_points = scene.coupling.keep_points,
                    .worth_repeating = scene.coupling.tolerance.value_or(steps::worth_repeating),
                    .settled_below = scene.coupling.settled_below()};
  setup.initial_rest = {.sought = scene.solid.initial_rest,
                        .bears_seepage = scene.solid.initial_seepage && scene.fluid.drag};
  setup.sleeps = scene.solid.quiet && !(scene.coupled() && !setup.can_yield);
  setup.gauges = scene.gauges;
  setup.gauge_interval = scene.output.gauge_interval;
  for (Soil soil : scene.soils) {
    const MaterialName model = scene.model_of(soil);
    soil.model = model;
    setup.soils.push_back(weakened(std::move(soil), scene.solid.strength_reduction, material(model).keys));
  }
  setup.counts_impulses = asks_for(scene.gauges, "solid", "unexplained_impulse");
  setup.parallel = scene.coupling.scheme == CouplingCase::Scheme::parallel;
  setup.inertia_share = setup.parallel && scene.fluid.skeleton_response ? 0.5 : 0.0;
  constexpr std::size_t most_soils = std::numeric_limits<std::uint8_t>::max();
  if (scene.soils.size() > most_soils)
    throw CaseError(fmt::format("{} soils: the solid takes at most {}", scene.soils.size(), most_soils));
  std::vector<Shape> shapes;
  for (const Soil& soil : scene.soils) shapes.push_back(soil.shape);
  for (std::size_t s = 0; s < scene.soils.size(); ++s) {
    const Soil& soil = scene.soils[s];
    const Material kind = material(scene.model_of(soil));
    setup.models.push_back(make_constitutive(scene.model_of(soil), setup.soils[s]));
    const double residual = soil.porosity * soil.initial_saturation, solid = 1.0 - soil.porosity;
    const double density = solid * soil.grain_density + residual * scene.water.density;
    setup.grain_density.push_back(density / (solid + residual));
    setup.grain_share.push_back(solid / (solid + residual));
    std::optional<double> grains;  // friction coefficient, where they shear at constant volume and have no cohesion
    if (kind.has_cone() && soil.dilation_angle <= 0.0 && soil.cohesion <= 0.0)
      grains = std::tan(soil.friction_angle * std::numbers::pi / 180.0);
    else if (kind.grains)
      grains = kind.grains(soil);
    setup.constant_volume.push_back((kind.has_cone() && soil.dilation_angle <= 0.0) || grains ? 1 : 0);
    setup.contact_volume.push_back(soil.contact_porosity ? solid / (1.0 - *soil.contact_porosity)
                                                         : std::numeric_limits<double>::infinity());
    setup.loose_friction.push_back(grains && scene.solid.regular_flow ? static_cast<float>(*grains) : 0.0F);
    setup.erosion.push_back(soil.erosion ? std::optional(porous::Erosion(*soil.erosion, scene.water.density))
                                         : std::nullopt);
    setup.erodes = setup.erodes || soil.erosion.has_value();
    setup.softened_by_water.push_back(soil.saturated_cohesion ? 1 : 0);
    const auto lattice = lay<D>(soil.shape, setup.spacing, scene.solid.offset, scene.solid.jitter,
                                scene.solid.seed + static_cast<unsigned>(s), std::span(shapes).subspan(s + 1));
    setup.density.push_back(density);
    const std::size_t all = particles.size() + lattice.position.size();
    particles.position.reserve(all);
    for (auto* array : {&particles.mass, &particles.volume}) array->reserve(all);
    particles.material.reserve(all);
    for (const auto& x : lattice.position) {
      particles.position.push_back(x);
      particles.mass.push_back(density * lattice.volume);
      particles.volume.push_back(lattice.volume);
      particles.material.push_back(static_cast<std::uint8_t>(s));
    }
  }
  if (particles.size() == 0)
    throw CaseError("no soil particle lies in any [[soil]] shape: check shapes and solid.particle_spacing");
  Eigen::AlignedBox<double, D> box;  // box around the soil that is free to move
  for (const auto& x : particles.position) box.extend(x);
  lay_in_slices(box, setup.spacing, particles);
  hold_soil_behind_rough_walls<D>(scene, setup, particles);
  const std::size_t n = particles.size();
  setup.parts = parts_of(n);
  particles.displacement.assign(n, Vec<D>::Zero());
  particles.velocity.assign(n, Vec<D>::Zero());
  std::fill_n(particles.velocity.begin(), particles.free(), Vec<D>(scene.solid.initial_velocity.head<D>()));
  if (scene.solid.initial_wave != 0.0)
    for (std::size_t i = 0; i < particles.free(); ++i) {
      Point3 x = Point3::Zero();
      x.head<D>() = particles.position[i];
      particles.velocity[i] +=
          scene.solid.initial_wave * sloshing_mode(scene.soils.front().shape, x, D).template head<D>();
    }
  particles.stress.assign(n, Tensor::Zero());
  particles.plastic_strain.assign(n, 0.0);
  std::size_t remembered = 0;
  for (const auto& model : setup.models) remembered = std::max(remembered, model->state_size());
  particles.material_state.assign(n * remembered, 0.0);
  for (std::size_t i = 0; i < n; ++i)
    setup.models[particles.material[i]]->initial(particles.stress[i], particles.state_of(i));
  particles.rubbing.assign(n, 0.0F);
  const double g = setup.gravity.norm();
  for (int d = 0; d < D; ++d) {
    box.min()[d] = domain.min(box.min()[d]);
    box.max()[d] = domain.max(box.max()[d]);
  }
  setup.height = setup.spacing + (g > 0.0 ? box.sizes().dot(setup.gravity.cwiseAbs()) / g : box.sizes().maxCoeff());
  const double weight = weight_of_all(scene, setup);
  double fastest = 0.0;
  setup.stabilisers.modulus = std::numeric_limits<double>::infinity();
  for (std::size_t s = 0; s < scene.soils.size(); ++s) {
    const ConstitutiveModel& model = *setup.models[s];
    setup.largest_pressure.push_back(scene.soils[s].largest_pressure.value_or(2.0 * weight));
    setup.typical.push_back(model.moduli_under(0.5 * weight));
    const double stiffest = model.stiffest(setup.largest_pressure[s]).constrained();
    setup.stiffens.push_back(model.stiffest(2.0 * setup.largest_pressure[s]).constrained() > stiffest ? 1 : 0);
    fastest = std::max(fastest, std::sqrt(stiffest / setup.density[s]));
    // The softest soil counts: hourglass control must not stiffen one soil with the modulus of another.
    setup.stabilisers.modulus = std::min(setup.stabilisers.modulus, setup.typical[s].constrained());
  }
  setup.stabilisers.sound_speed = fastest;
  setup.boundaries = make_boundaries<D>(scene, setup.range());
  if (setup.boundaries.surfaces) setup.quiet.regions = 0.0;  // forces on images' parents need all rows
  setup.soft_edges = surfaces_carry_nothing(scene, setup);
  // These longer substeps resolve some waves poorly, which disturb the flow and reduce its friction: they are damped.
  if (setup.soft_edges) setup.stabilisers.bulk = points::bulk_viscosity * fastest * setup.spacing;
  const double courant = scene.solid.courant.value_or(courant_number(scene, setup));
  setup.longest_substep = setup.stabilisers.step = courant * setup.spacing / fastest;
  setup.rest_substep = scene.solid.courant.value_or(steps::careful) * setup.spacing / fastest;
  if (setup.boundaries.any_frictional()) {
    particles.slip = particles.velocity;
    particles.slipped.assign(n, Vec<D>::Zero());
    particles.wall_slope.assign(n, Vec<D>::Zero());
  }
  setup.plates = make_plates<D>(scene, setup.spacing, particles.position, particles.mass);
  particles.plates.resize(setup.plates.size());
  for (std::size_t k = 0; k < scene.loads.size(); ++k)
    attach_load<D>(scene, k, 2.0 * sph::support_radius * setup.smoothing_length, 0.01 * setup.spacing,
                   particles.position, setup);
  return {std::move(setup), std::move(particles)};
}

template <int D>
std::pair<Setup<D>, Particles<D>> set_up(const Case& scene, std::shared_ptr<Tiling<D>> tiling) {
  expect_possible_on_ranks(scene);
  auto made = set_up<D>(scene, Domain(tiling->ranks(), 0, 0));
  made.first.tiling = std::move(tiling);
  return made;
}

template <int D>
void expect_bearable_pressure(const Setup<D>& setup, const Particles<D>& particles) {
  if (std::ranges::none_of(setup.stiffens, [](char stiffens) { return stiffens != 0; })) return;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const std::size_t soil = particles.material[i];
    const double pressure = -trace(particles.stress[i]) / 3.0, most = setup.largest_pressure[soil];
    if (setup.stiffens[soil] && pressure > most)
      throw DivergedError(fmt::format(
          "soil[{}] at particle {}: a mean effective pressure of {:.4g} Pa, and the substep was chosen for at "
          "most {:.4g}: set soil.largest_pressure to what is expected",
          soil, i, pressure, most));
  }
}

template void expect_bearable_pressure<2>(const Setup<2>&, const Particles<2>&);
template void expect_bearable_pressure<3>(const Setup<3>&, const Particles<3>&);
template struct Setup<2>;
template struct Setup<3>;
template Setup<2> weaker<2>(const Setup<2>&, double);
template Setup<3> weaker<3>(const Setup<3>&, double);
template std::pair<Setup<2>, Particles<2>> set_up<2>(const Case&, const Domain&);
template std::pair<Setup<3>, Particles<3>> set_up<3>(const Case&, const Domain&);
template std::pair<Setup<2>, Particles<2>> set_up<2>(const Case&, std::shared_ptr<Tiling<2>>);
template std::pair<Setup<3>, Particles<3>> set_up<3>(const Case&, std::shared_ptr<Tiling<3>>);

}  // namespace poretwin::solid
