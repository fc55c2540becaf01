// The kinds of gauges. The page of the case file, the check and the solvers all use this list.
#pragma once

#include <string>
#include <string_view>

namespace poretwin {

struct GaugeKind {
  std::string_view name;
  std::string_view phase;    ///< "fluid", "solid" or "either"
  std::string_view meaning;  ///< what the gauge measures, and which of its keys it needs
};

// clang-format off: one row per kind
inline constexpr GaugeKind gauge_kinds[] = {
    {"point", "either", "a field at `points`"},
    {"front", "either",
     "distance along the line between two `points`: of the water to its wetting front (up a vertical line: to the "
     "water table), of the soil to its farthest place of a given `thickness`"},
    {"momentum", "either", "sum of mass times velocity over the particles"},
    {"kinetic_energy", "either", "kinetic energy of all particles"},
    {"energy", "either", "kinetic and potential energy, of the soil also elastic energy"},
    {"received_impulse", "either", "impulse from the other phase, since the start"},
    {"unexplained_impulse", "either",
     "momentum less what weight, walls and the other phase gave since the start. The fluid subtracts the whole "
     "pressure of the water on walls (2D), the part that the soil bears included, so that the sum over both phases is "
     "the error of the discretisation"},
    {"particles", "either", "their number"},
    {"max_speed", "either", "highest speed of any particle"},
    {"volume", "fluid", "volume of water"},
    {"potential_energy", "fluid", "potential energy in gravity and the central force"},
    {"drag_work", "fluid", "work of the drag on both phases, since the start"},
    {"extent", "fluid", "how far the water reaches from the first of `points` towards the second"},
    {"spread", "fluid", "rms distance from the water's mean position, along the line of `points`"},
    {"level", "fluid", "level of the water behind the face, or in the well, named by `quantity`"},
    {"basin", "fluid",
     "of a field: water of the basin behind the face named by `quantity`: `_stored`; since the start `_in` (poured in, "
     "rain), `_out` (drawn off, evaporated), `_spilled` and `_seeped` (into the soil, less what came out of it); "
     "`_error` = in - out - spilled - seeped - gain"},
    {"passed_volume", "fluid",
     "volume that came in less volume that went out through the face or well named by `quantity`; absent: through all "
     "of them"},
    {"discharge", "fluid",
     "volume per time through the wet part of the line between two `points`, positive from its right to its left side; "
     "of a field in 3D through a flat section with `points` as its corners in order, positive along its normal by the "
     "right-hand rule; of a field also the inflow through the face, or the discharge pumped out by the well, named by "
     "`quantity`"},
    {"exit_height", "fluid",
     "elevation at which the water's surface meets a face, a line between two `points` (3D: of a field only)"},
    {"exit_gradient", "fluid",
     "largest outward hydraulic gradient over such a face; `_at`: its distance from the first of the `points`; "
     "`_over_critical`, where the face looks upwards: largest ratio to the gradient that lifts the grains off it, "
     "(1 - n)(rho_s / rho_w - 1) times the cosine of the face's slope"},
    {"pressure_force", "fluid",
     "force per width of the water's pressure on the line between two `points` [N/m], such as the uplift of a floor; "
     "suction does not count; `_at`: distance of its line of action from the first of them"},
    {"heave", "fluid",
     "of the line between two `points` in soil: the water's pressure on it over the weight of soil and water that lies "
     "above it up to the first gap, sums over the line; at 1 it lifts them"},
    {"balance", "fluid", "volumes `_in`, `_out`, `_stored` and `_error` = in - out - gain"},
    {"infiltration", "fluid",
     "of a field: rain that soaked in since the start, under the rain named by `quantity`; absent: all"},
    {"evaporation", "fluid", "of a field: soil water that has evaporated, likewise"},
    {"runoff", "fluid",
     "of a field: rain that could neither soak in nor pond, and soil water that came out under the rain where no face "
     "lies; likewise"},
    {"min_pressure", "fluid", "lowest pressure of any particle"},
    {"height", "solid", "of its surface above `points`"},
    {"grain_volume", "solid", "volume of the grains alone"},
    {"stress_noise", "solid", "rms departure of the mean effective stress from a linear field around each particle"},
    {"density_error", "solid", "rms of rho / rho_0 - 1 where the soil is packed"},
    {"factor_of_safety", "solid",
     "by which cohesion and tan(friction) of all soils can be divided before the soil finds no equilibrium under its "
     "weight, the loads and the water's forces of that instant; `_error`: half the width of the bracket"},
    {"plate", "solid",
     "of the plate named by `quantity`: the force with which it presses on the soil along its normal [N; 2D: N/m]; "
     "`_along` (2D): its force along the line, towards its last point [N/m]; `_displacement`: how far it has moved "
     "into the soil [m], at its middle. Of a plate that tilts also `_moment`: the moment about its middle that it puts "
     "on the soil [N m/m]; `_rotation`: how far it has turned [rad], both above zero where its last point presses into "
     "the soil; and, where it lifts, `_touching`: the part of its length that touches the soil [m]"},
    {"max_displacement", "solid", "largest displacement of any particle"},
    {"max_plastic_strain", "solid", "largest plastic strain of any particle"},
    {"slip_surface", "solid",
     "of all paths from the line of the first two `points` to that of the last two, the one along which the least "
     "plastic strain is largest: that strain"},
    {"uplift", "solid", "largest rise since the initial rest"},
    {"strain_energy", "solid", "elastic energy"},
    {"crest_level", "solid", "elevation of the top of the soil: of its highest particles that others touch, and half a spacing"},
    {"carried_off", "solid", "volume of the grains that free water has carried off since the start"},
    {"crest_settlement", "solid", "settlement of the highest particles since the initial rest"},
    {"pending_impulse", "solid",
     "impulse that the soil has received and that has not yet been taken from the water (`returned_impulse`)"},
};
// clang-format on

/// The kind of that name; nullptr if there is none.
inline const GaugeKind* find_gauge_kind(std::string_view name) {
  for (const auto& kind : gauge_kinds)
    if (kind.name == name) return &kind;
  return nullptr;
}

/// Whether one of the gauges is of this kind and belongs to this phase, "fluid" or "solid".
template <class Gauges>
bool asks_for(const Gauges& gauges, std::string_view phase, std::string_view kind) {
  for (const auto& gauge : gauges)
    if (gauge.phase == phase && gauge.kind == kind) return true;
  return false;
}

/// Table of all kinds for docs/case-file.md.
inline std::string gauge_kinds_table() {
  std::string text = "| Kind | Phase | Reads |\n| --- | --- | --- |\n";
  for (const auto& [name, phase, meaning] : gauge_kinds)
    text += "| `" + std::string(name) + "` | " + std::string(phase) + " | " + std::string(meaning) + " |\n";
  return text;
}

}  // namespace poretwin
