// Everything of the soil skeleton that changes in time, as plain arrays: copied whole to save and restore.
#pragma once

#include "common/core/archive.hpp"
#include "common/core/lanes.hpp"
#include "common/core/or_zero.hpp"
#include "common/core/vector.hpp"
#include "solid_solver/discretisation/pairs.hpp"
#include "solid_solver/material/stress.hpp"
#include "solid_solver/numerics/points.hpp"
#include "solid_solver/numerics/steps.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <span>
#include <vector>

namespace poretwin::solid {

/// The real particles: those of the soil, then those that rough walls hold still.
template <int D>
struct Particles {
  VecArray<D> position;                ///< m
  VecArray<D> displacement;            ///< m, since the unloaded lattice
  VecArray<D> velocity;                ///< m/s
  ScalarArray mass;                    ///< kg (per metre in 2D) of solid matter
  ScalarArray volume;                  ///< m^D, bulk volume V = m / (n_s rho_s)
  std::vector<Tensor> stress;          ///< Pa, effective, compression negative
  ScalarArray plastic_strain;          ///< accumulated equivalent deviatoric plastic strain
  std::vector<std::uint8_t> material;  ///< index of the soil
  ScalarArray material_state;          ///< what materials remember of each particle, one row after the other
  std::vector<float> rubbing;          ///< friction coefficient where grains are apart and only collide, 0 elsewhere
  VecArray<D> slip;      ///< m/s, of the soil along frictional walls (wall_friction.hpp); empty without such
  VecArray<D> slipped;   ///< m, displacement that goes with it
  /// N/m3, at frictional walls: added to the body force in the slope of the stress there (wall_friction.hpp).
  VecArray<D> wall_slope;
  std::size_t held = 0;  ///< how many, at the end, are held
  [[nodiscard]] std::size_t size() const { return mass.size(); }
  /// What its material remembers of a particle; rows are as long as the soil with most to remember needs.
  [[nodiscard]] std::span<double> state_of(std::size_t i) {
    const std::size_t each = material_state.size() / size();
    return {material_state.data() + i * each, each};
  }
  [[nodiscard]] std::span<const double> state_of(std::size_t i) const {
    const std::size_t each = material_state.size() / size();
    return {material_state.data() + i * each, each};
  }
  [[nodiscard]] std::size_t free() const { return mass.size() - held; }  ///< how many, at the front, are free to move
};

/// The symmetric matrix whose columns, to the diagonal, stand one after the other.
template <int D>
Mat<D> symmetric(const double* upper) {
  Mat<D> full;
  for (int b = 0; b < D; ++b)
    for (int a = 0; a <= b; ++a) full(a, b) = full(b, a) = *upper++;
  return full;
}

/// Room for n numbers that loops over four pairs add to.
constexpr std::size_t room_for(std::size_t n) { return (n + 3) / 4 * 4; }

/// What the pair loops read of a particle or an image, packed, four numbers to a register: neighbours are visited in
/// scattered order. In 2D these are three lines of 64 bytes: what the velocity gradient needs, what it sums up, and
/// what forces need besides. Gradients and the correction are stored nowhere else; the rest is copied from the
/// particles before every evaluation of forces (fill_nodes).
template <int D>
struct alignas(64) Node {
  Vec<D> position = Vec<D>::Zero();
  Vec<D> velocity = Vec<D>::Zero();  ///< m/s
  double volume = 0.0;               ///< m^D
  double density = 0.0;              ///< kg/m3, rho_bar
  double hourglass_level = elastic;  ///< hourglass control level, of a pair the lower of its two particles'
  double rubbing = 0.0;              ///< see Particles
  Mat<D> gradient = Mat<D>::Zero();  ///< 1/s, of the velocity, d v_a / d x_b
  std::array<double, room_for(D* D + D * (D + 1) / 2) - D * D> upper{};  ///< columns of B (correction), to the diagonal
  Mat<D> flux = Mat<D>::Zero();         ///< sigma B [Pa]: the stress as it acts on its neighbours
  Mat<D> deformation = Mat<D>::Zero();  ///< 1, of the displacement, d u_a / d x_b
  /// Values of hourglass_level: no control; of velocities; of displacements, too. What it is above `yielded` is the
  /// largest strain that the control of displacements answers with its full stiffness.
  static constexpr double flows = 0.0, yielded = 1.0, elastic = std::numeric_limits<double>::infinity();
  static constexpr std::size_t at_velocity = D, at_volume = 2 * D, at_density = 2 * D + 1,
                               at_hourglass_level = 2 * D + 2, at_rubbing = 2 * D + 3, at_gradient = 2 * D + 4,
                               at_correction = at_gradient + D * D, n_sums = room_for(D * D + D * (D + 1) / 2),
                               at_flux = at_gradient + n_sums, at_deformation = at_flux + D * D;
  [[nodiscard]] const double* row() const { return position.data(); }
  /// Where the gradient's loop sums up: the gradient, then the upper half of the moments' matrix.
  [[nodiscard]] double* sums() { return gradient.data(); }
  /// Kernel-gradient correction B, symmetric; of images that of their parents (correction_at).
  [[nodiscard]] Mat<D> correction() const { return symmetric<D>(upper.data()); }
  void set_correction(const Mat<D>& full) {
    double* next = upper.data();
    for (int b = 0; b < D; ++b)
      for (int a = 0; a <= b; ++a) *next++ = full(a, b);
  }
};

/// Share of its elastic moduli that a particle keeps beside a free surface, whose corrected gradients are long: their
/// stiffness, which goes as |B|^2, would set the substep of all soil (docs/theory/soil.md, "Soft edges"). From the
/// upper half of B; of one particle or of four (Number: double or Lanes).
template <int D, class Number>
[[gnu::always_inline]] inline void edge_stiffness(const Number* upper, Number& share) {
  Number squared{};
  for (int b = 0; b < D; ++b)
    for (int a = 0; a <= b; ++a, ++upper) squared += (a == b ? 1.0 : 2.0) * *upper * *upper;
  share = points::inside_correction * D / squared;
  min_in_place(share, Number{} + 1.0);
}

/// One wall that an image lies behind. Acceleration vanishes at a wall (its normal part at a roller), hence stress
/// varies across it as d(sigma n)/dn = -b with the body force b: the mirrored stress gets 2 d (share b) n^T.
template <int D>
struct Crossing {
  Vec<D> normal = Vec<D>::Zero();  ///< unit, into the soil
  double level = 0.0;              ///< normal . point of the wall [m]
  Mat<D> share = Mat<D>::Zero();   ///< of the parent's body force: all of it (fixed) or its normal part (roller)
  double friction = std::numeric_limits<double>::infinity();  ///< Coulomb's coefficient; infinite where nothing slips
};

/// How one image follows its parent: x' = map x + shift, v' = velocity v + slip s with the parent's slip s along
/// frictional walls, (sigma B)' = velocity (sigma B) map^T.
template <int D>
struct ImageRule {
  Index parent = 0;
  Mat<D> map = Mat<D>::Identity();
  Vec<D> shift = Vec<D>::Zero();
  Mat<D> velocity = Mat<D>::Identity();
  Mat<D> slip = Mat<D>::Zero();
  bool slips = false;  ///< some wall passed is frictional
  std::array<Crossing<D>, D> crossings{};
  std::size_t n_crossings = 0;
  bool periodic = false;                 ///< the domain truly goes on: scalars carry over unchanged
  Vec<D> displacement = Vec<D>::Zero();  ///< m, of the image; updated with its node
  /// Velocity [m/s] or displacement [m] of the image, with that of the slip.
  [[nodiscard]] Vec<D> moved(const Vec<D>& v, const VecArray<D>& s) const {
    return slips ? Vec<D>(velocity * v + slip * s[parent]) : Vec<D>(velocity * v);
  }
};

/// Who is near whom: real particles and images. Survives displacements below half the skin.
template <int D>
struct Neighbourhood {
  /// Positions of the real particles when built [m]; in floats, of which 1e5 spacings of extent lose 0.006 spacings.
  std::vector<Eigen::Matrix<float, D, 1>> built_at;
  Vec<D> lower = Vec<D>::Zero(), upper = Vec<D>::Zero();  ///< m, the box they filled
  std::vector<ImageRule<D>> images;
  Pairs pairs;
};

/// Water and loads as they act during a window.
template <int D>
struct External {
  OrZero<double> pressure, coverage;  ///< Pa; 0..1
  OrZero<double> saturation;          ///< degree of saturation s_r
  OrZero<Vec<D>> pressure_gradient;   ///< Pa/m, SPH form of Eq. (62) (or (61)), at the end of the last window
  OrZero<Vec<D>> force;               ///< N/m3 on the skeleton, of pressure and drag, at the end of the last window
};

/// While the soil sleeps its particles stand still; what acted on it when it fell asleep.
template <int D>
struct Sleep {
  bool asleep = false;
  OrZero<Vec<D>> force;  ///< N on each particle, from the water
  OrZero<double> saturation;
  std::size_t loads = 0;  ///< that had begun
};

/// Regions at rest around soil that flows (regions.hpp); arrays of the free particles, empty before any soil has
/// flowed.
template <int D>
struct Regions {
  double clock = 0.0;                ///< s, of the steps taken
  double last_activity_check = 0.0;  ///< clock at the last search for particles that move
  double last_sleep_check = 0.0;     ///< clock at the last search for particles that may fall asleep
  ScalarArray last_active;           ///< clock when a particle last moved or yielded
  VecArray<D> mark;     ///< m, its displacement then; while it sleeps: N, its neighbours' force when it fell asleep
  VecArray<D> outside;  ///< N, force from outside when it fell asleep
  ScalarArray sheared;  ///< its plastic strain then
  OrZero<double> saturation;          ///< when it fell asleep
  std::vector<char> calm, asleep;     ///< 1 or 0; no `asleep` while nothing sleeps
  double watched = 0.0, slept = 0.0;  ///< counters: s times particles, looked at and asleep of these
  [[nodiscard]] bool sleeps(std::size_t i) const { return i < asleep.size() && asleep[i] != 0; }
  [[nodiscard]] bool is_calm(std::size_t i) const { return !calm.empty() && calm[i] != 0; }
};

/// Whether a coupled soil moves: then every elastic wave is followed; otherwise long windows are taken as equilibria.
/// Waves in soil that stands are damped out; soil that slides is soft, and its damping fades (Rayleigh's quotient).
struct Motion {
  bool moving = false;
  double calm = 0.0;      ///< s, for how long it has hardly moved
  double patience = 0.0;  ///< s of calm after which rest is sought again; doubled when none is found then
  double relaxed = 0.0, at_rest = 0.0, steps = 0.0,
         begun = 0.0;     ///< counters: windows, displacements and steps of the searches, beginnings
  double duration = 0.0;  ///< s, in motion so far
  double longest = std::numeric_limits<double>::infinity();  ///< s, window in which an equilibrium is looked for
  double held = 0.0;      ///< counter: windows in which a force held the soil that neither phase bears
  double in_a_row = 0.0;  ///< windows with such a force up to now
  void begins(double long_window) {
    moving = true;
    calm = 0.0;
    patience = std::clamp(steps::patience_grows * patience, steps::least_patience * long_window,
                          steps::most_patience * long_window);
    begun += 1.0;
  }
  /// After a window that is not repeated; whether that force was noticeable. A few windows hold the soil where its
  /// motion changes suddenly, as under a load that begins.
  void held_by_nothing(bool noticeable) {
    in_a_row = noticeable ? in_a_row + 1.0 : 0.0;
    if (in_a_row > steps::few_held) held += 1.0;
  }
  /// After a window in motion: whether it is over.
  bool calms(double interval, bool hardly_moved) {
    duration += interval;
    calm = hardly_moved ? calm + interval : 0.0;
    moving = calm < patience;
    return !moving;
  }
};

/// Sums over pairs of n numbers, as the loops over four pairs add to them.
template <std::size_t n>
struct alignas(32) Sums {
  static constexpr std::size_t size = room_for(n);
  std::array<double, size> x{};
};

/// Forces on a particle per volume [N/m3], as the loop over pairs adds to them.
template <int D>
struct Force {
  Sums<2 * D> sum;
  /// div sigma' (adjoint form).
  [[nodiscard]] Vec<D> internal() const { return Eigen::Map<const Vec<D>>(sum.x.data()); }
  /// Zero-energy-mode control and artificial viscosity.
  [[nodiscard]] Vec<D> stabilising() const { return Eigen::Map<const Vec<D>>(sum.x.data() + D); }
  void add_stabilising(const Vec<D>& f) { Eigen::Map<Vec<D>>(sum.x.data() + D) += f; }
};

/// W'/r of every stored pair [1/m^(D+2)], rounded to floats: all loops see the same numbers, so that gradients stay
/// exact for linear fields and forces their adjoint.
using Kernels = std::vector<float>;

/// What keep_flow_regular reads of a particle or an image, packed.
template <int D>
struct alignas(32) Grain {
  Vec<D> position = Vec<D>::Zero();
  double volume = 0.0, mass = 0.0;
  double shown = 0.0;    ///< the volume where the stress may be read, 0 behind walls
  double swollen = 0.0;  ///< volume over mass
  double flows = 0.0;    ///< see Scratch
  Eigen::Matrix<double, D == 2 ? 4 : 6, 1> stress = Eigen::Matrix < double, D == 2 ? 4 : 6, 1 > ::Zero();
  Eigen::Matrix<double, D == 2 ? 4 : 6, D> slope = Eigen::Matrix < double, D == 2 ? 4 : 6, D > ::Zero();
  static constexpr std::size_t at_volume = D, at_mass = D + 1, at_shown = D + 2, at_swollen = D + 3, at_flows = D + 4,
                               at_stress = 8, at_slope = at_stress + (D == 2 ? 4 : 6);
  [[nodiscard]] const double* row() const { return position.data(); }
};

/// Where the kernel sums of keep_flow_regular stand; the stress's come first.
template <int D>
struct Around {
  static constexpr std::size_t at_swelling = D == 2 ? 4 : 6, at_cover = at_swelling + 1, at_crowding = at_cover + 1,
                               size = at_crowding + D;
};

/// Memory that the loops reuse from step to step; it holds nothing between them, so that a copy starts empty.
template <int D>
struct Scratch {
  std::vector<Quad> sums;     ///< of whichever loop over pairs is at it
  std::vector<char> touches;  ///< slide_on_walls
  ScalarArray flows;          ///< keep_flow_regular, as all below: 1 where soil flows; where it yielded a little minus
                              ///< the stress [Pa] that may be evened out
  std::vector<Grain<D>> grains;
  /// n numbers of every one of `count` particles, all zero, until the next loop asks for its own.
  template <std::size_t n>
  Sums<n>* zero_sums(std::size_t count) {
    sums.assign(count * (Sums<n>::size / n_lanes), Quad{});
    return reinterpret_cast<Sums<n>*>(sums.data());
  }
  Scratch() = default;
  Scratch(const Scratch&) {}
  Scratch(Scratch&&) = default;
  Scratch& operator=(const Scratch&) { return *this; }
  Scratch& operator=(Scratch&&) = default;
  ~Scratch() = default;
  void archive(Archive&) {}
};

template <int D>
struct State {
  double time = 0.0;           ///< s
  double last_interval = 0.0;  ///< s, of the last window; 0 before the first
  std::uint64_t revision = 1;
  Particles<D> particles;
  Neighbourhood<D> near;
  std::vector<Node<D>> nodes;   ///< real particles, then images
  Kernels kernel;               ///< at the current positions
  VecArray<D> body;             ///< N/m3, all distributed forces that act now: weight, water; not tractions
  std::vector<Force<D>> force;  ///< of the current state; zero on held particles
  OrZero<double> backing;       ///< Pa, even in all directions, which the forces count beside the effective stress
  External<D> external;
  OrZero<Vec<D>> mean_velocity;      ///< m/s over the last window, of coupled soil
  OrZero<double> dilation;           ///< volumetric strain by motion in the last window, of coupled soil
  OrZero<Vec<D>> returned_impulse;   ///< N s, last window
  Vec<D> received = Vec<D>::Zero();  ///< N s, from the water in all windows but for what is returned of the last one
  Vec<D> from_outside = Vec<D>::Zero();  ///< N s, of weight, loads and walls; where a gauge asks for it
  OrZero<Vec<D>> rest_displacement;      ///< m, after initialise: where uplift counts from
  std::vector<char> yielded;             ///< during the last window
  OrZero<double> plastic_shear_ratio;    ///< plastic over all shear strain of the last window, of coupled soil
  bool any_yielded = false;
  Sleep<D> sleep;
  Regions<D> regions;
  Motion motion;
  ScalarArray resistance;     ///< N/m, added by a window, with which the stiffness was last factorised
  bool still_yields = false;  ///< something yielded since the soil was last quiet: its motion must not be damped
  double since_upkeep = 0.0;  ///< s, since the flowing soil was last kept regular
  std::vector<float> evened;  ///< plastic strain then; empty while none of the soil has any
  Scratch<D> scratch;
  double substeps = 0.0, rebuilds = 0.0, slept = 0.0, damped = 0.0;  ///< counters of substeps and list rebuilds
};

}  // namespace poretwin::solid
