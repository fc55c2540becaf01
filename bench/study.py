#!/usr/bin/python3
"""Measures the performance of poretwin: error against spacing and run time for several schemes, and speed of single parts.

    poretwin bench                                      measures everything: jobs, kernels, sizes, solve, coupling,
                                                        skipped, every study of studies.toml
    poretwin bench --page                               as above, and replaces the present page in docs/
    poretwin bench sizes                                measures one part; the page takes the other parts from OUT
    poretwin bench rectangular_dam --schemes default    measures one case with one scheme
    poretwin bench terzaghi --spacings 0.02 0.002       measures one case with these spacings

Writes OUT/CASE.csv and OUT/CASE.png for each study, and one page, OUT/performance.md. OUT is the folder of --out.

Errors are those that the case's own `verify` computes: the CSV contains every metric, the picture shows one. Run time is
CPU seconds of all processes, the median of --repeats runs; the tables give wall-clock seconds, too. Runs that are
compared are measured in one session. When a run of a scheme takes longer than --longest, the scheme's finer runs are left out.
"""
import argparse
import json
import math
import pathlib
import os
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import tomllib

import overhead
import scaling
import skipping
from plot import error_curves, write_csv
from runs import Run

HERE = pathlib.Path(__file__).resolve().parent
DOCS = HERE.parent / "docs"
# Speed of the plainest loop over pairs, one pair at a time, on the machine on which the public codes were timed: million
# directed pairs per CPU second (each pair counts once for each of its two particles).
PUBLIC_PAIR_RATE = 202
HEAD = """# Performance

This page is made by `poretwin bench`, on {cores} cores. docs/notebook/performance.md explains the figures and says what was
tried. A *window* is one time step of the coupling or, where the fluid solver runs alone, of that solver; "asked" is the
bound.

The studies, from hydrostatic_tank on, give the error that the case's own `verify` computes, and the CPU and wall-clock
seconds of all processes. `*`: no other run of the case has a smaller error in less CPU time. A dash: the run did not
end. When a run of a scheme takes longer than a minute, the scheme's finer runs are left out. Schemes: `default`, the
code without settings; `EISPH`, explicit sweeps for the pressure (`fluid.scheme = "eisph"`); `paper`, the scheme of Bui
& Nguyen (2017) as far as it is built (`case.scheme = "paper"`, [theory](theory/paper.md#scheme--paper)). Other schemes
change the setting that they name. Where `default` bears the `*`, a tighter tolerance or a finer run costs more than its
smaller error is worth.
"""


def verified(program, case, study, settings, longest):
    """The result of one run of `verify`; None where the run took longer than `longest` seconds."""
    with tempfile.TemporaryDirectory() as folder:
        result = pathlib.Path(folder) / "result.json"
        command = [program, "verify", case, "--json", result, "--out", folder]
        if "run" in study:
            command += ["--run", study["run"]]
        for setting in settings:
            command += ["--set", setting]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
            try:
                output, error = process.communicate(timeout=longest)
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGINT)  # poretwin then ends its processes
                process.communicate()
                print(f"{case}: stopped after {longest:g} s", flush=True)
                return None
        if not result.exists():
            sys.exit(f"{case}: {error.strip() or output.strip()}")
        return json.loads(result.read_text())


def measured(a, case, study, scheme, spacing):
    """One row per metric of the run with this spacing and scheme."""
    settings = [*study.get("set", []), f'{study["spacing"]}={spacing}', *study["schemes"][scheme]]
    verdicts = []
    for _ in range(a.repeats):
        verdict = verified(a.program, case, study, settings, study.get("longest", a.longest))
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
    """Whether no other run has a smaller error in less CPU time."""
    return row["error"] is not None and not any(
        other["error"] is not None and other["error"] < row["error"] and other["cpu_s"] < row["cpu_s"]
        for other in rows)


