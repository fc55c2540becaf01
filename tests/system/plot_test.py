#!/usr/bin/python3
"""`poretwin plot`: figures in every format, one colour range for all frames, animations, the figures of a case, and error messages; with runs that are
written by this test."""
import contextlib
import io
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import zlib
from unittest import mock

import h5py
import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "cli"))
import animate  # noqa: E402
import plot  # noqa: E402
import report  # noqa: E402
import verify_page  # noqa: E402
import style  # noqa: E402

TIMES = (0.0, 1.0, 2.0)
DX = 0.02


def square(n=20, dx=DX):
    at = (np.arange(n) + 0.5) * dx
    x, y = np.meshgrid(at, at)
    return np.stack([x.ravel(), y.ravel(), np.zeros(n * n)], axis=1)


def write_phase(path, frames, fields):
    """Writes a results file. frames: (time, positions); fields: name, unit, function of time and positions."""
    counts = [len(x) for _, x in frames]
    with h5py.File(path, "w") as file:
        root = file.create_group("VTKHDF")
        root["NumberOfPoints"], root["Points"] = counts, np.vstack([x for _, x in frames])
        steps = root.create_group("Steps")
        steps.attrs["NSteps"] = len(frames)
        steps["Values"], steps["PointOffsets"] = [t for t, _ in frames], np.concatenate([[0], np.cumsum(counts)[:-1]]).astype(int)
        data = root.create_group("PointData")
        for name, unit, tell in fields:
            data[name] = np.concatenate([tell(t, x) for t, x in frames])
            data[name].attrs["unit"] = unit


def write_run(folder, dry_start=False):
    """A run with water whose pressure grows in time, and soil at rest below it; each is a square."""
    folder.mkdir(parents=True)
    x = square()
    pressure = ("pore_pressure", "Pa", lambda t, x: 1e3 * (1.0 + t) * x[:, 1])
    volume = ("volume", "m2", lambda t, x: np.full(len(x), DX**2))
    write_phase(folder / "fluid.vtkhdf", [(t, x[:0] if dry_start and t == 0.0 else x) for t in TIMES], [pressure, volume])
    stress = ("effective_stress", "Pa", lambda t, x: np.outer(x[:, 1] - 0.4, np.array([0.5, 1.0, 0.5, 0.0, 0.0, 0.0])) * 1e4)
    write_phase(folder / "solid.vtkhdf", [(t, x) for t in TIMES], [stress, volume])
    rows = [f"{t},depth[{i}],{(1.0 + t) * (4 - i)},Pa" for t in TIMES for i in range(5)] + [f"{t},head,{0.1 * t},m" for t in TIMES]
    (folder / "gauges.csv").write_text("time_s,gauge,value,unit\n" + "\n".join(rows) + "\n")


CASE = """
[case]
title = "made"
[[water_face]]
discharge = [[0, 0], [2, 0.001]]
[[gauge]]
name = "depth"
phase = "fluid"
kind = "point"
quantity = "pore_pressure"
points = [[0.2, 0.0], [0.2, 0.1], [0.2, 0.2], [0.2, 0.3], [0.2, 0.4]]
"""
VERIFY = """
[[run]]
name = "whole"
[[run]]
name = "later"
[[metric]]
name = "profile"
op = "l2"
gauge = "depth"
references = [12, 9, 6, 3, 0]
[[metric]]
name = "head"
op = "value"
gauge = "head"
reference = 0.2
[[figure]]
name = "panels"
title = "Made"
kind = "fields"
fields = ["fluid.pore_pressure", "effective_stress"]
times = [0, 2]
reference_csv = "reference/points.csv"
[[figure]]
name = "surface"
kind = "outlines"
times = [0, 2]
points = [[0.1, 0.2], [0.2, 0.3]]
[[figure]]
name = "profile"
kind = "profile"
gauges = ["depth"]
label = "pressure [Pa]"
[[figure]]
name = "history"
kind = "history"
gauges = ["head"]
label = "head [m]"
drive = "water_face.0.discharge"
drive_label = "discharge [m2/s]"
[[figure]]
name = "of another run"
kind = "history"
runs = ["later"]
gauges = ["head"]
"""


