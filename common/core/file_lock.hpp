// Who writes into a folder: a lock (flock) on a file in it. The kernel releases it however its holder ends, so none is
// ever left behind; the file itself stays, and names the holder.
#pragma once

#include <filesystem>
#include <string>

namespace poretwin {

class FileLock {
 public:
  /// Whether programs that the holder starts hold the lock too, until the last of them has ended.
  enum class Inherited { no, yes };

  FileLock() = default;
  /// Takes the lock, making the file where there is none. `subject` begins the complaint: "runs/dam: another run writes
  /// into this folder". Throws FileError with the holder's own words when somebody else has it. A holder that is gone
  /// while programs it started still end is waited for. Where the file system knows no locks, nothing is locked.
  FileLock(const std::filesystem::path& file, const std::string& subject, Inherited inherited);
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;
  FileLock(FileLock&& other) noexcept;
  FileLock& operator=(FileLock&& other) noexcept;
  ~FileLock();

  /// Writes into the file who holds it: `what` ("poretwin run dam"), process, machine and time.
  void sign(const std::string& what) const;
  explicit operator bool() const { return descriptor_ >= 0; }

 private:
  std::filesystem::path file_;
  int descriptor_ = -1;
};

}  // namespace poretwin
