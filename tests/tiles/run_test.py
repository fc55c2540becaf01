"""`poretwin run --tiles P`: results as of one process, for soil, for water, and for water beside soil that moves; a run that is stopped or killed goes on, on another
number of ranks; what several processes cannot compute is refused before anything starts. Arguments: program, folder of the sources, classes of tests (default: all)."""
import json, os, shutil, signal, subprocess, sys, tempfile, time, unittest
from pathlib import Path

import h5py
import numpy as np

program, sources = sys.argv[1], Path(sys.argv[2])
coarse = ["--set", "solid.particle_spacing=0.01", "--set", "output.gauge_interval=0.02", "--no-pictures"]


def ranks_below(pid, solver="poretwin-solid"):
    """Process ids of the solver's ranks below the process `pid`, in their order."""
    found, open_ = [], [pid]
    while open_:
        parent = open_.pop()
        try:
            children = [int(c) for c in Path(f"/proc/{parent}/task/{parent}/children").read_text().split()]
        except OSError:
            continue
        open_ += children
        for child in children:
            try:
                if Path(f"/proc/{child}/comm").read_text().strip() == solver:
                    variables = Path(f"/proc/{child}/environ").read_bytes().split(b"\0")
                    found.append((next(int(v[21:]) for v in variables if v.startswith(b"OMPI_COMM_WORLD_RANK=")), child))
            except (OSError, StopIteration):
                pass
    return [child for _, child in sorted(found)]


def is_running(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


def wait_for(condition, seconds=60):
    end = time.monotonic() + seconds
    while not (found := condition()):
        if time.monotonic() > end:
            raise AssertionError("waited in vain")
        time.sleep(0.02)
    return found


def child_named(pid, name):
    """Process id of the child of the process `pid` with this name; None: there is none."""
    for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split():
        if Path(f"/proc/{child}/comm").read_text().strip() == name:
            return int(child)
    return None


class Runs(unittest.TestCase):
    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="poretwin-tiles-"))
        self.addCleanup(shutil.rmtree, self.folder)

    def last_frame(self, out, field, phase="solid"):
        with h5py.File(self.folder / out / f"{phase}.vtkhdf") as file:
            group = file["VTKHDF"]
            n = int(group["NumberOfPoints"][-1])
            return group["PointData"][field][-n:]