def write_case(folder):
    """A case with figures, and the runs that `poretwin verify` would have made of it."""
    (folder / "case" / "reference").mkdir(parents=True)
    (folder / "case" / "case.toml").write_text(CASE)
    (folder / "case" / "verify.toml").write_text(VERIFY)
    (folder / "case" / "reference" / "points.csv").write_text("# made\nt_s,x_m,y_m\n0,0.1,0.1\n2,0.2,0.2\n")
    write_run(folder / "runs" / "whole")
    (folder / "runs" / "whole" / "run.toml").write_text(f"case_file = \"{folder / 'case' / 'case.toml'}\"\noverrides = []\n")


def drawn(*words, expect=0):
    """Runs `poretwin plot WORDS`; returns what it printed."""
    out, err, status = io.StringIO(), io.StringIO(), 0
    with mock.patch.object(sys, "argv", ["plot", *map(str, words)]), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            plot.main()
        except SystemExit as end:
            status = getattr(end, "exit_code", end.code)
            err.write(str(end))
    if status != expect:
        raise AssertionError(f"{words}: {status}\n{out.getvalue()}{err.getvalue()}")
    return out.getvalue() if expect == 0 else err.getvalue()


def text_of(pdf):
    """The drawing commands of a PDF."""
    return b"".join(zlib.decompress(body) for body in re.findall(rb"/FlateDecode >>\s*stream\r?\n(.*?)\nendstream", pdf, re.DOTALL))


class Folder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.at = pathlib.Path(folder.name)


