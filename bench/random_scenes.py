#!/usr/bin/python3
"""Runs random scenes and compares each with an exact value or with its own finite-volume solution. The exit code is 1 if any scene is silently
wrong or failed.

Kinds of scenes, and what is compared:

    still   water at rest in tanks with slanted sides, steps, blocks or two chambers, or above ground: pressure rho g (H - y) at the height y
            below the level H; largest speed
    column  steady seepage through layers in series, with gravity at any angle to the layers: discharge per area dh / sum(t / k), with the
            difference of heads dh, thickness t and conductivity k of the layers; heads
    plane   steady seepage in a plane with lenses, slanted and stepped layers, drains or thick piles: discharge and heads by finite volumes
    dry     elastic soil at rest beside smooth walls, in layers: vertical stress rho g h at the depth h; horizontal stress, K0 times the
            vertical one
    wet     as dry, but saturated and under a pond: pore pressure, effective stress

Every scene has a random size from 1e-2 to 1e2 m, a random position up to 1e6 m from the origin and a random angle to the lattice.

Outcomes: right; refused (by `poretwin check`); stopped (the run itself gave a reason, exit codes 3 and 4); warned (exit code 6); slow (the
run took longer than --longest); SILENTLY WRONG: the run ended by itself without a warning, but an error exceeds its bound; failed: any other
end.

Column `error`: the largest relative error. For heads it is relative to the difference of heads, for pressures and stresses to those at the
base. Column `bound`: 0.3 divided by the number of particle rows in the thinnest part (3 % at 10 rows), but at least 1 %.
"""
import argparse
import collections
import concurrent.futures
import dataclasses
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from plot import write_csv
from runs import PROGRAM, Run
from scenes import G, WATER, WEIGHT, Scene, box, inside

from scipy.interpolate import RegularGridInterpolator
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import spsolve

FIRST_ORDER, SMALLEST = 0.3, 0.01  # bound with one row of particles; smallest bound
# Kinds of scenes that are known to be refused or wrong: drawn only with --known NAME.
KNOWN = {"thin_walls": "piles thinner than the kernel's reach", "part_faces": "faces that end on a straight wall"}


@dataclasses.dataclass
class Held:
    """A scene and the values with which its gauges are compared. `rows`: number of particle rows in its thinnest part; `values`:
    {gauge: (right value, scale of the error)}; `most`: {gauge: largest allowed reading}."""
    scene: Scene
    rows: float
    values: dict
    about: str
    most: dict = dataclasses.field(default_factory=dict)

    @property
    def bound(self):
        return max(SMALLEST, FIRST_ORDER / self.rows)


def log_uniform(rng, low, high):
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def pick(rng, *options):
    return options[rng.integers(len(options))]


def where(rng, size, spacing):
    """A random angle [rad] and position [m] of a scene with this size [m] and particle spacing [m]."""
    angle = rng.choice([0.0, 1.0, 2.0], p=[0.25, 0.15, 0.6])
    angle = 0.0 if angle == 0.0 else rng.integers(1, 4) * 0.5 * np.pi if angle == 1.0 else rng.uniform(-np.pi, np.pi)
    far = rng.choice([0, 1, 2], p=[0.4, 0.4, 0.2])
    distance = 0.0 if far == 0 else log_uniform(rng, size, min(1e6, 3e5 * spacing)) if far == 1 else log_uniform(rng, 1.0, 1e6)
    course = pick(rng, 0.0, 0.5 * np.pi, rng.uniform(0.0, 2.0 * np.pi))
    return angle, distance * np.array([np.cos(course), np.sin(course)])


def points_of(scene, name, phase, quantity, places):
    scene.gauge(name, phase, "point", places, quantity=quantity)
    return [f"{name}[{i}]" for i in range(len(places))]


