#!/usr/bin/python3
"""What the coupling stands: a table of runs over permeability, stiffness, porosity and exchange window. OUT/stress.csv.

    column  a saturated column under its weight, loaded by 1 kPa at once (cases/terzaghi with gravity), each combination of
            --conductivities, --moduli, --porosities and --factors (exchange window over plain staggering's limit
            1.2 rho_bar_s k / gamma_w), --windows windows each
    front   water arrives on a dry column from above, and leaves it again
    block   a block of soil falls into water

A run counts as bounded when it ends by itself and, in its second half, the plate has not moved farther than 1.5 times the drained
settlement (1 % of the height more), and the water at the base carries no more than 1.5 times the load more than its rest.
`overshoot`: the largest excess pressure at the base over the load. 1.5 to 3 at first is common where windows are shorter than
the water takes to drain three rows of particles: docs/theory.md.
"""
import argparse
import itertools
import pathlib
import sys
import tempfile

import numpy as np
from plot import write_csv
from runs import PROGRAM, Run

HEIGHT, LOAD, WEIGHT, GRAINS, POISSON = 0.4, 1e3, 9810.0, 2600.0, 0.3
CASES = pathlib.Path(__file__).resolve().parent.parent / "cases"

FRONT = """
[case]
end_time = {end}
[[soil]]
min = [0, 0]
max = [0.1, 0.4]
porosity = {n}
hydraulic_conductivity = {k}
youngs_modulus = {E}
[[wall]]
points = [[0, 0], [0.1, 0]]
soil = "fixed"
[[wall]]
points = [[0.1, 0], [0.1, 0.4]]
[[wall]]
points = [[0, 0.4], [0, 0]]
[[water_face]]
points = [[0.1, 0.4], [0, 0.4]]
head = [[0, 0.5], [{half}, 0.5], [{later}, 0.1]]
[fluid]
particle_spacing = 0.02
[[gauge]]
name = "speed"
phase = "solid"
kind = "max_speed"
[[gauge]]
name = "water"
phase = "fluid"
kind = "balance"
"""

BLOCK = """
[case]
end_time = 1
[[soil]]
min = [0.2, 0.32]
max = [0.4, 0.42]
porosity = {n}
hydraulic_conductivity = {k}
youngs_modulus = {E}
[[wall]]
points = [[0, 0.6], [0, 0], [0.6, 0], [0.6, 0.6]]
[fluid]
particle_spacing = 0.02
[[fluid.region]]
min = [0, 0]
max = [0.6, 0.3]
[solid]
model = "{model}"
initial_rest = false
[[gauge]]
name = "speed"
phase = "solid"
kind = "max_speed"
[[gauge]]
name = "water"
phase = "fluid"
kind = "volume"
"""


def judge(row, run, bounds):
    """bounds: {gauge: (lowest, highest)}."""
    row["cpu_s"] = round(run.cpu, 2)
    row["windows"] = int(run.summaries.get("coupler", {}).get("steps", {}).get("windows", 0))
    said = run.reason.replace("\n", " ")
    if run.exit == 2:
        row["verdict"], row["why"] = "refused", said
    elif run.exit != 0:
        row["verdict"], row["why"] = {4: "diverged", 124: "too slow"}.get(run.exit, f"exit {run.exit}"), said
    else:
        row["verdict"] = "bounded"
        for name, (low, high) in bounds.items():
            times, values = run.gauges[name]
            values = values[(times >= 0.5 * times[-1]) & ~np.isnan(values)]
            if len(values) and not (low <= values.min() and values.max() <= high):
                row["verdict"] = "unbounded"
                row["why"] += f"{name} {values.min():.3g} .. {values.max():.3g}, expected {low:.3g} .. {high:.3g}; "
    return row


