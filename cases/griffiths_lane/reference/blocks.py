#!/usr/bin/python3
"""Upper bounds of the factor of safety of the clay slopes of this case, from mechanisms that need not be circles: rigid blocks whose edges join
points of a lattice. Of all these mechanisms the one with the least factor is found by linear programming (discontinuity layout optimisation,
Smith & Gilbert 2007, Proc. R. Soc. A 463, 2461-2484).

Usage: blocks.py [RATIO ...]        ratios s_u2 / s_u1 (default: 0.2 0.6 1 2); prints the bound by a coarse and a fine lattice, and the circle's
       blocks.py --cut              stability number gamma H / s_u of a vertical cut; the exact one lies between 3.7764 and 3.7777

Clay does not change its volume: blocks slide along their edges, with a slip s on each edge of length L. The factor is the work that the slips
take, sum(s_u L |s|), over the work of the weight. It is an upper bound of the exact factor for soil that can carry tension, since every mechanism
gives one. Around each point the slips of the edges add up to zero, which is what linear programming needs to find the best set of edges. It begins
with short edges; edges that would lower the factor are added until there are none.
"""
import math
import sys

import bishop
import numpy as np
from scipy.optimize import linprog
from scipy.sparse import coo_matrix


class Body:
    """Clay below a ground line (x and y of its corners, from left to right), between smooth walls, on a rough base at y = 0.
    strength(y): undrained strength [Pa] at the height y; layer: height of the boundary between two strengths."""

    def __init__(self, ground, layer, below, above):
        self.ground, self.layer, self.below, self.above = np.array(ground, dtype=float), layer, below, above

    def top(self, x):
        return np.interp(x, *self.ground.T)

    def area(self, x):
        """Integral of top() from the left end to x."""
        corners, heights = self.ground.T
        before = np.concatenate([[0.0], np.cumsum(np.diff(corners) * 0.5 * (heights[1:] + heights[:-1]))])
        k = np.clip(np.searchsorted(corners, x, side="right") - 1, 0, len(corners) - 2)
        return before[k] + (x - corners[k]) * 0.5 * (heights[k] + self.top(x))

    def is_ground(self, x):
        """Whether points [n, 2] lie on the ground line."""
        near = np.full(len(x), np.inf)
        for a, b in zip(self.ground, self.ground[1:]):
            share = np.clip((x - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
            near = np.minimum(near, np.linalg.norm(x - a - share[:, None] * (b - a), axis=1))
        return near < 1e-6

    def points(self, dx, dy):
        """Lattice of points, with their whole-number coordinates."""
        x = np.arange(round(self.ground[-1, 0] / dx) + 1)
        y = np.arange(round(self.ground[:, 1].max() / dy) + 1)
        ij = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
        return ij[ij[:, 1] * dy <= self.top(ij[:, 0] * dx) + 1e-9]


class Edges:
    """Edges from a to b (arrays of points [m]), with a to the left of b, or below it: their slip is that of the soil above (to the left of) the
    edge, along the edge. cost: work per slip, s_u L [N]; weight: work of the weight per slip [N]; free: edges along the ground, which may open, too."""

    def __init__(self, body, a, b):
        along = b - a
        length = np.linalg.norm(along, axis=1)
        self.along = along / length[:, None]
        low, high = np.minimum(a[:, 1], b[:, 1]), np.maximum(a[:, 1], b[:, 1])
        part = np.where(high > low, np.clip((body.layer - low) / np.where(high > low, high - low, 1.0), 0.0, 1.0), low < body.layer)
        mean = part * body.below + (1.0 - part) * body.above
        flat = (high == low) & (low == body.layer)
        self.cost = np.where(flat, min(body.below, body.above), mean) * length
        above = body.area(b[:, 0]) - body.area(a[:, 0]) - along[:, 0] * 0.5 * (a[:, 1] + b[:, 1])
        self.weight = -bishop.WEIGHT * above * self.along[:, 1]
        wall = (along[:, 0] == 0.0) & ((a[:, 0] == 0.0) | (a[:, 0] == body.ground[-1, 0]))
        self.cost[wall] = 0.0
        self.free = body.is_ground(0.5 * (a + b))
        self.cost[self.free] = 0.0


def pairs(body, ij, dx, dy):
    """All edges of the lattice: pairs of points with no third point between them, whose edge does not leave the soil."""
    first, second = np.triu_indices(len(ij), 1)
    step = ij[second] - ij[first]
    keep = np.gcd(np.abs(step[:, 0]), np.abs(step[:, 1])) == 1
    size = np.array([dx, dy])
    for corner in body.ground[1:-1]:
        a, b = ij[first] * size, ij[second] * size
        across = (a[:, 0] < corner[0]) & (corner[0] < b[:, 0])
        y = a[:, 1] + (b[:, 1] - a[:, 1]) * (corner[0] - a[:, 0]) / np.where(across, b[:, 0] - a[:, 0], 1.0)
        keep &= ~across | (y <= corner[1] + 1e-9)
    return first[keep], second[keep]


def solve(n, first, second, edges):
    """Least factor of the mechanisms of these edges, the slips, and the prices of the two conditions at each point and of the work."""
    m, free = len(first), np.flatnonzero(edges.free)
    t = edges.along
    # Columns: slip to either side of each edge; opening of the edges along the ground.
    column = np.arange(m)
    rows, columns, values = [], [], []
    for sign, offset in ((1.0, 0), (-1.0, m)):
        for point, side in ((first, 1.0), (second, -1.0)):
            for k in (0, 1):
                rows.append(2 * point + k), columns.append(column + offset), values.append(sign * side * t[:, k])
        rows.append(np.full(m, 2 * n)), columns.append(column + offset), values.append(sign * edges.weight)
    normal = np.stack([-t[free, 1], t[free, 0]], axis=1)
    for point, side in ((first[free], 1.0), (second[free], -1.0)):
        for k in (0, 1):
            rows.append(2 * point + k), columns.append(2 * m + np.arange(len(free))), values.append(side * normal[:, k])
    total = 2 * m + len(free)
    matrix = coo_matrix((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=(2 * n + 1, total)).tocsr()
    right = np.zeros(2 * n + 1)
    right[-1] = 1.0
    cost = np.concatenate([edges.cost, edges.cost, np.zeros(len(free))])
    bounds = np.zeros((total, 2))
    bounds[:, 1] = np.inf
    bounds[2 * m:, 0] = -np.inf
    found = linprog(cost, A_eq=matrix, b_eq=right, bounds=bounds, method="highs")
    if found.status != 0:
        raise SystemExit(f"no mechanism found: {found.message}")
    price = found.eqlin.marginals
    return found.fun, found.x[:m] - found.x[m:2 * m], price[:-1].reshape(-1, 2), price[-1]


def least_factor(body, dx, dy, first_length=2.9, most=4000):
    """Upper bound of the factor of safety by the lattice of points dx, dy [m] apart, and its mechanism: edges [k, 2, 2] and slips [k]."""
    ij = body.points(dx, dy)
    x = ij * np.array([dx, dy])
    first, second = pairs(body, ij, dx, dy)
    every = Edges(body, x[first], x[second])
    scale = bishop.WEIGHT  # numbers of common size for the solver
    every.cost /= scale
    every.weight /= scale
    used = (np.linalg.norm(x[second] - x[first], axis=1) <= first_length * max(dx, dy)) | every.free
    while True:
        at = np.flatnonzero(used)
        part = object.__new__(Edges)
        part.along, part.cost, part.weight, part.free = every.along[at], every.cost[at], every.weight[at], every.free[at]
        factor, slip, price, of_work = solve(len(x), first[at], second[at], part)
        gain = np.abs((every.along * (price[first] - price[second])).sum(axis=1) + of_work * every.weight) - every.cost
        gain[used] = 0.0
        missing = np.flatnonzero(gain > 1e-6 * np.maximum(every.cost, 1e-6))
        if len(missing) == 0:
            moves = np.flatnonzero(np.abs(slip) > 1e-6 * np.abs(slip).max())
            return factor, np.stack([x[first[at[moves]]], x[second[at[moves]]]], axis=1), slip[moves]
        used[missing[np.argsort(-(gain / np.maximum(every.cost, 1e-6))[missing])][:most]] = True


def clay_slope(ratio):
    """Example 4: a slope of 10 m, 2:1, on 10 m of clay whose strength is `ratio` times that of the slope, 50 kPa."""
    return Body([(0, 20), (20, 20), (40, 10), (60, 10)], 10.0, ratio * 50e3, 50e3)


def main():
    if sys.argv[1:] == ["--cut"]:
        for dx in (1.0, 0.5):
            cut = Body([(0, 14), (10, 14), (10.0 + 1e-9, 4), (16, 4)], 0.0, 50e3, 50e3)
            print(f"vertical cut, points {dx:g} m apart: gamma H / s_u = {bishop.WEIGHT * 10.0 / 50e3 * least_factor(cut, dx, dx)[0]:.4f}", flush=True)
        return
    for ratio in [float(r) for r in sys.argv[1:]] or (0.2, 0.6, 1.0, 2.0):
        circle = bishop.Slope(20.0, 10.0, 20.0, (50e3, ratio * 50e3), (0.0, 0.0)).lowest()[0]
        bounds = [least_factor(clay_slope(ratio), dx, dx / 2.0)[0] for dx in (4.0, 2.0)]
        print(f"s_u2 / s_u1 = {ratio:g}: blocks {bounds[0]:.3f} (points 4 m x 2 m apart), {bounds[1]:.3f} (2 m x 1 m); circles {circle:.3f}", flush=True)


if __name__ == "__main__":
    main()
