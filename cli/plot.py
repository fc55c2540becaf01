#!/usr/bin/python3
"""Draws a run: fields of either phase at given times, gauges against time with their references, animations.

Called by `poretwin plot RUN ...`; needs the Debian packages python3-h5py, python3-numpy, python3-matplotlib.
"""
import argparse
import csv
import pathlib
import re
import tomllib

import h5py
import matplotlib.colors
import numpy as np
import style
from cells import SURFACE, Canvas, spacing
from mpl_toolkits.axes_grid1 import make_axes_locatable
from stop import NO_FILE, WRONG_COMMAND, Stop, exit_with
from style import plt

# The most informative fields of each phase, the best first.
MAIN_FIELDS = {
    "fluid": ["pore_pressure", "velocity"],
    "solid": ["effective_stress", "accumulated_plastic_strain", "displacement"],
}
AT_REST = 1e-6  # s: times above zero and below this one are not shown (Shown.title)
LEAST_STRAIN = 1e-3  # smallest plastic strain on the colour bar, whose scale is logarithmic
STRAINS = ("accumulated_plastic_strain", "failing_strain")
FACTOR = "local_factor_of_safety"
FACTORS = (1.0, 3.0)  # range of its colours; larger factors are of no interest
YIELDS = 1.01  # soil with a local factor up to this one counts as yielding: rounding scatters the factor about 1
TENSOR = ["xx", "yy", "zz", "xy", "yz", "xz"]


class Frames:
    """The frames of one phase in a VTKHDF file. The rows of a step are found through the file's offsets, as other readers do."""

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

    def columns(self, name):
        shape = self.root["PointData"][name].shape
        return shape[1] if len(shape) > 1 else 1

    def nearest(self, time):
        """Index of the step nearest to a time."""
        return int(np.argmin(np.abs(self.times - time)))

    def unit(self, name):
        unit = self.root["PointData"][name].attrs.get("unit", "")
        return unit.decode() if isinstance(unit, bytes) else str(unit)


def component_of(frames, name, step):
    """Splits "velocity_x" into field and component. A name without a component means the length ("| |") of a vector, or the vertical component
    of a tensor."""
    fields = frames.fields()
    if name in fields:
        columns = frames.columns(name)
        return name, "" if columns == 1 else "| |" if columns == 3 else ("zz" if is_3d(frames, step) else "yy")
    stem, _, component = name.rpartition("_")
    if stem in fields and component in (TENSOR if frames.columns(stem) == 6 else ["x", "y", "z"] if frames.columns(stem) == 3 else []):
        return stem, component
    raise Stop(WRONG_COMMAND, f"no field '{name}'; there are: {', '.join(fields)}")


def scalar(frames, name, step):
    """Values [n] of a field or of one of its components."""
    field, component = component_of(frames, name, step)
    values = frames.values(field, step)
    if component == "| |":
        return np.linalg.norm(values, axis=1)
    return values[:, (TENSOR if values.shape[1] == 6 else "xyz").index(component)] if component else values


def is_3d(frames, step):
    x = frames.positions(step)
    return len(x) > 0 and np.ptp(x[:, 2]) > 0


class Body:
    """The particles of one frame in the plane of the picture; in 3D, the particles of the middle slice, seen from the front."""

    def __init__(self, frames, step, values=None):
        x = frames.positions(step)
        self.three = is_3d(frames, step)
        dimensions = 3 if self.three else 2
        if "volume" in frames.fields():
            size = frames.values("volume", step) ** (1.0 / dimensions)
        else:  # the frames are from a solver that does not write volumes
            size = np.full(len(x), spacing(x[:, :dimensions]))
        self.dx = float(np.median(size))
        keep = np.abs(x[:, 1] - np.median(x[:, 1])) <= 0.75 * self.dx if self.three else np.ones(len(x), dtype=bool)
        self.x, self.size = x[keep][:, [0, 2] if self.three else [0, 1]], size[keep]
        self.values = None if values is None else values[keep]


