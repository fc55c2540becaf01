#include "cli/check.hpp"

#include "cli/json_output.hpp"
#include "common/case/materials.hpp"
#include "common/core/error.hpp"
#include "common/geometry/shapes.hpp"
#include "common/media/seepage.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

namespace poretwin::cli {
namespace {

constexpr double standard_gravity = 9.81;  // m/s2; a conductivity in m/s is defined with this gravity

template <int D>
ParticleCount count(const Case& scene) {
  ParticleCount result;
  const auto& f = scene.fluid;
  const auto count = [&](const Shape& shape) {
    result.fluid += fill<D>(shape, f.particle_spacing, f.offset, 0.0, f.seed).position.size();
  };
  if (scene.has_field())
    for (const auto& soil : scene.soils) count(soil.shape);
  if (!scene.is_field())
    for (const auto& region : f.regions) count(region);
  const auto& s = scene.solid;
  if (scene.deformable())
    for (const auto& soil : scene.soils)
      result.solid += fill<D>(soil.shape, s.particle_spacing, s.offset, 0.0, s.seed).position.size();
  return result;
}

std::vector<Limit> limits(const Case& scene) {
  std::vector<Limit> result;
  if (scene.is_field()) {
    if (scene.coupling.interval) result.push_back({*scene.coupling.interval, "coupling.interval of the case"});
    return result;  // a field of pore water chooses its time steps by their error
  }
  const double gravity = scene.general.gravity.norm();
  if (gravity > 0.0 && scene.has_water())
    result.push_back(
        {0.3 * std::sqrt(scene.fluid.particle_spacing / gravity), "free surface under gravity, 0.3 sqrt(dx / g)"});
  const auto named = [](const Soil& soil) { return soil.name.empty() ? "" : " in '" + soil.name + "'"; };
  if (scene.fluid.scheme == FluidCase::Scheme::eisph_explicit_drag && scene.has_water() && scene.fluid.drag)
    for (const auto& soil : scene.soils)
      result.push_back(
          {porous::seepage_at(scene, soil, soil.porosity).conductivity / (soil.porosity * standard_gravity),
           "explicit drag" + named(soil) + ", k / (n g); no limit with another fluid.scheme"});
  if (!scene.deformable()) return result;
  for (const auto& soil : scene.soils) {
    const std::string where = named(soil);
    const double density = (1.0 - soil.porosity) * soil.grain_density;
    result.push_back(
        {scene.solid.particle_spacing / std::sqrt(constrained_modulus(scene, soil) / density),
         "elastic wave across one particle" + where +
             ", dx / sqrt(M / rho_bar_s); in longer windows the solid takes shorter steps or finds an equilibrium"});
    if (!scene.coupled() || !scene.fluid.drag) continue;
    // Stability limit of the exchange with a fluid that does not predict the skeleton's response
    // (docs/theory/coupling.md, "Other schemes").
    const bool parallel = scene.coupling.scheme == CouplingCase::Scheme::parallel;
    const double n_s = 1.0 - soil.porosity;
    const double b = n_s * n_s * scene.water.density / (soil.porosity * density);
    const double unit = density * porous::seepage_at(scene, soil, soil.porosity).conductivity /
                        (scene.water.density * standard_gravity);
    result.push_back({std::max(0.0, parallel ? 1.0 - b * b : 2.0 - 2.0 * b) * unit,
                      fmt::format("plain {} coupling{}, {} rho_bar_s k / gamma_w with b = n_s^2 rho_w / (n rho_bar_s); "
                                  "lifted by fluid.skeleton_response",
                                  parallel ? "parallel" : "serial", where, parallel ? "(1 - b^2)" : "2 (1 - b)")});
  }
  if (scene.coupling.interval) result.push_back({*scene.coupling.interval, "coupling.interval of the case"});
  std::sort(result.begin(), result.end(), [](const Limit& a, const Limit& b) { return a.seconds < b.seconds; });
  return result;
}

const char* phases(const Case& scene) {
  return scene.coupled()      ? (scene.is_field() ? "water as a field and solid coupled" : "fluid and solid coupled")
         : scene.deformable() ? "soil alone"
         : scene.is_field()   ? "water as a field in rigid soil"
         : scene.is_both()    ? "free water as particles, and water as a field in rigid soil"
                              : "fluid alone in rigid soil";
}

}  // namespace

void expect_memory(const Case& scene) {
  const Amounts a = estimate(scene);
  const double pages = static_cast<double>(::sysconf(_SC_PHYS_PAGES)),
               there = pages * static_cast<double>(::sysconf(_SC_PAGESIZE));
  if (!(pages > 0.0) || a.memory_bytes <= there) return;
  throw CaseError(
      fmt::format("{}: key '{}.particle_spacing': about {:.3g} GB for {:.3g} particles: expected what this "
                  "machine has, {:.3g} GB; give a larger spacing, or run on a larger machine",
                  scene.path.string(), scene.has_water() ? "fluid" : "solid", a.memory_bytes / 1e9, a.fluid + a.solid,
                  there / 1e9));
}

ParticleCount count_particles(const Case& scene) {
  return scene.general.dimension == 3 ? count<3>(scene) : count<2>(scene);
}

CheckReport report_of(const Case& scene) {
  CheckReport report;
  report.amounts = estimate(scene);
  // Above this number the particles are only estimated, since making and counting them would take too long.
  constexpr double many = 2e6;
  const Amounts& amounts = report.amounts;
  report.estimated = amounts.fluid + amounts.solid > many;
  report.particles =
      report.estimated ? ParticleCount{static_cast<std::size_t>(amounts.fluid), static_cast<std::size_t>(amounts.solid)}
                       : count_particles(scene);
  report.intervals = limits(scene);
  return report;
}

std::string check_text(const Case& scene, const CheckReport& report) {
  const auto& [amounts, particles, estimated, intervals] = report;
  const char* about = estimated ? "about " : "";
  std::string text =
      fmt::format("{}: {}\n", scene.path.string(), scene.warnings.empty() ? "sound" : "sound, with warnings");
  if (!scene.general.title.empty()) text += fmt::format("title       {}\n", scene.general.title);
  text += fmt::format("dimension   {}, simulated time {} s, {}\n", scene.general.dimension, scene.general.end_time,
                      phases(scene));
  if (scene.has_water())
    text += fmt::format("fluid       {}{} {}, spacing {} m\n", about, particles.fluid,
                        scene.is_field()  ? "points"
                        : scene.is_both() ? "particles at the start and points in soil"
                                          : "particles at the start",
                        scene.fluid.particle_spacing);
  if (!scene.representation_chosen.empty()) text += fmt::format("auto        {}\n", scene.representation_chosen);
  if (scene.deformable())
    text +=
        fmt::format("solid       {}{} particles, spacing {} m\n", about, particles.solid, scene.solid.particle_spacing);
  text += fmt::format("gauges      {}", scene.gauges.size());
  if (amounts.gauge_rows > 0.0) text += fmt::format(", about {:.3g} readings", amounts.gauge_rows);
  text += fmt::format("\noutput      {:.0f} frames, about {:.3g} MB\n", amounts.frames, amounts.frame_bytes / 1e6);
  text += "intervals   estimates, smallest first\n";
  for (const auto& limit : intervals) text += fmt::format("  {:10.3g} s  {}\n", limit.seconds, limit.what);
  text += fmt::format("memory      about {:.0f} MB in all\n", amounts.memory_bytes / 1e6);
  for (const auto& warning : scene.warnings) text += fmt::format("warning: {}\n", warning);
  return text;
}

nlohmann::ordered_json check_json(const Case& scene, const CheckReport& report) {
  const auto& [amounts, particles, estimated, intervals] = report;
  Json json = json_head("check", 0, scene.warnings.empty() ? "sound" : "sound, with warnings");
  json["case_file"] = scene.path.string();
  json["title"] = scene.general.title;
  json["dimension"] = scene.general.dimension;
  json["end_time_s"] = scene.general.end_time;
  json["phases"] = phases(scene);
  json["representation_chosen"] =
      scene.representation_chosen.empty() ? Json(nullptr) : Json(scene.representation_chosen);
  json["particles_estimated"] = estimated;
  const auto phase = [](std::size_t count, double spacing) {
    return Json{{"particles", count}, {"spacing_m", spacing}};
  };
  json["fluid"] = scene.has_water() ? phase(particles.fluid, scene.fluid.particle_spacing) : Json(nullptr);
  json["solid"] = scene.deformable() ? phase(particles.solid, scene.solid.particle_spacing) : Json(nullptr);
  json["gauges"] = scene.gauges.size();
  json["gauge_readings"] = amounts.gauge_rows > 0.0 ? Json(amounts.gauge_rows) : Json(nullptr);
  json["frames"] = json_number(amounts.frames);
  json["frame_bytes"] = json_number(amounts.frame_bytes);
  json["memory_bytes"] = json_number(amounts.memory_bytes);
  json["intervals"] = Json::array();
  for (const auto& limit : intervals)
    json["intervals"].push_back({{"seconds", json_number(limit.seconds)}, {"what", limit.what}});
  json["warnings"] = scene.warnings;
  return json;
}

}  // namespace poretwin::cli