class Figures(Folder):
    def test_vector_figures_have_text_and_lines_as_such_and_particles_as_one_small_picture(self):
        write_run(self.at / "run")
        for kind in ("svg", "pdf"):
            drawn(self.at / "run", "--phase", "fluid", "--field", "pore_pressure", "--format", kind)
        svg = (self.at / "run/pictures/fluid_pore_pressure.svg").read_text()
        self.assertGreater(svg.count("<path"), 20)  # letters, ticks, outline
        self.assertIn("pore pressure", svg)  # as text beside the paths of the letters
        self.assertLess(svg.count("<image"), 5)
        pdf = (self.at / "run/pictures/fluid_pore_pressure.pdf").read_bytes()
        self.assertNotIn(b"/Type3", pdf)
        self.assertIn(b" Tj", text_of(pdf))
        images = [int(width) for width in re.findall(rb"/Width (\d+)", pdf)]
        # The square of particles is drawn 5 inches wide, with its surroundings: 300 dots per inch.
        self.assertGreater(max(images), 1300)
        for path in (self.at / "run/pictures").iterdir():
            self.assertLess(path.stat().st_size, 3e5, path)

    def test_a_figure_is_the_same_to_the_byte_when_it_is_drawn_again(self):
        write_run(self.at / "run")
        for kind in ("svg", "pdf"):  # formats that could contain the date, and random names
            for out in "ab":
                drawn(self.at / "run", "--gauge", "head", "--format", kind, "--out", self.at / out)
            self.assertEqual(*((self.at / out / f"gauge_head.{kind}").read_bytes() for out in "ab"), kind)

    def test_many_particles_do_not_make_a_large_file(self):
        # 10,000 particles with values unrelated to their neighbours': the picture that compresses worst.
        n, dx = 100, 0.4 / 100
        x = square(n, dx)
        (self.at / "run").mkdir()
        noise = np.random.default_rng(0).uniform(0, 1e3, len(x))
        write_phase(self.at / "run/fluid.vtkhdf", [(0.0, x)], [("pore_pressure", "Pa", lambda t, x: noise),
                                                              ("volume", "m2", lambda t, x: np.full(len(x), dx**2))])
        drawn(self.at / "run", "--field", "pore_pressure", "--format", "pdf")
        self.assertLess((self.at / "run/pictures/fluid_pore_pressure.pdf").stat().st_size, 2e6)

    def test_frames_shown_together_have_one_range(self):
        write_run(self.at / "run", dry_start=True)
        frames = plot.Frames(self.at / "run" / "fluid.vtkhdf")
        together = plot.Shown(frames, "fluid", "pore_pressure", [0, 1, 2])
        self.assertEqual(together.steps, [1, 2])  # there is no water at first
        alone = [plot.Shown(frames, "fluid", "pore_pressure", [step]) for step in (1, 2)]
        top = 0.4 - 0.5 * DX
        self.assertAlmostEqual(together.norm.vmax * together.factor, 3e3 * top, delta=1e-9)
        self.assertAlmostEqual(together.norm.vmin * together.factor, 2e3 * 0.5 * DX, delta=1e-9)
        self.assertAlmostEqual(alone[0].norm.vmax * alone[0].factor, 2e3 * top, delta=1e-9)
        printed = drawn(self.at / "run", "--phase", "fluid", "--field", "pore_pressure", "--time", "0", "1", "2")
        self.assertIn("fluid_pore_pressure_t0_t1_t2.png", printed)
        self.assertIn("no particles at t = 0 s", printed)

    def test_the_local_factor_has_the_same_colours_in_every_run_and_a_line_around_soil_that_yields(self):
        write_run(self.at / "run")
        x = square()

        def paint(values):
            (self.at / "run" / "solid.vtkhdf").unlink()  # the last one is still open
            write_phase(self.at / "run" / "solid.vtkhdf", [(0.0, x)], [("local_factor_of_safety", "1", lambda t, x: values)])
            shown = plot.Shown(plot.Frames(self.at / "run" / "solid.vtkhdf"), "solid", "local_factor_of_safety", [0])
            figure, axes = plot.plt.subplots()
            self.addCleanup(plot.plt.close, figure)
            shown.paint(axes, 0)
            lines = [line for line in axes.collections if np.array_equal(line.get_edgecolor()[:, :3], [[1.0, 1.0, 1.0]])]
            return shown, lines, figure

        # Soil that yields within rounding below y = 0.1, much stronger soil above, and to the right soil without a factor.
        scatter = 1.0 + 1e-12 * np.random.default_rng(0).normal(size=len(x))
        shown, lines, figure = paint(np.where(x[:, 0] > 0.3, np.nan, np.where(x[:, 1] < 0.1, scatter, 100.0)))
        self.assertEqual((shown.norm.vmin, shown.norm.vmax, shown.extend), (1.0, 3.0, "max"))
        self.assertEqual(len(lines), 1)
        ends = np.concatenate([part.vertices for part in lines[0].get_paths()])
        self.assertAlmostEqual(ends[:, 1].max(), 0.1, delta=0.6 * DX)
        self.assertAlmostEqual(ends[:, 0].max(), 0.3, delta=0.6 * DX)
        self.assertIn("white line: around soil that yields", figure.axes[0].get_title())
        for values, extend in ((np.full(len(x), 1.5), "neither"), (np.linspace(0.0, 4.0, len(x)), "both"), (np.full(len(x), np.nan), "neither")):
            shown, lines, _ = paint(values)
            self.assertEqual((shown.norm.vmin, shown.norm.vmax, shown.extend), (1.0, 3.0, extend))
            self.assertEqual(len(lines), 1 if extend == "both" else 0)
        drawn(self.at / "run", "--field", "local_factor_of_safety")
        self.assertTrue((self.at / "run/pictures/solid_local_factor_of_safety.png").exists())

    def test_labels_are_symbols_with_short_units(self):
        write_run(self.at / "run")
        shown = plot.Shown(plot.Frames(self.at / "run" / "solid.vtkhdf"), "solid", "effective_stress", [0])
        self.assertEqual(shown.label, r"effective stress $\sigma'_{yy}$ [kPa]")
        self.assertEqual(style.label("fluid", "velocity", "| |"), r"speed of the water $|\mathbf{v}_w|$")
        self.assertEqual(style.label("fluid", "velocity", "x"), "velocity of the water $v_{w,x}$")
        self.assertEqual(style.label("solid", "of_another_solver"), "of another solver")
        self.assertEqual(style.prefix(2500.0, "Pa"), (1e3, "kPa"))
        self.assertEqual(style.unit("1"), "")


