#!/usr/bin/python3
"""Measures the range in which the coupling is stable, by runs over permeability, stiffness, porosity and exchange window (time step of the
coupling). Writes OUT/stress.csv and the maps stress_column.png, stress_plain.png and stress_scenes.png; prints a table as Markdown.

Scenes:

    column  a saturated column under its weight, suddenly loaded by 1 kPa (cases/terzaghi with gravity), for each combination of
            --conductivities, --moduli, --porosities and --factors, with --windows windows each. The factor is the exchange window over
            the stability limit of plain staggering, 1.2 rho_bar_s k / gamma_w (docs/theory/symbols.md)
    plain   the column at the middle porosity by plain staggering (fluid.skeleton_response = false)
    front   water arrives on a dry column from above, and drains again
    block   a block of soil falls into water

Verdicts:

    bounded    The run ends by itself, and
               column, plain: in the second half of the run the plate has not moved by more than 1.5 times the drained settlement (plus
               1 % of the height); the size of the excess pressure at the base never exceeds 3.5 times the load, and in the second half
               exceeds neither 1.5 times the load nor, if this is more, 1.2 times its largest value in the first half. A column that
               misses this is repeated with ten times as many windows, in which an instability keeps growing;
               block, front: the soil moves no faster than it could fall, and no water is lost or created.
    unbounded  The run ends by itself, but not so.
    refused    The run ends before its first window, with a reason.
    diverged   The run gives up.
    too slow   The run takes longer than --longest.

Column `overshoot`: the largest excess pressure at the base over the load. During a window or two after loading 1 to 1.7 is normal.
"""
import argparse
import itertools
import pathlib
import re
import sys
import tempfile

import numpy as np
from plot import plt, style, write_csv
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


def judge(row, run, complaints):
    """Sets the verdict of a run in its table row. complaints: function that lists the missed bounds of a run that ended by itself."""
    row["cpu_s"] = round(run.cpu, 2)
    row["windows"] = int(run.summaries.get("coupler", {}).get("steps", {}).get("windows", 0))
    said = re.sub(r"\[[\d:]+\] | ?\(all of it: .*?\)|\S+/(?=case\.toml)", "", run.reason)  # without times and paths of this run
    row["why"] = " ".join(said.split())
    if run.exit in (0, 6):  # 6: the run ended, with warnings that put its result in doubt
        row["why"] = "; ".join(complaints(run))
        row["verdict"] = "unbounded" if row["why"] else "bounded"
    else:
        row["verdict"] = {2: "refused", 4: "diverged", 124: "too slow"}.get(run.exit, f"exit {run.exit}")
    return row


def within(run, name, low, high):
    """Checks a gauge in the second half of the run; yields a text if a value is not within low .. high."""
    times, values = run.gauges[name]
    values = values[(times >= 0.5 * times[-1]) & ~np.isnan(values)]
    if len(values) and not (low <= values.min() and values.max() <= high):
        yield f"{name} {values.min():.3g} .. {values.max():.3g}, expected {low:.3g} .. {high:.3g}"


def excess(run):
    """Excess pressure at the base over the load: in the first half of the run, in the second."""
    times, values = run.gauges["base_pressure"]
    over = (values - WEIGHT * HEIGHT) / LOAD
    late = times >= 0.5 * times[-1]
    return over[~late & ~np.isnan(over)], over[late & ~np.isnan(over)]


