#!/usr/bin/python3
"""A pond on unsaturated sand, by finite volumes: independent of poretwin, written for this case.

Richards' equation in mixed form on a grid of squares in the plane, backward Euler, modified Picard iteration (Celia,
Bouloutas & Zarba 1990), conductivity as the mean of both cells. The pond is a volume with one level; its head acts on
the wetted part of the soil's surface, and what passes there leaves it in the same step. Where the surface is dry,
nothing passes, or water comes out at zero pressure and joins the pond.

    richards.py column CELL [OUT.csv]     CELL in m
    richards.py basin CELL [OUT.csv]
"""

import sys

import numpy as np
import scipy.sparse as sparse
import scipy.sparse.linalg

# Sand (Carsel & Parrish 1988) with a larger conductivity.
THETA_R, THETA_S, ALPHA, N, K = 0.045, 0.43, 14.5, 2.68, 1e-3
M = 1.0 - 1.0 / N


def saturation(psi):
    return np.where(psi < 0.0, (1.0 + (ALPHA * np.abs(psi)) ** N) ** -M, 1.0)


def content(psi):
    return THETA_R + (THETA_S - THETA_R) * saturation(psi)


def capacity(psi):
    a = ALPHA * np.abs(psi)
    slope = (THETA_S - THETA_R) * M * N * ALPHA * a ** (N - 1.0) * (1.0 + a**N) ** (-M - 1.0)
    return np.where(psi < 0.0, slope, 0.0)


def permeability(psi):
    s = saturation(psi)
    return np.sqrt(s) * (1.0 - (1.0 - np.minimum(s, 1.0) ** (1.0 / M)) ** M) ** 2


class Ground:
    """Squares of soil; `soil[i, j]` over x and z. Faces of the pond: cell, elevation of middle, wall or floor."""

    def __init__(self, cell, soil, table, surface, drained):
        self.d = cell
        index = -np.ones(soil.shape, int)
        index[soil] = np.arange(soil.sum())
        x, z = np.nonzero(soil)
        self.z = (z + 0.5) * cell
        self.psi = table - self.z
        pairs = []
        for axis in (0, 1):
            a = index[:-1, :] if axis == 0 else index[:, :-1]
            b = index[1:, :] if axis == 0 else index[:, 1:]
            both = (a >= 0) & (b >= 0)
            pairs.append(np.stack([a[both], b[both]]))
        self.a, self.b = np.concatenate(pairs, axis=1)
        self.face, self.face_z, self.face_high = surface(index, cell)
        self.base = index[:, 0][index[:, 0] >= 0] if drained else np.empty(0, int)

    def step(self, dt, pond, level_of):
        """One step from the pond's volume; returns success and the new volume."""
        n, d, a, b = len(self.psi), self.d, self.a, self.b
        before, psi, volume = content(self.psi), self.psi.copy(), pond
        for _ in range(40):
            level = level_of(max(volume, 0.0))
            k = K * 0.5 * (permeability(psi[a]) + permeability(psi[b]))
            rise = self.z[a] - self.z[b]
            flow = k * (psi[a] - psi[b] + rise)
            # surface: the middle of the wetted part of each face
            low = self.face_z - 0.5 * self.face_high
            height = np.where(self.face_high > 0.0, self.face_high, 1.0)
            wet = np.where(self.face_high > 0.0, np.clip((level - low) / height, 0, 1), level > self.face_z)
            middle = low + 0.5 * wet * self.face_high
            cell, distance = self.face, 0.5 * d
            head = np.maximum(level - middle, 0.0)
            kf = K * 0.5 * (1.0 + permeability(psi[cell]))
            g = kf * d / distance * wet
            into = g * (head + middle - psi[cell] - self.z[cell])
            seeps = (wet < 1.0) & (psi[cell] + self.z[cell] > self.face_z) & (psi[cell] > 0.0)
            gs = np.where(seeps, K * d / distance * (1.0 - wet), 0.0)
            into += gs * (self.face_z - psi[cell] - self.z[cell])
            available = pond / dt
            total = into.sum()
            held = total > available
            if held:
                into *= available / total
                g = g * 0.0
            kb = K * 0.5 * (1.0 + permeability(psi[self.base]))
            out = kb * d / distance * (psi[self.base] + self.z[self.base])
            balance = np.zeros(n)
            np.add.at(balance, a, -flow)
            np.add.at(balance, b, flow)
            np.add.at(balance, cell, into)
            np.add.at(balance, self.base, -out)
            right = d * d * (before - content(psi)) / dt + balance
            diagonal = d * d * capacity(psi) / dt + 1e-12
            np.add.at(diagonal, a, k)
            np.add.at(diagonal, b, k)
            np.add.at(diagonal, cell, g + gs)
            np.add.at(diagonal, self.base, kb * d / distance)
            matrix = sparse.coo_matrix((np.concatenate([diagonal, -k, -k]),
                                        (np.concatenate([np.arange(n), a, b]), np.concatenate([np.arange(n), b, a]))),
                                       shape=(n, n)).tocsc()
            change = scipy.sparse.linalg.spsolve(matrix, right)
            psi += change
            last, volume = volume, pond - dt * into.sum()
            if not np.all(np.isfinite(psi)) or np.abs(psi).max() > 1e3:
                return False, pond
            if np.abs(right).sum() * dt < 1e-7 * d * d * n * 0.1 and abs(volume - last) < 1e-9:
                self.psi = psi
                self.stored = d * d * content(psi).sum()
                return True, volume
        return False, pond


