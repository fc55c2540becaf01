#!/usr/bin/python3
"""Factor of safety of the dam's downstream slope by Bishop's simplified method of slices (Bishop 1955), with the pore pressures and the weight
of water that a run has found: the lowest over all circles above the firm base. Also for soil that did not feel the seepage force.

Usage: bishop.py RUN [TIME ...]    s; default: the last frame. Prints time [s], F, F without the seepage force.

Below the water table the pore pressure acts as it is, above it as S_e p (Bishop's stress with chi = S_e), as in the run. The seepage force is the
drag of steady flow on the grains, n S (rho_w g - grad p) per volume (docs/theory/equilibrium.md).
"""
import pathlib
import sys

import h5py
import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "bench"))
import slices  # noqa: E402

SURFACE = np.array([[0.0, 0.0], [20.0, 10.0], [24.0, 10.0], [44.0, 0.0]])  # m
COHESION, FRICTION = 5e3, np.tan(np.radians(30.0))  # Pa, 1
POROSITY, GRAINS, WATER, GRAVITY = 0.43, 2650.0, 1000.0, 9.81
RESIDUAL = 0.078 / 0.43  # water content that stays, over the porosity
SLICES, LAYERS = 60, 12  # points of a body: across, and over the depth of a slice
STEP = 0.25  # m: half the distance over which the pressure's gradient is taken


def top(x):
    return np.interp(x, SURFACE[:, 0], SURFACE[:, 1], left=0.0, right=0.0)


class State(slices.PoreWater):
    """Pore water in the dam at one time."""

    def seepage_force(self, x, y):
        """To the right and upwards [N/m3]."""
        def pressure(dx, dy):
            return self.at(x + dx, y + dy)[0]
        wet = POROSITY * self.at(x, y)[1]
        along = (pressure(STEP, 0.0) - pressure(-STEP, 0.0)) / (2.0 * STEP)
        up = (pressure(0.0, STEP) - pressure(0.0, -STEP)) / (2.0 * STEP)
        return -wet * along, -wet * (WATER * GRAVITY + up)


def factor(state, seeping, centre, radius):
    """Of one circle; infinite where it cuts no sensible body out of the slope."""
    xc, yc = centre
    if yc <= SURFACE[:, 1].max() or yc - radius < 0.0:
        return np.inf
    x = np.linspace(xc - radius, xc + radius, 2001)
    cut = (slices.base_of(xc, yc, radius, x) < top(x) - 1e-9) & (x > 0.0) & (x < SURFACE[-1, 0])
    if cut.sum() < 40 or np.ptp(np.flatnonzero(cut)) != cut.sum() - 1:
        return np.inf
    a, b = x[cut][0], x[cut][-1]
    if a < SURFACE[1, 0] or b - a < 3.0:  # the upper end lies on the crest or on the slope
        return np.inf
    width = (b - a) / SLICES
    x = a + (np.arange(SLICES) + 0.5) * width
    bottom = slices.base_of(xc, yc, radius, x)
    height = top(x) - bottom
    inside = np.repeat(x[:, None], LAYERS, axis=1)
    above = bottom[:, None] + (np.arange(LAYERS) + 0.5) / LAYERS * height[:, None]
    volume = (height * width / LAYERS)[:, None]
    down = ((1.0 - POROSITY) * GRAINS + POROSITY * WATER * state.at(inside, above)[1]) * GRAVITY
    right = np.zeros_like(down)
    if not seeping:
        along, up = state.seepage_force(inside, above)
        down, right = down + up, right - along
    vertical = (down * volume).sum(axis=1)
    driving = ((down * (xc - inside) + right * (yc - above)) * volume).sum() / radius
    if driving <= 0.0:
        return np.inf
    pressure = slices.acting(*state.at(x, bottom), RESIDUAL)
    sine = (xc - x) / radius
    return slices.factor(np.maximum(vertical - pressure * width, 0.0), COHESION * width, FRICTION, sine, driving)


def lowest(state, seeping):
    """Over all circles: a coarse grid of the upper end, the lower end and the sagitta, then a simplex from the best five."""
    ends = [(u, l) for u in np.arange(20.5, 36.1, 1.5) for l in np.arange(32.0, 44.1, 1.5) if l > u + 4.0]
    return slices.lowest_between(top, SURFACE[-1, 0], ends, (1.0, 1.5, 2.0, 3.0, 4.0, 5.0), lambda centre, radius: factor(state, seeping, centre, radius))


def main():
    run = pathlib.Path(sys.argv[1])
    with h5py.File(run / "fluid.vtkhdf") as file:
        root = file["VTKHDF"]
        found = root["Steps/Values"][:]
        for time in [float(t) for t in sys.argv[2:]] or [found[-1]]:
            step = int(np.argmin(np.abs(found - time)))
            state = State(*slices.read_frame(root, step))
            print(f"{found[step]:g},{lowest(state, True):.4f},{lowest(state, False):.4f}", flush=True)


if __name__ == "__main__":
    main()
