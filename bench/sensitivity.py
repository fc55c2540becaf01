#!/usr/bin/python3
"""Halves and doubles constants of fluid_solver/numerics, pore_solver/numerics, joint_solver/numerics and solid_solver/numerics, and reports which tests then fail.

    bench/sensitivity.py --list                              prints all constants
    bench/sensitivity.py fluid.surface.hole solid.walls      tries one constant and all constants of a header, each with the test that
                                                             the header names
    bench/sensitivity.py --all --suites                      tries all constants; those without a named test with all unit tests of
                                                             their solver
    bench/sensitivity.py --all --short                       the same, with the short forms of the cases in which their solver takes part

The values are changed in a scratch copy of the sources: a worktree of the last commit in a temporary folder with its own build, or the
tree of --scratch, which is kept and whose existing build is used. It is built once: its programs read a factor for one constant from
the environment (NUMBER); constants of one name in one header change together. The tests of a constant must pass there before it is
changed. If no change of a constant makes a test fail, either the constant is not needed, or its test is missing.
Results go to docs/notebook/sensitivity.md, which keeps its rows for other constants.
Exit code: 0 each constant that was tried made a test fail, 1 some did not, 2 a test fails without any change.
"""
import argparse
import contextlib
import dataclasses
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib

from runs import PROGRAMS

SOURCE = pathlib.Path(__file__).resolve().parent.parent
PAGE = SOURCE / "docs" / "notebook" / "sensitivity.md"
SOLVERS = ("fluid", "pore", "joint", "solid")
SUITES = {"fluid": ["fluid_tests"], "pore": ["pore_tests"], "joint": ["joint_tests"], "solid": ["solid_tests", "material_tests"]}
ENTRY = re.compile(r"^(?P<reason>(?:/// .*\n)+)/// Unit: (?P<unit>.+?)\. Test: (?P<test>.+)\.\n"
                   r"inline constexpr (?P<type>[\w:]+(?:<[^>]+>)?) (?P<name>\w+)(?: = )?(?P<value>[^;]+);", re.MULTILINE)
NUMBER = "PORETWIN_NUMBER"  # environment variable of programs built in the scratch copy: "NAME FACTOR"
CHOSEN = """// Numbers that the environment changes by a factor; made by bench/sensitivity.py.
#pragma once
#include <array>
#include <cstdlib>
#include <sstream>
#include <string>
namespace poretwin {
inline double factor_for(const std::string& number) {
  std::string name;
  double factor = 1.0;
  if (const char* text = std::getenv("NUMBER")) std::istringstream(text) >> name >> factor;
  return name == number ? factor : 1.0;
}
template <class T>
T chosen(const char* number, T value) {
  return static_cast<T>(static_cast<double>(value) * factor_for(number));
}
template <std::size_t n>
std::array<double, n> chosen(const char* number, std::array<double, n> values) {
  for (double& value : values) value *= factor_for(number);
  return values;
}
}  // namespace poretwin
""".replace("NUMBER", NUMBER)
HEAD = """# Sensitivity of the chosen numbers

What turns red when a number of a solver's numerics folder is halved or doubled, written by
`bench/sensitivity.py`. A row holds for the value that it names and the code with which it was made. "nothing" in both columns: the tests
tried do not need the number, or need a sharper bound.

| Constant | Value | Tried | Halved | Doubled |
| --- | --- | --- | --- | --- |
"""


@dataclasses.dataclass
class Constant:
    solver: str
    room: str
    name: str
    type: str
    value: str
    unit: str
    test: str  # as the header names it
    reason: str

    @property
    def full(self):
        return f"{self.solver}.{self.room}.{self.name}"

    @property
    def tests(self):
        return [] if self.test.startswith("none known") else [self.test.removesuffix(" (untried)")]

    def may_be_times(self, factor):
        """Whether the type has such a value: half of the integer 1 is none."""
        if self.type == "double" or self.type.startswith("std::array<double"):
            return True
        return int(int(self.value) * factor) not in (0, int(self.value))


def sheet(root):
    found = []
    for solver in SOLVERS:
        for file in sorted((root / f"{solver}_solver" / "numerics").glob("*.hpp")):
            text = file.read_text()
            entries = list(ENTRY.finditer(text))
            if len(entries) != text.count("inline constexpr"):
                sys.exit(f"{file}: of {text.count('inline constexpr')} constants only {len(entries)} have reason, unit and test")
            for e in entries:
                reason = " ".join(line.removeprefix("/// ") for line in e["reason"].splitlines())
                found.append(Constant(solver, file.stem, e["name"], e["type"], e["value"], e["unit"], e["test"], reason))
    return found


