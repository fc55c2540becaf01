// The smoothed drag of Bui & Nguyen (2017): a sum over pairs of water and soil particles. The drag of each pair acts
// along the line that joins them.
#pragma once

#include "common/core/vector.hpp"
#include "common/geometry/shapes.hpp"
#include "common/particles/kernel.hpp"
#include "common/particles/neighbours.hpp"
#include "fluid_solver/numerics/exchange.hpp"

#include <span>

namespace poretwin::fluid {

/// The matrix G sum_i V_i (r r^T)/(r^2 + eta^2) W over the particles of rigid soil. In Eqs. (67), (74) it multiplies a
/// uniform relative velocity. With G = D (number of dimensions) its mean over random points is the unit matrix, but it
/// is so nowhere exactly: 0.68 where the lattices coincide, 0.65 and 1.34 along and across an edge
/// (docs/theory/paper.md). With G = 1/D, as printed in the paper, it is D^2 times weaker.
template <int D>
class SmoothedDrag {
 public:
  explicit SmoothedDrag(const Case& scene)
      : length_(exchange::drag_smoothing_ratio * scene.solid.particle_spacing),
        G_(scene.fluid.drag_form == FluidCase::DragForm::smoothed ? D : 1.0 / D) {
    for (const auto& soil : scene.soils) {
      const auto lattice = lay<D>(soil.shape, scene.solid.particle_spacing, scene.solid.offset, 0.0, 1);
      points_.insert(points_.end(), lattice.position.begin(), lattice.position.end());
      volume_.resize(points_.size(), lattice.volume);
    }
  }

  [[nodiscard]] MatArray<D> at(std::span<const Vec<D>> water) const {
    sph::CellGrid<D> grid;
    grid.build(points_, sph::support_radius * length_);
    MatArray<D> form(water.size(), Mat<D>::Zero());
    for (std::size_t a = 0; a < water.size(); ++a)
      grid.for_each_within(water[a], sph::support_radius * length_, [&](Index i, double r2) {
        const Vec<D> r = points_[i] - water[a];
        const double w = G_ * volume_[i] * sph::CubicSpline<D>::value(std::sqrt(r2), length_) /
                         (r2 + exchange::drag_softening * length_ * length_);
        form[a] += w * r * r.transpose();
      });
    return form;
  }

 private:
  double length_ = 0.0;  ///< smoothing length [m]
  double G_ = 1.0;
  VecArray<D> points_;  ///< of the soil [m]
  ScalarArray volume_;  ///< m^D
};

}  // namespace poretwin::fluid
