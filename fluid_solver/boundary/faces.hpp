// Faces of prescribed head or pressure. Water enters and leaves through columns, one per particle spacing along the
// face. Each column has a stack of buffer particles outside the face, which moves with the flow ("ghost reservoir": no
// particles represent the reservoir itself).
#pragma once

#include "common/particles/neighbours.hpp"
#include "fluid_solver/boundary/water_boundary.hpp"
#include "fluid_solver/discretisation/stencil.hpp"
#include "fluid_solver/exchange/soil_view.hpp"
#include "fluid_solver/numerics/faces.hpp"

#include <cmath>

namespace poretwin::fluid {

/// Properties that a water particle keeps from the first body of water to which it belonged.
struct Provenance {
  double wave_speed = 0.0;      ///< m/s, see Particles
  bool goes_with_soil = false;  ///< see Particles
};

template <int D>
struct FaceColumn {
  Vec<D> foot = Vec<D>::Zero();    ///< m, point on the face
  Vec<D> normal = Vec<D>::Zero();  ///< unit, into the domain
  int face = 0;                    ///< index in Case::water_faces
  double spacing = 0.0;            ///< m, along the normal
  double width = 0.0;              ///< m, half of its width along the face
  double volume = 0.0;             ///< m^D, bulk volume of each buffer particle
  double mass = 0.0;               ///< kg, mass of a particle born here
  double void_fraction = 1.0;      ///< volume fraction that water fills in the ground behind the face
  double offset = 0.0;             ///< m, position of the stack: buffers are at offset - j spacing, j = 1 .. 4
  double speed = 0.0;              ///< m/s, of the stack along the normal
  double pressure = 0.0;           ///< Pa, piezometric, at the foot
  double slope = 0.0;              ///< Pa/m, of the piezometric pressure along the normal
  Provenance provenance;           ///< of particles born here: the provenance of the nearest water at the start
  bool in_soil = false;            ///< the ground behind the face is soil
  bool drag_dominated = false;     ///< in this soil drag, not inertia, dominates the motion of water
  bool wet = false;                ///< the pressure at the foot is not negative: water passes
  bool held = false;               ///< a wall fixes the soil at the face: a filter
  bool loaded = false;             ///< the face carries a load
  double stored = 0.0;             ///< m^D, water of the outermost spacing that is in the domain but in no particle
  double passed = 0.0;             ///< m^D, volume that has entered here, minus the volume that has left
  double before = 0.0;             ///< m, length of the wall that continues the face straight beyond its first end here
  double after = 0.0;              ///< m, length of the wall that continues the face straight beyond its last end here
  int handed_to = -1;  ///< column at which the particles of the water that passes here are born and removed; -1: this
                       ///< one. At the toe of a slope of soil at rest a row does not fit between face and base
  [[nodiscard]] double inside(const Vec<D>& x) const { return normal.dot(x - foot); }
  /// Volume of the part of the first buffer that lies inside the face [m^D]; negative: volume of the part of the last
  /// particle that lies outside.
  [[nodiscard]] double share(double density) const {
    return wet ? mass / density * std::clamp(offset / spacing - 0.5, -0.5 - faces::deletion_depth, 0.5) : 0.0;
  }
};

/// The terms that drive a front into dry ground behind a face.
struct InfiltrationSpeed {
  double head = 0.0;     ///< m2/s, k/n times the pressure head
  double gravity = 0.0;  ///< m/s, k/n times the cosine between gravity and the inward normal
};

/// A point in the soil at `depth` inside a place on its face. Where the soil is thinner, as near the toe of a slope,
/// where the normal soon reaches the base, the point is less deep.
template <int D>
Vec<D> behind_face(const Ground<D>& ground, const Vec<D>& foot, const Vec<D>& normal, double depth) {
  for (double share = 1.0; share > 1e-3; share *= 0.5)
    if (Vec<D> x = foot + share * depth * normal; ground.at(x)) return x;
  return foot + depth * normal;
}

/// The point at which a face's soil is looked up: a quarter spacing inside. At the toe of a slope of two to one or
/// flatter, a point at that depth would lie below the base.
template <int D>
Vec<D> just_inside(const Ground<D>& ground, const Vec<D>& foot, const Vec<D>& normal, double spacing) {
  return behind_face<D>(ground, foot, normal, faces::soil_depth * spacing);
}

namespace detail {

template <int D>
bool in_water(const Case& scene, const Vec<D>& x) {
  return std::any_of(scene.fluid.regions.begin(), scene.fluid.regions.end(),
                     [&](const Shape& region) { return contains(region, to_point3<D>(x), D); });
}

/// Whether a place lies on a face.
template <int D>
bool lies_on(const Face& face, const Vec<D>& x, double tolerance) {
  for (const auto& piece : planes_of<D>(face, 0, tolerance)) {
    const double along = piece.tangent.dot(x);
    const bool beside = piece.to > piece.from && (along < piece.from || along > piece.to);
    if (!beside && std::abs(piece.normal.dot(x - piece.point)) <= tolerance) return true;
  }
  return false;
}

template <int D>
void add_column(const Case& scene, const Ground<D>& ground, int face, const Vec<D>& foot, const Vec<D>& normal,
                double area, double width, std::vector<FaceColumn<D>>& columns) {
  const double dx = scene.fluid.particle_spacing;
  const Vec<D> probe = just_inside<D>(ground, foot, normal, dx);
  const Stratum* soil = ground.at(probe);
  if (!soil && !in_water<D>(scene, probe) && !scene.water_faces[static_cast<std::size_t>(face)].outlet) return;
  FaceColumn<D> c;
  c.foot = foot;
  c.normal = normal;
  c.face = face;
  c.volume = std::pow(dx, D);
  c.spacing = c.volume / area;
  c.width = width;
  c.in_soil = soil != nullptr;
  c.held = std::any_of(scene.walls.begin(), scene.walls.end(), [&](const Wall& wall) {
    return (wall.soil == Wall::ForSoil::fixed || wall.soil == Wall::ForSoil::rough) &&
           lies_on<D>(wall.face, foot, 1e-6 * dx);
  });
  c.loaded = std::any_of(scene.loads.begin(), scene.loads.end(),
                         [&](const Load& load) { return lies_on<D>(load.face, foot, 1e-6 * dx); });
  c.void_fraction = soil ? soil->fillable_porosity : 1.0;
  if (soil && scene.fluid.drag)
    c.drag_dominated = !inertia_rules(c.void_fraction, scene.water.density, soil->resistance.linear, dx,
                                      ground.specific_weight() / scene.water.density);
  c.mass = scene.water.density * c.void_fraction * c.volume;
  c.offset = 0.5 * c.spacing;
  columns.push_back(c);
}

}  // namespace detail

/// The points at which a wall ends and a face with columns begins.
template <int D>
std::vector<Joint<D>> make_joints(const Case& scene) {
  std::vector<Joint<D>> joints;
  if constexpr (D == 2) {
    const double tolerance = 0.05 * scene.fluid.particle_spacing;
    const auto ends = [](const sph::ImagePlane<D>& p) {
      const double at = p.tangent.dot(p.point);
      return std::array<Vec<D>, 2>{p.point + (p.from - at) * p.tangent, p.point + (p.to - at) * p.tangent};
    };
    for (const auto& face : scene.water_faces) {
      if (is_inlet(scene, face) || face.face.points.empty()) continue;
      for (const auto& next : planes_of<D>(face.face, 0, 0.0))
        for (std::size_t w = 0; w < scene.walls.size(); ++w) {
          const auto& wall = scene.walls[w];
          if (wall.water == Wall::ForWater::none || wall.face.points.empty()) continue;
          for (const auto& piece : planes_of<D>(wall.face, static_cast<int>(w), 0.0))
            for (const std::size_t e : {0, 1}) {
              if ((ends(piece)[e] - ends(next)[1 - e]).norm() > tolerance) continue;
              const double sign = e == 1 ? 1.0 : -1.0;
              // An end turned towards the domain is a corner, which images of the columns fill.
              if (sign * piece.normal.dot(next.tangent) > 0.01) continue;
              joints.push_back(
                  {ends(piece)[e], sign * piece.tangent, piece.normal, piece.to - piece.from, static_cast<int>(w)});
            }
        }
    }
  }
  return joints;
}

/// Sets FaceColumn::handed_to where the soil behind a column is thinner than a spacing: to the nearest column of the
/// same face and soil behind which a row fits.
template <int D>
void hand_on(const Ground<D>& ground, std::vector<FaceColumn<D>>& columns) {
  std::vector<char> has_place;
  std::vector<const Stratum*> soil;
  for (const auto& c : columns) {
    has_place.push_back(!c.in_soil || ground.at(c.foot + c.spacing * c.normal) ? 1 : 0);
    soil.push_back(ground.at(just_inside<D>(ground, c.foot, c.normal, c.spacing)));
  }
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (has_place[i] != 0) continue;
    auto& c = columns[i];
    double nearest = HUGE_VAL;
    for (std::size_t k = 0; k < columns.size(); ++k) {
      const double distance = (columns[k].foot - c.foot).norm();
      if (columns[k].face != c.face || has_place[k] == 0 || soil[k] != soil[i] || distance >= nearest) continue;
      c.handed_to = static_cast<int>(k);
      nearest = distance;
    }
  }
}

