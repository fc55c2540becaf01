#!/usr/bin/python3
"""Seepage under a floor with a sheet pile at its downstream end, in soil without end (Khosla, Bose & Taylor 1936): the head at points, and
the exit gradient at the pile. z = x + iy, y <= 0: zeta = sqrt(z^2 + d^2) unfolds the pile, and the floor and the pile become the straight
line from -sqrt(b^2 + d^2) to d. Below an impermeable line from c - a to c + a the head is (H / pi) Re arccos((zeta - c) / a)."""
import numpy as np

H, b, d = 4.0, 6.0, 2.0  # m: head difference, length of the floor, depth of the pile
PLACES = np.array([[-5.5, -0.5], [-4.5, -0.5], [-3.5, -0.5], [-2.5, -0.5], [-1.5, -0.5], [-0.5, -0.5]])


def head(points):
    z = points[:, 0] + 1j * points[:, 1]
    zeta = np.sqrt(z**2 + d**2)
    zeta = np.where(zeta.real * z.real < 0.0, -zeta, zeta)  # the branch that is z far from the pile
    left, right = -np.hypot(b, d), d
    return H / np.pi * np.arccos((zeta - 0.5 * (left + right)) / (0.5 * (right - left))).real


alpha = b / d
print("exit gradient H / (pi d sqrt(lambda)), lambda = (1 + sqrt(1 + alpha^2)) / 2, alpha = b / d:",
      H / (np.pi * d * np.sqrt(0.5 * (1.0 + np.sqrt(1.0 + alpha**2)))))
x = -b + (np.arange(200000) + 0.5) * b / 200000
pressure = 9810.0 * head(np.stack([x, 0.0 * x - 1e-12], axis=1))
print(f"uplift of the floor: {pressure.mean() * b:.6g} N/m, {np.sum(pressure * (x + b)) / np.sum(pressure):.5g} m from its upper end")
x = (np.arange(20000) + 0.5) * 0.5 * d / 20000
below = head(np.stack([x, 0.0 * x - d], axis=1)) + d  # m, pressure head below a prism of soil behind the pile, d deep and d / 2 wide
print(f"pressure below the prism over its weight: {below.mean() / (d * (0.6 * 2.65 + 0.4)):.5g}")
print("heads [m]:", ", ".join(f"{h:.4f}" for h in head(PLACES)))
