#include "fluid_solver/boundary/water_boundary.hpp"

#include "common/core/error.hpp"
#include "fluid_solver/boundary/basin.hpp"
#include "fluid_solver/boundary/outlet.hpp"
#include "fluid_solver/boundary/prescribed_discharge.hpp"
#include "fluid_solver/boundary/prescribed_head.hpp"
#include "fluid_solver/boundary/prescribed_pressure.hpp"

namespace poretwin::fluid {

namespace {

struct Kind {
  bool (*is_meant)(const WaterFace& face);
  std::unique_ptr<WaterBoundary> (*make)(const Case& scene, const WaterFace& face);
};

template <class Boundary>
constexpr Kind kind{&Boundary::is_meant, [](const Case& scene, const WaterFace& face) {
                      return std::unique_ptr<WaterBoundary>(std::make_unique<Boundary>(scene, face));
                    }};

/// A face is of the first of these kinds whose keys it has.
constexpr Kind kinds[] = {kind<Basin>, kind<PrescribedDischarge>, kind<PrescribedHead>, kind<PrescribedPressure>,
                          kind<Outlet>};

}  // namespace

std::unique_ptr<WaterBoundary> make_water_boundary(const Case& scene, const WaterFace& face) {
  for (const auto& k : kinds)
    if (k.is_meant(face)) return k.make(scene, face);
  throw CaseError("a water face of no kind");  // reading the case refuses such faces
}

WaterBoundaries make_water_boundaries(const Case& scene) {
  WaterBoundaries boundaries;
  for (const auto& face : scene.water_faces) boundaries.push_back(make_water_boundary(scene, face));
  return boundaries;
}

double unchanged_for(const Series& series, double t, double most) {
  const double value = series.at(t);
  std::pair<double, double> last{t, value};
  for (const auto& knot : series.knots) {
    if (knot.first <= t) continue;
    const double change = knot.second - value;
    if (std::abs(change) > most) {
      const double target = value + std::copysign(most, change);
      return last.first - t + (knot.first - last.first) * (target - last.second) / (knot.second - last.second);
    }
    last = knot;
  }
  return HUGE_VAL;
}

}  // namespace poretwin::fluid
