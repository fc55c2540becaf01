// The folder of a run: which run it belongs to, what lies in it, and whether a run may begin or resume there. Nothing
// in it is touched before that is decided.
#pragma once

#include "common/checkpoint/store.hpp"
#include "common/core/file_lock.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace poretwin::cli {

/// The entries of run.toml that are read again.
struct RunRecord {
  std::string case_name, case_file, started, ended, reason;
  std::optional<int> exit;  ///< absent: it has not ended, or was killed
  RunIdentity identity;
};

/// Reads run.toml; nothing where there is none. Throws CaseError when it cannot be read.
std::optional<RunRecord> read_run_record(const std::filesystem::path& out);

struct RunClaim {
  std::filesystem::path out;
  std::string case_name;
  RunIdentity identity;         ///< of the case and of its programs
  std::string leader;           ///< the process whose checkpoints count
  bool resume = false;          ///< go on with what is there
  bool overwrite = false;       ///< begin anew whatever run is there
  bool accept_changed_program = false;
};

/// Locks the folder for one run, as long as this object and the programs that the run starts exist.
class RunFolder {
 public:
  /// A new run: a folder without a run is taken; one that has ended is replaced; one of another case, and one that can
  /// be resumed or was broken off, only with `overwrite`. To resume: the same case, settings and programs, and a
  /// checkpoint. Throws FileError or CaseError that says what is there and what to do, and leaves the folder as it is.
  explicit RunFolder(const RunClaim& claim);

  /// The run to be resumed has ended already. Nothing was touched.
  [[nodiscard]] bool already_finished() const { return finished_; }
  /// What a new run replaces, for a person; empty: nothing.
  [[nodiscard]] const std::string& replaced() const { return replaced_; }
  /// Deletes results and checkpoints of earlier runs, before a start from the beginning.
  void clear() const;

 private:
  std::filesystem::path out_;
  FileLock lock_;
  bool finished_ = false;
  std::string replaced_;
};

/// The lock of a folder in which a command makes several runs.
FileLock lock_folder(const std::filesystem::path& out, const std::string& what);

}  // namespace poretwin::cli