def column(a, k, E, n, factor):
    window = factor * 1.2 * (1.0 - n) * GRAINS * k / WEIGHT
    end = a.windows * window
    M = E * (1.0 - POISSON) / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON))
    row = {"scene": "column", "k": k, "E": E, "n": n, "factor": factor, "window_s": window, "why": ""}
    run = Run(CASES / "terzaghi", [
        f"soil.0.hydraulic_conductivity={k}", f"soil.0.youngs_modulus={E}", f"soil.0.porosity={n}", "case.gravity=[0, -9.81]",
        f"coupling.interval={window}", f"case.end_time={end:.12g}", "output.interval=0", "fluid.particle_spacing=0.02",
        "solid.particle_spacing=0.02"], a.program, a.longest)
    row["overshoot"] = ""
    if run.exit == 0:
        row["overshoot"] = round((np.nanmax(run.gauges["base_pressure"][1]) - WEIGHT * HEIGHT) / LOAD, 2)
    settlement = LOAD * HEIGHT / M
    weight = ((1.0 - n) * (GRAINS - 1000.0) * 9.81) * HEIGHT**2 / (2.0 * M)
    return judge(row, run, {"settlement": (-1.5 * (settlement + weight) - 0.01 * HEIGHT, 0.01 * HEIGHT),
                            "base_pressure": (WEIGHT * HEIGHT - 1.5 * LOAD, WEIGHT * HEIGHT + 1.5 * LOAD)})


def written(a, text, row, bounds):
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "case.toml"
        path.write_text(text)
        return judge(row, Run(path, [], a.program, a.longest), bounds)


def front(a, k, E, n):
    half = max(1, round(0.5 * n * HEIGHT / k))  # s, for the front to come half-way or so
    row = {"scene": "front", "k": k, "E": E, "n": n, "factor": "", "window_s": "", "why": "", "overshoot": ""}
    return written(a, FRONT.format(k=k, E=E, n=n, half=half, later=1.1 * half, end=2 * half), row, {"speed": (0.0, 3.0), "water_error": (-1e-5, 1e-5)})


def block(a, k, E, n, model="elastic"):
    row = {"scene": "block", "k": k, "E": E, "n": n, "factor": "", "window_s": "", "why": "", "overshoot": ""}
    return written(a, BLOCK.format(k=k, E=E, n=n, model=model), row, {"speed": (0.0, 3.0), "water": (0.17, 0.19)})


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=PROGRAM)
    parser.add_argument("--scenes", nargs="+", choices=["column", "front", "block"], default=["column", "front", "block"])
    parser.add_argument("--conductivities", type=float, nargs="+", default=[1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1])
    parser.add_argument("--moduli", type=float, nargs="+", default=[1e5, 1e6, 1e7, 1e9], help="Pa, Young's")
    parser.add_argument("--porosities", type=float, nargs="+", default=[0.2, 0.4, 0.6])
    parser.add_argument("--factors", type=float, nargs="+", default=[0.1, 1.0, 10.0, 100.0])
    parser.add_argument("--windows", type=int, default=100, help="of one run of the column")
    parser.add_argument("--longest", type=float, default=300.0, help="s, of one run")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("bench-results"))
    a = parser.parse_args()
    soils = list(itertools.product(a.conductivities, a.moduli, a.porosities))
    jobs = [(column, (*soil, factor)) for soil in soils for factor in a.factors if "column" in a.scenes]
    jobs += [(front, soil) for soil in soils if "front" in a.scenes] + [(block, soil) for soil in soils if "block" in a.scenes]
    rows = []
    for scene, job in jobs:
        rows.append(scene(a, *job))
        r = rows[-1]
        print(f"{r['scene']:<7} k={r['k']:g} E={r['E']:g} n={r['n']:g} factor={r['factor']} {r['verdict']} ({r['windows']} windows, {r['cpu_s']} CPU s) "
              f"{r['overshoot']} {r['why'][:300]}", flush=True)
        write_csv(a.out / "stress.csv", rows)
    bad = sum(row["verdict"] not in ("bounded", "refused") for row in rows)
    print(f"{len(rows)} runs: {sum(row['verdict'] == 'bounded' for row in rows)} bounded, "
          f"{sum(row['verdict'] == 'refused' for row in rows)} refused, {bad} neither")
    sys.exit(bad > 0)


if __name__ == "__main__":
    main()
