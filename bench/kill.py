#!/usr/bin/python3
"""Kills one of the three processes of a coupled run at a random moment, resumes the run, and compares its results with those of
an undisturbed run, bit by bit. This trial is repeated --moments times.

    bench/kill.py [--moments 60] [--programs build/release/bin] [--seed 1] [CASE [options of poretwin run]...]

In every other trial `poretwin run` restarts the processes by itself; in the others the run is started again with --resume. A
trial passes when the results are equal, no process hangs, and no process, socket or shared memory remains."""

import argparse
import os
import pathlib
import random
import re
import signal
import subprocess
import sys
import tempfile
import time

import h5py
import numpy as np

DEFAULT = ["terzaghi", "--set", "case.end_time=0.3", "--set", "output.interval=0.004"]
PATIENCE = 60.0  # s: a run, which takes some seconds, hangs if it takes longer than this


def content(path):
    """All data in a file of particles, except its provenance (which program wrote it, and when)."""
    found = {}

    def take(name, item):
        if name.startswith("provenance"):
            return
        for key, value in item.attrs.items():
            found[f"{name}@{key}"] = np.asarray(value).tobytes()
        if isinstance(item, h5py.Dataset):
            found[name] = (item.shape, np.asarray(item[()]).tobytes())

    with h5py.File(path, "r") as file:
        file.visititems(take)
    return found


def differences(one, other):
    """Names of the files and data that differ between two run folders."""
    bad = []
    for file in sorted(one.iterdir()):
        twin = other / file.name
        if file.suffix in (".vtkhdf", ".csv", ".xmf") and not twin.exists():
            bad.append(file.name)
        elif file.suffix == ".vtkhdf":
            a, b = content(file), content(twin)
            bad += [f"{file.name}:{key}" for key in sorted(a.keys() | b.keys()) if a.get(key) != b.get(key)]
        elif file.suffix in (".csv", ".xmf") and file.read_bytes() != twin.read_bytes():
            bad.append(file.name)
    return bad


def processes_of(out):
    """Ids of the processes that were started with this folder, by name of the program."""
    found = {}
    for entry in pathlib.Path("/proc").iterdir():
        try:
            words = (entry / "cmdline").read_bytes().split(b"\0")
        except (OSError, NotADirectoryError):
            continue
        if str(out).encode() in words:
            found.setdefault(pathlib.Path(words[0].decode()).name, []).append(int(entry.name))
    return found


class Trials:
    def __init__(self, arguments, folder):
        self.poretwin = str(pathlib.Path(arguments.programs).resolve() / "poretwin")
        self.case = arguments.case or DEFAULT
        self.folder = folder
        self.temporary = folder / "temporary"
        self.temporary.mkdir()
        self.random = random.Random(arguments.seed)
        self.shared = set(os.listdir("/dev/shm"))
        start = time.monotonic()
        self.start(folder / "reference", []).wait(timeout=10 * PATIENCE)
        self.whole = time.monotonic() - start

    def start(self, out, more):
        command = [self.poretwin, "run", *self.case, "--out", str(out), "--no-pictures", "--quiet", *more]
        return subprocess.Popen(command, stderr=open(f"{out}.err", "a"), stdout=subprocess.DEVNULL,
                                env={**os.environ, "TMPDIR": str(self.temporary)})

    def kill(self, out, victim, moment):
        """Kills the process `victim` after `moment` seconds; False where it had already ended."""
        time.sleep(moment)
        for _ in range(100):
            ids = processes_of(out).get(f"poretwin-{victim}")
            if ids:
                os.kill(ids[0], signal.SIGKILL)
                return True
            if not processes_of(out):
                return False
            time.sleep(0.01)
        return False

    def complaint(self, out, run, restarts, killed):
        """Waits for the end of a run, and resumes it where it does not restart by itself. Returns a text that says what went
        wrong, or an empty text."""
        try:
            code = run.wait(timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            run.kill()
            return "hangs"
        said = pathlib.Path(f"{out}.err").read_text()
        if killed and not re.search("killed by signal 9", said):
            return f"the cause is not named: {said}"
        if restarts or code == 0:
            return f"exit code {code}: {said}" if code else ""
        # A run that was killed before its first checkpoint refuses --resume, and is started from time zero.
        again = self.start(out, ["--resume"])
        code = again.wait(timeout=PATIENCE)
        if code == 5 and "nothing to resume" in pathlib.Path(f"{out}.err").read_text():
            self.unborn += 1
            code = self.start(out, []).wait(timeout=PATIENCE)
        return f"exit code {code} of --resume: {pathlib.Path(f'{out}.err').read_text()}" if code else ""

    def left_behind(self, out):
        found = [f"process {name}" for name in processes_of(out)]
        found += [f"temporary {name}" for name in os.listdir(self.temporary)]
        found += [f"shared memory {name}" for name in set(os.listdir("/dev/shm")) - self.shared]
        return found

    unborn = 0

    def trial(self, k):
        while True:
            out = self.folder / f"trial{k}"
            restarts = k % 2 == 0
            victim = self.random.choice(["coupler", "fluid", "solid"])
            moment = self.random.uniform(0.0, self.whole)
            run = self.start(out, ["--checkpoint-every", "0.1", "--restarts", "2" if restarts else "0"])
            killed = self.kill(out, victim, moment)
            complaint = self.complaint(out, run, restarts, killed)
            if killed or complaint:
                break
        wrong = [complaint] if complaint else differences(self.folder / "reference", out)
        wrong += self.left_behind(out)
        how = "restarted by itself" if restarts else "resumed"
        print(f"{k + 1:3}  {victim:8} killed after {moment:5.2f} s, {how}: {'; '.join(wrong) or 'the same'}", flush=True)
        return not wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--moments", type=int, default=60)
    parser.add_argument("--programs", default="build/release/bin")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("case", nargs=argparse.REMAINDER)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        trials = Trials(arguments, pathlib.Path(folder))
        good = sum(trials.trial(k) for k in range(arguments.moments))
    print(f"{good} of {arguments.moments} moments: the same results, nothing left behind "
          f"({trials.unborn} were killed before the first checkpoint)")
    return 0 if good == arguments.moments else 1


if __name__ == "__main__":
    sys.exit(main())
