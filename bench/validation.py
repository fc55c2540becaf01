#!/usr/bin/python3
"""Makes docs/validation.md by running the cases. The page gives for each case the reference, the table of errors, the numbers of particles and
windows and the run time; for the main cases also pictures.

bench/validation.py                 runs every case, in the short form of its verify.toml
bench/validation.py --full          runs every case in full (takes hours)
bench/validation.py [--full] CASE.. runs these cases; results of the others are kept (runs/validation)
bench/validation.py --page          runs nothing; writes the page from kept results
"""
import argparse
import json
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "cli"))
import verify_page  # noqa: E402
import style  # noqa: E402

PICTURED = ("dam_break", "submerged_soil", "terzaghi", "embankment_seepage", "rockfill_dam", "rockfill_flood",
            "embankment_failure", "column_collapse", "quicksand")


def verify(poretwin, name, full, found):
    """Runs `verify` of one case; its results go to found/NAME.json."""
    raw = found / "unfinished"
    raw.unlink(missing_ok=True)
    subprocess.run([poretwin, "verify", ROOT / "cases" / name, "--json", raw, "--out", found / "runs"]
                   + ([] if full else ["--short"]), check=False)
    if raw.exists():
        case = json.loads(raw.read_text())
        (found / f"{name}.json").write_text(json.dumps(case | {"case": name, "form": "full" if full else "short"}))


def page(found):
    """Markdown of all kept results."""
    cases = [json.loads(file.read_text()) for file in sorted(found.glob("*.json"))]
    lines = ["# Validation", "", "Made by `bench/validation.py` from the runs themselves; the reference numbers and their sources stand in "
             "`cases/*/reference`.", "The short form of a case is coarser or ends sooner than the full one, against the same bounds "
             "unless its verify.toml says otherwise. Where a result hangs on chance a run is repeated as several histories "
             "(`histories` in verify.toml): particles displaced by a millionth of a spacing, single numbers such as cohesion changed by a "
             "percent; the mean is held against the reference, and the standard deviation may have a bound of its own (`spread`). Run times are those of the machine and of what else ran on it; docs/performance.md has the others.", "",
             "| case | form | within its bounds | metrics | CPU s |", "| --- | --- | --- | --- | --- |"]
    for case in cases:
        missed = sum(not m["passed"] for m in case["metrics"])
        lines.append(f"| [{case['case']}](#{case['case']}) | {case['form']} | {f'**{missed} missed**' if missed else 'yes'} "
                     f"| {len(case['metrics'])} | {case['cpu_s']:.1f} |")
    for case in cases:
        pictured = 1 if case["case"] in PICTURED else 0
        lines += ["", f'<a id="{case["case"]}"></a>', ""] + verify_page.section(case, ROOT / "docs" / "pictures", pictured)
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", nargs="*", help="names of cases; none: all")
    parser.add_argument("--full", action="store_true", help="full runs, not short ones")
    parser.add_argument("--page", action="store_true", help="run nothing")
    parser.add_argument("--poretwin", default=ROOT / "build" / "release" / "bin" / "poretwin", help="the program")
    parser.add_argument("--found", type=pathlib.Path, default=ROOT / "runs" / "validation", help="folder of what was found")
    a = parser.parse_args()
    a.found.mkdir(parents=True, exist_ok=True)
    names = [] if a.page else a.cases or sorted(f.parent.name for f in (ROOT / "cases").glob("*/verify.toml"))
    for name in names:
        verify(a.poretwin, name, a.full, a.found)
    style.use(**{"savefig.dpi": 70})
    (ROOT / "docs" / "validation.md").write_text(page(a.found))
    print(ROOT / "docs" / "validation.md")


if __name__ == "__main__":
    main()
