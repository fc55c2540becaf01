#!/usr/bin/python3
"""Writes an engineer's report of a run on one page: cross-section, prescribed heads and other drives, state at the end, gauges against time,
factor of safety, balances of water and grains, warnings, and the origin of the data. All pictures are embedded in the page.

Called by `poretwin report RUN`; needs the Debian packages python3-h5py, python3-numpy, python3-matplotlib; for a PDF the program chromium.
"""
import argparse
import base64
import csv
import html
import io
import json
import pathlib
import re
import shutil
import subprocess
import tempfile
import tomllib

import matplotlib.path
import matplotlib.tri
import numpy as np
import plot
import style
from stop import NO_FILE, WRONG_COMMAND, Stop, exit_with
from style import plt

# Fields of the state at the end, for each phase.
FIELDS = {"fluid": ["pore_pressure", "degree_of_saturation"], "solid": ["effective_stress", "accumulated_plastic_strain", plot.FACTOR, "displacement"]}
SOILS = ["#e2d6c2", "#cbbfa9", "#d9cfe0", "#c9d8c5", "#e8cfc4", "#d5d5d5", "#efe3b8", "#c3cfd6"]
# Properties of a soil: key, heading, unit, factor.
PROPERTIES = [("porosity", "n", "", 1), ("hydraulic_conductivity", "k", "m/s", 1), ("youngs_modulus", "E", "MPa", 1e-6), ("poissons_ratio", "ν", "", 1),
              ("cohesion", "c", "kPa", 1e-3), ("friction_angle", "φ", "°", 1), ("dilation_angle", "ψ", "°", 1),
              ("undrained_shear_strength", "s_u", "kPa", 1e-3), ("grain_density", "ρ_s", "kg/m³", 1)]
