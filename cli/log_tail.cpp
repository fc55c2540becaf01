#include "cli/log_tail.hpp"

#include <algorithm>
#include <fstream>

namespace poretwin::cli {

LogTail::LogTail(std::vector<std::filesystem::path> files, bool from_now, std::function<void(const std::string&)> line)
    : line_(std::move(line)) {
  for (auto& path : files) {
    std::error_code none;
    const auto size = std::filesystem::file_size(path, none);
    files_.push_back({std::move(path), from_now && !none ? size : 0});
  }
}

void LogTail::read() {
  for (auto& file : files_) {
    std::error_code none;
    const auto size = std::filesystem::file_size(file.path, none);
    if (none) continue;
    if (size < file.at) file.at = 0;
    if (size == file.at) continue;
    std::ifstream stream(file.path, std::ios::binary);
    stream.seekg(static_cast<std::streamoff>(file.at));
    std::string text(static_cast<std::size_t>(size - file.at), '\0');
    stream.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(stream.gcount()));
    std::size_t from = 0;
    for (auto end = text.find('\n'); end != std::string::npos; end = text.find('\n', from)) {
      std::string line = text.substr(from, end - from);
      if (line.starts_with("[") && line.find("] ") != std::string::npos) line.erase(0, line.find("] ") + 2);
      line_(line);
      from = end + 1;
    }
    file.at += from;
  }
}

}  // namespace poretwin::cli
