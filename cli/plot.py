#!/usr/bin/python3
"""Pictures of a run: fields of either phase at a time, gauges against time with their references.

Called by `poretwin plot RUN ...`; needs the Debian packages python3-h5py, python3-numpy, python3-matplotlib.
"""
import argparse
import csv
import pathlib
import re
import sys

import h5py
import matplotlib
import matplotlib.colors
import numpy as np
from cells import SURFACE, Canvas, spacing

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the backend is chosen)
from mpl_toolkits.axes_grid1 import make_axes_locatable  # noqa: E402

# The field that tells most about a phase, best first.
MAIN_FIELDS = {
    "fluid": ["pore_pressure", "velocity"],
    "solid": ["effective_stress", "accumulated_plastic_strain", "displacement"],
}
AROUND = {"fluid": "#d8d5cf", "solid": "#d3e5f3"}  # behind the water: soil; behind the soil: water
WATER_LINE = "#2b7bba"
LEAST_STRAIN = 1e-3  # plastic strain is drawn by its logarithm, from here on
TENSOR = ["xx", "yy", "zz", "xy", "yz", "xz"]
STYLE = {"font.size": 9, "axes.linewidth": 0.8, "figure.dpi": 100, "savefig.dpi": 200, "axes.grid": False}


class Frames:
    """One phase's file: steps found through the offsets, as a VTKHDF reader does."""

    def __init__(self, path):
        self.file = h5py.File(path, "r", locking=False)
        self.root = self.file["VTKHDF"]
        self.steps = self.root["Steps"]
        self.n_steps = int(self.steps.attrs["NSteps"])
        self.times = self.steps["Values"][: self.n_steps]

    def fields(self):
        return list(self.root["PointData"])

    def rows(self, step):
        first = int(self.steps["PointOffsets"][step])
        return slice(first, first + int(self.root["NumberOfPoints"][step]))

    def positions(self, step):
        return self.root["Points"][self.rows(step)]

    def values(self, name, step):
        return self.root["PointData"][name][self.rows(step)]

    def unit(self, name):
        unit = self.root["PointData"][name].attrs.get("unit", "")
        return unit.decode() if isinstance(unit, bytes) else str(unit)


def scalar(frames, name, step):
    """Values and label of NAME: a field, or one component (velocity_x, effective_stress_yy); vectors by their length."""
    fields = frames.fields()
    if name in fields:
        values = frames.values(name, step)
        if values.ndim == 1:
            return values, name
        if values.shape[1] == 3:
            return np.linalg.norm(values, axis=1), f"|{name}|"
        vertical = 2 if is_3d(frames, step) else 1
        return values[:, vertical], f"{name}_{TENSOR[vertical]}"
    stem, _, component = name.rpartition("_")
    if stem in fields:
        names = TENSOR if frames.values(stem, step).shape[-1] == 6 else ["x", "y", "z"]
        if component in names:
            return frames.values(stem, step)[:, names.index(component)], name
    raise SystemExit(f"no field '{name}'; there are: {', '.join(fields)}")


def is_3d(frames, step):
    x = frames.positions(step)
    return len(x) > 0 and np.ptp(x[:, 2]) > 0


def prefix(value):
    """A scale that keeps numbers short: kPa, mm."""
    for factor, sign in ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ")):
        if value >= factor:
            return factor, sign
    return 1.0, ""


class Body:
    """The particles of one frame in the plane of the picture: of a 3D run its middle slice, seen from the front."""

    def __init__(self, frames, step, values=None):
        x = frames.positions(step)
        self.three = is_3d(frames, step)
        dimensions = 3 if self.three else 2
        if "volume" in frames.fields():
            size = frames.values("volume", step) ** (1.0 / dimensions)
        else:  # of a solver that does not tell it
            size = np.full(len(x), spacing(x[:, :dimensions]))
        self.dx = float(np.median(size))
        keep = np.abs(x[:, 1] - np.median(x[:, 1])) <= 0.75 * self.dx if self.three else np.ones(len(x), dtype=bool)
        self.x, self.size = x[keep][:, [0, 2] if self.three else [0, 1]], size[keep]
        self.values = None if values is None else values[keep]


def other_body(frames, phase, step):
    """The other phase of the same run at the same time, where there is one."""
    other = "solid" if phase == "fluid" else "fluid"
    path = pathlib.Path(frames.file.filename).with_name(f"{other}.vtkhdf")
    if not path.exists():
        return None
    there = Frames(path)
    if there.n_steps == 0:
        return None
    nearest = int(np.argmin(np.abs(there.times - frames.times[step])))
    return Body(there, nearest) if len(there.positions(nearest)) > 0 else None


