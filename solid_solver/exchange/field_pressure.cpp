#include "solid_solver/exchange/field_pressure.hpp"

#include "common/geometry/pieces.hpp"
#include "common/geometry/shapes.hpp"
#include "solid_solver/numerics/exchange.hpp"

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

/// Distance [m] of a point from a face on a plane (3D); infinite if the point does not lie in front of the face.
double distance_from_plane(const Face& face, const Point3& x) {
  if (face.normal.isZero()) return HUGE_VAL;
  const Point3 inwards = face.normal.normalized();
  const double distance = inwards.dot(x - face.point);
  if (distance < 0.0 || (face.within && !contains(*face.within, x - distance * inwards, 3))) return HUGE_VAL;
  return distance;
}

/// Pressure behind the nearest face within `reach` [m] of the particle; zero (air) if there is no such face. The face
/// is looked for around the particle's position as the case draws it (`drawn`), and its pressure is evaluated at its
/// present position (`now`).
template <int D>
Beyond<D> beyond(const Setup<D>& setup, const Vec<D>& drawn, const Vec<D>& now, double reach, double time) {
  Point3 x = Point3::Zero();
  x.head<D>() = drawn;
  const WaterFace* nearest = nullptr;
  for (const WaterFace& face : setup.water.faces) {
    const auto take = [&](double distance) {
      if (!(distance < reach)) return;
      reach = distance;
      nearest = &face;
    };
    for (const auto& piece : pieces_of(face.face)) take(distance_from(piece, x));
    if constexpr (D == 3) take(distance_from_plane(face.face, x));
  }
  if (!nearest) return {};
  if (nearest->pressure) return {nearest->pressure->at(time), Vec<D>::Zero()};
  if (!nearest->head) return {};
  const Beyond<D> water{setup.water.density * setup.gravity.norm() * nearest->head->at(time),
                        Vec<D>(setup.water.density * setup.gravity)};
  return water.at(now) > 0.0 ? water : Beyond<D>{};
}

/// Particles that the free surface affects: those with a surface vector of sufficient length, and all within a kernel's
/// reach of the first row. Otherwise the third row in 3D, with a surface vector of 0.0199 / spacing, would lose 2 % of
/// the load. surface [1/m]: surface_vectors().
template <int D>
std::vector<char> feel_surface(const Setup<D>& setup, const State<D>& state, const VecArray<D>& surface) {
  const std::size_t n = surface.size();
  const auto length = [&](std::size_t i) { return surface[i].norm() * setup.spacing; };
  std::vector<char> feels(n);
  for (std::size_t i = 0; i < n; ++i) feels[i] = length(i) >= exchange::surface;
  for_each_ordered_pair(state.near.pairs, [&](std::size_t i, std::size_t j, std::size_t) {
    if (length(j < n ? j : state.near.images[j - n].parent) >= exchange::first_row) feels[i] = 1;
  });
  return feels;
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
  const std::vector<char> at_surface = feel_surface(setup, state, surface);
  std::vector<Beyond<D>> outside(n);
  for (std::size_t i = 0; i < n; ++i) {
    if (!at_surface[i]) continue;
    outside[i] = beyond<D>(setup, p.position[i] - p.displacement[i], place(i), reach, time);
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
