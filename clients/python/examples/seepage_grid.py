#!/usr/bin/env python3
"""Steady seepage by finite differences in place of poretwin's fluid solver: a grid of nodes instead of particles. The solid
solver is poretwin's own.

    poretwin run clients/python/examples/seepage.toml --fluid "python3 clients/python/examples/seepage_grid.py"

Solves div(k grad h) = 0 for the head h [m] at the nodes of a rectangular grid over the soil; the conductivity k [m/s] comes from
the solid, mapped to the nodes. The case's water faces prescribe h; all other sides are impermeable. The pore pressure is
p = rho_w g (h - z), with the elevation z and the density rho_w of water. The drag on the skeleton per volume balances weight and
pressure gradient of the water: it is n (rho_w g - grad p), with the porosity n.
The water does not respond to the skeleton: the seepage is steady, the predicted velocity of the skeleton is zero, and the
impulse that the solid returns is ignored.
"""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import poretwin


class SeepageGrid(poretwin.Phase):
    role = "fluid"

    def __init__(self, case):
        self.dimension = case.dimension
        if case.dimension != 2 or len(case.get("soil", [])) != 1:
            raise ValueError("this example knows one box of soil in two dimensions")
        lower, upper = np.array(case.get("soil.0.min"), float), np.array(case.get("soil.0.max"), float)
        spacing = case.get("fluid.particle_spacing")
        self.shape = tuple(np.round((upper - lower) / spacing).astype(int) + 1)
        self.step = (upper - lower) / (np.array(self.shape) - 1)
        self.axes = [np.linspace(a, b, n) for a, b, n in zip(lower, upper, self.shape)]
        x, y = np.meshgrid(*self.axes, indexing="ij")
        weights = [np.where((c == c[0]) | (c == c[-1]), 0.5, 1.0) * d for c, d in zip(self.axes, self.step)]
        volume = np.outer(*weights)
        n = x.size
        self.points = poretwin.Points(np.stack([x.ravel(), y.ravel()], axis=1), volume.ravel(), np.full(n, 1.3 * spacing))
        self.weight = case.get("water.density", 1000.0) * np.array(case.gravity, float)  # N/m3
        self.elevation = self.points.position @ (-self.weight / np.linalg.norm(self.weight))
        self.prescribed = self._prescribed(case)
        self.case_porosity = case.get("soil.0.porosity", 0.4)
        self.case_conductivity = case.get("soil.0.hydraulic_conductivity", 1e-4)
        self.porosity = np.full(n, self.case_porosity)
        self.impulse = np.zeros((n, 2))
        self.change = np.zeros((n, 2))
        self._solve(np.full(n, self.case_conductivity))

    def _prescribed(self, case):
        """Heads [m] at the nodes on water faces; NaN at all others."""
        heads = np.full(len(self.points), np.nan)
        for face in case.get("water_face", []):
            for a, b in zip(face["points"], face["points"][1:]):
                a, b = np.array(a, float), np.array(b, float)
                along = (b - a) / np.linalg.norm(b - a)
                r = self.points.position - a
                on = (np.abs(r @ [-along[1], along[0]]) < 1e-9) & (r @ along > -1e-9) & (r @ along < np.linalg.norm(b - a) + 1e-9)
                if "head" in face:
                    heads[on] = face["head"]
                else:
                    heads[on] = self.elevation[on] + face["pressure"] / np.linalg.norm(self.weight)
        return heads

    def _solve(self, conductivity):
        """Computes heads, pressures and the force of the water on the skeleton at all nodes."""
        n = len(self.points)
        index = np.arange(n).reshape(self.shape)
        matrix, right = np.zeros((n, n)), np.zeros(n)
        for axis in (0, 1):
            a = np.moveaxis(index, axis, 0)[:-1].ravel()
            b = np.moveaxis(index, axis, 0)[1:].ravel()
            # Width of the cross-section between two nodes, in grid steps: one half at the rim of the grid.
            across = np.ones(self.shape[1 - axis])
            across[[0, -1]] = 0.5
            width = np.tile(across * self.step[1 - axis], self.shape[axis] - 1)
            k = 2.0 * conductivity[a] * conductivity[b] / (conductivity[a] + conductivity[b])
            conductance = k * width / self.step[axis]
            for i, j in ((a, b), (b, a)):
                np.add.at(matrix, (i, i), conductance)
                np.add.at(matrix, (i, j), -conductance)
        balance = matrix.copy()
        fixed = ~np.isnan(self.prescribed)
        matrix[fixed] = 0.0
        matrix[fixed, fixed] = 1.0
        right[fixed] = self.prescribed[fixed]
        head = np.linalg.solve(matrix, right)
        inflow = balance @ head  # m2/s that enters at each node
        self.discharge = inflow[inflow > 0.0].sum()
        self.pressure = np.linalg.norm(self.weight) * (head - self.elevation)
        gradient = np.gradient(self.pressure.reshape(self.shape), *self.axes, edge_order=2)
        self.force = self.porosity[:, None] * (self.weight - np.stack([g.ravel() for g in gradient], axis=1))

    def publish(self):
        return poretwin.Publication(self.points, {
            "pore_pressure": self.pressure,
            "predicted_solid_velocity": np.zeros((len(self.points), 2)),
            "predicted_change": self.change,
            "drag_impulse": self.impulse,
            "soil_fraction": np.ones(len(self.points)),
            "surface_gradient": np.zeros((len(self.points), 2)),
            "surface_share": np.zeros(len(self.points)),  # 0: the solid uses its own pressure gradient
            "spreading_rate": np.zeros(len(self.points)),  # 0: all motion of the soil strains it
        })

    def advance(self, window, inbox):
        soil = inbox.coverage > 0.0  # fields are 0, and meaningless, elsewhere
        self.porosity = np.where(soil, 1.0 - inbox["solid_volume_fraction"], self.case_porosity)
        self._solve(np.where(soil, inbox["hydraulic_conductivity"], self.case_conductivity))
        self.impulse = self.force * self.points.volume[:, None] * window.interval
        self.change = -np.where(soil[:, None], inbox["solid_velocity"], 0.0)  # the prediction is soil at rest

    def gauges(self):
        return {"discharge": (self.discharge, "m2/s")}


if __name__ == "__main__":
    sys.exit(poretwin.main("fluid", SeepageGrid))
