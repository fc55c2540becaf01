#include "solid_solver/material/mohr_coulomb.hpp"

#include "solid_solver/material/local_factor.hpp"

#include <cmath>
#include <limits>
#include <numbers>

namespace poretwin::solid {
namespace {

// The functions below treat one particle (In = InOnes) or four at a time (InFours).

/// The yield surface f = up s1 - down s3 - k, with the plastic potential and the elastic moduli, for one particle or
/// four.
template <class In>
struct Surface {
  using Number = typename In::Number;
  Number up, down;            ///< 1 + sin(phi), 1 - sin(phi)
  Number k;                   ///< Pa, 2 c cos(phi)
  Number flow_up, flow_down;  ///< 1 + sin(psi), 1 - sin(psi)
  Number limit;               ///< largest principal stress possible [Pa]
  Moduli<In> moduli;
};

/// Sets the limit of tension: the apex, or the tensile strength if that is lower.
template <class In>
[[gnu::always_inline]] inline void limit_tension(double tensile_strength, Surface<In>& surface) {
  using Number = typename In::Number;
  const Number friction = surface.up - surface.down, apex = surface.k / friction;
  surface.limit = Number{} + tensile_strength;
  surface.limit = (friction > 0.0) & (apex < surface.limit) ? apex : surface.limit;
}

/// Returns principal stresses t[0] >= t[1] >= t[2] to the surface. Computes the equivalent deviatoric plastic strain (0
/// inside).
template <class In>
[[gnu::always_inline]] inline void return_principal(const Surface<In>& y, typename In::Number* t,
                                                    typename In::Number& plastic) {
  using Number = typename In::Number;
  using Mask = typename In::Mask;
  const Number two_g = 2.0 * y.moduli.shear, lame = y.moduli.bulk - two_g / 3.0;
  // Decrease of s1, s2, s3 per unit of the face's multiplier. off_12, off_23: mean decrease of the two stresses that
  // are equal where two faces meet.
  const Number off_2 = lame * (y.flow_up - y.flow_down), off_1 = off_2 + two_g * y.flow_up,
               off_3 = off_2 - two_g * y.flow_down, off_12 = off_2 + y.moduli.shear * y.flow_up,
               off_23 = off_2 - y.moduli.shear * y.flow_down;
  const Number f = y.up * t[0] - y.down * t[2] - y.k;
  const Mask yields = (f > 0.0) | (t[0] > y.limit);
  Number multiplier = f;
  max_in_place(multiplier, Number{});
  multiplier /= y.up * off_1 - y.down * off_3;
  Number s1 = t[0] - multiplier * off_1, s2 = t[1] - multiplier * off_2, s3 = t[2] - multiplier * off_3;
  const Mask upper = s2 > s1, lower = s2 < s3;
  const Number on_upper =
      (y.up * (t[0] + t[1]) - 2.0 * (y.down * t[2] + y.k)) / (2.0 * (y.up * off_12 - y.down * off_3));
  const Number on_lower =
      (2.0 * (y.up * t[0] - y.k) - y.down * (t[1] + t[2])) / (2.0 * (y.up * off_1 - y.down * off_23));
  const Number upper_pair = 0.5 * (t[0] + t[1]) - on_upper * off_12,
               lower_pair = 0.5 * (t[1] + t[2]) - on_lower * off_23;
  s1 = upper ? upper_pair : lower ? t[0] - on_lower * off_1 : s1;
  s2 = upper ? upper_pair : lower ? lower_pair : s2;
  s3 = upper ? t[2] - on_upper * off_3 : lower ? lower_pair : s3;
  // Tension: one, two or three principal stresses are at the limit, where this is possible without shear failure.
  const Mask cut = s1 > y.limit;
  if (any(cut)) {
    const Number stiff = lame + two_g, over = t[0] - y.limit, one = lame * over / stiff;
    Number least = t[1] - one > y.limit ? t[2] - lame * (over + t[1] - y.limit) / (lame + stiff) : t[2] - one;
    Number middle = t[1] - one;
    min_in_place(middle, y.limit);
    min_in_place(least, y.limit);
    // Otherwise the face yields as well: s1 and s3 lie where the face meets the limit.
    const Number met = (y.up * y.limit - y.k) / y.down, short_of = t[2] - met;
    const Number determinant = off_1 * lame - off_3 * stiff;
    const Number by_face = (over * lame - short_of * stiff) / determinant,
                 by_limit = (off_1 * short_of - off_3 * over) / determinant;
    Number between = t[1] - by_face * off_2 - by_limit * lame;
    max_in_place(between, met);
    min_in_place(between, y.limit);
    const Mask sheared = least < met;
    s1 = cut ? y.limit : s1;
    s2 = cut ? (sheared ? between : middle) : s2;
    s3 = cut ? (sheared ? met : least) : s3;
  }
  Number part[3] = {t[0] - s1, t[1] - s2, t[2] - s3};
  const Number mean = (part[0] + part[1] + part[2]) / 3.0;
  Number square{};
  for (Number& p : part) square += (p - mean) * (p - mean);
  plastic = square / 1.5;
  sqrt_in_place(plastic);
  plastic /= two_g;
  // In pure tension nothing yields in shear: the smallest positive number marks that the soil yielded.
  max_in_place(plastic, Number{} + std::numeric_limits<double>::min());
  plastic = yields ? plastic : Number{};
  t[0] = yields ? s1 : t[0];
  t[1] = yields ? s2 : t[1];
  t[2] = yields ? s3 : t[2];
}

/// A symmetric tensor with one known principal axis: the value on that axis; and in the plane across it the mean of the
/// two normal components, half of their difference, and the shear component.
template <class In>
struct Across {
  typename In::Number axis, mean, half, shear;
};

template <class In>
[[gnu::always_inline]] inline void return_across(const Surface<In>& surface, Across<In>& stress,
                                                 typename In::Number& plastic) {
  using Number = typename In::Number;
  using Mask = typename In::Mask;
  Number radius = stress.half * stress.half + stress.shear * stress.shear;
  sqrt_in_place(radius);
  const Number high = stress.mean + radius, low = stress.mean - radius;
  const Mask above = stress.axis > high, below = stress.axis < low;
  Number t[3] = {above ? stress.axis : high, above ? high : below ? low : stress.axis, below ? stress.axis : low};
  return_principal<In>(surface, t, plastic);
  const Number new_high = above ? t[1] : t[0], new_low = below ? t[1] : t[2];
  stress.axis = above ? t[0] : below ? t[2] : t[1];
  stress.mean = 0.5 * (new_high + new_low);
  const Number kept = radius > 0.0 ? 0.5 * (new_high - new_low) / radius : Number{};
  stress.half *= kept;
  stress.shear *= kept;
}

/// An orthonormal frame in which w is the principal axis of a deviator whose principal value is farthest from the other
/// two values. This value is a single root of the cubic equation.
template <class In>
struct Frame {
  typename In::Number u[3], v[3], w[3];
};

template <class In>
[[gnu::always_inline]] inline void cross(const typename In::Number* a, const typename In::Number* b,
                                         typename In::Number* c) {
  c[0] = a[1] * b[2] - a[2] * b[1];
  c[1] = a[2] * b[0] - a[0] * b[2];
  c[2] = a[0] * b[1] - a[1] * b[0];
}

template <class In>
[[gnu::always_inline]] inline void find_frame(const typename In::Number* stress, Frame<In>& frame) {
  using Number = typename In::Number;
  using Mask = typename In::Mask;
  const Number mean = (stress[0] + stress[1] + stress[2]) / 3.0;
  Number size;
  root_j2(stress, size);
  const Number scale = 1.0 / (size + 1e-300);
  const Number xx = (stress[0] - mean) * scale, yy = (stress[1] - mean) * scale, zz = (stress[2] - mean) * scale,
               xy = stress[3] * scale, yz = stress[4] * scale, xz = stress[5] * scale;
  const Number third = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz);
  // r^3 - r = |J3| for a deviator with J2 = 1. The root lies between 1 and 2/sqrt(3); three steps of Newton's method
  // find it to rounding.
  const Mask turned = third < 0.0;
  const Number j3 = turned ? -third : third;
  Number root = 1.0 + 0.4 * j3;
  for (int k = 0; k < 3; ++k) root = (2.0 * root * root * root + j3) / (3.0 * root * root - 1.0);
  root = turned ? -root : root;
  const Number rows[3][3] = {{xx - root, xy, xz}, {xy, yy - root, yz}, {xz, yz, zz - root}};
  // The rows of a matrix that maps w to zero: w is orthogonal to each of them.
  Number best{};
  for (int k = 0; k < 3; ++k) {
    Number axis[3];
    cross<In>(rows[k], rows[(k + 1) % 3], axis);
    const Number length = axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2];
    const Mask longer = length > best;
    best = longer ? length : best;
    for (int d = 0; d < 3; ++d) frame.w[d] = longer || k == 0 ? axis[d] : frame.w[d];
  }
  sqrt_in_place(best);
  for (Number& w : frame.w) w /= best;
  const Number zero{};
  const Mask along_x = frame.w[0] * frame.w[0] > frame.w[1] * frame.w[1];
  const Number first = along_x ? -frame.w[2] : zero, second = along_x ? zero : frame.w[2],
               last = along_x ? frame.w[0] : -frame.w[1];
  Number length = first * first + second * second + last * last;
  sqrt_in_place(length);
  frame.u[0] = first / length;
  frame.u[1] = second / length;
  frame.u[2] = last / length;
  cross<In>(frame.w, frame.u, frame.v);
}

