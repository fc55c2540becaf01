#!/usr/bin/python3
"""Makes docs/gallery by running the cases. The page gives for each case a picture, the first lines of its README, the commands that made the
picture, the number of particles and the run time.

bench/gallery.py           runs every case
bench/gallery.py CASE..    runs these cases; results of the others are kept (docs/gallery/found.json)
bench/gallery.py --page    runs nothing; writes the page from kept results

bench/gallery.toml says with which options each case is run, and what its picture shows.
"""
import argparse
import concurrent.futures
import json
import pathlib
import shlex
import subprocess
import sys
import tempfile
import tomllib

from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parent.parent
GALLERY = ROOT / "docs" / "gallery"
WIDEST, HIGHEST = 720, 480  # pixels, largest size on the page
COLOURS = 256               # of a palette: the file has a third of its size, with hardly a visible difference
LONGEST = 5                 # lines of text per case
HEAD = """# Gallery

Every case in a picture. Made by `bench/gallery.py` from the runs themselves, as `bench/gallery.toml` says; words are the first of each case's
README, which also has the reference and what is not met. How far off each case is: [validation.md](../validation.md). Run times are CPU seconds of all processes,
on two cores shared with other work. Some commands end a case sooner or take coarser particles than its file does.
"""


def groups():
    """The groups of bench/gallery.toml, each case with its commands: [(title, [{name, command, plot}])]."""
    for group in tomllib.loads((ROOT / "bench" / "gallery.toml").read_text())["group"]:
        cases = []
        for case in group["case"]:
            name = case["name"]
            cases.append({"name": name, "command": f"poretwin {case.get('with', 'run')} {case.get('run', name)}",
                          "plot": f"poretwin plot runs/{name} {case['show']}" if "show" in case else None})
        yield group["title"], cases


def small(picture, target):
    """Writes a picture reduced to the size on the page."""
    with Image.open(picture) as opened:
        image = opened.convert("RGB")
    scale = min(1.0, WIDEST / image.width, HIGHEST / image.height)
    image = image.resize((round(image.width * scale), round(image.height * scale)), Image.Resampling.LANCZOS)
    # A palette that covers all colours, not only the most frequent ones, so that thin black lines stay black.
    image.quantize(COLOURS, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE).save(target, optimize=True)


def make(case, poretwin, runs, again=False):
    """Runs a case and draws its picture; returns the page's data of the case. again: uses the existing run."""
    folder = runs / case["name"]
    report = runs / f"{case['name']}.json"
    command = [poretwin, *shlex.split(case["command"])[1:], "--out", folder, "--json", report, "--quiet"]
    if case["plot"]:
        command += ["--no-pictures", "--overwrite"]
    if not again:
        subprocess.run(command, cwd=ROOT, stdout=subprocess.DEVNULL, check=False)
    result = json.loads(report.read_text())
    if result["exit"] not in (0, 6):  # 6: the run itself reports what puts its result in doubt
        raise SystemExit(f"{case['command']}: {result['reason']}")
    counted = json.loads(subprocess.run([poretwin, "check", *check_of(case["command"]), "--json", "-"], cwd=ROOT, check=True, capture_output=True, text=True).stdout)
    particles = {phase: (counted[phase] or {"particles": 0})["particles"] for phase in ("fluid", "solid")}
    for process in result.get("processes", []):  # with the water that entered through faces
        if process["process"] in particles:
            particles[process["process"]] = max(particles[process["process"]], int(process["counters"].get("particles", 0)))
    particles = {phase: n for phase, n in particles.items() if n > 0}
    draw(case, poretwin, folder, result)
    doubts = sorted({w["what"] for w in result.get("warnings", []) if w.get("result_in_doubt")})
    return {"particles": particles, "cpu_s": round(result["cpu_s"], 1), "factor": result.get("factor"), "doubts": doubts}


