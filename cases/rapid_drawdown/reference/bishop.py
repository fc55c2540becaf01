#!/usr/bin/python3
"""Factors of safety of both slopes of the dam by Bishop's simplified method of slices (Bishop 1955), with the pore pressures and the
weight of water that a run has found: the lowest over all circles above the firm base.

Usage: bishop.py RUN [TIME ...]    days; default: all frames. Prints time [days], F upstream, F downstream.

Below the water table the pore pressure acts as it is, above it as S_e p (Bishop's stress with chi = S_e), as in the run. Water before the upstream slope
loads it: its weight counts in the slices, its thrust in the moment about the centre.
"""
import pathlib
import sys

import h5py
import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "bench"))
import slices  # noqa: E402

SURFACE = np.array([[0.0, 0.0], [25.0, 10.0], [29.0, 10.0], [54.0, 0.0]])  # m
COHESION, FRICTION = 5e3, np.tan(np.radians(25.0))  # Pa, 1
POROSITY, GRAINS, WATER, GRAVITY = 0.43, 2650.0, 1000.0, 9.81
RESIDUAL = 0.078 / 0.43  # water content that stays, over the porosity
LEVEL = [(0.0, 0.0), (10.0, 8.0), (100.0, 8.0), (105.0, 2.0)]  # days, m
SLICES = 60


def ground(x):
    return np.interp(x, SURFACE[:, 0], SURFACE[:, 1], left=0.0, right=0.0)


class State:
    """Pore water in the dam at one time. Mirrored: as seen from behind, so that either slope falls to the right."""

    def __init__(self, water, level, mirrored):
        self.water, self.mirrored, self.level = water, mirrored, level

    def there(self, x):
        return SURFACE[-1, 0] - x if self.mirrored else x

    def at(self, x, y):
        """Pressure that acts [Pa], and saturation."""
        pressure, saturation = self.water.at(self.there(x), y)
        return slices.acting(pressure, saturation, RESIDUAL), saturation

    def top(self, x):
        return ground(self.there(x))

    def outside(self, x):
        """Depth of free water above the ground; it stands before the upstream slope only."""
        upstream = self.there(x) < 25.0
        return np.where(upstream, np.maximum(self.level - self.top(x), 0.0), 0.0)


def factor(state, centre, radius):
    """Of one circle; infinite where it cuts no sensible body out of the slope that falls to the right."""
    xc, yc = centre
    if yc <= SURFACE[:, 1].max() or yc - radius < 0.0:
        return np.inf
    x = np.linspace(xc - radius, xc + radius, 2001)
    cut = (slices.base_of(xc, yc, radius, x) < state.top(x) - 1e-9) & (x > 0.0) & (x < SURFACE[-1, 0])
    if cut.sum() < 40 or np.ptp(np.flatnonzero(cut)) != cut.sum() - 1:
        return np.inf
    a, b = x[cut][0], x[cut][-1]
    if state.top(a) < 9.999 or b - a < 3.0:  # the upper end lies on the crest
        return np.inf
    width = (b - a) / SLICES
    x = a + (np.arange(SLICES) + 0.5) * width
    bottom, top = slices.base_of(xc, yc, radius, x), state.top(x)
    share = (np.arange(12) + 0.5) / 12.0
    _, saturation = state.at(np.repeat(x[:, None], 12, axis=1), bottom[:, None] + share * (top - bottom)[:, None])
    weight = ((1.0 - POROSITY) * GRAINS + POROSITY * WATER * saturation.mean(axis=1)) * GRAVITY * (top - bottom) * width
    pressure, _ = state.at(x, bottom)
    loaded = WATER * GRAVITY * state.outside(x)
    vertical = weight + loaded * width
    # Thrust of the water on the slope: on each slice p times its height, against the slope, at the ground.
    step = state.top(x + 0.5 * width) - state.top(x - 0.5 * width)
    thrust = loaded * step  # to the right where positive; the ground falls to the right: negative
    sine = (xc - x) / radius
    driving = (vertical * sine).sum() + (thrust * (yc - top)).sum() / radius
    if driving <= 0.0:
        return np.inf
    return slices.factor(np.maximum(vertical - pressure * width, 0.0), COHESION * width, FRICTION, sine, driving)


def lowest(state):
    """Over all circles: a coarse grid of the upper end, the lower end and the sagitta, then a simplex from the best five."""
    ends = [(u, l) for u in np.arange(24.2, 30.0, 0.8) for l in np.arange(34.0, 54.1, 2.0)]
    return slices.lowest_between(state.top, SURFACE[-1, 0], ends, (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.5), lambda centre, radius: factor(state, centre, radius))


def main():
    run = pathlib.Path(sys.argv[1])
    times = [float(t) for t in sys.argv[2:]]
    with h5py.File(run / "fluid.vtkhdf") as file:
        root = file["VTKHDF"]
        found = root["Steps/Values"][:] / 86400.0
        wanted = [int(np.argmin(np.abs(found - t))) for t in times] if times else range(len(found))
        for step in wanted:
            water = slices.PoreWater(*slices.read_frame(root, step))
            level = np.interp(found[step], *np.array(LEVEL).T)
            factors = [lowest(State(water, level, mirrored)) for mirrored in (True, False)]
            print(f"{found[step]:.3f},{factors[0]:.4f},{factors[1]:.4f}", flush=True)


if __name__ == "__main__":
    main()