def still(rng, _known):
    rows, across = rng.integers(10, 26), rng.integers(12, 36)
    size = log_uniform(rng, 1e-2, 1e2)
    dx = size / max(rows, across)
    depth, width = rows * dx, across * dx
    scene = Scene(dx, 6.0 * np.sqrt(depth / G), *where(rng, size, dx))
    air, variant = 1.3 * depth, pick(rng, "tank", "trapezoid", "step", "block", "chambers", "ground")
    levels = [(0.0, width, depth)]
    if variant == "trapezoid":
        left, right = rng.uniform(-0.4, 0.6, 2) * width * 0.5
        left, right = -abs(left) if left < 0 else left, right
        slope = lambda y: (left * y / air, width + right * y / air)
        scene.wall([[slope(air)[0], air], [0, 0], [width, 0], [slope(air)[1], air]])
        scene.water([[0, 0], [width, 0], [slope(depth)[1], depth], [slope(depth)[0], depth]])
        places = [[0.5 * sum(slope(y)), y] for y in depth * np.array([0.15, 0.4, 0.65, 0.85])]
    elif variant == "step":
        at, up = rng.uniform(0.35, 0.65) * width, rng.uniform(0.2, 0.5) * depth
        scene.wall([[0, air], [0, 0], [at, 0], [at, up], [width, up], [width, air]])
        scene.water([[0, 0], [at, 0], [at, up], [width, up], [width, depth], [0, depth]])
        places = [[0.5 * at, 0.2 * depth], [0.5 * at, 0.6 * depth], [0.5 * (at + width), 0.5 * (up + depth)], [at, 0.85 * depth]]
    elif variant == "block":
        width = max(width, 18 * dx)
        low, high, half = 0.35 * depth, 0.35 * depth + 0.3 * depth, max(3.0 * dx, rng.uniform(0.1, 0.2) * width)
        middle = 0.5 * width
        hole = [[middle - half, low], [middle - half, high], [middle + half, high], [middle + half, low]]
        scene.wall([[0, air], [0, 0], [width, 0], [width, air]])
        scene.wall(hole + hole[:1])
        scene.water(np.array([[0, 0], [width, 0], [width, depth], [middle, depth], [middle, high], [middle + half, high], [middle + half, low],
                              [middle - half, low], [middle - half, high], [middle, high], [middle, depth], [0, depth]]))
        places = [[0.5 * (middle - half), 0.3 * depth], [0.5 * (middle - half), 0.7 * depth], [middle, 0.17 * depth], [middle, 0.83 * depth]]
    elif variant == "chambers":
        thick, other = 5.5 * dx, depth * rng.uniform(0.4, 0.9)
        width = max(width, 21.5 * dx)
        left = 0.5 * (width - thick)
        scene.wall([[0, air], [0, 0], [left, 0], [left, air]])
        scene.wall([[left + thick, air], [left + thick, 0], [width, 0], [width, air]])
        scene.water(box(0, 0, left, depth))
        scene.water(box(left + thick, 0, width, other))
        levels = [(0.0, left, depth), (left + thick, width, other)]
        places = [[0.5 * left, 0.3 * depth], [0.5 * left, 0.7 * depth], [width - 0.5 * left, 0.3 * other], [width - 0.5 * left, 0.7 * other]]
    else:
        scene.wall([[0, air], [0, 0], [width, 0], [width, air]])
        scene.water(box(0, 0, width, depth))
        if variant == "ground":
            scene.soil(box(0, 0, width, rng.uniform(0.25, 0.6) * depth), porosity=rng.uniform(0.3, 0.6),
                       hydraulic_conductivity=log_uniform(rng, 1e-7, 1e-1))
        places = [[0.5 * width, y] for y in depth * np.array([0.1, 0.35, 0.6, 0.85])]
    scene.gauge("speed", "fluid", "max_speed")
    names = points_of(scene, "p", "fluid", "pore_pressure", places)
    level = lambda x: next(h for a, b, h in levels if a <= x <= b or len(levels) == 1)
    lowest = min(h for _, _, h in levels)
    values = {name: (WEIGHT * (level(x) - y), WEIGHT * depth) for name, (x, y) in zip(names, places)}
    return Held(scene, lowest / dx, values, variant, {"speed": np.sqrt(G * dx)})


