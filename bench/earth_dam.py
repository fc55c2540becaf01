#!/usr/bin/python3
"""Estimates seepage and safety of the earth dam of docs/tutorials/earth-dam.md independently of poretwin: steady seepage with a free surface by
finite volumes, and the factor of safety by Bishop's simplified method on circles through the downstream slope, with the pore pressures of that
seepage.

bench/earth_dam.py              prints discharges and water tables with which the page compares
bench/earth_dam.py --strength   also prints the factors of safety
bench/earth_dam.py --check      prints the seepage through a dam whose discharge is known exactly

Seepage follows Darcy's law on square cells. Where the pressure is below zero, the conductivity k is a millionth of its value (Bathe &
Khoshgoftaar 1979: dry ground hardly conducts). On the downstream slope water either leaves at zero pressure or does not leave at all. Slopes are
staircases of cells.
"""
import argparse
import math

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import spsolve

GAMMA_W = 9810.0  # N/m3
HEAD = 8.0        # m, level of the reservoir
DRAIN_FROM = 34.0  # m, where the drain under the downstream slope begins
BASE, HEIGHT, CREST = 44.0, 10.0, (20.0, 24.0)  # m: length of the base, height, ends of the crest
SHELL = [(0, 0), (44, 0), (24, 10), (20, 10)]
CORE = [(19, 0), (25, 0), (23, 10), (21, 10)]
CONDUCTIVITY = {"shell": 1e-5, "core": 2e-7}  # m/s
STRENGTH = {"shell": (5e3, 32.0), "core": (15e3, 24.0)}  # Pa, degrees
DRY, SATURATED = 0.65 * 2650 * 9.81, (0.65 * 2650 + 0.35 * 1000) * 9.81  # unit weights [N/m3], with the porosity 0.35


def inside(polygon, x, y):
    result = np.zeros(np.shape(x), dtype=bool)
    for (x0, y0), (x1, y1) in zip(polygon, polygon[1:] + polygon[:1]):
        crosses = (y0 > y) != (y1 > y)
        with np.errstate(divide="ignore", invalid="ignore"):
            result ^= crosses & (x < (x1 - x0) * (y - y0) / (y1 - y0) + x0)
    return result


