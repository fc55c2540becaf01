// A solver's command as a child process: started, asked, told to end.
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
  /// The command's first word is looked for in PATH. Its output goes to `log`; empty: to ours.
  explicit Child(const std::vector<std::string>& command, const std::filesystem::path& log = {});
  /// Ends it with SIGKILL when it still runs.
  ~Child();
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  /// Exit code, 128 + n after signal n; nothing while it runs.
  std::optional<int> ended();
  std::optional<int> wait(std::chrono::milliseconds patience);
  void signal(int number);

 private:
  pid_t pid_ = -1;
  std::optional<int> code_;
};

/// A folder of our own for sockets, whose paths must be short; removed with everything in it.
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
