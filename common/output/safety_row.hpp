// OUT/safety.csv of `poretwin safety RUN`, which poretwin-solid writes and the command reads.
#pragma once

namespace poretwin {

/// Its columns. factor: inf where the soil stands at any factor tried. The last columns tell what fails, and are empty
/// where nothing does: the soil of which most of it consists; the water face nearest to its centre (2D); its share of
/// the motion of all soil (soil may fail on two sides); its volume [m2; 3D: m3], its centre, and the unit vector along
/// which it moves.
inline constexpr const char* safety_columns =
    "frame,time_s,factor,error,stands,fails,soil,face,share,volume,x_m,y_m,z_m,towards_x,towards_y,towards_z";

}  // namespace poretwin
