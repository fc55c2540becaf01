#!/usr/bin/python3
"""Measures the time that the solvers save by skipping work, and the error that skipping causes. Writes OUT/skipping.csv and
prints a table.

    bench/skipping.py                       measures every entry of skipping.toml
    bench/skipping.py "dry soil" --repeats 5

Each entry is run with skipping and with skipping switched off, alternately. CPU seconds are those of all processes, the median
over the repeats. Errors are the differences of the named gauges between the two runs, divided by the gauges' scales, at the
times of the run that skips.
"""
import argparse
import pathlib
import statistics
import tempfile
import tomllib

import numpy as np

from plot import write_csv
from runs import PROGRAM, Run

HERE = pathlib.Path(__file__).resolve().parent
ENTRIES = tomllib.loads((HERE / "skipping.toml").read_text())


def run(program, case, addition, settings, folder):
    """Makes one run of a case with these settings (--set); `addition` is appended to its case file."""
    text = (HERE.parent / "cases" / case / "case.toml").read_text()
    path = pathlib.Path(folder) / "case.toml"
    path.write_text(text + addition)
    done = Run(path, settings, program)
    if done.exit != 0:
        raise SystemExit(f"{case} with {settings}: {done.reason}")
    return done


def series(done, name):
    """{gauge: (times, values)} of the gauge with this name; for a gauge with several points, of each point `name[i]`."""
    found = {key: value for key, value in done.gauges.items() if key == name or key.startswith(f"{name}[")}
    if not found:
        raise SystemExit(f"no gauge '{name}'")
    return found


def difference(skipped, computed, gauges, after):
    """Differences of the gauges between the two runs, over the gauges' scales: root mean square over all points and times, and
    largest value. after [s]: earlier times are left out."""
    gaps = []
    for name, scale in gauges.items():
        pairs = [(value, series(computed, name)[key]) for key, value in series(skipped, name).items()]
        scale = scale or max(np.abs(values[np.isfinite(values)]).max(initial=0.0) for _, (_, values) in pairs)
        for (times, values), (others, reference) in pairs:
            chosen = (times >= after) & (times <= others[-1])
            gap = np.abs(values[chosen] - np.interp(times[chosen], others, reference)) / scale
            gaps.append(gap[np.isfinite(gap)])  # only times at which both runs have a value
    gaps = np.concatenate(gaps)
    return float(np.sqrt(np.mean(gaps**2))), float(gaps.max())


def measured(program, name, entry, repeats):
    both, add = entry.get("set", []), entry.get("add", "")
    skipped, computed = [], []
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(repeats):
            skipped.append(run(program, entry["case"], add, both + entry.get("only_skipped", []), folder))
            computed.append(run(program, entry.get("computed_case", entry["case"]), add + entry.get("computed_add", ""),
                                both + entry.get("computed", []), folder))
    less, more = (statistics.median(done.cpu for done in runs) for runs in (skipped, computed))
    rms, largest = difference(skipped[-1], computed[-1], entry["gauges"], entry.get("after", 0.0))
    return {"skipped": name, "what": entry["what"], "case": entry["case"], "cpu_s": round(less, 3),
            "cpu_s_computed": round(more, 3), "error": float(f"{rms:.2g}"), "largest": float(f"{largest:.2g}")}


def measure_all(program, repeats, names=()):
    rows = []
    for name in names or ENTRIES:
        rows.append(measured(program, name, ENTRIES[name], repeats))
        print(rows[-1], flush=True)
    return rows


def table(rows):
    """The results as a Markdown table."""
    lines = ["| skipped | what | case | CPU s | computed | saved | error, rms | largest |",
             "| --- | --- | --- | --- | --- | --- | --- | --- |"]
    for r in rows:
        saved = 100.0 * (1.0 - r["cpu_s"] / r["cpu_s_computed"])
        lines.append(f"| {r['skipped']} | {r['what']} | {r['case']} | {r['cpu_s']:.2f} | {r['cpu_s_computed']:.2f} "
                     f"| {saved:.0f} % | {r['error']:.1g} | {r['largest']:.1g} |")
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(ENTRIES))
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("runs/bench"))
    parser.add_argument("--program", default=str(PROGRAM), help=argparse.SUPPRESS)
    a = parser.parse_args()
    rows = measure_all(a.program, a.repeats, a.names)
    write_csv(a.out / "skipping.csv", rows)
    print("\n".join(table(rows)), f"\n\ntable: {a.out}/skipping.csv")


if __name__ == "__main__":
    main()