def job_table(a, jobs):
    """Run times of whole runs, the time that a user waits, beside their bounds: medians over --repeats runs."""
    rows = []
    pace = pair_rate(a.program)
    carried_to = ("The column \"carried\" gives the CPU seconds converted to that\nmachine: a loop over a list of pairs of particles, one pair at a time, "
                  f"computes {PUBLIC_PAIR_RATE} million pairs per CPU second there;\nthe same loop computed "
                  f"{pace:.0f} million here, just before these runs."
                  if pace else "CPU seconds are not converted to that\nmachine: the loop that compares the two machines is not built (`ninja pair_loops`).")
    lines = ["", "## Jobs", "", "CPU seconds are those of all processes in a whole run; the column \"threads\" gives the threads of each solver. The bounds\n"
             f"refer to the machine on which the public codes were timed. {carried_to}", "",
             "| job | particles | steps or windows | threads | million particle-steps/s | CPU s | carried | wall s | asked |",
             "| --- | --- | --- | --- | --- | --- | --- | --- | --- |"]
    for name, job in jobs.items():
        runs = [Run(job["case"], job.get("set", []), a.program, threads=job.get("threads")) for _ in range(a.repeats)]
        threads = job.get("threads", os.cpu_count())
        if any(run.exit != 0 for run in runs):
            lines.append(f"| {name} | - | - | {threads} | - | {runs[-1].reason} | - | - | {job['asked']} |")
            rows.append({"job": name, "threads": threads, "reason": runs[-1].reason, "asked": job["asked"]})
            continue
        run, cpu, wall = runs[0], statistics.median(run.cpu for run in runs), statistics.median(run.wall for run in runs)
        phases = [phase for phase in ("fluid", "solid") if phase in run.summaries]
        particles = sum(run.counter(phase, "particles") for phase in phases)
        steps = run.counter(phases[0], "windows") or run.counter("solid", "substeps") + run.counter("solid", "rest steps")
        rate = f"{1e-6 * particles * steps / cpu:.2f}" if len(phases) == 1 else ""
        carried = f"{cpu * pace / PUBLIC_PAIR_RATE:.2f}" if pace and threads == 1 else ""
        lines.append(f"| {name} | {particles:.0f} | {steps:.0f} | {threads} | {rate} | {cpu:.2f} | {carried} | {wall:.2f} | {job['asked']} |")
        print(lines[-1], flush=True)
        rows.append({"job": name, "particles": int(particles), "steps": int(steps), "threads": threads, "cpu_s": round(cpu, 3),
                     "wall_s": round(wall, 3), "asked": job["asked"]})
    return lines, rows


def printed_by(program, name):
    """Output of the benchmark with this name, which measures one kernel; None where it has not been built beside the program."""
    path = pathlib.Path(program).resolve().parent / name
    return subprocess.run([path], capture_output=True, text=True, check=True).stdout if path.exists() else None


def pair_rate(program):
    """Speed of the plainest loop over pairs, in million directed pairs per CPU second; None where the benchmark has not been built."""
    text = printed_by(program, "pair_loops")
    return text and float(next(line for line in text.splitlines() if "one pair at a time" in line).split("|")[2])


def table_of(program, name, title):
    """The page's section with the output of one kernel's benchmark, and its rows; a note where the benchmark has not been built."""
    text = printed_by(program, name)
    if text is None:
        return ["", f"## {title}", "", f"(build it first: `ninja {name}`)"], []
    head, table = text.split("\n", 1)
    return ["", f"## {title}", "", head + ".", "", table.strip()], table_rows(table)


def table_rows(table):
    """The rows of a Markdown table as dictionaries by heading."""
    cells = [[cell.strip() for cell in line.strip().strip("|").split("|")] for line in table.splitlines() if line.startswith("|")]
    return [dict(zip(cells[0], row)) for row in cells[2:]]


def size_table(a):
    rows = scaling.measure_all(a.program, scaling.PHASES, a.sizes, a.threads)
    write_csv(a.out / "scaling.csv", rows)
    scaling.draw(a.out / "scaling.png", rows)
    return ["", "## Size", "", "CPU time per particle and step, without the time to start; memory of the solver per particle, without the memory of a\n"
            "run with 1000 particles (bench/scaling.py). \"Of the first thread\" is the CPU time of the thread that also does all\n"
            "serial work. \"All threads over the first\" divides the CPU time of all threads by it: the speed-up on a machine where\n"
            "every thread has a core of its own. \"Speed-up by wall\" is the speed-up of the wall-clock time, which other load on the\n"
            "machine reduces. Iterations are those of the pressure solve per window.", "",
            "![](bench/scaling.png)", "", *scaling.table(rows)], rows


def coupling_table(a):
    rows = overhead.measure_all(a.program, a.repeats)
    write_csv(a.out / "overhead.csv", rows)
    return ["", "## Coupling", "", "Every instant of a run counts for one activity; \"nobody\" means that no process works. Overhead is the time of mapping,\n"
            "of sending and of \"nobody\", divided by the whole time. \"Over the critical path\" is the whole time divided by the time in\n"
            "which some process works (bench/overhead.py). Bounds: overhead 25 % for 3000 particles and 15 % for embankment_failure;\n"
            "1.15 over the critical path.", "", *overhead.table(rows)], rows


def skipping_table(a):
    rows = skipping.measure_all(a.program, a.repeats)
    write_csv(a.out / "skipping.csv", rows)
    return ["", "## Skipped work", "", "Work that the solvers skip. The column \"computed\" gives the CPU seconds of the same run with this work done. The errors\n"
            "are the differences that skipping makes in the case's gauges, divided by the gauges' scales (bench/skipping.py).", "",
            *skipping.table(rows)], rows


def order(row, rows):
    """Observed order of convergence from the next coarser spacing of the same scheme to this row's; empty where the scheme has no
    coarser run, or an error is missing."""
    coarser = [other for other in rows if other["scheme"] == row["scheme"] and other["spacing"] > row["spacing"]]
    if not coarser or not row["error"] or not coarser[-1]["error"]:
        return ""
    before = coarser[-1]
    return f'{math.log(before["error"] / row["error"]) / math.log(before["spacing"] / row["spacing"]):.1f}'