def column(rng, _known):
    count = rng.integers(1, 5)
    thick = np.array([rng.choice([2, 3, 5, 8, 12]) + rng.choice([0.0, rng.uniform(-0.4, 0.4)]) for _ in range(count)])
    thick = np.maximum(thick, 1.0) if count > 1 else np.maximum(thick, 5.0)
    across = rng.integers(6, 16)
    k = 10.0 ** rng.uniform(-7, -2) * 10.0 ** (rng.uniform(-3, 3, count) * rng.choice([0.0, 0.3, 1.0]))
    k = np.clip(k, 1e-9, 0.1)  # with a larger k, the flow takes seconds to become steady
    size = log_uniform(rng, 1e-2, 1e2)
    dx = size / max(across, thick.sum())
    ends = np.r_[0.0, np.cumsum(thick * dx)]
    height, width, porosity = ends[-1], across * dx, rng.uniform(0.25, 0.6)
    resistance = np.sum(thick * dx / k)
    bottom, top = (height + width) * rng.uniform(1.2, 2.0, 2)  # heads above all of the column, in any orientation
    if abs(top - bottom) < 0.2 * height:
        top = bottom + 0.3 * height
    speed = (bottom - top) / resistance
    angle, place = where(rng, size, dx)
    scene = Scene(dx, 3.0 * dx * porosity / abs(speed), angle, place, gravity=pick(rng, 0.0, -angle, rng.uniform(-np.pi, np.pi)))
    for i in range(count):
        scene.soil(box(0, ends[i], width, ends[i + 1]), porosity=porosity, hydraulic_conductivity=k[i])
    scene.wall([[0, height], [0, 0]])
    scene.wall([[width, 0], [width, height]])
    scene.face([[width, height], [0, height]], head=top)
    scene.face([[0, 0], [width, 0]], head=bottom)
    scene.water(box(0, 0, width, height))
    middles = 0.5 * (ends[1:] + ends[:-1])
    places = [[0.5 * width, y] for y in middles] + [[0.3 * width, middles[0]]]
    heads = bottom - speed * np.interp([y for _, y in places], ends, np.r_[0.0, np.cumsum(thick * dx / k)])
    values = {}
    for i, y in enumerate(middles):
        scene.gauge(f"q{i}", "fluid", "discharge", [[0, y], [width, y]])
        values[f"q{i}"] = (speed * width, abs(speed) * width)
    for name, at, h in zip(points_of(scene, "p", "fluid", "pore_pressure", places), places, heads):
        values[name] = (WEIGHT * (h - scene.local_up @ at), WEIGHT * abs(top - bottom))
    return Held(scene, min(thick.min(), across), values, f"rows {' '.join(f'{t:.1f}' for t in thick)}, k {' '.join(f'{v:.1e}' for v in k)}")


def finite_volumes(width, height, parts, default, holes, faces, h):
    """Steady seepage in a rectangle, in cells of about h by h [m]. A point has the conductivity of the first part that contains it, otherwise
    `default`; holes do not conduct. faces: [(side, from, to, head)]. Returns a function that gives the head at points, and the inward discharge
    through each face [m2/s]."""
    nx, ny = round(width / h), round(height / h)
    hx, hy = width / nx, height / ny
    x, y = np.meshgrid((np.arange(nx) + 0.5) * hx, (np.arange(ny) + 0.5) * hy, indexing="ij")
    places = np.column_stack([x.ravel(), y.ravel()])
    k = np.full(len(places), float(default))
    for polygon, value in reversed(parts):
        k[inside(polygon, places)] = value
    open_ = np.ones(len(places), bool)
    for polygon in holes:
        open_ &= ~inside(polygon, places)
    number = np.arange(nx * ny).reshape(nx, ny)
    rows, cols, entries = [], [], []
    diagonal, right = np.zeros(nx * ny), np.zeros(nx * ny)
    for a, b, ratio in ((number[:-1], number[1:], hy / hx), (number[:, :-1], number[:, 1:], hx / hy)):
        a, b = a.ravel(), b.ravel()
        t = np.where(open_[a] & open_[b], 2.0 * k[a] * k[b] / (k[a] + k[b]) * ratio, 0.0)
        rows += [a, b]
        cols += [b, a]
        entries += [-t, -t]
        np.add.at(diagonal, a, t)
        np.add.at(diagonal, b, t)
    inlets = []
    for side, start, end, head in faces:
        cells, along, ratio = {"left": (number[0], y[0], hy / hx), "right": (number[-1], y[-1], hy / hx), "bottom": (number[:, 0], x[:, 0], hx / hy),
                               "top": (number[:, -1], x[:, -1], hx / hy)}[side]
        cells = cells[(along > start) & (along < end)]
        cells = cells[open_[cells]]
        t = 2.0 * k[cells] * ratio
        diagonal[cells] += t
        right[cells] += t * head
        inlets.append((cells, t, head))
    diagonal[~open_] = 1.0
    size = np.arange(nx * ny)
    matrix = coo_matrix((np.concatenate(entries + [diagonal]), (np.concatenate(rows + [size]), np.concatenate(cols + [size])))).tocsc()
    head = spsolve(matrix, right)

    at = RegularGridInterpolator((x[:, 0], y[0]), head.reshape(nx, ny))
    return at, [float(np.sum(t * (value - head[cells]))) for cells, t, value in inlets]