def short_forms(root, solver):
    """Cases with a verify.toml that the solver takes part in computing."""
    for verify in sorted((root / "cases").glob("*/verify.toml")):
        case = tomllib.loads((verify.parent / "case.toml").read_text())
        moves = "soil" in case and case.get("solid", {}).get("model") != "rigid"
        fluid = case.get("fluid", {})
        if {"solid": moves, "pore": fluid.get("representation") in ("field", "both"), "joint": fluid.get("representation") == "both", "fluid": fluid.get("region")}[solver]:
            yield verify.parent.name


class Scratch:
    """A source tree in which values are changed, built and tested."""

    def __init__(self, root, jobs, limit):
        self.root, self.jobs, self.limit = root, jobs, limit
        self.build = root / "build" / "release"

    def prepare(self):
        """Lets the programs read the constants' factors from the environment."""
        header = self.root / "common" / "core" / "chosen.hpp"
        if not header.exists():
            header.write_text(CHOSEN)
        for solver in SOLVERS:
            for file in (self.root / f"{solver}_solver" / "numerics").glob("*.hpp"):
                text = file.read_text()

                def read(e):
                    definition = e[0][: e.start("type") - e.start()].replace("inline constexpr ", "inline const ")
                    return (f'{definition}{e["type"]} {e["name"]} = '
                            f'poretwin::chosen("{solver}.{file.stem}.{e["name"]}", {e["type"]}{{{e["value"].strip("{}")}}});')

                changed = ENTRY.sub(read, text)
                if changed != text:
                    file.write_text(changed.replace("#pragma once\n", '#pragma once\n\n#include "common/core/chosen.hpp"\n', 1))

        # What is computed from them is no constant expression any more.
        names = "|".join(f"{c.room}::{c.name}" for c in sheet(SOURCE))
        uses = re.compile(rf"\bconstexpr\b(?=.*\b(?:{names})\b)")
        for solver in SOLVERS:
            for file in (self.root / f"{solver}_solver").rglob("*.?pp"):
                text = file.read_text()
                if (changed := uses.sub("const", text)) != text:
                    file.write_text(changed)

    def make(self, targets):
        if not (self.build / "CMakeCache.txt").exists():
            subprocess.run(["cmake", "--preset", "release"], cwd=self.root, check=True, stdout=subprocess.DEVNULL)
        command = ["cmake", "--build", self.build, "-j", str(self.jobs), "--target", *targets]
        built = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if built.returncode:
            print(built.stdout[-2000:], file=sys.stderr)
        return built.returncode == 0

    def program_of(self, test):
        """The test program that contains this test, or is it; None for a case."""
        if test.endswith("_tests"):
            return test
        if "." not in test:
            return None
        suite, name = test.split(".")
        for lists in sorted((self.root / "tests").glob("*/CMakeLists.txt")):
            for program, rest in re.findall(r"poretwin_test\((\w+) ([^)]*)\)", lists.read_text()):
                for file in re.findall(r"\w+_test\.cpp", rest):
                    if re.search(rf"TEST(_F|_P)?\({suite}, {name}\)", (lists.parent / file).read_text()):
                        return program
        sys.exit(f"{test}: in no test program")

    def red(self, test, number="", factor=1.0):
        """The names of the tests that fail: of one test (Suite.Name), of all of a test program, or of one case."""
        program = self.program_of(test)
        if program:
            command = [self.build / "bin" / program] + ([] if program == test else [f"--gtest_filter={test}:*/{test}/*"])
        else:
            shutil.rmtree(self.build / "sensitivity", ignore_errors=True)
            command = [self.build / "bin" / "poretwin", "verify", self.root / "cases" / test, "--short", "--out", self.build / "sensitivity"]
        try:
            run = subprocess.run(command, cwd=self.build, capture_output=True, text=True, errors="replace", timeout=self.limit,
                                 env=os.environ | {NUMBER: f"{number} {factor!r}"})
        except subprocess.TimeoutExpired:
            return [test if program != test else f"{test} (takes too long)"]
        if program and "Running 0 tests" in run.stdout:
            sys.exit(f"{test}: not run by {program}")
        if not run.returncode:
            return []
        failed = re.findall(r"^\[  FAILED  \] ([\w/]+\.[\w/]+)", run.stdout, re.MULTILINE) if program == test else []
        return list(dict.fromkeys(failed)) or [test if program != test else f"{test} (ends early)"]

    def targets(self, tests):
        programs = {self.program_of(t) for t in tests}
        return sorted(programs - {None} | ({*PROGRAMS} if None in programs else set()))