def column(cell):
    """0.8 m deep, one cell wide; water table and drain at the base; 0.2 m of water on it."""
    rows = round(0.8 / cell)
    soil = np.ones((1, rows), bool)

    def surface(index, d):
        return np.array([index[0, -1]]), np.array([0.8]), np.array([0.0])

    ground = Ground(cell, soil, 0.0, surface, True)
    return ground, 0.2 * cell, lambda v: 0.8 + v / cell, cell


def basin(cell):
    """Half of a pit with upright sides: floor at 0.3 m to x = 0.2 m, bank at 0.5 m to x = 0.8 m; 0.15 m of water."""
    soil = np.ones((round(0.8 / cell), round(0.5 / cell)), bool)
    wide, floor = round(0.2 / cell), round(0.3 / cell)
    soil[:wide, floor:] = False

    def surface(index, d):
        below = index[:wide, floor - 1]
        side = index[wide, floor:]
        z = 0.3 + (np.arange(len(side)) + 0.5) * d
        return (np.concatenate([below, side]), np.concatenate([np.full(wide, 0.3), z]),
                np.concatenate([np.zeros(wide), np.full(len(side), d)]))

    ground = Ground(cell, soil, 0.0, surface, False)
    return ground, 0.2 * 0.15, lambda v: 0.3 + v / 0.2, 1.0


def main():
    kind, cell = sys.argv[1], float(sys.argv[2])
    ground, pond, level_of, width = {"column": column, "basin": basin}[kind](cell)
    first, t, dt = pond, 0.0, 1e-4
    stored = ground.d**2 * content(ground.psi).sum()
    rows = [(t, pond / width)]
    end = float(sys.argv[4]) if len(sys.argv) > 4 else 300.0
    most = 0.25
    while t < end:
        dt = min(dt, end - t)
        solved, left = ground.step(dt, pond, level_of)
        if not solved:
            dt *= 0.4
            if dt < 1e-9:
                sys.exit(f"no solution at t = {t} s")
            continue
        t, pond = t + dt, max(left, 0.0)
        rows.append((t, pond / width))
        dt = min(1.2 * dt, most)
        if pond < 1e-9 * first and t > 10.0:
            break
    rows = np.array(rows)
    for share in (0.9, 0.5, 0.25, 0.1, 0.05, 0.02, 0.01):
        at = np.interp(-share, -rows[:, 1] / rows[0, 1], rows[:, 0])
        print(f"{share:5.2f} of the pond left at {at:.4f} s")
    print(f"steps {len(rows)}, stored {stored:.6g} -> {ground.stored:.6g}, pond {first:.6g} -> {pond:.6g}")
    if len(sys.argv) > 3:
        times = np.arange(0.0, rows[-1, 0], 2.0)
        np.savetxt(sys.argv[3], np.stack([times, np.interp(times, rows[:, 0], rows[:, 1])], 1), delimiter=",",
                   fmt="%.6g", header="time_s," + ("depth_m" if kind == "column" else "pond_m2"), comments="")


if __name__ == "__main__":
    main()
