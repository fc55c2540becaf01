#include "cli/ranks.hpp"

#include "common/core/error.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <sstream>
#include <string_view>

namespace poretwin::cli {
namespace fs = std::filesystem;
namespace {

/// Whether the solvers beside this program were built with MPI.
constexpr bool has_tiles =
#ifdef PORETWIN_HAS_TILES
    true;
#else
    false;
#endif

/// The file of a program that the shell would find; empty if there is none.
fs::path found_in_path(const std::string& program) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');)
    if (const fs::path file = fs::path(folder) / program; ::access(file.c_str(), X_OK) == 0) return file;
  return {};
}

}  // namespace

void expect_tiles(const RunOptions& options, const Case& scene) {
  const auto refuse = [&](std::string_view why) { throw CaseError(fmt::format("--tiles {}: {}", options.tiles, why)); };
  if (scene.has_field()) refuse("expected water as particles, found fluid.representation");
  if (!options.fluid.empty()) refuse("expected poretwin's own fluid solver, found --fluid");
  if (!has_tiles)
    refuse(
        "the solvers were built without MPI: install libopenmpi-dev, openmpi-bin and libtrilinos-zoltan-dev, "
        "then build again");
  if (found_in_path("mpirun").empty()) refuse("expected mpirun in PATH, found none: install openmpi-bin");
}

Program over_ranks(const RunOptions& options, Program solver) {
  const int ranks = options.tiles;
  if (ranks == 1) return solver;
  std::vector<std::string> started{"--bind-to", "none", "-n", std::to_string(ranks)};
  // Where the user says how many processes a machine takes, mpirun refuses more.
  if (options.hosts.empty())
    started.emplace_back("--oversubscribe");
  else
    started.insert(started.end(), {"--hostfile", options.hosts.string(), "-x", "OMP_NUM_THREADS"});
  started.push_back(fs::absolute(solver.file).string());
  solver.file = found_in_path("mpirun");
  solver.arguments.insert(solver.arguments.begin(), started.begin(), started.end());
  solver.by_mpirun = true;
  solver.stop_signal = SIGUSR1;
  // How many cores other machines have is not known here: there a rank has one thread, or as many as the user says.
  const bool here = options.hosts.empty(), said = std::getenv("OMP_NUM_THREADS") != nullptr;
  const int threads = here ? available_threads() / ranks : said ? available_threads() : 1;
  solver.environment["OMP_NUM_THREADS"] = std::to_string(std::max(1, threads));
  // mpirun asks root twice. Ranks on one machine: the fast way to copy between processes is often forbidden in
  // containers, and OpenMPI complains of it.
  solver.environment["OMPI_ALLOW_RUN_AS_ROOT"] = solver.environment["OMPI_ALLOW_RUN_AS_ROOT_CONFIRM"] = "1";
  solver.environment["OMPI_MCA_btl_vader_single_copy_mechanism"] = "none";
  return solver;
}

}  // namespace poretwin::cli
