#!/usr/bin/python3
"""Measures the error that sleeping soil causes (soil whose steps are skipped while its forces hardly change), and the
work that it saves. Writes sleep.csv and sleep.png beside this file.

Scene `slow`: seepage through the bed of cases/upward_seepage rises to 0.75 of the critical gradient in 20 s and falls
back in 20 s. The error is the largest difference of the vertical effective stress at four depths from the run without
sleep, over the stress at the base without flow.
Scene `heave`: the seepage rises beyond the critical gradient. The error is that of the gradient at which the bed has
risen by 1 mm, relative to the run without sleep.
"""
import argparse
import csv
import pathlib

import numpy as np
from plot import plt, style
from runs import PROGRAM, Run

HERE = pathlib.Path(__file__).resolve().parent
CRITICAL, BASE = 0.99, 0.99 * 9810.0  # critical gradient; Pa, effective stress at the base without flow
SCENES = {
    "slow": ["case.end_time=42", f"pore_pressure.0.to_head=[[0, 1.2], [20, {1.2 + 0.75 * CRITICAL}], [40, 1.2]]"],
    "heave": ["case.end_time=44", f"pore_pressure.0.to_head=[[0, 1.2], [44, {1.2 + 1.1 * CRITICAL}]]"],
}
# Keys of [solid.quiet]: sleep_below and wake_above, in units of gravity g, and damping (of quasi-static windows).
SETTINGS = [(1e-4, 1e-3, True), (1e-3, 3e-3, True), (1e-3, 5e-3, True), (1e-3, 1e-2, True), (1e-3, 3e-2, True),
            (1e-3, 5e-3, False)]


def run(program, overrides):
    """Makes one run; returns its gauges and the solid solver's summary."""
    done = Run("upward_seepage", overrides, program)
    if done.exit != 0:
        raise SystemExit(done.reason)
    return done.gauges, done.summaries["solid"]


def stress_error(gauges, full):
    worst = 0.0
    for k in range(4):
        times, values = gauges[f"vertical[{k}]"]
        worst = max(worst, np.abs(values - np.interp(times, *full[f"vertical[{k}]"])).max() / BASE)
    return worst


def lift(gauges):
    times, values = gauges["uplift"]
    return times[np.argmax(values > 1e-3)]


def draw(rows):
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.6), constrained_layout=True)
    titles = {"slow": "stress error over the base value", "heave": "error of the gradient at which the bed lifts"}
    for axis, scene in zip(axes, SCENES):
        mine = [r for r in rows if r[0] == scene]
        for r in mine[1:]:
            axis.plot(r[4] / mine[0][4], max(r[7], 1e-5), "o" if r[3] else "s", color="C0" if r[3] else "C1")
            axis.annotate(f"{r[1]:g} / {r[2]:g}", (r[4] / mine[0][4], max(r[7], 1e-5)), fontsize=7,
                          textcoords="offset points", xytext=(0, 5), ha="center")
        axis.set(xscale="log", yscale="log", xlabel="substeps computed, of all", ylabel=titles[scene], title=scene)
        axis.grid(True)
        axis.margins(0.15)
    figure.suptitle("Sleep below / wake above [g]; squares: without damping", fontsize=9)
    style.save(figure, HERE / "sleep.png")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--poretwin", default=PROGRAM)
    program = parser.parse_args().poretwin
    rows = []
    for scene, overrides in SCENES.items():
        full, summary = run(program, overrides)
        rows.append([scene, "", "", "", summary["counters"]["substeps"], 0, summary["cpu_s"], 0])
        for below, above, damping in SETTINGS:
            gauges, summary = run(program, overrides + [f"solid.quiet.sleep_below={below}",
                                                        f"solid.quiet.wake_above={above}",
                                                        f"solid.quiet.damping={str(damping).lower()}"])
            error = stress_error(gauges, full) if scene == "slow" else abs(lift(gauges) / lift(full) - 1.0)
            counters = summary["counters"]
            rows.append([scene, below, above, damping, counters["substeps"], counters["substeps asleep"],
                         summary["cpu_s"], error])
            print(*rows[-1])
    with open(HERE / "sleep.csv", "w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(["scene", "sleep_below_g", "wake_above_g", "damping", "substeps", "substeps_asleep", "cpu_s",
                         "error"])
        writer.writerows(rows)
    draw(rows)


if __name__ == "__main__":
    main()