def column(a, k, E, n, factor, plain=False):
    window = factor * 1.2 * (1.0 - n) * GRAINS * k / WEIGHT
    M = E * (1.0 - POISSON) / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON))
    settlement = LOAD * HEIGHT / M
    weight = ((1.0 - n) * (GRAINS - 1000.0) * 9.81) * HEIGHT**2 / (2.0 * M)

    def complaints(run):
        yield from within(run, "settlement", -1.5 * (settlement + weight) - 0.01 * HEIGHT, 0.01 * HEIGHT)
        first, second = (np.abs(part).max(initial=0.0) for part in excess(run))
        if max(first, second) > 3.5 or second > max(1.5, 1.2 * first):
            yield f"excess pressure at the base {first:.3g} loads, then {second:.3g}"

    def judged(windows):
        row = {"scene": "plain" if plain else "column", "k": k, "E": E, "n": n, "factor": factor, "window_s": window, "verdict": "", "overshoot": ""}
        run = Run(CASES / "terzaghi", [
            f"soil.0.hydraulic_conductivity={k}", f"soil.0.youngs_modulus={E}", f"soil.0.porosity={n}", "case.gravity=[0, -9.81]",
            f"coupling.interval={window}", f"case.end_time={windows * window:.12g}", "output.interval=0", "fluid.particle_spacing=0.02",
            "solid.particle_spacing=0.02"] + ["fluid.skeleton_response=false"] * plain, a.program, a.longest)
        if run.exit in (0, 6):
            row["overshoot"] = round(max(part.max(initial=0.0) for part in excess(run)), 2)
        return judge(row, run, complaints)

    row = judged(a.windows)
    return judged(10 * a.windows) if row["verdict"] == "unbounded" and not plain else row


def plain(*arguments):
    return column(*arguments, plain=True)


def written(a, scene, text, soil, bounds):
    row = {"scene": scene, **dict(zip(("k", "E", "n"), soil)), "factor": "", "window_s": "", "verdict": "", "overshoot": ""}
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "case.toml"
        path.write_text(text)
        run = Run(path, [], a.program, a.longest)
    return judge(row, run, lambda run: (text for name, bound in bounds.items() for text in within(run, name, *bound)))


def front(a, k, E, n):
    half = max(1, round(0.2 * n * HEIGHT / k))  # s: time in which the front moves by at least a fifth of the column's height
    return written(a, "front", FRONT.format(k=k, E=E, n=n, half=half, later=1.1 * half, end=2 * half), (k, E, n),
                   {"speed": (0.0, 3.0), "water_error": (-1e-5, 1e-5)})


def block(a, k, E, n):
    return written(a, "block", BLOCK.format(k=k, E=E, n=n), (k, E, n), {"speed": (0.0, 3.0), "water": (0.17, 0.19)})


SCENES = {"column": column, "plain": plain, "front": front, "block": block}
# Runs that are known to be unbounded (docs/stability.md): scene, k, E, n. They are shown, but do not change the exit code.
MISSED = {("column", 0.1, 1e5, 0.2), ("block", 1e-3, 1e9, 0.2)}
MARKS = {"bounded": ("tab:green", "o"), "refused": ("0.6", "s"), "unbounded": ("tab:orange", "D"), "diverged": ("tab:red", "X"),
         "too slow": ("tab:purple", "v")}


def named(key, value):
    return f"E = {value / 1e6:g} MPa" if key == "E" else value if key == "scene" else f"{key} = {value:g}"


def draw(path, rows, across, down, y, label):
    """Draws one panel for each pair of values of the columns `down` and `across`, with k along the horizontal axis."""
    columns, lines = (sorted({row[key] for row in rows}) for key in (across, down))
    figure, panels = plt.subplots(len(lines), len(columns), figsize=(1.2 + 2.5 * len(columns), 0.8 + 2.3 * len(lines)), sharex=True, sharey=True,
                                  squeeze=False, constrained_layout=True)
    for i, line in enumerate(lines):
        for j, value in enumerate(columns):
            panel = panels[i][j]
            mine = [row for row in rows if row[across] == value and row[down] == line]
            for verdict, (colour, mark) in MARKS.items():
                chosen = [row for row in mine if row["verdict"].startswith(verdict)]
                panel.loglog([row["k"] for row in chosen], [row[y] for row in chosen], mark, color=colour, ls="", label=verdict)
            if y == "window_s":
                k, n = np.array(sorted({row["k"] for row in mine})), mine[0]["n"]
                panel.loglog(k, 1.2 * (1.0 - n) * GRAINS * k / WEIGHT, "k-", lw=0.8, label="limit of plain staggering")
            panel.set_title(f"{named(across, value)}, {named(down, line)}", fontsize=8)
    for panel in panels[-1]:
        panel.set_xlabel("k [m/s]")
    for row in panels:
        row[0].set_ylabel(label)
    drawn = {line.get_label(): line for panel in panels.flat for line in panel.get_lines() if len(line.get_xdata())}
    figure.legend(drawn.values(), drawn.keys(), loc="upper center", bbox_to_anchor=(0.5, 0.0), ncol=len(drawn), fontsize=8)
    style.save(figure, path)


