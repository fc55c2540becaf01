#include "common/coupling/standard_contract.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace poretwin::coupling {
namespace {

using enum Mapping;
using enum Role;

constexpr double largest = std::numeric_limits<double>::max();
constexpr double above_zero = std::numeric_limits<double>::min();
constexpr double below_one = 1.0 - std::numeric_limits<double>::epsilon() / 2.0;
constexpr Bounds share{0.0, 1.0};      // fractions
constexpr Bounds speed{-1e6, 1e6};     // m/s
constexpr Bounds strong{-1e15, 1e15};  // Pa; N/m3; N s/m3: impulse of the weight of water in 3000 years
constexpr Bounds not_negative{0.0, largest};
constexpr Bounds any{-largest, largest};

constexpr std::array fields{
    StandardField{.giver = fluid,
                  .name = field::pore_pressure,
                  .unit = "Pa",
                  .bounds = strong,
                  .of_field = true,
                  .meaning = "water pressure at t + dt; of a field the share of it that the skeleton bears, chi p"},
    StandardField{.giver = fluid,
                  .name = field::degree_of_saturation,
                  .unit = "1",
                  .bounds = share,
                  .at_rest = 1.0,
                  .of_particles = false,
                  .of_field = true,
                  .meaning = "water's share of the pores, at t + dt"},
    StandardField{.giver = fluid,
                  .name = field::predicted_solid_velocity,
                  .unit = "m/s",
                  .vector = true,
                  .mask = field::soil_fraction,
                  .bounds = speed,
                  .meaning = "skeleton velocity that the fluid's solve predicts, v_s'"},
    StandardField{.giver = fluid,
                  .name = field::predicted_change,
                  .unit = "m/s",
                  .vector = true,
                  .mask = field::soil_fraction,
                  .bounds = speed,
                  .meaning = "change of the skeleton's velocity in the window: v_s' less the `solid_velocity` that the "
                             "fluid was given"},
    StandardField{.giver = fluid,
                  .name = field::drag_impulse,
                  .unit = "N s",
                  .vector = true,
                  .mapping = conservative,
                  .bounds = strong,
                  .of_volume = true,
                  .meaning = "impulse that the drag gives to the solid during the window"},
    StandardField{.giver = fluid,
                  .name = field::soil_fraction,
                  .unit = "1",
                  .bounds = share,
                  .at_rest = 1.0,
                  .meaning = "1 inside soil, 0 in free water"},
    StandardField{.giver = fluid,
                  .name = field::surface_gradient,
                  .unit = "Pa/m",
                  .vector = true,
                  .mask = field::surface_share,
                  .bounds = any,
                  .meaning = "gradient of the pressure where the water's free surface bounds it"},
    StandardField{.giver = fluid,
                  .name = field::surface_share,
                  .unit = "1",
                  .bounds = share,
                  .meaning = "1 where water of moving soil lies at its free surface: there the solid takes "
                             "`surface_gradient` for its own; 0 elsewhere"},
    StandardField{.giver = fluid,
                  .name = field::spreading_rate,
                  .unit = "1/s",
                  .mask = field::soil_fraction,
                  .bounds = any,
                  .meaning =
                      "rate at which the fluid's repair of its packing expands the mixture and takes moving soil "
                      "along: it is no strain of the skeleton; 0 elsewhere"},
    StandardField{.giver = solid,
                  .name = field::solid_velocity,
                  .unit = "m/s",
                  .vector = true,
                  .bounds = speed,
                  .meaning = "at the window's end"},
    StandardField{.giver = solid,
                  .name = field::mean_solid_velocity,
                  .unit = "m/s",
                  .vector = true,
                  .bounds = speed,
                  .meaning = "mean over the window"},
    StandardField{.giver = solid,
                  .name = field::volumetric_strain_rate,
                  .unit = "1/s",
                  .bounds = any,
                  .meaning =
                      "rate of the skeleton's volumetric strain, mean over the window, expansion positive, as the "
                      "solid's stress law integrated it; the fluid adds to its volume balance the part of this rate "
                      "that the divergence of the mapped velocities does not contain"},
    StandardField{.giver = solid,
                  .name = field::unbalanced_force,
                  .unit = "N/m3",
                  .vector = true,
                  .bounds = strong,
                  .meaning = "div sigma' + traction + weight + the force of pressure and drag, at the window's end: 0 "
                             "at rest"},
    // The upper bound is below 1: without pores no water could be inside the soil.
    StandardField{.giver = solid,
                  .name = field::solid_volume_fraction,
                  .unit = "1",
                  .bounds = {0.0, below_one},
                  .at_rest = 0.6,
                  .meaning = "n_s = 1 - porosity"},
    // `at_rest` is the value for soil that does not move.
    StandardField{.giver = solid,
                  .name = field::grain_density,
                  .unit = "kg/m3",
                  .mapping = nearest,
                  .bounds = {above_zero, 1e15},
                  .at_rest = 2650.0,
                  .meaning = "intrinsic rho_s"},
    StandardField{.giver = solid,
                  .name = field::constrained_modulus,
                  .unit = "Pa",
                  .mapping = nearest,
                  .bounds = {0.0, 1e15},
                  .meaning = "M = K + 4 G / 3"},
    StandardField{
        .giver = solid,
        .name = field::yielding,
        .unit = "1",
        .bounds = share,
        .meaning =
            "share of the last window's shear strain that was plastic: plastic shear continues at constant stress"},
    StandardField{.giver = solid,
                  .name = field::hydraulic_conductivity,
                  .unit = "m/s",
                  .mapping = nearest,
                  .bounds = {above_zero, 1e6},
                  .at_rest = 1e-3,
                  .meaning = "k of i = U/k + b U^2"},
    StandardField{.giver = solid,
                  .name = field::forchheimer_coefficient,
                  .unit = "s2/m2",
                  .mapping = nearest,
                  .bounds = not_negative,
                  .meaning = "b of i = U/k + b U^2"},
    StandardField{.giver = solid,
                  .name = field::returned_impulse,
                  .unit = "N s",
                  .vector = true,
                  .mapping = conservative,
                  .bounds = strong,
                  .of_volume = true,
                  .meaning =
                      "impulse that the solid received in addition to `drag_impulse`. It is the inertia of water that "
                      "moves along with soil which departs from `predicted_change`; at the start of the next "
                      "window the fluid takes this impulse from its water"},
};

std::string short_number(double x) {
  std::string text = fmt::format("{:g}", x);
  if (const auto e = text.find("e+"); e != std::string::npos) text.erase(e + 1, text[e + 2] == '0' ? 2 : 1);
  return text;
}

}  // namespace

