// The kinds of gauges: the one list that the case file's reference, its check and the solvers go by.
#pragma once

#include <string>
#include <string_view>

namespace poretwin {

struct GaugeKind {
  std::string_view name;
  std::string_view phase;    ///< "fluid", "solid" or "either"
  std::string_view meaning;  ///< what it reads, and which of the gauge's keys it needs
};

// clang-format off: one row each
inline constexpr GaugeKind gauge_kinds[] = {
    {"point", "either", "a field at `points`"},
    {"front", "either",
     "along the line between two `points`: of the water its wetting front (up a vertical line: the water table), of "
     "the soil its farthest place of a given "
     "`thickness`"},
    {"momentum", "either", "sum over the particles"},
    {"kinetic_energy", "either", "sum over the particles"},
    {"energy", "either", "kinetic and potential, of the soil elastic, too"},
    {"received_impulse", "either", "from the other phase, since the start"},
    {"unexplained_impulse", "either",
     "momentum less what weight, walls and the other phase gave since the start; the water counts all that its "
     "pressure on walls does (2D), on the soil too: of the two phases' sum the discretisation is left"},
    {"particles", "either", "their number"},
    {"max_speed", "either", "of any particle"},
    {"volume", "fluid", "of water"},
    {"potential_energy", "fluid", "in gravity and the central force"},
    {"drag_work", "fluid", "of the drag on both phases, since the start"},
    {"extent", "fluid", "how far the water reaches from the first of `points` towards the second"},
    {"spread", "fluid", "rms distance from the water's mean position, along the line of `points`"},
    {"level", "fluid", "of the water behind the face named by `quantity`"},
    {"passed_volume", "fluid", "come in less gone out through the face named by `quantity`; absent: through all"},
    {"discharge", "fluid",
     "volume per time through the wet part of a line, from its right to its left; of a field also in through the face "
     "named by `quantity`"},
    {"exit_height", "fluid", "elevation at which the water's surface meets a face, a line between two `points`"},
    {"exit_gradient", "fluid", "largest outward hydraulic gradient over such a face"},
    {"balance", "fluid", "volumes `_in`, `_out`, `_stored` and `_error` = in - out - gain"},
    {"infiltration", "fluid",
     "of a field: rain that soaked in since the start, under the rain named by `quantity`; absent: all"},
    {"evaporation", "fluid", "of a field: soil water that left as vapour, likewise"},
    {"runoff", "fluid", "of a field: what could neither soak in nor pond, likewise"},
    {"min_pressure", "fluid", "lowest of any particle"},
    {"height", "solid", "of its surface above `points`"},
    {"grain_volume", "solid", "of the grains alone"},
    {"stress_noise", "solid", "rms of the mean effective stress against a linear field around each particle"},
    {"density_error", "solid", "rms of rho / rho_0 - 1 where the soil is packed"},
    {"factor_of_safety", "solid",
     "by which cohesion and tan(friction) of all soils can be divided before the soil finds no equilibrium under weight, "
     "loads and the water's forces of that instant; `_error`: half the bracket; every `every` seconds"},
    {"max_displacement", "solid", "of any particle"},
    {"max_plastic_strain", "solid", "of any particle"},
    {"slip_surface", "solid",
     "weakest link of the most sheared path from the line of the first two `points` to that of the last two: plastic "
     "strain that it has everywhere"},
    {"uplift", "solid", "largest rise since the initial rest"},
    {"strain_energy", "solid", "elastic"},
    {"crest_settlement", "solid", "of the highest particles, since the initial rest"},
    {"pending_impulse", "solid",
     "impulse that the soil has received and that has not yet been taken from the water (`returned_impulse`)"},
};
// clang-format on

/// The kind of that name, or none.
inline const GaugeKind* find_gauge_kind(std::string_view name) {
  for (const auto& kind : gauge_kinds)
    if (kind.name == name) return &kind;
  return nullptr;
}

/// Whether one of the gauges is of this kind and reads this phase, "fluid" or "solid".
template <class Gauges>
bool asks_for(const Gauges& gauges, std::string_view phase, std::string_view kind) {
  for (const auto& gauge : gauges)
    if (gauge.phase == phase && gauge.kind == kind) return true;
  return false;
}

/// One sentence for the reference of keys.
inline std::string gauge_kinds_text() {
  std::string text;
  for (const std::string_view phase : {"either", "fluid", "solid"}) {
    text += text.empty() ? "Of either phase: " : phase == "fluid" ? " Of the fluid: " : " Of the solid: ";
    std::string separator;
    for (const auto& kind : gauge_kinds) {
      if (kind.phase != phase) continue;
      text += separator + "`" + std::string(kind.name) + "` (" + std::string(kind.meaning) + ")";
      separator = ", ";
    }
    text += ".";
  }
  return text;
}

}  // namespace poretwin
