#!/usr/bin/python3
"""Error against resolution and against run time, by scheme: OUT/CASE.csv, OUT/CASE.png and one page, OUT/performance.md.

    poretwin bench                                      every study of bench/studies.toml
    poretwin bench rectangular_dam --schemes default    one case, one scheme
    poretwin bench terzaghi --spacings 0.02 0.002

Errors are those of the case's own `verify`: every metric is in the CSV, one is drawn. Run time is CPU seconds of all
processes, the median of --repeats runs; wall-clock seconds stand beside it. All that is compared is measured in one go.
A scheme's finer runs are left out once one has taken longer than --longest.
"""
import argparse
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile
import tomllib

from plot import error_curves, write_csv

HERE = pathlib.Path(__file__).resolve().parent


def verified(program, case, study, settings, longest):
    """The verdict of one run of `verify`, or None when it took too long or did not end well."""
    with tempfile.TemporaryDirectory() as folder:
        result = pathlib.Path(folder) / "result.json"
        command = [program, "verify", case, "--json", result, "--out", folder]
        if "run" in study:
            command += ["--run", study["run"]]
        for setting in settings:
            command += ["--set", setting]
        try:
            done = subprocess.run(command, timeout=longest, capture_output=True, text=True, check=False)
        except subprocess.TimeoutExpired:
            print(f"{case}: stopped after {longest:g} s", flush=True)
            return None
        if not result.exists():
            sys.exit(f"{case}: {done.stderr.strip() or done.stdout.strip()}")
        return json.loads(result.read_text())


def measured(a, case, study, scheme, spacing):
    """One row per metric of the run at this spacing in this scheme."""
    settings = [*study.get("set", []), f'{study["spacing"]}={spacing}', *study["schemes"][scheme]]
    verdicts = []
    for _ in range(a.repeats):
        verdict = verified(a.program, case, study, settings, a.longest)
        if verdict is None:
            return []
        verdicts.append(verdict)
    last = verdicts[-1]
    windows = max((n for key, n in last["steps"].items() if key.endswith(".windows")), default=0)
    return [{"case": case, "scheme": scheme, "spacing": spacing, "metric": metric["name"], "error": metric["error"],
             "bound": metric["tolerance"], "cpu_s": round(statistics.median(v["cpu_s"] for v in verdicts), 3),
             "wall_s": round(statistics.median(v["wall_s"] for v in verdicts), 3), "windows": int(windows),
             "particles": int(sum(last["particles"].values()))} for metric in last["metrics"]]


def is_front(row, rows):
    """Does no other run have a smaller error in less time?"""
    return row["error"] is not None and not any(
        other["error"] is not None and other["error"] < row["error"] and other["cpu_s"] < row["cpu_s"]
        for other in rows)


def page(drawn, studies):
    """One table per case, Markdown; `*` marks the runs that no other one beats in error and time at once."""
    lines = ["# Error against run time", "",
             "Made by `poretwin bench`: the error of each case's own `verify`, CPU and wall-clock seconds of all processes.",
             "`*`: no other run of the case has a smaller error in less time. A dash: the run did not end."]
    for case, rows in drawn.items():
        axis = "exchange interval [s]" if studies[case]["spacing"].startswith("coupling") else "spacing [m]"
        lines += ["", f"## {case}", "", f"{rows[0]['metric']} (asked: {rows[0]['bound']:g})", "", f"![](bench/{case}.png)",
                  "", f"| scheme | {axis} | error | CPU s | wall s | windows | particles | |",
                  "| --- | --- | --- | --- | --- | --- | --- | --- |"]
        for row in rows:
            error = "-" if row["error"] is None else f"{row['error']:.2g}"
            lines.append(f"| {row['scheme']} | {row['spacing']:g} | {error} | {row['cpu_s']:.2f} | {row['wall_s']:.2f} "
                         f"| {row['windows']} | {row['particles']} | {'*' if is_front(row, rows) else ''} |")
    return "\n".join(lines) + "\n"


def main():
    studies = tomllib.loads((HERE / "studies.toml").read_text())
    parser = argparse.ArgumentParser(prog="poretwin bench", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", nargs="*", metavar="CASE", help=f"default: {', '.join(studies)}")
    parser.add_argument("--schemes", nargs="+", help="default: all of the study")
    parser.add_argument("--spacings", nargs="+", type=float, help="coarse to fine; default: the study's own")
    parser.add_argument("--repeats", type=int, default=1, help="runs of which the median is taken (default 1)")
    parser.add_argument("--longest", type=float, default=600.0, help="wall-clock seconds of a run (default 600)")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("runs/bench"))
    parser.add_argument("--program", default="poretwin", help=argparse.SUPPRESS)
    a = parser.parse_args()
    drawn = {}
    for case in a.cases or studies:
        if case not in studies:
            parser.error(f"{case}: no such study; expected one of: {', '.join(studies)}")
        study, rows = studies[case], []
        for scheme in a.schemes or study["schemes"]:
            if scheme not in study["schemes"]:
                parser.error(f"{case} has no scheme '{scheme}'; expected one of: {', '.join(study['schemes'])}")
            for spacing in a.spacings or study["spacings"]:
                found = measured(a, case, study, scheme, spacing)
                if not found:
                    break
                rows += found
                first = next((row for row in found if row["metric"] == study.get("metric")), found[0])
                print("{case}, {scheme}, {spacing:g}: {metric} {error}, {cpu_s} CPU s".format(**first), flush=True)
        if not rows:
            continue
        metric = study.get("metric", rows[0]["metric"])
        write_csv(a.out / f"{case}.csv", rows)
        drawn[case] = [row for row in rows if row["metric"] == metric]
        error_curves(a.out / f"{case}.png", f"{case}: {metric}", drawn[case],
                     {"spacing": study["spacing"], "cpu_s": "run time [CPU s]"}, bound=drawn[case][0]["bound"])
    a.out.mkdir(parents=True, exist_ok=True)
    (a.out / "performance.md").write_text(page(drawn, studies))
    print(f"tables, pictures and performance.md: {a.out}")


if __name__ == "__main__":
    main()
