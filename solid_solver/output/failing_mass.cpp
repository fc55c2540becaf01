#include "solid_solver/output/failing_mass.hpp"

#include <algorithm>
#include <array>

namespace poretwin::solid {

template <int D>
std::optional<FailingMass<D>> failing_mass(const Setup<D>& setup, const State<D>& state,
                                           const VecArray<D>& displacement) {
  const Particles<D>& p = state.particles;
  const Vec<D> up = upwards(setup);
  // There are two sides: soil that moves in the level direction of the farthest displacement, and soil against it.
  const auto farthest = std::ranges::max_element(displacement, {}, [](const Vec<D>& u) { return u.norm(); });
  if (farthest == displacement.end() || !(farthest->norm() > 0.0)) return {};
  const Vec<D> level = *farthest - up.dot(*farthest) * up;
  struct Sums {
    FailingMass<D> mass;
    ScalarArray of_soil;
    double weights = 0.0, first = 0.0, second = 0.0;
  };
  std::array<Sums, 2> sides;
  for (std::size_t i = 0; i < displacement.size(); ++i) {
    const Vec<D>& u = displacement[i];
    Sums& side = sides[u.dot(level) >= 0.0 ? 0 : 1];
    const double moved = u.norm(), weight = p.mass[i] * moved;
    side.of_soil.resize(setup.soils.size(), 0.0);
    side.of_soil[p.material[i]] += weight;
    side.weights += weight;
    side.mass.centre += weight * p.position[i];
    side.mass.towards += p.mass[i] * u;
    side.first += p.volume[i] * moved;
    side.second += p.volume[i] * moved * moved;
  }
  Sums& side = sides[sides[1].weights > sides[0].weights ? 1 : 0];
  FailingMass<D>& failing = side.mass;
  failing.share = side.weights / (sides[0].weights + sides[1].weights);
  failing.soil = static_cast<std::size_t>(std::ranges::max_element(side.of_soil) - side.of_soil.begin());
  failing.centre /= side.weights;
  failing.towards.normalize();
  failing.volume = side.first * side.first / side.second;
  return failing;
}

template std::optional<FailingMass<2>> failing_mass<2>(const Setup<2>&, const State<2>&, const VecArray<2>&);
template std::optional<FailingMass<3>> failing_mass<3>(const Setup<3>&, const State<3>&, const VecArray<3>&);

}  // namespace poretwin::solid