def other_body(frames, phase, step):
    """The other phase of the same run at the same time, or None."""
    other = "solid" if phase == "fluid" else "fluid"
    path = pathlib.Path(frames.file.filename).with_name(f"{other}.vtkhdf")
    if not path.exists():
        return None
    there = Frames(path)
    if there.n_steps == 0:
        return None
    nearest = there.nearest(frames.times[step])
    return Body(there, nearest) if len(there.positions(nearest)) > 0 else None


def scene_of(run):
    """Content of a run's case file, and the overrides of the run; empty where the file no longer exists."""
    try:
        about = tomllib.loads((run / "run.toml").read_text())
        return tomllib.loads(pathlib.Path(about["case_file"]).read_text()), about.get("overrides", [])
    except (OSError, KeyError, ValueError):
        return {}, []


def corners(shape):
    """The outline of a region of a 2D case [n, 2]; None for other shapes."""
    if shape.get("shape") == "polygon" and all(len(p) == 2 for p in shape.get("points", [])):
        return np.array(shape["points"], dtype=float)
    if shape.get("shape") == "box" and len(shape.get("min", [])) == 2:
        (x0, y0), (x1, y1) = shape["min"], shape["max"]
        return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]], dtype=float)
    if shape.get("shape") == "ball" and len(shape.get("centre", [])) == 2:
        angle = np.linspace(0.0, 2.0 * np.pi, 73)[:-1]
        return np.array(shape["centre"], dtype=float) + shape["radius"] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return None


def rigid_soil(run):
    """Outlines of the rigid soil of a 2D run, [[x, y], ...] for each region, from its case file."""
    scene, overrides = scene_of(run)
    if (run / "solid.vtkhdf").exists() or any(re.match(r"soil\..*(points|min|max|shape)", text) for text in overrides):
        return []
    try:
        outlines = [corners(soil) for soil in scene.get("soil", []) if soil["shape"] in ("polygon", "box")]
        return [outline for outline in outlines if outline is not None]
    except (KeyError, TypeError, ValueError):
        return []  # the case file has changed since the run


def view(points, margin):
    """Lower and upper corner of the section of the plane that is drawn. It contains all points except a few far away, such as spray."""
    low, high = np.quantile(points, 0.005, axis=0), np.quantile(points, 0.995, axis=0)
    far = 0.5 * (high - low).max()
    return np.maximum(points.min(axis=0), low - far) - margin, np.minimum(points.max(axis=0), high + far) + margin


def arrows(below, above):
    """The ends of a colour bar that are arrows, as matplotlib names them: those beyond which there are values."""
    return "both" if below and above else "min" if below else "max" if above else "neither"


