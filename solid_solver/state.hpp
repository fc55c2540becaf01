// All quantities of the soil skeleton that change in time, as plain arrays. Saving and restoring copies them all.
#pragma once

#include "common/core/archive.hpp"
#include "common/core/lanes.hpp"
#include "common/core/or_zero.hpp"
#include "common/core/vector.hpp"
#include "common/particles/particle_arrays.hpp"
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

/// Position and motion of a rigid plate (discretisation/plates.hpp).
template <int D>
struct PlateMotion {
  Vec<D> displacement = Vec<D>::Zero();  ///< m, since time zero
  Vec<D> velocity = Vec<D>::Zero();      ///< m/s
  Vec<D> reaction = Vec<D>::Zero();      ///< N (2D: N/m), force of the skeleton on the plate
  double water = 0.0;                    ///< N (2D: N/m), force of the pore pressure, against the normal
  double largest = 0.0;                  ///< N (2D: N/m), largest force between plate and soil so far
  double pull = 0.0;                     ///< N (2D: N/m), largest pull at the soil so far
  double pulls = 0.0;                    ///< counter: windows at whose end the plate pulled
  // Only of a plate that tilts; rotations and moments are about its middle, counter-clockwise.
  double angle = 0.0;         ///< rad, since time zero
  double spin = 0.0;          ///< rad/s
  double moment = 0.0;        ///< N m/m, of the skeleton on the plate
  double water_moment = 0.0;  ///< N m/m, of the pore pressure on the soil; minus that on the plate
  /// Of each part of its length, about a spacing long: the force [N/m] with which it presses on the soil along its
  /// present normal; and, where the plate lifts, whether it has come off (1), and the distance [m] of the nearest
  /// particles from the plate when it did.
  ScalarArray pressed;
  std::vector<char> apart;
  ScalarArray touched_at;
};

/// Which particles of the whole run this rank has, where several ranks share the soil (discretisation/ranks.hpp).
/// Checkpoints hold the soil of all ranks, so that nothing of it is stored.
struct RankShare {
  std::vector<GlobalId> ids;  ///< of this rank's particles, ascending; empty where one rank has all
  GlobalId first_held = 0;    ///< the fixed particles have the ids from here on
  std::size_t copies = 0;     ///< number of copies of other ranks' particles
  std::vector<char> at_rest;  ///< [copies] 1: the copy is of a fixed or a sleeping particle
  void archive(Archive&) {}
};

/// The real particles: first the particles that are free to move, then the fixed particles behind rough walls. Where
/// several ranks share the soil, these are the rank's own. In the arrays that the computation of neighbours and images
/// reads (position, displacement, velocity, mass, stress, plastic_strain and those of slip) the copies of other ranks'
/// particles stand behind them.
template <int D>
struct Particles {
  VecArray<D> position;                ///< m
  VecArray<D> displacement;            ///< m, since the unloaded state
  VecArray<D> velocity;                ///< m/s
  ScalarArray mass;                    ///< kg (2D: kg/m) of grains and residual water
  ScalarArray volume;                  ///< m^D, bulk volume V = m / (n_s rho_s)
  std::vector<Tensor> stress;          ///< Pa, effective, compression negative
  ScalarArray plastic_strain;          ///< accumulated equivalent deviatoric plastic strain
  std::vector<std::uint8_t> material;  ///< index of the soil
  ScalarArray material_state;          ///< state variables of the materials, one row per particle
  std::vector<float> rubbing;          ///< friction coefficient where grains are apart and only collide; otherwise 0
  VecArray<D> slip;     ///< m/s, slip of the soil along frictional walls (wall_friction.hpp); empty without such walls
  VecArray<D> slipped;  ///< m, displacement that corresponds to the wall slip
  /// N/m3, added to the body force in the slope of the stress at frictional walls (wall_friction.hpp).
  VecArray<D> wall_slope;
  std::vector<PlateMotion<D>> plates;  ///< rigid plates that press on the particles
  std::size_t held = 0;                ///< number of fixed particles; they come after the free ones
  RankShare share;
  [[nodiscard]] std::size_t size() const { return mass.size() - share.copies; }
  [[nodiscard]] std::size_t with_copies() const { return mass.size(); }
  /// State variables of a particle. All rows have the length that the soil with the most state variables needs.
  [[nodiscard]] std::span<double> state_of(std::size_t i) {
    const std::size_t each = material_state.size() / size();
    return {material_state.data() + i * each, each};
  }
  [[nodiscard]] std::span<const double> state_of(std::size_t i) const {
    const std::size_t each = material_state.size() / size();
    return {material_state.data() + i * each, each};
  }
  [[nodiscard]] std::size_t free() const { return size() - held; }  ///< particles free to move; they come first
};

