"""Converts the state of a phase to bytes and back. The bytes contain data only. Unlike a pickle they cannot contain code, so that a
file from an untrusted source can do no harm beyond wrong numbers.

Format: MAGIC, the length of a JSON text, the text, then the arrays to which it refers, little-endian, one after the other."""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np

from .phase import Points

MAGIC = b"poretwin python state 1\n"
POINTS = ("position", "volume", "smoothing_length", "n_active", "owner", "revision")


class StateError(ValueError):
    """Raised for a value that cannot be stored as data, and for bytes that dump() did not make."""


def dump(value: Any) -> bytes:
    """The bytes of a value. Allowed are None, bool, int, float, str, bytes, lists, tuples, dicts whose keys are str, arrays of numbers
    and Points."""
    arrays: list[bytes] = []
    size = 0

    def array(values: Any) -> dict[str, Any]:
        nonlocal size
        raw = np.ascontiguousarray(values, dtype=values.dtype.newbyteorder("<")).tobytes()
        arrays.append(raw)
        size += len(raw)
        return {"array": values.dtype.newbyteorder("<").str, "shape": list(values.shape), "at": size - len(raw), "size": len(raw)}

    def plain(value: Any, path: str) -> Any:
        if value is None or isinstance(value, (bool, int, str)) and not isinstance(value, np.generic):
            return value
        if isinstance(value, float) and not isinstance(value, np.generic):
            return {"float": value.hex()}  # exact, and also possible for infinities and NaN
        if isinstance(value, (np.ndarray, np.generic)) and np.asarray(value).dtype.kind in "biuf":
            return array(np.asarray(value)) | {"scalar": isinstance(value, np.generic)}
        if isinstance(value, bytes):
            return {"bytes": value.hex()}
        if isinstance(value, (list, tuple)):
            return {type(value).__name__ if type(value) in (list, tuple) else "list": [plain(x, f"{path}[{i}]") for i, x in enumerate(value)]}
        if isinstance(value, dict) and all(isinstance(key, str) for key in value):
            return {"dict": {key: plain(x, f"{path}.{key}") for key, x in value.items()}}
        if isinstance(value, Points):
            return {"points": {name: plain(getattr(value, name), f"{path}.{name}") for name in POINTS}}
        raise StateError(f"{path or 'the state'} is a {type(value).__name__}: expected numbers, text, arrays, lists, dicts or Points; "
                         "override state() and resume() of the phase to keep it in another form")

    text = json.dumps(plain(value, "")).encode()
    return b"".join([MAGIC, struct.pack("<Q", len(text)), text, *arrays])


def load(data: bytes) -> Any:
    """The value whose bytes dump() made. Raises StateError for other bytes."""
    start = len(MAGIC) + 8
    if data[:len(MAGIC)] != MAGIC or len(data) < start:
        raise StateError("not a state of this program: it does not begin as one")
    (length,) = struct.unpack("<Q", data[len(MAGIC):start])
    base = start + length

    def value_of(node: Any) -> Any:
        if node is None or isinstance(node, (bool, int, str)):
            return node
        kind = next(iter(node))
        content = node[kind]
        if kind == "float":
            return float.fromhex(content)
        if kind == "array":
            dtype = np.dtype(content)
            if dtype.kind not in "biuf":
                raise StateError(f"an array of {dtype}")
            at, size = base + int(node["at"]), int(node["size"])
            if node["at"] < 0 or size < 0 or at + size > len(data):
                raise StateError("an array lies beyond the end of the state")
            values = np.frombuffer(data[at:at + size], dtype=dtype).reshape(node["shape"]).astype(dtype.newbyteorder("="))
            return values[()] if node["scalar"] else values
        if kind == "bytes":
            return bytes.fromhex(content)
        if kind in ("list", "tuple"):
            return (list if kind == "list" else tuple)(value_of(x) for x in content)
        if kind == "dict":
            return {key: value_of(x) for key, x in content.items()}
        if kind == "points":
            return Points(**{name: value_of(content[name]) for name in POINTS})
        raise StateError(f"unknown kind '{kind}'")

    try:
        return value_of(json.loads(data[start:base]))
    except StateError:
        raise
    except Exception as error:  # a damaged text can cause any exception above
        raise StateError(f"damaged: {type(error).__name__}: {error}") from error