/// The columns of all water faces. A face given as a plane is tiled where soil or regions of water lie behind it.
template <int D>
std::vector<FaceColumn<D>> make_columns(const Case& scene, const Ground<D>& ground) {
  std::vector<FaceColumn<D>> columns;
  const double dx = scene.fluid.particle_spacing;
  for (std::size_t f = 0; f < scene.water_faces.size(); ++f) {
    if (is_inlet(scene, scene.water_faces[f])) continue;
    const Face& face = scene.water_faces[f].face;
    const int number = static_cast<int>(f);
    if constexpr (D == 2) {
      if (!face.points.empty()) {
        for (const auto& piece : planes_of<2>(face, 0, 0.0)) {
          const double length = piece.to - piece.from;
          const int count = std::max(1, static_cast<int>(std::lround(length / dx)));
          const double width = length / count;
          const std::size_t first = columns.size();
          for (int i = 0; i < count; ++i)
            detail::add_column<2>(scene, ground, number, piece.point + (i + 0.5) * width * piece.tangent, piece.normal,
                                  width, 0.5 * width, columns);
          if (columns.size() == first) continue;
          for (const auto& joint : make_joints<2>(scene)) {
            if (joint.normal.dot(piece.normal) < 0.9999 ||
                std::abs(piece.normal.dot(joint.at - piece.point)) > 0.05 * dx)
              continue;
            auto& c = joint.along.dot(piece.tangent) > 0.0 ? columns[first] : columns.back();
            if ((c.foot - joint.at).norm() > 1.05 * c.width) continue;
            (joint.along.dot(piece.tangent) > 0.0 ? c.before : c.after) = joint.length;
          }
        }
        continue;
      }
    }
    // A plane is tiled over the box around everything, with an orthonormal pair (2D: one vector) of tangents.
    const Vec<D> point = face.point.head<D>(), normal = face.normal.head<D>().normalized();
    Eigen::Matrix<double, D, D> frame = Eigen::Matrix<double, D, D>::Identity();
    int axis = 0;
    normal.cwiseAbs().maxCoeff(&axis);
    frame.col(axis).swap(frame.col(0));
    frame.col(0) = normal;
    for (int d = 1; d < D; ++d) {
      for (int e = 0; e < d; ++e) frame.col(d) -= frame.col(e).dot(frame.col(d)) * frame.col(e);
      frame.col(d).normalize();
    }
    Vec<D> lower = Vec<D>::Constant(1e300), upper = -lower;
    const auto enclose = [&](const Shape& shape) {
      const auto [lo, hi] = bounds(shape);
      for (int corner = 0; corner < (1 << D); ++corner) {
        Vec<D> x;
        for (int d = 0; d < D; ++d) x[d] = (corner >> d) & 1 ? hi[d] : lo[d];
        const Vec<D> along = frame.transpose() * (x - point);
        lower = lower.cwiseMin(along);
        upper = upper.cwiseMax(along);
      }
    };
    for (const auto& soil : scene.soils) enclose(soil.shape);
    for (const auto& region : scene.fluid.regions) enclose(region);
    if (!(upper[0] >= lower[0])) continue;
    std::array<int, 3> count{1, 1, 1};
    Vec<D> step = Vec<D>::Zero();
    double area = 1.0;
    for (int d = 1; d < D; ++d) {
      const double length = upper[d] - lower[d];
      count[static_cast<std::size_t>(d)] = std::max(1, static_cast<int>(std::lround(length / dx)));
      step[d] = length / count[static_cast<std::size_t>(d)];
      area *= step[d];
    }
    for (int j = 0; j < count[2]; ++j)
      for (int i = 0; i < count[1]; ++i) {
        Vec<D> x = point + (lower[1] + (i + 0.5) * step[1]) * frame.col(1);
        if constexpr (D == 3) x += (lower[2] + (j + 0.5) * step[2]) * frame.col(2);
        detail::add_column<D>(scene, ground, number, x, normal, area, 0.5 * step[1], columns);
      }
  }
  if (!scene.coupled()) hand_on<D>(ground, columns);
  return columns;
}

