// poretwin-solid --safety-of: the factor of safety of the soil in frames of a run that has ended.
#pragma once

namespace poretwin::solid {

/// Whether the command line asks for it.
bool asks_for_safety(int argc, char** argv);

/// Reads the frames, searches for the factor of each, the first guess being the factor before, and writes to OUT:
/// safety.csv, a row per frame as soon as it is found (columns: safety_columns); frames with failing_strain and
/// failing_displacement, the plastic strain and the displacement [m] in the failing trial nearest to the factor, in
/// solid.vtkhdf; and the factors as gauges. Returns the exit code of the process.
int safety_main(int argc, char** argv);

}  // namespace poretwin::solid
