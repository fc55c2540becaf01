#include "solid_solver/output/failing_mass.hpp"

#include <algorithm>

namespace poretwin::solid {

template <int D>
std::optional<FailingMass<D>> failing_mass(const State<D>& state, const VecArray<D>& displacement) {
  const Particles<D>& p = state.particles;
  FailingMass<D> failing;
  ScalarArray of_soil;
  double weights = 0.0, first = 0.0, second = 0.0;
  for (std::size_t i = 0; i < displacement.size(); ++i) {
    const double moved = displacement[i].norm(), weight = p.mass[i] * moved;
    of_soil.resize(std::max<std::size_t>(of_soil.size(), p.material[i] + 1U), 0.0);
    of_soil[p.material[i]] += weight;
    weights += weight;
    failing.centre += weight * p.position[i];
    failing.towards += p.mass[i] * displacement[i];
    first += p.volume[i] * moved;
    second += p.volume[i] * moved * moved;
  }
  if (!(weights > 0.0)) return {};
  failing.soil = static_cast<std::size_t>(std::ranges::max_element(of_soil) - of_soil.begin());
  failing.centre /= weights;
  failing.towards.normalize();
  failing.volume = first * first / second;
  return failing;
}

template std::optional<FailingMass<2>> failing_mass<2>(const State<2>&, const VecArray<2>&);
template std::optional<FailingMass<3>> failing_mass<3>(const State<3>&, const VecArray<3>&);

}  // namespace poretwin::solid