/// Finds the column to which a place belongs.
template <int D>
class ColumnFinder {
 public:
  explicit ColumnFinder(const std::vector<FaceColumn<D>>& columns) : columns_(columns) {
    for (const auto& c : columns_) {
      feet_.push_back(c.foot);
      widest_ = std::max(widest_, reach * std::max(c.spacing, 2.0 * c.width));
    }
    grid_.build(feet_, std::max(widest_, 1e-300));
  }
  ColumnFinder(const ColumnFinder&) = delete;
  ColumnFinder& operator=(const ColumnFinder&) = delete;

  /// The column with the nearest foot, if x lies before, behind or less than a spacing beside it; -1: no such column.
  [[nodiscard]] int nearest(const Vec<D>& x) const {
    int best = -1;
    double least = widest_ * widest_;
    grid_.for_each_within(x, widest_, [&](Index i, double r2) {
      if (r2 >= least) return;
      least = r2;
      best = static_cast<int>(i);
    });
    if (best < 0) return -1;
    const auto& c = columns_[static_cast<std::size_t>(best)];
    const Vec<D> lateral = x - c.foot - c.inside(x) * c.normal;
    return lateral.norm() <= c.width + c.spacing ? best : -1;
  }

 private:
  static constexpr double reach = 2.0;
  const std::vector<FaceColumn<D>>& columns_;
  VecArray<D> feet_;
  double widest_ = 0.0;
  sph::CellGrid<D> grid_;
};

