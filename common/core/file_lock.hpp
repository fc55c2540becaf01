// A lock (flock) on a file, so that only one run writes into a folder. The kernel releases the lock in whatever way its
// holder ends. The file itself remains and names the holder.
#pragma once

#include <filesystem>
#include <string>

namespace poretwin {

class FileLock {
 public:
  /// Whether programs that the holder starts also hold the lock, until the last of them has ended.
  enum class Inherited { no, yes };

  FileLock() = default;
  /// Takes the lock; creates the file if it does not exist. `subject` begins the message: "runs/dam: another run writes
  /// into this folder". Throws FileError with the holder's text from the file if another process has the lock. If the
  /// holder has ended but programs that it started have not, waits for these. On a file system without locks nothing is
  /// locked.
  FileLock(const std::filesystem::path& file, const std::string& subject, Inherited inherited);
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;
  FileLock(FileLock&& other) noexcept;
  FileLock& operator=(FileLock&& other) noexcept;
  ~FileLock();

  /// Writes a description of the holder into the file: `what` ("poretwin run dam"), process, machine and time.
  void sign(const std::string& what) const;
  explicit operator bool() const { return descriptor_ >= 0; }

 private:
  std::filesystem::path file_;
  int descriptor_ = -1;
};

}  // namespace poretwin
