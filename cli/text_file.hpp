// Files that the command writes as a whole.
#pragma once

#include <filesystem>
#include <string>

namespace poretwin::cli {

/// Writes a file, in place of one that is there. Throws FileError where it cannot be written.
void write_file(const std::filesystem::path& path, const std::string& text);

}  // namespace poretwin::cli
