"""Draws the figures that the verify.toml of a case declares ([[figure]]), from the runs that `poretwin verify CASE` has made. Used by
`poretwin plot FOLDER-OF-THE-RUNS` and by the report of `poretwin verify --report`.
"""
import pathlib
import sys
import tomllib

import matplotlib.colors
import numpy as np
import plot
import style
from cells import SURFACE, Canvas
from stop import NO_FILE, WRONG_COMMAND, Stop
from style import plt

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent / "view"))
import references  # noqa: E402  (reference values of gauges)


def read_toml(path):
    try:
        return tomllib.loads(path.read_text())
    except (OSError, ValueError) as problem:
        raise Stop(NO_FILE, f"{path}: {problem}") from None


def case_file(run):
    """Content of the case file of a run."""
    return read_toml(pathlib.Path(read_toml(run / "run.toml")["case_file"]))


def runs_below(folder):
    return [path for path in sorted(folder.iterdir()) if (path / "run.toml").is_file()]


def is_verification(folder):
    """Whether a folder contains runs, and is not itself the folder of a run."""
    return not (folder / "run.toml").exists() and not any(folder.glob("*.vtkhdf")) and bool(runs_below(folder))


def case_of(folder):
    """The folder of the case whose runs are below this folder."""
    cases = {pathlib.Path(read_toml(run / "run.toml").get("case_file", "")).parent for run in runs_below(folder)}
    cases = [case for case in cases if (case / "verify.toml").is_file()]
    if len(cases) != 1:
        raise Stop(NO_FILE, f"{folder}: expected a run, or the runs of one case with a verify.toml; found {len(cases)} such cases")
    return cases[0]


class Missing(Exception):
    """Raised where results that a figure needs are missing: the run was not made, or ended early."""


