"""Messages as bytes: one protobuf header and one raw frame per array. proto/poretwin.proto is compiled on first use."""

import importlib.util
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

PROTOCOL = (1, 2)
PROTO = Path(__file__).resolve().parents[3] / "proto" / "poretwin.proto"


def _generate(folder):
    with tempfile.TemporaryDirectory(dir=folder) as scratch:
        subprocess.run(["protoc", f"--proto_path={PROTO.parent}", f"--python_out={scratch}", str(PROTO)], check=True)
        os.replace(Path(scratch) / "poretwin_pb2.py", folder / "poretwin_pb2.py")


def _load():
    """The module made from the messages: beside this file, or in the temporary folder where that cannot be written."""
    folder = Path(__file__).resolve().parent / "generated"
    try:
        folder.mkdir(exist_ok=True)
        writable = os.access(folder, os.W_OK)
    except OSError:
        writable = False
    if not writable:
        folder = Path(tempfile.gettempdir()) / f"poretwin-python-{os.getuid()}"
        folder.mkdir(mode=0o700, exist_ok=True)
    module = folder / "poretwin_pb2.py"
    if not module.exists() or module.stat().st_mtime < PROTO.stat().st_mtime:
        _generate(folder)
    spec = importlib.util.spec_from_file_location("poretwin_pb2", module)
    loaded = importlib.util.module_from_spec(spec)
    sys.modules.setdefault("poretwin_pb2", loaded)
    spec.loader.exec_module(loaded)
    return loaded


pb = _load()


class WireError(Exception):
    """What came in is no message of this protocol."""


def add_array(header, frames, name, unit, values):
    """Appends [n] or [n, components] values to a message under way."""
    values = np.ascontiguousarray(values, dtype="<f8")
    components = 1 if values.ndim == 1 else values.shape[1]
    header.arrays.add(name=name, unit=unit, components=components, element=pb.FLOAT64_LE, n=values.shape[0])
    frames.append(values)


def encode(header, frames=()):
    return [header.SerializeToString(), *frames]


def decode(frames):
    """Header and {name: values}; sizes are checked before anything is read."""
    header = pb.Header()
    try:
        header.ParseFromString(bytes(frames[0]))
    except Exception as error:
        raise WireError(f"the first frame is not a poretwin header: {error}") from error
    if header.protocol_major != PROTOCOL[0]:
        return header, {}
    if len(frames) != len(header.arrays) + 1:
        raise WireError(f"{len(header.arrays)} arrays are announced, {len(frames) - 1} frames came")
    arrays = {}
    for array, frame in zip(header.arrays, frames[1:]):
        size = len(memoryview(frame))
        if array.element != pb.FLOAT64_LE or array.components < 1 or size != array.n * array.components * 8:
            raise WireError(f"array '{array.name}': {array.n} points x {array.components} components do not fit a frame of {size} bytes")
        values = np.frombuffer(frame, dtype="<f8")
        arrays[array.name] = values if array.components == 1 else values.reshape(-1, array.components)
    return header, arrays
