#!/usr/bin/python3
"""Compares two builds: runs the short form of every case with both, and reports whether their results are the same, bit by bit.

    bench/same.py OLD NEW [CASE ..] [--out DIR] [--checkpoints S]

OLD and NEW are build folders, or copies of them, with bin/ and share/poretwin/cases. Each build runs the cases in its own folder, so
that keys may have been renamed between the two builds. The program compares:

    gauges and the time lines of frames, byte by byte
    frames, data set by data set (HDF5 files also contain who wrote them and when)
    the numbers of windows, substeps and iterations
    the states in checkpoints, byte by byte, without their heads, which name the program

A run that ends well removes its checkpoints. Therefore each case's first run is started again with both builds, with a checkpoint
after every window, and stopped after --checkpoints seconds. Meanwhile the states are collected; those of the same windows are
compared.

The results below --out are kept, and used again if neither the programs of the build nor the case have changed.
Exit code: 0 no difference, 1 a difference, 2 nothing to compare.
"""
import argparse
import hashlib
import json
import pathlib
import shutil
import signal
import struct
import subprocess
import sys
import time
import tomllib

from kill import differences
from runs import PROGRAMS

NO_RESULTS = ("_s", "_bytes")  # endings of the names of counters that depend on run time or memory; they are not compared


def cases_of(build):
    return build / "share" / "poretwin" / "cases"


def fingerprint(build, case):
    digest = hashlib.sha256()
    for file in [build / "bin" / name for name in PROGRAMS] + sorted((cases_of(build) / case).glob("*.toml")):
        digest.update(file.read_bytes())
    return digest.hexdigest()


def verify(build, case, out):
    """Makes every short run of the case, below out / case. Whether errors are within their bounds does not matter here."""
    subprocess.run([build / "bin" / "poretwin", "verify", cases_of(build) / case, "--short", "--out", out],
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)


def state_in(data):
    """The state in a checkpoint, without its head: common/checkpoint/store.cpp."""
    at = data.index(b"\n") + 1 + 16  # first line, checksum

    def text():
        nonlocal at
        size, = struct.unpack_from("<Q", data, at)
        at += 8 + size
        return data[at - size:at]

    text()
    at += 16  # window, time
    pairs, = struct.unpack_from("<Q", data, at)
    at += 8
    for _ in range(2 * pairs):
        text()
    state = text()
    if at != len(data):
        raise ValueError("the layout of checkpoints is another")
    return state


def catch_checkpoints(build, case, out, seconds):
    """Runs the case's first short run for some seconds, and writes caught.json: digests of the states in its checkpoints, by process
    and window."""
    spec = tomllib.loads((cases_of(build) / case / "verify.toml").read_text())
    first = next((run for run in spec["run"] if run.get("when") != "full" and run.get("command", "run") == "run"), None)
    if first is None:
        return
    command = [build / "bin" / "poretwin", "run", cases_of(build) / case / first.get("case", "case.toml"), "--out", out / "run",
               "--quiet", "--no-pictures", "--checkpoint-every", "0", "--restarts", "0"]
    for assignment in first.get("set", []) + first.get("short", []):
        command += ["--set", assignment]
    caught, end = {}, time.monotonic() + seconds
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        while process.poll() is None and time.monotonic() < end:
            for file in (out / "run" / "checkpoints").glob("*.state"):
                process_name, _, window = file.stem.split("-")
                name = f"{process_name} {int(window)}"
                if name not in caught:
                    try:
                        caught[name] = hashlib.sha256(state_in(file.read_bytes())).hexdigest()
                    except FileNotFoundError:
                        pass  # the run has removed the file
            time.sleep(0.001)
        process.send_signal(signal.SIGINT)
    (out / "caught.json").write_text(json.dumps(caught))


def left_by(build, case, out, seconds):
    """Runs the case, unless results of the same build and case exist."""
    stamp, mark = out / "stamp", f"{fingerprint(build, case)} {seconds}"
    if stamp.exists() and stamp.read_text() == mark:
        return
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir(parents=True)
    verify(build, case, out)
    if seconds > 0:
        catch_checkpoints(build, case, out / "checkpoints", seconds)
    stamp.write_text(mark)


def counted(file):
    summary = json.loads(file.read_text())
    return {name: value for name, value in (summary["steps"] | summary["counters"]).items()
            if name != "checkpoints" and not name.startswith("bytes") and not name.endswith(NO_RESULTS)}


def compared(old, new, case):
    """The differences, the number of compared runs and the number of compared checkpoints."""
    bad, runs = [], 0
    folders = [{file.parent.relative_to(out) for file in (out / case).rglob("run.toml")} for out in (old, new)]
    for run in sorted(folders[0] | folders[1]):
        if run not in folders[0] & folders[1]:
            bad.append(f"{run}: of one build only")
            continue
        runs += 1
        names = [{file.name for file in (out / run).iterdir() if file.suffix in (".csv", ".vtkhdf", ".xmf")} for out in (old, new)]
        bad += [f"{run}/{name}: of one build only" for name in sorted(names[0] ^ names[1])]
        bad += [f"{run}/{what}" for what in differences(old / run, new / run)]
        for file in sorted((old / run).glob("*.summary.json")):
            one, other = counted(file), counted(new / run / file.name)
            bad += [f"{run}/{file.name}: {name}: {one.get(name)}, {other.get(name)}"
                    for name in sorted(one.keys() | other.keys()) if one.get(name) != other.get(name)]
    files = [out / "checkpoints" / "caught.json" for out in (old, new)]
    one, other = (json.loads(file.read_text()) if file.exists() else {} for file in files)
    states = len(one.keys() & other.keys())
    bad += [f"checkpoint of {name}" for name in one if one[name] != other.get(name, one[name])]
    return bad, runs, states


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old", type=pathlib.Path, metavar="OLD")
    parser.add_argument("new", type=pathlib.Path, metavar="NEW")
    parser.add_argument("cases", nargs="*", metavar="CASE", help="default: all that have a verify.toml")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("runs/same"), help="folder of the runs (default runs/same)")
    parser.add_argument("--checkpoints", type=float, default=5.0, metavar="S",
                        help="seconds for which checkpoints are caught (default 5); 0: none are compared")
    a = parser.parse_args()
    old, new, out = a.old.resolve(), a.new.resolve(), a.out.resolve()
    cases = a.cases or sorted(file.parent.name for file in cases_of(old).glob("*/verify.toml"))
    for case in cases:
        if not (cases_of(old) / case / "verify.toml").exists():
            parser.error(f"{case}: no such case below {cases_of(old)}, or none with a verify.toml")
    different, seen = False, 0
    for case in cases:
        left_by(old, case, out / "old" / case, a.checkpoints)
        left_by(new, case, out / "new" / case, a.checkpoints)
        bad, runs, states = compared(out / "old" / case, out / "new" / case, case)
        seen += runs
        different = different or bool(bad) or runs == 0
        verdict = "nothing to compare" if runs == 0 else f"{len(bad)} differences, such as {bad[0]}" if bad else "same"
        print(f"{case:<28} {runs:>3} runs {states:>4} checkpoints  {verdict}", flush=True)
    sys.exit(2 if seen == 0 else 1 if different else 0)


if __name__ == "__main__":
    main()
