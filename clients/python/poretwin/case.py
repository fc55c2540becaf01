"""The case as the coupler sends it: TOML text and overrides."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable
from typing import Any

import numpy as np

from .phase import Points, lattice


class Case:
    """The case with its overrides applied. `data`: content of the TOML text; `dimension`: 2 or 3."""

    def __init__(self, text: str, overrides: Iterable[str] = (), digest: str = "", dimension: int = 2) -> None:
        self.data: dict[str, Any] = tomllib.loads(text)
        for assignment in overrides:
            key, value = assignment.split("=", 1)
            self._set(key.strip().split("."), tomllib.loads("value = " + value)["value"])
        self.digest = digest
        self.dimension = dimension

    def _set(self, path: list[str], value: Any) -> None:
        place: Any = self.data
        for key, following in zip(path, path[1:]):
            if isinstance(place, list):
                place = place[int(key)]
            else:
                place = place.setdefault(key, [] if following.isdigit() else {})
        place[int(path[-1]) if isinstance(place, list) else path[-1]] = value

    def get(self, path: str, default: Any = None) -> Any:
        """The value at a dotted path, such as get("soil.0.porosity", 0.4)."""
        place: Any = self.data
        for key in path.split("."):
            try:
                place = place[int(key)] if isinstance(place, list) else place[key]
            except (KeyError, IndexError):
                return default
        return place

    @property
    def gravity(self) -> list[float]:
        """Gravity [m/s2]: as in the case, by default 9.81 m/s2 downwards along the last axis."""
        given: list[float] | None = self.get("case.gravity")
        return given if given is not None else [0.0] * (self.dimension - 1) + [-9.81]

    def soil_points(self, spacing: float, smoothing_per_spacing: float = 1.3) -> tuple[Points, np.ndarray]:
        """Lattice points of every box of soil, and for each point the index of its soil.

        Where a side of a box lies on a wall, the lattice continues behind the wall by four spacings. These points are ghosts,
        which give fields but receive none. Without them the fluid solver would take the wall for the soil's surface.
        """
        active: list[tuple[np.ndarray, int]] = []
        ghosts: list[tuple[np.ndarray, int]] = []
        for index, soil in enumerate(self.get("soil", [])):
            lower, upper = np.array(soil["min"], float), np.array(soil["max"], float)
            if soil.get("shape") != "box":
                raise ValueError(f"soil '{soil.get('name')}': expected shape = \"box\", found '{soil.get('shape')}'")
            outer_lower, outer_upper = lower.copy(), upper.copy()
            for axis in range(self.dimension):
                for outer, side, sign in ((outer_lower, lower, -1.0), (outer_upper, upper, 1.0)):
                    if self._has_wall(axis, side[axis]):
                        outer[axis] += sign * 4.0 * spacing
            x = lattice(outer_lower, outer_upper, spacing).position
            inside = np.all((x > lower) & (x < upper), axis=1)
            active += [(p, index) for p in x[inside]]
            ghosts += [(p, index) for p in x[~inside]]
        n, everything = len(active), active + ghosts
        size = len(everything)
        points = Points(np.array([p for p, _ in everything]).reshape(size, self.dimension), np.full(size, spacing**self.dimension),
                        np.full(size, smoothing_per_spacing * spacing), n_active=n)
        return points, np.array([i for _, i in everything], dtype=int)

    def _has_wall(self, axis: int, coordinate: float) -> bool:
        for wall in self.get("wall", []):
            corners = wall.get("points", [])
            for a, b in zip(corners, corners[1:]):
                if abs(a[axis] - coordinate) < 1e-9 and abs(b[axis] - coordinate) < 1e-9:
                    return True
        return False
