"""A peer of a coupled run in Python: needs pyzmq, protobuf (with protoc) and numpy. docs/protocol.md tells the conversation."""

from .case import Case
from .participant import PeerError, main
from .phase import Field, Inbox, Phase, Points, Publication, Refused, Window, lattice, standard_fields

__all__ = [
    "Case", "Field", "Inbox", "PeerError", "Phase", "Points", "Publication", "Refused", "Window", "lattice", "main", "standard_fields",
]