class Shown:
    """One field of one phase at several steps, with one colour range and one section of the plane. `rare`: fraction of all values that may
    lie beyond either end of the colour range; otherwise one short extreme would leave no colours for the other frames."""

    def __init__(self, frames, phase, name, steps, most=1800, rare=0.0):
        self.frames, self.phase, self.name, self.most = frames, phase, name, most
        self.steps = [step for step in steps if len(frames.positions(step)) > 0]
        self.dx = None
        self.ground = rigid_soil(pathlib.Path(frames.file.filename).parent) if phase == "fluid" else []
        low, high, lower, upper, values, points = np.inf, -np.inf, np.inf, -np.inf, [], []
        for step in self.steps:
            body, around = self.bodies(step)
            finite = body.values[np.isfinite(body.values)]
            low, high = min(low, finite.min(initial=np.inf)), max(high, finite.max(initial=-np.inf))
            self.dx = self.dx or body.dx
            drawn = np.vstack([*(b.x for b in (body, around) if b is not None), *self.ground])
            corners = view(drawn, 2.5 * self.dx)
            lower, upper = np.minimum(lower, corners[0]), np.maximum(upper, corners[1])
            few = max(1, len(self.steps) * len(drawn) // 1000000)  # a million values suffice for the quantiles
            values.append(finite[::few])
            points.append(drawn[::few])
        self.extend = "neither"
        if rare > 0.0 and low < high and component_of(frames, name, self.steps[0])[0] not in STRAINS:
            ends = low, high
            low, high = np.quantile(np.concatenate(values), [rare, 1.0 - rare])
            lower, upper = view(np.vstack(points), 2.5 * self.dx)
            self.extend = arrows(ends[0] < low, ends[1] > high)
        self.lower, self.upper = lower, upper
        if self.steps:
            self.colours(*((low, high) if low <= high else (0.0, 0.0)))

    def bodies(self, step):
        return Body(self.frames, step, scalar(self.frames, self.name, step)), other_body(self.frames, self.phase, step)

    def colours(self, low, high):
        """Sets the norm, the colour map and the label of the colour bar."""
        field, component = component_of(self.frames, self.name, self.steps[0])
        unit, largest = self.frames.unit(field), max(abs(low), abs(high))
        self.factor, unit = style.prefix(largest, unit)
        # A diverging map is used only where both signs matter, not for a little noise around zero.
        signed = min(-low, high) > 0.05 * largest
        self.least, self.shows_yield = None, field == FACTOR
        if field in STRAINS and largest > LEAST_STRAIN:  # so that slip bands show beside grains that have rolled away
            self.least = min(LEAST_STRAIN, largest / 30.0)
            self.norm = matplotlib.colors.LogNorm(self.least, largest)
        elif field == "degree_of_saturation":
            self.norm = matplotlib.colors.Normalize(0.0, 1.0)
        elif field == FACTOR:
            self.norm = matplotlib.colors.Normalize(*FACTORS)
            # Without any value both ends are zero.
            self.extend = arrows(low < FACTORS[0] - (YIELDS - 1.0) and high > 0.0, high > FACTORS[1])
        else:
            if high - low <= 1e-9 * largest:  # constant field: a bar from zero
                low, high = min(low, 0.0), max(high, 0.0)
            low, high = (-largest, largest) if signed else (low, high)
            self.norm = matplotlib.colors.Normalize(low / self.factor, high / self.factor)
        self.map = style.SIGNED_MAP if signed else style.MAPS.get(field, style.MAP)
        self.label = style.label(self.phase, field, component) + style.unit(unit)

    def shape(self):
        """Width and height of the section [m]."""
        return self.upper - self.lower

    def paint(self, axes, step):
        """Draws the field with its surroundings: grey soil around the water, or pale blue water with its outline around the soil. Returns the
        artist for the colour bar."""
        for artist in [*axes.images, *axes.collections, *axes.patches]:  # removes the previous frame
            artist.remove()
        for corners in self.ground:
            axes.fill(corners[:, 0], corners[:, 1], color=style.AROUND["fluid"], zorder=0)
        body, around = self.bodies(step)
        canvas = Canvas(self.lower, self.upper, self.dx, self.most)
        place = {"extent": canvas.extent, "origin": "lower", "interpolation": "nearest"}
        outline = None if around is None else canvas.cover(around.x, around.size)
        if outline is not None:
            shade = np.zeros((*canvas.shape, 4))
            shade[outline > SURFACE] = matplotlib.colors.to_rgba(style.AROUND[self.phase])
            axes.imshow(shade, **place)
        filled, own = canvas.fill(body.x, body.values / self.factor, body.size)
        drawn = axes.imshow(filled if self.least is None else np.maximum(filled, self.least), cmap=self.map, norm=self.norm, **place)
        if self.shows_yield and (yields := canvas.smooth(filled <= YIELDS, body.size)).max() > 0.5:
            axes.contour(yields, levels=[0.5], colors="white", linewidths=1.1, extent=canvas.extent)
        if own.max() > SURFACE:
            axes.contour(own, levels=[SURFACE], colors="0.35", linewidths=0.5, extent=canvas.extent)  # shows the edge of pale colours
        if outline is not None and self.phase == "solid" and outline.max() > SURFACE:
            axes.contour(outline, levels=[SURFACE], colors=style.WATER_LINE, linewidths=0.9, extent=canvas.extent)
        axes.set(xlim=(self.lower[0], self.upper[0]), ylim=(self.lower[1], self.upper[1]), aspect="equal")
        axes.set_title(self.title(step, body, outline is not None))
        return drawn

    def title(self, step, body, wet):
        beyond = np.count_nonzero(((body.x < self.lower) | (body.x > self.upper)).any(axis=1))
        about = "; blue: outline of the water" if wet and self.phase == "solid" else ""
        if self.shows_yield:
            about += "; white line: around soil that yields"
        if beyond:
            about += f"; {beyond} particle{'s' if beyond > 1 else ''} beyond"
        time = self.frames.times[step]
        # The trials of `poretwin safety` end at 1e-9 s, after the search for equilibrium; that time has no meaning.
        return style.BODY[self.phase] + (f", t = {style.time(time, style.time_unit(self.frames.times[-1]))}" if not 0.0 < time < AT_REST else "") + about

    def axis_labels(self, axes, below=True, beside=True):
        three = is_3d(self.frames, self.steps[0])
        axes.set(xlabel="x [m]" if below else "", ylabel=("z [m], middle slice" if three else "y [m]") if beside else "")

    def bar(self, axes, drawn):
        """The colour bar, as high as the picture beside it."""
        found = axes.figure.colorbar(drawn, cax=make_axes_locatable(axes).append_axes("right", size=0.12, pad=0.08), extend=self.extend)
        found.set_label(self.label)
        return found


def paint(axes, frames, phase, name, step):
    """Draws one field of one phase at one time, with its colour bar."""
    shown = Shown(frames, phase, name, [step])
    drawn = shown.paint(axes, step)
    shown.axis_labels(axes)
    shown.bar(axes, drawn)


def panel_width(shape):
    """Width in inches of a picture of a section with this width and height [m]; wide sections fill the page."""
    return min(style.PAGE - 1.2, max(2.0, 5.0 * shape[0] / shape[1]))


def draw_field(frames, phase, name, steps, target):
    """Writes a figure of one field, in the proportions of the body. Several steps: one panel each, with one colour range, below each other or, where
    the body is narrow, side by side."""
    steps = [steps] if np.isscalar(steps) else list(steps)
    shown = Shown(frames, phase, name, steps)
    for step in steps:
        if step not in shown.steps:
            print(f"{phase}: no particles at t = {frames.times[step]:g} s")
    if not shown.steps:
        return
    shape = shown.shape()
    count, width = len(shown.steps), panel_width(shape)
    # Narrow bodies are placed side by side.
    columns = max(1, min(count, int((style.PAGE - 0.7) / (width + 0.5)))) if count > 1 else 1
    rows = -(-count // columns)
    figure, panels = plt.subplots(rows, columns, squeeze=False, layout="compressed",
                                  figsize=(columns * (width + 0.3) + 0.9, rows * (width * shape[1] / shape[0] + 0.3) + 0.6))
    for k, axes in enumerate(panels.flat):
        if k >= count:
            axes.set_axis_off()
            continue
        drawn = shown.paint(axes, shown.steps[k])
        shown.axis_labels(axes, below=k + columns >= count, beside=k % columns == 0)
        if k + columns < count:
            axes.tick_params(labelbottom=False)
        if k % columns:
            axes.tick_params(labelleft=False)
    if count == 1:
        shown.bar(panels[0, 0], drawn)
    else:
        figure.colorbar(drawn, ax=panels, label=shown.label, aspect=30, pad=0.02, extend=shown.extend)
    style.save(figure, target)
    print(target)


def read_gauges(run):
    path = run / "gauges.csv"
    sources = [path] if path.exists() else sorted(run.glob("gauges.*.csv"))
    series = {}
    for source in sources:
        with open(source, newline="") as stream:
            for row in csv.DictReader(stream):
                if row["unit"] is None:
                    continue  # the run was killed while it wrote this line
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


def declaration(run, title):
    """The case's declaration of a gauge, and the component that the title names ("x" in "soil_x"). Empty where the run has overrides for gauges."""
    scene, overrides = scene_of(run)
    if any(text.startswith("gauge.") for text in overrides):
        return {}, ""
    declared = {gauge.get("name"): gauge for gauge in scene.get("gauge", [])}
    stem, _, component = title.rpartition("_")
    return (declared[title], "") if title in declared else (declared.get(stem, {}), component)


def places(declared, names):
    """Labels that distinguish readings at several points: the coordinate in which they differ, else all coordinates."""
    points = np.array(declared.get("points", []), dtype=float)
    if declared.get("kind") != "point" or points.ndim != 2 or len(points) != len(names):
        return names
    differ = np.flatnonzero(np.ptp(points, axis=0) > 0.0)
    if len(differ) == 1:
        return [f"{'xyz'[differ[0]]} = {style.number(point[differ[0]])} m" for point in points]
    return [f"({', '.join(style.number(x) for x in point)}) m" for point in points]


def quantity_label(declared, component, title):
    """Label of the quantity that a gauge measures, as for a field; for other kinds of gauges the gauge's name."""
    if declared.get("kind") == "momentum":
        return f"momentum of the {style.BODY[declared['phase']]}" + (f", {component}" if component else "")
    if declared.get("kind") != "point":
        return title.replace("_", " ")
    field, _, component = declared["quantity"].rpartition("_")
    known = style.FLUID | style.SOLID
    return style.label(declared["phase"], field, component) if field in known else style.label(declared["phase"], declared["quantity"])


def draw_gauges(run, names, title, series, target, marks=()):
    """Draws gauges against time into a file."""
    style.save(gauge_figure(run, names, title, series, marks), target)
    print(target)


def gauge_figure(run, names, title, series, marks=()):
    """Figure of gauges against time. marks: points on which the curves should lie, [gauge, time, value, allowed error of the time, of the value]."""
    figure, axes = plt.subplots(figsize=(style.COLUMN, 0.62 * style.COLUMN), layout="constrained")
    colours = plt.rcParams["axes.prop_cycle"].by_key()["color"]
    declared, component = declaration(run, title)
    largest = max((abs(v) for name in names for v in series[name]["v"] if np.isfinite(v)), default=0.0)
    factor, unit = style.prefix(largest, series[names[0]]["unit"])
    unit_of_time, name_of_time = style.time_unit(max((entry["t"][-1] for name in names if (entry := series[name])["t"]), default=0.0))
    labelled = False
    for i, (name, place) in enumerate(zip(names, places(declared, names))):
        entry, colour = series[name], colours[i % len(colours)]
        axes.plot(np.array(entry["t"]) / unit_of_time, np.array(entry["v"]) / factor, color=colour, label=place if len(names) > 1 else "computed",
                  linestyle=["-", "--", ":"][i // len(colours) % 3])
        own = np.array([mark[1:] for mark in marks if mark[0] == name], dtype=float).reshape(-1, 4)
        reference = reference_of(run, name) if len(own) == 0 else own[:, :2]
        if reference is None:
            continue
        axes.plot(reference[:, 0] / unit_of_time, reference[:, 1] / factor, color=colour, **style.REFERENCE, label=None if labelled else "reference")
        labelled = True
        for direction, off in ("xerr", own[:, 2] / unit_of_time), ("yerr", own[:, 3] / factor):
            some = off > 0.0  # an error bar of zero length would still show its caps
            if some.any():
                axes.errorbar(own[some, 0] / unit_of_time, own[some, 1] / factor, **{direction: off[some]}, fmt="none", ecolor=colour, elinewidth=0.9, capsize=2.5)
    axes.set_xlabel(f"time [{name_of_time}]")
    axes.set_ylabel(quantity_label(declared, component, title) + style.unit(unit))
    axes.margins(x=0.02)
    axes.grid(True)
    if len(names) > 1:  # outside the axes: the curves leave no space for the legend
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    elif labelled:
        axes.legend()
    return figure


def requested_pictures(run, options):
    """Frames, phase and field of each requested picture."""
    found = []
    for phase in [options.phase] if options.phase else ["fluid", "solid"]:
        path = run / f"{phase}.vtkhdf"
        if not path.exists():
            continue
        frames = Frames(path)
        if frames.n_steps == 0:
            continue
        fields = frames.fields()
        name = options.field or next((f for f in MAIN_FIELDS[phase] if f in fields), fields[0] if fields else None)
        if name is None or (options.field and not options.phase and name not in fields and name.rpartition("_")[0] not in fields):
            continue
        found.append((frames, phase, name))
    return found


def nothing_to_draw(run, options):
    """Why there is no picture of a field, as a Stop."""
    phases = [phase for phase in ("fluid", "solid") if (run / f"{phase}.vtkhdf").exists()]
    if not phases:
        return Stop(NO_FILE, f"{run}: neither fluid.vtkhdf nor solid.vtkhdf is there")
    if options.phase and options.phase not in phases:
        return Stop(WRONG_COMMAND, f"{run}: {options.phase}.vtkhdf is not there; this run has: {', '.join(phases)}")
    empty = [phase for phase in phases if Frames(run / f"{phase}.vtkhdf").n_steps == 0]
    if len(empty) == len(phases) or options.phase in empty:
        return Stop(NO_FILE, f"{run}: no frame has been written yet")
    return Stop(WRONG_COMMAND, f"no phase of {run} has a field '{options.field}'")


def draw_run(options, out):
    """Draws fields and gauges of one run."""
    run = options.run
    pictures = [] if options.gauge and not options.field else requested_pictures(run, options)
    if not pictures and (options.field or options.phase or options.time):
        raise nothing_to_draw(run, options)
    for frames, phase, name in pictures:
        steps = sorted({frames.nearest(time) for time in options.time}) if options.time else [frames.n_steps - 1]
        suffix = "".join(f"_t{frames.times[step]:g}" for step in steps) if options.time else ""
        draw_field(frames, phase, name, steps, out / f"{phase}_{name}{suffix}.{options.format}")
    if options.gauge or not options.field:
        series = read_gauges(run)
        if not pictures and not series:
            raise nothing_to_draw(run, options)
        groups = {}
        for name in series:
            groups.setdefault(name.partition("[")[0], []).append(name)
        for title in options.gauge or groups:
            if title not in groups and title not in series:
                raise Stop(WRONG_COMMAND, f"no gauge '{title}'; there are: {', '.join(series)}")
            draw_gauges(run, groups.get(title, [title]), title, series, out / f"gauge_{title.replace('/', '_')}.{options.format}")


def main():
    parser = argparse.ArgumentParser(prog="poretwin plot", description=__doc__.splitlines()[0])
    parser.add_argument("run", type=pathlib.Path, help="folder of a run, or of what `poretwin verify CASE` has run")
    parser.add_argument("--field", help="field, or a component of one: pore_pressure, velocity_x, effective_stress_yy")
    parser.add_argument("--time", type=float, nargs="+", help="the frames nearest to these times [s], in one picture (default: the last)")
    parser.add_argument("--phase", choices=["fluid", "solid"], help="default: every phase that has the field")
    parser.add_argument("--gauge", nargs="+", help="only these gauges, in one picture each")
    parser.add_argument("--format", choices=style.FORMATS, default="png", help="of the pictures (default png)")
    parser.add_argument("--animate", type=pathlib.Path, metavar="FILE", help="all frames, as FILE.gif or FILE.mp4")
    parser.add_argument("--out", type=pathlib.Path, help="folder of the pictures (default: RUN/pictures)")
    options = parser.parse_args()
    if not options.run.is_dir():
        raise Stop(NO_FILE, f"{options.run}: expected the folder of a run")
    style.use()
    if options.animate:
        import animate
        animate.draw(options)
        return 0
    out = options.out or options.run / "pictures"
    out.mkdir(parents=True, exist_ok=True)
    import figures
    if figures.is_verification(options.run):
        figures.draw_all(options.run, out, options.format)
    else:
        draw_run(options, out)
    return 0


if __name__ == "__main__":
    exit_with(main)
