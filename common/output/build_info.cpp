#include "common/output/build_info.hpp"

#include "common/core/hash.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <ctime>
#include <fstream>

namespace poretwin {

std::string version() { return PORETWIN_VERSION; }

std::string build() { return PORETWIN_BUILD; }

std::string host() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? std::string(name.data()) : std::string("unknown");
}

std::string time_now() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text.data();
}

std::string program_hash(const std::filesystem::path& program) {
  std::ifstream stream(program, std::ios::binary);
  if (!stream) return "none";
  std::uint64_t hash = fnv1a({});
  std::array<char, 65536> bytes{};
  while (stream.read(bytes.data(), bytes.size()) || stream.gcount() > 0)
    hash = fnv1a({bytes.data(), static_cast<std::size_t>(stream.gcount())}, hash);
  return fmt::format("{:016x}", hash);
}

}  // namespace poretwin
