#include "solid_solver/exchange/tracking.hpp"

#include "solid_solver/numerics/exchange.hpp"

namespace poretwin::solid {

template <int D>
Tracking<D> make_tracking(const Setup<D>& setup, const State<D>& state, const coupling::Window& window,
                          const CrossedAs& crossed, const WaterInput<D>& water, const VecArray<D>& found,
                          PositionCache<D>& cache) {
  const Particles<D>& p = state.particles;
  const std::size_t n = p.size();
  const double interval = window.interval;
  const bool rests = crossed.rests, again = rests && window.pass > 0;
  const auto steps = static_cast<double>(crossed.steps);
  const double whole = setup.parallel ? 1.0 : 2.0 * steps / (steps + 1.0);
  Tracking<D> tracking;
  tracking.goes_along.assign(n, 1.0);
  if (!water.tracks) return tracking;
  tracking.drive.tracking.assign(n, 0.0);
  tracking.drive.target.assign(n, Vec<D>::Zero());
  if (again) tracking.answers.resize(n);
  tracking.start = p.velocity;
  tracking.change.assign(n, Vec<D>::Zero());
  for (std::size_t i = 0; i < n; ++i) {
    if (state.external.coverage[i] <= 0.0 || water.soil_seen[i] <= exchange::least_seen) continue;
    const double R = p.mass[i] / p.volume[i];
    double along = 0.0, z = 0.0;  // impedance by inertia of entrained water; total impedance
    if (setup.water.drags) {
      const double n_w = void_fraction(setup, p, i);
      const auto law = porous::resistance(setup.water.weight, n_w, cache.seepage(setup, state)[i]);
      const double force =
          Eigen::Map<const Vec<D>>(water.impulse.values().data() + i * D).norm() / (p.volume[i] * interval);
      const double slip = law.speed(force), C = law.slope(slip), a = n_w * setup.water.density / interval;
      tracking.dissipated += p.volume[i] * force * slip * interval;
      along = C * a / (a + C);
      // In the parallel scheme, the prediction is that of the last window. The impedance therefore includes the
      // resistance of the pressure: where grains advance, water flows back, n v_w = -n_s v_s, and drag and pressure
      // together resist with C / n^2.
      z = setup.inertia_share > 0.0 ? C / (n_w * n_w) : rests ? C : along;
      if (again) {
        tracking.answers[i] =
            answer_of({C, a, n_w, interval}, moduli(setup, p, i).constrained(), setup.spacing, setup.height);
        z = tracking.answers[i].translation;
      }
    }
    const double inertia = (!again && rests ? 0.5 : setup.inertia_share) * R / interval;
    z += inertia;
    tracking.drive.tracking[i] = state.external.coverage[i] * p.volume[i] * whole * z;
    tracking.goes_along[i] = rests && z > 0.0 ? along / z : 1.0;
    for (int d = 0; d < D; ++d) {
      const std::size_t c = i * D + static_cast<std::size_t>(d);
      double& change = tracking.change[i][d];
      change = setup.parallel ? water.predicted[c] - p.velocity[i][d] : water.change[c];
      // The inertia term acts against a departure from the predicted change of velocity, the drag against a departure
      // from the predicted velocity.
      if (rests && !setup.parallel && z > 0.0)
        change = (1.0 - inertia / z) * (water.predicted[c] - p.velocity[i][d]) + inertia / z * water.change[c];
      // In a repeated window, the fluid reports the difference between its prediction and the velocity found in the
      // last pass.
      if (again) change = found[i][d] + water.change[c] - p.velocity[i][d];
    }
    tracking.drive.target[i] = p.velocity[i] + tracking.change[i];
  }
  return tracking;
}

template Tracking<2> make_tracking<2>(const Setup<2>&, const State<2>&, const coupling::Window&, const CrossedAs&,
                                      const WaterInput<2>&, const VecArray<2>&, PositionCache<2>&);
template Tracking<3> make_tracking<3>(const Setup<3>&, const State<3>&, const coupling::Window&, const CrossedAs&,
                                      const WaterInput<3>&, const VecArray<3>&, PositionCache<3>&);

}  // namespace poretwin::solid
