#!/usr/bin/python3
"""Pictures of particles: bodies without holes, with the colour of the nearest particle."""
import pathlib
import sys
import unittest

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "cli"))
from cells import Canvas, spacing  # noqa: E402


def lattice(nx, ny, dx):
    x, y = np.meshgrid((np.arange(nx) + 0.5) * dx, (np.arange(ny) + 0.5) * dx)
    return np.stack([x.ravel(), y.ravel()], axis=1)


class Cells(unittest.TestCase):
    def test_spacing_of_a_lattice_and_of_its_disorder(self):
        x = lattice(40, 30, 0.01)
        self.assertAlmostEqual(spacing(x), 0.01, delta=0.0003)
        self.assertAlmostEqual(spacing(x + np.random.default_rng(1).uniform(-0.003, 0.003, x.shape)), 0.01, delta=0.0006)

    def test_a_body_has_no_holes_and_ends_at_its_surface(self):
        dx = 0.01
        x = lattice(30, 20, dx)
        x += np.random.default_rng(2).uniform(-0.2 * dx, 0.2 * dx, x.shape)
        canvas = Canvas([-0.05, -0.05], [0.35, 0.25], dx)
        drawn, _ = canvas.fill(x, x[:, 0], np.full(len(x), dx))
        rows, columns = np.indices(canvas.shape)
        at = canvas.lower + (np.stack([columns, rows], axis=2) + 0.5) * canvas.pixel
        inside = (at > 0.5 * dx).all(axis=2) & (at[:, :, 0] < 0.295) & (at[:, :, 1] < 0.195)
        outside = (at < -0.7 * dx).any(axis=2) | (at[:, :, 0] > 0.307) | (at[:, :, 1] > 0.207)
        self.assertTrue(np.isfinite(drawn[inside]).all())
        self.assertFalse(np.isfinite(drawn[outside]).any())
        self.assertLess(np.abs(drawn - at[:, :, 0])[inside].max(), dx)
        area = np.isfinite(drawn).sum() * canvas.pixel**2
        self.assertAlmostEqual(area, 0.3 * 0.2, delta=0.03 * 0.06)

    def test_gaps_wider_than_particles_stay(self):
        dx = 0.01
        x = np.vstack([lattice(10, 10, dx), lattice(10, 10, dx) + (0.13, 0.0)])
        canvas = Canvas([0.0, 0.0], [0.23, 0.1], dx)
        drawn, _ = canvas.fill(x, np.ones(len(x)), np.full(len(x), dx))
        middle = int(0.115 / canvas.pixel)
        self.assertFalse(np.isfinite(drawn[:, middle]).any())


if __name__ == "__main__":
    unittest.main()
