#!/usr/bin/env python3
"""A rigid skeleton in place of poretwin's solid solver; the fluid solver is poretwin's own.

    poretwin run clients/python/examples/seepage.toml --solid "python3 clients/python/examples/rigid_solid.py"

The skeleton is a set of points at rest. Its density makes it rigid: from density and modulus the fluid predicts how far the
skeleton moves within a window, and with 1e12 kg/m3 it does not move.
"""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import poretwin

UNMOVABLE = 1e12  # kg/m3, grain density with which the skeleton does not move


class RigidSolid(poretwin.Phase):
    role = "solid"

    def __init__(self, case):
        self.dimension = case.dimension
        spacing = case.get("solid.particle_spacing") or case.get("fluid.particle_spacing")
        self.points, soil = case.soil_points(spacing)
        still = np.zeros((len(self.points), self.dimension))

        def of_soil(key, default):
            return np.array([case.get(f"soil.{i}.{key}", default) for i in soil], dtype=float)

        self.fields = {
            "solid_velocity": still,
            "mean_solid_velocity": still,
            "volumetric_strain_rate": np.zeros(len(self.points)),
            "unbalanced_force": still,
            "solid_volume_fraction": 1.0 - of_soil("porosity", 0.4),
            "grain_density": np.full(len(self.points), UNMOVABLE),
            "constrained_modulus": np.zeros(len(self.points)),
            "yielding": np.zeros(len(self.points)),
            "hydraulic_conductivity": of_soil("hydraulic_conductivity", 1e-4),
            "returned_impulse": still,
        }
        self.taken = np.zeros(self.dimension)  # N s, sum of all drag impulses received

    def publish(self):
        return poretwin.Publication(self.points, self.fields)

    def advance(self, window, inbox):
        impulse = inbox["drag_impulse"].reshape(-1, self.dimension).sum(axis=0)
        self.taken = self.taken + impulse
        self.drag = impulse / window.interval

    def gauges(self):
        readings = {f"impulse_taken_{axis}": (value, "N s") for axis, value in zip("xyz", self.taken)}
        if hasattr(self, "drag"):
            readings |= {f"drag_{axis}": (value, "N") for axis, value in zip("xyz", self.drag)}
        return readings


if __name__ == "__main__":
    sys.exit(poretwin.main("solid", RigidSolid))