def view(points, margin):
    """Corners of what is drawn: all of the points, but for some of a splash that fly far off."""
    low, high = np.quantile(points, 0.005, axis=0), np.quantile(points, 0.995, axis=0)
    far = 0.5 * (high - low).max()
    return np.maximum(points.min(axis=0), low - far) - margin, np.minimum(points.max(axis=0), high + far) + margin


def paint(axes, frames, phase, name, step):
    """One field of one phase, in its surroundings: grey soil around the water, or pale blue water and its outline over the soil."""
    values, label = scalar(frames, name, step)
    unit = frames.unit(name if name in frames.fields() else name.rpartition("_")[0])
    body, around = Body(frames, step, values), other_body(frames, phase, step)
    values, largest = body.values, np.nanmax(np.abs(body.values)) if np.isfinite(body.values).any() else 0.0
    factor, sign = prefix(largest) if unit in ("Pa", "m", "m/s", "N") else (1.0, "")
    # A diverging map only where both signs matter: a little noise around zero does not.
    signed = min(-np.nanmin(values), np.nanmax(values)) > 0.05 * largest
    limits = {"vmin": -largest / factor, "vmax": largest / factor} if signed else {}
    if name == "accumulated_plastic_strain" and largest > LEAST_STRAIN:  # slip bands beside grains that have rolled away
        values, limits = np.maximum(values, LEAST_STRAIN), {"norm": matplotlib.colors.LogNorm(LEAST_STRAIN, largest)}
    points = np.vstack([b.x for b in (body, around) if b is not None])
    lower, upper = view(points, 2.5 * body.dx)
    beyond = np.count_nonzero(((body.x < lower) | (body.x > upper)).any(axis=1))
    canvas = Canvas(lower, upper, body.dx)
    place = {"extent": canvas.extent, "origin": "lower", "interpolation": "nearest"}
    outline = None if around is None else canvas.cover(around.x, around.size)
    if outline is not None:
        shade = np.zeros((*canvas.shape, 4))
        shade[outline > SURFACE] = matplotlib.colors.to_rgba(AROUND[phase])
        axes.imshow(shade, **place)
    filled, own = canvas.fill(body.x, values / factor, body.size)
    drawn = axes.imshow(filled, cmap="RdBu_r" if signed else "viridis", **limits, **place)
    axes.contour(own, levels=[SURFACE], colors="0.35", linewidths=0.5, extent=canvas.extent)  # pale colours need a border
    about = ""
    if outline is not None and phase == "solid":
        axes.contour(outline, levels=[SURFACE], colors=WATER_LINE, linewidths=0.9, extent=canvas.extent)
        about = "; blue: outline of the water"
    if beyond:
        about += f"; {beyond} particle{'s' if beyond > 1 else ''} beyond"
    axes.set(xlim=(lower[0], upper[0]), ylim=(lower[1], upper[1]), aspect="equal", xlabel="x [m]",
             ylabel="z [m], middle slice" if body.three else "y [m]")
    axes.set_title(f"{phase}, t = {frames.times[step]:.4g} s{about}", fontsize=9)
    bar = axes.figure.colorbar(drawn, cax=make_axes_locatable(axes).append_axes("right", size=0.12, pad=0.08))
    bar.set_label(f"{label.replace('_', ' ')} [{sign}{unit}]")


def draw_field(frames, phase, name, step, target):
    """A picture of one field, as large as its body's shape asks for."""
    if len(frames.positions(step)) == 0:
        print(f"{phase}: no particles at t = {frames.times[step]:g} s")
        return
    figure, axes = plt.subplots(layout="tight")
    paint(axes, frames, phase, name, step)
    size = np.ptp(axes.get_xlim()), np.ptp(axes.get_ylim())
    width = min(7.0, max(2.0, 5.0 * size[0] / size[1]))
    figure.set_size_inches(width + 1.2, width * size[1] / size[0] + 0.9)
    figure.savefig(target, bbox_inches="tight")
    plt.close(figure)
    print(target)


def read_gauges(run):
    path = run / "gauges.csv"
    sources = [path] if path.exists() else sorted(run.glob("gauges.*.csv"))
    series = {}
    for source in sources:
        with open(source, newline="") as stream:
            for row in csv.DictReader(stream):
                if row["unit"] is None:
                    continue  # half a line of a run that was killed
                entry = series.setdefault(row["gauge"], {"unit": row["unit"], "t": [], "v": []})
                entry["t"].append(float(row["time_s"]))
                entry["v"].append(float(row["value"]))
    return series


