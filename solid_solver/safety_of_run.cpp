#include "solid_solver/safety_of_run.hpp"

#include "common/core/error.hpp"
#include "common/coupling/interrupt.hpp"
#include "common/coupling/process_main.hpp"
#include "common/geometry/pieces.hpp"
#include "common/output/run_recorder.hpp"
#include "common/output/safety_row.hpp"
#include "solid_solver/output/failing_mass.hpp"
#include "solid_solver/output/report.hpp"
#include "solid_solver/output/stored_state.hpp"
#include "solid_solver/statics/initial_state.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <string_view>

namespace poretwin::solid {
namespace {

using coupling::Arguments;

/// A name as a cell of a CSV table.
std::string cell(std::string name) {
  std::ranges::replace_if(
      name, [](char c) { return c == ',' || c == '"' || c == '\n'; }, ' ');
  return name;
}

/// Name of the water face nearest to x [m] (2D); empty if that face has no name.
std::string nearest_face(const Case& scene, const Point3& x) {
  std::string name;
  if (scene.general.dimension != 2) return name;
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& face : scene.water_faces)
    for (const auto& piece : pieces_of(face.face)) {
      const double distance = distance_from(piece, x);
      if (!(distance < nearest)) continue;
      nearest = distance;
      name = face.name;
    }
  return name;
}

template <int D>
std::string row_of(const Case& scene, const Setup<D>& setup, std::size_t frame, const State<D>& state,
                   const FactorOfSafety<D>& found) {
  std::string row = fmt::format("{},{:.17g},{:.9g},{:.9g},{:.9g},{:.9g},", frame, state.time, found.factor(),
                                found.error(), found.stands, found.fails);
  const auto failing = failing_mass(setup, state, found.failing_displacement);
  if (!failing) return row + ",,,,,,,,,";
  Point3 centre = Point3::Zero(), towards = Point3::Zero();
  centre.head<D>() = failing->centre;
  towards.head<D>() = failing->towards;
  row += fmt::format("{},{},{:.6g},{:.6g}", cell(scene.soils[failing->soil].name), cell(nearest_face(scene, centre)),
                     failing->share, failing->volume);
  centre += scene.general.origin;
  for (const auto& vector : {centre, towards})
    for (int d = 0; d < 3; ++d) row += fmt::format(",{:.6g}", vector[d]);
  return row;
}

/// The soil of a frame, with the way in which it fails.
template <int D>
OutputFrame shown(const Setup<D>& setup, const State<D>& state, const FactorOfSafety<D>& found) {
  OutputFrame frame = frame_of(setup, state);
  std::erase_if(frame.fields, [](const OutputField& field) {
    return field.name == "velocity" || field.name == "water_force";  // a stored state does not have them
  });
  frame.fields.push_back(failing_strain_field(found.failing_strain, "the factor of safety"));
  frame.fields.push_back({{"failing_displacement", "m", "displacement of the soil that fails, likewise", 3},
                          write_vectors_by<D>([&found](std::size_t i) -> Vec<D> {
                            if (i < found.failing_displacement.size()) return found.failing_displacement[i];
                            return Vec<D>::Zero();
                          })});
  return frame;
}

struct Work {
  std::unique_ptr<Recorder> recorder;
  std::size_t found = 0;
};

/// Searches the factors for all frames; returns whether it was interrupted.
template <int D>
bool search_all(const Arguments& arguments, const Case& scene, Work& work) {
  const FrameFile frames(arguments.safety_of);
  work.recorder = make_run_recorder(arguments.out, "solid", scene);
  const auto table = arguments.out / "safety.csv";
  std::ofstream rows(table, std::ios::binary);
  rows << safety_columns << std::endl;
  auto [setup, particles] = set_up<D>(scene);
  const State<D> initial = laid_out(setup, std::move(particles));
  double last = 0.0;
  for (const std::size_t frame : arguments.frames) {
    if (frame >= frames.times().size())
      throw CaseError(fmt::format("argument --frame: expected less than {}, the number of frames in {}, found {}",
                                  frames.times().size(), arguments.safety_of.string(), frame));
    const auto stored = stored_state(setup, initial, frames, frame, scene.general.origin);
    const auto found = factor_of_safety(setup, stored.state, stored.water, search_near(last, arguments.tolerance));
    if (!found) return true;
    last = std::isfinite(found->fails) ? found->factor() : 0.0;
    work.recorder->gauges(stored.state.time, {{"factor_of_safety", found->factor(), "1"},
                                              {"factor_of_safety_error", found->error(), "1"}});
    work.recorder->frame(shown(setup, stored.state, *found));
    rows << row_of(scene, setup, frame, stored.state, *found) << std::endl;
    if (!rows) throw FileError(fmt::format("{}: cannot be written", table.string()));
    ++work.found;
  }
  return false;
}

}  // namespace

bool asks_for_safety(int argc, char** argv) {
  return std::any_of(argv, argv + argc, [](const char* word) { return std::string_view(word) == "--safety-of"; });
}

int safety_main(int argc, char** argv) {
  Work work;
  return coupling::process_main(argc, argv, "poretwin-solid", "solid", coupling::Program::solid,
                                {[&](const Arguments& arguments) {
                                   const Case scene = read_case(arguments.case_file, arguments.overrides);
                                   return scene.general.dimension == 3 ? search_all<3>(arguments, scene, work)
                                                                       : search_all<2>(arguments, scene, work);
                                 },
                                 [&] {
                                   coupling::RunSummary summary;
                                   summary.counters.emplace_back("factors of safety", static_cast<double>(work.found));
                                   if (work.recorder) summary.files = work.recorder->files();
                                   return summary;
                                 }});
}

}  // namespace poretwin::solid
