// What the fluid shows of itself: output frames and counters.
#include "fluid_solver/fluid_phase.hpp"

namespace poretwin::fluid {

template <int D>
OutputFrame Fluid<D>::frame() const {
  const auto& p = state_.particles;
  OutputFrame out;
  out.time = state_.time;
  const auto three = [](const VecArray<D>& from) {
    std::vector<double> values(3 * from.size(), 0.0);
    for (std::size_t a = 0; a < from.size(); ++a)
      for (std::size_t d = 0; d < D; ++d) values[3 * a + d] = from[a][static_cast<int>(d)];
    return values;
  };
  out.position = three(p.position);
  ScalarArray pressure(p.size()), flag(p.size());
  VecArray<D> relative(p.size());
  for (std::size_t a = 0; a < p.size(); ++a) {
    pressure[a] = p.pressure[a] + weight_.dot(p.position[a] - origin_);
    flag[a] = p.surface[a] == Surface::interior ? 0.0 : 1.0;
    relative[a] =
        p.mask[a] > 0.0 ? Vec<D>(p.void_fraction[a] * (p.velocity[a] - p.solid_velocity[a])) : Vec<D>(Vec<D>::Zero());
  }
  // One by one: a list of them all would be copied.
  const auto add = [&](OutputField&& field) { out.fields.push_back(std::move(field)); };
  add({"velocity", "m/s", "velocity of the water between the grains (intrinsic)", 3, three(p.velocity)});
  add({"pore_pressure", "Pa", "total pressure of the water", 1, std::move(pressure)});
  add({"void_fraction", "1", "n_w, water's share of the volume where saturated; 1 in free water", 1, p.void_fraction});
  add({"relative_flux", "m/s", "n (v_w - v_s), the discharge through the skeleton; zero in free water", 3,
       three(relative)});
  add({"surface", "1", "1 on the free surface", 1, std::move(flag)});
  return out;
}

template <int D>
std::map<std::string, double> Fluid<D>::counters() const {
  const auto& c = state_.counts;
  std::map<std::string, double> counters{{"particles", static_cast<double>(state_.particles.size())},
                                         {"windows", c.windows},
                                         {"pressure iterations", c.pressure_iterations},
                                         {"multigrid cycles", c.multigrid_cycles},
                                         {"skeleton iterations", c.skeleton_iterations},
                                         {"outer iterations", c.outer_iterations},
                                         {"solves that missed their tolerance", c.unconverged},
                                         {"list rebuilds", c.stencils},
                                         {"further rounds of quadratic drag", c.drag_rounds},
                                         {"born", c.born},
                                         {"deleted", c.deleted},
                                         {"lost, far outside", c.lost}};
  if (c.cavitating > 0.0) {
    counters["particles that cavitated, most at once"] = c.cavitating;
    counters["s: first cavitation"] = c.first_cavitation;
  }
  return counters;
}

template class Fluid<2>;
template class Fluid<3>;

}  // namespace poretwin::fluid
