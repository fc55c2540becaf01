#!/usr/bin/python3
"""Runs scenes that are extreme for one phase alone (bench/extremes.toml): disorder, impacts, near-vacuum, large ratios of permeability and
stiffness, thin films, single particles, coarse and fine spacings, a million steps of rest; some in 3D. Writes OUT/extremes.csv and prints a
table. For both phases together: bench/stress.py.

    bench/extremes.py                  runs all scenes to their ends
    bench/extremes.py --short disorder runs the short forms of the scenes with this word in their names

Verdicts: a run that ends by itself is `bounded` if all values of its gauges are within their bounds, otherwise `unbounded`. A run may also be
`refused` before its first window, have `diverged`, or be `too slow` (--longest). Exit code 1 if a run was neither bounded nor refused.
"""
import argparse
import math
import pathlib
import sys
import tempfile
import tomllib

from plot import write_csv
from runs import PROGRAM, Run

ENTRIES = tomllib.loads((pathlib.Path(__file__).with_suffix(".toml")).read_text())
KINDS = {"speed": "max_speed", "particles": "particles", "energy": "energy"}
OWN_KINDS = {"fluid": {"lowest": "min_pressure"}, "solid": {}}


def gauges(phase):
    return "".join(f'[[gauge]]\nname = "{name}"\nphase = "{phase}"\nkind = "{kind}"\n'
                   for name, kind in (KINDS | OWN_KINDS[phase]).items())


def complaints(run, entry):
    readings = {name: [value for value in values if not math.isnan(value)] for name, (_, values) in run.gauges.items()}
    for name, (low, high) in entry.get("bounds", {}).items():
        if not (low <= min(readings[name]) and max(readings[name]) <= high):
            yield f"{name} {min(readings[name]):.4g} .. {max(readings[name]):.4g}, expected {low:g} .. {high:g}"
    for name, most in entry.get("gains", {}).items():
        if (gain := max(readings[name]) - readings[name][0]) > most:
            yield f"{name} gained {gain:.4g}, expected {most:g} at most"


def judged(phase, name, entry, settings, a):
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "case.toml"
        path.write_text(entry["case"] + gauges(phase))
        run = Run(path, settings, a.program, a.longest)
    why = run.reason.replace(str(path), "case.toml") if run.exit not in (0, 6) else "; ".join(complaints(run, entry))
    verdict = {0: "unbounded" if why else "bounded", 2: "refused", 4: "diverged", 124: "too slow"}.get(
        0 if run.exit == 6 else run.exit, f"exit {run.exit}")  # 6: the run ended, with warnings that put the result in doubt
    steps = run.counter(phase, "substeps") or run.counter(phase, "windows")
    return {"phase": phase, "what": name, "verdict": verdict, "particles": int(run.counter(phase, "particles")), "steps": int(steps),
            "cpu_s": round(run.cpu, 2), "why": " ".join(why.split())}


def table(rows):
    """The results as a Markdown table."""
    lines = ["| phase | what | verdict | particles | steps | CPU s | why |", "| --- | --- | --- | --- | --- | --- | --- |"]
    return lines + ["| " + " | ".join(str(value) for value in row.values()) + " |" for row in rows]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help="parts of names; none: all")
    parser.add_argument("--short", action="store_true", help="the form that the tests run")
    parser.add_argument("--longest", type=float, default=300.0, help="s, of one run")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("runs/bench"))
    parser.add_argument("--program", default=PROGRAM)
    a = parser.parse_args()
    rows = []
    for phase, entries in ENTRIES.items():
        for name, entry in entries.items():
            if a.names and not any(part in f"{phase} {name}" for part in a.names):
                continue
            for spacing in entry.get("spacings", [None]):
                settings = [f"{phase}.particle_spacing={spacing}"] * (spacing is not None) + entry["short"] * a.short
                rows.append(judged(phase, name if spacing is None else f"{name}: {spacing:g} m", entry, settings, a))
                print("{phase}, {what}: {verdict} ({particles} particles, {steps} steps, {cpu_s} CPU s) {why}".format(**rows[-1]), flush=True)
    if not rows:
        parser.error(f"no such name; expected parts of: {', '.join(name for entries in ENTRIES.values() for name in entries)}")
    write_csv(a.out / "extremes.csv", rows)
    print("\n".join(table(rows)))
    sys.exit(any(row["verdict"] not in ("bounded", "refused") for row in rows))


if __name__ == "__main__":
    main()