class Tiles(Runs):
    def command(self, out, *more, case="column_collapse"):
        return [program, "run", str(sources / "cases" / case), "--out", str(self.folder / out), *coarse, *more]

    def run_to_the_end(self, out, *more, **which):
        return subprocess.run(self.command(out, *more, **which), capture_output=True, text=True, timeout=280)

    def expect_same(self, one, other, allowed):
        for field in ("displacement", "velocity", "effective_stress", "accumulated_plastic_strain"):
            a, b = self.last_frame(one, field), self.last_frame(other, field)
            self.assertEqual(a.shape, b.shape)
            self.assertLessEqual(np.abs(a - b).max(), allowed * np.abs(a).max(), field)

    def test_gives_the_results_of_one_process(self):
        end = ["--set", "case.end_time=0.1"]
        for out, more in (("one", []), ("two", ["--tiles", "2", "--json", str(self.folder / "report.json")])):
            ended = self.run_to_the_end(out, *end, *more)
            self.assertEqual(ended.returncode, 0, ended.stderr)
        report = json.loads((self.folder / "report.json").read_text())
        with h5py.File(self.folder / "two" / "solid.vtkhdf") as file:
            n = int(file["VTKHDF"]["NumberOfPoints"][-1])
        self.assertGreaterEqual(report["processes"][0]["counters"]["particles"], n)
        self.expect_same("one", "two", 1e-6)  # flowing soil departs from 1e-13 by itself: decision 0039
        gauges = [np.genfromtxt(self.folder / out / "gauges.csv", delimiter=",", names=True, dtype=None, encoding="utf8") for out in ("one", "two")]
        self.assertEqual(len(gauges[0]), len(gauges[1]))

    def test_gives_the_water_of_one_process(self):
        for out, more in (("one", []), ("two", ["--tiles", "2"])):
            ended = subprocess.run([program, "run", str(sources / "cases" / "dam_break"), "--out", str(self.folder / out), "--no-pictures",
                                    "--set", "fluid.particle_spacing=0.05", "--set", "case.end_time=0.2",
                                    "--set", "fluid.pressure_tolerance=1e-10", *more],
                                   capture_output=True, text=True, timeout=280)
            self.assertEqual(ended.returncode, 0, ended.stderr)
        last = {}
        for out in ("one", "two"):
            with h5py.File(self.folder / out / "fluid.vtkhdf") as file:
                group = file["VTKHDF"]
                last[out] = [group[name][-int(group["NumberOfPoints"][-1]):] for name in ("Points", "PointData/velocity")]
        for one, two in zip(last["one"], last["two"]):
            self.assertEqual(one.shape, two.shape)
            self.assertLessEqual(np.abs(one - two).max(), 1e-5 * np.abs(one).max())

    def test_stopped_goes_on_with_another_number_of_ranks(self):
        # Finer than the other runs, so that it takes seconds and is still going when it is stopped.
        end = ["--set", "case.end_time=0.6", "--set", "solid.particle_spacing=0.0025"]
        running = subprocess.Popen(self.command("run", *end, "--tiles", "2"), stderr=subprocess.PIPE, text=True)
        wait_for(lambda: (self.folder / "run" / "solid.vtkhdf").exists() and len(ranks_below(running.pid)) == 2)
        time.sleep(0.2)
        running.send_signal(signal.SIGINT)
        said = running.communicate(timeout=60)[1]
        self.assertEqual(running.returncode, 130, said)
        self.assertTrue(list((self.folder / "run" / "checkpoints").iterdir()))
        ended = self.run_to_the_end("run", *end, "--tiles", "3", "--resume")
        self.assertEqual(ended.returncode, 0, ended.stderr)
        with h5py.File(self.folder / "run" / "solid.vtkhdf") as file:
            times = file["VTKHDF"]["Steps"]["Values"][:]
        self.assertAlmostEqual(times[-1], 0.6)
        self.assertTrue((np.diff(times) > 0.0).all())

    def test_ends_when_a_rank_dies(self):
        running = subprocess.Popen(self.command("run", "--set", "case.end_time=6", "--tiles", "3", "--restarts", "0"), stderr=subprocess.PIPE, text=True)
        pids = wait_for(lambda: (found := ranks_below(running.pid)) and len(found) == 3 and (self.folder / "run" / "solid.vtkhdf").exists() and found)
        start = time.monotonic()
        os.kill(pids[2], signal.SIGKILL)
        said = running.communicate(timeout=60)[1]
        self.assertLess(time.monotonic() - start, 5.0)
        self.assertIn(running.returncode, (1, 3), said)  # 3: another rank missed its signs of life before mpirun heard of its death
        self.assertIn("rank 2", said)
        wait_for(lambda: not any(is_running(pid) for pid in pids), 3)

    def test_ends_when_a_rank_is_stopped_and_goes_on(self):
        end = ["--set", "case.end_time=0.2", "--set", "solid.particle_spacing=0.005", "--checkpoint-every", "0.1"]
        running = subprocess.Popen(self.command("run", *end, "--tiles", "2"), stderr=subprocess.PIPE, text=True)
        pids = wait_for(lambda: (found := ranks_below(running.pid)) and len(found) == 2 and (self.folder / "run" / "checkpoints").exists()
                        and list((self.folder / "run" / "checkpoints").iterdir()) and found)
        os.kill(pids[1], signal.SIGSTOP)
        said = running.communicate(timeout=60)[1]
        self.assertEqual(running.returncode, 3, said)
        self.assertRegex(said, r"rank 1 \(tile 1\) on .* has given no sign of life")
        wait_for(lambda: not any(is_running(pid) for pid in pids), 3)
        ended = self.run_to_the_end("run", *end, "--tiles", "2", "--resume")
        self.assertEqual(ended.returncode, 0, ended.stderr)

    def test_starts_as_many_ranks_as_the_machines_take(self):
        hosts = self.folder / "hosts"
        hosts.write_text("localhost slots=2\n")
        for ranks, code in ((2, 0), (3, 1)):
            ended = self.run_to_the_end(f"on{ranks}", "--set", "case.end_time=0.02", "--tiles", str(ranks), "--hosts", str(hosts))
            self.assertEqual(ended.returncode, code, ended.stderr)
        self.assertIn("not enough slots", ended.stderr)

    def test_refuses_what_it_cannot_compute(self):
        for case, more, text in (("embankment_seepage", ["--tiles", "2", "--fluid", "mine"], "--tiles 2: expected poretwin's own fluid solver, found --fluid"),
                                 ("infiltration_vertical", ["--tiles", "2", "--set", "fluid.representation=\"field\""], "found fluid.representation"),
                                 ("column_collapse", ["--tiles", "0"], "--tiles"),
                                 ("column_collapse", ["--tiles", "2", "--solid", "mine"], "--solid"),
                                 ("column_collapse", ["--hosts", __file__], "--hosts: machines for the processes of --tiles: expected --tiles P"),
                                 ("column_collapse", ["--tiles", "2", "--hosts", "nowhere"], "--hosts: File does not exist: nowhere"),
                                 ("footing", ["--tiles", "2"], "[[plate]]")):
            with self.subTest(case=case, more=more):
                ended = self.run_to_the_end("refused", *more, case=case)
                self.assertEqual(ended.returncode, 2, ended.stderr)
                self.assertIn(text, ended.stderr)
                if text != "[[plate]]":
                    self.assertFalse((self.folder / "refused").exists())

    def test_names_the_rank_that_fails(self):
        ended = self.run_to_the_end("failed", "--tiles", "2", "--set", "solid.initial_velocity=[500, 0]")
        self.assertNotEqual(ended.returncode, 0)
        self.assertIn("the soil diverged", ended.stderr)


