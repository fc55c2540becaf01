#include "solid_solver/output/deposit.hpp"

#include "common/numerics/dense.hpp"
#include "solid_solver/numerics/readings.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace poretwin::solid {
namespace {

/// Wendland C2 kernel in one dimension less than the soil's [1/m^(D-1)].
/// It serves for sums over all soil on a vertical line.
template <int D>
double flat_kernel(double r, double h) {
  constexpr double pi = 3.14159265358979;
  const double q = r / h;
  if (q >= sph::support_radius) return 0.0;
  const double u = 1.0 - 0.5 * q, u2 = u * u;
  return (D == 2 ? 0.75 / h : 7.0 / (4.0 * pi * h * h)) * u2 * u2 * (2.0 * q + 1.0);
}

/// Thickness [m] that the soil would have if packed as at the start, at the places x, x - step, x - 2 step, ...
template <int D>
ScalarArray thicknesses(const Setup<D>& setup, const State<D>& state, const Vec<D>& x, const Vec<D>& step,
                        std::size_t n_places) {
  const auto& p = state.particles;
  const Vec<D> up = upwards(setup), back = up.dot(step) * up - step;
  const double h = setup.smoothing_length, length = back.norm(), last = static_cast<double>(n_places) - 1.0;
  const double reach = length > 0.0 ? sph::support_radius * h / length : last;  // in steps
  ScalarArray sum(n_places, 0.0);
  for (std::size_t i = 0; i < p.free(); ++i) {
    Vec<D> r = p.position[i] - x;
    r -= up.dot(r) * up;
    const double nearest = length > 0.0 ? r.dot(back) / (length * length) : 0.0;
    const double first = std::max(0.0, std::ceil(nearest - reach)), end = std::min(last, nearest + reach);
    for (double k = first; k <= end; k += 1.0)
      sum[static_cast<std::size_t>(k)] +=
          p.mass[i] / setup.density[p.material[i]] * flat_kernel<D>((r - k * back).norm(), h);
  }
  return sum;
}

/// A particle or an image with its bulk volume [m^D].
template <int D>
struct Piece {
  Vec<D> position;
  double volume;
};

/// All particles and images within a kernel's reach of the line through x along `up`.
template <int D>
std::vector<Piece<D>> pieces_along(const Setup<D>& setup, const State<D>& state, const Vec<D>& x, const Vec<D>& up) {
  const auto& p = state.particles;
  const auto& images = state.near.images;
  const double reach = sph::support_radius * setup.smoothing_length;
  std::vector<Piece<D>> pieces;
  auto add = [&](const Vec<D>& position, double volume) {
    const Vec<D> r = position - x;
    if ((r - up.dot(r) * up).squaredNorm() < reach * reach) pieces.push_back({position, volume});
  };
  for (std::size_t i = 0; i < p.size(); ++i) add(p.position[i], p.volume[i]);
  for (const auto& image : images) add(image.map * p.position[image.parent] + image.shift, p.volume[image.parent]);
  return pieces;
}

/// Coverage of a place by the particles that see it, or one of its images, past thin walls. (A particle sees an image
/// of the place along the same line as the place sees the image of the particle.)
template <int D>
double coverage_past_walls(const Setup<D>& setup, const State<D>& state, const Vec<D>& place) {
  const auto& p = state.particles;
  const sph::Sight<D>& sight = setup.boundaries.sight;
  const double h = setup.smoothing_length, reach = sph::support_radius * h;
  VecArray<D> seen{place};
  const auto images = sph::images_in_all_orders<D>(seen, sight.planes(), reach);
  seen.insert(seen.end(), images.position.begin(), images.position.end());
  typename sph::Sight<D>::Near walls;
  double sum = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    for (Index k = 0; k < seen.size(); ++k) {
      const double weight = p.volume[i] * sph::WendlandC2<D>::value((seen[k] - p.position[i]).norm(), h);
      if (weight <= 0.0) continue;
      sight.find_near(p.position[i], reach, walls);
      const bool open = k == 0 ? sight.open(p.position[i], place, walls)
                               : sight.sees(p.position[i], k, 1, seen, images.by, images.of, walls);
      if (open) sum += weight;
    }
  }
  return sum;
}

