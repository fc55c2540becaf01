#!/usr/bin/python3
"""Computes and measures the longest stable window (time step of the coupling) for several coupling schemes. Writes OUT/schemes.csv and
prints the table of docs/notebook/coupling.md.

Theory: consider one mode of wave number kappa in a column that drains through its top. One window, as the solvers compute it (function
`window`), is a linear map of the values kept between two windows. The limit is the longest window for which no mode of the column
grows, nor a uniform relative velocity of the phases (kappa = 0).

Measurement: cases/terzaghi at a spacing of 2 cm. Windows are halved and doubled until one that is stable and one that is not differ by
10 %. A run counts as stable if it is bounded: in its second half the largest pressure at the base is at most 1.2 times that in its
first half, or at most 1.5 times the load, and the windows have the prescribed length (the fluid solver shortens windows where the
pressure oscillates). Columns `error`: error of the degree of consolidation against the reference of consolidation.py, with windows of
--accuracy.
"""
import argparse
import functools
import pathlib

import numpy as np
from consolidation import reference
from plot import write_csv
from runs import PROGRAM, Run

HEIGHT, SPACING, LOAD, MODULUS, GAMMA = 0.4, 0.02, 1e3, 3e6 * 0.7 / (1.3 * 0.4), 9810.0  # m, m, Pa, Pa (constrained), N/m3 (water)
POROSITY, GRAINS, WATER = 0.4, 2600.0, 1000.0  # 1, kg/m3, kg/m3
N_S, SOIL = 1.0 - POROSITY, (1.0 - POROSITY) * GRAINS  # 1, kg/m3
SUBSTEP = 0.8 * SPACING * np.sqrt(SOIL / MODULUS)  # s, substep of the soil
SCHEMES = {
    "serial (default)": [],
    "serial, plain": ["fluid.skeleton_response=false"],
    "parallel": ["coupling.scheme=\"parallel\""],
    "parallel, plain": ["coupling.scheme=\"parallel\"", "fluid.skeleton_response=false"],
    "iterated, plain": ["coupling.scheme=\"iterated\"", "fluid.skeleton_response=false"],
}
# Values kept between two windows. Water: velocity w, deferred impulse, pressure gradient g, prediction s of the soil's velocity, drag impulse J.
# Soil: displacement u, velocity v, last pressure gradient, mean velocity, impulse returned to the water.
KEPT = ["w", "owed", "u", "v", "ramped", "g", "s", "J", "mean", "returned"]


def fluid(x, v, r, mean, dt, k, kappa, plain):
    """The water's values after a window of dt [s]. x: all values before it, by name. Received from the soil: its velocity v, the force r on it
    [N/m3] and its mean velocity."""
    C, aw = GAMMA * POROSITY**2 / k, POROSITY * WATER / dt
    owed = x["owed"] + x["returned"]
    taken = aw / (aw + C) * owed
    w = x["w"] - taken / (POROSITY * WATER)
    if plain:  # without prediction: the skeleton is taken to move as before
        new = -N_S / POROSITY * v if kappa else (aw * w + C * v) / (aw + C)
        g = -(aw * (new - w) + C * (new - v)) / POROSITY if kappa else 0.0
        J = dt * C * (new - v)
        s = v + dt / SOIL * (r - N_S * g) + J / SOIL
    else:
        e = N_S + POROSITY * C / (aw + C)
        A = np.array([[aw + C, -C, POROSITY], [-C, SOIL / dt + C + dt * MODULUS * kappa**2, N_S], [POROSITY, N_S, 0.0]])
        b = np.array([aw * w, SOIL / dt * v + r, -e * (mean - x["s"])])
        new, s, g = np.linalg.solve(A, b) if kappa else [*np.linalg.solve(A[:2, :2], b[:2]), 0.0]
        J = dt * C * (new - s)
    return {"w": new, "owed": owed - taken, "g": g, "s": s, "J": J}


def soil(x, g, s, J, dt, k, kappa, scheme):
    C = GAMMA * POROSITY**2 / k
    Z = {"serial (default)": C + 0.5 * SOIL / dt, "parallel": C / POROSITY**2 + 0.5 * SOIL / dt}.get(scheme, C)
    steps = int(np.ceil(dt / SUBSTEP - 1e-9))
    h, u, v, returned = dt / steps, x["u"], x["v"], 0.0
    for i in range(steps):
        share = (i + 1) / steps
        force = -MODULUS * kappa**2 * u - N_S * ((1.0 - share) * x["ramped"] + share * g) + J / dt
        v = (v + h / SOIL * (force + Z * s)) / (1.0 + h * Z / SOIL)
        returned += h * Z * (s - v)
        u += h * v
    return {"u": u, "v": v, "mean": (u - x["u"]) / dt, "returned": returned, "ramped": g}


def window(x, scheme, dt, k, kappa):
    """The kept values after one more window of length dt [s]; x: their present values by name."""
    plain = scheme.endswith("plain")
    if scheme.startswith("parallel"):
        return {**fluid(x, x["v"], -MODULUS * kappa**2 * x["u"], x["mean"], dt, k, kappa, plain),
                **soil(x, x["g"], x["s"], x["J"], dt, k, kappa, scheme)}

    def one_pass(v, u, mean):
        water = fluid(x, v, -MODULUS * kappa**2 * u, mean, dt, k, kappa, plain)
        return {**water, **soil(x, water["g"], water["s"], water["J"], dt, k, kappa, scheme)}

    if scheme.startswith("serial"):
        return one_pass(x["v"], x["u"], x["mean"])
    names, columns = ["v", "u", "mean"], []  # iterated: a pass whose output equals its input; a pass is an affine map
    rest = np.array([one_pass(0.0, 0.0, 0.0)[name] for name in names])
    for unit in np.eye(3):
        columns.append(np.array([one_pass(*unit)[name] for name in names]) - rest)
    return one_pass(*np.linalg.solve(np.eye(3) - np.array(columns).T, rest))