class TilesBesideSoil(Runs):
    """Water that two processes share, beside soil that moves: terzaghi with 100 particles."""

    def start(self, out, *more, end):
        return subprocess.Popen([program, "run", str(sources / "cases" / "terzaghi"), "--out", str(self.folder / out), "--no-pictures",
                                 "--set", "fluid.particle_spacing=0.02", "--set", "solid.particle_spacing=0.02",
                                 "--set", f"case.end_time={end}", *more], stderr=subprocess.PIPE, text=True)

    def run_to_the_end(self, out, *more, **which):
        running = self.start(out, *more, **which)
        said = running.communicate(timeout=280)[1]
        self.assertEqual(running.returncode, 0, said)

    def expect_same(self, one, other):
        """Equal as far as the solve with a skeleton goes, which ends at a residual of 1e-2 of what a window changes: measured 2e-4 of the water's velocity, and
        1e-5 of the others."""
        for phase, field, allowed in (("fluid", "pore_pressure", 1e-3), ("fluid", "velocity", 1e-2), ("solid", "displacement", 1e-3),
                                      ("solid", "effective_stress", 1e-3)):
            a, b = self.last_frame(one, field, phase), self.last_frame(other, field, phase)
            self.assertEqual(a.shape, b.shape)
            self.assertGreater(np.abs(a).max(), 0.0)
            self.assertLessEqual(np.abs(a - b).max(), allowed * np.abs(a).max(), field)

    def test_gives_the_results_of_one_process(self):
        self.run_to_the_end("one", end=0.1)
        self.run_to_the_end("two", "--tiles", "2", end=0.1)
        self.expect_same("one", "two")
        windows = [json.loads((self.folder / out / "coupler.summary.json").read_text())["steps"]["windows"] for out in ("one", "two")]
        self.assertEqual(*windows)

    def running(self, out, *more, **which):
        """A run by two processes that has written a checkpoint, with the ids of its ranks and of the solid."""
        running = self.start(out, "--tiles", "2", "--checkpoint-every", "0.1", *more, **which)
        checkpoints = self.folder / out / "checkpoints"
        wait_for(lambda: checkpoints.exists() and list(checkpoints.iterdir()))
        return running, ranks_below(running.pid, "poretwin-fluid"), child_named(running.pid, "poretwin-solid")

    def end_of(self, running, pids, since):
        """What the run says. All its processes end, in 2 to 4 s where others keep the machine busy."""
        said = running.communicate(timeout=60)[1]
        self.assertEqual(len(pids), 3)
        self.assertLess(time.monotonic() - since, 10.0)
        wait_for(lambda: not any(is_running(pid) for pid in pids), 3)
        return said

    def test_stopped_goes_on(self):
        running, ranks, solid = self.running("run", end=0.3)
        start = time.monotonic()
        running.send_signal(signal.SIGINT)
        said = self.end_of(running, [*ranks, solid], start)
        self.assertEqual(running.returncode, 130, said)
        self.run_to_the_end("run", "--tiles", "2", "--resume", end=0.3)
        self.run_to_the_end("whole", end=0.3)
        self.expect_same("run", "whole")

    def test_ends_when_a_rank_or_the_solid_dies(self):
        for dies in ("rank", "solid"):
            with self.subTest(dies=dies):
                running, ranks, solid = self.running(dies, "--restarts", "0", end=3)
                start = time.monotonic()
                os.kill(ranks[1] if dies == "rank" else solid, signal.SIGKILL)
                said = self.end_of(running, [*ranks, solid], start)
                # 3: the other rank missed its signs of life before mpirun heard of its death.
                self.assertIn(running.returncode, (1, 3) if dies == "rank" else (1,), said)
                self.assertIn("rank 1" if dies == "rank" else "solid was killed by signal 9", said)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
