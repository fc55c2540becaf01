#!/usr/bin/python3
"""Measures time per particle and step, memory and iterations for several numbers of particles and threads. Writes scaling.csv and scaling.png.

    bench/scaling.py                                        one thread, 10 thousand to 1 million particles
    bench/scaling.py --threads 1 2 --sizes 100000           speed-up of both solvers
    bench/scaling.py --phases "fluid 3D" --sizes 2e6        2 million particles in 3D; takes some 4 GB of memory

Water: seepage through a saturated aquifer of rigid soil (cases/confined_flow), also in 3D. Soil: the dry embankment (cases/embankment_dry),
without stress at first. The time of a step is the difference of the times of a long and a short run, divided by the difference of their numbers
of steps. So the times for reading the case, for the first search of neighbours and for writing cancel.

There are two speed-ups. "By wall" is that of the wall-clock time; it is meaningful on a quiet machine only. "All threads over the first" is the
CPU time of all threads divided by that of the first thread, which does all serial work: the speed-up that threads give where each has a core of
its own. It is measured in one run, also on a busy machine. Memory is the solver's largest memory, less that of a run with 1000 particles.
"""
import argparse
import json
import os
import pathlib
import subprocess
import tempfile

from plot import plt, style, write_csv
from runs import PROGRAM

ROOT = pathlib.Path(__file__).resolve().parent.parent
QUIET = ["output.interval=1e9", "output.gauge_interval=1e9"]


def water(n, windows):
    dx = (0.4 * 0.2 / n) ** 0.5
    end = windows * 0.25 * dx / 6.9e-5  # s: a quarter spacing per window
    return "confined_flow", [f"fluid.particle_spacing={dx}", f"case.end_time={end}"]


def water_3d(n, windows):
    dx = (0.4 * 0.2 * 0.2 / n) ** (1.0 / 3.0)
    end = windows * 0.25 * dx / 6.9e-5
    return "cases/confined_flow/case3d.toml", [f"fluid.particle_spacing={dx}", f"case.end_time={end}"]


def soil(n, steps):
    dx = (0.32 / n) ** 0.5
    end = steps * 0.8 * dx / 51.0  # s: Courant number 0.8, speed of compression waves 51 m/s
    return "embankment_dry", [f"solid.particle_spacing={dx}", f"case.end_time={end}", "solid.initial_rest=false"]


# Solver, scene, numbers of steps of the short and the long run, name of the counter of steps.
PHASES = {"fluid": ("fluid", water, (3, 27), "windows"), "fluid 3D": ("fluid", water_3d, (2, 8), "windows"),
          "solid": ("solid", soil, (10, 50), "substeps")}


def run(program, solver, scene, threads):
    """The solver's summary."""
    case, overrides = scene
    if case.endswith(".toml"):
        case = ROOT / case
    with tempfile.TemporaryDirectory() as folder:
        command = [program, "run", case, "--out", folder, "--no-pictures", "--quiet", "--restarts", "0"]
        for text in overrides + QUIET:
            command += ["--set", text]
        done = subprocess.run(command, env={**os.environ, "OMP_NUM_THREADS": str(threads)})
        if done.returncode != 0:
            raise SystemExit(f"{case} with {overrides}: status {done.returncode}")
        return json.loads((pathlib.Path(folder) / f"{solver}.summary.json").read_text())


def measured(program, phase, n, threads, base):
    solver, scene, (few, many), steps_of = PHASES[phase]
    short = run(program, solver, scene(n, few), threads)
    long = run(program, solver, scene(n, many), threads)
    c = long["counters"]
    difference = lambda name: c.get(name, 0.0) - short["counters"].get(name, 0.0)  # noqa: E731
    steps, particles = difference(steps_of), c["particles"]
    work = 1e-6 * steps * particles
    return {"phase": phase, "particles": int(particles), "threads": threads, "steps": int(steps),
            "cpu_us": round((long["cpu_s"] - short["cpu_s"]) / work, 4),
            "first_us": round((long["cpu_first_thread_s"] - short["cpu_first_thread_s"]) / work, 4),
            "wall_us": round((long["seconds"]["computing"] - short["seconds"]["computing"]) / work, 4),
            "bytes": round((long["memory_bytes"] - base) / particles),
            "iterations": round((difference("pressure iterations") + difference("multigrid cycles")) / steps, 1)}


