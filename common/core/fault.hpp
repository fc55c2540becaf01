// Failures on demand: what the machine refuses once in a year is asked for by a test. PORETWIN_FAIL="fluid write 3"
// lets the third write of poretwin-fluid fail as a full disk would, "coupler send 1+" every sending of the coupler.
#pragma once

namespace poretwin {

enum class Fallible { open, write, send, map, allocate };

/// Is this the call of its kind that is to fail? Then errno says why. Costs one look at a constant where none is asked
/// for.
bool fails(Fallible what);

}  // namespace poretwin
