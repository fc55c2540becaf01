// Injected failures, so that tests can produce rare errors of the system. PORETWIN_FAIL="fluid write 3" makes the third
// write of poretwin-fluid fail as on a full disk; "coupler send 1+" makes every send of the coupler fail.
#pragma once

namespace poretwin {

enum class Fallible { open, write, send, map, allocate };

/// Whether this call must fail; errno is then set. Costs one comparison where no failure is requested.
bool fails(Fallible what);

}  // namespace poretwin