def reference_of(run, gauge):
    """Time and value from cases/NAME/reference/<gauge>.csv, when the case has one."""
    text = (run / "run.toml").read_text() if (run / "run.toml").exists() else ""
    found = re.search(r'^case_file = "(.*)"', text, re.M)
    if not found:
        return None
    path = pathlib.Path(found.group(1)).parent / "reference" / f"{gauge}.csv"
    if not path.exists():
        return None
    rows = []
    for line in path.read_text().splitlines():
        try:
            rows.append([float(cell) for cell in line.split(",")[:2]])
        except ValueError:
            continue  # comments and the heading
    return np.array(rows) if rows and len(rows[0]) == 2 else None


def draw_gauges(run, names, title, series, target, marks=()):
    """Gauges against time. marks: what they should read, [gauge, time, value, and by how much either may be off]."""
    figure, axes = plt.subplots(figsize=(5.5, 3.4))
    legend = len(names) > 1
    for i, name in enumerate(names):
        entry, colour = series[name], f"C{i % 10}"
        axes.plot(entry["t"], entry["v"], lw=1.4, color=colour, label=name)
        own = np.array([mark[1:] for mark in marks if mark[0] == name], dtype=float).reshape(-1, 4)
        reference = reference_of(run, name) if len(own) == 0 else own[:, :2]
        if reference is None:
            continue
        axes.plot(reference[:, 0], reference[:, 1], "o", ms=4, mfc="white", color=colour, zorder=3,
                  label=None if len(names) > 1 and i > 0 else "reference" if len(own) else f"{name}, reference")
        for direction, off in ("xerr", own[:, 2]), ("yerr", own[:, 3]):
            some = off > 0.0  # a bar of no length would still have its caps
            if some.any():
                axes.errorbar(own[some, 0], own[some, 1], **{direction: off[some]}, fmt="none", ecolor=colour, elinewidth=0.9, capsize=2.5)
        legend = True
    axes.set_xlabel("time [s]")
    axes.set_ylabel(f"{title.replace('_', ' ')} [{series[names[0]]['unit']}]")
    axes.margins(x=0.02)
    axes.grid(alpha=0.3, lw=0.5)
    if legend:
        axes.legend(fontsize=7, frameon=False, ncols=2 if len(names) > 6 else 1)
    figure.savefig(target, bbox_inches="tight")
    plt.close(figure)
    print(target)


def main():
    parser = argparse.ArgumentParser(prog="poretwin plot", description=__doc__.splitlines()[0])
    parser.add_argument("run", type=pathlib.Path, help="folder of a run")
    parser.add_argument("--field", help="field, or a component of one: pore_pressure, velocity_x, effective_stress_yy")
    parser.add_argument("--time", type=float, help="the frame nearest to this time [s] (default: the last)")
    parser.add_argument("--phase", choices=["fluid", "solid"], help="default: every phase that has the field")
    parser.add_argument("--gauge", nargs="+", help="only these gauges, in one picture each")
    parser.add_argument("--out", type=pathlib.Path, help="folder of the pictures (default: RUN/pictures)")
    options = parser.parse_args()
    if not options.run.is_dir():
        raise SystemExit(f"{options.run}: expected the folder of a run")
    out = options.out or options.run / "pictures"
    out.mkdir(parents=True, exist_ok=True)
    plt.rcParams.update(STYLE)

    only_gauges = options.gauge and not options.field
    phases = [options.phase] if options.phase else ["fluid", "solid"]
    drawn = False
    for phase in [] if only_gauges else phases:
        path = options.run / f"{phase}.vtkhdf"
        if not path.exists():
            continue
        frames = Frames(path)
        if frames.n_steps == 0:
            continue
        fields = frames.fields()
        name = options.field or next((f for f in MAIN_FIELDS[phase] if f in fields), fields[0] if fields else None)
        if name is None or (options.field and not options.phase and name not in fields and name.rpartition("_")[0] not in fields):
            continue
        step = frames.n_steps - 1 if options.time is None else int(np.argmin(np.abs(frames.times - options.time)))
        suffix = "" if options.time is None else f"_t{frames.times[step]:g}"
        draw_field(frames, phase, name, step, out / f"{phase}_{name}{suffix}.png")
        drawn = True
    if options.field and not drawn:
        raise SystemExit(f"no phase of {options.run} has a field '{options.field}'")

    if options.gauge or not options.field:
        series = read_gauges(options.run)
        groups = {}
        for name in series:
            groups.setdefault(name.partition("[")[0], []).append(name)
        for title in options.gauge or groups:
            if title not in groups and title not in series:
                raise SystemExit(f"no gauge '{title}'; there are: {', '.join(series)}")
            draw_gauges(options.run, groups.get(title, [title]), title, series, out / f"gauge_{title.replace('/', '_')}.png")
    return 0


if __name__ == "__main__":
    sys.exit(main())
