// OUT/safety.csv of `poretwin safety RUN`, which poretwin-solid writes and the command reads.
#pragma once

namespace poretwin {

/// Its columns. factor: inf where the soil stands at any factor tried. volume: m^D, of the soil that fails. x, y, z [m],
/// towards_x .. towards_z: its centre and the unit vector along which it moves; soil: the soil of which most of it
/// consists; face: the water face nearest to the centre (2D). The last ten are empty where nothing fails.
inline constexpr const char* safety_columns =
    "frame,time_s,factor,error,stands,fails,soil,face,volume,x_m,y_m,z_m,towards_x,towards_y,towards_z";

}  // namespace poretwin
