#include "common/output/build_info.hpp"

#include <unistd.h>

#include <array>
#include <ctime>

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

}  // namespace poretwin
