#!/usr/bin/python3
"""Measures the time that the coupling costs besides the solvers' own work, from the time line of `poretwin run --profile`. Writes
overhead.csv.

Every instant of a run counts for one activity: computing if a process computes, else writing, checkpointing, mapping or sending
(in this order), else `nobody`. Columns of the table:

    overhead            (mapping + sending + nobody) / whole time. In a serial schedule one solver computes while the other waits;
                        this is no overhead
    over the critical   whole time / (whole time - nobody): the run time over the time that it would take if activities that
    path                depend on each other followed each other without a gap
    fluid waits,        time in which this solver waits for the other solver or for the coupler, over the whole time
    solid waits
    both                time in which both solvers compute, over the whole time

The first two scenes are a column of 3000 particles (cases/terzaghi) with an exchange at every substep of the soil, by the serial
and by the parallel scheme (docs/theory/coupling.md, "Other schemes"). The others are cases/embankment_seepage and, to its end,
cases/embankment_failure, with windows that the solvers choose. --trace evaluates an existing time line. On a busy machine the time
in which a process waits for a processor core may count as `nobody`, too; therefore the shortest of --repeat runs is reported.
"""
import argparse
import collections
import json
import pathlib

from plot import write_csv
from runs import PROGRAM, Run

COLUMN = ["fluid.particle_spacing=0.00516", "solid.particle_spacing=0.00516", "coupling.interval=6e-5", "case.end_time=0.018",
          "output.interval=0", "output.gauge_interval=0.01"]
SCENES = {
    "3000 particles, every substep": ("terzaghi", COLUMN),
    "the same, parallel": ("terzaghi", COLUMN + ["coupling.scheme=\"parallel\""]),
    "embankment_seepage, own windows": ("embankment_seepage", ["case.end_time=300"]),
    "embankment_failure, whole": ("embankment_failure", []),
}
ACTIVITIES = ["computing", "writing", "checkpointing", "mapping", "sending", "nobody"]
OVERLAP = ["fluid waits", "solid waits", "both"]


def shares(events):
    """Seconds of each activity, from the mapping of the second window to that of the last window."""
    spans = [(e["ts"], e["ts"] + e["dur"], e["name"]) for e in events if e["ph"] == "X" and e["name"] in ACTIVITIES]
    mapped = sorted(begin for begin, _, name in spans if name == "mapping")
    first, last = mapped[min(4, len(mapped) - 1)], mapped[-1]
    edges = sorted(edge for begin, end, name in spans
                   for edge in ((min(max(begin, first), last), 1, name), (min(max(end, first), last), -1, name)))
    under_way, seconds, now = collections.Counter(), collections.Counter(), first
    for time, step, name in edges:
        who = next((activity for activity in ACTIVITIES if under_way[activity] > 0), "nobody")
        seconds[who] += 1e-6 * (time - now)
        seconds["both"] += 1e-6 * (time - now) * (under_way["computing"] > 1)
        under_way[name] += step
        now = time
    names = {e["pid"]: e["args"]["name"] for e in events if e["name"] == "process_name"}
    for e in events:
        if e["ph"] == "X" and e["name"] == "waiting":
            seconds[f"{names[e['pid']]} waits"] += 1e-6 * max(0.0, min(e["ts"] + e["dur"], last) - max(e["ts"], first))
    return seconds


def judged(scene, events, windows):
    seconds = shares(events)
    whole = sum(seconds[name] for name in ACTIVITIES)
    overhead = seconds["mapping"] + seconds["sending"] + seconds["nobody"]
    return {"scene": scene, "windows": windows, "wall_s": round(whole, 4), **{name: round(seconds[name], 4) for name in ACTIVITIES},
            "overhead": round(overhead / whole, 4), "critical_path": round(whole / (whole - seconds["nobody"]), 4),
            **{name: round(seconds[name], 4) for name in OVERLAP}}


def table(rows):
    """The results as a Markdown table."""
    lines = ["| scene | windows | wall s | " + " | ".join(ACTIVITIES) + " | overhead | over the critical path | " + " | ".join(OVERLAP) + " |",
             "| --- " * (len(ACTIVITIES) + len(OVERLAP) + 5) + "|"]
    for row in rows:
        parts = " | ".join(f"{100 * row[name] / row['wall_s']:.1f} %" for name in ACTIVITIES)
        lines.append(f"| {row['scene']} | {row['windows']} | {row['wall_s']:.2f} | {parts} | {100 * row['overhead']:.1f} % | {row['critical_path']:.3f} | "
                     + " | ".join(f"{100 * row[name] / row['wall_s']:.1f} %" for name in OVERLAP) + " |")
    return lines


def measure_all(program, repeats):
    rows = []
    for scene, (case, settings) in SCENES.items():
        runs = []
        for _ in range(repeats):
            run = Run(case, settings, program, profile=True)
            if run.exit != 0:
                raise SystemExit(f"{case}: exit {run.exit}: {run.reason}")
            runs.append(judged(scene, run.trace, int(run.summaries["coupler"]["steps"]["windows"])))
            print(runs[-1], flush=True)
        rows.append(min(runs, key=lambda row: row["wall_s"]))
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trace", type=pathlib.Path, nargs="+", help="judge these time lines, run nothing")
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("runs/bench"))
    parser.add_argument("--program", default=PROGRAM, help=argparse.SUPPRESS)
    a = parser.parse_args()
    rows = [judged(str(path), json.loads(path.read_text())["traceEvents"], "") for path in a.trace or []]
    rows = rows or measure_all(a.program, a.repeat)
    write_csv(a.out / "overhead.csv", rows)
    print("\n".join(table(rows)))


if __name__ == "__main__":
    main()