class OfACase(Folder):
    def test_gauges_are_labelled_by_their_places_and_called_as_fields_are(self):
        write_case(self.at)
        drawn(self.at / "runs" / "whole", "--gauge", "depth", "head", "--format", "svg", "--out", self.at / "out")
        depth = (self.at / "out/gauge_depth.svg").read_text()
        for words in ("pore pressure", "y = 0.1 m", "y = 0.4 m"):  # matplotlib adds each text as a comment to its letters' paths
            self.assertIn(words, depth)
        self.assertNotIn("depth[", depth)
        self.assertIn("head [mm]", (self.at / "out/gauge_head.svg").read_text())
        declared, _ = plot.declaration(self.at / "runs" / "whole", "depth")
        self.assertEqual(plot.places(declared | {"points": [[0, 0.1], [0.2, 0.3]]}, ["a", "b"]), ["(0, 0.1) m", "(0.2, 0.3) m"])
        self.assertEqual(plot.quantity_label(declared | {"quantity": "velocity_x", "phase": "solid"}, "", "speed"), "velocity of the soil $v_{s,x}$")
        self.assertEqual(plot.quantity_label({"kind": "momentum", "phase": "solid"}, "x", "soil_x"), "momentum of the soil, x")

    def test_the_figures_of_a_case_are_drawn_from_its_runs(self):
        write_case(self.at)
        printed = drawn(self.at / "runs", "--out", self.at / "out", "--format", "svg")
        self.assertEqual({path.name for path in (self.at / "out").iterdir()}, {f"{n}.svg" for n in ("panels", "surface", "profile", "history")})
        self.assertIn("of another run: not drawn: there is no run 'later'", printed)
        history = (self.at / "out/history.svg").read_text()
        for words in ("head [m]", "discharge [m2/s]", "reference"):
            self.assertIn(words, history)
        self.assertIn("pressure [Pa]", (self.at / "out/profile.svg").read_text())

    def test_references_are_drawn_where_they_belong(self):
        import figures
        write_case(self.at)
        style.use()
        case = figures.Figures(self.at / "case", {"whole": self.at / "runs" / "whole"})
        declared = {f["name"]: f for f in case.declared()}
        lines = {tuple(map(tuple, np.column_stack(line.get_data()))) for line in case.profile(declared["profile"]).axes[0].get_lines()}
        self.assertIn(((12.0, 0.0), (9.0, 0.1), (6.0, 0.2), (3.0, 0.3), (0.0, 0.4)), lines)  # as computed, and the reference
        history = case.history(declared["history"]).axes[0].get_lines()
        self.assertIn((2.0, 0.2), {tuple(point) for line in history for point in np.column_stack(line.get_data())})
        panels = case.fields(declared["panels"]).axes[:4]
        points = [[tuple(line.get_xydata()[0]) for line in axes.get_lines()] for axes in panels]
        self.assertEqual(points, [[(0.1, 0.1)]] * 2 + [[(0.2, 0.2)]] * 2)

    def test_a_report_has_them(self):
        write_case(self.at)
        run = {"name": "whole", "folder": str(self.at / "runs/whole"), "figures": [], "windows": 1, "wall_s": 1, "cpu_s": 1, "particles": {}}
        found = [{"case": "case", "folder": str(self.at / "case"), "source": "", "passed": True, "runs": [run], "metrics": []}]
        (self.at / "found.json").write_text(json.dumps(found))
        with mock.patch.object(sys, "argv", ["report", str(self.at / "found.json"), str(self.at / "page")]), contextlib.redirect_stdout(io.StringIO()):
            verify_page.main()
        self.assertIn("![case_panels](pictures/case_panels.png)", (self.at / "page/validation.md").read_text())
        self.assertTrue((self.at / "page/pictures/case_panels.png").exists())

    def test_runs_without_figures_are_named(self):
        write_case(self.at)
        (self.at / "case/verify.toml").write_text('[[run]]\nname = "whole"\n')
        self.assertIn("declares no [[figure]]; name one of the runs: whole", drawn(self.at / "runs", expect=2))


