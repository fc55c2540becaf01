#include "solid_solver/exchange/field_pressure.hpp"

#include "common/geometry/shapes.hpp"

#include <cmath>

namespace poretwin::solid {
namespace {

/// Pressure beyond the soil's surface near a particle, as a linear function of position.
template <int D>
struct Beyond {
  double datum = 0.0;             ///< Pa, at the origin
  Vec<D> slope = Vec<D>::Zero();  ///< Pa/m
  [[nodiscard]] double at(const Vec<D>& x) const { return datum + slope.dot(x); }
};

/// Pressure behind the nearest face within `reach` [m] of particle i, which is at `now`; zero (air) if there is no such
/// face. The face is looked for around the particle's position as the case draws it.
template <int D>
Beyond<D> beyond(const Setup<D>& setup, const State<D>& state, std::size_t i, const Vec<D>& now, double reach,
                 double time) {
  Point3 drawn = Point3::Zero();
  drawn.head<D>() = state.particles.position[i] - state.particles.displacement[i];
  const WaterFace* nearest = nullptr;
  for (const WaterFace& face : setup.water.faces) {
    const double distance = distance_from(face.face, drawn, D);
    if (!(distance < reach)) continue;
    reach = distance;
    nearest = &face;
  }
  if (!nearest) return {};
  if (nearest->pressure) return {nearest->pressure->at(time), Vec<D>::Zero()};
  if (!nearest->head && !nearest->basin_area) return {};
  const double level = nearest->basin_area ? state.external.basin_level[i] : nearest->head->at(time);
  const Beyond<D> water{setup.water.density * setup.gravity.norm() * level,
                        Vec<D>(setup.water.density * setup.gravity)};
  return water.at(now) > 0.0 ? water : Beyond<D>{};
}

}  // namespace

template <int D>
VecArray<D> gradient_of_field(const Setup<D>& setup, const State<D>& state, std::span<const double> pressure,
                              double time) {
  const Particles<D>& p = state.particles;
  const std::size_t n = p.size();
  VecArray<D> gradient = pressure_gradient_difference<D>(state, pressure);
  const VecArray<D> surface = surface_vectors(state);
  const double reach = 2.0 * sph::support_radius * setup.smoothing_length;
  // The water is computed on the soil as the case draws it: the displacement before time zero is subtracted.
  const auto place = [&](std::size_t i) { return Vec<D>(p.position[i] - state.rest_displacement[i]); };
  const std::vector<char> at_surface = feel_surface<D>(setup.spacing, state, surface);
  std::vector<Beyond<D>> outside(n);
  for (std::size_t i = 0; i < n; ++i) {
    if (!at_surface[i]) continue;
    outside[i] = beyond<D>(setup, state, i, place(i), reach, time);
  }
  VecArray<D> adjoint(n);
  for (std::size_t i = 0; i < n; ++i) adjoint[i] = outside[i].slope;
  for_each_ordered_pair(state.near.pairs, [&](std::size_t i, std::size_t j, std::size_t m) {
    if (!at_surface[i]) return;
    const bool image = j >= n;
    const std::size_t source = image ? state.near.images[j - n].parent : j;
    const Node<D>&a = state.nodes[i], &b = state.nodes[j];
    // Behind a wall, the pressure continues with its gradient at the wall.
    double theirs = pressure[source];
    if (image && !state.near.images[j - n].periodic)
      theirs += gradient[source].dot(b.position - state.nodes[source].position);
    const Vec<D> there = b.position - p.position[source] + place(source);
    const double own = pressure[i] - outside[i].at(place(i)), other = theirs - outside[i].at(there);
    const Mat<D> weights = own * a.correction() + other * correction_at(state, j);
    adjoint[i] += weights * ((b.volume * state.kernel[m]) * (a.position - b.position));
  });
  for (std::size_t i = 0; i < n; ++i)
    if (at_surface[i]) gradient[i] = adjoint[i];
  return gradient;
}

template VecArray<2> gradient_of_field<2>(const Setup<2>&, const State<2>&, std::span<const double>, double);
template VecArray<3> gradient_of_field<3>(const Setup<3>&, const State<3>&, std::span<const double>, double);

}  // namespace poretwin::solid