def study_table(case, study, rows):
    """Markdown of a study; `*` marks runs for which no other run has both a smaller error and less CPU time."""
    axis = "exchange interval [s]" if study["spacing"].startswith("coupling") else "spacing [m]"
    lines = ["", f"## {case}", "", f"{rows[0]['metric']} (asked: {rows[0]['bound']:g}).", "", f"![](bench/{case}.png)", "",
             f"| scheme | {axis} | error | order | CPU s | wall s | windows | particles | |",
             "| --- | --- | --- | --- | --- | --- | --- | --- | --- |"]
    for row in rows:
        error = "-" if row["error"] is None else f"{row['error']:.2g}"
        lines.append(f"| {row['scheme']} | {row['spacing']:g} | {error} | {order(row, rows)} | {row['cpu_s']:.2f} | {row['wall_s']:.2f} "
                     f"| {row['windows']} | {row['particles']} | {'*' if is_front(row, rows) else ''} |")
    return lines + (["", study["note"]] if "note" in study else [])


def measure_study(a, case, study):
    """Measures all schemes and spacings of a study. Returns the lines of the page and the rows; writes the rows as CSV and picture."""
    rows = []
    for scheme in a.schemes or study["schemes"]:
        if scheme not in study["schemes"]:
            sys.exit(f"{case} has no scheme '{scheme}'; expected one of: {', '.join(study['schemes'])}")
        spacings = a.spacings or study["spacings"]
        for spacing in spacings[:1] if scheme in study.get("own_windows", []) else spacings:
            found = measured(a, case, study, scheme, spacing)
            if not found:
                break
            rows += found
            first = next((row for row in found if row["metric"] == study.get("metric")), found[0])
            print("{case}, {scheme}, {spacing:g}: {metric} {error}, {cpu_s} CPU s".format(**first), flush=True)
    if not rows:
        return ["", f"## {case}", "", f"(no run ended within {a.longest:g} s)"], []
    metric = study.get("metric", rows[0]["metric"])
    write_csv(a.out / f"{case}.csv", rows)
    drawn = [row for row in rows if row["metric"] == metric]
    error_curves(a.out / f"{case}.png", f"{case}: {metric}", drawn,
                 {"spacing": study["spacing"], "cpu_s": "run time [CPU s]"}, bound=drawn[0]["bound"])
    return study_table(case, study, drawn), rows


def main():
    studies = tomllib.loads((HERE / "studies.toml").read_text())
    jobs = studies.pop("job")
    parser = argparse.ArgumentParser(prog="poretwin bench", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", metavar="PART")
    parser.add_argument("--schemes", nargs="+", help="default: all of the study")
    parser.add_argument("--spacings", nargs="+", type=float, help="coarse to fine; default: the study's own")
    parser.add_argument("--repeats", type=int, default=1, help="runs of which the median is taken (default 1)")
    parser.add_argument("--longest", type=float, default=60.0, help="wall-clock seconds of a run of a study (default 60)")
    parser.add_argument("--sizes", type=float, nargs="+", default=[1e4, 1e5, 1e6], help="particles, of the table of sizes")
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 2], help="of the solvers, in the table of sizes")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("runs/bench"))
    parser.add_argument("--page", action="store_true", help="put page and pictures into docs/")
    parser.add_argument("--program", default="poretwin", help=argparse.SUPPRESS)
    a = parser.parse_args()
    measures = {"jobs": lambda: job_table(a, jobs), "kernels": lambda: table_of(a.program, "pair_loops", "Pair loops"),
                "sizes": lambda: size_table(a),
                "solve": lambda: table_of(a.program, "multigrid_timing", "The pressure solve against size"),
                "coupling": lambda: coupling_table(a), "skipped": lambda: skipping_table(a)}
    measures |= {case: lambda case=case, study=study: measure_study(a, case, study) for case, study in studies.items()}
    if unknown := [part for part in a.parts if part not in measures]:
        parser.error(f"{unknown[0]}: no such part; expected some of: {', '.join(measures)}")
    if a.page and not DOCS.is_dir():
        sys.exit(f"--page: {DOCS} is not there: expected the docs of a source tree; leave it out, the page is in {a.out}")
    a.out.mkdir(parents=True, exist_ok=True)
    tables = {}
    for part in a.parts or measures:
        lines, tables[part] = measures[part]()
        (a.out / f"{part}.md").write_text("\n".join(lines) + "\n")
    (a.out / "bench.json").write_text(json.dumps(tables, indent=2, default=float) + "\n")
    page = a.out / "performance.md"
    page.write_text(HEAD.format(cores=os.cpu_count()) + "".join(
        (a.out / f"{part}.md").read_text() for part in measures if (a.out / f"{part}.md").exists()))
    if a.page:
        page = pathlib.Path(shutil.copy(page, DOCS))
        for picture in a.out.glob("*.png"):
            shutil.copy(picture, DOCS / "bench")
    print(f"tables and pictures: {a.out}; {page}")


if __name__ == "__main__":
    main()
