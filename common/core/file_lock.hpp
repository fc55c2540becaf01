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
  /// Takes the lock, creating the file where there is none. `subject` begins the message: "runs/dam: another run writes
  /// into this folder". Throws FileError with the holder's text from the file when another process has the lock. If the
  /// holder has ended and programs that it started are still ending, waits for them. Where the file system has no
  /// locks, nothing is locked.
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