/// Kernel sums over the neighbours of each particle and itself.
template <int D>
struct Surroundings {
  ScalarArray cover;   ///< coverage of the particle's place by soil
  VecArray<D> centre;  ///< m, first moment of the coverage about the particle
};
template <int D>
Surroundings<D> surroundings(const Setup<D>& setup, const State<D>& state) {
  const double h = setup.smoothing_length;
  const std::size_t n = state.particles.size();
  Surroundings<D> sums{ScalarArray(n), VecArray<D>(n, Vec<D>::Zero())};
  for (std::size_t i = 0; i < n; ++i) sums.cover[i] = state.nodes[i].volume * sph::WendlandC2<D>::value(0.0, h);
  for_each_ordered_pair(state.near.pairs, [&](std::size_t i, std::size_t j, std::size_t) {
    const Vec<D> r = state.nodes[j].position - state.nodes[i].position;
    const double weight = state.nodes[j].volume * sph::WendlandC2<D>::value(r.norm(), h);
    sums.cover[i] += weight;
    sums.centre[i] += weight * r;
  });
  return sums;
}

/// Whether each particle lies inside the soil (1 or 0).
template <int D>
std::vector<char> inside(const Setup<D>& setup, const State<D>& state) {
  const double h = setup.smoothing_length;
  const auto [cover, centre] = surroundings(setup, state);
  std::vector<char> found(state.particles.free());
  for (std::size_t i = 0; i < found.size(); ++i)
    found[i] = cover[i] > readings::inside_cover && centre[i].norm() < readings::inside_centre * h * cover[i];
  return found;
}

}  // namespace

template <int D>
double front_position(const Setup<D>& setup, const State<D>& state, const Vec<D>& from, const Vec<D>& to,
                      double thickness) {
  const auto& p = state.particles;
  const Vec<D> along = (to - from).normalized();
  const double length = (to - from).norm();
  double tip = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < p.free(); ++i) tip = std::max(tip, along.dot(p.position[i] - from));
  tip = std::clamp(tip + 0.5 * setup.spacing, 0.0, length);
  if (thickness <= 0.0) return tip;
  const double step = readings::step * setup.spacing, begin = std::min(length, tip + 2.0 * setup.smoothing_length);
  const auto n_places = static_cast<std::size_t>(begin / step) + 1;
  const ScalarArray found = thicknesses<D>(setup, state, from + begin * along, step * along, n_places);
  double beyond = 0.0;
  for (std::size_t k = 0; k < n_places; ++k) {
    const double s = begin - static_cast<double>(k) * step;
    if (found[k] >= thickness) return s + step * (found[k] - thickness) / std::max(found[k] - beyond, 1e-300);
    beyond = found[k];
  }
  return 0.0;
}