/// a . T b.
template <class In>
[[gnu::always_inline]] inline void form(const typename In::Number* tensor, const typename In::Number* a,
                                        const typename In::Number* b, typename In::Number& product) {
  product = tensor[0] * a[0] * b[0] + tensor[1] * a[1] * b[1] + tensor[2] * a[2] * b[2] +
            tensor[3] * (a[0] * b[1] + a[1] * b[0]) + tensor[4] * (a[1] * b[2] + a[2] * b[1]) +
            tensor[5] * (a[0] * b[2] + a[2] * b[0]);
}

/// Adds the elastic stress of a strain increment, and returns the stress to the surface.
template <class In>
[[gnu::always_inline]] inline void return_to(const Surface<In>& surface, const typename In::Number* strain,
                                             typename In::Number* stress, typename In::Number& plastic) {
  using Number = typename In::Number;
  add_stress<In>(surface.moduli, strain, stress);
  plastic = Number{};
  // A quick test: inside the cone inscribed in the six faces, and below a cone under the limit of tension.
  const Number mean = (stress[0] + stress[1] + stress[2]) / 3.0, x = stress[0] - mean, y = stress[1] - mean,
               z = stress[2] - mean;
  const Number j2 =
      0.5 * (x * x + y * y + z * z) + stress[3] * stress[3] + stress[4] * stress[4] + stress[5] * stress[5];
  const Number sine = 0.5 * (surface.up - surface.down), room = 0.5 * surface.k - mean * sine,
               below = surface.limit - mean;
  const typename In::Mask outside =
      (room < 0.0) | (below < 0.0) | (j2 * (1.0 + sine * sine / 3.0) > room * room) | (4.0 / 3.0 * j2 > below * below);
  if (!any(outside)) return;
  Across<In> across;
  if (!any((stress[4] != 0.0) | (stress[5] != 0.0))) {
    across = {stress[2], 0.5 * (stress[0] + stress[1]), 0.5 * (stress[0] - stress[1]), stress[3]};
    return_across<In>(surface, across, plastic);
    stress[0] = across.mean + across.half;
    stress[1] = across.mean - across.half;
    stress[2] = across.axis;
    stress[3] = across.shear;
    return;
  }
  Frame<In> frame;
  find_frame<In>(stress, frame);
  Number uu, vv;
  form<In>(stress, frame.u, frame.u, uu);
  form<In>(stress, frame.v, frame.v, vv);
  form<In>(stress, frame.u, frame.v, across.shear);
  across.axis = 3.0 * mean - uu - vv;
  across.mean = 0.5 * (uu + vv);
  across.half = 0.5 * (uu - vv);
  return_across<In>(surface, across, plastic);
  const typename In::Mask yields = plastic > 0.0;
  constexpr int first[6] = {0, 1, 2, 0, 1, 0}, second[6] = {0, 1, 2, 1, 2, 2};
  for (int c = 0; c < 6; ++c) {
    const int a = first[c], b = second[c];
    const Number returned = across.axis * frame.w[a] * frame.w[b] +
                            (across.mean + across.half) * frame.u[a] * frame.u[b] +
                            (across.mean - across.half) * frame.v[a] * frame.v[b] +
                            across.shear * (frame.u[a] * frame.v[b] + frame.v[a] * frame.u[b]);
    stress[c] = yields ? returned : stress[c];
  }
}

