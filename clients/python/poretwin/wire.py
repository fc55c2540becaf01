"""Converts messages to bytes and back: one protobuf header and one raw frame per array. In an installation the description of the
messages, compiled from proto/poretwin.proto by protoc, lies beside this file. In the source tree no such description exists: importing
this module runs protoc and keeps the description in memory, so that it always belongs to the present poretwin.proto."""

from __future__ import annotations

import subprocess
from collections.abc import Iterable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import numpy.typing as npt
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory

PROTOCOL = (1, 3)
INSTALLED = Path(__file__).resolve().with_name("poretwin.binpb")
PROTO = Path(__file__).resolve().parents[3] / "proto" / "poretwin.proto"


def _compiled() -> bytes:
    if INSTALLED.exists():
        return INSTALLED.read_bytes()
    return subprocess.run(["protoc", f"--proto_path={PROTO.parent}", "--descriptor_set_out=/dev/stdout", str(PROTO)], check=True,
                          stdout=subprocess.PIPE).stdout


def _load() -> Any:
    """The content of the module that protoc would generate: a class for every message, a number for every name of an enumeration."""
    (described,) = descriptor_pb2.FileDescriptorSet.FromString(_compiled()).file
    pool = descriptor_pool.DescriptorPool()
    pool.Add(described)
    file = pool.FindFileByName(described.name)
    if hasattr(message_factory, "GetMessageClass"):
        class_of = message_factory.GetMessageClass
    else:  # protobuf before 4.22
        class_of = message_factory.MessageFactory(pool).GetPrototype
    names = {name: class_of(message) for name, message in file.message_types_by_name.items()}
    for enumeration in file.enum_types_by_name.values():
        names |= {value.name: value.number for value in enumeration.values}
    return SimpleNamespace(**names)


pb = _load()


class WireError(Exception):
    """Raised for a received message that does not follow the protocol."""


def add_array(header: Any, frames: list[Any], name: str, unit: str, values: npt.ArrayLike) -> None:
    """Appends an array of shape [n] or [n, components] to an unfinished message."""
    numbers = np.ascontiguousarray(values, dtype="<f8")
    components = 1 if numbers.ndim == 1 else numbers.shape[1]
    header.arrays.add(name=name, unit=unit, components=components, element=pb.FLOAT64_LE, n=numbers.shape[0])
    frames.append(numbers)


def encode(header: Any, frames: Iterable[Any] = ()) -> list[Any]:
    """The frames of one message."""
    return [header.SerializeToString(), *frames]


def decode(frames: list[bytes]) -> tuple[Any, dict[str, np.ndarray]]:
    """The header of a message, and its arrays as {name: values}. Sizes are checked before the values are read."""
    header = pb.Header()
    try:
        header.ParseFromString(bytes(frames[0]))
    except Exception as error:
        raise WireError(f"the first frame is not a poretwin header: {error}") from error
    if header.protocol_major != PROTOCOL[0]:
        return header, {}
    if len(frames) != len(header.arrays) + 1:
        raise WireError(f"{len(header.arrays)} arrays are announced, {len(frames) - 1} frames came")
    arrays: dict[str, np.ndarray] = {}
    for array, frame in zip(header.arrays, frames[1:]):
        size = len(memoryview(frame))
        if array.element != pb.FLOAT64_LE or array.components < 1 or size != array.n * array.components * 8:
            raise WireError(f"array '{array.name}': {array.n} points x {array.components} components do not fit a frame of {size} bytes")
        values = np.frombuffer(frame, dtype="<f8")
        arrays[array.name] = values if array.components == 1 else values.reshape(-1, array.components)
    return header, arrays
