// Checkpoints on disk: OUT/checkpoints/<process>-<name>.state. Such a file is always complete (it is written under a
// temporary name, flushed to disk by fsync, then renamed), has a checksum, and identifies the run that wrote it.
#pragma once

#include "common/core/archive.hpp"

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace poretwin {

/// Number of complete checkpoints on disk: older ones are removed.
inline constexpr std::size_t checkpoint_generations = 2;

struct Checkpoint {
  std::string name;        ///< the same in all processes; never used twice
  std::uint64_t step = 0;  ///< number of accepted windows
  double time = 0.0;       ///< s
};

/// The properties that must be equal in the run that wrote a state and in the run that resumes from it: pairs of a
/// description and a value. The description is reported where values differ.
using RunIdentity = std::vector<std::pair<std::string, std::string>>;

/// The entry for the program that wrote the state; the user may allow it to differ (--accept-changed-program).
inline constexpr const char* program_entry = "program";

/// Throws CaseError with the first entry that differs, and what the user can do. `place`: the file or process that has
/// the identity `found`.
void expect_same(const std::string& place, const RunIdentity& expected, const RunIdentity& found,
                 bool accept_changed_program);

class CheckpointStore {
 public:
  using Say = std::function<void(const std::string&)>;
  CheckpointStore(const std::filesystem::path& out, std::string process, RunIdentity identity, Say say = {},
                  bool accept_changed_program = false);

  /// The checkpoints that can be read, newest first; damaged ones are reported and left out. Throws CaseError if one of
  /// them belongs to another case or program.
  [[nodiscard]] std::vector<Checkpoint> whole() const;
  /// Writes a checkpoint, which is durable when the function returns. Throws FileError.
  void write(const Checkpoint& checkpoint, const Archive& state) const;
  /// Reads the state of the checkpoint of that name. Throws FileError.
  [[nodiscard]] Archive read(const std::string& name) const;
  /// Removes all checkpoints of this process except those named.
  void keep_only(const std::vector<std::string>& names) const;

 private:
  struct Content {
    Checkpoint checkpoint;
    RunIdentity identity;
    std::string state;
  };
  [[nodiscard]] std::filesystem::path file_of(const std::string& name) const;
  [[nodiscard]] std::vector<std::filesystem::path> files() const;
  [[nodiscard]] Content content_of(const std::filesystem::path& file) const;

  std::filesystem::path folder_;
  std::string process_;
  RunIdentity identity_;
  Say say_;
  bool accept_changed_program_;
};

/// Whether the run's folder contains checkpoints of that process, complete or not.
bool has_checkpoints(const std::filesystem::path& out, const std::string& process);

}  // namespace poretwin
