"""Messages as bytes: one protobuf header and one raw frame per array. proto/poretwin.proto is compiled when this is imported, in
memory: no generated file could be somebody else's."""

import subprocess
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory

PROTOCOL = (1, 2)
PROTO = Path(__file__).resolve().parents[3] / "proto" / "poretwin.proto"


def _load():
    """What protoc would write as a module: a class for every message, a number for every name of an enumeration."""
    compiled = subprocess.run(["protoc", f"--proto_path={PROTO.parent}", "--descriptor_set_out=/dev/stdout", str(PROTO)], check=True,
                              stdout=subprocess.PIPE).stdout
    (described,) = descriptor_pb2.FileDescriptorSet.FromString(compiled).file
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
