#include "solid_solver/output/stored_state.hpp"

#include "common/core/error.hpp"
#include "solid_solver/numerics/flow.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace poretwin::solid {
namespace {

/// Vectors made of the first D of three numbers per particle.
template <int D>
VecArray<D> vectors(const std::vector<double>& numbers) {
  VecArray<D> all(numbers.size() / 3);
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = Eigen::Map<const Vec<D>>(numbers.data() + 3 * i);
  return all;
}

}  // namespace

template <int D>
StoredState<D> stored_state(const Setup<D>& setup, const State<D>& initial, const FrameFile& frames, std::size_t frame,
                            const Point3& origin) {
  StoredState<D> stored{initial, {}};
  State<D>& state = stored.state;
  Particles<D>& p = state.particles;
  const std::size_t n = p.size();
  if (p.held > 0 || frames.particles(frame) != n)
    throw FileError(
        fmt::format("{}: expected {} particles of soil in the frame at {:g} s, as the case lays them out, found {}",
                    frames.path().string(), n, frames.times()[frame], frames.particles(frame)));
  state.time = frames.times()[frame];
  p.position = vectors<D>(frames.positions(frame));
  for (auto& x : p.position) x -= origin.head<D>();
  p.displacement = vectors<D>(frames.values("displacement", frame));
  p.velocity.assign(n, Vec<D>::Zero());
  p.volume = frames.values("volume", frame);
  p.plastic_strain = frames.values("accumulated_plastic_strain", frame);
  const auto stress = frames.values("effective_stress", frame);
  for (std::size_t i = 0; i < n; ++i) std::copy_n(&stress[6 * i], 6, p.stress[i].data());
  if (!p.slipped.empty()) p.slipped = vectors<D>(frames.values("wall_slip", frame));
  state.external.pressure = frames.values("pore_pressure", frame);
  state.external.coverage = frames.values("coverage", frame);
  state.external.saturation = frames.values("degree_of_saturation", frame);
  for (std::size_t soil = 0; soil < setup.models.size(); ++soil) {
    const auto variables = setup.models[soil]->state_variables();
    for (std::size_t k = 0; k < variables.size(); ++k) {
      const auto values = frames.values(variables[k].name, frame);
      for (std::size_t i = 0; i < n; ++i)
        if (p.material[i] == soil) p.state_of(i)[k] = values[i];
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    const auto soil = p.material[i];
    const bool apart = p.volume[i] > flow::loosest * p.mass[i] / setup.density[soil];
    p.rubbing[i] = apart ? setup.loose_friction[soil] : 0.0F;
  }
  stored.water = vectors<D>(frames.values("water_force", frame));
  for (std::size_t i = 0; i < n; ++i) stored.water[i] *= p.volume[i];
  return stored;
}

template StoredState<2> stored_state<2>(const Setup<2>&, const State<2>&, const FrameFile&, std::size_t, const Point3&);
template StoredState<3> stored_state<3>(const Setup<3>&, const State<3>&, const FrameFile&, std::size_t, const Point3&);

}  // namespace poretwin::solid
