#!/usr/bin/python3
"""Added-mass coefficient and acceleration of the disc, as a circle and as the body that particles on a lattice make of it.

Usage: added_mass.py    prints a table

Water at rest pushes back with the potential phi of a body that starts with unit velocity: Laplace's equation, phi = 0 on the free surface,
no flow through the tank's walls, the body's normal velocity on its edge (Lamb 1932, art. 92). The coefficient is the integral of phi
n_y over the edge, over the body's area. Solved by finite volumes on square cells that divide the squares of the lattice; corners make
the error one of order 4/3 in the cell, which is extrapolated away. With finer lattices the coefficient tends to the circle's at first order.
"""
import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import spsolve

TANK, CENTRE, RADIUS = 1.2, 0.6, 0.1  # m
GRAVITY, WATER, POROSITY = 9.81, 1000.0, 0.4
GRAINS = {"heavy": 2600.0, "light": 500.0}  # kg/m3
ORDER = 4.0 / 3.0  # of the flow at a corner of 270 degrees


def coefficient(spacing, parts):
    """Added mass over that of the displaced water; squares of `spacing` [m], each of them `parts` cells wide; and the body's area [m2]."""
    cell = spacing / parts
    n = round(TANK / cell)
    middle = (np.floor((np.arange(n) + 0.5) / parts) + 0.5) * spacing - CENTRE
    body = np.add.outer(middle**2, middle**2) < RADIUS**2
    number = np.full((n, n), -1)
    number[~body] = np.arange((~body).sum())
    unknowns = number.max() + 1
    diagonal, source, rows, columns = np.zeros(unknowns), np.zeros(unknowns), [], []
    for a, b in ((number[:-1], number[1:]), (number[:, :-1], number[:, 1:])):
        water = (a >= 0) & (b >= 0)
        rows += [a[water], b[water]]
        columns += [b[water], a[water]]
        for side in (a, b):
            np.add.at(diagonal, side[water], 1.0)
    diagonal[number[:, -1]] += 2.0  # half a cell to the surface
    above = number[:, 1:][body[:, :-1] & ~body[:, 1:]]
    below = number[:, :-1][body[:, 1:] & ~body[:, :-1]]
    source[above] += cell
    source[below] -= cell
    rows, columns = np.concatenate(rows), np.concatenate(columns)
    matrix = sparse.csc_matrix((-np.ones(rows.size), (rows, columns)), (unknowns, unknowns)) + sparse.diags(diagonal, format="csc")
    phi = spsolve(matrix, source)
    # On the edge, half a cell away, phi is larger by that times the velocity.
    impulse = cell * ((phi[above] + cell / 2).sum() - (phi[below] - cell / 2).sum())
    area = body.sum() * cell**2
    return impulse / area, area


def extrapolated(spacing, parts):
    coarse, fine = coefficient(spacing, parts)[0], coefficient(spacing, 2 * parts)[0]
    return fine + (fine - coarse) / (2.0**ORDER - 1.0)


def acceleration(grains, added):
    saturated = (1.0 - POROSITY) * grains + POROSITY * WATER
    return GRAVITY * (saturated - WATER) / (saturated + added * WATER)


print("body                     coefficient  acceleration [m/s2]: heavy    light")
for name, added in (("circle (sums of images)", 1.047), ("squares of 2 cm", extrapolated(0.02, 4)),
                    ("squares of 1 cm", extrapolated(0.01, 2)), ("squares of 5 mm", extrapolated(0.005, 1))):
    print(f"{name:23}  {added:11.4f}  {acceleration(GRAINS['heavy'], added):26.4f}  {acceleration(GRAINS['light'], added):7.4f}")
