"""The base class of a solver, and the data that a solver (a phase) publishes and receives, independent of any transport."""

from __future__ import annotations

import copy
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from .contract import STANDARD


@dataclass(frozen=True)
class Field:
    """One field of the contract, which is the list of exchanged fields."""

    name: str
    unit: str  # SI
    components: int = 1  # 1, or the dimension
    # How values get from the giver's points to the receiver's. "consistent": interpolated; "nearest": interpolated, but where the
    # values jump, that of the nearest point; "conservative": an amount that is distributed so that its sum is kept.
    mapping: str = "consistent"
    mask: str = ""  # field that weights this field in the mapping; "": none
    in_time: bool = False  # for consistent fields in takes(): also receive the values at the window's start


def standard_fields(role: str, dimension: int) -> list[Field]:
    """The fields that a role gives by the standard contract. Roles are "fluid", "solid" and "field"; "field" is a fluid solver whose water
    is a continuous field, not particles."""
    return [
        Field(name, unit, dimension if vector else 1, mapping, mask)
        for name, unit, vector, mapping, mask in STANDARD[role]
    ]


@dataclass
class Points:
    """The points at which a phase gives fields. The first n_active points also receive fields; the others are ghosts, which only give."""

    position: np.ndarray  # [n, dimension] m
    volume: np.ndarray  # [n] m^dimension
    smoothing_length: np.ndarray  # [n] m; the kernel of a point reaches twice this length
    n_active: int = -1  # -1: all
    owner: np.ndarray = field(default_factory=lambda: np.empty(0))  # [n] active point whose image a ghost is; -1: none
    revision: int = 0  # must be changed whenever an array above changes

    def __post_init__(self) -> None:
        n = len(self.volume)
        if self.n_active < 0:
            self.n_active = n
        if len(self.owner) == 0:
            self.owner = np.where(np.arange(n) < self.n_active, np.arange(n), -1.0)

    def __len__(self) -> int:
        return len(self.volume)


@dataclass
class Publication:
    """A phase's state at the end of a window, as the other phase receives it."""

    points: Points
    fields: dict[str, np.ndarray]  # name -> [n] or [n, components]; fields that are left out are zero
    proposed_interval: float = float("inf")  # s, longest next window that is stable and accurate
    limited_by: str = ""  # what limits proposed_interval


@dataclass
class Inbox:
    """The other phase's fields at this phase's active points. Where the coverage is zero, so are the fields."""

    coverage: np.ndarray  # [n_active] kernel sum of the other's points: 1 inside these points, about 0.5 on their edge, 0 outside
    asymmetry: np.ndarray  # [n_active] distance of their centre of mass in smoothing lengths: 0 inside, 0.47 on a flat edge
    fields: dict[str, np.ndarray] = field(default_factory=dict)
    spread: np.ndarray | None = None  # [n_active] their standard deviation in smoothing lengths: 0 of one point, 0.6 on a flat edge; None: not sent

    def __getitem__(self, name: str) -> np.ndarray:
        return self.fields[name]

    def between(self, name: str, share: float) -> np.ndarray:
        """Values of a field with `in_time` within the window: linear in time between its start (share 0) and its end (share 1)."""
        start = self.fields.get(name + "@start")
        return self.fields[name] if start is None else (1.0 - share) * start + share * self.fields[name]


@dataclass(frozen=True)
class Window:
    """A window: one time step of the exchange."""

    step: int
    time: float  # s, start
    interval: float  # s


class Refused(Exception):
    """Raised by Phase.advance where the window is too long. The coupler then takes a shorter one."""

    def __init__(self, suggested_interval: float, reason: str) -> None:
        super().__init__(reason)
        self.suggested_interval = suggested_interval


class Phase:
    """Base class of a solver. Derived classes must set `role` and `dimension`."""

    role = ""
    dimension = 2
    _saved: Any = None

    def gives(self) -> list[Field]:
        """The fields that this phase publishes; by default the standard fields of its role."""
        return standard_fields(self.role, self.dimension)

    def takes(self) -> list[Field]:
        """The fields that this phase receives from the other phase; by default the standard fields of the other phase."""
        return standard_fields("solid" if self.role == "fluid" else "fluid", self.dimension)

    def publish(self) -> Publication:
        """The Publication at the current time."""
        raise NotImplementedError

    def initialise(self, inbox: Inbox) -> None:
        """Called once, with the other phase's fields at time zero."""

    def advance(self, window: Window, inbox: Inbox) -> None:
        """Advances by one window; raises Refused where the window is too long."""
        raise NotImplementedError

    def save(self) -> None:
        """Stores the complete state in memory. restore() returns to this state, any number of times."""
        self._saved = None
        self._saved = copy.deepcopy(self.__dict__)

    def restore(self) -> None:
        """Returns to the state that save() stored."""
        saved = self._saved
        self.__dict__ = copy.deepcopy(saved)
        self._saved = saved

    def state(self) -> bytes:
        """The complete state as bytes, for a checkpoint; resume() restores it in a new phase. A phase with attributes that state.dump()
        cannot store must override state() and resume(). It must not store code either."""
        from . import state

        return state.dump({name: value for name, value in self.__dict__.items() if name != "_saved"})

    def resume(self, data: bytes) -> None:
        """Restores what state() returned, in a new phase."""
        from . import state

        self.__dict__ = state.load(data)

    def gauges(self) -> dict[str, tuple[float, str]]:
        """Values at the current time for gauges.csv: name -> (value, unit)."""
        return {}


def lattice(lower: npt.ArrayLike, upper: npt.ArrayLike, spacing: float, smoothing_per_spacing: float = 1.3) -> Points:
    """Points of a square lattice that fills a box; the outermost points lie half a spacing inside its sides."""
    axes = [np.arange(round((b - a) / spacing)) * spacing + a + 0.5 * spacing for a, b in zip(np.asarray(lower, float), np.asarray(upper, float))]
    position = np.stack([c.ravel() for c in np.meshgrid(*axes, indexing="ij")], axis=-1)
    n = len(position)
    return Points(position, np.full(n, spacing ** len(axes)), np.full(n, smoothing_per_spacing * spacing))
