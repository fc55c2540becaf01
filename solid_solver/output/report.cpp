#include "solid_solver/output/report.hpp"

#include "solid_solver/numerics/readings.hpp"
#include "solid_solver/numerics/walls.hpp"
#include "solid_solver/output/readout.hpp"
#include "solid_solver/statics/safety.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace poretwin::solid {

template <int D>
OutputFrame frame_of(const Setup<D>& setup, const State<D>& state) {
  const Particles<D>& p = state.particles;
  OutputFrame frame;
  frame.time = state.time;
  frame.count = p.free();
  frame.position = write_vectors<D>(p.position);
  const Vec<D> up = upwards(setup);
  const auto stress = [&p](std::size_t i, double* components) { std::copy_n(p.stress[i].data(), 6, components); };
  const auto add = [&](FieldDeclaration&& declared, ParticleWriter&& write) {
    frame.fields.push_back({std::move(declared), std::move(write)});
  };
  add({"displacement", "m", "displacement of the skeleton since the unloaded state", 3},
      write_vectors<D>(p.displacement));
  add({"velocity", "m/s", "velocity of the skeleton", 3}, write_vectors<D>(p.velocity));
  add({"effective_stress", "Pa", "effective stress (xx yy zz xy yz xz), compression negative", 6}, stress);
  add({"pore_pressure", "Pa", "pressure of the water at the soil's points", 1},
      write_scalars([&state](std::size_t i) { return state.external.pressure[i]; }));
  add({"water_force", "N/m3", "force of the pore water on the skeleton: pressure, and the drag of steady flow", 3},
      write_vectors_by<D>([&state, &setup](std::size_t i) { return standing_water_force(setup, state, i); }));
  if (!p.slipped.empty())
    add({"wall_slip", "m", "displacement that belongs to the soil's slip along frictional walls", 3},
        write_vectors<D>(p.slipped));
  add({"void_fraction", "1", "porosity n_w = 1 - n_s", 1},
      write_scalars([&p, &setup](std::size_t i) { return void_fraction(setup, p, i); }));
  add({"degree_of_saturation", "1", "water's share of the soil's surroundings, Eq. (90)", 1},
      write_scalars([&state](std::size_t i) { return state.external.saturation[i]; }));
  add({"coverage", "1", "fraction of the particle that the water's points cover", 1},
      write_scalars([&state](std::size_t i) { return state.external.coverage[i]; }));
  add({"accumulated_plastic_strain", "1", "accumulated equivalent deviatoric plastic strain", 1},
      write_scalars([&p](std::size_t i) { return p.plastic_strain[i]; }));
  add({"mobilised_friction", "degrees", "mobilised friction angle, sin phi_m = (s1 - s3) / (s1 + s3)", 1},
      write_scalars([&p](std::size_t i) { return mobilised_friction(p.stress[i]); }));
  if (std::ranges::any_of(setup.soils, [](const Soil& soil) { return material(*soil.model).has_strength(); }))
    add({"local_factor_of_safety", "1",
         "number by which the strength can be divided until the stress reaches it; NaN: the soil has no such strength",
         1},
        write_scalars([&p, &state, &setup](std::size_t i) {
          const Condition condition = at_once(setup, p, i, state.external.saturation[i]);
          const double factor = setup.models[p.material[i]]->local_factor(p.stress[i], condition, p.state_of(i));
          return std::min(factor, readings::largest_local_factor);  // NaN stays NaN
        }));
  add({"pore_pressure_ratio", "1", "r_u = pore pressure / total vertical stress; 1: liquefied", 1},
      write_scalars([&p, &state, up](std::size_t i) {
        return pore_pressure_ratio(state.external.pressure[i], up.dot(matrix_of<D>(p.stress[i]) * up));
      }));
  std::map<std::string, StateVariable> remembered;  // the state variables of all materials, by name
  for (const auto& model : setup.models)
    for (const StateVariable& variable : model->state_variables()) remembered.try_emplace(variable.name, variable);
  for (const auto& [name, variable] : remembered)
    add({name, variable.unit, variable.meaning, 1}, write_scalars([&p, &setup, name](std::size_t i) {
          const auto variables = setup.models[p.material[i]]->state_variables();
          const auto found = std::ranges::find(variables, name, &StateVariable::name);
          return found == variables.end() ? 0.0 : p.state_of(i)[static_cast<std::size_t>(found - variables.begin())];
        }));
  if (setup.erodes) {
    add({"bed_shear_stress", "Pa", "shear stress of free water on the soil's surface", 1},
        write_scalars(
            [&e = state.erosion](std::size_t i) { return i < e.shear_stress.size() ? e.shear_stress[i] : 0.0; }));
    add({"eroded_share", "1", "share of its volume that the particle has lost to the water; at 1 it leaves", 1},
        write_scalars([&e = state.erosion](std::size_t i) { return i < e.share.size() ? e.share[i] : 0.0; }));
  }
  add({"volume", D == 2 ? "m2" : "m3", "bulk volume that the particle stands for", 1},
      write_scalars([&p](std::size_t i) { return p.volume[i]; }));
  return frame;
}

