// poretwin-solid --safety-of: the factor of safety of the soil in frames of a run that has ended.
#pragma once

namespace poretwin::solid {

/// Whether the command line contains --safety-of.
bool asks_for_safety(int argc, char** argv);

/// Reads the frames and searches for the factor of safety of each, with the previous frame's factor as first guess.
/// Writes to OUT: safety.csv, with a row for each frame as soon as its factor is found (columns: safety_columns);
/// solid.vtkhdf, with frames of failing_strain and failing_displacement, the plastic strain and the displacement [m] in
/// the failing trial nearest to the factor; and the factors as gauges. Returns the exit code of the process.
int safety_main(int argc, char** argv);

}  // namespace poretwin::solid
