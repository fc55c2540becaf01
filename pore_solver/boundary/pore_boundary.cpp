#include "pore_solver/boundary/pore_boundary.hpp"

#include "common/media/seepage.hpp"
#include "pore_solver/boundary/basin.hpp"
#include "pore_solver/boundary/free_water.hpp"
#include "pore_solver/boundary/surface.hpp"
#include "pore_solver/boundary/water_behind.hpp"
#include "pore_solver/boundary/well_screen.hpp"

#include <cmath>

namespace poretwin::pore {

double next_knot(const Series& series, double time) {
  for (const auto& knot : series.knots)
    if (knot.first > time) return knot.first;
  return HUGE_VAL;
}

std::unique_ptr<PoreBoundary> make_boundary(const Case& scene, std::size_t face, std::size_t rain) {
  if (rain != Segment::none) return std::make_unique<Surface>(scene.rains[rain], face != Segment::none);
  const WaterFace& f = scene.water_faces[face];
  if (f.free_water) return std::make_unique<FreeWater>();
  if (f.basin_area) return std::make_unique<Basin>(f, scene.fluid.particle_spacing);
  if (f.outlet) return std::make_unique<Outlet>();
  if (f.pressure) return std::make_unique<PrescribedPressure>(*f.pressure, porous::specific_weight(scene));
  return std::make_unique<Reservoir>(*f.head);
}

std::unique_ptr<PoreBoundary> make_well(const Well& well) {
  if (well.head) return std::make_unique<Reservoir>(*well.head);
  return std::make_unique<WellScreen>(*well.discharge);
}

}  // namespace poretwin::pore
