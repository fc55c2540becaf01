"""Library for a solver in Python that takes part in a coupled run. Needs pyzmq, protobuf and numpy (in the source tree, protoc as well).
docs/protocol.md describes the messages."""

from .case import Case
from .participant import PeerError, main
from .phase import Field, Inbox, Phase, Points, Publication, Refused, Window, lattice, standard_fields
from .version import __version__

__all__ = [
    "Case", "Field", "Inbox", "PeerError", "Phase", "Points", "Publication", "Refused", "Window", "__version__", "lattice", "main", "standard_fields",
]
