#!/usr/bin/python3
"""docs/gallery: it contains every case, its links are valid, and the program accepts its commands. Arguments: the program, the source folder, then those of
unittest."""
import pathlib
import re
import shlex
import subprocess
import sys
import tomllib
import unittest

PROGRAM, SOURCE = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
sys.dont_write_bytecode = True
sys.path.insert(0, str(SOURCE / "bench"))
import gallery  # noqa: E402

PAGE = SOURCE / "docs" / "gallery" / "README.md"
LARGEST, LARGEST_SUM = 60_000, 1_500_000  # bytes: pictures stay in the repository's history for ever


def cases():
    return [case for _, group in gallery.groups() for case in group]


def commands():
    """Every command of the page, split into words."""
    return [shlex.split(line) for block in re.findall(r"^```\n(.*?)^```", PAGE.read_text(), re.MULTILINE | re.DOTALL) for line in block.splitlines()]


def option(words, name):
    return [words[i + 1] for i, word in enumerate(words) if word == name]


class Gallery(unittest.TestCase):
    def test_every_case_stands_in_it_once(self):
        self.assertEqual(sorted(case["name"] for case in cases()), sorted(path.parent.name for path in (SOURCE / "cases").glob("*/case.toml")))

    def test_the_page_is_the_one_that_its_script_writes(self):
        found = gallery.json.loads((PAGE.parent / "found.json").read_text())
        self.assertEqual(PAGE.read_text(), gallery.page(found), "bench/gallery.py --page writes it anew")

    def test_links_and_pictures_are_there(self):
        text = PAGE.read_text()
        for link in re.findall(r"\]\(([^)\s]+)\)", text):
            if link.startswith("#"):
                self.assertIn(f'<a id="{link[1:]}"></a>', text)
            elif "://" not in link:
                self.assertTrue((PAGE.parent / link.partition("#")[0]).exists(), link)

    def test_every_case_has_a_picture_and_pictures_are_small(self):
        sizes = {path.name: path.stat().st_size for path in PAGE.parent.glob("*.png")}
        found = gallery.json.loads((PAGE.parent / "found.json").read_text())
        names = sorted(case["name"] for case in cases())
        self.assertEqual(sorted(found), names, "bench/gallery.py CASE makes what is missing")
        self.assertEqual(sorted(sizes), [f"{name}.png" for name in names])
        self.assertLessEqual(max(sizes.values()), LARGEST)
        self.assertLessEqual(sum(sizes.values()), LARGEST_SUM)

    def test_commands_are_ones_that_the_program_takes(self):
        helps = {command: subprocess.run([PROGRAM, command, "--help"], capture_output=True, text=True, check=True).stdout for command in ("run", "safety", "plot")}
        self.assertGreater(len(commands()), 80)
        for words in commands():
            self.assertEqual(words[0], "poretwin")
            for word in words[1:]:
                if word.startswith("--"):
                    self.assertIn(f"{word} ", helps[words[1]], words)
            if words[1] == "plot":
                case = pathlib.Path(words[2]).name
                scene = tomllib.loads((SOURCE / "cases" / case / "case.toml").read_text())
                for gauge in option(words, "--gauge"):
                    names = [g["name"] for g in scene["gauge"]]  # for a vector sum plot needs a component
                    self.assertTrue(gauge in names or gauge.rpartition("_")[0] in names, words)
            else:
                case = words[2]
                done = subprocess.run([PROGRAM, "check", *gallery.check_of(shlex.join(words))], cwd=SOURCE, capture_output=True, text=True)
                self.assertEqual(done.returncode, 0, f"{words}: {done.stderr}")
            file = SOURCE / case if case.endswith(".toml") else SOURCE / "cases" / case / "case.toml"
            self.assertTrue(file.exists(), words)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
