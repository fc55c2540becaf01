// Water that comes and goes through columns of buffers.
#pragma once

#include "fluid_solver/discretisation/cloud.hpp"
#include "fluid_solver/pressure/window.hpp"
#include "fluid_solver/state.hpp"

#include <functional>

namespace poretwin::fluid {

/// The water's faces, as they stay through a run.
template <int D>
struct Faces {
  Faces(const Case& scene, WaterBoundaries what_stands_behind, const State<D>& first);

  /// Level of the still water behind a face [m]; none: there is no such water.
  [[nodiscard]] std::optional<double> level(const State<D>& state, int face, double time) const {
    const auto f = static_cast<std::size_t>(face);
    return boundaries[f]->level(time, state.faces[f]);
  }
  /// Whether particles of water come through a face, by a piston.
  [[nodiscard]] bool is_opening(const State<D>& state, int face) const {
    return std::any_of(state.inlets.begin(), state.inlets.end(),
                       [&](const auto& inlet) { return inlet.face == face && !inlet.sill; });
  }
  /// The face behind which still water takes in what is at x [m] at the state's time, below its level; -1: none. Above
  /// a crest the sill's piston does that.
  [[nodiscard]] int taker(const Setup<D>& setup, const State<D>& state, const Vec<D>& x) const;

  /// Whether a face is one of soil with still water behind it.
  [[nodiscard]] bool is_reservoir(int face) const {
    return std::any_of(reservoirs_.begin(), reservoirs_.end(), [&](const auto& r) { return r.face == face; });
  }

  WaterBoundaries boundaries;
  VecArray<D> feet;  ///< of the columns, where the case has them [m]

 private:
  /// A face of soil behind which still water stands, in no particles.
  struct Reservoir {
    int face = 0;
    std::function<bool(const Point3& x)> is_behind;
  };
  std::vector<Reservoir> reservoirs_;
};

/// Does particle a belong to no soil?
template <int D>
bool is_free(const Particles<D>& p, std::size_t a) {
  return p.goes_with_soil[a] == 0 && p.mask[a] <= 0.5;
}

/// What stands behind the faces at the end of a window, the flow through them taken as it was in the last one.
template <int D>
void advance_boundaries(const Setup<D>& setup, const Faces<D>& faces, double time, double interval, State<D>& state);

/// Volume that has come in through each face, less what has gone out [m^D].
template <int D>
ScalarArray passed(const State<D>& state);

/// Whether water flows quasi-statically through a column into soil at rest: drag-dominated, its pressure solved for.
template <int D>
bool is_quasi_static(const Setup<D>& setup, const FaceColumn<D>& c);

/// Speed of a front into dry ground behind a face.
template <int D>
InfiltrationSpeed infiltration_speed(const Setup<D>& setup, const FaceColumn<D>& c);

/// Moves the columns' stacks by one window; came [faces] gathers what they let in, m^D.
template <int D>
void advance_columns(const Setup<D>& setup, const sph::Sight<D>& sight, const Stencil<D>& s, const SoilView<D>& view,
                     const WindowSolution<D>& solution, double interval, State<D>& state, ScalarArray& came);

/// Bounds the surface of the water at faces and at wetting fronts.
template <int D>
void limit_surface(const Setup<D>& setup, const State<D>& state, Stencil<D>& s);

/// Faces of a prescribed head step back with the soil's surface.
template <int D>
void follow_soil(const SoilView<D>& view, State<D>& state);

/// Lets particles in and takes out those that have left; came as above.
template <int D>
void give_birth_and_delete(const Setup<D>& setup, const Faces<D>& faces, const SoilView<D>& view, State<D>& state,
                           ScalarArray& came);

/// Enters what came through each face in a window, less what went, in the balance: from column to column it goes in and
/// out with the packing.
void close_accounts(const ScalarArray& came, Balance& balance);

/// What the faces' account has let in beyond what the particles' water has grown by [m^D].
template <int D>
double missing_water(const Setup<D>& setup, const State<D>& state);

/// The still water behind faces, as far as soil may slide into it: the columns' rows beyond those that the water's own
/// operators need, and more columns where a face ends in the open. Its piezometric pressure is the face's.
template <int D>
std::vector<StillWater<D>> still_water(const Setup<D>& setup, const Faces<D>& faces,
                                       std::span<const sph::ImagePlane<D>> planes, const State<D>& state);

}  // namespace poretwin::fluid
