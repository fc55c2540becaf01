#include "solid_solver/exchange/publication.hpp"

#include "solid_solver/dynamics/step.hpp"
#include "solid_solver/exchange/water_load.hpp"
#include "solid_solver/numerics/exchange.hpp"

#include <algorithm>

namespace poretwin::solid {

template <int D>
coupling::Publication published(const Setup<D>& setup, const State<D>& state, PositionCache<D>& cache) {
  namespace field = coupling::field;
  const Particles<D>& p = state.particles;
  const auto& images = state.near.images;
  const std::size_t n = p.size(), all = n + images.size();
  coupling::Publication out;
  out.time = state.time;
  out.points.dimension = D;
  out.points.revision = state.revision;
  out.points.n_active = n;
  auto parent = [&](std::size_t i) { return i < n ? i : static_cast<std::size_t>(images[i - n].parent); };
  out.points.position.resize(all * D);
  for (auto* array : {&out.points.volume, &out.points.smoothing_length, &out.points.owner}) array->resize(all);
  for (std::size_t i = 0; i < all; ++i) {
    Eigen::Map<Vec<D>> x(out.points.position.data() + i * D);
    if (i < n)
      x = reference_position(setup, state, i);
    else
      x = images[i - n].map * reference_position(setup, state, images[i - n].parent) + images[i - n].shift;
    out.points.volume[i] = i < n ? p.volume[i] : p.volume[parent(i)] * images[i - n].swelling;
    out.points.smoothing_length[i] = setup.smoothing_length;
    out.points.owner[i] = static_cast<double>(parent(i));
  }
  auto scalars = [&](std::string_view name, auto&& value) {
    coupling::Field f{std::string(name), 1, ScalarArray(all)};
    for (std::size_t i = 0; i < all; ++i) f.values[i] = value(parent(i));
    out.fields.push_back(std::move(f));
  };
  auto vectors = [&](std::string_view name, auto&& value) {  // value(i): vector of point i, images included
    coupling::Field f{std::string(name), D, ScalarArray(all * D)};
    for (std::size_t i = 0; i < all; ++i) {
      const Vec<D> v = value(i);
      std::copy(v.data(), v.data() + D, f.values.begin() + static_cast<std::ptrdiff_t>(i * D));
    }
    out.fields.push_back(std::move(f));
  };
  auto moved = [&](const auto& v) {
    return [&](std::size_t i) {
      return i < n ? v[i] : images[i - n].moved(v[images[i - n].parent], p.slip) + images[i - n].carried;
    };
  };
  vectors(field::solid_velocity, moved(p.velocity));
  vectors(field::mean_solid_velocity, moved(state.mean_velocity));
  scalars(field::volumetric_strain_rate,
          [&](std::size_t i) { return state.last_interval > 0.0 ? state.dilation[i] / state.last_interval : 0.0; });
  const VecArray<D> load = load_forces<D>(setup, state, state.time + 1e-9 * std::abs(state.time));
  vectors(field::unbalanced_force, [&](std::size_t i) -> Vec<D> {
    const std::size_t j = parent(i);
    const Vec<D> r =
        state.force[j].internal() + (load[j] + p.mass[j] * setup.gravity) / p.volume[j] + state.external.force[j];
    return i < n ? r : Vec<D>(images[i - n].map * r);
  });
  scalars(field::solid_volume_fraction, [&](std::size_t i) { return solid_fraction(setup, p, i); });
  scalars(field::grain_density, [&](std::size_t i) { return setup.grain_density[p.material[i]]; });
  scalars(field::constrained_modulus, [&](std::size_t i) {
    const Elasticity elasticity = moduli(setup, p, i);
    if (in_suspension(setup, p, i)) return exchange::modulus_in_suspension * elasticity.constrained();
    if (state.motion.moving) return exchange::modulus_in_motion * elasticity.constrained();
    return state.yielded[i] ? elasticity.yielding() : elasticity.constrained();
  });
  scalars(field::yielding, [&](std::size_t i) { return state.plastic_shear_ratio[i]; });
  const auto& seepage = cache.seepage(setup, state);
  scalars(field::hydraulic_conductivity, [&](std::size_t i) { return seepage[i].conductivity; });
  scalars(field::forchheimer_coefficient, [&](std::size_t i) { return seepage[i].quadratic; });
  vectors(field::returned_impulse,
          [&](std::size_t i) { return i < n ? state.returned_impulse[i] : Vec<D>(Vec<D>::Zero()); });
  return out;
}

template coupling::Publication published<2>(const Setup<2>&, const State<2>&, PositionCache<2>&);
template coupling::Publication published<3>(const Setup<3>&, const State<3>&, PositionCache<3>&);

}  // namespace poretwin::solid
