// Any text as a case file gives a CaseError or a case.
#include "common/case/case.hpp"
#include "common/core/error.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <string>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const int file = ::memfd_create("case", 0);
  static const std::string path = "/proc/self/fd/" + std::to_string(file);
  if (::ftruncate(file, 0) != 0 || ::pwrite(file, data, size, 0) != static_cast<ssize_t>(size)) std::abort();
  try {
    const poretwin::Case scene = poretwin::read_case(path);
    if (scene.digest().size() != 16) std::abort();
  } catch (const poretwin::CaseError&) {
    // refused with a reason
  }
  return 0;
}