def plane(rng, known):
    across, rows = rng.integers(18, 34), rng.integers(14, 26)
    size = log_uniform(rng, 1e-2, 1e2)
    dx = size / max(rows, across)
    width, height = across * dx, rows * dx
    porosity, k = rng.uniform(0.25, 0.6), 10.0 ** rng.uniform(-6, -3)
    variants = ["lens", "slanted", "step", "drain", "pile"] + ["thin pile"] * ("thin_walls" in known) + ["part faces"] * ("part_faces" in known)
    variant = pick(rng, *variants)
    contrast = 10.0 ** (rng.uniform(0.3, 3.0) * pick(rng, -1.0, 1.0))
    high, low = (width + height) * np.array([1.9, 1.9 - rng.uniform(0.1, 0.6)])
    if rng.random() < 0.5:
        high, low = low, high
    whole = box(0, 0, width, height)
    parts, holes, thinnest = [], [], float(min(rows, across))
    faces = [("left", 0.0, height, high), ("right", 0.0, height, low)]
    if variant == "lens":
        a, b = rng.uniform(0.12, 0.28, 2) * min(width, height)
        turn = rng.uniform(0.0, np.pi)
        c, s = np.cos(turn), np.sin(turn)
        middle = np.array([width * rng.uniform(0.42, 0.58), height * rng.uniform(0.42, 0.58)])
        lens = np.array([[-a, -b], [a, -b], [a, b], [-a, b]]) @ np.array([[c, s], [-s, c]]) + middle
        near = np.linalg.norm(lens, axis=1).argmin()  # corner of the lens where the ground's polygon is joined to it
        around = np.vstack([whole, whole[:1], lens[[near, near - 3, near - 2, near - 1, near][::-1]]])
        parts = [(lens, k * contrast), (around, k)]
        thinnest = 2.0 * min(a, b) / dx
    elif variant == "slanted":
        p, q = rng.uniform(0.25, 0.75, 2) * width
        parts = [(np.array([[0, 0], [p, 0], [q, height], [0, height]]), k * contrast),
                 (np.array([[p, 0], [width, 0], [width, height], [q, height]]), k)]
        thinnest = min(p, q, width - p, width - q) / dx
    elif variant == "step":
        p, q, y = rng.uniform(0.25, 0.75) * width, rng.uniform(0.25, 0.75) * width, rng.uniform(0.3, 0.7) * height
        parts = [(np.array([[0, 0], [p, 0], [p, y], [q, y], [q, height], [0, height]]), k * contrast),
                 (np.array([[p, 0], [width, 0], [width, height], [q, height], [q, y], [p, y]]), k)]
        thinnest = min(p, q, width - p, width - q, y, height - y) / dx
    elif variant == "drain":
        length, low_, thick = rng.uniform(0.3, 0.7) * width, rng.uniform(0.1, 0.5) * height, rng.uniform(0.12, 0.3) * height
        parts = [(box(width - length, low_, width, low_ + thick), k * max(contrast, 1.0 / contrast)),
                 (np.array([[0, 0], [width, 0], [width, low_], [width - length, low_], [width - length, low_ + thick], [width, low_ + thick],
                            [width, height], [0, height]]), k)]
        thinnest = min(thick, low_) / dx
    else:
        half = (rng.uniform(4.2, 7.0) if variant == "pile" else rng.uniform(0.5, 1.9)) * dx * 0.5
        middle, tip = width * rng.uniform(0.4, 0.6), height * rng.uniform(0.35, 0.65)
        holes = [box(middle - half, tip, middle + half, height)]
        faces = [("top", 0.0, middle - half, high), ("top", middle + half, width, low)]
        thinnest = min(tip, middle - half, width - middle - half) / dx
        if variant == "part faces":
            holes, p, q = [], rng.uniform(0.2, 0.4) * width, rng.uniform(0.6, 0.8) * width
            faces = [("top", 0.0, p, high), ("top", q, width, low)]
            thinnest = min(p, width - q, q - p) / dx
    angle, place = where(rng, size, dx)
    scene = Scene(dx, 1.0, angle, place, gravity=pick(rng, 0.0, -angle))
    if holes:
        (a, tip), (b, _) = holes[0][0], holes[0][1]
        whole = np.array([[0, 0], [width, 0], [width, height], [b, height], [b, tip], [a, tip], [a, height], [0, height]])
        scene.wall([[b, height], [b, tip], [a, tip], [a, height]])
    for polygon, value in parts:
        scene.soil(polygon, porosity=porosity, hydraulic_conductivity=value)
    if not parts:
        scene.soil(whole, porosity=porosity, hydraulic_conductivity=k)
    scene.water(whole)
    if faces[0][0] == "left":
        scene.wall([[0, 0], [width, 0]])
        scene.wall([[width, height], [0, height]])
        scene.face([[0, height], [0, 0]], head=high)
        scene.face([[width, 0], [width, height]], head=low)
        lines = [[[x, height], [x, 0]] for x in (0.12 * width, 0.88 * width)]
    else:
        scene.wall([[0, height], [0, 0], [width, 0], [width, height]])
        for _, start, end, head in faces:
            scene.face([[end, height], [start, height]], head=head)
        if not holes:
            scene.wall([[faces[1][1], height], [faces[0][2], height]])
        y = 0.5 * (holes[0][0][1] + height) if holes else 0.0
        lines = [[[a, y], [0, y]], [[b, y], [width, y]]] if holes else [[[middle, height], [middle, 0]]]
    at, through = finite_volumes(width, height, parts, k, holes, faces, dx / 6.0)
    drop = abs(high - low)
    scene.end = 2.0 * dx * porosity / (abs(through[0]) / min(width, height))
    scene.gauge_interval = scene.end / 40.0
    places = rng.uniform(0.12, 0.88, (60, 2)) * [width, height]
    clear = 2.0 * dx
    away = [p for p in places if not any(inside(polygon + [[-clear, -clear], [clear, -clear], [clear, clear], [-clear, clear]], [p])[0]
                                         for polygon in holes)][:6]
    values = {}
    for i, line in enumerate(lines):
        scene.gauge(f"q{i}", "fluid", "discharge", line)
        values[f"q{i}"] = (through[0], abs(through[0]))
    for name, p, h in zip(points_of(scene, "p", "fluid", "pore_pressure", away), away, at(away)):
        values[name] = (WEIGHT * (h - scene.local_up @ p), WEIGHT * drop)
    return Held(scene, thinnest, values, f"{variant}, {across} by {rows} rows, contrast {contrast:.3g}")