template <int D>
double surface_height(const Setup<D>& setup, const State<D>& state, const Vec<D>& x) {
  const auto& p = state.particles;
  const Vec<D> up = upwards(setup);
  double top = -std::numeric_limits<double>::infinity(), bottom = -top;
  for (std::size_t i = 0; i < p.free(); ++i) {
    const double level = up.dot(p.position[i] - x);
    top = std::max(top, level);
    bottom = std::min(bottom, level);
  }
  const auto pieces = pieces_along<D>(setup, state, x, up);
  auto coverage_at = [&](const Vec<D>& place) {
    if (setup.boundaries.sight.limited()) return coverage_past_walls(setup, state, place);
    double sum = 0.0;
    for (const auto& piece : pieces)
      sum += piece.volume * sph::WendlandC2<D>::value((piece.position - place).norm(), setup.smoothing_length);
    return sum;
  };
  const double step = readings::step * setup.spacing;
  double above = 0.0;
  for (double z = top + setup.smoothing_length; z >= bottom; z -= step) {
    const double here = coverage_at(x + z * up);
    if (here >= 0.5) return z + step * (here - 0.5) / std::max(here - above, 1e-300);
    above = here;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

template <int D>
double crest_level(const Setup<D>& setup, const State<D>& state, const std::function<bool(const Vec<D>&)>& counts) {
  const auto& p = state.particles;
  const Vec<D> up = upwards(setup);
  const ScalarArray cover = surroundings(setup, state).cover;
  double top = -std::numeric_limits<double>::infinity(), highest = top;
  for (std::size_t i = 0; i < p.free(); ++i) {
    if (!counts(p.position[i])) continue;
    const double level = up.dot(p.position[i]);
    highest = std::max(highest, level);
    if (cover[i] >= readings::in_contact) top = std::max(top, level);
  }
  return (std::isfinite(top) ? top : highest) + 0.5 * setup.spacing;
}

template <int D>
double stress_noise(const Setup<D>& setup, const State<D>& state) {
  using Basis = Eigen::Matrix<double, D + 1, 1>;
  using Moment = Eigen::Matrix<double, D + 1, D + 1>;
  const auto& p = state.particles;
  const double h = setup.smoothing_length;
  std::vector<Moment> moment(p.size(), Moment::Zero());
  std::vector<Basis> right(p.size(), Basis::Zero());
  auto add = [&](std::size_t i, std::size_t j) {
    const Vec<D> r = p.position[j] - p.position[i];
    Basis basis;
    basis << 1.0, r / h;
    const double weight = p.volume[j] * sph::WendlandC2<D>::value(r.norm(), h);
    moment[i] += weight * basis * basis.transpose();
    right[i] += weight * trace(p.stress[j]) / 3.0 * basis;
  };
  for (std::size_t i = 0; i < p.free(); ++i) add(i, i);
  for_each_ordered_pair(state.near.pairs, [&](std::size_t i, std::size_t j, std::size_t) {
    if (j < p.free()) add(i, j);
  });
  const std::vector<char> within = inside<D>(setup, state);
  double sum = 0.0, count = 0.0;
  for (std::size_t i = 0; i < p.free(); ++i) {
    if (!within[i] || moment[i].determinant() < readings::least_determinant * std::pow(moment[i](0, 0), D + 1))
      continue;  // too few neighbours
    const Basis fit = solve_symmetric<D + 1>(moment[i], right[i]);
    const double difference = trace(p.stress[i]) / 3.0 - fit[0];
    sum += difference * difference;
    count += 1.0;
  }
  return count > 0.0 ? std::sqrt(sum / count) : 0.0;
}

template <int D>
double density_error(const Setup<D>& setup, const State<D>& state) {
  const auto& p = state.particles;
  const std::vector<char> within = inside<D>(setup, state);
  double sum = 0.0, count = 0.0;
  for (std::size_t i = 0; i < p.free(); ++i) {
    if (!within[i]) continue;
    const double error = p.mass[i] / (setup.density[p.material[i]] * p.volume[i]) - 1.0;
    sum += error * error;
    count += 1.0;
  }
  return count > 0.0 ? std::sqrt(sum / count) : 0.0;
}

#define PORETWIN_INSTANTIATE(D)                                                                                \
  template double front_position<D>(const Setup<D>&, const State<D>&, const Vec<D>&, const Vec<D>&, double);   \
  template double surface_height<D>(const Setup<D>&, const State<D>&, const Vec<D>&);                          \
  template double crest_level<D>(const Setup<D>&, const State<D>&, const std::function<bool(const Vec<D>&)>&); \
  template double stress_noise<D>(const Setup<D>&, const State<D>&);                                           \
  template double density_error<D>(const Setup<D>&, const State<D>&);
PORETWIN_INSTANTIATE(2)
PORETWIN_INSTANTIATE(3)
#undef PORETWIN_INSTANTIATE

}  // namespace poretwin::solid