def growth(scheme, dt, k, kappa):
    """Growth per window of the fastest growing combination of kept values."""
    columns = []
    for unit in np.eye(len(KEPT)):
        after = window(dict(zip(KEPT, unit)), scheme, dt, k, kappa)
        columns.append([after[name] for name in KEPT])
    return np.abs(np.linalg.eigvals(np.array(columns).T)).max()


def limit_by_theory(scheme, k):
    # Waves with kappa above 0.9 / SPACING are left out: the operators treat them as longer waves.
    modes = [0.0] + [kappa for kappa in (np.arange(HEIGHT / SPACING) + 0.5) * np.pi / HEIGHT if kappa < 0.9 / SPACING]
    stable = lambda dt: all(growth(scheme, dt, k, kappa) < 1.0 + 1e-7 for kappa in modes)  # momentum is conserved: 1 up to rounding
    times = np.geomspace(1e-7, 3e-2, 120)
    for short, long in zip(times, times[1:]):
        if stable(long):
            continue
        for _ in range(12):
            middle = np.sqrt(short * long)
            short, long = (middle, long) if stable(middle) else (short, middle)
        return short
    return np.inf


def column(a, scheme, k, dt, end):
    settings = [f"soil.0.hydraulic_conductivity={k}", f"coupling.interval={dt}", f"case.end_time={end:.12g}", "output.interval=0",
                f"fluid.particle_spacing={SPACING}", f"solid.particle_spacing={SPACING}", "water.cavitation_pressure=-1e12"]
    return Run("terzaghi", settings + SCHEMES[scheme], a.program, a.longest)


def bounded(a, scheme, k, dt):
    run = column(a, scheme, k, dt, a.windows * dt)
    if run.exit != 0:
        return False
    t, p = run.gauges["base_pressure"]
    p = np.abs(p) / LOAD
    late = t >= 0.5 * t[-1]
    return bool(np.isfinite(p).all()) and p[late].max() <= max(1.5, 1.2 * p[~late].max()) and np.median(np.diff(t[late])) >= 0.9 * dt


def error(a, scheme, k, dt):
    """Largest error of the degree of consolidation from Terzaghi's dimensionless time Tv = 0.1 to 0.5; NaN where the run does not end
    well."""
    unit = HEIGHT**2 * GAMMA / (k * MODULUS)
    run = column(a, scheme, k, dt, 0.5 * unit)
    if run.exit != 0:
        return np.nan
    t, settlement = run.gauges["settlement"]
    late = t >= 0.1 * unit
    return np.abs(-settlement[late] * MODULUS / (LOAD * HEIGHT) - reference(k, t[late])[0]).max()


def limit_measured(a, scheme, k, guess):
    """Longest window with which a run was bounded, and the shortest with which it was not (inf: all up to --most were bounded)."""
    holds = functools.cache(lambda dt: bounded(a, scheme, k, dt))
    dt = min(guess, a.most)
    while holds(dt):
        if dt >= a.most:
            return dt, np.inf
        dt = min(2.0 * dt, a.most)
    short, long = 0.5 * dt, dt
    while not holds(short):
        short, long = 0.5 * short, short
        if short < 1e-8:
            return 0.0, long
    while long > 1.1 * short:
        middle = np.sqrt(short * long)
        short, long = (middle, long) if holds(middle) else (short, middle)
    return short, long


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=PROGRAM)
    parser.add_argument("--conductivities", type=float, nargs="+", default=[1e-3, 1.1e-4, 1e-5])
    parser.add_argument("--schemes", nargs="+", choices=SCHEMES, default=list(SCHEMES))
    parser.add_argument("--windows", type=int, default=400, help="of one run, at least")
    parser.add_argument("--most", type=float, default=1e-2, help="s, longest window tried")
    parser.add_argument("--longest", type=float, default=120.0, help="s, of one run")
    parser.add_argument("--accuracy", type=float, nargs="+", default=[1e-4, 1e-3, 1e-2], help="s, windows of the error's runs")
    parser.add_argument("--theory", action="store_true", help="run nothing")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("bench-results"))
    a = parser.parse_args()
    rows = []
    print("| scheme | k, m/s | limit by theory | measured |" + "".join(f" error at {dt:g} s |" for dt in a.accuracy) + "\n" + "| --- " * (4 + len(a.accuracy)) + "|")
    for scheme in a.schemes:
        for k in a.conductivities:
            unit, theory = SOIL * k / GAMMA, limit_by_theory(scheme, k)
            short, long = (np.nan, np.nan) if a.theory else limit_measured(a, scheme, k, unit if theory > a.most else theory)
            row = {"scheme": scheme, "k": k, "unit_s": unit, "theory_s": theory, "holds_s": short, "fails_s": long}
            row |= {f"error_{dt:g}": np.nan if a.theory or dt > short else error(a, scheme, k, dt) for dt in a.accuracy}
            rows.append(row)
            cells = ["none" if np.isinf(theory) else f"{theory:.2g} s = {theory / unit:.2f}",
                     "" if a.theory else f"none to {short:.2g} s" if np.isinf(long) else f"{short:.2g} - {long:.2g} s = {short / unit:.2f} - {long / unit:.2f}"]
            cells += ["" if np.isnan(row[f"error_{dt:g}"]) else f"{row[f'error_{dt:g}']:.4f}" for dt in a.accuracy]
            print(f"| {scheme} | {k:g} | {' | '.join(cells)} |", flush=True)
    if not a.theory:
        write_csv(a.out / "schemes.csv", rows)


if __name__ == "__main__":
    main()