class Seepage:
    """Steady head in the dam. A cell belongs to the first of the given zones that contains it, otherwise to the shell."""

    def __init__(self, zones, conductivity, cell=0.1, outline=SHELL, exit_from=CREST[1], drain=False):
        nx, ny = round(BASE / cell), round(HEIGHT / cell)
        self.cell = cell
        x, y = np.meshgrid((np.arange(nx) + 0.5) * cell, (np.arange(ny) + 0.5) * cell)
        self.x, self.y, self.dam = x, y, inside(outline, x, y)
        k = np.where(self.dam, conductivity["shell"], 0.0)
        for name, polygon in reversed(list(zones.items())):
            k[self.dam & inside(polygon, x, y)] = conductivity[name]
        outside = np.pad(~self.dam, 1, constant_values=True)
        outside[0] = False  # the ground is impermeable
        edge = self.dam & (outside[1:-1, :-2] | outside[1:-1, 2:] | outside[2:, 1:-1])
        wet = edge & (x < 0.5 * BASE) & (y < HEAD)
        leak = edge & (x > exit_from)
        if drain:
            leak |= self.dam & (y < cell) & (x > DRAIN_FROM)
        number = np.full(self.dam.shape, -1)
        number[self.dam] = np.arange(self.dam.sum())
        height, held, out = y[self.dam], wet[self.dam], leak[self.dam]
        h = np.where(held, HEAD, np.minimum(HEAD, height + 0.1))
        active = out & (height < 0.3 * HEAD)
        pairs, walls = [], []
        for shift in ((0, 1), (1, 0)):
            a, b = number[: ny - shift[0], : nx - shift[1]], number[shift[0]:, shift[1]:]
            both = (a >= 0) & (b >= 0)
            ka, kb = k[: ny - shift[0], : nx - shift[1]][both], k[shift[0]:, shift[1]:][both]
            pairs.append((a[both], b[both]))
            walls.append((ka, kb))
        i, j = (np.concatenate([p[s] for p in pairs]) for s in (0, 1))
        ki, kj = (np.concatenate([w[s] for w in walls]) for s in (0, 1))
        for _ in range(400):
            wetness = np.clip((h - height) / cell + 0.5, 1e-6, 1.0)
            c = 2.0 / (1.0 / (ki * wetness[i]) + 1.0 / (kj * wetness[j]))
            fixed = held | active
            n = len(h)
            rows = np.concatenate([i, j, i, j])
            columns = np.concatenate([i, j, j, i])
            values = np.concatenate([c, c, -c, -c])
            matrix = coo_matrix((values, (rows, columns)), shape=(n, n)).tocsr()
            given = np.where(held, HEAD, height)
            free = ~fixed
            new = given.copy()
            new[free] = spsolve(matrix[free][:, free], -(matrix[free][:, fixed] @ given[fixed]))
            change = np.abs(new - h).max()
            h = np.where(fixed, new, h + 0.5 * (new - h))
            flow = matrix @ new  # inflow to the dam at the cells with a fixed head
            wanted = out & ((active & (flow < 0.0)) | (~active & (new > height)))
            if change < 1e-3 and (wanted == active).all():
                break
            active = wanted
        self.head = np.full(self.dam.shape, np.nan)
        self.head[self.dam] = new
        self.discharge = flow[held].sum()
        self.exit = height[active].max() if active.any() else 0.0

    def table(self, x):
        """Elevation of the water table at x [m]."""
        i = min(int(x / self.cell), self.head.shape[1] - 1)
        p = self.head[:, i] - self.y[:, i]
        wet = np.flatnonzero(p > 0.0)
        return 0.0 if len(wet) == 0 else self.y[wet[-1], i] + min(p[wet[-1]], self.cell)

    def pressure(self, x, y):
        i, j = int(x / self.cell), int(y / self.cell)
        h = self.head[min(j, self.head.shape[0] - 1), min(i, self.head.shape[1] - 1)]
        return 0.0 if math.isnan(h) else max(0.0, GAMMA_W * (h - y))


def ground(x):
    return min(HEIGHT, x * HEIGHT / CREST[0], (BASE - x) * HEIGHT / (BASE - CREST[1]))


def strength(zones, x, y):
    for name, polygon in zones.items():
        if inside(polygon, np.array([x]), np.array([y]))[0]:
            return STRENGTH[name]
    return STRENGTH["shell"]


def bishop(circle, zones, seepage, table, slices=40):
    xc, yc, r = circle
    if yc - r < 0.0:
        return None
    xs = np.linspace(max(0.0, xc - r), min(BASE, xc + r), 400)
    bottoms = yc - np.sqrt(np.maximum(0.0, r * r - (xs - xc) ** 2))
    cut = [x for x, bottom in zip(xs, bottoms) if bottom < ground(x)]
    if len(cut) < 20 or cut[0] < CREST[0]:
        return None  # the circle also cuts the upstream side, or hardly any soil
    width = (cut[-1] - cut[0]) / slices
    parts = []
    for n in range(slices):
        x = cut[0] + (n + 0.5) * width
        bottom = yc - math.sqrt(max(0.0, r * r - (x - xc) ** 2))
        top = ground(x)
        if top <= bottom:
            continue
        water = 0.0 if table is None else max(0.0, min(table[min(int(x * 10), len(table) - 1)], top) - bottom)
        weight = (DRY * (top - bottom - water) + SATURATED * water) * width
        c, phi = strength(zones, x, bottom)
        u = 0.0 if seepage is None else seepage.pressure(x, bottom)
        parts.append((weight, math.asin((xc - x) / r), c, math.tan(math.radians(phi)), u))
    driving = sum(p[0] * math.sin(p[1]) for p in parts)
    if driving <= 0.0:
        return None
    f = 1.5
    for _ in range(60):
        new = sum((c * width + max(0.0, w - u * width) * t) / (math.cos(a) + math.sin(a) * t / f) for w, a, c, t, u in parts) / driving
        if abs(new - f) < 1e-5:
            break
        f = new
    return f


