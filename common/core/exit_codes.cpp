#include "common/core/exit_codes.hpp"

#include <fmt/format.h>

namespace poretwin {

std::string exit_codes_text() {
  std::string text = "Exit codes:\n";
  for (const auto& [code, meaning] : exit_meanings)
    text += fmt::format("  {:>3}  {}\n", static_cast<int>(code), meaning);
  return text;
}

}  // namespace poretwin