def at_rest(rng, water):
    rows, across = rng.integers(10, 24), rng.integers(8, 24)
    size = log_uniform(rng, 1e-2, 1e2)
    dx = size / max(rows, across)
    height, width = rows * dx, across * dx
    angle, place = where(rng, size, dx)
    count, poisson = rng.integers(1, 4), rng.uniform(0.1, 0.45)
    ends = np.r_[0.0, np.sort(rng.uniform(0.25, 0.75, count - 1)), 1.0] * height
    porosity, grains = rng.uniform(0.3, 0.55), rng.uniform(2300.0, 2900.0, count)
    E = WEIGHT * height * log_uniform(rng, 300.0, 1e5)
    scene = Scene(dx, 0.0, angle, place)
    scene.model = "elastic"
    scene.end = 20.0 * height / np.sqrt(E / ((1.0 - porosity) * grains.mean()))
    scene.gauge_interval = scene.end / 20.0
    if np.diff(ends).min() < 3.0 * dx:
        ends, grains = np.r_[0.0, height], grains[:1]
    for i in range(len(grains)):
        scene.soil(box(0, ends[i], width, ends[i + 1]), porosity=porosity, grain_density=grains[i], youngs_modulus=E, poissons_ratio=poisson,
                   hydraulic_conductivity=log_uniform(rng, 1e-6, 1e-3))
    scene.wall([[0, height], [0, 0]], soil="roller")
    scene.wall([[0, 0], [width, 0]], soil=pick(rng, "roller", "fixed"))
    scene.wall([[width, 0], [width, height]], soil="roller")
    places = [[x * width, y * height] for x, y in ((0.5, 0.15), (0.5, 0.45), (0.25, 0.3), (0.75, 0.7))]
    buoyant = (1.0 - porosity) * (grains - (WATER if water else 0.0))
    above = lambda y: sum(b * max(0.0, ends[i + 1] - max(ends[i], y)) for i, b in enumerate(buoyant))
    whole = G * above(0.0)
    values = {}
    pond = 0.0
    if water:
        pond = rng.uniform(0.0, 0.5) * height
        scene.face([[width, height], [0, height]], head=height + pond)
        scene.water(box(0, 0, width, height))
        for name, p in zip(points_of(scene, "p", "fluid", "pore_pressure", places), places):
            values[name] = (WEIGHT * (height + pond - p[1]), WEIGHT * (height + pond))
    # Tension is positive; along the scene's axes the tensor is diagonal.
    x, y = scene.turn[:, 0], scene.turn[:, 1]
    for component, (i, j) in {"xx": (0, 0), "yy": (1, 1), "xy": (0, 1)}.items():
        names = points_of(scene, f"s{component}", "solid", f"effective_stress_{component}", places)
        for name, p in zip(names, places):
            vertical = -G * above(p[1])
            values[name] = (vertical * (y[i] * y[j] + poisson / (1.0 - poisson) * x[i] * x[j]), whole)
    scene.gauge("soil_speed", "solid", "max_speed")
    return Held(scene, min(rows, across, (np.diff(ends) / dx).min() if len(grains) > 1 else rows), values,
                f"{rows} by {across} rows, {len(grains)} layers, nu {poisson:.2f}, E {E:.1e}" + (f", pond {pond:.2g}" if water else ""))


