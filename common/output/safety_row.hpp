// OUT/safety.csv of `poretwin safety RUN`. poretwin-solid writes this file and the command reads it.
#pragma once

namespace poretwin {

/// The columns of the file. factor: inf if the soil is stable at every factor that was tried. The last columns describe
/// the failing mass, and are empty if nothing fails: the soil of which most of it consists; the water face nearest to
/// its centre (2D); its fraction of the motion of all soil (soil may fail on two sides); its volume [m2; 3D: m3], its
/// centre, and the unit vector along which it moves.
inline constexpr const char* safety_columns =
    "frame,time_s,factor,error,stands,fails,soil,face,share,volume,x_m,y_m,z_m,towards_x,towards_y,towards_z";

}  // namespace poretwin
