#!/usr/bin/python3
"""Error of the fluid solver against resolution and against run time, by scheme: build/bench/CASE.csv and CASE.png.

    bench/run.py                                  all cases below
    bench/run.py dam_break --schemes projection   one case, one scheme
    bench/run.py infiltration_vertical --spacings 0.02 0.01 0.005

Errors are those of the case's own `verify`: every metric of the run is in the CSV, the first is drawn. Run time is CPU
seconds of all processes. A run that takes longer than --longest is stopped, and so are the finer ones of its scheme.
"""
import argparse
import json
import pathlib
import subprocess
import tempfile

from plot import error_curves, write_csv

ROOT = pathlib.Path(__file__).resolve().parent.parent
# case: spacings [m], coarse to fine
CASES = {
    "hydrostatic_tank": [0.1, 0.05, 0.025],
    "infiltration_vertical": [0.02, 0.01, 0.005],
    "rectangular_dam": [0.04, 0.02, 0.01],
    "confined_flow": [0.04, 0.02, 0.01],
    "dam_break": [0.08, 0.04, 0.02],
    "embankment_seepage_rigid": [0.02, 0.01, 0.005],
}


def first_run(case):
    """Name of the first run in the case's verify.toml."""
    text = (ROOT / "cases" / case / "verify.toml").read_text()
    head = text.split("[[run]]", 1)
    return head[1].split("name = \"", 1)[1].split("\"", 1)[0] if len(head) > 1 else None


def measure(program, case, scheme, spacing, longest):
    """Rows of one run, one per metric; nothing when it took too long."""
    with tempfile.TemporaryDirectory() as folder:
        result = pathlib.Path(folder) / "result.json"
        command = [program, "verify", case, "--json", result, "--out", folder]
        command += ["--set", f'fluid.scheme="{scheme}"', "--set", f"fluid.particle_spacing={spacing}"]
        if name := first_run(case):
            command += ["--run", name]
        try:
            subprocess.run(command, cwd=ROOT, timeout=longest, stdout=subprocess.DEVNULL, check=False)
        except subprocess.TimeoutExpired:
            return []
        verdict = json.loads(result.read_text())
    return [{"case": case, "scheme": scheme, "spacing_m": spacing, "metric": metric["name"], "error": metric["error"],
             "bound": metric["tolerance"], "cpu_s": round(verdict["cpu_s"], 3),
             "windows": sum(n for key, n in verdict["steps"].items() if key == "fluid.windows"),
             "particles": verdict["particles"].get("fluid")} for metric in verdict["metrics"]]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", nargs="*", metavar="CASE", help=f"default: {', '.join(CASES)}")
    parser.add_argument("--schemes", nargs="+", default=["projection", "eisph"])
    parser.add_argument("--spacings", nargs="+", type=float, help="m, coarse to fine; default: the case's own")
    parser.add_argument("--longest", type=float, default=600.0, help="wall-clock seconds of a run (default 600)")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "build" / "bench")
    parser.add_argument("--program", default=str(ROOT / "build" / "release" / "bin" / "poretwin"))
    a = parser.parse_args()
    for case in a.cases:
        if not (ROOT / "cases" / case / "verify.toml").exists():
            parser.error(f"{case}: there is no cases/{case}/verify.toml to take errors from")
    for case in a.cases or [name for name in CASES if (ROOT / "cases" / name / "verify.toml").exists()]:
        rows = []
        for scheme in a.schemes:
            for spacing in a.spacings or CASES.get(case) or parser.error(f"{case}: give --spacings"):
                found = measure(a.program, case, scheme, spacing, a.longest)
                if not found:
                    print(f"{case} {scheme} {spacing} m: stopped after {a.longest:g} s")
                    break
                rows += found
                print("{case} {scheme} {spacing_m} m: {metric} {error}, {cpu_s} CPU s".format(**found[0]), flush=True)
        if not rows:
            continue
        write_csv(a.out / f"{case}.csv", rows)
        drawn = [row for row in rows if row["metric"] == rows[0]["metric"]]
        error_curves(a.out / f"{case}.png", f"{case}: {rows[0]['metric']}", drawn,
                     {"spacing_m": "particle spacing [m]", "cpu_s": "run time [CPU s]"}, bound=rows[0]["bound"])


if __name__ == "__main__":
    main()
