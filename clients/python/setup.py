"""Adds the messages, compiled by protoc, to the wheel; all other settings are in pyproject.toml."""

import subprocess
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

PROTO = Path(__file__).resolve().parents[2] / "proto" / "poretwin.proto"


class BuildWithMessages(build_py):
    def run(self):
        super().run()
        target = Path(self.build_lib) / "poretwin" / "poretwin.binpb"
        subprocess.run(["protoc", f"--proto_path={PROTO.parent}", f"--descriptor_set_out={target}", str(PROTO)], check=True)


setup(cmdclass={"build_py": BuildWithMessages})
