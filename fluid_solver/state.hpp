// All quantities of the fluid that change in time, as one value, so that a copy saves them.
#pragma once

#include "common/core/or_zero.hpp"
#include "common/particles/particle_arrays.hpp"
#include "fluid_solver/boundary/faces.hpp"
#include "fluid_solver/boundary/inlet.hpp"
#include "fluid_solver/boundary/water_boundary.hpp"
#include "fluid_solver/discretisation/free_surface.hpp"
#include "fluid_solver/setup.hpp"
#include "fluid_solver/time_limit.hpp"

namespace poretwin::fluid {

/// Which particles of the whole run this rank has, where several ranks share the water (discretisation/ranks.hpp).
/// Checkpoints hold the water of all ranks, so that nothing of it is stored.
struct RankShare {
  std::vector<GlobalId> ids;  ///< of this rank's particles, ascending; empty where one rank has all
  GlobalId next = 0;          ///< id of the particle that is born next
  void archive(Archive&) {}
};

/// The real particles. Where several ranks share the water, these are the rank's own.
template <int D>
struct Particles {
  VecArray<D> position;             ///< m
  VecArray<D> velocity;             ///< m/s
  ScalarArray mass;                 ///< kg
  ScalarArray void_fraction;        ///< n
  ScalarArray volume;               ///< bulk volume V = m / (n rho), m^D
  ScalarArray pressure;             ///< piezometric pressure, Pa
  OrZero<Vec<D>> solid_velocity;    ///< predicted velocity v_s' of the skeleton, m/s
  OrZero<Vec<D>> solid_change;      ///< change of solid_velocity in the window, v_s' - v_s, m/s
  OrZero<Vec<D>> drag_impulse;      ///< drag impulse on the soil in the last window, N s
  OrZero<double> surface_share;     ///< 1: in moving soil, beside its free surface
  OrZero<double> spreading;         ///< 1/s, expansion that repairs the packing and displaces the soil with the water
  OrZero<Vec<D>> surface_gradient;  ///< gradient of the total pressure at the soil's free surface, Pa/m
  /// Force of pressure and drag on the soil at the end of the last window, N/m3
  OrZero<Vec<D>> coupling_force;
  /// coupling_force one window earlier: in the parallel scheme the soil has received only this earlier force.
  OrZero<Vec<D>> previous_coupling_force;
  /// Fraction of a departure of the skeleton from its predicted velocity that the water follows through drag, in the
  /// last window: C / (a + C), with the drag coefficient C and the water's inertia a = n rho_w / Dt [N s/m4].
  OrZero<double> entrained_fraction;
  ScalarArray wave_speed;  ///< m/s, of long waves on the body of water to which the particle first belonged, or of a
                           ///< drop in its central force
  ScalarArray mask;        ///< soil membership
  std::vector<char> goes_with_soil;  ///< 1: came with soil that can leave its place together with its faces; 0: can
                                     ///< become free water
  std::vector<char> in_seepage;      ///< 1: in the seepage regime; 0: moves and has a surface as free water does
  /// 1 + index of the soil in which the particle was when its pressure and velocity were computed; 0: in no soil, or
  /// new. Used where the soil is at rest and has several conductivities.
  OrZero<int> soil;
  OrZero<int> closed_body;     ///< number from 1 of the particle's body of water if only walls surround this body; else
                               ///< 0
  OrZero<double> void_volume;  ///< m^D, volume of voids in the water, opened by cavitation
  /// Motion of the soil that is not yet applied to the water's volume. deferred_motion [m]: beyond the predicted
  /// motion, times the fraction of the mixture's volume that moved with it. unseen_strain: strain that the solid
  /// reports beyond the divergence of its mapped velocity; unseen_rate [1/s]: rate at which unseen_strain is being
  /// applied.
  OrZero<Vec<D>> deferred_motion;
  OrZero<double> unseen_strain, unseen_rate;
  VecArray<D> birthplace;  ///< m, where the particle was born: a particle that has not moved since needs no repair of
                           ///< its packing
  ScalarArray row;         ///< thickness, in spacings, of the row of surface particles in which it lies
  std::vector<Surface> surface;
  RankShare share;
  [[nodiscard]] std::size_t size() const { return position.size(); }

  /// Calls visit(array) for every array that is allocated.
  template <class Visit>
  void for_each_array(const Visit& visit) {
    for_each_dense_array(visit);
    for_each_sparse_array([&visit](auto& array) {
      if (array.is_allocated()) visit(array.values());
    });
    if (!share.ids.empty()) visit(share.ids);
  }
  /// Calls visit(array) for every array that always has an entry for each particle.
  template <class Visit>
  void for_each_dense_array(const Visit& visit) {
    visit(position);
    visit(velocity);
    visit(mass);
    visit(void_fraction);
    visit(volume);
    visit(pressure);
    visit(wave_speed);
    visit(mask);
    visit(goes_with_soil);
    visit(in_seepage);
    visit(birthplace);
    visit(row);
    visit(surface);
  }
  /// Calls visit(array) for every array that may be unallocated (OrZero).
  template <class Visit>
  void for_each_sparse_array(const Visit& visit) {
    visit(solid_velocity);
    visit(solid_change);
    visit(drag_impulse);
    visit(coupling_force);
    visit(previous_coupling_force);
    visit(surface_share);
    visit(spreading);
    visit(surface_gradient);
    visit(entrained_fraction);
    visit(closed_body);
    visit(soil);
    visit(void_volume);
    visit(deferred_motion);
    visit(unseen_rate);
    visit(unseen_strain);
  }

