#!/usr/bin/python3
"""Factors of safety of the slopes of this case by Bishop's simplified method of slices (Bishop 1955): the lowest over all circles above the
firm base, through soil in layers. Without friction the method is the balance of moments of an undrained circle.

Usage: bishop.py            all examples; prints the factor, the centre, the radius and the depth below the toe
"""
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "bench"))
import slices  # noqa: E402

WEIGHT, HEIGHT, RUN = 20e3, 10.0, 20.0  # N/m3, m: of the soil; height and horizontal length of the slope
SLICES = 200


class Slope:
    """The slope falls to the right, on a layer of some thickness. Each layer has a cohesion [Pa] and a tan(phi): of the slope, of the foundation."""

    def __init__(self, crest, thickness, toe, cohesion, friction):
        self.crest, self.thickness, self.length = crest, thickness, crest + RUN + toe
        self.cohesion, self.friction = cohesion, friction

    def top(self, x):
        return self.thickness + np.interp(x, [self.crest, self.crest + RUN], [HEIGHT, 0.0])

    def factor(self, xc, yc, radius):
        """Of one circle; infinite where it cuts no sensible body out of the soil."""
        if yc <= self.thickness + HEIGHT:
            return np.inf
        x = np.linspace(xc - radius, xc + radius, 4001)
        cut = np.flatnonzero(slices.base_of(xc, yc, radius, x) < self.top(x))
        if len(cut) < 40 or np.ptp(cut) != len(cut) - 1:
            return np.inf
        a, b = x[cut[0]], x[cut[-1]]
        if a <= 0.0 or a >= self.crest or b >= self.length:
            return np.inf
        width = (b - a) / SLICES
        x = a + (np.arange(SLICES) + 0.5) * width
        bottom = slices.base_of(xc, yc, radius, x)
        if bottom.min() < -1e-9:
            return np.inf
        weight = WEIGHT * np.maximum(self.top(x) - bottom, 0.0) * width
        layer = (bottom < self.thickness).astype(int)
        cohesion, friction = np.take(self.cohesion, layer), np.take(self.friction, layer)
        sine = (xc - x) / radius
        driving = (weight * sine).sum()
        return slices.factor(weight, cohesion * width, friction, sine, driving) if driving > 0.0 else np.inf

    def lowest(self):
        """A coarse grid of the centre and the depth of the circle, then a simplex from the best five. A circle that would reach below the base touches it."""
        def circle(v):
            x, y, depth = v
            return x, y, y - max(depth, 0.0)
        depths = np.append(np.arange(0.0, self.thickness + 3.0, 1.0), self.thickness + 0.01)
        tried = [(x, y, d) for x in self.crest + np.arange(4.0, 26.1, 2.0)
                 for y in self.thickness + HEIGHT + np.arange(1.0, 40.0, 3.0) for d in depths]
        found, at = slices.lowest(lambda v: self.factor(*circle(v)), tried, xatol=1e-3, fatol=1e-6, maxiter=2000)
        return found, circle(at)


def main():
    slopes = [("example 1: no foundation", Slope(12.0, 0.0, 0.0, (10e3, 10e3), (np.tan(np.radians(20.0)),) * 2)),
              ("example 2: D = 1.5", Slope(18.0, 5.0, 14.0, (10e3, 10e3), (np.tan(np.radians(20.0)),) * 2))]
    for ratio in (0.2, 0.6, 1.0, 1.25, 1.5, 1.75, 2.0):
        slopes.append((f"example 4: D = 2, s_u2 / s_u1 = {ratio:g}", Slope(20.0, 10.0, 20.0, (50e3, ratio * 50e3), (0.0, 0.0))))
    for name, slope in slopes:
        f, (x, y, radius) = slope.lowest()
        print(f"{name}: F = {f:.3f}, centre ({x:.1f}, {y:.1f}) m, radius {radius:.1f} m, depth below the toe {slope.thickness - y + radius:.2f} m", flush=True)


if __name__ == "__main__":
    main()
