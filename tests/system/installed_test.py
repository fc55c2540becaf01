"""The result of `cmake --install`: programs that run from any folder, a library for solvers outside the source tree, packages for Python. Arguments:
build folder, source folder, then those of unittest."""

import importlib.util
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

BUILD, SOURCE = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
CASE = SOURCE / "clients" / "python" / "examples" / "seepage.toml"
VERSION = "0.1.0"


def run(*command, **options):
    """Runs a command and returns its stdout; after a failure shows all its output."""
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, **options)
    if done.returncode != 0:
        raise AssertionError(f"{' '.join(map(str, command))}: exit code {done.returncode}\n{done.stdout}\n{done.stderr}")
    return done.stdout


class Installed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="poretwin-install-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        run("cmake", "--install", BUILD, "--prefix", cls.folder / "first")
        cls.prefix = cls.folder / "moved"
        (cls.folder / "first").rename(cls.prefix)  # nothing may depend on the folder of installation
        cls.program = cls.prefix / "bin" / "poretwin"
        cls.library = next(cls.prefix.rglob("libporetwin.a")).parent

    def conforms(self, solver, **options):
        report = run(self.program, "peer", "conformance", CASE, solver, **options)
        self.assertIn("13 checks passed, 0 failed", report)

    def built_by_cmake(self, target):
        example, build = self.folder / target / "source", self.folder / target / "build"
        shutil.copytree(SOURCE / "clients" / "cpp", example)
        text = (example / "CMakeLists.txt").read_text()
        (example / "CMakeLists.txt").write_text(text.replace("poretwin::participant)", f"poretwin::{target})"))
        run("cmake", "-S", example, "-B", build, "-G", "Ninja", f"-DCMAKE_PREFIX_PATH={self.prefix}")
        run("cmake", "--build", build)
        return build / "rigid-solid"

    def test_nothing_refers_to_the_source_tree_or_to_the_first_prefix(self):
        for path in self.prefix.rglob("*"):
            if path.is_file():
                data = path.read_bytes()
                for place in (SOURCE, BUILD, self.folder / "first"):
                    self.assertNotIn(str(place).encode(), data, path)

    def test_a_case_runs_by_its_name_in_any_folder(self):
        told = json.loads(run(self.program, "run", "terzaghi", "--until", "0.01", "--json", "-", cwd=self.folder))
        self.assertEqual(told["exit"], 0)
        out = self.folder / "runs" / "terzaghi"
        self.assertEqual(told["out"], "runs/terzaghi")
        self.assertTrue(list((out / "pictures").glob("*.png")))
        self.assertIn("cohesive_slope", run(self.program, "describe", "cases", cwd=self.folder))
        self.assertFalse(list(self.prefix.rglob("__pycache__")), "what is installed is not written to")

    def test_versions_are_one(self):
        for name in ("poretwin", "poretwin-fluid", "poretwin-pore", "poretwin-joint", "poretwin-solid", "poretwin-coupler"):
            self.assertRegex(run(self.prefix / "bin" / name, "--version"), rf"^{name} {VERSION} .*, \w+, .+")
        python = {**os.environ, "PYTHONPATH": next(self.prefix.rglob("dist-packages"))}
        told = run("/usr/bin/python3", "-B", "-c", "import importlib.metadata as m, poretwin as p; print(m.version('poretwin'), p.__version__, p.__file__)",
                   env=python, cwd=self.folder).split()
        self.assertEqual(told[:2], [VERSION, VERSION])
        self.assertTrue(told[2].startswith(str(self.prefix)))

    def test_a_solver_by_find_package_conforms(self):
        self.conforms(self.built_by_cmake("participant"))

    def test_a_solver_on_the_shared_library_starts(self):
        solver = self.built_by_cmake("participant_shared")
        self.assertIn("libporetwin.so", run("objdump", "-p", solver))
        self.assertIn("--connect ADDRESS", run(solver, "--help"))

    def test_a_solver_by_pkg_config_conforms(self):
        paths = {**os.environ, "PKG_CONFIG_PATH": str(self.library / "pkgconfig"), "LD_LIBRARY_PATH": str(self.library)}
        flags = run("pkg-config", "--cflags", "--libs", "poretwin", env=paths).split()
        self.assertEqual(run("pkg-config", "--modversion", "poretwin", env=paths).strip(), VERSION)
        solver = self.folder / "by-pkg-config"
        run("c++", "-std=c++20", SOURCE / "clients" / "cpp" / "rigid_solid.cpp", *flags, "-o", solver, env=paths)
        self.conforms(solver, env=paths)

    def test_public_headers_stand_alone(self):
        headers = sorted(path.relative_to(self.prefix / "include") for path in (self.prefix / "include").rglob("*.hpp"))
        self.assertEqual(len(headers), 9)
        for header in headers:
            self.assertNotIn('#include "', (self.prefix / "include" / header).read_text(), header)


class PythonPackage(unittest.TestCase):
    @unittest.skipUnless(importlib.util.find_spec("build") and importlib.util.find_spec("setuptools"), "needs python3-build, python3-setuptools")
    def test_the_wheel_is_built_without_network_and_works(self):
        with tempfile.TemporaryDirectory() as folder:
            place = pathlib.Path(folder)
            shutil.copytree(SOURCE / "clients" / "python", place / "tree" / "clients" / "python")
            shutil.copytree(SOURCE / "proto", place / "tree" / "proto")
            nowhere = {**os.environ, "PIP_NO_INDEX": "1", "http_proxy": "http://127.0.0.1:9", "https_proxy": "http://127.0.0.1:9"}
            run("/usr/bin/python3", "-m", "build", "--wheel", "--no-isolation", "-o", place, place / "tree" / "clients" / "python", env=nowhere)
            wheel = next(place.glob("*.whl"))
            self.assertEqual(wheel.name, f"poretwin-{VERSION}-py3-none-any.whl")
            shutil.unpack_archive(wheel, place / "site", "zip")
            run("/usr/bin/python3", "-c", "import poretwin; poretwin.wire.pb.Header()", cwd=place / "site")
            self.assertTrue((place / "site" / "poretwin" / "py.typed").exists())

    @unittest.skipUnless(shutil.which("mypy"), "needs mypy")
    def test_type_hints_hold(self):
        with tempfile.TemporaryDirectory() as cache:
            run(shutil.which("mypy"), "--cache-dir", cache, "--python-executable", "/usr/bin/python3", "poretwin", cwd=SOURCE / "clients" / "python")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
