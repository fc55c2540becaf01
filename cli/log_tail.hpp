// Follows what the processes of a run write to their logs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace poretwin::cli {

class LogTail {
 public:
  /// from_now: follows the files from their present ends, otherwise from their beginnings. `line` receives each
  /// complete line, without its time of day.
  LogTail(std::vector<std::filesystem::path> files, bool from_now, std::function<void(const std::string&)> line);
  /// Reads what has been added. A file that has become shorter is read again from its beginning.
  void read();

 private:
  struct File {
    std::filesystem::path path;
    std::uintmax_t at = 0;
  };
  std::vector<File> files_;
  std::function<void(const std::string&)> line_;
};

}  // namespace poretwin::cli
