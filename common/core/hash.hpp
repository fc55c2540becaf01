// A hash of case files and of files on disk. It is the same on every machine and in every version.
#pragma once

#include <cstdint>
#include <string_view>

namespace poretwin {

/// 64-bit FNV-1a. `hash`: the hash of the text before this text.
inline std::uint64_t fnv1a(std::string_view text, std::uint64_t hash = 14695981039346656037ULL) {
  for (const char c : text) {
    hash ^= static_cast<unsigned char>(c);
    hash *= 1099511628211ULL;
  }
  return hash;
}

}  // namespace poretwin
