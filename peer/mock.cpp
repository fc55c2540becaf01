#include "common/core/error.hpp"
#include "common/coupling/phase_main.hpp"
#include "peer/arguments.hpp"
#include "peer/peer.hpp"
#include "peer/still.hpp"

namespace poretwin::peer {

int mock(const std::string& role, const std::vector<std::string>& arguments) {
  if (role != "fluid" && role != "solid") throw CaseError("peer mock: expected fluid or solid, got '" + role + "'");
  const auto which = role == "fluid" ? coupling::Role::fluid : coupling::Role::solid;
  ArgumentList list("poretwin-" + role, arguments);
  return coupling::phase_main(list.count(), list.data(), which,
                              [which](const Case& scene) { return make_still(scene, which); });
}

}  // namespace poretwin::peer
