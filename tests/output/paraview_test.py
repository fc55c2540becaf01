#!/usr/bin/python3
"""ParaView 5.11 (Debian 12) opens the .xmf of a run with each of its two readers: every step has the particles and numbers that were
written, an empty first step too, and a picture shows them at their positions. Arguments: the program, then those of unittest.

Needs the packages paraview, python3-paraview and xvfb; without them exit code 77 (skipped).
"""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

SKIPPED = 77
READERS = {"Xdmf3ReaderS": "FileName", "XDMFReader": "FileNames"}  # ParaView 5.11 uses the first by default
SIZE = (400, 300)


def look(files, out):
    """Inside pvbatch: writes the content of each file according to each reader as JSON, and pictures of the particles coloured by pore pressure."""
    from paraview import simple
    view = simple.CreateView("RenderView")
    view.ViewSize = SIZE
    view.OrientationAxesVisibility = 0
    view.UseColorPaletteForBackground = 0
    view.Background = [1.0, 1.0, 1.0]
    view.InteractionMode = "2D"
    found = []
    for name in files:
        for kind, files_argument in READERS.items():
            reader = getattr(simple, kind)(**{files_argument: [name]})
            shown = simple.Show(reader, view)
            shown.Representation = "Points"
            shown.PointSize = 8
            steps = []
            for time in list(reader.TimestepValues):
                reader.UpdatePipeline(time)
                view.ViewTime = time
                about = reader.GetDataInformation()
                fields = {array.Name: [array.GetRange(k) for k in range(array.GetNumberOfComponents())] for array in reader.PointData}
                points = about.GetNumberOfPoints()
                steps.append({"time": time, "points": points, "bounds": about.GetBounds(), "fields": fields})
            # The first step is drawn after the last one has been read: a picture of it must not contain anything of the last.
            low, high = steps[-1]["fields"]["pore_pressure"][0]
            colours = simple.GetColorTransferFunction("pore_pressure")
            colours.RGBPoints = [low, 1, 0, 0, high, 0, 0, 1]
            colours.ColorSpace = "RGB"
            simple.ColorBy(shown, ("POINTS", "pore_pressure"))
            shown.SetScalarBarVisibility(view, False)
            bounds = steps[-1]["bounds"]
            view.CameraParallelProjection = 1
            view.CameraParallelScale = max(bounds[1] - bounds[0], bounds[3] - bounds[2])
            view.CameraFocalPoint = [(bounds[0] + bounds[1]) / 2, (bounds[2] + bounds[3]) / 2, 0]
            view.CameraPosition = [*view.CameraFocalPoint[:2], 10]
            for k in (len(steps) - 1, 0):
                view.ViewTime = steps[k]["time"]
                steps[k]["picture"] = f"{out}/{len(found)}_{k}.png"
                simple.SaveScreenshot(steps[k]["picture"], view, ImageResolution=SIZE)
            simple.Hide(reader, view)
            found.append({"file": name, "reader": kind, "steps": steps})
    pathlib.Path(out, "found.json").write_text(json.dumps(found))
    os._exit(0)  # ParaView and Mesa sometimes crash when they close the window (GLXBadContext)


def written(path):
    """The steps in the .vtkhdf: time, positions, fields by name, [n, components]."""
    import h5py
    with h5py.File(path) as file:
        root = file["VTKHDF"]
        for k, time in enumerate(root["Steps/Values"]):
            first = int(root["Steps/PointOffsets"][k])
            rows = slice(first, first + int(root["NumberOfPoints"][k]))
            fields = {name: data[rows] for name, data in root["PointData"].items()}
            yield float(time), root["Points"][rows], {name: data[:, None] if data.ndim == 1 else data for name, data in fields.items()}


def mismatch(seen, path):
    """Describes how a reader's steps differ from those in the .vtkhdf; None: they do not."""
    steps = list(written(path))
    if [step["time"] for step in seen["steps"]] != [time for time, _, _ in steps]:
        return "times"
    for step, (time, points, fields) in zip(seen["steps"], steps):
        if step["points"] != len(points):
            return f"number of particles at {time}"
        if len(points) == 0:
            continue
        bounds = [step["bounds"][k] for k in range(4)]
        if bounds != [points[:, 0].min(), points[:, 0].max(), points[:, 1].min(), points[:, 1].max()]:
            return f"positions at {time}"
        for name, values in fields.items():
            if name not in step["fields"] or [list(r) for r in step["fields"][name]] != [[c.min(), c.max()] for c in values.T]:
                return f"{name} at {time}"
    return None