class Figures:
    """All figures of a case. `runs`: the folder of each run, by name."""

    def __init__(self, case, runs):
        self.case, self.runs, self.verify = case, runs, read_toml(case / "verify.toml")

    def declared(self):
        return self.verify.get("figure", [])

    def run_of(self, f):
        return self.folder((f.get("runs") or [self.verify["run"][0]["name"]])[0])

    def folder(self, name):
        if name not in self.runs:
            raise Missing(f"there is no run '{name}'")
        return self.runs[name]

    def frames(self, folder, phase):
        path = folder / f"{phase}.vtkhdf"
        if not path.exists():
            raise Missing(f"{path} is not there")
        frames = plot.Frames(path)
        if frames.n_steps == 0:
            raise Missing(f"{path} has no frame")
        return frames

    def points(self, f, time, last):
        """Additional points to draw, as rows [x, y]: those given for this time; points without a time only in the last picture."""
        if "points" in f:
            return np.array(f["points"], dtype=float) if last else None
        if "reference_csv" not in f:
            return None
        path = self.case / f["reference_csv"]
        lines = [line for line in path.read_text().splitlines() if line and not line.startswith("#")]
        heading = [word.strip() for word in lines[0].split(",")]
        rows = np.array([[float(cell) for cell in line.split(",")] for line in lines[1:]])
        if not {"x_m", "y_m"} <= set(heading):
            raise Stop(WRONG_COMMAND, f"{path}: expected columns x_m and y_m, found {', '.join(heading)}")
        if "t_s" in heading:
            rows = rows[np.abs(rows[:, heading.index("t_s")] - time) <= 1e-3 * time]
        elif not last:
            return None
        return rows[:, [heading.index("x_m"), heading.index("y_m")]] if len(rows) else None

    def draw(self, f, target):
        """Draws one figure. Raises Missing where results that it needs are missing."""
        figure = getattr(self, f["kind"])(f)
        if f.get("title"):
            figure.suptitle(f["title"], fontsize=9)
        return style.save(figure, target)

    def fields(self, f):
        folder = self.run_of(f)
        columns = []
        for text in f["fields"]:
            phase, _, name = text.rpartition(".")
            for one in [phase] if phase else ["fluid", "solid"]:
                if not (folder / f"{one}.vtkhdf").exists():
                    continue
                frames = self.frames(folder, one)
                if name in frames.fields() or name.rpartition("_")[0] in frames.fields():
                    steps = [frames.nearest(time) for time in f["times"]] if "times" in f else [frames.n_steps - 1]
                    columns.append((plot.Shown(frames, one, name, steps), steps))
                    break
            else:
                raise Missing(f"{folder} has no field '{text}'")
        if not all(shown.steps for shown, _ in columns):
            raise Missing(f"{folder} has no particles at these times")
        rows = len(columns[0][1])
        width = min(plot.panel_width(columns[0][0].shape()), (style.PAGE - 0.6) / len(columns))
        height = width * max(shown.shape()[1] / shown.shape()[0] for shown, _ in columns)
        figure, panels = plt.subplots(rows, len(columns), squeeze=False, layout="compressed",
                                      figsize=(len(columns) * width + 0.6, rows * (height + 0.32) + 1.0))
        for k, (shown, steps) in enumerate(columns):
            for row, step in enumerate(steps):
                axes = panels[row, k]
                if step in shown.steps:
                    drawn = shown.paint(axes, step)
                time = shown.frames.times[step]
                axes.set_title(f"t = {style.number(time)} s")
                shown.axis_labels(axes, below=row == rows - 1, beside=k == 0)
                axes.tick_params(labelbottom=row == rows - 1, labelleft=k == 0)
                points = self.points(f, time, row == rows - 1)
                if points is not None:
                    axes.plot(points[:, 0], points[:, 1], color="black", mew=0.7, **style.REFERENCE)
            figure.colorbar(drawn, ax=panels[:, k], location="bottom", label=shown.label, aspect=30, pad=0.02, shrink=0.9)
        return figure

    def outlines(self, f):
        names = f.get("runs") or [self.verify["run"][0]["name"]]
        lines = []  # for each outline of the water: label, time, body
        for k, name in enumerate(names):
            frames = self.frames(self.folder(name), "fluid")
            for time in f["times"] if len(names) == 1 and "times" in f else [frames.times[-1]]:
                step = frames.nearest(time)
                text = f.get("labels", names)[k] if len(names) > 1 else f"{style.number(frames.times[step])} s"
                if len(frames.positions(step)) > 0:
                    lines.append((text, frames.times[step], plot.Body(frames, step)))
        if not lines:
            raise Missing("there is no water at these times")
        ground, pieces = plot.other_body(frames, "fluid", step), plot.rigid_soil(self.folder(names[0]))
        shown = [body.x for _, _, body in lines] + ([] if ground is None else [ground.x]) + pieces
        lower, upper = plot.view(np.vstack(shown), 2.5 * lines[0][2].dx)
        size = upper - lower
        figure, axes = plt.subplots(layout="compressed", figsize=(style.PAGE, (style.PAGE - 0.7) * size[1] / size[0] + 1.1))
        canvas = Canvas(lower, upper, lines[0][2].dx)
        for corners in pieces:
            axes.fill(corners[:, 0], corners[:, 1], color=style.AROUND["fluid"], zorder=0)
        if ground is not None:
            shade = np.zeros((*canvas.shape, 4))
            shade[canvas.cover(ground.x, ground.size) > SURFACE] = matplotlib.colors.to_rgba(style.AROUND["fluid"])
            axes.imshow(shade, extent=canvas.extent, origin="lower", interpolation="nearest")
        colours = plt.get_cmap(style.MAP)(np.linspace(0.0, 0.85, len(lines)))
        for k, ((text, time, body), colour) in enumerate(zip(lines, colours)):
            cover = canvas.cover(body.x, body.size)
            axes.contour(cover, levels=[SURFACE], colors=[colour], linewidths=1.2, extent=canvas.extent)
            axes.plot([], [], color=colour, lw=1.2, label=text)
            points = self.points(f, time, k == len(lines) - 1)
            if points is not None:
                axes.plot(points[:, 0], points[:, 1], color=colour if k + 1 < len(lines) else "black", **style.REFERENCE)
        if "points" in f or "reference_csv" in f:
            axes.plot([], [], color="black", label="reference", **style.REFERENCE)
        axes.set(xlim=(lower[0], upper[0]), ylim=(lower[1], upper[1]), aspect="equal", xlabel="x [m]", ylabel="y [m]")
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2 * size[0] / size[1] / 3.5), ncols=len(lines) + 1, columnspacing=1.2)
        return figure

    def marks(self, folder, series):
        record = read_toml(folder / "run.toml")
        return references.references(record, [self.case.resolve()], list(series))

    def profile(self, f):
        folder = self.run_of(f)
        series = plot.read_gauges(folder)
        declared = {gauge["name"]: gauge for gauge in case_file(folder).get("gauge", [])}
        right = {mark["gauge"]: mark["value"] for mark in self.marks(folder, series)}
        figure, axes = plt.subplots(figsize=(style.COLUMN, 0.8 * style.COLUMN), layout="constrained")
        colours = plt.rcParams["axes.prop_cycle"].by_key()["color"]
        scale = f.get("scale", 1.0)
        for k, name in enumerate(f["gauges"]):
            if name not in declared or f"{name}[0]" not in series:
                raise Missing(f"{folder} has no gauge '{name}' at several points")
            places = np.array(declared[name]["points"], dtype=float)
            along = int(np.argmax(np.ptp(places, axis=0)))
            names = [f"{name}[{i}]" for i in range(len(places))]
            values = scale * np.array([series[one]["v"][-1] for one in names])
            exact = scale * np.array([right.get(one, np.nan) for one in names])
            colour = colours[k % len(colours)]
            # Where the points of a gauge lie above each other, their height is the vertical axis.
            lines = [(exact, {"lw": 1.0}), (values, style.REFERENCE | {"label": f.get("labels", f["gauges"])[k]})]
            for numbers, how in lines:
                axes.plot(*((numbers, places[:, along]) if along else (places[:, along], numbers)), color=colour, **how)
        axes.plot([], [], color="0.4", lw=1.0, label="reference")
        label, place = f.get("label", ""), f"{'xyz'[along]} [m]"
        axes.set(xlabel=label if along else place, ylabel=place if along else label)
        axes.grid(True)
        axes.legend()
        return figure

    def history(self, f):
        folder = self.run_of(f)
        series = plot.read_gauges(folder)
        marks = self.marks(folder, series)
        figure, axes = plt.subplots(figsize=(style.COLUMN, 0.62 * style.COLUMN), layout="constrained")
        colours = plt.rcParams["axes.prop_cycle"].by_key()["color"]
        scale, marked = f.get("scale", 1.0), False
        for k, name in enumerate(f["gauges"]):
            if name not in series:
                raise Missing(f"{folder} has no gauge '{name}'")
            time, colour = series[name]["t"], colours[k % len(colours)]
            axes.plot(time, scale * np.array(series[name]["v"]), lw=1.0, color=colour, label=f.get("labels", f["gauges"])[k])
            own = [mark for mark in marks if mark["gauge"] == name]
            if own:
                axes.plot([time[-1] if mark["time"] is None else mark["time"] for mark in own], [scale * mark["value"] for mark in own],
                          color=colour, clip_on=False, ms=6, **style.REFERENCE)
            marked = marked or bool(own)
        if marked:
            axes.plot([], [], color="0.4", label="reference", ms=6, **style.REFERENCE)
        if "drive" in f:
            value = case_file(folder)
            for word in f["drive"].split("."):
                value = value[int(word)] if isinstance(value, list) else value[word]
            knots = np.array(value, dtype=float)
            beside = axes.twinx()
            beside.plot(knots[:, 0], f.get("drive_scale", 1.0) * knots[:, 1], color="0.5", lw=1.0, ls="--")
            beside.set(ylabel=f.get("drive_label", f["drive"]), ylim=(0.0, None))
            axes.plot([], [], color="0.5", lw=1.0, ls="--", label=f.get("drive_label", f["drive"]).partition(" [")[0])
        axes.set(xlabel="time [s]", ylabel=f.get("label", ""))
        axes.margins(x=0.02)
        axes.grid(True)
        axes.legend()
        return figure

    def draw_all(self, out, form, stem=""):
        """Draws the figures whose runs exist. Yields their paths."""
        for f in self.declared():
            try:
                yield self.draw(f, out / f"{stem}{f['name']}.{form}")
            except Missing as missing:
                print(f"{f['name']}: not drawn: {missing}")


def draw_all(folder, out, form):
    """Draws the figures of one case, for `poretwin plot`."""
    case = case_of(folder)
    all_of_them = Figures(case, {run.name: run for run in runs_below(folder)})
    if not all_of_them.declared():
        raise Stop(WRONG_COMMAND, f"{folder}: {case / 'verify.toml'} declares no [[figure]]; name one of the runs: "
                   f"{', '.join(run.name for run in runs_below(folder))}")
    drawn = False
    for path in all_of_them.draw_all(out, form):
        drawn = True
        print(path)
    if not drawn:
        raise Stop(NO_FILE, f"{folder}: none of the figures of {case / 'verify.toml'} could be drawn")
