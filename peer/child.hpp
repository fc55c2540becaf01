// A solver's command as a child process: started, watched, stopped.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace poretwin::peer {

class Child {
 public:
  /// Starts the command; its first word is looked up in PATH. The command's output goes to the file `log`; if `log` is
  /// empty, to the output of this process.
  explicit Child(const std::vector<std::string>& command, const std::filesystem::path& log = {});
  /// Kills the process (SIGKILL) if it still runs.
  ~Child();
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  /// Exit code, or 128 + n after signal n; empty while the process runs.
  std::optional<int> ended();
  std::optional<int> wait(std::chrono::milliseconds patience);
  void signal(int number);

 private:
  pid_t pid_ = -1;
  std::optional<int> code_;
};

/// A temporary folder for sockets, whose paths must be short. It is removed with its content.
class PrivateFolder {
 public:
  PrivateFolder();
  ~PrivateFolder();
  PrivateFolder(const PrivateFolder&) = delete;
  PrivateFolder& operator=(const PrivateFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace poretwin::peer
