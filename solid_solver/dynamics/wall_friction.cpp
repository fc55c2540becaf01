#include "solid_solver/dynamics/wall_friction.hpp"

#include "solid_solver/discretisation/ranks.hpp"
#include "solid_solver/numerics/points.hpp"
#include "solid_solver/numerics/walls.hpp"

namespace poretwin::solid {
namespace {

/// Whether the wall itself is opposite x [m], and not only its extension for images.
template <int D>
bool stands_before(const sph::ImagePlane<D>& wall, const Vec<D>& x) {
  if (wall.screen < 0) return wall.faces(x);
  const double along = wall.tangent.dot(x);
  return along >= wall.seen_from && along <= wall.seen_to;
}

/// Calls visit(image, node, weight) for the images that act on particle i; weight = V W'/r (x_i - x_j) [1/m].
template <int D, class Visit>
void for_each_image(const State<D>& state, std::size_t i, Visit&& visit) {
  const std::size_t n = state.particles.with_copies();
  const Pairs& pairs = state.near.pairs;
  for (std::size_t m = pairs.alone[i]; m < pairs.offset[i + 1]; ++m) {
    const std::size_t j = pairs.index[m];
    if (j < n) continue;
    const Vec<D> r = state.nodes[i].position - state.nodes[j].position;
    visit(state.near.images[j - n], state.nodes[j], Vec<D>((state.nodes[j].volume * state.kernel[m]) * r));
  }
}

/// How the soil's velocity gradient across the wall changes with the wall slip, d(dv_t/dn)/ds [1/m], at particle i;
/// negative.
template <int D>
double effect_of_slip(const State<D>& state, std::size_t i, const Vec<D>& normal) {
  const Vec<D> row = state.nodes[i].correction() * normal;
  const Mat<D> along = Mat<D>::Identity() - normal * normal.transpose();
  double effect = 0.0;
  for_each_image(state, i, [&](const ImageRule<D>& image, const Node<D>&, const Vec<D>& weight) {
    if (image.slips) effect += (along * image.slip).trace() / (D - 1) * weight.dot(row);
  });
  return effect;
}

/// Force density [N/m3] of stress that changes along a wall, at particle i: the divergence of the stress without the
/// derivative across the wall, by least squares over the parents of the images behind the wall. Zero where these
/// parents do not spread along the wall.
template <int D>
Vec<D> divergence_along(const State<D>& state, std::size_t i, const Vec<D>& normal) {
  using Slopes = Eigen::Matrix<double, D, D * D>;
  Mat<D> moment = Mat<D>::Zero();
  Slopes slopes = Slopes::Zero();
  double spread = 0.0;
  for_each_image(state, i, [&](const ImageRule<D>& image, const Node<D>& node, const Vec<D>& weight) {
    if (!image.slips) return;
    const Vec<D> r = node.position - state.nodes[i].position, along = r - normal.dot(r) * normal;
    const double w = weight.norm() / r.norm();
    const Mat<D> change = matrix_of<D>(Tensor(state.particles.stress[image.parent] - state.particles.stress[i]));
    moment += w * along * along.transpose();
    slopes += w * along * Eigen::Map<const Eigen::Matrix<double, 1, D * D>>(change.data());
    spread += w * r.squaredNorm();
  });
  if (moment.trace() < walls::least_spread * spread) return Vec<D>::Zero();
  const Slopes solved = (moment + spread * normal * normal.transpose()).inverse() * slopes;
  Vec<D> sum = Vec<D>::Zero();
  for (int l = 0; l < D; ++l) sum += solved.row(l).template segment<D>(l * D).transpose();
  return sum;
}

/// Force density r0 - r s on soil that moves along a wall with the slip velocity s, in addition to its body force:
/// inertia, damping, and the force with which it tracks the fluid's prediction.
template <int D>
struct AlongWall {
  double resistance = 0.0;        ///< r, N s/m4
  Vec<D> force = Vec<D>::Zero();  ///< r0, N/m3
};

/// slip: s at the start of the step, whose length is dt [s].
template <int D>
AlongWall<D> along_wall(const State<D>& state, std::size_t i, const Drive<D>& drive, double dt, const Vec<D>& slip) {
  const Particles<D>& p = state.particles;
  const double density = p.mass[i] / p.volume[i];
  AlongWall<D> out{density * (1.0 / dt + drive.damping_at(state, i)), (density / dt) * slip};
  if (drive.tracking.empty()) return out;
  const double follows = drive.tracking[i] / p.volume[i];
  out.resistance += follows;
  out.force += follows * drive.target[i];
  return out;
}

/// Calls visit(i, friction coefficient, normal, distance [m]) for particles within a spacing of a frictional wall.
template <int D, class Visit>
void for_each_touch(const Setup<D>& setup, const State<D>& state, Visit&& visit) {
  const Boundaries<D>& walls = setup.boundaries;
  if (walls.surfaces) {
    // A particle touches a wall where an image by that wall alone mirrors it.
    for (const ImageRule<D>& image : state.near.images) {
      const Crossing<D>& wall = image.crossings[0];
      if (image.n_crossings != 1 || std::isinf(wall.friction) || image.parent >= state.particles.free() ||
          state.regions.sleeps(image.parent))
        continue;
      const double distance = wall.normal.dot(state.nodes[image.parent].position) - wall.level;
      if (distance >= 0.0 && distance < setup.spacing)
        visit(std::size_t{image.parent}, wall.friction, wall.normal, distance);
    }
    return;
  }
  for (std::size_t k = 0; k < walls.planes.size(); ++k) {
    if (walls.kinds[k] != Boundaries<D>::Kind::frictional) continue;
    const Vec<D>& normal = walls.planes[k].normal;
    for (std::size_t i = 0; i < state.particles.free(); ++i) {
      if (state.regions.sleeps(i)) continue;
      const Vec<D>& x = state.nodes[i].position;  // the position that the kernels use
      const double distance = normal.dot(x - walls.planes[k].point);
      if (distance >= 0.0 && distance < setup.spacing && stands_before(walls.planes[k], x))
        visit(i, walls.friction[k], normal, distance);
    }
  }
}

}  // namespace

template <int D>
void rub_on_walls(const Setup<D>& setup, double dt, State<D>& state) {
  Particles<D>& p = state.particles;
  if (p.slip.empty()) return;
  const double h = setup.smoothing_length;
  for_each_touch(setup, state, [&](std::size_t i, double friction, const Vec<D>& normal, double) {
    if (p.slip[i].isZero(0.0)) return;
    const double alpha = p.rubbing[i] > 0.0F ? setup.stabilisers.collision : setup.stabilisers.artificial;
    const double beta = p.rubbing[i] > 0.0F ? 0.0 : setup.stabilisers.quadratic;
    double lift = 0.0;  // m/s2
    for_each_image(state, i, [&](const ImageRule<D>& image, const Node<D>& node, const Vec<D>& weight) {
      if (!image.slips) return;
      const Vec<D> r = state.nodes[i].position - node.position;
      const double approach = -r.dot(state.nodes[i].velocity - node.velocity);
      if (approach <= 0.0) return;
      const double closing = approach / (r.squaredNorm() + points::viscosity_softening * h * h);
      lift -= (alpha * setup.stabilisers.sound_speed + beta * h * closing) * h * closing * weight.dot(normal);
    });
    const Vec<D> along = p.velocity[i] - normal.dot(p.velocity[i]) * normal;
    const double speed = along.norm(), most = friction * lift * dt;
    if (lift > 0.0 && speed > 0.0) p.velocity[i] -= std::min(1.0, most / speed) * along;
  });
}

template <int D>
void slide_on_walls(const Setup<D>& setup, double dt, const Drive<D>* drive, State<D>& state) {
  Particles<D>& p = state.particles;
  if (!setup.boundaries.any_frictional()) return;
  auto& touches = state.scratch.touches;
  touches.assign(p.with_copies(), 0.0);
  std::fill(p.wall_slope.begin(), p.wall_slope.end(), Vec<D>::Zero());
  fill_copies(setup.domain, std::span(p.stress));
  for_each_touch(setup, state, [&](std::size_t i, double, const Vec<D>& normal, double) {
    p.wall_slope[i] += divergence_along(state, i, normal);
  });
  for_each_touch(setup, state, [&](std::size_t i, double friction, const Vec<D>& normal, double distance) {
    const double effect = effect_of_slip(state, i, normal);
    if (effect > -walls::touches_from / setup.spacing) return;
    touches[i] = 1.0;
    const double stiffness = -effect * moduli(setup, p, i).shear * dt;  // Pa s/m, shear of the particle, per slip
    const Vec<D> body = state.body[i] + p.wall_slope[i];
    const double reach = distance * slope_carried<D>(p, i, normal, distance, body);
    const WallShear<D> found = wall_shear<D>(p.stress[i], normal, reach, body);
    const auto tangential = [&](const Vec<D>& v) { return Vec<D>(v - normal.dot(v) * normal); };
    const Vec<D> before = tangential(p.slip[i]);
    const AlongWall<D> moves = drive ? along_wall(state, i, *drive, dt, before) : AlongWall<D>{};
    const double resistance = stiffness + reach * moves.resistance;  // Pa s/m, change of traction per slip velocity
    const Vec<D> force = tangential(moves.force);
    const WallShear<D> stuck{found.traction + stiffness * before + reach * force, found.pressure};
    const double excess = stuck.excess(friction);
    const bool pressed = found.pressure > 0.0;
    const Vec<D> slip = pressed ? Vec<D>((excess / resistance) * stuck.traction) : tangential(p.velocity[i]);
    const Vec<D> change = pressed ? Vec<D>(stiffness * (before - slip)) : Vec<D>(-found.traction);
    if (pressed) p.wall_slope[i] += force - moves.resistance * slip;
    p.slip[i] += slip - before;
    const Mat<D> unsheared = effect * (slip - before) * normal.transpose();
    state.nodes[i].gradient += unsheared;
    state.nodes[i].deformation += dt * unsheared;
    if (excess > 0.0)  // the wall is where the soil's own shear puts it
      p.slipped[i] += tangential(p.displacement[i] - distance * state.nodes[i].deformation * normal - p.slipped[i]);
    set_matrix<D>(matrix_of<D>(p.stress[i]) + change * normal.transpose() + normal * change.transpose(), p.stress[i]);
    const double plastic = setup.models[p.material[i]]->advance(
        p.stress[i], Tensor::Zero(), at_once(setup, p, i, state.external.saturation[i]), p.state_of(i));
    if (plastic > 0.0) {
      p.plastic_strain[i] += plastic;
      state.yielded[i] = 1;
    }
  });
  fill_copies(setup.domain, std::span(touches));
  for (auto* slips : {&p.slip, &p.slipped}) fill_copies(setup.domain, std::span(*slips));
  for (std::size_t i = 0; i < p.free(); ++i) {
    if (touches[i] > 0.0 || state.regions.sleeps(i)) continue;
    Vec<D> slip = Vec<D>::Zero(), slipped = slip;
    double weights = 0.0;
    for_each_image(state, i, [&](const ImageRule<D>& image, const Node<D>&, const Vec<D>& weight) {
      if (!image.slips || touches[image.parent] == 0.0) return;
      slip += weight.norm() * p.slip[image.parent];
      slipped += weight.norm() * p.slipped[image.parent];
      weights += weight.norm();
    });
    p.slip[i] = weights > 0.0 ? Vec<D>(slip / weights) : p.velocity[i];
    p.slipped[i] = weights > 0.0 ? Vec<D>(slipped / weights) : p.displacement[i];
  }
}

template void rub_on_walls<2>(const Setup<2>&, double, State<2>&);
template void rub_on_walls<3>(const Setup<3>&, double, State<3>&);
template void slide_on_walls<2>(const Setup<2>&, double, const Drive<2>*, State<2>&);
template void slide_on_walls<3>(const Setup<3>&, double, const Drive<3>*, State<3>&);

}  // namespace poretwin::solid