/// The symmetric matrix whose upper triangle, diagonal included, is given by consecutive columns.
template <int D>
Mat<D> symmetric(const double* upper) {
  Mat<D> full;
  for (int b = 0; b < D; ++b)
    for (int a = 0; a <= b; ++a) full(a, b) = full(b, a) = *upper++;
  return full;
}

/// Size of an array for n numbers to which loops over four pairs add.
constexpr std::size_t room_for(std::size_t n) { return (n + 3) / 4 * 4; }

/// Data of a particle or an image that the pair loops read, packed four numbers to a register, since neighbours are
/// visited in scattered order. In 2D they take three cache lines of 64 bytes: the inputs of the velocity gradient, its
/// sums, and the further inputs of the forces. Gradients and the correction are stored only here. The other data are
/// copied from the particles before every evaluation of forces (fill_nodes).
template <int D>
struct alignas(64) Node {
  Vec<D> position = Vec<D>::Zero();
  Vec<D> velocity = Vec<D>::Zero();  ///< m/s
  double volume = 0.0;               ///< m^D
  double density = 0.0;              ///< kg/m3, rho_bar
  double hourglass_level = elastic;  ///< hourglass control level; a pair has the lower of its particles' levels
  double rubbing = 0.0;              ///< see Particles
  Mat<D> gradient = Mat<D>::Zero();  ///< 1/s, of the velocity, d v_a / d x_b
  std::array<double, room_for(D* D + D * (D + 1) / 2) - D * D> upper{};  ///< columns of the upper triangle of the
                                                                         ///< correction B
  Mat<D> flux = Mat<D>::Zero();         ///< sigma B [Pa]: the stress as it acts on the node's neighbours
  Mat<D> deformation = Mat<D>::Zero();  ///< 1, of the displacement, d u_a / d x_b
  /// Values of hourglass_level. flows: no control; yielded: control of velocities only; elastic: also of displacements.
  /// The excess over `yielded` is the largest strain to which the control of displacements responds with its full
  /// stiffness.
  static constexpr double flows = 0.0, yielded = 1.0, elastic = std::numeric_limits<double>::infinity();
  static constexpr std::size_t at_velocity = D, at_volume = 2 * D, at_density = 2 * D + 1,
                               at_hourglass_level = 2 * D + 2, at_rubbing = 2 * D + 3, at_gradient = 2 * D + 4,
                               at_correction = at_gradient + D * D, n_sums = room_for(D * D + D * (D + 1) / 2),
                               at_flux = at_gradient + n_sums, at_deformation = at_flux + D * D;
  [[nodiscard]] const double* row() const { return position.data(); }
  /// Sums of the velocity gradient's loop: the gradient, then the upper triangle of the moment matrix.
  [[nodiscard]] double* sums() { return gradient.data(); }
  /// Kernel-gradient correction B, symmetric; an image uses its parent's (see correction_at).
  [[nodiscard]] Mat<D> correction() const { return symmetric<D>(upper.data()); }
  void set_correction(const Mat<D>& full) {
    double* next = upper.data();
    for (int b = 0; b < D; ++b)
      for (int a = 0; a <= b; ++a) *next++ = full(a, b);
  }
};

/// Factor on the elastic moduli of a particle beside a free surface. The corrected gradients of such a particle are
/// long; its stiffness, which grows as |B|^2, would determine the substep of all soil (docs/theory/soil.md, "Soft
/// edges"). upper: upper triangle of B, of one particle (Number: double) or of four (Lanes).
template <int D, class Number>
[[gnu::always_inline]] inline void edge_stiffness(const Number* upper, Number& share) {
  Number squared{};
  for (int b = 0; b < D; ++b)
    for (int a = 0; a <= b; ++a, ++upper) squared += (a == b ? 1.0 : 2.0) * *upper * *upper;
  share = points::inside_correction * D / squared;
  min_in_place(share, Number{} + 1.0);
}

