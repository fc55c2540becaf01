#!/usr/bin/python3
"""Writes one page with the results of `poretwin verify`. For each case it gives the introduction, the errors, the runs with particles,
windows and run time, the figures that verify.toml declares, pictures of the fields that verify.toml names (otherwise of each phase's main
field at the end of the run), and pictures of the gauges that are compared.

Called by `poretwin verify CASE|all --report DIR`.
"""
import argparse
import json
import pathlib

import figures
import plot
import style


def text(value):
    return "-" if value is None else f"{value:.4g}"


def introduction(case_folder):
    """Title and first paragraph of a case's README."""
    readme = case_folder / "README.md"
    if not readme.exists():
        return case_folder.name, ""
    title, _, rest = readme.read_text().partition("\n")
    return title.lstrip("# "), rest.strip().split("\n\n")[0]


def draw_fields(folder, wanted, target, prefix):
    """Draws fields of a run. wanted: list of "FIELD" (at the end) or "FIELD@TIME"; empty: each phase's main field. Yields paths."""
    for phase in ("fluid", "solid"):
        if not (folder / f"{phase}.vtkhdf").exists():
            continue
        frames = plot.Frames(folder / f"{phase}.vtkhdf")
        there = frames.fields()
        if frames.n_steps == 0:
            continue
        for text in wanted or [f for f in plot.MAIN_FIELDS[phase] if f in there][:1]:
            name, _, time = text.partition("@")
            if name not in there and name.rpartition("_")[0] not in there:
                continue
            step = frames.nearest(float(time)) if time else frames.n_steps - 1
            path = target / f"{prefix}_{phase}_{text.replace('@', '_t')}.png"
            plot.draw_field(frames, phase, name, step, path)
            if path.exists():
                yield path


def draw_gauges(folder, judged, target, prefix):
    """Draws one picture for each gauge to which these metrics refer, with the reference values; all points of a gauge share one picture.
    Yields the files' paths."""
    series = plot.read_gauges(folder)
    for title in dict.fromkeys(m["gauge"].partition("[")[0] for m in judged):
        group = [name for name in series if name.partition("[")[0] == title and len(series[name]["t"]) > 1]
        if group:
            path = target / f"{prefix}_{title.replace('/', '_')}.png"
            marks = [mark for m in judged for mark in m.get("marks", []) if mark[0] in group]
            plot.draw_gauges(folder, group, title, series, path, marks)
            yield path


def draw_figures(case, target):
    """Draws the figures that verify.toml declares. Yields paths."""
    folder = pathlib.Path(case["folder"])
    if (folder / "verify.toml").exists():
        runs = {run["name"]: pathlib.Path(run["folder"]) for run in case["runs"]}
        yield from figures.Figures(folder, runs).draw_all(target, "png", f"{case['case']}_")


def section(case, folder_of_pictures, pictured=None):
    """Markdown of one case. Pictures go into folder_of_pictures: those of all runs (pictured = None), or of the first `pictured` runs. Where
    some runs list `figures` in verify.toml, only these are counted."""
    title, about = introduction(pathlib.Path(case["folder"]))
    lines = [f"## {case['case']}: {title}", "", about, ""]
    pictures = {}
    if case["source"]:
        lines += [f"Reference: {case['source']}.", ""]
    lines += ["| metric | value | reference | error | bound | |", "| --- | --- | --- | --- | --- | --- |"]
    for m in case["metrics"]:
        lines.append(f"| {m['name']} | {text(m['value'])} {m['unit']} | {text(m['reference'])} | {text(m['error'])} "
                     f"| {m['tolerance']:g} | {'' if m['passed'] else '**missed**'} |")
    lines += ["", "| run | particles | windows | wall s | CPU s |", "| --- | --- | --- | --- | --- |"]
    named = [run for run in case["runs"] if run["figures"]]
    chosen = case["runs"] if pictured is None else (named or case["runs"])[:pictured]
    for run in case["runs"]:
        counts = ", ".join(f"{n:.0f} {phase}" for phase, n in run["particles"].items())
        lines.append(f"| {run['name']} | {counts} | {run['windows']:.0f} | {run['wall_s']:.1f} | {run['cpu_s']:.1f} |")
        if run not in chosen:
            continue
        folder, prefix = pathlib.Path(run["folder"]), f"{case['case']}_{run['name']}".replace(" ", "_")
        judged = [m for m in case["metrics"] if m["run"] == run["name"] and m["gauge"]]
        pictures[run["name"]] = [*draw_fields(folder, run["figures"], folder_of_pictures, prefix),
                                 *draw_gauges(folder, judged, folder_of_pictures, prefix)]
    drawn = [] if pictured == 0 else list(draw_figures(case, folder_of_pictures))
    if drawn:
        lines += [""] + [f"![{path.stem}](pictures/{path.name})" for path in drawn]
    for name, paths in pictures.items():
        if paths:
            lines += ["", f"Run `{name}`:", ""]
            lines += [f"![{path.stem}](pictures/{path.name})" for path in paths]
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("results", type=pathlib.Path, help="JSON of `poretwin verify`")
    parser.add_argument("out", type=pathlib.Path, help="folder of the page")
    a = parser.parse_args()
    (a.out / "pictures").mkdir(parents=True, exist_ok=True)
    style.use(**{"savefig.dpi": 100})
    cases = json.loads(a.results.read_text())
    passed = sum(case["passed"] for case in cases)
    lines = ["# Validation", "", f"Made by `poretwin verify --report` from the runs themselves: {passed} of {len(cases)} "
             "cases within all their bounds.", ""]
    for case in cases:
        lines += section(case, a.out / "pictures") + [""]
    (a.out / "validation.md").write_text("\n".join(lines))
    print(a.out / "validation.md")


if __name__ == "__main__":
    main()
