// Water that enters and leaves through columns of buffers at faces.
#pragma once

#include "fluid_solver/discretisation/cloud.hpp"
#include "fluid_solver/pressure/window.hpp"
#include "fluid_solver/state.hpp"

#include <functional>

namespace poretwin::fluid {

/// The properties of the water's faces that stay constant during a run. Where several ranks share the water, each has
/// all faces, with all their columns in the same state: what changes them is known to all ranks.
template <int D>
struct Faces {
  Faces(const Case& scene, WaterBoundaries what_stands_behind, const State<D>& first);

  /// Level of the still water behind a face [m]; empty where no still water stands behind it.
  [[nodiscard]] std::optional<double> level(const State<D>& state, int face, double time) const {
    const auto f = static_cast<std::size_t>(face);
    return boundaries[f]->level(time, state.faces[f]);
  }
  /// Whether water particles come through a face, pushed by a piston.
  [[nodiscard]] bool is_opening(const State<D>& state, int face) const {
    return std::any_of(state.inlets.begin(), state.inlets.end(),
                       [&](const auto& inlet) { return inlet.face == face && !inlet.sill; });
  }
  /// The face behind which still water takes in water at x [m], below its level, at the state's time; -1: no face.
  /// Above a crest the sill's piston takes the water in.
  [[nodiscard]] int taker(const Setup<D>& setup, const State<D>& state, const Vec<D>& x) const;

  /// Whether a face is a face of soil with still water behind it.
  [[nodiscard]] bool is_reservoir(int face) const {
    return std::any_of(reservoirs_.begin(), reservoirs_.end(), [&](const auto& r) { return r.face == face; });
  }

  WaterBoundaries boundaries;
  VecArray<D> feet;  ///< m, feet of the columns at the start

 private:
  /// A face of soil with still water behind it that no particles represent.
  struct Reservoir {
    int face = 0;
    std::function<bool(const Point3& x)> is_behind;
  };
  std::vector<Reservoir> reservoirs_;
};

/// Whether particle a belongs to no soil.
template <int D>
bool is_free(const Particles<D>& p, std::size_t a) {
  return p.goes_with_soil[a] == 0 && p.mask[a] <= 0.5;
}

/// Advances the still water and the basins behind the faces to the end of a window, using the flow of the last window.
template <int D>
void advance_boundaries(const Setup<D>& setup, const Faces<D>& faces, double time, double interval, State<D>& state);

/// Volume that has entered through each face, minus the volume that has left [m^D].
template <int D>
ScalarArray passed(const State<D>& state);

/// Whether water flows quasi-statically through a column into soil at rest: drag dominates the flow, and the pressure
/// is solved for.
template <int D>
bool is_quasi_static(const Setup<D>& setup, const FaceColumn<D>& c);

/// Speed of a front that enters dry ground behind a face.
template <int D>
InfiltrationSpeed infiltration_speed(const Setup<D>& setup, const FaceColumn<D>& c);

/// Moves the columns' stacks of buffers by one window. came (one per face): sums the volume that enters, m^D.
template <int D>
void advance_columns(const Setup<D>& setup, const sph::Sight<D>& sight, const Stencil<D>& s, const SoilView<D>& view,
                     const WindowSolution<D>& solution, double interval, State<D>& state, ScalarArray& came);

/// Sets the surface of the water at faces and its pressure at wetting fronts.
template <int D>
void limit_surface(const Setup<D>& setup, const State<D>& state, Stencil<D>& s);

/// Moves faces of a prescribed head with the soil's surface as it recedes.
template <int D>
void follow_soil(const Setup<D>& setup, const SoilView<D>& view, State<D>& state);

/// Adds particles that enter and deletes those that have left.
/// came (one per face): sums the volume that enters, m^D.
template <int D>
void give_birth_and_delete(const Setup<D>& setup, const Faces<D>& faces, const SoilView<D>& view, State<D>& state,
                           ScalarArray& came);

/// Adds the net volume through each face in a window [m^D] to the balance. Inflow and outflow are not summed by column:
/// the repair of the packing moves water in at one column and out at the next.
void close_accounts(const ScalarArray& came, Balance& balance);

/// Volume that the faces have let in beyond the growth of the particles' volume [m^D].
template <int D>
double missing_water(const Setup<D>& setup, const State<D>& state);

/// The still water behind faces into which soil may slide: the rows of columns beyond those that the water's own
/// operators need, and further columns where a face ends without a neighbour. It has the face's piezometric pressure.
template <int D>
std::vector<StillWater<D>> still_water(const Setup<D>& setup, const Faces<D>& faces,
                                       std::span<const sph::ImagePlane<D>> planes, const State<D>& state);

}  // namespace poretwin::fluid