OutputField failing_strain_field(const ScalarArray& strain, const std::string& factor) {
  return {{"failing_strain", "1", "plastic strain of the soil that fails, its strength divided by " + factor, 1},
          write_scalars([&strain](std::size_t i) { return i < strain.size() ? strain[i] : 0.0; })};
}

template <int D>
std::map<std::string, double> counters_of(const State<D>& state, const RestReport& rest) {
  return {{"particles", static_cast<double>(state.particles.size())},
          {"particles carried off", state.erosion.particles},
          {"substeps", state.substeps},
          {"substeps asleep", state.slept},
          {"substeps damped", state.damped},
          {"share asleep beside soil that flows",
           state.regions.watched > 0.0 ? state.regions.slept / state.regions.watched : 0.0},
          {"list rebuilds", state.rebuilds},
          {"windows relaxed", state.motion.relaxed},
          {"windows at rest", state.motion.at_rest},
          {"displacements tried", state.motion.steps},
          {"times the soil began to move", state.motion.begun},
          {"time in motion", state.motion.duration},
          {"rest steps", static_cast<double>(rest.steps)},
          {"rest found", rest.steps > 0 && rest.reached() ? 1.0 : 0.0},
          {"rest residual", rest.residual},
          {"rest displacement", rest.displacement},
          {"rest criterion", rest.criterion}};
}

template <int D>
std::vector<Warning> warnings_of(const Setup<D>& setup, const State<D>& state, const RestReport& rest) {
  const bool sought = rest.steps > 0 && !rest.reached();
  // Soil that moved far in the search starts from a shape that the case does not draw. A layer that slides as a whole
  // (by a third of its height in cases/sliding_layer) keeps its shape.
  const bool far = rest.displacement > 0.5 * setup.height;
  double pulls = 0.0;
  for (const auto& plate : state.particles.plates)
    if (plate.pull > walls::noticed_pull * plate.largest) pulls += plate.pulls;
  return {
      {"the soil's rest was not found", sought ? 1.0 : 0.0,
       fmt::format("{} steps left {:.2g} of the driving acceleration, wanted {:g}; the run starts in motion, the soil "
                   "moved by up to {:.3g} m before time zero: too weak to stand, too soft (youngs_modulus is in "
                   "Pa), or solid.initial_rest = false is meant",
                   rest.steps, rest.residual, rest.criterion, rest.displacement),
       far},
      {"windows in which a force held the soil that neither phase bears", state.motion.held,
       "it would have moved otherwise than the water predicted; coupling.scheme = \"iterated\" repeats "
       "such windows until both agree",
       true},
      {"windows in which a plate pulled at the soil", pulls,
       "soil sticks to a plate as to every wall; a real plate would have lifted off: expected no such pull", false},
      {"times the soil began to move", state.motion.begun,
       "its inertia matters: it is followed in short windows until it is calm again", false}};
}

#define PORETWIN_INSTANTIATE(D)                                                              \
  template OutputFrame frame_of<D>(const Setup<D>&, const State<D>&);                        \
  template std::map<std::string, double> counters_of<D>(const State<D>&, const RestReport&); \
  template std::vector<Warning> warnings_of<D>(const Setup<D>&, const State<D>&, const RestReport&);
PORETWIN_INSTANTIATE(2)
PORETWIN_INSTANTIATE(3)
#undef PORETWIN_INSTANTIATE

}  // namespace poretwin::solid