# Parameters that only one material has: key, heading, unit, factor.
OF_MODEL = {
    "modified_cam_clay": [("compression_slope", "λ", "", 1), ("swelling_slope", "κ", "", 1), ("critical_state_slope", "M", "", 1),
                          ("overconsolidation_ratio", "OCR", "", 1), ("preconsolidation_pressure", "p_c", "kPa", 1e-3)],
    "mu_i": [("static_friction", "μ_s", "", 1), ("limiting_friction", "μ_2", "", 1), ("inertial_number", "I_0", "", 1), ("viscous_number", "J_0", "", 1),
             ("grain_diameter", "d", "mm", 1e3), ("dilatancy", "K_ψ", "", 1), ("critical_solid_fraction", "φ_c", "", 1), ("inertial_loosening", "b", "", 1)],
}
# The default of this key, 0, is no pressure: it means that the pressure follows from another key.
LEFT_OPEN = {"preconsolidation_pressure"}
PAGE = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width"><title>{title}</title><style>
body {{ font: 15px/1.5 system-ui, sans-serif; color: #222; background: #fff; max-width: 60rem; margin: 2rem auto; padding: 0 1rem }}
h1 {{ font-size: 1.6rem; margin-bottom: .2rem }} h2 {{ font-size: 1.15rem; margin-top: 2rem; border-bottom: 1px solid #ccc }}
p.about {{ color: #555; margin-top: 0 }} img {{ max-width: 100%; height: auto; display: block; margin: .6rem auto }}
table {{ border-collapse: collapse; font-size: .9rem; margin: .6rem 0 }} th, td {{ text-align: left; padding: .15rem .9rem .15rem 0; border-bottom: 1px solid #e5e5e5; vertical-align: top }}
td.number {{ text-align: right; font-variant-numeric: tabular-nums }} .doubt {{ color: #a00; font-weight: 600 }} .wide {{ overflow-x: auto }}
figure {{ margin: .5rem 0; break-inside: avoid }} .row {{ display: flex; flex-wrap: wrap; justify-content: center; gap: 0 1rem }} .row figure {{ flex: 0 1 auto }} .half figure {{ flex: 0 1 28rem }} figcaption {{ font-size: .85rem; color: #555; text-align: center }} h2, tr {{ break-inside: avoid; break-after: avoid }}
</style></head><body>
{body}
</body></html>
"""


class Run:
    """The content of a run's folder and of its case file."""

    def __init__(self, folder):
        self.folder = folder
        try:
            self.about = tomllib.loads((folder / "run.toml").read_text())
        except (OSError, ValueError):
            raise Stop(NO_FILE, f"{folder}: expected the folder of a run that has ended: run.toml is missing or cannot be read")
        self.summaries = [json.loads(path.read_text()) for path in sorted(folder.glob("*.summary.json"))]
        self.missing = ""  # says why the case cannot be read
        self.case = self.read_case()
        self.gauges = plot.read_gauges(folder)
        self.frames = {}
        for phase in ("fluid", "solid"):
            if (folder / f"{phase}.vtkhdf").exists():
                frames = plot.Frames(folder / f"{phase}.vtkhdf")
                if frames.n_steps > 0:
                    self.frames[phase] = frames
        ends = [frames.times[-1] for frames in self.frames.values()] + [s["t"][-1] for s in self.gauges.values() if s["t"]]
        self.end = float(max(ends, default=0.0))
        self.unit = style.time_unit(self.end)

    def read_case(self):
        """The case with the run's overrides; empty where its file is missing or has changed."""
        path = pathlib.Path(self.about.get("case_file", ""))
        try:
            text = path.read_bytes()
        except OSError:
            self.missing = f"The case file {path} is not there any more: section, soils and drives are left out."
            return {}
        if f"{fnv1a(text):016x}" != self.about.get("identity", {}).get("case file"):
            self.missing = f"The case file {path} has changed since the run: section, soils and drives are left out."
            return {}
        case = tomllib.loads(text.decode())
        for assignment in self.about.get("overrides", []):
            key, _, value = assignment.partition("=")
            put(case, key.split("."), value_of(value))
        return case

    def of_kind(self, kind):
        """Names of the gauges of one kind."""
        return [g.get("name", "") for g in self.case.get("gauge", []) if g.get("kind") == kind]


def fnv1a(data):
    """The hash of the case file in run.toml: FNV-1a, 64 bits."""
    value = 14695981039346656037
    for byte in data:
        value = (value ^ byte) * 1099511628211 % 2**64
    return value


def value_of(text):
    try:
        return tomllib.loads(f"x = {text}")["x"]
    except ValueError:
        return text


def put(tree, keys, value):
    """Sets tree["a"][0]["b"] for the keys a, 0, b."""
    for here, following in zip(keys, keys[1:]):
        if isinstance(tree, list):
            while len(tree) <= int(here):
                tree.append({})
            tree = tree[int(here)]
        else:
            tree = tree.setdefault(here, [] if following.isdigit() else {})
    if isinstance(tree, list):
        tree[int(keys[-1])] = value
    else:
        tree[keys[-1]] = value


def closed(outline):
    return matplotlib.path.Path(np.vstack([outline, outline[:1]]))


def place_of_name(outline, others):
    """The point at which a soil's name is written: inside the soil's outline, outside all other outlines, as far from the edges as possible."""
    low, high = outline.min(axis=0), outline.max(axis=0)
    grid = np.stack(np.meshgrid(np.linspace(low[0], high[0], 41), np.linspace(low[1], high[1], 41)), axis=-1).reshape(-1, 2)
    path = closed(outline)
    grid = grid[path.contains_points(grid)]
    for other in others:
        grid = grid[~closed(other).contains_points(grid)]
    if len(grid) == 0:
        return outline.mean(axis=0)
    a, b = outline, np.roll(outline, -1, axis=0)
    along = np.clip((((grid[:, None] - a) * (b - a)).sum(-1)) / np.maximum(((b - a) ** 2).sum(-1), 1e-300), 0.0, 1.0)
    return grid[np.sqrt((((a + along[..., None] * (b - a)) - grid[:, None]) ** 2).sum(-1)).min(axis=1).argmax()]


def series(value):
    """The value of a key, which is a number or a table over time, as an array of rows [t, value]."""
    return np.array(value, dtype=float).reshape(-1, 2) if isinstance(value, list) else np.array([[0.0, float(value)]])


def level(face, time):
    """Elevation [m] of the water's level behind a face at a time [s]; None where the case prescribes no head at this face."""
    if "head" not in face:
        return None
    knots = series(face["head"])
    return float(np.interp(time, knots[:, 0], knots[:, 1]))


class Page:
    """The page while it is built: pieces of HTML."""

    def __init__(self):
        self.pieces = []

    def add(self, text):
        self.pieces.append(text)

    def heading(self, text):
        self.add(f"<h2>{html.escape(text)}</h2>")

    def table(self, rows, head=None):
        """Appends rows of cells; numbers are aligned to the right."""
        def cell(value, kind):
            if isinstance(value, float):
                return f'<{kind} class="number">{style.number(value)}</{kind}>'
            return f"<{kind}>{html.escape(str(value))}</{kind}>"
        lines = [[cell(value, "th") for value in head]] if head else []
        lines += [[cell(value, "td") for value in row] for row in rows]
        self.add('<div class="wide"><table>' + "".join("<tr>" + "".join(line) + "</tr>" for line in lines) + "</table></div>")

    def figure(self, figure, caption, kind="svg"):
        stream = io.BytesIO()
        figure.savefig(stream, format=kind, bbox_inches="tight", **({"metadata": {"Date": None}} if kind == "svg" else {"dpi": 160}))
        plt.close(figure)
        data = base64.b64encode(stream.getvalue()).decode()
        media = "image/svg+xml" if kind == "svg" else "image/png"
        said = html.escape(caption)
        self.add(f'<figure><img alt="{said}" src="data:{media};base64,{data}"><figcaption>{said}</figcaption></figure>')


def outline_soils(axes, run, filled=False):
    """Draws the outlines of the case's soils, with names; returns the outlines."""
    drawn = []
    soils = [(soil, plot.corners(soil)) for soil in run.case.get("soil", [])]
    for k, (soil, outline) in enumerate(soils):
        if outline is None:
            continue
        colour = SOILS[k % len(SOILS)]
        axes.fill(*outline.T, facecolor=colour if filled else "none", edgecolor="0.3", linewidth=0.7, zorder=1 if filled else 4)
        if filled and soil.get("name"):
            later = [o for _, o in soils[k + 1:] if o is not None]
            axes.annotate(soil["name"], place_of_name(outline, later), ha="center", va="center", fontsize=8, zorder=5)
        drawn.append(outline)
    return drawn


def draw_section(page, run):
    """Draws soils, walls, initial water, faces and loads from the case."""
    if run.case.get("case", {}).get("dimension", 2) != 2:
        return
    figure, axes = plt.subplots(figsize=(style.PAGE, 0.5 * style.PAGE), layout="constrained")
    drawn = outline_soils(axes, run, filled=True)
    for region in run.case.get("fluid", {}).get("region", []):
        outline = plot.corners(region)
        if outline is not None:
            axes.fill(*outline.T, facecolor=style.AROUND["solid"], edgecolor=style.WATER_LINE, linewidth=0.6, zorder=0.5)
            drawn.append(outline)
    lines = [("wall", "0.1", 1.8, "walls"), ("water_face", style.WATER_LINE, 2.0, "faces of water"), ("rain", "#56b4e9", 2.0, "rain"),
             ("load", "#d55e00", 2.0, "loads")]
    for kind, colour, width, name in lines:
        labelled = False
        for piece in run.case.get(kind, []):
            points = np.array(piece.get("points", []), dtype=float)
            if points.ndim != 2 or points.shape[1] != 2:
                continue
            axes.plot(*points.T, color=colour, linewidth=width, zorder=3, solid_capstyle="butt", label=None if labelled else name)
            labelled = True
            drawn.append(points)
            at = level(piece, run.end) if kind == "water_face" else None
            if at is not None:
                low, high = points[:, 1].min(), points[:, 1].max()
                if low < at <= high + 1e-9 and high > low:
                    order = np.argsort(points[:, 1])
                    x = np.interp(at, points[order, 1], points[order, 0])
                    axes.annotate(f"▽ {style.number(at)} m", (x, at), ha="center",
                                  va="bottom", fontsize=8, color=style.WATER_LINE, zorder=5)
    if not drawn:
        plt.close(figure)
        return
    axes.set_aspect("equal")
    axes.margins(0.03)
    axes.set(xlabel="x [m]", ylabel="y [m]")
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=4)
    page.heading("Section")
    page.figure(figure, f"As drawn in the case; water levels at the end ({style.time(run.end, run.unit)}).")


def tabulate_soils(page, run, defaults):
    """Writes the soils' properties, then those of each material that has parameters of its own. defaults: value by material and key."""
    soils = [(soil, soil.get("model", run.case.get("solid", {}).get("model", ""))) for soil in run.case.get("soil", [])]

    def heading(symbol, unit):
        return f"{symbol} [{unit}]" if unit else symbol

    def scaled(value, factor):
        return float(value) * factor if isinstance(value, (int, float)) else ""
    rows = [[soil.get("name", ""), model] + [scaled(soil.get(key), factor) for key, _, _, factor in PROPERTIES] for soil, model in soils]
    if rows:
        page.heading("Soils")
        keep = [0, 1] + [2 + i for i in range(len(PROPERTIES)) if any(row[2 + i] != "" for row in rows)]
        head = ["soil", "model"] + [heading(symbol, unit) for _, symbol, unit, _ in PROPERTIES]
        page.table([[row[i] for i in keep] for row in rows], [head[i] for i in keep])
    for name, parameters in OF_MODEL.items():
        standard = {key: value for key, value in defaults.get(name, {}).items() if key not in LEFT_OPEN}
        rows = [[soil.get("name", ""), model] + [scaled(soil.get(key, standard.get(key)), factor) for key, _, _, factor in parameters]
                for soil, model in soils if model == name]
        if rows:
            page.table(rows, ["soil", "model"] + [heading(symbol, unit) for _, symbol, unit, _ in parameters])


def draw_drives(page, run):
    """Draws what the case prescribes over time: heads, pressures, discharges, rain."""
    curves = {}
    for kind, key, label in [("water_face", "head", "head [m]"), ("water_face", "pressure", "pressure [Pa]"), ("water_face", "discharge", "discharge [m²/s]"),
                             ("rain", "rate", "rain [m/s]")]:
        for k, piece in enumerate(run.case.get(kind, [])):
            if isinstance(piece.get(key), list) and len(series(piece[key])) > 1:
                curves.setdefault(label, []).append((piece.get("name") or f"{kind} {k}", series(piece[key])))
    if not curves:
        return
    page.heading("What drives it")
    figure, panels = plt.subplots(len(curves), 1, squeeze=False, sharex=True, figsize=(style.COLUMN, 1.1 + 1.3 * len(curves)), layout="constrained")
    for axes, (label, group) in zip(panels.flat, curves.items()):
        for name, knots in group:
            knots = knots[knots[:, 0] <= run.end] if (knots[:, 0] <= run.end).any() else knots[:1]
            last = [run.end, np.interp(run.end, knots[:, 0], knots[:, 1])]
            axes.plot(*np.vstack([knots, last]).T / np.array([[run.unit[0]], [1.0]]), label=name)
        axes.set_ylabel(label)
        axes.grid(True)
        axes.legend()
    panels.flat[-1].set_xlabel(f"time [{run.unit[1]}]")
    page.figure(figure, "Prescribed in the case.")


def draw_state(page, run):
    """Draws the main fields at the end, with the soils' outlines and the water table."""
    page.heading(f"The end: {style.time(run.end, run.unit)}")
    page.add('<div class="row">')
    for phase, frames in run.frames.items():
        for name in FIELDS[phase]:
            if name in frames.fields():
                draw_field(page, run, phase, name, frames.n_steps - 1, required=name == "pore_pressure")
    page.add("</div>")


def draw_field(page, run, phase, name, step, required=False, frames=None):
    """Draws one field with the soils' outlines and the water table; frames: those of the run, unless others are given. A constant field is drawn
    only if it is `required`."""
    frames = frames or run.frames[phase]
    shown = plot.Shown(frames, phase, name, [step])
    values = plot.scalar(frames, name, step)
    values = values[np.isfinite(values)]
    if not shown.steps or not (required or len(values) > 0 and np.ptp(values) > 0.0):
        return
    shape = shown.shape()
    width = min(plot.panel_width(shape), max(1.5, 3.5 * shape[0] / shape[1]))
    figure, axes = plt.subplots(figsize=(width + 1.2, width * shape[1] / shape[0] + 0.9), layout="constrained")
    drawn = shown.paint(axes, step)
    shown.axis_labels(axes)
    shown.bar(axes, drawn)
    if not plot.is_3d(frames, step):
        outline_soils(axes, run)
    caption = shown.label + (", of the stress at each point, not of a slip surface" if name == plot.FACTOR else "")
    if phase == "fluid" and "pressure_head" in frames.fields():  # water as a field: its water table is where the pressure is zero
        if draw_water_table(axes, plot.Body(frames, step, frames.values("pressure_head", step))):
            caption += "; dashed: water table"
    page.figure(figure, plain(caption), "png")


def draw_water_table(axes, body):
    """Draws the line on which the pressure head is zero, interpolated between points. Returns whether there is one."""
    if len(body.x) < 3 or not body.values.min() < 0.0 < body.values.max():
        return False
    net = matplotlib.tri.Triangulation(*body.x.T)
    around = body.x[net.triangles]
    longest = np.linalg.norm(around - np.roll(around, 1, axis=1), axis=2).max(axis=1)
    net.set_mask(longest > 2.0 * body.size[net.triangles].max(axis=1))  # triangles that span gaps in the soil
    axes.tricontour(net, body.values, levels=[0.0], colors="black", linewidths=1.1, linestyles="--")
    return True


def plain(text):
    """A label without its formula."""
    return " ".join(re.sub(r" ?\$[^$]*\$", "", text).split())


AFTER = "poretwin safety"  # name of the curve of factors of safety that were computed after the run


def safety_after(run):
    """Rows of RUN/safety/safety.csv, which `poretwin safety RUN` writes, ordered by time; empty where this file does not exist."""
    path = run.folder / "safety" / "safety.csv"
    return sorted(csv.DictReader(path.read_text().splitlines()), key=lambda row: float(row["time_s"])) if path.exists() else []


def draw_safety(page, run):
    """Draws the factor of safety against time: the values of gauges, and those that `poretwin safety RUN` has computed."""
    after = safety_after(run)
    series = {name: run.gauges[name] for name in run.of_kind("factor_of_safety") if name in run.gauges}
    errors = {name: run.gauges.get(f"{name}_error", {"v": np.zeros(len(series[name]["v"]))})["v"] for name in series}
    if after:
        series[AFTER] = {"t": [float(row["time_s"]) for row in after], "v": [float(row["factor"]) for row in after]}
        errors[AFTER] = [float(row["error"]) for row in after]
    if not series:
        return
    page.heading("Factor of safety")
    figure, axes = plt.subplots(figsize=(style.COLUMN, 0.55 * style.COLUMN), layout="constrained")
    rows = []
    for name, found in series.items():
        t, v, error = np.array(found["t"]), np.array(found["v"]), np.array(errors[name])
        finite = np.isfinite(v)  # the value is not finite where the soil does not fail at any factor
        drawn, = axes.plot(t[finite] / run.unit[0], v[finite], marker="o", label=name)
        axes.fill_between(t[finite] / run.unit[0], (v - np.where(finite, error, 0.0))[finite], (v + error)[finite], color=drawn.get_color(), alpha=0.2, linewidth=0)
        least = int(np.nanargmin(v))
        rows.append([name, float(v[least]), float(error[least]), style.time(t[least], run.unit), float(v[-1])])
    axes.axhline(1.0, color="0.4", linewidth=0.8, linestyle="--")
    axes.set(xlabel=f"time [{run.unit[1]}]", ylabel="factor of safety")
    axes.grid(True)
    if len(series) > 1:
        axes.legend()
    page.figure(figure, "By strength reduction, from the soil as it is at each time; band: the bracket.")
    page.table(rows, ["factor", "least", "±", "at", "at the end"])
    least = min(((v, t, name) for name, found in series.items() for t, v in zip(found["t"], found["v"]) if np.isfinite(v)), default=(0.0, 0.0, AFTER))
    if after:
        rows = [[style.time(float(row["time_s"]), run.unit), float(row["factor"]), float(row["error"]), row["soil"], row["face"],
                 f"{100.0 * float(row['share']):.0f} %" if row["share"] else ""] for row in after]
        page.table(rows, ["time", "factor", "±", "soil that fails", "nearest water face", "share of all motion"])
        frames = plot.Frames(run.folder / "safety" / "solid.vtkhdf")
        step = int(np.argmin(np.abs(frames.times - least[1]))) if least[2] == AFTER else int(np.nanargmin(series[AFTER]["v"]))
        page.add(f"<p>What fails at {style.time(frames.times[step], run.unit)}:</p>")
        draw_field(page, run, "solid", "failing_strain", step, frames=frames)
    elif "solid" in run.frames and "failing_strain" in run.frames["solid"].fields():
        times = run.frames["solid"].times
        later = np.flatnonzero(times >= least[1] * (1.0 - 1e-9))  # a frame shows what the gauge computed last before it
        page.add(f"<p>What fails where the factor is least (frame at {style.time(times[later[0] if len(later) else -1], run.unit)}):</p>")
        draw_field(page, run, "solid", "failing_strain", int(later[0]) if len(later) else len(times) - 1)


def draw_series(page, run):
    """Draws all other gauges against time."""
    apart = set(run.of_kind("factor_of_safety")) | {f"{n}_error" for n in run.of_kind("factor_of_safety")}
    groups = {}
    for name, found in run.gauges.items():
        if name not in apart and len(found["t"]) > 1 and np.isfinite(found["v"]).any():
            groups.setdefault(name.partition("[")[0], []).append(name)
    if not groups:
        return
    page.heading("Gauges")
    page.add('<div class="row half">')
    for title, names in groups.items():
        page.figure(plot.gauge_figure(run.folder, names, title, run.gauges), title.replace("_", " "))
    page.add("</div>")


def write_balance(page, run):
    """Writes the balances of water and grains at the end, from the gauges."""
    rows = []
    for name in run.of_kind("balance"):
        for part, meaning in [("in", "came in"), ("out", "left"), ("stored", "stored at the end"), ("error", "missing: in - out - increase of what is stored")]:
            if f"{name}_{part}" in run.gauges:
                found = run.gauges[f"{name}_{part}"]
                rows.append([f"{name}: {meaning}", float(found["v"][-1]), style.UNITS.get(found["unit"], found["unit"])])
    for name in run.of_kind("grain_volume"):
        if name in run.gauges:
            found = run.gauges[name]
            rows.append([f"{name}: change of the grains' volume", float(found["v"][-1] - found["v"][0]), style.UNITS.get(found["unit"], found["unit"])])
    if rows:
        page.heading("Balance")
        page.table(rows)


def write_warnings(page, run):
    page.heading("Warnings")
    rows = [("case", text, "", "") for text in run.about.get("warnings", [])]
    for summary in run.summaries:
        for w in summary.get("warnings", []):
            rows.append((summary["process"], w["what"], float(w["count"]), "the result may be wrong" if w.get("result_in_doubt") else ""))
    if run.missing:
        rows.append(("report", run.missing, "", ""))
    if rows:
        page.table(rows, ["from", "what", "times", ""])
    else:
        page.add("<p>None.</p>")


def write_origin(page, run):
    about = run.about
    page.heading("Where it comes from")
    rows = [("case file", about.get("case_file", "")), ("keys changed on the command line", ", ".join(about.get("overrides", [])) or "nothing"),
            ("hash of the case file (FNV-1a)", about.get("identity", {}).get("case file", "")), ("run", str(run.folder)),
            ("program", f"poretwin {about.get('version', '')}, {about.get('build', '')}"), ("machine", about.get("host", "")),
            ("started, ended", f"{about.get('started', '')}, {about.get('ended', '')}"), ("restarts after crashes", str(about.get("restarts", 0)))]
    page.table(rows)
    head = ["process", "particles or points", "windows", "CPU time [s]", "memory [MB]"]
    page.table([[s["process"], float(s["counters"].get("particles", s["counters"].get("points", 0))) or "", float(s["steps"].get("windows", 0)),
                 float(s["cpu_s"]), float(s["memory_bytes"]) / 1e6] for s in run.summaries], head)


def make(folder, material_defaults):
    """The report page of a run, as text."""
    run, page = Run(folder), Page()
    title = run.case.get("case", {}).get("title") or run.about.get("case", folder.name)
    page.add(f"<h1>{html.escape(title)}</h1>")
    exit_code = run.about.get("exit", 0)
    ended = {0: "ended as asked", 6: "ended, but its result is in doubt: see Warnings", 130: "interrupted"}.get(exit_code, f"failed: {run.about.get('reason', '')}")
    doubt = "" if exit_code == 0 else ' class="doubt"'
    page.add(f'<p class="about">{html.escape(str(run.about.get("case", "")))}, {style.time(run.end, run.unit)} computed in '
             f'{style.time(run.about.get("wall_s", 0.0))}; <span{doubt}>{html.escape(ended)}</span></p>')
    draw_section(page, run)
    tabulate_soils(page, run, material_defaults)
    draw_drives(page, run)
    if run.frames:
        draw_state(page, run)
    draw_safety(page, run)
    draw_series(page, run)
    write_balance(page, run)
    write_warnings(page, run)
    write_origin(page, run)
    return PAGE.format(title=html.escape(title), body="\n".join(page.pieces))


def print_pdf(text, target):
    browser = shutil.which("chromium") or shutil.which("google-chrome")
    if not browser:
        raise Stop(NO_FILE, f"{target}: a PDF needs the program chromium, of the package of that name; an HTML page does not")
    with tempfile.TemporaryDirectory() as folder:
        source = pathlib.Path(folder) / "report.html"
        source.write_text(text)
        done = subprocess.run([browser, "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={folder}/profile", "--no-pdf-header-footer",
                               f"--print-to-pdf={target.resolve()}", source.as_uri()], capture_output=True, text=True, check=False)
        if done.returncode != 0 or not target.exists():
            raise SystemExit(f"{target}: chromium made no PDF: {done.stderr.strip().splitlines()[-1:] or done.returncode}")


def main():
    parser = argparse.ArgumentParser(prog="poretwin report", description="An engineer's report of a run: one HTML page, or a PDF.")
    parser.add_argument("run", metavar="RUN", type=pathlib.Path, help="folder of a run")
    parser.add_argument("--out", type=pathlib.Path, metavar="FILE", help="FILE.html or FILE.pdf (default: RUN/report.html)")
    parser.add_argument("--material-defaults", type=json.loads, default={}, help=argparse.SUPPRESS)  # {material: {key: value}}, from the program
    options = parser.parse_args()
    target = options.out or options.run / "report.html"
    if target.suffix not in (".html", ".pdf"):
        raise Stop(WRONG_COMMAND, f"{target}: expected a name that ends in .html or .pdf")
    style.use(**{"savefig.bbox": "standard"})
    text = make(options.run, options.material_defaults)
    if target.suffix == ".pdf":
        print_pdf(text, target)
    else:
        target.write_text(text)
    print(target)
    return 0


if __name__ == "__main__":
    exit_with(main)
