// Differential operators on a stencil: corrected gradient and divergence, pairwise Laplacian, interpolation.
#pragma once

#include "fluid_solver/csr.hpp"
#include "fluid_solver/stencil.hpp"

#include <optional>

namespace poretwin::fluid {

/// What a vector field is: behind a wall that moves, a velocity of the water is not the mirrored one alone.
enum class Carried : bool { no, yes };

/// Values at all points from values at real particles: images take their parent's, through the linear map for vectors.
/// Buffers and their images get zero: nothing here reads them.
template <int D>
VecArray<D> extended(const Stencil<D>& s, std::span<const Vec<D>> f, Carried carried = Carried::no) {
  VecArray<D> all(s.size(), Vec<D>::Zero());
  std::copy(f.begin(), f.end(), all.begin());
  for (std::size_t j = s.n_base; j < s.size(); ++j)
    if (s.parent[j] < s.n_real) {
      all[j] = s.map[j - s.n_base] * f[s.parent[j]];
      if (carried == Carried::yes) all[j] += s.carried[j - s.n_base];
    }
  return all;
}

inline double harmonic(double a, double b) {
  if (a == b) return a;
  return a + b > 0.0 ? 2.0 * a * b / (a + b) : 0.0;
}

/// Slope of a pressure along a face column's normal [Pa/m]; nothing where the ground inside is dry.
template <int D>
std::optional<double> face_slope(const Stencil<D>& s, Index column, std::span<const double> p, double face_pressure,
                                 bool increment = false) {
  if (column + 1 >= s.fit_offset.size() || s.fit_offset[column] == s.fit_offset[column + 1]) return std::nullopt;
  double slope = increment ? 0.0 : s.fit_constant[column];
  for (Index k = s.fit_offset[column]; k < s.fit_offset[column + 1]; ++k)
    slope += s.fit_weight[k] * (p[s.fit_index[k]] - face_pressure);
  return slope;
}

/// Corrected gradient of a piezometric pressure; face_pressure(column) is the pressure at a face (0 for increments).
/// mobility(a, parent of b) multiplies each pair; blind_gradient is taken in directions without neighbours;
/// surface_pressure(a) is that of the free surface next to particle a (0 for increments); increment: p is a change of
/// pressure.
template <int D, class Face, class Mobility, class SurfacePressure>
VecArray<D> pressure_gradient(const Stencil<D>& s, std::span<const double> p, Face&& face_pressure, Mobility&& mobility,
                              const Vec<D>& blind_gradient, SurfacePressure&& surface_pressure,
                              bool increment = false) {
  VecArray<D> result(s.n_real);
  // Pressures of the buffers. Reflecting particle by particle, as the Laplacian does, would magnify the error of a
  // particle that lies on the face itself.
  ScalarArray buffer(s.n_base - s.n_real);
  std::vector<bool> fitted(buffer.size());
  for (std::size_t i = 0; i < buffer.size(); ++i) {
    const double at_face = face_pressure(s.column[i]);
    const auto slope = face_slope(s, s.column[i], p, at_face, increment);
    fitted[i] = slope.has_value();
    buffer[i] = at_face - slope.value_or(0.0) * s.outside[i];
  }
  for (std::size_t a = 0; a < s.n_real; ++a) {
    Vec<D> sum = Vec<D>::Zero();
    for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k) {
      const Index j = s.other[k], q = s.parent[j];
      const double difference = q < s.n_real           ? p[q] - p[a]
                                : fitted[q - s.n_real] ? buffer[q - s.n_real] - p[a]
                                                       : s.reflection[k] * (buffer[q - s.n_real] - p[a]);
      sum += s.volume[j] * mobility(a, q) * difference * s.gradient[k];
    }
    if (s.ghost_distance[a] > 0.0) sum += 2.0 * mobility(a, a) * (p[a] - surface_pressure(a)) * s.normal[a];
    result[a] = s.correction[a] * sum + mobility(a, a) * (s.blind[a] * blind_gradient);
  }
  return result;
}

/// Corrected gradient of the water's velocity, G_ij = d v_i / d x_j, buffers left out.
template <int D>
MatArray<D> velocity_gradient(const Stencil<D>& s, std::span<const Vec<D>> f) {
  const VecArray<D> all = extended<D>(s, f, Carried::yes);
  MatArray<D> result(s.n_real);
  for (std::size_t a = 0; a < s.n_real; ++a) {
    Mat<D> sum = Mat<D>::Zero();
    for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k) {
      const Index j = s.other[k];
      if (!s.is_buffer(j)) sum += s.volume[j] * (all[j] - all[a]) * s.gradient[k].transpose();
    }
    result[a] = sum * s.correction_open[a];
  }
  return result;
}

/// Corrected divergence of a velocity-like field, buffers left out (one-sided at faces).
template <int D>
ScalarArray divergence(const Stencil<D>& s, std::span<const Vec<D>> f, Carried carried = Carried::no) {
  const VecArray<D> all = extended<D>(s, f, carried);
  ScalarArray result(s.n_real);
  for (std::size_t a = 0; a < s.n_real; ++a) {
    Mat<D> sum = Mat<D>::Zero();
    for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k) {
      const Index j = s.other[k];
      if (s.is_buffer(j)) continue;
      sum += s.volume[j] * (all[j] - all[a]) * s.gradient[k].transpose();
    }
    result[a] = sum.cwiseProduct(s.correction_open[a].transpose()).sum();
  }
  return result;
}

/// V_a sum_b 2 V_b mobility_ab G_ab (p_a - p_b): minus the Laplacian, weighted with the volume so that it is symmetric.
/// With buffers, their pairs go to the diagonal, (1 + r) (p_a - p_face); without, they are left out (natural).
template <int D, class Mobility>
PairMatrix laplacian(const Stencil<D>& s, Mobility&& mobility, bool buffers) {
  PairMatrix m;
  m.offset.reserve(s.n_real + 1);
  m.column.reserve(s.other.size());
  m.weight.reserve(s.other.size());
  m.diagonal.assign(s.n_real, 0.0);
  for (std::size_t a = 0; a < s.n_real; ++a) {
    for (Index k = s.offset[a]; k < s.offset[a + 1]; ++k) {
      const Index j = s.other[k], q = s.parent[j];
      if (q == a) continue;
      const double w = s.volume[a] * 2.0 * s.volume[j] * mobility(a, q) * s.strength[k] * s.amplified(a, q);
      if (w == 0.0) continue;
      if (q < s.n_real) {
        m.diagonal[a] += w;
        m.column.push_back(q);
        m.weight.push_back(w);
      } else if (buffers) {
        m.diagonal[a] += w * s.reflection[k];
      }
    }
    m.offset.push_back(static_cast<Index>(m.column.size()));
  }
  return m;
}

}  // namespace poretwin::fluid
