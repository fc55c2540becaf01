// `poretwin safety RUN`: the factor of safety of the soil at instants of a run that has ended, from its frames.
#pragma once

#include "cli/run.hpp"

#include <array>
#include <span>

namespace poretwin::cli {

/// The instants asked for: those named, multiples of a time, or the last frame where neither is given.
struct Instants {
  std::vector<double> at;       ///< s
  std::optional<double> every;  ///< s
};

struct SafetyOfRunOptions {
  std::filesystem::path run, out;  ///< out empty: RUN/safety
  Instants instants;
  double tolerance = 0.01;         ///< width of the bracket over the factor
  std::filesystem::path programs;  ///< folder of poretwin-solid
  bool quiet = false, pictures = true;
};

/// The factor at one instant and what fails there; a row of safety.csv (common/output/safety_row.hpp).
struct SafetyAtInstant {
  double time = 0.0, factor = 0.0, error = 0.0, stands = 0.0, fails = 0.0;
  std::string soil, face;            ///< of the soil that fails; empty where no soil fails
  double share = 0.0, volume = 0.0;  ///< share: fraction of the motion of all soil; volume: m2, 3D: m3
  std::array<double, 3> centre{}, towards{};
};

struct SafetyOfRun {
  std::string case_name, case_file;
  std::filesystem::path out;
  std::vector<SafetyAtInstant> instants;  ///< in the order of their times
  int exit = 0;
  std::string reason;
  double wall = 0.0, cpu = 0.0;  ///< s
  /// The instant with the least factor; nullptr where there is none.
  [[nodiscard]] const SafetyAtInstant* least() const;
};

/// Whether the path is the folder of a run.
bool is_run_folder(const std::filesystem::path& path);

/// Indices of the frames nearest to the instants, ascending, each once. Throws CaseError for an instant outside the
/// times of the frames (by more than their rounding). `say` receives a line for an instant between frames.
std::vector<std::size_t> frames_at(std::span<const double> times, const Instants& instants,
                                   const std::function<void(const std::string&)>& say);

/// Starts poretwin-solid on the frames and prints each factor as it is found. Writes OUT/safety.csv, OUT/gauges.csv
/// (factor_of_safety, factor_of_safety_error), OUT/solid.vtkhdf with failing_strain and failing_displacement, and
/// pictures. Throws CaseError and FileError, saying what to do, where the folder is not that of a run, a run is under
/// way in it, its case has changed since or its soil has no strength, or its frames cannot give a factor.
SafetyOfRun find_safety_of_run(const SafetyOfRunOptions& options);

/// The least factor and when it occurs.
std::string safety_of_run_text(const SafetyOfRun& safety);
nlohmann::ordered_json safety_of_run_json(const SafetyOfRunOptions& options, const SafetyOfRun& safety);

}  // namespace poretwin::cli
