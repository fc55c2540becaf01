"""A run of poretwin in a benchmark: its gauges, its exit code, its run times."""
import contextlib
import csv
import json
import os
import pathlib
import signal
import subprocess
import tempfile
import time

import numpy as np

PROGRAMS = ["poretwin", "poretwin-fluid", "poretwin-pore", "poretwin-joint", "poretwin-solid", "poretwin-coupler"]  # programs of a build, in bin/
PROGRAM = pathlib.Path(__file__).resolve().parent.parent / "build" / "release" / "bin" / "poretwin"


class Run:
    """Makes the run. Arguments: threads of each solver, None: all cores; folder: kept after the run, None: a temporary folder.
    Results: exit: exit code (124: stopped after `longest` seconds); reason: messages of the run; gauges: {name: (times, values)};
    summaries: {process: its summary}; cpu: CPU seconds of all processes; wall: wall-clock seconds; trace: events of the time line,
    only with `profile`."""

    def __init__(self, case, overrides, program=PROGRAM, longest=None, profile=False, threads=None, folder=None):
        with contextlib.nullcontext(folder) if folder else tempfile.TemporaryDirectory() as folder:
            command = [program, "run", case, "--out", folder, "--no-pictures", "--quiet", "--restarts", "0"] + ["--profile"] * profile
            for text in overrides:
                command += ["--set", text]
            env = os.environ | ({"OMP_NUM_THREADS": str(threads)} if threads else {})
            begin = time.monotonic()
            with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, env=env) as process:
                try:
                    self.reason = process.communicate(timeout=longest)[1].strip()
                    self.exit = process.returncode
                except subprocess.TimeoutExpired:
                    process.send_signal(signal.SIGINT)  # poretwin then ends its processes
                    process.communicate()
                    self.exit, self.reason = 124, f"stopped after {longest:g} s"
            self.wall = time.monotonic() - begin
            folder = pathlib.Path(folder)
            self.summaries = {path.name.split(".")[0]: json.loads(path.read_text())
                              for path in folder.glob("*.summary.json")}
            self.cpu = sum(summary["cpu_s"] for summary in self.summaries.values())
            self.trace = json.loads((folder / "trace.json").read_text())["traceEvents"] if profile else []
            rows = {}
            if (folder / "gauges.csv").exists():
                with open(folder / "gauges.csv") as stream:
                    for row in csv.DictReader(stream):
                        rows.setdefault(row["gauge"], []).append((float(row["time_s"]), float(row["value"])))
            self.gauges = {name: np.array(pairs).T for name, pairs in rows.items()}

    def counter(self, process, name):
        return self.summaries.get(process, {}).get("counters", {}).get(name, 0.0)