/// sin(x) for 0 <= x <= pi / 2, with an error of 1e-11, without a library call, for four particles at a time.
template <class In>
[[gnu::always_inline]] inline void sine(const typename In::Number& x, typename In::Number& result) {
  const typename In::Number square = x * x;
  result = x * (1.0 + square * (-1.0 / 6 +
                                square * (1.0 / 120 +
                                          square * (-1.0 / 5040 +
                                                    square * (1.0 / 362880 +
                                                              square * (-1.0 / 39916800 +
                                                                        square * (1.0 / 6227020800 -
                                                                                  square * (1.0 / 1307674368000))))))));
}

double radians(double degrees) { return degrees * std::numbers::pi / 180.0; }

}  // namespace

MohrCoulomb::MohrCoulomb(const Soil& soil)
    : elasticity_(soil),
      soil_(soil),
      friction_{radians(soil.friction_angle),
                radians(soil.residual_friction_angle.value_or(soil.friction_angle) - soil.friction_angle)},
      dilation_{radians(soil.dilation_angle),
                radians(soil.residual_dilation_angle.value_or(soil.dilation_angle) - soil.dilation_angle)},
      cohesion_{1.0,
                soil.residual_cohesion && soil.cohesion > 0.0 ? *soil.residual_cohesion / soil.cohesion - 1.0 : 0.0},
      sin_phi_(std::sin(friction_.from)),
      cos_phi_(std::cos(friction_.from)),
      sin_psi_(std::sin(dilation_.from)),
      softens_(friction_.by != 0.0 || dilation_.by != 0.0 || cohesion_.by != 0.0),
      residual_strain_(softens_ ? soil.softening_slip.value_or(0.0) / soil.band_width : 0.0),
      tensile_strength_(soil.tensile_strength.value_or(std::numeric_limits<double>::infinity())),
      largest_void_ratio_(soil.maximum_void_ratio.value_or(std::numeric_limits<double>::infinity())) {}

