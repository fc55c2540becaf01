// The program that produced a result: written into every file and shown by --version.
#pragma once

#include <filesystem>
#include <string>

namespace poretwin {

std::string version();   ///< "0.1.0 (1a2b3c4)"
std::string build();     ///< "Release, GNU 12.2.0"
std::string host();      ///< the name of the machine
std::string time_now();  ///< UTC, ISO 8601

/// Hash of a program's file. It also differs after a change that was compiled but not committed. "none" if there is no
/// such file.
std::string program_hash(const std::filesystem::path& program);

}  // namespace poretwin
