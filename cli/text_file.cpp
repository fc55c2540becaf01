#include "cli/text_file.hpp"

#include "common/core/error.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fstream>

namespace poretwin::cli {

void write_file(const std::filesystem::path& path, const std::string& text) {
  std::ofstream stream(path, std::ios::binary);
  stream << text;
  stream.close();
  if (!stream) throw FileError(fmt::format("{}: cannot be written: {}", path.string(), std::strerror(errno)));
}

}  // namespace poretwin::cli
