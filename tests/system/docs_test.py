#!/usr/bin/python3
"""Checks that the documentation names only what exists. Argument: the source folder; then those of unittest.

Links of all pages lead to existing files and headings; paths, functions, types and tests that pages name exist; the sources include only what
docs/architecture.md allows; the solvers' chosen numbers have a unit, a reason and an existing test. docs/notebook is a record: only its links are checked. `Itself` shows on an invented tree that each check can fail."""
import functools
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

SOURCE = pathlib.Path(sys.argv[1]).resolve()
CODE = {".cpp", ".hpp", ".in", ".proto", ".py", ".toml", ".sh", ".txt", ".json", ".cmake"}
SKIPPED = {"build", "runs", "site", "node_modules", "__pycache__"}


class Tree:
    """A source folder and the faults of its documentation: lists of lines, empty where there is none."""

    def __init__(self, root):
        self.root = root
        self.files = sorted(p for top in root.iterdir() if top.name not in SKIPPED and not top.name.startswith(".")
                            for p in ([top] if top.is_file() else top.rglob("*")) if p.is_file() and not SKIPPED & set(p.parts))
        self.pages = [p for p in self.files if p.suffix == ".md" and (p.parent == root or "docs" in p.relative_to(root).parts[:1] or p.name == "README.md")]
        self.tops = {p.relative_to(root).parts[0] for p in self.files if p.parent != root}

    def name(self, page):
        return page.relative_to(self.root).as_posix()

    @functools.cache
    def prose(self, page):
        """The lines of a page outside fenced blocks, with their numbers."""
        lines, fenced = [], False
        for number, line in enumerate(page.read_text().splitlines(), 1):
            if line.lstrip().startswith("```"):
                fenced = not fenced
            elif not fenced:
                lines.append((number, line))
        return lines

    @functools.cache
    def anchors(self, page):
        """Anchors of a page: those that GitHub makes of headings, and explicit ones."""
        found = set(re.findall(r'<a id="([^"]+)"', page.read_text()))
        for _, line in self.prose(page):
            if heading := re.match(r"#+\s+(.*)", line):
                words = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading[1]).replace("`", "").strip().lower()
                slug = re.sub(r"[^\w\- ]", "", words).replace(" ", "-")
                found.add(next(s for s in [slug, *(f"{slug}-{i}" for i in range(1, 99))] if s not in found))
        return found

    def links(self, page):
        for number, line in self.prose(page):
            for target in re.findall(r"\]\(([^)\s]+)(?:\s+\"[^\"]*\")?\)", re.sub(r"`[^`]*`", "", line)):
                if "://" not in target and not target.startswith("mailto:"):
                    yield number, *target.partition("#")[::2]

    def wrong_links(self):
        wrong = []
        for page in self.pages:
            for number, path, anchor in self.links(page):
                target = (page.parent / path).resolve() if path else page
                if not target.exists():
                    wrong.append(f"{self.name(page)}:{number}: no file {path}")
                elif anchor and target.suffix == ".md" and anchor not in self.anchors(target):
                    wrong.append(f"{self.name(page)}:{number}: no heading #{anchor} in {self.name(target)}")
        return wrong

    def lost_pages(self):
        """Pages below docs to which no chain of links leads from docs/index.md."""
        seen, ahead = set(), [self.root / "docs" / "index.md"]
        while ahead:
            page = ahead.pop()
            if page in seen or page not in self.pages:
                continue
            seen.add(page)
            ahead += [(page.parent / path).resolve() for _, path, _ in self.links(page) if path]
        return [f"{self.name(p)}: no link leads here from docs/index.md" for p in self.pages if self.name(p).startswith("docs/") and p not in seen]

    def spans(self, page):
        for number, line in self.prose(page):
            for span in re.findall(r"`([^`]+)`", line):
                yield number, span

    def is_path(self, span):
        return re.fullmatch(r"[\w.*-]+(/[\w.*-]+)+/?", span) and span.split("/")[0] in self.tops and not re.search(r"/[A-Z]+(/|$)", span)

    def wrong_paths(self):
        wrong = []
        for page in self.pages:
            if "docs/notebook/" in self.name(page):
                continue
            for number, span in self.spans(page):
                if self.is_path(span) and not any(self.root.glob(span.rstrip("/"))):
                    wrong.append(f"{self.name(page)}:{number}: no file {span}")
        for file in self.files:  # pages that any file names, also in a comment
            if file.suffix in CODE | {".md"} and file.name != "docs_test.py":
                for page in set(re.findall(r"\bdocs/[\w./-]+\.md\b", file.read_text(errors="replace"))):
                    if not (self.root / page).exists():
                        wrong.append(f"{self.name(file)}: no page {page}")
        return wrong

    @functools.cached_property
    def code(self):
        """Text of the sources without comments."""
        texts = {}
        for file in self.files:
            if file.suffix in CODE and not self.name(file).startswith("docs/"):
                comment = r"//.*" if file.suffix in {".cpp", ".hpp", ".proto"} else r"(?<!\S)#(?!include).*"
                texts[file] = re.sub(comment, "", file.read_text(errors="replace"))
        return texts

    @functools.cached_property
    def words(self):
        """Every word of the sources, with the files that contain it."""
        found = {word: set() for word in {p.stem for p in self.files} | self.tops}
        for file, text in self.code.items():
            for word in set(re.findall(r"[A-Za-z_]\w*", text)):
                found.setdefault(word, set()).add(file)
        return found

    @functools.cached_property
    def tests(self):
        return {f"{suite}.{test}" for text in self.code.values() for suite, test in re.findall(r"\bTEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)\s*\)", text)}

    def is_member(self, owner, member):
        declares = re.compile(rf"\b(?:class|struct|namespace)\s+(?:alignas\([^)]*\)\s*)?{owner}\b")
        return any(declares.search(self.code[file]) for file in self.words.get(owner, set()) & self.words.get(member, set()))

    def is_known(self, span):
        if re.fullmatch(r"[A-Z]\w*\.(\*|[A-Z]\w*\*?)", span):  # a test, or all tests that begin so
            return any(t == span or span.endswith("*") and t.startswith(span[:-1]) for t in self.tests)
        if re.fullmatch(r"[A-Za-z_]\w*(::[A-Za-z_]\w*)+", span):
            owner, member = span.split("::")[-2:]
            return self.is_member(owner, member)
        return all(word in self.words for word in re.findall(r"[A-Za-z_]\w{2,}", span))

    def wrong_symbols(self):
        pages = [p for p in self.pages if self.name(p) == "docs/architecture.md" or self.name(p).startswith("docs/theory/")]
        return [f"{self.name(page)}:{number}: not in the sources: {span}" for page in pages for number, span in self.spans(page)
                if not self.is_path(span) and not self.is_known(span)]

    def wrong_numbers(self):
        """Numbers of a solver's numerics folder without reason and unit, or whose test neither exists nor is said to be unknown."""
        wrong = []
        for file in self.files:
            if file.suffix != ".hpp" or not re.search(r"solver/numerics$", self.name(file.parent)):
                continue
            text = file.read_text()
            for number in re.finditer(r"\binline constexpr [\w:]+(?:<[^>]+>)? (\w+)", text):
                entry = re.search(r"(?:/// .*\n)+/// Unit: .+\. Test: (.+)\.\n$", text[:number.start()])
                if not entry:
                    wrong.append(f"{self.name(file)}: {number[1]} without reason, unit or test")
                elif not re.match(r"none known( |$)", entry[1]):
                    test = entry[1].removesuffix(" (untried)")
                    if test not in self.tests and not (self.root / "cases" / test / "verify.toml").exists():
                        wrong.append(f"{self.name(file)}: {number[1]}: no test {test}")
        return wrong

    @functools.cached_property
    def rooms(self):
        """For each module the modules that it may include, from the table of docs/architecture.md."""
        rows = (re.match(r"\| ([\w/]+) \|.*\| ([\w/, ]*)\|$", line) for _, line in self.prose(self.root / "docs" / "architecture.md"))
        return {row[1]: {w.strip() for w in row[2].split(",")} for row in rows if row and (self.root / row[1]).is_dir()}

    def room_of(self, folder):
        """The innermost module (folder with a row in that table) that contains a folder; outside of all of them, the first part of its path."""
        parts = folder.split("/")
        inside = ("/".join(parts[:n]) for n in range(len(parts), 0, -1))
        return next((room for room in inside if room in self.rooms), parts[0])

    def wrong_includes(self):
        wrong = []
        for file, text in self.code.items():
            if file.suffix not in {".cpp", ".hpp"} or file.parent == self.root:
                continue
            room = self.room_of(self.name(file.parent))
            for folder in re.findall(r'#include ["<]([\w/]+)/[\w.]+[">]', text) if room in self.rooms else []:
                seen = self.room_of(folder)
                if folder.split("/")[0] in self.tops | {"poretwin"} and seen not in self.rooms[room] | {room}:
                    wrong.append(f"{self.name(file)}: includes {seen}, which docs/architecture.md does not allow {room}")
        return wrong

    def reductions_of_one_rank(self):
        """Sums and maxima that a solver forms without Domain, so that several ranks would decide differently. A comment on the line above
        says why one may."""
        wrong = []
        for file in self.code:
            if file.suffix in {".cpp", ".hpp"} and self.name(file).split("/")[0].endswith("_solver"):
                lines = ["", *file.read_text().splitlines()]
                wrong += [f"{self.name(file)}:{n}: a reduction of one rank" for n, line in enumerate(lines)
                          if "one_rank::" in line and not lines[n - 1].lstrip().startswith("//")]
        return wrong