/// One of the walls behind which an image lies. At a fixed wall the acceleration is zero, at a roller its normal part.
/// Hence stress varies across the wall as d(sigma n)/dn = -b with the body force b, and the mirrored stress is
/// increased by 2 d (share b) n^T, with the parent's distance d from the wall. At a frictional wall b also contains the
/// stress's change along the wall, and the shear beyond Coulomb's limit is removed (fill_nodes, wall_friction.hpp).
template <int D>
struct Crossing {
  Vec<D> normal = Vec<D>::Zero();  ///< unit, into the soil
  double level = 0.0;              ///< normal . x [m] of the points x on the wall
  Mat<D> share = Mat<D>::Zero();   ///< part of the parent's body force that counts: the whole (fixed, frictional) or
                                   ///< its normal part (roller)
  double friction = std::numeric_limits<double>::infinity();  ///< Coulomb's friction coefficient; infinite at walls
                                                              ///< without slip
  Mat<D> bend = Mat<D>::Zero();  ///< 1/m, derivative of the normal along a curved wall (docs/theory/walls.md)
};

enum class BoundaryKind { roller, fixed, frictional, periodic };

/// A wall behind which an image lies, as seen from its parent when the lists were built.
template <int D>
struct Passed {
  BoundaryKind kind = BoundaryKind::roller;
  double friction = 0.0;                                       ///< Coulomb's coefficient, of frictional walls
  int plate = -1;                                              ///< number of the plate; -1: a wall at rest
  bool tilts = false;                                          ///< it is a plate that tilts; `point` is its middle
  Vec<D> normal = Vec<D>::Zero(), point = Vec<D>::Zero();      ///< unit, into the soil; a point of the wall [m]
  Mat<D> bend = Mat<D>::Zero(), stretch = Mat<D>::Identity();  ///< see Surfaces::WallPoint
  Vec<D> from = Vec<D>::Zero();                                ///< m, place of the parent; set where the wall is curved
};

/// The walls behind which an image lies, at least one of them curved: its normal turns as the parent moves.
template <int D>
struct BehindCurved {
  Index image = 0;
  std::size_t size = 0;
  std::array<Passed<D>, D> walls{};
};

/// The walls behind which an image lies, in the order of its reflections, at least one of them a plate that tilts.
template <int D>
struct BehindTilting {
  Index image = 0;
  Index first = 0;  ///< the first of the image's entries among those of BehindPlate
  std::vector<Passed<D>> walls;
};

/// How an image follows its parent, with the maps below: x' = map x + shift; v' = velocity v + slip s with the parent's
/// wall slip s along frictional walls; (sigma B)' = velocity (sigma B) map^T.
template <int D>
struct ImageRule {
  Index parent = 0;  ///< a real particle or a copy
  Mat<D> map = Mat<D>::Identity();
  Vec<D> shift = Vec<D>::Zero();
  Mat<D> velocity = Mat<D>::Identity();
  Mat<D> slip = Mat<D>::Zero();
  bool slips = false;               ///< one of the walls passed is frictional
  bool moves = false;               ///< one of the walls passed is a plate
  Vec<D> carried = Vec<D>::Zero();  ///< m/s, part of the image's velocity that is due to the motion of plates
  std::array<Crossing<D>, D> crossings{};
  std::size_t n_crossings = 0;
  bool curved = false;                   ///< one of the walls passed is curved
  double swelling = 1.0;                 ///< volume of the image over that of its parent
  bool periodic = false;                 ///< the image lies only beyond periodic sides: it has its parent's scalars
  Vec<D> displacement = Vec<D>::Zero();  ///< m, of the image; updated together with its node
  /// Velocity [m/s] or displacement [m] of the image. v: that of its parent; s: the slips of all particles.
  [[nodiscard]] Vec<D> moved(const Vec<D>& v, const VecArray<D>& s) const {
    return slips ? Vec<D>(velocity * v + slip * s[parent]) : Vec<D>(velocity * v);
  }
};