std::vector<StateVariable> MohrCoulomb::state_variables() const {
  if (!softens_) return {};
  return {{"plastic_shear_strain", "1", "that the strength falls with"}};
}

template <class In>
[[gnu::always_inline]] inline void MohrCoulomb::soften(const typename In::Number& saturation,
                                                       const typename In::Number* softened,
                                                       typename In::Number& cohesion,
                                                       typename In::Number& share) const {
  using Number = typename In::Number;
  cohesion_at<In>(soil_, saturation, cohesion);
  share = Number{};
  if (!softens_) return;
  share = *softened / residual_strain_;
  min_in_place(share, Number{} + 1.0);
  cohesion *= 1.0 + share * cohesion_.by;
}

template <class In>
[[gnu::always_inline]] inline void MohrCoulomb::follow(const typename In::Number& saturation,
                                                       const typename In::Number& void_ratio,
                                                       const typename In::Number* strain, typename In::Number* stress,
                                                       typename In::Number* softened,
                                                       typename In::Number& plastic) const {
  using Number = typename In::Number;
  const Number zero{};
  Number cohesion, share, sin_phi = zero + sin_phi_, cos_phi = zero + cos_phi_, sin_psi = zero + sin_psi_;
  soften<In>(saturation, softened, cohesion, share);
  if (softens_) {
    sine<In>(friction_.from + share * friction_.by, sin_phi);
    sine<In>(dilation_.from + share * dilation_.by, sin_psi);
    cos_phi = 1.0 - sin_phi * sin_phi;
    sqrt_in_place(cos_phi);
  }
  sin_psi = void_ratio < largest_void_ratio_ ? sin_psi : zero;
  Moduli<In> moduli;
  elasticity_.over(stress, strain, moduli);
  Surface<In> surface{1.0 + sin_phi, 1.0 - sin_phi, 2.0 * cos_phi * cohesion, 1.0 + sin_psi, 1.0 - sin_psi,
                      zero,          moduli};
  limit_tension(tensile_strength_, surface);
  return_to<In>(surface, strain, stress, plastic);
  if (softens_) *softened += std::numbers::sqrt3 * plastic;
}

double MohrCoulomb::advance(Tensor& stress, const Tensor& strain, const Condition& condition,
                            std::span<double> state) const {
  double plastic = 0.0;
  follow<InOnes>(condition.saturation, condition.void_ratio, strain.data(), stress.data(), state.data(), plastic);
  return plastic;
}

double MohrCoulomb::local_factor(const Tensor& stress, const Condition& condition,
                                 std::span<const double> state) const {
  double cohesion = 0.0, share = 0.0;
  soften<InOnes>(condition.saturation, state.data(), cohesion, share);
  const auto [largest, smallest] = extreme_stresses(stress);
  const double factor = factor_to_yield(coulomb, cohesion, std::tan(friction_.from + share * friction_.by),
                                        0.5 * (largest - smallest), -0.5 * (largest + smallest));
  return limit_by_tension(factor, soil_.tensile_strength.value_or(0.0), largest);
}

void MohrCoulomb::advance(std::span<Four> many) const {
  run_lanes([&]() __attribute__((always_inline)) {
    for (Four& four : many) {
      Lanes softened{};
      if (softens_) softened = four.state[0].v;
      follow<InFours>(four.saturation, four.void_ratio, four.strain, four.stress, &softened, four.plastic);
      if (softens_) four.state[0].v = softened;
    }
  });
}

}  // namespace poretwin::solid