  /// Reserves memory for n particles, and for a sixteenth more where others may enter. Arrays that grow by doubling
  /// would be half empty, and arrays that are reallocated separately fragment the memory.
  void reserve(std::size_t n, bool others_come) {
    const std::size_t room = others_come ? n + n / 16 + 16 : n;
    for_each_array([room](auto& array) { array.reserve(room); });
  }

  void add(const Vec<D>& x, const Vec<D>& v, double m, double n, double V, double p, const Provenance& from) {
    if (size() == position.capacity()) reserve(size(), true);
    position.push_back(x);
    velocity.push_back(v);
    mass.push_back(m);
    void_fraction.push_back(n);
    volume.push_back(V);
    pressure.push_back(p);
    wave_speed.push_back(from.wave_speed);
    goes_with_soil.push_back(from.goes_with_soil ? 1 : 0);
    mask.push_back(n < 1.0 ? 1.0 : 0.0);
    in_seepage.push_back(n < 1.0 ? 1 : 0);
    birthplace.push_back(x);
    row.push_back(1.0);
    surface.push_back(Surface::interior);
    for (auto* array : {&solid_velocity, &solid_change, &surface_gradient, &drag_impulse, &coupling_force,
                        &previous_coupling_force, &deferred_motion})
      array->grow();
    closed_body.grow();
    soil.grow();
    for (auto* array : {&surface_share, &spreading, &entrained_fraction, &void_volume, &unseen_rate, &unseen_strain})
      array->grow();
  }

  /// Keeps the particles for which keep[a] holds, in their order.
  void filter(const std::vector<bool>& keep) {
    for_each_array([&keep](auto& array) {
      std::size_t to = 0;
      for (std::size_t a = 0; a < keep.size(); ++a)
        if (keep[a]) array[to++] = array[a];
      array.resize(to);
    });
  }
};

/// Counters for a run's summary.
struct Counts {
  double windows = 0, pressure_iterations = 0, multigrid_cycles = 0, skeleton_iterations = 0, outer_iterations = 0,
         stencils = 0, born = 0, deleted = 0, unconverged = 0, drag_rounds = 0, lost = 0;
  double in_doubt = 0;                          ///< pressure solves whose residual exceeds the tolerance of free water
  double cavitating = 0, first_cavitation = 0;  ///< largest number of particles that cavitated at one time; s, time of
                                                ///< the first cavitation
};

/// Volumes of water that have entered and left through faces, and the initial volume [m^D].
struct Balance {
  double in = 0.0, out = 0.0, initial = 0.0;
};

/// A part of the bed between free water and the ground (boundary/bed.hpp).
template <int D>
struct BedPart {
  Vec<D> centre = Vec<D>::Zero(), normal = Vec<D>::Zero();  ///< m; unit, into the water
  double film = 0.0;       ///< m^D, water on it that no particle has; negative: that the particles owe the ground
  double rate = 0.0;       ///< m^D/s, at which the film turns into particles
  double head_sum = 0.0;   ///< m s, integral of the pressure head at its centre over
  double mean_time = 0.0;  ///< s
};

/// Impulse and work exchanged between water and soil since the start.
template <int D>
struct Exchanged {
  Vec<D> received = Vec<D>::Zero();      ///< N s, by the soil on the water: minus the impulse of drag, minus the
                                         ///< returned impulse
  double drag_work = 0.0;                ///< J, work of the drag on both phases
  Vec<D> from_outside = Vec<D>::Zero();  ///< N s, of weight and of the pressure of walls; summed only where a gauge
                                         ///< needs it
};

template <int D>
struct State {
  double time = 0.0;
  double last_interval = 0.0;        ///< s
  double usual_interval = 0.0;       ///< s, mean length of the last windows
  double deferred_motion_due = 0.0;  ///< s, time that remains to apply the particles' deferred motion
  double pressure_change = 0.0;      ///< rms change of the pressure in the last window, over the pressure's range
  double widest_range = 0.0;         ///< Pa, widest range of the piezometric pressure so far
  double controlled = 0.0;           ///< s, next window that the control by the change of pressure allows; 0: control
                                     ///< not started
  std::uint64_t revision = 0;
  Particles<D> particles;
  std::vector<FaceColumn<D>> columns;
  std::vector<Inlet<D>> inlets;
  std::vector<BedPart<D>> bed;
  bool full = false;       ///< all soil is at rest and full of water from the start, and all faces are wet: no surface
                           ///< can form
  bool multigrid = false;  ///< the last pressure solve needed more than a few cycles of multigrid
  std::vector<FaceState> faces;
  std::vector<TimeLimit> window_limits;  ///< from the last window
  Counts counts;
  Balance balance;
  Exchanged<D> exchanged;
  /// [gauges of kind discharge, in the case's order] m2/s, flow in the last window; empty where the pressure does not
  /// drive the whole flow.
  ScalarArray section_flow;
  double first_interval = 0.0;  ///< s, length of the first window beside soil that moves; 0: not known yet
};

/// Whether the pressure alone drives the water: in several soils at rest that are full of water. Flow without a surface
/// follows the heads within n rho_w / C (40 ms in gravel of k = 0.2 m/s), so that its inertia is negligible. But at a
/// border between soils of different conductivity the velocity jumps, and the divergence of a momentum that jumps is
/// wrong: with inertia, up to half of the discharge of a drain of such gravel came from nowhere.
template <int D>
bool is_driven_by_pressure(const Setup<D>& setup, const State<D>& state) {
  return state.full && !setup.one_soil && setup.drag;
}

/// The state at time zero, before its hydrostatic pressure is solved for. lattices: see water_lattices.
template <int D>
State<D> first_state(const Case& scene, const Setup<D>& setup, const WaterBoundaries& boundaries,
                     std::span<const Lattice<D>> lattices);

}  // namespace poretwin::fluid