/// Sets the columns' pressures at a time [s]. A column is wet where the total pressure at its foot is not negative.
/// boundaries, states: one per face.
template <int D>
void update_columns(const WaterBoundaries& boundaries, std::span<const FaceState> states, double time,
                    const Vec<D>& weight, const Vec<D>& origin, std::vector<FaceColumn<D>>& columns) {
  const double magnitude = weight.norm();
  for (auto& c : columns) {
    const auto face = static_cast<std::size_t>(c.face);
    const double elevation = magnitude > 0.0 ? -weight.dot(c.foot) / magnitude : 0.0;
    const double total = boundaries[face]->pressure({to_point3<D>(c.foot), elevation, magnitude}, time, states[face]);
    c.wet = total >= 0.0;
    c.pressure = total - weight.dot(c.foot - origin);
  }
}

/// The buffers of the columns. beyond: where a wall continues a face in a straight line, the face's last column is
/// repeated behind the wall, as far as lines of sight through the face reach (Joint).
template <int D>
std::vector<Buffer<D>> make_buffers(const std::vector<FaceColumn<D>>& columns, bool beyond = false) {
  std::vector<Buffer<D>> buffers;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const auto& c = columns[i];
    if (!c.wet) continue;
    const auto add = [&](const Vec<D>& foot) {
      for (int j = 1; j <= faces::buffers_per_column; ++j) {
        const double d = c.offset - j * c.spacing;
        buffers.push_back({foot + d * c.normal, c.volume, static_cast<Index>(i), -d, foot, c.normal, c.in_soil});
      }
    };
    add(c.foot);
    if constexpr (D == 2) {
      const Vec<D> step = 2.0 * c.width * Vec<D>(c.normal[1], -c.normal[0]);
      for (int k = 1; beyond && k < faces::buffers_per_column; ++k) {
        if ((k - 0.5) * 2.0 * c.width < c.before) add(c.foot - k * step);
        if ((k - 0.5) * 2.0 * c.width < c.after) add(c.foot + k * step);
      }
    }
  }
  return buffers;
}

/// Returns m/2 [spacings], with m = sum_s s^3 F / sum_s s^2 F and F = -W'/r summed over the row at the distance of s
/// spacings. A sudden load makes the pressure p0 uniform behind a drained face. If the slope at the face is p0 / (m/2)
/// and the first row lies half a spacing inside, the pressure gradients of all rows sum to the pressure drop p0 at the
/// face (docs/theory/coupling.md, "Loads on a drained face").
template <int D>
double length_of_even_fall() {
  static const double value = [] {
    constexpr int reach = 3;
    double second = 0.0, third = 0.0;
    for (int s = 1; s <= reach; ++s)
      for (int i = -reach; i <= reach; ++i)
        for (int j = (D == 3 ? -reach : 0); j <= (D == 3 ? reach : 0); ++j) {
          const double F =
              -Kernel<D>::derivative_over_r(std::sqrt(1.0 * (s * s + i * i + j * j)), points::smoothing_ratio);
          second += s * s * F;
          third += s * s * s * F;
        }
    return 0.5 * third / second;
  }();
  return value;
}