/// How a plate moves an image behind it (and possibly behind other walls). An image with the velocity v has v +
/// velocity V for the plate's velocity V; likewise for the displacement. With the plate's displacement U the image lies
/// farther by place U. Where one of the plates tilts (`turns`), both change with its angle, and the image's velocity
/// also contains its spin times the vector `spin` (turn_images).
template <int D>
struct BehindPlate {
  Index image = 0, plate = 0;
  std::uint32_t crossing = 0;  ///< number of the plate among the image's crossings
  bool first = true;           ///< the first plate of this image
  Mat<D> velocity = Mat<D>::Zero(), place = Mat<D>::Zero();
  Vec<D> shift = Vec<D>::Zero();  ///< m, shift of the image before the plates moved
  double level = 0.0;             ///< m, level of the crossing before the plate moved
  bool turns = false;
  Vec<D> spin = Vec<D>::Zero();  ///< m
};

/// Pairs of particles with images behind one plate. The plate's force on the soil is the sum over its lists.
struct PlatePairs {
  Index plate = 0;
  /// Numbers of the plates that bear half of the forces along the plate each; -1: a wall. The part along its normal the
  /// plate bears itself.
  std::array<int, 2> along{};
  [[nodiscard]] bool bears_all() const { return along == std::array{static_cast<int>(plate), static_cast<int>(plate)}; }
  Pairs pairs;
};

/// Pairs of real particles, copies of other ranks' particles, and images within range of each other. They are valid
/// while displacements are below half the skin.
template <int D>
struct Neighbourhood {
  /// Positions of the real particles when the lists were built [m]. In single precision they are exact to 0.006
  /// spacings over an extent of 1e5 spacings.
  std::vector<Eigen::Matrix<float, D, 1>> built_at;
  Vec<D> lower = Vec<D>::Zero(), upper = Vec<D>::Zero();  ///< m, bounding box of the particles when built
  std::vector<ImageRule<D>> images;
  std::vector<BehindCurved<D>> behind_curved;
  std::vector<BehindPlate<D>> behind_plates;
  std::vector<BehindTilting<D>> behind_tilting;
  std::vector<PlateMotion<D>> plates_at;  ///< the plates when the lists were built
  std::vector<PlatePairs> plate_pairs;
  Pairs pairs;
  Views views;
};

/// The water's action on the soil in a window.
template <int D>
struct External {
  OrZero<double> pressure, coverage;  ///< pore pressure [Pa]; fraction of each particle covered by water
  OrZero<double> saturation;          ///< degree of saturation s_r
  OrZero<double> basin_level;         ///< m, of the basin behind the nearest face with one (water as a field)
  OrZero<double> spreading;           ///< 1/s, expansion that evens out the points of soil and water; not a strain
  OrZero<Vec<D>> pressure_gradient;   ///< Pa/m, SPH form of Eq. (62) or (61), at the end of the last window
  OrZero<Vec<D>> force;               ///< N/m3, force of pressure and drag on the skeleton, at the end of the last
                                      ///< window
};

/// What free water has eroded so far (erosion/erosion.hpp). The arrays are empty where no soil erodes.
struct Eroded {
  ScalarArray share;                ///< share of its volume that each particle has lost; at 1 it leaves
  ScalarArray shear_stress;         ///< Pa, of the water at each particle in the last window
  std::vector<Index> first_number;  ///< number that each particle had at time zero
  double grains = 0.0;              ///< m^D, volume of the grains that have been carried off
  double particles = 0.0;           ///< counter: particles that have been carried off
};

/// Sleep of the soil as a whole: particles do not move. The members are the values when the soil fell asleep.
template <int D>
struct Sleep {
  bool asleep = false;
  OrZero<Vec<D>> force;  ///< N on each particle, from the water
  OrZero<double> saturation;
  std::size_t loads = 0;  ///< number of loads that had begun
};

