// The recorder of a real run: <phase>.vtkhdf with provenance, <phase>.xmf and gauges.<phase>.csv in the run's folder.
#pragma once

#include "common/case/case.hpp"
#include "common/output/recorder.hpp"

#include <filesystem>
#include <memory>
#include <string>

namespace poretwin {

/// Creates the folder and the files (older ones of the same name are replaced), or to go on with a checkpoint leaves
/// them until it is loaded. Throws FileError.
/// The gauges' series go into the HDF5 file (/gauges) when the recorder is destroyed.
std::unique_ptr<Recorder> make_run_recorder(const std::filesystem::path& out_dir, const std::string& phase_name,
                                            const Case& scene, bool to_resume = false);

}  // namespace poretwin
