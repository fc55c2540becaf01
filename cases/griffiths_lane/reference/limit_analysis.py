#!/usr/bin/python3
"""Upper bounds of the factor of safety of this case's clay slopes by finite-element limit analysis, over all mechanisms, not only circles.

Usage: limit_analysis.py SIZE [RATIO ...]    SIZE: width of the elements [m], twice their height; RATIO: s_u2 / s_u1 (default: 0.2 0.6 1 2).
                                             Prints the bound for each ratio.

Upper-bound theorem: for every velocity field u that keeps the volume, meets the walls and lets the weight do work, the exact factor is at most

    F = integral of s_u sqrt(e1^2 + e2^2)  /  integral of gamma . u        e1 = du/dx - dv/dy, e2 = du/dy + dv/dx

for soil that flows without change of volume and can carry tension. u is quadratic on triangles (six nodes; rectangles cut along both diagonals), so
that the rates are linear, and what holds at the corners of a triangle holds in all of it: the volume is kept where it is kept at the corners, and the
mean of the convex integrand over the corners is not below its mean over the triangle (Makrodimopoulos & Martin 2007, Int. J. Numer. Anal. Meth. Geomech.
31, 835-865). The F of a finer mesh is lower. The field with the least F is found by Kacanov's iteration: each step solves a viscous flow with the
viscosity s_u / sqrt(e1^2 + e2^2 + d^2) of the last step, with d falling to 1e-4 of the mean rate. A bulk viscosity 1e6 times as large keeps the volume;
the rate at which it still changes, 1e-5 of the shear rate, times the mean pressure is less than 0.1 % of the integral.
"""
import sys

import bishop
import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import splu

CREST, THICKNESS, TOE = 20.0, 10.0, 20.0  # m: level ground above the slope, layer below it, level ground before it
STRENGTH = 50e3  # Pa, s_u1
STEPS, BULK, FLOOR = 45, 1e6, 1e-4


def mesh(slope, dx, dy):
    """Nodes [n, 2] and triangles [m, 6] (corners, then the middles of the sides 01, 12, 20)."""
    nodes, triangles = {}, []

    def node(x, y):
        return nodes.setdefault((round(x, 6), round(y, 6)), len(nodes))

    def add(*corners):
        corners = np.array(corners)
        middles = 0.5 * (corners + np.roll(corners, -1, axis=0))
        triangles.append([node(*p) for p in (*corners, *middles)])

    for i in range(round(slope.length / dx)):
        left, right = slope.top(np.array([i, i + 1]) * dx)
        for j in range(round(max(left, right) / dy)):
            a, b, c, d = [(i * dx + p * dx, j * dy + q * dy) for p, q in ((0, 0), (1, 0), (1, 1), (0, 1))]
            if c[1] <= min(left, right) + 1e-9:
                middle = (a[0] + 0.5 * dx, a[1] + 0.5 * dy)
                for p, q in ((a, b), (b, c), (c, d), (d, a)):
                    add(p, q, middle)
            elif abs(d[1] - left) < 1e-9 and abs(b[1] - right) < 1e-9:  # the slope is the diagonal of these rectangles
                add(a, b, d)
            else:
                raise SystemExit("expected rectangles whose diagonal is as steep as the slope, twice as wide as high")
    return np.array(list(nodes)), np.array(triangles)


def derivatives(x, triangles, r, s):
    """Matrices [m, n] of d/dx and d/dy at the place (r, s) of each triangle, and the values of the six shape functions there."""
    corner = x[triangles[:, :3]]
    inverse = np.linalg.inv(np.stack([corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]], axis=2))
    t = 1.0 - r - s
    local = np.array([[1 - 4 * t, 1 - 4 * t], [4 * r - 1, 0], [0, 4 * s - 1], [4 * (t - r), -4 * r], [4 * s, 4 * r], [-4 * s, 4 * (t - s)]])
    gradient = np.einsum("ki,tij->tkj", local, inverse)
    rows = np.repeat(np.arange(len(triangles)), 6)
    matrices = [sparse.csr_matrix((gradient[:, :, k].ravel(), (rows, triangles.ravel())), shape=(len(triangles), len(x))) for k in (0, 1)]
    return matrices, np.array([t * (2 * t - 1), r * (2 * r - 1), s * (2 * s - 1), 4 * t * r, 4 * r * s, 4 * s * t])


def rates(x, triangles, places, free):
    """Matrices of e1, e2 and du/dx + dv/dy at these places of all triangles, for the free components of the velocity (all u, then all v)."""
    parts = []
    for place in places:
        (along_x, along_y), _ = derivatives(x, triangles, *place)
        parts.append([sparse.hstack(pair) for pair in ((along_x, -along_y), (along_y, along_x), (along_x, along_y))])
    return [sparse.vstack([part[k] for part in parts]).tocsr()[:, free] for k in range(3)]


def upper_bound(slope, dx):
    """Upper bound of the factor for elements dx [m] wide."""
    x, triangles = mesh(slope, dx, 0.5 * dx)
    corner = x[triangles[:, :3]]
    area = 0.5 * np.abs(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]))
    strength = np.where(corner[:, :, 1].mean(axis=1) < slope.thickness, slope.cohesion[1], slope.cohesion[0])
    base, wall = x[:, 1] < 1e-9, (x[:, 0] < 1e-9) | (x[:, 0] > slope.length - 1e-9)
    free = np.flatnonzero(~np.concatenate([base | wall, base]))
    inside, corners = [(1 / 6, 1 / 6), (2 / 3, 1 / 6), (1 / 6, 2 / 3)], [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]
    e1, e2, volume = rates(x, triangles, corners, free)
    weight = np.zeros(2 * len(x))
    for place in inside:
        np.add.at(weight, len(x) + triangles, -bishop.WEIGHT * area[:, None] / 3.0 * derivatives(x, triangles, *place)[1])
    weight, thirds, strengths = weight[free], np.tile(area / 3.0, 3), np.tile(strength, 3)
    viscosity = strengths
    for step in range(STEPS):
        k = sparse.diags(thirds * viscosity)
        matrix = (e1.T @ k @ e1 + e2.T @ k @ e2 + BULK * (volume.T @ k @ volume)).tocsc()
        u = splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}).solve(weight)
        u /= weight @ u
        shear = np.hypot(e1 @ u, e2 @ u)
        mean = np.sqrt((thirds * shear**2).sum() / area.sum())
        viscosity = strengths / np.hypot(shear, mean * max(FLOOR, 0.3 * 0.7**step))
    return (thirds * strengths * np.hypot(e1 @ u, e2 @ u)).sum()


def main():
    size = float(sys.argv[1])
    for ratio in [float(r) for r in sys.argv[2:]] or (0.2, 0.6, 1.0, 2.0):
        slope = bishop.Slope(CREST, THICKNESS, TOE, (STRENGTH, ratio * STRENGTH), (0.0, 0.0))
        print(f"s_u2 / s_u1 = {ratio:g}: F <= {upper_bound(slope, size):.4f} by elements {size:g} m wide", flush=True)


if __name__ == "__main__":
    main()
