// Which program made a result: goes into every file and into --version.
#pragma once

#include <filesystem>
#include <string>

namespace poretwin {

std::string version();   ///< "0.1.0 (1a2b3c4)"
std::string build();     ///< "Release, GNU 12.2.0"
std::string host();      ///< the machine's name
std::string time_now();  ///< UTC, ISO 8601

/// Hash of the bytes of a program's file, which an edit that is compiled without a commit changes, too. "none" where
/// there is no such file.
std::string program_hash(const std::filesystem::path& program);

}  // namespace poretwin