class Docs(unittest.TestCase):
    maxDiff = None
    tree = Tree(SOURCE)

    def test_links_lead_somewhere(self):
        self.assertEqual(self.tree.wrong_links(), [])

    def test_every_page_is_found_from_the_index(self):
        self.assertEqual(self.tree.lost_pages(), [])

    def test_files_that_pages_name_exist(self):
        self.assertEqual(self.tree.wrong_paths(), [])

    def test_symbols_and_tests_that_pages_name_exist(self):
        self.assertEqual(self.tree.wrong_symbols(), [])

    def test_chosen_numbers_have_unit_reason_and_test(self):
        self.assertEqual(self.tree.wrong_numbers(), [])

    def test_chosen_numbers_are_all_on_the_sheet(self):
        listed = subprocess.run([sys.executable, SOURCE / "bench" / "sensitivity.py", "--list"], capture_output=True, text=True)
        self.assertEqual(listed.returncode, 0, listed.stderr)
        self.assertIn("fluid.exchange.body_density", listed.stdout)

    def test_solvers_reduce_over_all_ranks(self):
        self.assertEqual(self.tree.reductions_of_one_rank(), [])

    def test_rooms_include_what_they_may(self):
        with_code = {self.tree.room_of(self.tree.name(f.parent)) for f in self.tree.files if f.suffix in {".cpp", ".hpp"} and f.parent != SOURCE}
        self.assertEqual(with_code - set(self.tree.rooms) - {"tests", "bench", "docs"}, set(), "rooms without a row")
        self.assertEqual(self.tree.wrong_includes(), [])