/// Regions at rest around flowing soil (regions.hpp). The arrays have one value per free particle. They are empty until
/// soil has flowed.
template <int D>
struct Regions {
  double clock = 0.0;                ///< s, sum of the steps taken
  double last_activity_check = 0.0;  ///< clock at the last search for particles that move
  double last_sleep_check = 0.0;     ///< clock at the last search for particles that may fall asleep
  ScalarArray last_active;           ///< clock when the particle last moved or yielded
  VecArray<D> mark;     ///< m, displacement when the particle last moved or yielded; asleep: N, force of its neighbours
                        ///< when it fell asleep
  VecArray<D> outside;  ///< N, force from outside when the particle fell asleep
  ScalarArray sheared;  ///< plastic strain when the particle last moved or yielded
  OrZero<double> saturation;          ///< degree of saturation when the particle fell asleep
  std::vector<char> calm, asleep;     ///< 1 or 0; `asleep` is empty while nothing sleeps
  double watched = 0.0, slept = 0.0;  ///< counters: s times particles watched; s times particles asleep
  [[nodiscard]] bool sleeps(std::size_t i) const { return i < asleep.size() && asleep[i] != 0; }
  [[nodiscard]] bool is_calm(std::size_t i) const { return !calm.empty() && calm[i] != 0; }
};

/// Whether a coupled soil moves. If it does, every elastic wave is resolved; otherwise long windows are computed as
/// equilibria. Waves in soil that stands are damped out. Soil that slides is soft, and its damping decreases
/// (Rayleigh's quotient).
struct Motion {
  bool moving = false;
  double calm = 0.0;      ///< s, time for which the soil has hardly moved
  double patience = 0.0;  ///< s of calm after which an equilibrium is searched for again; doubles each time that the
                          ///< soil begins to move, until one is found
  double relaxed = 0.0, at_rest = 0.0, steps = 0.0,
         begun = 0.0;     ///< counters: windows with and without a search that moved the soil, trial displacements,
                          ///< times that the soil began to move
  double duration = 0.0;  ///< s, time in motion so far
  double longest = std::numeric_limits<double>::infinity();  ///< s, longest window for which an equilibrium is searched
                                                             ///< for
  double held = 0.0;      ///< counter: windows in which a force borne by neither phase kept the soil at the prediction
  double in_a_row = 0.0;  ///< successive windows with such a force up to now
  void begins(double long_window) {
    moving = true;
    calm = 0.0;
    patience = std::clamp(steps::patience_grows * patience, steps::least_patience * long_window,
                          steps::most_patience * long_window);
    begun += 1.0;
  }
  /// Called after a window that is not repeated. noticeable: whether the force borne by neither phase was noticeable in
  /// this window. Such a force is usual in a few windows where the soil's motion changes suddenly, as under a load that
  /// begins.
  void held_by_nothing(bool noticeable) {
    in_a_row = noticeable ? in_a_row + 1.0 : 0.0;
    if (in_a_row > steps::few_held) held += 1.0;
  }
  /// Called after a window in motion; returns whether the motion is over.
  bool calms(double interval, bool hardly_moved) {
    duration += interval;
    calm = hardly_moved ? calm + interval : 0.0;
    moving = calm < patience;
    return !moving;
  }
};

/// Sums of n numbers over pairs, in the form to which loops over four pairs add.
template <std::size_t n>
struct alignas(32) Sums {
  static constexpr std::size_t size = room_for(n);
  std::array<double, size> x{};
};

/// Forces on a particle per volume [N/m3], in the form to which the loop over pairs adds.
template <int D>
struct Force {
  Sums<2 * D> sum;
  /// div sigma' (adjoint form).
  [[nodiscard]] Vec<D> internal() const { return Eigen::Map<const Vec<D>>(sum.x.data()); }
  /// Hourglass control and artificial viscosity.
  [[nodiscard]] Vec<D> stabilising() const { return Eigen::Map<const Vec<D>>(sum.x.data() + D); }
  void add_stabilising(const Vec<D>& f) { Eigen::Map<Vec<D>>(sum.x.data() + D) += f; }
};

/// W'/r of every stored pair [1/m^(D+2)], in single precision. All loops use the same numbers, so that gradients stay
/// exact for linear fields, and forces are their exact adjoint.
using Kernels = std::vector<float>;