/// Whether point j of a stencil is visible from a place.
template <int D>
bool sees(const sph::Sight<D>& sight, const Stencil<D>& s, const Vec<D>& x, Index j,
          const typename sph::Sight<D>::Near& near) {
  return j < s.n_base ? sight.open(x, s.position[j], near) : sight.sees(x, j, s.n_base, s.position, s.by, s.of, near);
}

/// Fits the pressure's slope at every column: a weighted least-squares line through the face's pressure, over the
/// particles of the first spacings inside and their images behind walls. Particles on the face itself do not determine
/// the slope; where there are too few others, the slope of the last window is used in proportion.
///
/// Below a load, before any drainage, the grains carry the whole drop of an even pressure at the face. There the slope
/// of the first row alone is mixed in until the gradients sum to that drop (with the fit alone they sum to 0.86 of it).
/// free [n]: 1 for particles in no soil, which are ignored at a face of soil. All ranks call this.
template <int D>
void fit_columns(const std::vector<FaceColumn<D>>& columns, std::span<const char> free, Stencil<D>& s,
                 const sph::Sight<D>& sight = {}) {
  typename sph::Sight<D>::Near near_by;
  s.fit_offset.assign(1, 0);
  s.fit_constant.clear();
  s.fitted.clear();
  if (columns.empty()) return;
  sph::CellGrid<D> grid;
  double widest = 0.0;
  for (const auto& c : columns)
    widest = std::max(widest, sph::support_radius * faces::fit_length * spacing_of<D>(c.volume));
  grid.build(s.position, widest);
  // Sums over the particles inside: of the weights times the distance from the face and its square, for all rows and
  // for the first alone; the least sum of squares; and how many particles there are.
  enum { sum, whole, first_sum, first_whole, least, count, n_sums };
  ScalarArray sums(columns.size() * n_sums, 0.0), first;  // first: the weights of the first row alone
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const auto& c = columns[i];
    double* const of = sums.data() + i * n_sums;
    if (c.wet) {
      const double h = faces::fit_length * spacing_of<D>(c.volume);
      const Vec<D> probe = c.foot + faces::probe_depth * c.spacing * c.normal;
      if (sight.limited()) sight.find_near(probe, sph::support_radius * h, near_by);
      grid.for_each_within(probe, sph::support_radius * h, [&](Index j, double r2) {
        const Index a = s.parent[j];
        if (sight.limited() && !sees<D>(sight, s, probe, j, near_by)) return;
        const double d = c.inside(s.position[j]);
        // A particle that has just been born lies on the face, within rounding.
        if (a >= s.n_real || d < -1e-6 * c.spacing || (c.in_soil && free[a])) return;
        const double w = s.volume[a] * Kernel<D>::value(std::sqrt(r2), h);
        if (w == 0.0) return;
        const double near = w * std::max(0.0, 1.0 - d / c.spacing);
        of[sum] += w * d * d;
        of[whole] += w * d;
        of[first_sum] += near * d * d;
        of[first_whole] += near * d;
        of[least] += w * faces::least_fitted * c.spacing * c.spacing;
        of[count] += 1.0;
        s.fit_index.push_back(a);
        s.fit_weight.push_back(w * d);
        first.push_back(near * d);
      });
    }
    s.fit_offset.push_back(static_cast<Index>(s.fit_index.size()));
  }
  s.domain.sum(sums);
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const auto& c = columns[i];
    const double* const of = sums.data() + i * n_sums;
    const double total = std::max(of[sum], of[least]);
    double share = 0.0;
    if (c.loaded && of[sum] >= of[least] && of[first_sum] > 0.0) {
      // Slopes for an even pressure of 1: that of the fit, that of the first row, and the required one.
      const double fitted = of[whole] / of[sum], steepest = of[first_whole] / of[first_sum];
      const double wanted = 1.0 / (c.spacing * (0.5 + length_of_even_fall<D>()) - c.offset);
      if (steepest > fitted) share = std::clamp((wanted - fitted) / (steepest - fitted), 0.0, 1.0);
    }
    for (std::size_t k = s.fit_offset[i]; k < s.fit_offset[i + 1]; ++k) {
      s.fit_weight[k] /= total;
      if (share > 0.0) s.fit_weight[k] += share * (first[k] / of[first_sum] - s.fit_weight[k]);
    }
    s.fit_constant.push_back(total > 0.0 ? (1.0 - of[sum] / total) * c.slope : 0.0);
    s.fitted.push_back(of[count] > 0.0 ? 1 : 0);
  }
}

}  // namespace poretwin::fluid