def check_of(command):
    """The case and the --set options of a command, for `poretwin check`."""
    words = shlex.split(command)[2:]
    kept = words[:1]
    for i, word in enumerate(words):
        if word == "--set":
            kept += words[i:i + 2]
    return kept


def draw(case, poretwin, folder, result):
    with tempfile.TemporaryDirectory() as out:
        if case["plot"]:
            subprocess.run([poretwin, "plot", folder, *shlex.split(case["plot"])[3:], "--out", out], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
            drawn = sorted(pathlib.Path(out).glob("*.png"))
        else:
            drawn = sorted(folder.glob("*.png"))
        if len(drawn) != 1:
            raise SystemExit(f"{case['name']}: one picture expected, there are {[path.name for path in drawn]}")
        small(drawn[0], GALLERY / f"{case['name']}.png")


def words(name):
    """Title and first paragraph of a case's README, with links adapted to the page."""
    title, _, rest = (ROOT / "cases" / name / "README.md").read_text().partition("\n")
    return title.lstrip("# "), "\n".join(rest.strip().split("\n\n")[0].splitlines()[:LONGEST])


def page(found):
    """Markdown of the page with all cases."""
    lines = [HEAD, "| | cases |", "| --- | --- |"]
    for title, cases in groups():
        names = ", ".join(f"[{case['name']}](#{case['name']})" for case in cases)
        lines.append(f"| {title} | {names} |")
    for title, cases in groups():
        lines += ["", f"## {title}"]
        for case in cases:
            name, run = case["name"], found[case["name"]]
            heading, about = words(name)
            commands = "\n".join(filter(None, (case["command"], case["plot"])))
            counts = " and ".join(f"{n} {'water' if phase == 'fluid' else 'soil'}" for phase, n in run["particles"].items())
            factor = f"; factor of safety {run['factor']:.2f}" if run.get("factor") else ""
            doubts = f"; the run itself puts its result in doubt: {', '.join(run['doubts'])}" if run.get("doubts") else ""
            lines += ["", f'<a id="{name}"></a>', "", f"### {heading}", "", f"![{name}]({name}.png)", "", about, "", "```", commands, "```", "",
                      f"[{name}](../../cases/{name}/README.md): {counts} particles, {run['cpu_s']:.3g} CPU s{factor}{doubts}."]
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", nargs="*", help="names of cases; none: all")
    parser.add_argument("--page", action="store_true", help="run nothing")
    parser.add_argument("--draw", action="store_true", help="draw from the runs that are there")
    parser.add_argument("--jobs", type=int, default=1, help="runs at a time")
    parser.add_argument("--poretwin", default=ROOT / "build" / "release" / "bin" / "poretwin", help="the program")
    parser.add_argument("--runs", type=pathlib.Path, default=ROOT / "runs" / "gallery", help="folder of the runs")
    a = parser.parse_args()
    a.runs.mkdir(parents=True, exist_ok=True)
    store = GALLERY / "found.json"
    found = json.loads(store.read_text()) if store.exists() else {}
    wanted = [case for _, cases in groups() for case in cases if not a.page and (not a.cases or case["name"] in a.cases)]
    failed = []
    with concurrent.futures.ThreadPoolExecutor(a.jobs) as jobs:
        running = {jobs.submit(make, case, a.poretwin, a.runs, a.draw): case["name"] for case in wanted}
        for done in concurrent.futures.as_completed(running):
            name = running[done]
            try:
                found[name] = done.result()
            except (SystemExit, subprocess.CalledProcessError) as error:  # other cases are still run
                failed.append(f"{name}: {error}")
                continue
            print(f"{name}: {found[name]}", flush=True)
            store.write_text(json.dumps(dict(sorted(found.items())), indent=1) + "\n")
    (GALLERY / "README.md").write_text(page(found))
    print(GALLERY / "README.md")
    return "\n".join(failed) or None


if __name__ == "__main__":
    sys.exit(main())