def measure_all(program, phases, sizes, threads):
    rows = []
    for phase in phases:
        solver, scene, (few, _), _ = PHASES[phase]
        base = run(program, solver, scene(1000, few), 1)["memory_bytes"]
        for n in sizes:
            for count in threads:
                rows.append(measured(program, phase, n, count, base))
                print(rows[-1], flush=True)
    return rows


def table(rows):
    """The results as a Markdown table."""
    lines = ["| phase | particles | threads | CPU us a particle and step | of the first thread | wall us | all threads over the first "
             "| speed-up by wall | bytes a particle | iterations |", "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |"]
    for r in rows:
        single = next((q for q in rows if (q["phase"], q["particles"]) == (r["phase"], r["particles"])
                       and q["threads"] == 1), None)
        gain = f"{r['cpu_us'] / r['first_us']:.2f}" if r["threads"] > 1 else ""
        by_wall = f"{single['wall_us'] / r['wall_us']:.2f}" if single and r["threads"] > 1 else ""
        lines.append(f"| {r['phase']} | {r['particles']} | {r['threads']} | {r['cpu_us']:.3f} | {r['first_us']:.3f} "
                     f"| {r['wall_us']:.3f} | {gain} | {by_wall} | {r['bytes']} | {r['iterations'] or ''} |")
    return lines


def draw(path, rows):
    figure, panels = plt.subplots(1, 3, figsize=(13.5, 3.6), constrained_layout=True)
    texts = {"wall_us": "wall microseconds per particle and step", "bytes": "bytes per particle",
             "iterations": "iterations and cycles per window"}
    colours = {phase: f"C{k}" for k, phase in enumerate(dict.fromkeys(r["phase"] for r in rows))}
    for panel, (key, text) in zip(panels, texts.items()):
        for phase, threads in dict.fromkeys((r["phase"], r["threads"]) for r in rows):
            if key == "iterations" and (phase == "solid" or threads > 1):  # the same for any number of threads
                continue
            mine = [r for r in rows if (r["phase"], r["threads"]) == (phase, threads)]
            panel.semilogx([r["particles"] for r in mine], [r[key] for r in mine], "o-" if threads == 1 else "o--",
                           color=colours[phase], label=f"{phase}, {threads} thread{'s' if threads > 1 else ''}")
        panel.set_xlabel("particles")
        panel.set_ylabel(text)
        if key == "iterations":
            panel.set_ylim(bottom=0.0)
        else:
            panel.set_yscale("log")
        panel.grid(True, which="both")
    panels[-1].legend(*panels[0].get_legend_handles_labels(), loc="upper left", bbox_to_anchor=(1.02, 1.0))
    style.save(figure, path)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sizes", type=float, nargs="+", default=[1e4, 1e5, 1e6])
    parser.add_argument("--threads", type=int, nargs="+", default=[1])
    parser.add_argument("--phases", nargs="+", choices=list(PHASES), default=["fluid", "solid"])
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("runs/bench"))
    parser.add_argument("--program", default=str(PROGRAM), help=argparse.SUPPRESS)
    a = parser.parse_args()
    rows = measure_all(a.program, a.phases, a.sizes, a.threads)
    write_csv(a.out / "scaling.csv", rows)
    draw(a.out / "scaling.png", rows)
    print("\n".join(table(rows)), f"\n\ntable and picture: {a.out}/scaling.csv, scaling.png")


if __name__ == "__main__":
    main()
