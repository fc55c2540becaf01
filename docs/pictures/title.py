#!/usr/bin/python3
"""The README's picture, from runs/submerged_soil and runs/terzaghi: title.py RUNS OUT.png"""
import csv
import pathlib
import sys

import h5py
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402


def last_frame(path, field):
    with h5py.File(path, "r", locking=False) as file:
        root = file["VTKHDF"]
        first, count = root["Steps/PointOffsets"][-1], root["NumberOfPoints"][-1]
        rows = slice(first, first + count)
        return root["Points"][rows], root["PointData"][field][rows]


def gauges(run):
    series = {}
    with open(run / "gauges.csv") as file:
        for row in csv.DictReader(file):
            series.setdefault(row["gauge"], []).append((float(row["time_s"]), float(row["value"])))
    return {name: np.array(values) for name, values in series.items()}


def reference(path):
    rows = [line.split(",") for line in open(path) if not line.startswith("#")]
    return np.array([[float(v) for v in row[:2]] for row in rows[1:]])


runs, out = pathlib.Path(sys.argv[1]), sys.argv[2]
plt.rcParams.update({"font.size": 9, "axes.titlesize": 9, "axes.linewidth": 0.8})
figure, axes = plt.subplots(1, 3, figsize=(11.5, 3.9), width_ratios=[1.25, 1, 1], constrained_layout=True)

bed = runs / "submerged_soil"
x, p = last_frame(bed / "fluid.vtkhdf", "pore_pressure")
y, stress = last_frame(bed / "solid.vtkhdf", "effective_stress")
water = x[:, 1] > 10
axes[0].scatter(x[water, 0], x[water, 1], c="#9ecae1", s=8, marker="s", linewidths=0)
drawn = axes[0].scatter(y[:, 0], y[:, 1], c=-stress[:, 1] / 1e3, s=12, marker="s", linewidths=0, cmap="YlOrBr")
figure.colorbar(drawn, ax=axes[0], label="vertical effective stress [kPa]", shrink=0.9)
axes[0].set(aspect="equal", xlabel="x [m]", ylabel="y [m]", title="Soil at rest under water (Bui & Nguyen 2017, 5.1)")

series, depth = gauges(bed), np.arange(11)
for name, label, slope, surface in [("sv_eff", "vertical, effective", 11.333, 0), ("sh_eff", "horizontal, effective", 4.857, 0),
                                    ("sv_total", "vertical, total", 21.143, 19.62), ("p_water", "pore pressure", 9.81, 19.62)]:
    sign = 1 if name == "p_water" else -1
    values = [sign * series[f"{name}[{i}]"][-1, 1] / 1e3 for i in depth]
    (line,) = axes[1].plot(surface + slope * depth, depth, lw=1)
    axes[1].plot(values, depth, "o", ms=4, mfc="none", color=line.get_color(), label=label)
axes[1].invert_yaxis()
axes[1].set(xlabel="[kPa]", ylabel="depth below ground [m]", title="On its centre line: computed (o), exact (line)")
axes[1].legend(frameon=False, fontsize=8)

column = runs / "terzaghi"
series = gauges(column)
here = pathlib.Path(__file__).resolve().parents[2] / "cases/terzaghi/reference"
settlement, exact = series["settlement"], reference(here / "settlement.csv")
axes[2].plot(settlement[:, 0], settlement[:, 1] / -9.9047619e-05, lw=1.2, label="consolidation")
axes[2].plot(exact[:, 0], exact[:, 1] / -9.9047619e-05, "o", ms=4, mfc="none", color="C0")
pressure, exact = series["base_pressure"], reference(here / "base_pressure.csv")
late = pressure[:, 0] > 0.01
axes[2].plot(pressure[late, 0], pressure[late, 1] / 1e3, lw=1.2, color="C1", label="base pressure over load")
axes[2].plot(exact[:, 0], exact[:, 1] / 1e3, "o", ms=4, mfc="none", color="C1")
axes[2].set(xlabel="time [s]", title="Terzaghi: computed (line), exact (o)")
axes[2].legend(frameon=False, fontsize=8)
figure.savefig(out, dpi=110)