class Itself(unittest.TestCase):
    """Correct documentation passes, and each kind of fault is found once."""

    def test_each_judgement_can_fail(self):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder).resolve()
            files = {
                "docs/index.md": "[a](architecture.md#what-it-is) [t](theory/t.md) [gone](gone.md) [no](architecture.md#nothing)\n```\n[not a link](x.md)\n```\n",
                "docs/architecture.md": "# What it is\n`fluid/a.cpp` `fluid/b.cpp` `Fluid::advance` `Fluid::vanish` `Case.Works*` `Case.Fails`\n\n"
                                        "| Room | Holds | May include |\n| --- | --- | --- |\n| fluid | water | common, fluid/deep |\n| fluid/deep | | |\n",
                "docs/theory/t.md": "`advance` `renamed_since`\n",
                "docs/alone.md": "Nobody links here.\n",
                "fluid/a.cpp": '#include "common/x.hpp"\n#include "solid/x.hpp"  // docs/never.md\nstruct Fluid { void advance(); };  // renamed_since\n'
                               "TEST(Case, WorksWell) {}\n",
                "common/x.hpp": "",
                "fluid/deep/b.hpp": '#include "common/x.hpp"\n#include "fluid/deep/c.hpp"\n#include <vector>\n',
                "solid/x.hpp": "",
                "solid_solver/sums.cpp": "double a = one_rank::dot(x, y);\n// Here only: it is a hint.\ndouble b = one_rank::dot(x, y);\n",
                "fluid_solver/numerics/room.hpp": "/// A.\n/// Unit: 1. Test: Case.WorksWell (untried).\ninline constexpr double tested = 1.0;\n"
                                                  "/// A.\n/// Unit: 1. Test: none known.\ninline constexpr int untested = 1;\n"
                                                  "/// A.\n/// Unit: 1. Test: Case.Gone.\ninline constexpr double lost = 1.0;\n"
                                                  "/// Unit: 1. Test: none known.\ninline constexpr double unreasoned = 1.0;\n"
                                                  "inline constexpr double bare = 1.0;\n",
            }
            for name, text in files.items():
                (root / name).parent.mkdir(parents=True, exist_ok=True)
                (root / name).write_text(text)
            tree = Tree(root)
            self.assertEqual(tree.wrong_links(), ["docs/index.md:1: no file gone.md", "docs/index.md:1: no heading #nothing in docs/architecture.md"])
            self.assertEqual(tree.lost_pages(), ["docs/alone.md: no link leads here from docs/index.md"])
            self.assertEqual(tree.wrong_paths(), ["docs/architecture.md:2: no file fluid/b.cpp", "fluid/a.cpp: no page docs/never.md"])
            self.assertEqual(tree.wrong_symbols(), ["docs/architecture.md:2: not in the sources: Fluid::vanish", "docs/architecture.md:2: not in the sources: Case.Fails",
                                                    "docs/theory/t.md:1: not in the sources: renamed_since"])
            self.assertEqual(tree.wrong_numbers(), [f"fluid_solver/numerics/room.hpp: {what}" for what in
                                                    ("lost: no test Case.Gone", "unreasoned without reason, unit or test", "bare without reason, unit or test")])
            self.assertEqual(tree.reductions_of_one_rank(), ["solid_solver/sums.cpp:1: a reduction of one rank"])
            self.assertEqual(tree.wrong_includes(), ["fluid/a.cpp: includes solid, which docs/architecture.md does not allow fluid",
                                                     "fluid/deep/b.hpp: includes common, which docs/architecture.md does not allow fluid/deep"])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
