#!/usr/bin/python3
"""Rotation of the footing of elastic.toml and consolidation.toml by finite elements: bilinear squares on the same layer, extrapolated to a size of
zero. Before water leaves, the layer keeps its volume: then Poisson's ratio is 0.4999 at the same shear modulus, and the volume of each square changes
as at its middle.

Usage: rotation.py [SIZE ...]    SIZE: sides of the squares [m], each half of the one before (default: 0.1 0.05 0.025)

The stiffness against rotation, moment over angle, converges with the first power of the size, since the stress is unbounded at the footing's ends.
For a smooth strip on a half plane it is pi E B^2 / (16 (1 - nu^2)) (Muskhelishvili 1953): 51.8 MN m per metre.
"""
import sys

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import spsolve

WIDTH, HEIGHT, FOOTING = 8.0, 3.0, 2.0  # m
E, NU, MOMENT = 60e6, 0.3, 10e3  # Pa, 1, N m per metre


def strains(a, b, size):
    """Strains xx, yy and 2 xy [3, 8] at the place (a, b) of a square, a and b from -1 to 1, per displacement of its corners."""
    slope = np.array([[b - 1, 1 - b, 1 + b, -1 - b], [a - 1, -1 - a, 1 + a, 1 - a]]) / (2 * size)
    strain = np.zeros((3, 8))
    strain[0, 0::2] = strain[2, 1::2] = slope[0]
    strain[1, 1::2] = strain[2, 0::2] = slope[1]
    return strain


def element(size, nu):
    """Stiffness matrix [8, 8] of a square."""
    shear = E / (2 * (1 + NU))
    lame = 2 * shear * nu / (1 - 2 * nu)
    middle = strains(0, 0, size)[:2].sum(axis=0)
    total = size**2 * lame * np.outer(middle, middle)
    for a in (-1 / np.sqrt(3), 1 / np.sqrt(3)):
        for b in (-1 / np.sqrt(3), 1 / np.sqrt(3)):
            strain = strains(a, b, size)
            total += strain.T @ np.diag([2 * shear, 2 * shear, shear]) @ strain * size**2 / 4
    return total


def stiffness(size, rough, nu):
    """Moment [N m per metre] on the footing per angle."""
    nx, ny = round(WIDTH / size), round(HEIGHT / size)
    i, j = np.meshgrid(np.arange(nx), np.arange(ny), indexing="ij")
    node = lambda a, b: a * (ny + 1) + b
    corners = np.stack([node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)], -1).reshape(-1, 4)
    unknown = np.stack([2 * corners, 2 * corners + 1], -1).reshape(-1, 8)
    entries = np.tile(element(size, nu).ravel(), len(unknown))
    matrix = sparse.coo_matrix((entries, (np.repeat(unknown, 8, 1).ravel(), np.tile(unknown, (1, 8)).ravel()))).tocsr()
    x = np.repeat(np.arange(nx + 1) * size, ny + 1) - WIDTH / 2
    y = np.tile(np.arange(ny + 1) * size, nx + 1)
    held, u = np.zeros(2 * len(x), bool), np.zeros(2 * len(x))
    under = (y > HEIGHT - 1e-9) & (abs(x) < FOOTING / 2 + 1e-9)
    held[0::2] = (y < 1e-9) | (abs(x) > WIDTH / 2 - 1e-9) | (under if rough else False)
    held[1::2] = (y < 1e-9) | under
    u[1::2][under] = x[under]
    free = ~held
    u[free] = spsolve(matrix[free][:, free].tocsc(), -(matrix[free][:, held] @ u[held]))
    return ((matrix @ u)[1::2] * x)[under].sum()


sizes = [float(size) for size in sys.argv[1:]] or [0.1, 0.05, 0.025]
for rough, nu in ((True, NU), (False, NU), (True, 0.4999)):
    found = np.array([stiffness(size, rough, nu) for size in sizes])
    step = np.diff(found)
    limit = found[-1] + step[-1] / (step[-2] / step[-1] - 1)
    print("rough" if rough else "smooth", nu, "MN m:", *np.round(found / 1e6, 3), f"limit {limit / 1e6:.3f}, angle {MOMENT / limit:.5e}")