def lowest(zones, seepage=None):
    """The smallest factor of safety of circles through the downstream slope that are at least a metre deep, and its circle: coordinates of the
    centre, radius [m]. The grid of centres is refined three times around the best circle."""
    table = None if seepage is None else [seepage.table(0.1 * n + 0.05) for n in range(int(BASE * 10))]
    best, at = math.inf, None
    centres = [(x, y) for x in np.arange(26.0, 46.0, 2.0) for y in np.arange(11.0, 40.0, 2.0)]
    step = 2.0
    for _ in range(4):
        for xc, yc in centres:
            reach = min(yc, 60.0)
            for r in np.linspace(max(3.0, yc - HEIGHT), reach, 25):
                # Depth of the circle below the slope; circles less than a metre deep are surface slides.
                if r - abs((xc - BASE) * HEIGHT + yc * (BASE - CREST[1])) / math.hypot(HEIGHT, BASE - CREST[1]) < 1.0:
                    continue
                f = bishop((xc, yc, r), zones, seepage, table)
                if f and f < best:
                    best, at = f, (xc, yc, r)
        step *= 0.4
        centres = [(at[0] + i * step, at[1] + j * step) for i in range(-2, 3) for j in range(-2, 3)]
    return best, at


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="the seepage against an exact discharge")
    parser.add_argument("--cell", type=float, default=0.1, help="of the finite volumes [m]")
    parser.add_argument("--strength", action="store_true", help="factors of safety, too")
    a = parser.parse_args()
    if a.check:  # between vertical faces exactly q = k H^2 / 2L (Charny)
        box = [(17, 0), (27, 0), (27, 10), (17, 10)]
        found = Seepage({}, {"shell": 1e-5}, a.cell, outline=box, exit_from=22.0)
        print(f"vertical faces, 10 m apart: {found.discharge:.4g} m2/s, exactly {1e-5 * HEAD**2 / 20.0:.4g}")
        return
    # Nearly all of the head is lost in a core that is fifty times less permeable than its shell. So the core is computed alone, between reservoir
    # and air.
    for k in (2e-7, 1e-6):
        found = Seepage({}, {"shell": k}, a.cell, outline=CORE, exit_from=22.0)
        print(f"core of {k:g} m/s alone: discharge {found.discharge:.3g} m2/s, comes out up to {found.exit:.2f} m", flush=True)
    for name, drain in (("shell alone", False), ("with a drain", True)):
        found = Seepage({}, CONDUCTIVITY, a.cell, drain=drain)
        print(f"{name}: discharge {found.discharge:.3g} m2/s, table at x = 18, 22, 26, 30 m: "
              + ", ".join(f"{found.table(x):.2f}" for x in (18, 22, 26, 30)) + f" m, comes out up to {found.exit:.2f} m", flush=True)
        if a.strength:
            f, circle = lowest({}, found)
            print(f"  factor of safety {f:.3f}, circle about ({circle[0]:.1f}, {circle[1]:.1f}) m, {circle[2]:.1f} m", flush=True)
    for name, zones in ((("dry, shell alone", {}), ("dry, with a core", {"core": CORE})) if a.strength else ()):
        f, circle = lowest(zones)
        print(f"{name}: factor of safety {f:.3f}, circle about ({circle[0]:.1f}, {circle[1]:.1f}) m, {circle[2]:.1f} m", flush=True)


if __name__ == "__main__":
    main()