class ParaView(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        at = pathlib.Path(cls.folder.name)
        # A run of both phases that starts without water; its fields include stress tensors.
        command = [PROGRAM, "run", "embankment_seepage", "--out", at, "--until", "100", "--no-pictures", "--quiet",
                   "--set", "fluid.particle_spacing=0.04", "--set", "solid.particle_spacing=0.04", "--set", "output.interval=50"]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        cls.paths = [at / "fluid.xmf", at / "solid.xmf", at / "broken.xmf"]
        # A side-car with an error: all its slabs begin with the first particle of the file.
        text = (at / "solid.xmf").read_text()
        count = list(written(at / "solid.vtkhdf"))[0][1].shape[0]
        for old, new in ((f"|{count}:", "|0:"), (f"|{count} 0:", "|0 0:"), (f">{count} 1 ", ">0 1 "), (f">{count} 0 1 1 ", ">0 0 1 1 ")):
            assert old in text, old
            text = text.replace(old, new)
        cls.paths[2].write_text(text)
        # Debian's ParaView draws through X only; an X server without a screen prints its number when it is ready. -noreset:
        # ParaView's MPI connects once to look for graphics cards, and without the option the server would restart when it
        # disconnects.
        server = subprocess.Popen(["Xvfb", "-displayfd", "1", "-noreset", "-nolisten", "tcp", "-screen", "0", "640x480x24"], stdout=subprocess.PIPE,
                                  stderr=subprocess.DEVNULL, text=True)
        try:
            display = f":{server.stdout.readline().strip()}"
            done = subprocess.run(["pvbatch", __file__, "look", at, *cls.paths], capture_output=True, text=True,
                                  env={**os.environ, "DISPLAY": display})
        finally:
            server.terminate()
            server.communicate()
        if done.returncode != 0:
            lines = [line for line in (done.stdout + done.stderr).splitlines() if not re.match(r"\d+ +0x", line)]  # no stack
            raise AssertionError("\n".join([f"pvbatch: {done.returncode}", *lines[-30:]]))
        cls.found = json.loads((at / "found.json").read_text())

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def seen(self, name):
        found = [one for one in self.found if pathlib.Path(one["file"]).name == name]
        self.assertEqual([one["reader"] for one in found], list(READERS))
        return found

    def test_every_step_has_what_was_written(self):
        for phase in ("fluid", "solid"):
            for one in self.seen(f"{phase}.xmf"):
                with self.subTest(phase=phase, reader=one["reader"]):
                    self.assertIsNone(mismatch(one, self.paths[0].with_name(f"{phase}.vtkhdf")))
        self.assertEqual(self.seen("fluid.xmf")[0]["steps"][0]["points"], 0)

    def test_a_side_car_that_points_elsewhere_is_noticed(self):
        for one in self.seen("broken.xmf"):
            self.assertRegex(mismatch(one, self.paths[1].with_suffix(".vtkhdf")) or "", "^(positions|[a-z_]+) at ", one["reader"])

    def test_pictures_show_the_particles_where_they_are_and_none_at_first(self):
        import numpy as np
        from matplotlib.image import imread
        for one in self.seen("fluid.xmf"):
            with self.subTest(reader=one["reader"]):
                first, last = (imread(one["steps"][k]["picture"])[:, :, :3] for k in (0, -1))
                self.assertTrue((first > 0.99).all(), "the first step has no water")
                coloured = (last < 0.9).any(axis=2)
                self.assertGreater(coloured.sum(), 50 * one["steps"][-1]["points"] / 4)
                rows, columns = np.nonzero(coloured)
                x0, x1, y0, y1 = one["steps"][-1]["bounds"][:4]
                pixel = 2 * max(x1 - x0, y1 - y0) / SIZE[1]
                # Points are 8 pixels wide.
                self.assertAlmostEqual(np.ptp(columns), (x1 - x0) / pixel + 8, delta=3)
                self.assertAlmostEqual(np.ptp(rows), (y1 - y0) / pixel + 8, delta=3)
                high, low = (last[edge][coloured[edge]].mean(axis=0) for edge in (rows.min() + 4, rows.max() - 4))
                self.assertGreater(high[0] - high[2], low[0] - low[2] + 0.5, "red above, where the pressure is low, and blue below")


if __name__ == "__main__":
    if sys.argv[1] == "look":
        look(sys.argv[3:], sys.argv[2])
        sys.exit(0)
    missing = {"pvbatch": "python3-paraview", "Xvfb": "xvfb"}
    missing = [package for program, package in missing.items() if shutil.which(program) is None]
    if missing:
        print(f"skipped: ParaView is not tried; install {' '.join(missing)}")
        sys.exit(SKIPPED)
    PROGRAM = sys.argv.pop(1)
    unittest.main()