std::string Bounds::text(std::string_view unit) const {
  if (high == largest)
    return low == -largest ? "a finite number" : low == 0.0 ? "a number of at least 0" : "a positive number";
  return fmt::format("a number in {}, {}{}{}", low == above_zero ? "(0" : "[" + short_number(low),
                     high == below_one ? "1" : short_number(high), high == below_one ? ")" : "]",
                     unit == "1" ? "" : fmt::format(" {}", unit));
}

std::span<const StandardField> standard_contract() { return fields; }

const StandardField* standard_field(std::string_view name) {
  const auto* const row = std::find_if(fields.begin(), fields.end(), [&](const auto& f) { return f.name == name; });
  return row == fields.end() ? nullptr : row;
}

std::vector<FieldSpec> standard_fields(Role giver, int dimension, WaterAs water) {
  std::vector<FieldSpec> specs;
  for (const auto& f : fields)
    if (f.giver == giver && (giver == solid || (water == WaterAs::field ? f.of_field : f.of_particles)))
      specs.push_back(
          {std::string(f.name), std::string(f.unit), f.vector ? dimension : 1, f.mapping, std::string(f.mask)});
  return specs;
}

std::string describe_contract() {
  std::string text;
  for (const Role giver : {fluid, solid}) {
    text += fmt::format("| {} | unit | mapping | bounds | meaning |\n| --- | --- | --- | --- | --- |\n",
                        giver == fluid ? "fluid -> solid" : "solid -> fluid");
    for (const auto& f : fields) {
      if (f.giver != giver) continue;
      const std::string_view who = f.giver == solid || (f.of_particles && f.of_field) ? ""
                                   : f.of_field                                       ? "; of a field only"
                                                                                      : "; of particles only";
      std::string bounds = f.bounds.text("1");
      if (constexpr std::string_view words = "a number in "; bounds.starts_with(words)) bounds.erase(0, words.size());
      text += fmt::format("| `{}`{} | {} | {}{} | {}{} | {}{} |\n", f.name, f.vector ? " (vector)" : "", f.unit,
                          to_string(f.mapping), f.mask.empty() ? "" : fmt::format(", mask `{}`", f.mask), bounds,
                          f.of_volume ? " of each m^D of the point" : "", f.meaning, who);
    }
    if (giver == fluid) text += '\n';
  }
  return text;
}

std::string python_contract() {
  std::string text =
      "\"\"\"The standard contract: what each role gives. Written by `poretwin exchange-fields --python`.\"\"\"\n\n"
      "# name, unit, vector, mapping, mask; what a fluid gives whose water is particles, a solid, and a fluid whose "
      "water\n"
      "# is a field (fluid.representation)\n"
      "STANDARD: dict[str, list[tuple[str, str, bool, str, str]]] = {\n";
  const auto list = [&](std::string_view key, Role giver, const auto& has) {
    text += fmt::format("    \"{}\": [\n", key);
    for (const auto& f : fields)
      if (f.giver == giver && has(f))
        text += fmt::format("        (\"{}\", \"{}\", {}, \"{}\", \"{}\"),\n", f.name, f.unit,
                            f.vector ? "True" : "False", to_string(f.mapping), f.mask);
    text += "    ],\n";
  };
  list("fluid", fluid, [](const StandardField& f) { return f.of_particles; });
  list("solid", solid, [](const StandardField&) { return true; });
  list("field", fluid, [](const StandardField& f) { return f.of_field; });
  return text + "}\n";
}

}  // namespace poretwin::coupling