@contextlib.contextmanager
def scratch_tree(given):
    if given and (given / "fluid_solver").exists():
        if given.resolve() == SOURCE:
            sys.exit("--scratch: values are changed there; name a tree other than this one")
        yield given.resolve()
        return
    with contextlib.ExitStack() as stack:
        root = given.resolve() if given else pathlib.Path(stack.enter_context(tempfile.TemporaryDirectory())) / "tree"
        subprocess.run(["git", "worktree", "add", "--detach", root, "HEAD"], cwd=SOURCE, check=True, stdout=subprocess.DEVNULL)
        if not given:
            stack.callback(subprocess.run, ["git", "worktree", "remove", "--force", root], cwd=SOURCE, check=True)
        yield root


def tried(scratch, constant, tests, before):
    """The tests that failed with the value halved, and those that failed with it doubled; each as a text for the table."""
    cells = []
    for factor in (0.5, 2.0):
        if not constant.may_be_times(factor):
            cells.append("no such value")
            continue
        red = [name for t in tests for name in scratch.red(t, constant.full, factor) if name not in before]
        cells.append("all" if red == tests else ", ".join(red) or "nothing")
    return cells


def write(rows):
    """Writes the rows to the page, in the order of the constants; the page's rows for other constants are kept."""
    known = {}
    if PAGE.exists():
        for line in PAGE.read_text().splitlines():
            if (cells := [c.strip() for c in line.strip("|").split("|")]) and re.fullmatch(r"`\w+\.\w+\.\w+`", cells[0]):
                known[cells[0]] = cells
    known |= {row[0]: row for row in rows}
    PAGE.write_text(HEAD + "".join(f"| {' | '.join(known[name])} |\n" for name in sorted(known)))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help="a constant (fluid.surface.hole), a room (fluid.surface) or a solver")
    parser.add_argument("--list", action="store_true", help="prints the sheet and ends")
    parser.add_argument("--all", action="store_true", help="all of the sheet")
    parser.add_argument("--short", nargs="*", metavar="CASE", help="constants without a named test: by these short forms (none named: "
                        "all in which their solver has something to compute)")
    parser.add_argument("--suites", action="store_true", help="constants without a named test: by all unit tests of their solver")
    parser.add_argument("--tests", nargs="+", default=[], metavar="TEST", help="tests (Suite.Name) or cases tried besides those of the sheet")
    parser.add_argument("--scratch", type=pathlib.Path, metavar="DIR", help="the scratch copy, kept (default: a temporary one)")
    parser.add_argument("--limit", type=float, default=600.0, metavar="S", help="a test that takes longer counts as red (default 600)")
    parser.add_argument("-j", "--jobs", type=int, default=2)
    a = parser.parse_args()
    constants = sheet(SOURCE)
    chosen = [c for c in constants if a.all or any(c.full == n or c.full.startswith(n + ".") for n in a.names)]
    for name in a.names:
        if not any(c.full == name or c.full.startswith(name + ".") for c in constants):
            parser.error(f"{name}: not on the sheet (--list)")
    if a.list:
        for c in chosen or constants:
            print(f"{c.full:<44} {c.value:<8} {c.unit}; test: {c.test}\n    {c.reason}")
        return
    if not chosen:
        parser.error("name constants or rooms, or --all")
    rows, missing, red_before = [], [], False
    with scratch_tree(a.scratch) as root:
        scratch = Scratch(root, a.jobs, a.limit)
        scratch.prepare()
        plan = []
        for c in chosen:
            tests = list(dict.fromkeys(c.tests + a.tests))
            if not tests and a.suites:
                tests = SUITES[c.solver]
            if not tests and a.short is not None:
                tests = a.short or list(short_forms(root, c.solver))
            if tests:
                plan.append((c, tests))
            else:
                print(f"{c.full}: no test named; --suites, --short or --tests")
                missing.append(c)
        if plan and not scratch.make(scratch.targets({t for _, tests in plan for t in tests})):
            sys.exit("the scratch copy does not build")
        before = {}  # what is red without any change
        for c, tests in plan:
            for t in tests:
                if t not in before:
                    before[t] = scratch.red(t)
            bad = {name for t in tests for name in before[t]}
            if bad & set(tests):
                print(f"{c.full}: red without any change: {', '.join(sorted(bad & set(tests)))}")
                red_before = True
                continue
            cells = tried(scratch, c, tests, bad)
            if set(cells) <= {"nothing", "no such value"}:
                missing.append(c)
            rows.append([f"`{c.full}`", c.value, ", ".join(tests), *cells])
            print(f"{c.full} = {c.value}: halved: {cells[0]}; doubled: {cells[1]}", flush=True)
            write(rows)
    sys.exit(2 if red_before else 1 if missing else 0)


if __name__ == "__main__":
    main()
