// The points at which the screens of wells pierce cells, and the transmissibility between such a point and its well.
#pragma once

#include "pore_solver/network.hpp"

namespace poretwin::pore {

/// Adds the segments of the case's wells to a network: one for each cell that a screen pierces.
///
/// The head at a point stands for a cell that is much wider than the well. With the transmissibility of the links, this
/// head equals that of Thiem's (1906) flow, h = q / (2 pi K) ln r, at an equivalent radius r_e (Peaceman 1978). Hence a
/// length L of screen of radius r_w has the transmissibility
///
///   T_w = 2 pi L / ln(r_e / r_w)
///
/// r_e follows from the network itself: the heads of the points within a few spacings of the axis are solved for, with
/// unit flow out of the pierced cells and ln r prescribed at the points around them. The solution at a pierced point is
/// ln r_e. On a square lattice r_e = 0.1985 spacings, the exact exp(-gamma) / sqrt(8) of the lattice's Green's
/// function. A well acts at the points whose cells it pierces, at most half a cell's diagonal from its drawn axis.
void add_wells(const Case& scene, Network& network);

/// A cell that a screen pierces.
struct Pierced {
  Index point = 0;
  double from = 0.0, to = 0.0;     ///< m, along the axis from its start: the part in the point's cell
  double equivalent_radius = 0.0;  ///< m
};
/// The cells that a well's screen pierces, in their order along the screen (3D), or the cell around the well (2D).
std::vector<Pierced> pierced_by(const Case& scene, const Network& network, const Well& well);

}  // namespace poretwin::pore
