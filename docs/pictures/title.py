#!/usr/bin/python3
"""The README's picture: title.py RUNS OUT.png, from these runs in that folder:

poretwin run embankment_seepage --until 3000 --set output.interval=200
poretwin run embankment_failure
poretwin run submerged_soil
poretwin run terzaghi
"""
import pathlib
import sys

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "cli"))
import plot  # noqa: E402
from cells import SURFACE, Canvas  # noqa: E402
import style  # noqa: E402
from style import plt  # noqa: E402


def reference(path):
    rows = [line.split(",") for line in open(ROOT / "cases" / path) if not line.startswith("#")]
    return np.array([[float(v) for v in row] for row in rows[1:]])


def seepage(axes, run):
    frames, fronts = plot.Frames(run / "fluid.vtkhdf"), reference("embankment_seepage/reference/front.csv")
    plot.paint(axes, frames, "fluid", "pore_pressure", frames.n_steps - 1)
    for t in (200, 800, 3000):
        body = plot.Body(frames, int(np.argmin(np.abs(frames.times - t))))
        canvas = Canvas([0, 0], [1.2, 0.4], body.dx)
        axes.contour(canvas.cover(body.x, body.size), levels=[SURFACE], colors="white", linewidths=0.8, extent=canvas.extent)
        right = fronts[fronts[:, 0] == t]
        axes.plot(right[:, 2], right[:, 1], "o", ms=3.8, mfc="white", mec="black", mew=0.8)
        axes.annotate(f"{t} s", right[0, [2, 1]], (5, 6), textcoords="offset points", fontsize=8)
    axes.set_title("Water enters a dry embankment: fronts (lines) and an independent reference (o)")


def failure(axes, run):
    frames = plot.Frames(run / "solid.vtkhdf")
    plot.paint(axes, frames, "solid", "accumulated_plastic_strain", frames.n_steps - 1)
    axes.set_title(f"... and it fails: slip surface from toe to crest, {frames.times[-1]:.0f} s; blue: the water")


def at_rest(axes, run):
    series, depth = plot.read_gauges(run), np.arange(11)
    for name, label, slope, surface in [("sv_eff", "vertical, effective", 11.333, 0), ("sh_eff", "horizontal, effective", 4.857, 0),
                                        ("sv_total", "vertical, total", 21.143, 19.62), ("p_water", "pore pressure", 9.81, 19.62)]:
        sign = 1 if name == "p_water" else -1
        values = [sign * series[f"{name}[{i}]"]["v"][-1] / 1e3 for i in depth]
        (line,) = axes.plot(surface + slope * depth, depth, lw=1)
        axes.plot(values, depth, "o", ms=4, mfc="none", color=line.get_color(), label=label)
    axes.invert_yaxis()
    axes.set(xlabel="[kPa]", ylabel="depth below ground [m]", title="Stresses in soil under water: computed (o), exact (line)")
    axes.legend(frameon=False, fontsize=8)


def consolidation(axes, run):
    series = plot.read_gauges(run)
    for gauge, name, scale, label in [("settlement", "settlement", -1 / 9.9047619e-05, "consolidation"),
                                      ("base_pressure", "base_pressure", 1e-3, "base pressure over load")]:
        exact = reference(f"terzaghi/reference/{name}.csv")
        t, v = np.array(series[gauge]["t"]), np.array(series[gauge]["v"])
        shown = t > 0.01
        (line,) = axes.plot(t[shown], v[shown] * scale, lw=1.2, label=label)
        axes.plot(exact[:, 0], exact[:, 1] * scale, "o", ms=4, mfc="none", color=line.get_color())
    axes.set(xlabel="time [s]", title="Terzaghi's consolidation: computed (line), exact (o)")
    axes.legend(frameon=False, fontsize=8)


runs, out = pathlib.Path(sys.argv[1]), sys.argv[2]
style.use()
figure, axes = plt.subplots(2, 2, figsize=(12.5, 6.2), height_ratios=[1, 0.95], layout="tight")
seepage(axes[0, 0], runs / "embankment_seepage")
failure(axes[0, 1], runs / "embankment_failure")
at_rest(axes[1, 0], runs / "submerged_soil")
consolidation(axes[1, 1], runs / "terzaghi")
figure.savefig(out, dpi=110)