KINDS = {"still": still, "column": column, "plane": plane, "dry": lambda rng, _: at_rest(rng, False), "wet": lambda rng, _: at_rest(rng, True)}


def drawn(seed, known=(), kinds=tuple(KINDS)):
    rng = np.random.default_rng(seed)
    kind = kinds[seed % len(kinds)]
    held = KINDS[kind](rng, known)
    held.scene.title = f"{kind} {seed}: {held.about}"
    return kind, held


def judge(held, run):
    """The largest error, over its scale, and the gauge that has it. What is compared is the mean of each gauge over the second half of the
    run."""
    worst, which = 0.0, ""
    for name, (right, unit) in held.values.items():
        if name not in run.gauges:
            return np.inf, f"{name} has no reading"
        times, readings = run.gauges[name]
        mean = np.mean(readings[times >= 0.5 * times[-1]])
        error = abs(mean - right) / unit
        if not error <= worst:
            worst, which = (error if np.isfinite(error) else np.inf), f"{name} {mean:.4g}, right {right:.4g}"
    for name, most in held.most.items():
        times, readings = run.gauges[name]
        fastest = readings[times >= 0.5 * times[-1]].max()
        if not fastest / most * held.bound <= worst:
            worst, which = fastest / most * held.bound, f"{name} {fastest:.3g}, at most {most:.3g}"
    return worst, which