def maps(out, rows):
    for name in ("column", "plain"):
        if mine := [row for row in rows if row["scene"] == name]:
            draw(out / f"stress_{name}.png", mine, "E", "n", "window_s", "window [s]")
    if mine := [row for row in rows if row["scene"] in ("front", "block")]:
        draw(out / "stress_scenes.png", mine, "n", "scene", "E", "E [Pa]")


def table(rows):
    """Markdown: number of runs with each verdict, by scene and stiffness."""
    lines = ["| scene | E, MPa | runs | " + " | ".join(MARKS) + " | CPU s a run |", "| --- " * (len(MARKS) + 4) + "|"]
    for scene, E in dict.fromkeys((row["scene"], row["E"]) for row in rows):
        mine = [row for row in rows if (row["scene"], row["E"]) == (scene, E)]
        counts = [sum(row["verdict"].startswith(verdict) for row in mine) or "" for verdict in MARKS]
        lines.append(f"| {scene} | {E / 1e6:g} | {len(mine)} | " + " | ".join(map(str, counts)) + f" | {np.mean([row['cpu_s'] for row in mine]):.2f} |")
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=PROGRAM)
    parser.add_argument("--scenes", nargs="+", choices=list(SCENES), default=list(SCENES))
    parser.add_argument("--conductivities", type=float, nargs="+", default=[1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1])
    parser.add_argument("--moduli", type=float, nargs="+", default=[1e5, 1e6, 1e7, 1e8, 1e9], help="Pa, Young's")
    parser.add_argument("--porosities", type=float, nargs="+", default=[0.2, 0.4, 0.6])
    parser.add_argument("--factors", type=float, nargs="+", default=[0.1, 1.0, 10.0, 100.0])
    parser.add_argument("--windows", type=int, default=100, help="of one run of the column")
    parser.add_argument("--longest", type=float, default=60.0, help="s, of one run")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("runs/bench"))
    a = parser.parse_args()
    soils = list(itertools.product(a.conductivities, a.moduli, a.porosities))
    middle = a.porosities[len(a.porosities) // 2]
    rows = []
    for scene in a.scenes:
        mine = [soil for soil in soils if scene != "plain" or soil[2] == middle]
        jobs = [(*soil, factor) for soil in mine for factor in a.factors] if scene in ("column", "plain") else mine
        for job in jobs:
            rows.append(SCENES[scene](a, *job))
            r = rows[-1]
            print(f"{scene:<7} k={r['k']:g} E={r['E']:g} n={r['n']:g} factor={r['factor']} {r['verdict']} ({r['windows']} windows, "
                  f"{r['cpu_s']} CPU s) {r['overshoot']} {r['why'][:300]}", flush=True)
            write_csv(a.out / "stress.csv", rows)
    maps(a.out, rows)
    print("\n".join(table(rows)), f"\n\ntable and maps: {a.out}/stress.csv, stress_column.png, stress_plain.png, stress_scenes.png")
    bad = [row for row in rows if row["scene"] != "plain" and row["verdict"] not in ("bounded", "refused")]
    sys.exit(any((row["scene"], row["k"], row["E"], row["n"]) not in MISSED for row in bad))


if __name__ == "__main__":
    main()
