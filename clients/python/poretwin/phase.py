"""What a phase gives and gets, independent of any transport."""

from __future__ import annotations

import copy
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from .contract import STANDARD


@dataclass(frozen=True)
class Field:
    """One field of the contract."""

    name: str
    unit: str  # SI
    components: int = 1  # 1, or the dimension
    mapping: str = "consistent"  # interpolated; "nearest": that, but at jumps of the nearest point; "conservative": an amount, shared out
    mask: str = ""
    in_time: bool = False  # of a field taken, consistent: the values at the window's start are wanted too


def standard_fields(role: str, dimension: int) -> list[Field]:
    """The standard contract: what each role gives, "field" for a fluid whose water is a field. It takes what the other gives."""
    return [
        Field(name, unit, dimension if vector else 1, mapping, mask)
        for name, unit, vector, mapping, mask in STANDARD[role]
    ]


@dataclass
class Points:
    """Where fields are given. The first n_active points also receive; the others are ghosts."""

    position: np.ndarray  # [n, dimension] m
    volume: np.ndarray  # [n] m^dimension
    smoothing_length: np.ndarray  # [n] m: a point speaks for what lies within twice this length
    n_active: int = None  # type: ignore[assignment]  # all, unless said otherwise
    owner: np.ndarray = None  # type: ignore[assignment]  # [n] the active point a ghost stands for; -1: nobody
    revision: int = 0  # change it whenever anything above changes

    def __post_init__(self) -> None:
        n = len(self.volume)
        if self.n_active is None:
            self.n_active = n
        if self.owner is None:
            self.owner = np.where(np.arange(n) < self.n_active, np.arange(n), -1.0)

    def __len__(self) -> int:
        return len(self.volume)


@dataclass
class Publication:
    """What a phase shows at the end of a window."""

    points: Points
    fields: dict[str, np.ndarray]  # name -> [n] or [n, components]; what the contract has and this has not is zero
    proposed_interval: float = float("inf")  # s, the longest next window that is stable and accurate
    limited_by: str = ""


@dataclass
class Inbox:
    """The other phase at this phase's active points; zero where coverage is zero."""

    coverage: np.ndarray  # [n_active] 1 inside the other's cloud, about 0.5 on its edge, 0 outside
    asymmetry: np.ndarray  # [n_active]
    fields: dict[str, np.ndarray] = field(default_factory=dict)

    def __getitem__(self, name: str) -> np.ndarray:
        return self.fields[name]

    def between(self, name: str, share: float) -> np.ndarray:
        """Values within the window, linear in time (share 0: its start, 1: its end), of a field taken `in_time`."""
        start = self.fields.get(name + "@start")
        return self.fields[name] if start is None else (1.0 - share) * start + share * self.fields[name]


@dataclass(frozen=True)
class Window:
    """One exchange window."""

    step: int
    time: float  # s, start
    interval: float  # s


class Refused(Exception):
    """Raised by Phase.advance: the window is too long."""

    def __init__(self, suggested_interval: float, reason: str) -> None:
        super().__init__(reason)
        self.suggested_interval = suggested_interval


class Phase:
    """Base class of a solver of your own. `role` and `dimension` must be set."""

    role = ""
    dimension = 2
    _saved: Any = None

    def gives(self) -> list[Field]:
        """Fields that it publishes: the standard ones of its role."""
        return standard_fields(self.role, self.dimension)

    def takes(self) -> list[Field]:
        """Fields that it wants of the other phase."""
        return standard_fields("solid" if self.role == "fluid" else "fluid", self.dimension)

    def publish(self) -> Publication:
        """The Publication at the current time."""
        raise NotImplementedError

    def initialise(self, inbox: Inbox) -> None:
        """Called once, with the other side's fields at time zero."""

    def advance(self, window: Window, inbox: Inbox) -> None:
        """Advances by one window; raises Refused when it is too long."""
        raise NotImplementedError

    def save(self) -> None:
        """Keeps the complete state; restore() brings it back, any number of times."""
        self._saved = None
        self._saved = copy.deepcopy(self.__dict__)

    def restore(self) -> None:
        """Brings back what save() kept."""
        saved = self._saved
        self.__dict__ = copy.deepcopy(saved)
        self._saved = saved

    def state(self) -> bytes:
        """The same complete state as bytes, for a checkpoint; resume() brings it back in a phase newly made. Attributes that are
        not data (state.py says which are) need a state() and a resume() of the phase's own, free of code as well."""
        from . import state

        return state.dump({name: value for name, value in self.__dict__.items() if name != "_saved"})

    def resume(self, data: bytes) -> None:
        """Brings back what state() gave, in a phase newly made."""
        from . import state

        self.__dict__ = state.load(data)

    def gauges(self) -> dict[str, tuple[float, str]]:
        """Readings for gauges.csv: name -> (value, unit)."""
        return {}


def lattice(lower: npt.ArrayLike, upper: npt.ArrayLike, spacing: float, smoothing_per_spacing: float = 1.3) -> Points:
    """Points on a square lattice that fills a box, the first half a spacing in."""
    axes = [np.arange(round((b - a) / spacing)) * spacing + a + 0.5 * spacing for a, b in zip(np.asarray(lower, float), np.asarray(upper, float))]
    position = np.stack([c.ravel() for c in np.meshgrid(*axes, indexing="ij")], axis=-1)
    n = len(position)
    return Points(position, np.full(n, spacing ** len(axes)), np.full(n, smoothing_per_spacing * spacing))