class Animations(Folder):
    def test_a_gif_has_every_frame_in_its_own_time(self):
        from PIL import Image
        write_run(self.at / "run", dry_start=True)
        drawn(self.at / "run", "--animate", self.at / "a.gif")
        with Image.open(self.at / "a.gif") as gif:
            self.assertEqual(gif.n_frames, len(TIMES))
            self.assertEqual(gif.info["duration"], 1000 // animate.RATE)
            pictures = []
            for k in range(gif.n_frames):
                gif.seek(k)
                pictures.append(np.asarray(gif.convert("RGB")).astype(int))
        self.assertEqual(len({picture.shape for picture in pictures}), 1)
        # Water appears, and its colours change with its pressure; the soil's do not.
        soil = pictures[0].shape[1] // 2
        self.assertGreater(np.abs(pictures[1] - pictures[0])[:, :soil].mean(), 5.0)
        self.assertGreater(np.abs(pictures[2] - pictures[1])[:, :soil].max(axis=2).mean(), 5.0)

    @unittest.skipIf(shutil.which("ffmpeg") is None, "install ffmpeg")
    def test_a_video_has_every_frame(self):
        write_run(self.at / "run")
        drawn(self.at / "run", "--phase", "fluid", "--animate", self.at / "a.mp4")
        counted = subprocess.run(["ffprobe", "-v", "error", "-count_frames", "-show_entries", "stream=nb_read_frames,pix_fmt", "-of", "csv=p=0",
                               self.at / "a.mp4"], capture_output=True, text=True, check=True).stdout
        self.assertEqual(counted.strip(), f"yuv420p,{len(TIMES)}")

    def test_one_blow_does_not_take_the_colours_from_the_other_frames(self):
        self.at.joinpath("run").mkdir()
        blow = lambda t, x: np.where((t == 1.0) & (np.arange(len(x)) < 4), 1e6, 1e3 * x[:, 1])  # noqa: E731
        write_phase(self.at / "run/fluid.vtkhdf", [(t, square()) for t in TIMES], [("pore_pressure", "Pa", blow)])
        frames = plot.Frames(self.at / "run/fluid.vtkhdf")
        whole = plot.Shown(frames, "fluid", "pore_pressure", [0, 1, 2])
        self.assertEqual((whole.norm.vmax * whole.factor, whole.extend), (1e6, "neither"))
        shown = plot.Shown(frames, "fluid", "pore_pressure", [0, 1, 2], animate.PIXELS, animate.RARE)
        self.assertLess(shown.norm.vmax * shown.factor, 400.0)
        self.assertIn(shown.extend, ("max", "both"))

    def test_long_runs_are_thinned_with_both_ends(self):
        for count in (1, 7, animate.MOST_FRAMES, 5000):
            chosen = animate.chosen(count)
            self.assertEqual(len(chosen), min(count, animate.MOST_FRAMES))
            self.assertEqual((chosen[0], chosen[-1]), (0, count - 1))


SLOPE = """
[case]
title = "A <bold> slope"
[[soil]]
name = "sand & gravel"
shape = "polygon"
points = [[0, 0], [0.4, 0], [0.2, 0.4], [0, 0.4]]
porosity = 0.4
cohesion = 2000
[[water_face]]
name = "reservoir"
points = [[0.2, 0.4], [0.4, 0]]
head = [[0, 0], [172800, 0.2]]
[[gauge]]
name = "F"
phase = "solid"
kind = "factor_of_safety"
every = 86400
[[gauge]]
name = "water"
phase = "fluid"
kind = "balance"
"""


class Report(Folder):
    def setUp(self):
        super().setUp()
        self.run_folder, self.case = self.at / "run", self.at / "case.toml"
        write_run(self.run_folder)
        self.case.write_text(SLOPE)
        rows = ["0,F,1.5,1", "0,F_error,0.01,1", "86400,F,1.25,1", "86400,F_error,0.02,1", "259200,F,1.375,1", "259200,F_error,0.01,1",
                "0,water_error,0,m2", "259200,water_error,1e-15,m2", "0,head,0,m", "259200,head,1,m"]
        (self.run_folder / "gauges.csv").write_text("time_s,gauge,value,unit\n" + "\n".join(rows) + "\n")
        (self.run_folder / "run.toml").write_text(f'case = "slope"\ncase_file = "{self.case}"\noverrides = ["soil.0.cohesion=3000"]\nexit = 6\nwall_s = 7200\n'
                                                  f'warnings = []\n[identity]\n"case file" = "{report.fnv1a(SLOPE.encode()):016x}"\n')
        (self.run_folder / "solid.summary.json").write_text(json.dumps({
            "process": "solid", "cpu_s": 12.5, "memory_bytes": 2e7, "steps": {"windows": 30}, "counters": {"particles": 400},
            "warnings": [{"what": "the soil's rest was not found", "count": 1, "detail": "", "result_in_doubt": True}]}))

    def made(self, *options):
        out = self.at / "report.html"
        with mock.patch.object(sys, "argv", ["report", str(self.run_folder), "--out", str(out), *options]), contextlib.redirect_stdout(io.StringIO()):
            report.main()
        return out.read_text()

    def test_it_has_section_drives_state_safety_balance_warnings_and_origin(self):
        page = self.made()
        headings = re.findall("<h2>(.*?)</h2>", page)
        self.assertEqual(headings, ["Section", "Soils", "What drives it", "The end: 3 days", "Factor of safety", "Gauges", "Balance", "Warnings", "Where it comes from"])
        self.assertIn("<h1>A &lt;bold&gt; slope</h1>", page)
        self.assertIn("computed in 7200 s", page)
        self.assertIn("<td>sand &amp; gravel</td>", page)
        self.assertIn('<td class="number">3</td>', page, "kPa, as given on the command line")
        self.assertRegex(page, '<td>F</td><td class="number">1.25</td><td class="number">0.02</td><td>1 days</td><td class="number">1.375</td>')
        self.assertIn("its result is in doubt", page)
        self.assertRegex(page, "the soil&#x27;s rest was not found</td><td[^>]*>1</td><td>the result may be wrong")
        self.assertNotIn('src="http', page)
        self.assertGreaterEqual(page.count("data:image/"), 6)

    def test_it_shows_the_factors_that_were_found_after_the_run(self):
        (self.run_folder / "safety").mkdir()
        write_phase(self.run_folder / "safety" / "solid.vtkhdf", [(0.0, square()), (172800.0, square())], [("failing_strain", "1", lambda t, x: x[:, 0])])
        columns = "frame,time_s,factor,error,stands,fails,soil,face,share,volume,x_m,y_m,z_m,towards_x,towards_y,towards_z"
        (self.run_folder / "safety" / "safety.csv").write_text(
            f"{columns}\n0,0,inf,inf,100,inf,,,,,,,,,,\n2,172800,1.125,0.01,1.115,1.135,sand & gravel,reservoir,0.8,0.1,0.3,0.2,0,0.9,-0.4,0\n")
        page = self.made()
        self.assertRegex(page, '<td>poretwin safety</td><td class="number">1.125</td><td class="number">0.01</td><td>2 days</td>')
        self.assertRegex(page, "<td>sand &amp; gravel</td><td>reservoir</td><td>80 %</td>")
        self.assertIn("What fails at 2 days", page)

    def test_it_shows_the_local_factor_of_soil_that_has_one(self):
        for value, shown in ((lambda x: 1.0 + x[:, 1], True), (lambda x: np.full(len(x), np.nan), False)):
            write_phase(self.run_folder / "solid.vtkhdf", [(t, square()) for t in (0.0, 259200.0)], [("local_factor_of_safety", "1", lambda t, x: value(x))])
            self.assertEqual("local factor of safety, of the stress at each point, not of a slip surface" in self.made(), shown)

    def test_it_has_the_parameters_of_materials_that_have_their_own(self):
        clay = 'model = "modified_cam_clay"\ncompression_slope = 0.161\npreconsolidation_pressure = 82000\n'
        grains = 'model = "mu_i"\nlimiting_friction = 0.73\ngrain_diameter = 0.002\n'
        defaults = json.dumps({"modified_cam_clay": {"compression_slope": 0.3, "swelling_slope": 0.02, "critical_state_slope": 1, "overconsolidation_ratio": 2},
                               "mu_i": {"static_friction": 0.5, "inertial_number": 0.4, "viscous_number": 0.01, "dilatancy": 0,
                                        "critical_solid_fraction": 0.6, "inertial_loosening": 1 / 3}})
        for keys, cells in ((clay, [0.161, 0.02, 1, 2, 82]), (grains, [0.5, 0.73, 0.4, 0.01, 2, 0, 0.6, 0.3333])):
            text = SLOPE.replace("cohesion = 2000\n", keys)
            self.case.write_text(text)
            about = (self.run_folder / "run.toml").read_text()
            (self.run_folder / "run.toml").write_text(re.sub('"case file" = ".*"', f'"case file" = "{report.fnv1a(text.encode()):016x}"', about)
                                                      .replace('"soil.0.cohesion=3000"', ""))
            self.assertIn("".join(f'<td class="number">{v:g}</td>' for v in cells), self.made("--material-defaults", defaults))

    def test_it_has_the_soils_of_a_body_in_three_dimensions(self):
        text = SLOPE.replace("[case]", "[case]\ndimension = 3").replace('shape = "polygon"', 'shape = "box"')
        text = re.sub(r"points = \[\[0, 0\], \[0.4.*", "min = [0, 0, 0]\nmax = [1, 1, 1]", text)
        text = text.replace("points = [[0.2, 0.4], [0.4, 0]]", "point = [0, 0, 0]\nnormal = [0, 0, 1]")
        self.case.write_text(text)
        about = (self.run_folder / "run.toml").read_text()
        (self.run_folder / "run.toml").write_text(re.sub('"case file" = ".*"', f'"case file" = "{report.fnv1a(text.encode()):016x}"', about))
        page = self.made()
        self.assertIn("<td>sand &amp; gravel</td>", page)
        self.assertNotIn("<h2>Section</h2>", page)

    def test_a_case_that_has_changed_since_is_not_shown(self):
        self.case.write_text(SLOPE.replace("0.4", "0.5"))
        page = self.made()
        self.assertIn("has changed since the run", page)
        self.assertNotIn("<h2>Section</h2>", page)

    def test_what_is_wrong_is_said(self):
        for words, message in (([self.at / "nowhere"], "expected the folder of a run that has ended"),
                               ([self.run_folder, "--out", self.at / "a.doc"], "ends in .html or .pdf")):
            with mock.patch.object(sys, "argv", ["report", *map(str, words)]), self.assertRaisesRegex(SystemExit, message):
                report.main()
        with mock.patch.dict(os.environ, {"PATH": "/nowhere"}), self.assertRaisesRegex(SystemExit, "needs the program chromium"):
            report.print_pdf("", self.at / "a.pdf")


class Mistakes(Folder):
    def test_what_is_wrong_is_said(self):
        write_run(self.at / "run")
        (self.at / "empty").mkdir()
        run = self.at / "run"
        water_only = self.at / "water"
        shutil.copytree(run, water_only)
        (water_only / "solid.vtkhdf").unlink()
        unbegun = self.at / "unbegun"
        unbegun.mkdir()
        write_phase(unbegun / "fluid.vtkhdf", [(0.0, square())], [("pore_pressure", "Pa", lambda t, x: x[:, 0])])
        with h5py.File(unbegun / "fluid.vtkhdf", "r+") as file:
            file["VTKHDF/Steps"].attrs["NSteps"] = 0
        for words, message, status in (
                ([self.at / "nowhere"], "expected the folder of a run", 5),
                ([self.at / "empty"], "neither fluid.vtkhdf nor solid.vtkhdf", 5),
                ([run, "--format", "jpg"], "invalid choice: 'jpg'", 2),
                ([run, "--animate", self.at / "a.avi"], "expected a name that ends in .gif or .mp4", 2),
                ([run, "--animate", self.at / "a.gif", "--time", "1"], "--time does not go with --animate", 2),
                ([run, "--field", "colour"], "no phase of .* has a field 'colour'", 2),
                ([run, "--phase", "solid", "--field", "effective_stress_ab"], "no field 'effective_stress_ab'; there are: effective_stress", 2),
                ([water_only, "--phase", "solid"], "solid.vtkhdf is not there; this run has: fluid", 2),
                ([water_only, "--phase", "solid", "--animate", self.at / "a.gif"], "this run has: fluid", 2),
                ([self.at / "empty", "--animate", self.at / "a.gif"], "neither fluid.vtkhdf nor solid.vtkhdf", 5),
                ([unbegun, "--time", "1"], "no frame has been written yet", 5),
                ([unbegun, "--animate", self.at / "a.gif"], "no frame has been written yet", 5)):
            with self.subTest(message):
                self.assertRegex(drawn(*words, expect=status), message)
        # Without ffmpeg in the PATH the message names its package, before anything is drawn.
        with mock.patch.dict(os.environ, {"PATH": "/nowhere"}):
            self.assertRegex(drawn(run, "--animate", self.at / "a.mp4", expect=5), "ffmpeg, of the package ffmpeg; or write a GIF")


if __name__ == "__main__":
    unittest.main()
