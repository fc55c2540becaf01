"""The command line as documented: --help, man pages, completions, the scripts of plot and bench, the table of exit codes.
Arguments: the program, the source folder, then those of unittest."""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

PROGRAM, SOURCE = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
PROCESSES = ("poretwin-fluid", "poretwin-pore", "poretwin-joint", "poretwin-solid", "poretwin-coupler")


def help_of(*words):
    return subprocess.run([*map(str, words), "--help"], capture_output=True, text=True, check=True).stdout


def options_in(text):
    return set(re.findall(r"^ +(?:-\w, ?)?(--[a-z-]+)", text, re.MULTILINE))


def commands(path=()):
    """(path, options) of the program and of every command, according to --help."""
    text = help_of(PROGRAM, *path)
    yield path, options_in(text)
    below = re.search(r"^Subcommands:\n((?: .*\n)+)", text, re.MULTILINE)
    for name in re.findall(r"^  ([a-z-]+)", below.group(1), re.MULTILINE) if below else []:
        yield from commands((*path, name))


def fnv1a(data):
    """The hash of the case file in run.toml."""
    value = 14695981039346656037
    for byte in data:
        value = (value ^ byte) * 1099511628211 % 2**64
    return value


def described(what):
    return subprocess.run([PROGRAM, "describe", what], capture_output=True, text=True, check=True).stdout


class CommandLine(unittest.TestCase):
    def told_to_man(self, program, path, options):
        text = described(f"{program}.1").replace("\\-", "-")
        if path:
            begin = re.search(rf"^\.SS {program} {' '.join(path)}( |$)", text, re.MULTILINE)
            self.assertTrue(begin, path)
            text = re.split(r"^\.S[SH] ", text[begin.end():], flags=re.MULTILINE)[0]
        for option in options:
            self.assertIn(f"\\fB{option}\\fR", text, path)

    def told_to_shells(self, program, path, options):
        bash, zsh, fish = (described(f"{program}.{shell}") for shell in ("bash", "zsh", "fish"))
        words = re.search(rf"^    '{' '.join(path)}'\) words=\"(.*)\" ;;$", bash, re.MULTILINE).group(1).split()
        block = re.search(rf"^    '{' '.join(path)}'\)\n(.*?) ;;$", zsh, re.MULTILINE | re.DOTALL).group(1)
        for option in options:
            self.assertIn(option, words, path)
            self.assertIn(f"'*{option}[", block, path)
            self.assertRegex(fish, rf"(?m)^complete -c {program} .*{path[-1] if path else ''}.*-l {option[2:]} ")

    def test_man_pages_and_completions_have_every_option_of_every_command(self):
        found = list(commands())
        self.assertGreater(len(found), 14)
        for path, options in found:
            self.told_to_man("poretwin", path, options)
            self.told_to_shells("poretwin", path, options)
        for process in PROCESSES:
            options = options_in(help_of(PROGRAM.parent / process))
            self.assertGreater(len(options), 14)
            self.told_to_man(process, (), options)
            self.told_to_shells(process, (), options)

    def test_they_are_well_formed(self):
        for program in ("poretwin", *PROCESSES):
            with tempfile.TemporaryDirectory() as folder:
                for form in ("1", "bash", "zsh", "fish"):
                    (pathlib.Path(folder) / form).write_text(described(f"{program}.{form}"))
                for command in (["man", "--warnings", "-Tutf8", "-l", "1"], ["bash", "-n", "bash"], ["zsh", "-n", "zsh"], ["fish", "-n", "fish"]):
                    if shutil.which(command[0]):
                        done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
                        self.assertEqual((done.returncode, done.stderr), (0, ""), command)

    def test_completion_in_bash_offers_what_fits(self):
        def offered(*words):
            script = described("poretwin.bash") + f"COMP_WORDS=({' '.join(map(repr, words))}); COMP_CWORD={len(words) - 1}; _poretwin; printf '%s\\n' \"${{COMPREPLY[@]}}\""
            return subprocess.run(["bash", "-c", script], capture_output=True, text=True, check=True, env={"PATH": f"{PROGRAM.parent}:/usr/bin:/bin"}).stdout.split()

        self.assertEqual(offered("poretwin", "saf"), ["safety"])
        self.assertEqual(offered("poretwin", "run", "--unt"), ["--until"])
        self.assertEqual(offered("poretwin", "run", "terzag"), ["terzaghi"])
        self.assertEqual(offered("poretwin", "plot", "--phase", "f"), ["fluid"])
        self.assertEqual(offered("poretwin", "peer", "conf"), ["conformance"])

    def test_scripts_take_the_options_that_the_program_declares(self):
        for command, script in (("plot", "cli/plot.py"), ("report", "cli/report.py"), ("view", "view/server.py"), ("bench", "bench/study.py")):
            self.assertEqual(options_in(help_of(PROGRAM, command)) - {"--json"}, options_in(help_of("/usr/bin/python3", "-B", SOURCE / script)))

    def test_a_report_shows_the_defaults_of_materials(self):
        with tempfile.TemporaryDirectory() as folder:
            run, case = pathlib.Path(folder) / "run", pathlib.Path(folder) / "case.toml"
            run.mkdir()
            case.write_text('[[soil]]\nmodel = "mu_i"\ngrain_diameter = 0.002\n[[soil]]\nmodel = "modified_cam_clay"\n')
            (run / "run.toml").write_text(f'case_file = "{case}"\n[identity]\n"case file" = "{fnv1a(case.read_bytes()):016x}"\n')
            subprocess.run([PROGRAM, "report", run], check=True, capture_output=True)
            page = (run / "report.html").read_text()
        for shown in ([0.38, 0.64, 0.279, 0.005, 2, 0, 0.585, 0.3333], [0.1, 0.02, 1, 1]):
            self.assertIn("".join(f'<td class="number">{v:g}</td>' for v in shown), page)
        self.assertIn('<td class="number">1</td><td></td></tr>', page, "no preconsolidation pressure: it follows from the ratio")

    def test_exit_codes_are_the_same_in_help_docs_and_man_page(self):
        rows = re.findall(r"^  +(\d+)  (.+)$", help_of(PROGRAM).split("Exit codes:")[1], re.MULTILINE)
        self.assertEqual([int(code) for code, _ in rows], [0, 1, 2, 3, 4, 5, 6, 130])
        docs = (SOURCE / "docs" / "protocol.md").read_text().split("## Exit codes")[1].split("## ")[0]
        self.assertEqual(re.findall(r"^\| (\d+) \| (.+) \|$", docs, re.MULTILINE), rows)
        man = described("poretwin.1").split(".SH EXIT STATUS")[1].replace("\\-", "-").replace("\\&", "")
        self.assertEqual(re.findall(r"^\.B (\d+)\n(.+)$", man, re.MULTILINE), rows)
        for process in PROCESSES:
            self.assertEqual(re.findall(r"^  +(\d+)  (.+)$", help_of(PROGRAM.parent / process).split("Exit codes:")[1], re.MULTILINE), rows)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