def one(seed, a):
    kind, held = drawn(seed, a.known, a.kinds)
    s = held.scene
    row = {"seed": seed, "kind": kind, "outcome": "", "error": np.nan, "bound": held.bound, "angle_deg": round(np.degrees(s.angle), 1),
           "spacing_m": s.spacing, "x_m": s.place[0], "y_m": s.place[1], "about": held.about, "wall_s": np.nan, "said": ""}
    with tempfile.TemporaryDirectory() as folder:
        folder = a.keep / f"{kind}_{seed}" if a.keep else pathlib.Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / "case.toml"
        path.write_text(s.text())
        check = subprocess.run([a.program, "check", path], capture_output=True, text=True)
        if check.returncode == 2:
            return row | {"outcome": "refused", "said": brief(check.stderr)}
        if check.returncode:
            return row | {"outcome": "failed", "said": f"check: exit code {check.returncode}: " + brief(check.stderr)}
        run = Run(path, ["output.interval=0"], a.program, a.longest, threads=1, folder=folder / "run" if a.keep else None)
    row["wall_s"] = round(run.wall, 1)
    outcome = {0: "right", 2: "refused", 3: "stopped", 4: "stopped", 6: "warned", 124: "slow"}.get(run.exit, "failed")
    said = brief(run.reason) if run.exit else ""
    if outcome == "right":
        row["error"], said = judge(held, run)
        if not row["error"] <= held.bound:
            outcome = "SILENTLY WRONG"
        warned = [line for line in (check.stdout + check.stderr).splitlines() if "warning:" in line]
        said += f"; check: {brief(warned[0])[:90]}" if warned and outcome != "right" else ""
    return row | {"outcome": outcome, "said": said}


def brief(text):
    lines = [" ".join(line.split()) for line in text.splitlines() if line.strip() and "all of it:" not in line]
    return " | ".join(lines)[-400:]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, nargs="+", help="these alone")
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=200, help="of scenes, from seed --first on (default 200)")
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=list(KINDS))
    parser.add_argument("--known", nargs="+", choices=KNOWN, default=[], help="; ".join(f"{name}: {what}" for name, what in KNOWN.items()))
    parser.add_argument("--jobs", type=int, default=1, help="scenes at a time")
    parser.add_argument("--longest", type=float, default=120.0, help="s, of one run")
    parser.add_argument("--keep", type=pathlib.Path, help="folder in which each scene's case and run stay")
    parser.add_argument("--out", type=pathlib.Path, help="folder of random_scenes.csv (default: none is written)")
    parser.add_argument("--program", type=pathlib.Path, default=PROGRAM)
    a = parser.parse_args()
    a.program = a.program.resolve()
    rows = []
    with concurrent.futures.ThreadPoolExecutor(a.jobs) as pool:
        print(f"{'seed':>5} {'kind':<7}{'outcome':<15}{'error':>9}{'bound':>8}{'angle':>7}{'spacing':>9}{'x':>10}{'y':>10}{'wall s':>8}  about; said")
        for row in pool.map(lambda seed: one(seed, a), a.seeds or range(a.first, a.first + a.count)):
            rows.append(row)
            print(f"{row['seed']:>5} {row['kind']:<7}{row['outcome']:<15}{row['error']:>9.4f}{row['bound']:>8.3f}{row['angle_deg']:>7}{row['spacing_m']:>9.2g}"
                  f"{row['x_m']:>10.2g}{row['y_m']:>10.2g}{row['wall_s']:>8}  {row['about']}; {row['said']}", flush=True)
    print()
    for kind in a.kinds:
        counts = collections.Counter(row["outcome"] for row in rows if row["kind"] == kind)
        print(f"{kind:<8}" + ", ".join(f"{outcome} {count}" for outcome, count in sorted(counts.items())))
    if a.out:
        a.out.mkdir(parents=True, exist_ok=True)
        write_csv(a.out / "random_scenes.csv", rows)
    wrong = [row["seed"] for row in rows if row["outcome"] in ("SILENTLY WRONG", "failed")]
    print(f"{len(rows)} scenes, silently wrong or failed: {wrong or 'none'}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