/// Data of a particle or an image that keep_flow_regular uses, packed.
template <int D>
struct alignas(32) Grain {
  Vec<D> position = Vec<D>::Zero();
  double volume = 0.0, mass = 0.0;
  double shown = 0.0;    ///< volume in sums over stresses: 0 for images behind walls, where the stress is unknown
  double swollen = 0.0;  ///< volume over mass
  double flows = 0.0;    ///< see Scratch
  Eigen::Matrix<double, D == 2 ? 4 : 6, 1> stress = Eigen::Matrix < double, D == 2 ? 4 : 6, 1 > ::Zero();
  Eigen::Matrix<double, D == 2 ? 4 : 6, D> slope = Eigen::Matrix < double, D == 2 ? 4 : 6, D > ::Zero();
  static constexpr std::size_t at_volume = D, at_mass = D + 1, at_shown = D + 2, at_swollen = D + 3, at_flows = D + 4,
                               at_stress = 8, at_slope = at_stress + (D == 2 ? 4 : 6);
  [[nodiscard]] const double* row() const { return position.data(); }
};

/// Indices of keep_flow_regular's kernel sums; the sums of the stress come first.
template <int D>
struct Around {
  static constexpr std::size_t at_swelling = D == 2 ? 4 : 6, at_cover = at_swelling + 1, at_crowding = at_cover + 1,
                               size = at_crowding + D;
};

/// Memory that the loops reuse from step to step. It contains nothing between steps, so that a copy starts empty.
template <int D>
struct Scratch {
  std::vector<Quad> sums;     ///< of the loop over pairs that is running
  ScalarArray touches;        ///< for slide_on_walls: 1 where a particle or a copy touches a wall
  ScalarArray yielded_since;  ///< for keep_flow_regular: plastic strain since its last correction
  ScalarArray flows;          ///< for keep_flow_regular: 1 where soil flows; where it yielded a little, minus the
                              ///< stress [Pa] that may be evened out. grains: also for keep_flow_regular
  std::vector<Grain<D>> grains;
  /// n sums for each of `count` particles, set to zero. They are valid until the next call.
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
  double last_interval = 0.0;  ///< s, of the last window; 0 before the first window
  std::uint64_t revision = 1;
  Particles<D> particles;
  Neighbourhood<D> near;
  std::vector<Node<D>> nodes;   ///< of the real particles, then of the copies, then of the images
  Kernels kernel;               ///< at the current positions
  VecArray<D> body;             ///< N/m3, distributed forces that act at present (weight, water), without tractions
  std::vector<Force<D>> force;  ///< of the current state; zero on fixed particles
  OrZero<double> backing;       ///< Pa, isotropic stress that acts in the forces in addition to the effective stress
  External<D> external;
  OrZero<Vec<D>> mean_velocity;      ///< m/s, over the last window, of coupled soil
  OrZero<double> dilation;           ///< volumetric strain of the last window, of coupled soil
  OrZero<Vec<D>> returned_impulse;   ///< N s, of the last window
  Vec<D> received = Vec<D>::Zero();  ///< N s, received from the water in all windows, without the impulse returned in
                                     ///< the last window
  Vec<D> from_outside = Vec<D>::Zero();  ///< N s, of weight, loads and walls; summed only where a gauge needs it
  OrZero<Vec<D>> rest_displacement;      ///< m, displacement after initialise(), from which uplift is measured
  std::vector<char> yielded;             ///< 1 where a particle yielded in the last window
  OrZero<double> plastic_shear_ratio;    ///< plastic over total shear strain of the last window, of coupled soil
  bool any_yielded = false;
  Sleep<D> sleep;
  Regions<D> regions;
  Motion motion;
  Eroded erosion;
  ScalarArray resistance;     ///< N/m, resistance added by the window for which the stiffness was last factorised
  bool still_yields = false;  ///< soil has yielded since it was last quiet: its motion must not be damped
  double since_upkeep = 0.0;  ///< s, since the last correction by keep_flow_regular
  std::vector<float> evened;  ///< plastic strain at keep_flow_regular's last correction; empty while no soil has any
  Scratch<D> scratch;
  double substeps = 0.0, rebuilds = 0.0, slept = 0.0, damped = 0.0;  ///< counters: substeps (computed, asleep, damped),
                                                                     ///< list rebuilds
};

}  // namespace poretwin::solid
