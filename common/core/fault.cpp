#include "common/core/fault.hpp"

#include <errno.h>

#include <array>
#include <atomic>
#include <cstdlib>
#include <sstream>
#include <string>
#include <string_view>

namespace poretwin {
namespace {

struct Kind {
  std::string_view name;
  int error;
};
/// Name and errno of every value of Fallible, in its order.
constexpr std::array<Kind, 5> kinds{
    {{"open", EMFILE}, {"write", ENOSPC}, {"send", ENOBUFS}, {"map", ENOMEM}, {"allocate", ENOMEM}}};

struct Fault {
  int kind = -1;  ///< index in `kinds`; -1: none
  long first = 0;
  bool ever_after = false;
  std::atomic<long> calls = 0;

  Fault() {
    const char* requested = std::getenv("PORETWIN_FAIL");
    if (requested == nullptr) return;
    std::istringstream words(requested);
    std::string process, what, when;
    words >> process >> what >> when;
    if (std::string_view(program_invocation_short_name) != "poretwin-" + process) return;
    first = std::atol(when.c_str());
    ever_after = when.ends_with('+');
    for (std::size_t k = 0; k < kinds.size(); ++k)
      if (kinds[k].name == what && first > 0) kind = static_cast<int>(k);
  }
};

}  // namespace

bool fails(Fallible what) {
  static Fault fault;
  const int kind = static_cast<int>(what);
  if (fault.kind != kind) return false;
  const long call = ++fault.calls;
  if (call < fault.first || (call > fault.first && !fault.ever_after)) return false;
  errno = kinds[static_cast<std::size_t>(kind)].error;
  return true;
}

}  // namespace poretwin
