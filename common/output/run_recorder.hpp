// The recorder of a real run: <phase>.vtkhdf with its provenance, <phase>.xmf and gauges.<phase>.csv in the run's
// folder.
#pragma once

#include "common/case/case.hpp"
#include "common/output/recorder.hpp"

#include <filesystem>
#include <memory>
#include <string>

namespace poretwin {

/// Creates the folder and the files. Replaces files of the same names, unless `to_resume` is set: then they stay until
/// a checkpoint is loaded. When the recorder is destroyed, it adds the gauge readings to the HDF5 file (/gauges).
/// Throws FileError.
std::unique_ptr<Recorder> make_run_recorder(const std::filesystem::path& out_dir, const std::string& phase_name,
                                            const Case& scene, bool to_resume = false);

}  // namespace poretwin
