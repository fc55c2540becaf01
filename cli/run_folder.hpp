// The folder of a run: to which run it belongs, what it contains, and whether a run may begin or resume there. Until
// that is decided, nothing in the folder is changed.
#pragma once

#include "common/checkpoint/store.hpp"
#include "common/core/file_lock.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace poretwin::cli {

/// The entries of run.toml that are read back.
struct RunRecord {
  std::string case_name, case_file, started, ended, reason;
  std::optional<int> exit;  ///< absent: the run still runs, or was killed
  RunIdentity identity;
  std::vector<std::string> overrides;
};

/// Reads run.toml; nothing where there is none. Throws CaseError when it cannot be read.
std::optional<RunRecord> read_run_record(const std::filesystem::path& out);

struct RunClaim {
  std::filesystem::path out;
  std::string case_name;
  RunIdentity identity;         ///< of case and programs
  std::string leader;           ///< the process whose checkpoints are counted
  bool resume = false;          ///< resume the run in the folder
  bool overwrite = false;       ///< begin anew, whatever run is there
  bool accept_changed_program = false;
};

/// Locks the folder for one run, as long as this object and the programs that the run starts exist.
class RunFolder {
 public:
  /// New run: allowed in a folder without a run; replaces a run that has ended; replaces a run of another case, or one
  /// that can be resumed or was broken off, only with `overwrite`. Resuming: needs the same case, settings and
  /// programs, and a checkpoint. Otherwise throws FileError or CaseError, saying what is there and what to do, and
  /// changes nothing.
  explicit RunFolder(const RunClaim& claim);

  /// The run to be resumed has already ended; nothing was changed.
  [[nodiscard]] bool already_finished() const { return finished_; }
  /// Describes the run that a new run replaces; empty: none.
  [[nodiscard]] const std::string& replaced() const { return replaced_; }
  /// Deletes results and checkpoints of earlier runs, before a start from the beginning.
  void clear() const;

 private:
  std::filesystem::path out_;
  FileLock lock_;
  bool finished_ = false;
  std::string replaced_;
};

/// Locks the folder of a run that has ended, so that no run can begin there. Throws FileError where a run is under way
/// in the folder.
FileLock lock_ended_run(const std::filesystem::path& run, const std::string& what);

/// Subfolder of a run's folder for what `poretwin safety RUN` finds.
inline constexpr const char* safety_folder = "safety";

/// Locks a folder in which one command makes several runs.
FileLock lock_folder(const std::filesystem::path& out, const std::string& what);

}  // namespace poretwin::cli
