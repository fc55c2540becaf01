"""Finite elements for the dam of ../case.toml: water and soil together, in plane strain and small strains.

    python3 dam.py [CELLS] [STEPS] [OUT]

CELLS: cells per metre of height (1 or more; default 2), STEPS: factor on the number of time steps (default 1), OUT: folder
for the tables (default: none, the values are printed only). Needs numpy and scipy.

Equations, with the displacement u (6-node triangles), the pressure head psi (their corners), the effective stress s'
(tension positive), Bishop's coefficient chi = S_e and the water content S (n + tr eps) per initial volume:

    div(s' - chi gamma_w psi 1) + [(1 - n) rho_s + S (n + tr eps) rho_w] g = 0
    d/dt [S (n + tr eps)] = div[K k_r(psi) grad(psi + z)]

S and k_r: van Genuchten (1980) and Mualem (1976). Core: Modified Cam-Clay (Roscoe & Burland 1968), implicit with
logarithmic laws for the pressures; shells: Mohr-Coulomb with a flow rule of its own, returned in principal stresses to
a plane, an edge or the apex. Both equations are solved together by Newton's method in steps of backward Euler.
"""
import os
import sys

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import splu

G, RHO_W = 9.81, 1000.0
GAMMA = G * RHO_W
DAY = 86400.0
HEIGHT, WIDTH, CORE = 10.0, 46.0, (21.0, 25.0)

SHELL = dict(n=0.3, rho=2650.0, K=1e-4, theta_r=0.03, alpha=2.0, vg=2.0, k0=0.45, E=4e7, nu=0.3,
             c=5e3, phi=np.radians(38.0), psi=np.radians(8.0))
CLAY = dict(n=0.4, rho=2700.0, K=1e-9, theta_r=0.08, alpha=0.1, vg=1.5, k0=0.6, nu=0.3,
            lam=0.08, kappa=0.016, M=1.0, pc=1e5)
INITIAL_HEAD = -2.0
LOAD = 4e4          # Pa, on the crest, grows over 30 days
FULL = 8.0          # m, level of the reservoir, which rises from day 60 to day 160


def load_at(t):
    return LOAD * min(t / (30 * DAY), 1.0)


def level_at(t):
    return FULL * min(max(t / DAY - 60.0, 0.0) / 100.0, 1.0)


# ---- retention ------------------------------------------------------------------------------------------------------
def effective_saturation(m, psi):
    return (1.0 + (m["alpha"] * np.maximum(-psi, 0.0)) ** m["vg"]) ** -(1.0 - 1.0 / m["vg"])


def relative_permeability(m, psi):
    def mualem(head):
        se, e = effective_saturation(m, head), 1.0 - 1.0 / m["vg"]
        return np.sqrt(se) * (1.0 - (1.0 - np.minimum(se, 1.0) ** (1.0 / e)) ** e) ** 2
    if m["vg"] >= 2.0:
        return mualem(psi)
    straight = 1e-3  # m: a straight line over the last millimetre, where the slope is infinite
    return np.where(psi < -straight, mualem(np.minimum(psi, -straight)),
                    1.0 + np.minimum(psi, 0.0) / straight * (1.0 - mualem(np.array(-straight))))


def saturation(m, psi):
    return (m["theta_r"] + (m["n"] - m["theta_r"]) * effective_saturation(m, psi)) / m["n"]


def slope(f, m, psi, d=1e-7):
    return (f(m, psi + d) - f(m, psi - d)) / (2 * d)


def borne(m, psi):
    """chi p / gamma_w [m]."""
    return effective_saturation(m, psi) * psi


# ---- materials: stress [.., 4] = xx, yy, zz, xy; strain increments [.., 3] = xx, yy, gamma_xy --------------------------
def cam_clay(stress, pc, v, strain, steps=2):
    a_, b_ = 1.0 / CLAY["kappa"], 1.0 / (CLAY["lam"] - CLAY["kappa"])
    m2, ratio = CLAY["M"] ** 2, 1.5 * (1 - 2 * CLAY["nu"]) / (1 + CLAY["nu"])
    stress, pc, v = stress.copy(), pc.copy(), v.copy()
    d = strain / steps
    compression = -(d[:, 0] + d[:, 1])
    e = np.stack([d[:, 0] + compression / 3, d[:, 1] + compression / 3, compression / 3, 0.5 * d[:, 2]], 1)
    dot = lambda x, y: x[:, 0] * y[:, 0] + x[:, 1] * y[:, 1] + x[:, 2] * y[:, 2] + 2 * x[:, 3] * y[:, 3]
    ee = dot(e, e)
    for _ in range(steps):
        p0 = np.maximum(-stress[:, :3].sum(1) / 3, 1.0)
        s0 = stress.copy()
        s0[:, :3] += p0[:, None]
        mid = v * (1 - 0.5 * compression)
        a, b = mid * a_, mid * b_
        ss, se = dot(s0, s0), dot(s0, e)
        x, plastic = np.zeros_like(p0), np.zeros_like(p0)  # multiplier, plastic compression
        yields = None
        for round_ in range(60):
            p = p0 * np.exp(a * (compression - plastic))
            pc_new = pc * np.exp(b * plastic)
            g = ratio * a * np.sqrt(np.maximum(p0, 1e3) * np.maximum(p, 1e3))
            dg = np.where(p > 1e3, -0.5 * a * g, 0.0)
            trial = 1.5 * (ss + 4 * g * se + 4 * g * g * ee)
            w = 1 / (1 + 6 * g * x / m2)
            f = trial * w * w / m2 + p * (p - pc_new)
            if yields is None:
                yields = f > 1e-12 * pc * pc
            flow = 2 * p - pc_new
            r = plastic - x * flow
            if not np.any(yields & ((abs(f) > 1e-12 * pc * pc) | (abs(r) > 1e-14))):
                break
            dp, dpc = -a * p, b * pc_new
            r_d, r_x = 1 - x * (2 * dp - dpc), -flow
            f_d = (1.5 * (4 * se + 8 * g * ee) * dg * w * w - trial * 2 * w ** 3 * 6 * x / m2 * dg) / m2 \
                + dp * flow - p * dpc
            f_x = -trial * 2 * w ** 3 * 6 * g / m2 / m2
            det = r_d * f_x - r_x * f_d
            det = np.where(det == 0, 1.0, det)
            plastic = np.where(yields, plastic - (r * f_x - f * r_x) / det, 0.0)
            x = np.where(yields, x - (f * r_d - r * f_d) / det, 0.0)
        else:
            raise ArithmeticError("Cam-Clay: no stress was found")
        s = (s0 + 2 * g[:, None] * e) * w[:, None]
        s[:, :3] -= p[:, None]
        stress, pc, v = s, pc_new, v * (1 - compression)
    return stress, pc, v


def mohr_coulomb(stress, strain):
    E, nu, c, phi, psi = (SHELL[k] for k in ("E", "nu", "c", "phi", "psi"))
    lame, mu = E * nu / (1 + nu) / (1 - 2 * nu), E / 2 / (1 + nu)
    volumetric = strain[:, 0] + strain[:, 1]
    trial = stress.copy()
    for k in range(2):
        trial[:, k] += lame * volumetric + 2 * mu * strain[:, k]
    trial[:, 2] += lame * volumetric
    trial[:, 3] += mu * strain[:, 2]
    centre, half = 0.5 * (trial[:, 0] + trial[:, 1]), 0.5 * (trial[:, 0] - trial[:, 1])
    radius = np.hypot(half, trial[:, 3])
    three = np.stack([centre + radius, centre - radius, trial[:, 2]], 1)
    order = np.argsort(-three, axis=1, kind="stable")
    s = np.take_along_axis(three, order, 1)
    d = lame * np.ones((3, 3)) + 2 * mu * np.eye(3)
    up, down = 1 + np.sin(phi), 1 - np.sin(phi)
    up_g, down_g = 1 + np.sin(psi), 1 - np.sin(psi)
    k = 2 * c * np.cos(phi)
    normals = np.array([[up, 0, -down], [0, up, -down], [up, -down, 0]])
    flows = np.array([[up_g, 0, -down_g], [0, up_g, -down_g], [up_g, -down_g, 0]]) @ d
    f = s @ normals.T - k
    yields = f[:, 0] > 1e-9 * (abs(s).max(1) + k)
    new = s - (f[:, :1] / (normals[0] @ flows[0])) * flows[0]
    eps = 1e-9 * (abs(s).max(1) + k)
    for other, wrong in ((1, new[:, 1] > new[:, 0] + eps), (2, new[:, 2] > new[:, 1] + eps)):
        pair = [0, other]
        matrix = normals[pair] @ flows[pair].T
        edge = s - np.linalg.solve(matrix, f[:, pair].T).T @ flows[pair]
        new = np.where(wrong[:, None], edge, new)
    tip = c / np.tan(phi)
    new = np.where((new[:, 0] > tip + eps)[:, None], tip, new)
    s = np.where(yields[:, None], new, s)
    back = np.empty_like(s)
    np.put_along_axis(back, order, s, 1)
    centre, r = 0.5 * (back[:, 0] + back[:, 1]), 0.5 * (back[:, 0] - back[:, 1])
    share = np.where(radius > 0, r / np.where(radius > 0, radius, 1), 0)
    return np.stack([centre + share * half, centre - share * half, back[:, 2], share * trial[:, 3]], 1), yields


# ---- mesh -------------------------------------------------------------------------------------------------------------
class Mesh:
    """Cells of 2 : 1 in the shells, whose diagonals run along the slopes, and of half that width in the core, each cut
    into two triangles with 6 nodes."""

    def __init__(self, cells):
        dz = 1.0 / cells
        left = np.arange(0, CORE[0] + 1e-9, 2 * dz)
        xs = np.unique(np.round(np.concatenate([left, np.arange(CORE[0], CORE[1] + 1e-9, dz), WIDTH - left]), 9))
        zs = np.arange(0, HEIGHT + 1e-9, dz)
        corners, index = [], {}

        def node(x, z):
            key = (round(x, 6), round(z, 6))
            if key not in index:
                index[key] = len(corners)
                corners.append((x, z))
            return index[key]
        triangles, material = [], []
        for x0, x1 in zip(xs, xs[1:]):
            rising = 0.5 * (x0 + x1) < WIDTH / 2
            for z0, z1 in zip(zs, zs[1:]):
                two = [[(x0, z0), (x1, z0), (x1, z1)], [(x0, z0), (x1, z1), (x0, z1)]] if rising else \
                      [[(x0, z0), (x1, z0), (x0, z1)], [(x1, z0), (x1, z1), (x0, z1)]]
                for t in two:
                    cx, cz = np.mean(t, axis=0)
                    if cz > cx / 2 or cz > (WIDTH - cx) / 2:
                        continue
                    triangles.append([node(*q) for q in t])
                    material.append(int(CORE[0] < cx < CORE[1]))
        self.heads = len(corners)
        middle, six = {}, []
        for t in triangles:
            extra = []
            for i, j in ((0, 1), (1, 2), (2, 0)):
                key = tuple(sorted((t[i], t[j])))
                if key not in middle:
                    middle[key] = len(corners)
                    corners.append(tuple(0.5 * (np.array(corners[t[i]]) + np.array(corners[t[j]]))))
                extra.append(middle[key])
            six.append(t + extra)
        self.x, self.t, self.clay = np.array(corners), np.array(six), np.array(material) == 1
        p = self.x[self.t[:, :3]]
        b = np.stack([p[:, 1, 1] - p[:, 2, 1], p[:, 2, 1] - p[:, 0, 1], p[:, 0, 1] - p[:, 1, 1]], 1)
        c = np.stack([p[:, 2, 0] - p[:, 1, 0], p[:, 0, 0] - p[:, 2, 0], p[:, 1, 0] - p[:, 0, 0]], 1)
        self.area = 0.5 * (b[:, 0] * c[:, 1] - b[:, 1] * c[:, 0])
        assert (self.area > 0).all()
        self.b, self.c = b / (2 * self.area[:, None]), c / (2 * self.area[:, None])  # gradients of the corner functions
        points = np.array([[2 / 3, 1 / 6, 1 / 6], [1 / 6, 2 / 3, 1 / 6], [1 / 6, 1 / 6, 2 / 3]])
        self.L = points
        self.N = self.shape(points)
        ne = len(self.t)
        self.B = np.zeros((ne, 3, 3, 12))
        for q, L in enumerate(points):
            dl = np.zeros((6, 3))
            for i in range(3):
                dl[i, i] = 4 * L[i] - 1
            for k, (i, j) in enumerate(((0, 1), (1, 2), (2, 0))):
                dl[3 + k, i], dl[3 + k, j] = 4 * L[j], 4 * L[i]
            dx, dy = self.b @ dl.T, self.c @ dl.T
            self.B[:, q, 0, 0::2] = dx
            self.B[:, q, 1, 1::2] = dy
            self.B[:, q, 2, 0::2] = dy
            self.B[:, q, 2, 1::2] = dx
        self.w = self.area / 3
        self.gauss = np.einsum("ql,eld->eqd", points, p)
        self.dofs = np.stack([2 * self.t, 2 * self.t + 1], 2).reshape(ne, 12)

    @staticmethod
    def shape(L):
        L = np.atleast_2d(L)
        return np.concatenate([L * (2 * L - 1), 4 * np.stack([L[:, 0] * L[:, 1], L[:, 1] * L[:, 2], L[:, 2] * L[:, 0]],
                                                              1)], 1)

    def edges(self, on):
        """3-node edges of the border (first, last, middle) whose ends satisfy on(x, z), walked with the soil on the
        left."""
        found = []
        for t in self.t:
            for k, (i, j) in enumerate(((0, 1), (1, 2), (2, 0))):
                if on(*self.x[t[i]]) and on(*self.x[t[j]]):
                    found.append([t[i], t[j], t[3 + k]])
        return np.array(found)

    def at(self, where):
        """Element and corner coordinates of a place."""
        p = self.x[self.t[:, :3]]
        L = np.stack([1 / 3 + self.b[:, i] * (where[0] - p[:, :, 0].mean(1)) + self.c[:, i] * (where[1] - p[:, :, 1].mean(1))
                      for i in range(3)], 1)
        e = int(np.argmax(L.min(1)))
        return e, L[e]


class Dam:
    def __init__(self, cells):
        m = self.m = Mesh(cells)
        self.nu, self.np = 2 * len(m.x), m.heads
        clay = m.clay
        self.value = lambda key: np.where(clay, CLAY[key], SHELL[key])
        self.n, self.K = self.value("n"), self.value("K")
        top = lambda x: np.minimum(np.minimum(x / 2, (WIDTH - x) / 2), HEIGHT)
        dry = (1 - self.n) * self.value("rho") * G
        water = self.n * self.by_soil(saturation, np.full(len(clay), INITIAL_HEAD)) * GAMMA
        self.dry = dry
        depth = top(m.gauss[:, :, 0]) - m.gauss[:, :, 1]
        suction = self.by_soil(borne, np.full(len(clay), INITIAL_HEAD)) * GAMMA
        vertical = -(dry + water)[:, None] * depth + suction[:, None]
        self.stress = np.zeros(m.B.shape[:2] + (4,))
        self.stress[..., 1] = vertical
        self.stress[..., 0] = self.stress[..., 2] = self.value("k0")[:, None] * vertical
        s = self.stress[clay].reshape(-1, 4)
        p = -s[:, :3].sum(1) / 3
        q2 = 1.5 * (((s[:, :3] + p[:, None]) ** 2).sum(1) + 2 * s[:, 3] ** 2)
        p = np.maximum(p, 1e3)
        self.pc = np.maximum(CLAY["pc"], p + q2 / (CLAY["M"] ** 2 * p))
        self.v = np.full(len(p), 1 / (1 - CLAY["n"]))
        self.u, self.psi = np.zeros(self.nu), np.full(self.np, INITIAL_HEAD)
        self.time = 0.0
        self.yielded = np.zeros(m.B.shape[:2], bool)
        on_base = abs(m.x[:, 1]) < 1e-6
        self.free = np.ones(self.nu + self.np, bool)
        self.free[:self.nu] = np.repeat(~on_base, 2)
        self.crest = m.edges(lambda x, z: abs(z - HEIGHT) < 1e-6)
        self.wet = m.edges(lambda x, z: abs(z - x / 2) < 1e-6 and x <= 20 + 1e-6)
        self.outlets = np.concatenate([m.edges(lambda x, z: abs(z - (WIDTH - x) / 2) < 1e-6),
                                       m.edges(lambda x, z: abs(z) < 1e-6 and x >= 26 - 1e-6)])
        lengths = lambda edges: np.linalg.norm(m.x[edges[:, 1]] - m.x[edges[:, 0]], axis=1)
        conductance = SHELL["K"] / 0.02  # m/s per m of head: the border's head is met within 2 cm of soil
        self.of_reservoir, self.of_outlet = np.zeros(self.np), np.zeros(self.np)
        for edges, into in ((self.wet, self.of_reservoir), (self.outlets, self.of_outlet)):
            for k in range(2):
                np.add.at(into, edges[:, k], 0.5 * lengths(edges) * conductance)
        self.dz = 1.0 / cells
        ne = len(m.t)
        self.rows_u = np.repeat(m.dofs, 12, 1).ravel()
        self.cols_u = np.tile(m.dofs, (1, 12)).ravel()
        t3 = self.nu + m.t[:, :3]
        self.rows_up, self.cols_up = np.repeat(m.dofs, 3, 1).ravel(), np.tile(t3, (1, 12)).ravel()
        self.rows_pu, self.cols_pu = np.repeat(t3, 12, 1).ravel(), np.tile(m.dofs, (1, 3)).ravel()
        self.edge_of = ((0, 1), (1, 2), (2, 0))
        # Transmissibility of the link of two corners in a triangle; of right angles none is negative.
        self.T = [-(m.b[:, i] * m.b[:, j] + m.c[:, i] * m.c[:, j]) * m.area * self.K for i, j in self.edge_of]
        assert min(t.min() for t in self.T) > -1e-12
        self.held = None

    def by_soil(self, f, psi):
        """f of each element's soil at heads [elements, ..]."""
        clay = self.m.clay
        out = np.empty_like(psi)
        out[clay], out[~clay] = f(CLAY, psi[clay]), f(SHELL, psi[~clay])
        return out

    def slope_by_soil(self, f, psi):
        return (self.by_soil(f, psi + 1e-7) - self.by_soil(f, psi - 1e-7)) / 2e-7

    def stresses(self, strain):
        """Stress and state after a strain increment [elements, 3, 3]."""
        clay = self.m.clay
        out = np.empty_like(self.stress)
        s, pc, v = cam_clay(self.stress[clay].reshape(-1, 4), self.pc, self.v, strain[clay].reshape(-1, 3))
        out[clay] = s.reshape(-1, 3, 4)
        s, yields = mohr_coulomb(self.stress[~clay].reshape(-1, 4), strain[~clay].reshape(-1, 3))
        out[~clay] = s.reshape(-1, 3, 4)
        return out, pc, v, yields

    def tangent(self, strain, stress):
        d = np.empty(stress.shape[:2] + (3, 3))
        for k in range(3):
            step = strain.copy()
            step[..., k] += 1e-9
            d[..., k] = (self.stresses(step)[0] - stress)[..., [0, 1, 3]] / 1e-9
        return d

    def outside(self, t):
        """Forces of load and reservoir on the nodes."""
        m, f = self.m, np.zeros(self.nu)
        level = level_at(t)
        for edges, pressure in ((self.crest, lambda z: np.full_like(z, load_at(t))),
                                (self.wet, lambda z: GAMMA * np.maximum(level - z, 0.0))):
            a, b = m.x[edges[:, 0]], m.x[edges[:, 1]]
            inwards = np.stack([-(b - a)[:, 1], (b - a)[:, 0]], 1)  # of the edge's length
            for at, weight in ((0.5 - np.sqrt(0.15), 5 / 18), (0.5, 8 / 18), (0.5 + np.sqrt(0.15), 5 / 18)):
                N = [(1 - at) * (1 - 2 * at), at * (2 * at - 1), 4 * at * (1 - at)]
                p = pressure((a + at * (b - a))[:, 1])
                for k in range(3):
                    for d in range(2):
                        np.add.at(f, 2 * edges[:, k] + d, weight * N[k] * p * inwards[:, d])
        return f

    def system(self, u, psi, t, dt, share=1.0, jacobian=True, water=True):
        """Residual and matrix of the step from the present state to (u, psi) at the time t."""
        m = self.m
        strain_all = np.einsum("eqij,ej->eqi", m.B, u[m.dofs])
        strain = strain_all - np.einsum("eqij,ej->eqi", m.B, self.u[m.dofs])
        stress, pc, v, yields = self.stresses(strain)
        self.trial = stress, pc, v, yields
        volumetric = strain_all[..., 0] + strain_all[..., 1]
        head = psi[m.t[:, :3]]
        at_gauss = head @ m.L.T
        chi_p = self.by_soil(borne, at_gauss) * GAMMA
        sat = self.by_soil(saturation, at_gauss)
        total = stress[..., [0, 1, 3]].copy()
        total[..., 0] -= chi_p
        total[..., 1] -= chi_p
        force = np.einsum("e,eqij,eqi->ej", m.w, m.B, total)
        weight = self.dry[:, None] + GAMMA * sat * (self.n[:, None] + volumetric)
        force[:, 1::2] += np.einsum("e,eq,qn->en", m.w, weight, m.N)
        residual = np.zeros(self.nu + self.np)
        np.add.at(residual, m.dofs, force)
        residual[:self.nu] -= self.outside(t)
        if self.held is not None:
            residual[:self.nu] -= (1 - share) * self.held
        # Water: per element and corner.
        sat_c = self.by_soil(saturation, head)
        pores = self.n[:, None] * m.area[:, None] / 3 + np.einsum("e,eq,qc->ec", m.w, volumetric, m.L)
        content = np.zeros(self.np)
        np.add.at(content, m.t[:, :3], sat_c * pores)
        self.content_trial = content
        entries = []
        if water:
            flow, z = np.zeros(self.np), m.x[:self.np, 1]
            k_r, dk_r = self.by_soil(relative_permeability, head), self.slope_by_soil(relative_permeability, head)
            for (i, j), T in zip(self.edge_of, self.T):
                a, b = m.t[:, i], m.t[:, j]
                drop = head[:, i] - head[:, j] + z[a] - z[b]
                first = np.where(m.clay, 0.5, (drop >= 0).astype(float))  # the mean in clay, else upstream
                k = first * k_r[:, i] + (1 - first) * k_r[:, j]
                F = T * k * drop
                np.add.at(flow, a, -F)
                np.add.at(flow, b, F)
                F_i = T * (k + drop * first * dk_r[:, i])
                F_j = T * (-k + drop * (1 - first) * dk_r[:, j])
                entries += [(a, a, dt * F_i), (a, b, dt * F_j), (b, a, -dt * F_i), (b, b, -dt * F_j)]
            level = level_at(t)
            wet = np.clip((level - z) / self.dz + 0.5, 0, 1) if level > 0 else np.zeros_like(z)
            inflow = self.of_reservoir * (wet * (np.maximum(level - z, 0) - psi) - (1 - wet) * np.maximum(psi, 0))
            d_in = -self.of_reservoir * (wet + (1 - wet) * (psi > 0))
            out = self.of_outlet * np.maximum(psi, 0)
            self.inflow, self.outflow = inflow.sum(), out.sum()
            residual[self.nu:] = content - self.content - dt * (flow + inflow - out)
            node = np.arange(self.np)
            entries.append((node, node, -dt * (d_in - self.of_outlet * (psi > 0))))
        else:
            residual[self.nu:] = 0.0
        if not jacobian:
            return residual, None
        D = self.tangent(strain, stress)
        K = np.einsum("e,eqia,eqij,eqjb->eab", m.w, m.B, D, m.B, optimize=True)
        div = m.B[:, :, 0] + m.B[:, :, 1]
        K[:, 1::2] += np.einsum("e,eq,qn,eqb->enb", m.w, GAMMA * sat, m.N, div)
        up = -np.einsum("e,eqa,eq,qc->eac", m.w, div, GAMMA * self.slope_by_soil(borne, at_gauss), m.L)
        up[:, 1::2] += np.einsum("e,qn,eq,qc->enc", m.w, m.N, GAMMA * self.slope_by_soil(saturation, at_gauss) *
                                 (self.n[:, None] + volumetric), m.L)
        pu = np.einsum("e,eqb,qc,ec->ecb", m.w, div, m.L, sat_c)
        rows, cols, values = [self.rows_u], [self.cols_u], [K.ravel()]
        if water:
            rows += [self.rows_up, self.rows_pu]
            cols += [self.cols_up, self.cols_pu]
            values += [up.ravel(), pu.ravel()]
            entries.append((m.t[:, :3].ravel(), m.t[:, :3].ravel(), (self.slope_by_soil(saturation, head) * pores).ravel()))
            for r, c, x in entries:
                rows.append(self.nu + r)
                cols.append(self.nu + c)
                values.append(x)
        size = self.nu + self.np
        matrix = coo_matrix((np.concatenate(values), (np.concatenate(rows), np.concatenate(cols))), (size, size)).tocsc()
        return residual, matrix

    def solve(self, t, dt, share=1.0, water=True, most=25):
        """One step; returns the number of iterations, or 0 where Newton's method fails."""
        u, psi = self.u.copy(), self.psi.copy()
        free = self.free.copy()
        free[self.nu:] = water
        keep = np.flatnonzero(free)
        weight, pores = 1e5, 1e-2  # N and m2: scales of a node's residuals
        scale = np.concatenate([np.full(self.nu, 1 / weight), np.full(self.np, 1 / pores)])
        try:
            residual, matrix = self.system(u, psi, t, dt, share, water=water)
            for iteration in range(1, most):
                full = np.zeros(self.nu + self.np)
                full[keep] = splu(matrix[keep][:, keep]).solve(-residual[keep])
                norm = np.linalg.norm((residual * scale)[keep])
                for f in 0.5 ** np.arange(6):
                    new = u + f * full[:self.nu], psi + f * full[self.nu:]
                    residual, matrix = self.system(*new, t, dt, share, water=water)
                    left = np.linalg.norm((residual * scale)[keep])
                    if left < norm * (1 - 0.1 * f) or left < 1e-7:
                        break
                u, psi = new
                if left < 1e-7:
                    self.u, self.psi = u, psi
                    self.stress, self.pc, self.v, yields = self.trial
                    self.yielded[~self.m.clay] |= yields.reshape(-1, 3)
                    return iteration
        except (ArithmeticError, RuntimeError) as problem:
            print("   ", problem)
        return 0

    def come_to_rest(self, steps=4):
        residual, _ = self.system(self.u, self.psi, 0.0, 0.0, jacobian=False, water=False)
        self.held = residual[:self.nu].copy()
        self.held[~self.free[:self.nu]] = 0.0
        for k in range(1, steps + 1):
            n = self.solve(0.0, 0.0, share=k / steps, water=False)
            print(f"rest {k}/{steps}: {n} iterations", flush=True)
            assert n
        self.held = None
        self.rest = self.u.copy()
        self.yielded[:] = False
        _, _ = self.system(self.u, self.psi, 0.0, 0.0, jacobian=False, water=False)
        self.content = self.content_trial.copy()

    def advance(self, until, longest):
        dt = min(longest, until - self.time)
        while self.time < until - 1.0:
            dt = min(dt, until - self.time, longest)
            n = self.solve(self.time + dt, dt)
            if not n:
                dt *= 0.5
                print(f"    day {self.time / DAY:.2f}: step of {dt / DAY:.3f} days", flush=True)
                assert dt > 100.0
                continue
            self.time += dt
            self.content = self.content_trial.copy()
            if n < 8:
                dt *= 1.5

    # ---- readings -------------------------------------------------------------------------------------------------
    def displacement(self, where):
        e, L = self.m.at(where)
        N = self.m.shape(L)[0]
        return N @ self.u[2 * self.m.t[e]], N @ self.u[2 * self.m.t[e] + 1]

    def head(self, where):
        e, L = self.m.at(where)
        return L @ self.psi[self.m.t[e, :3]]

    def effective_stress(self, where):
        """Linear fit through the integration points of the same soil and half of the dam within 0.8 m."""
        m = self.m
        e, _ = m.at(where)
        d = m.gauss - np.array(where)
        near = (np.hypot(d[..., 0], d[..., 1]) < 0.8) & (m.clay == m.clay[e])[:, None] & \
               ((m.gauss[..., 0] < WIDTH / 2) == (where[0] <= WIDTH / 2))
        A = np.concatenate([np.ones((near.sum(), 1)), d[near]], 1)
        return np.linalg.lstsq(A, self.stress[near], rcond=None)[0][0]


PLACES = dict(
    psi=[[23, 1], [23, 3], [23, 5], [23, 7], [23, 9], [22, 1], [22, 3], [22, 5], [24, 1], [24, 3], [24, 5], [15, 2],
         [18, 4]],
    u=[[23, 10], [23, 8], [23, 6], [23, 4], [23, 2], [20.5, 10], [25.5, 10], [15, 7], [31, 7], [18, 4], [28, 4]],
    stress=[[9, 3], [12, 3], [15, 3], [18, 3], [20, 3], [22, 3], [23, 3], [26, 3], [28, 3], [31, 3], [34, 3],
            [37, 3]])
# Day, and the longest step [days] on the way to it.
STAGES = ((30, 2), (60, 6), (120, 3), (160, 3), (300, 10), (900, 60))


def readings(dam):
    row = {}
    for k, x in enumerate(PLACES["psi"]):
        row[f"psi[{k}]"] = dam.head(x)
    moved = [dam.displacement(x) for x in PLACES["u"]]
    stress = [dam.effective_stress(x) for x in PLACES["stress"]]
    for name, values in (("shift", [u[0] for u in moved]), ("rise", [u[1] for u in moved]),
                         ("across", [s[0] for s in stress]), ("upright", [s[1] for s in stress])):
        row.update({f"{name}[{k}]": x for k, x in enumerate(values)})
    return row


def main():
    cells = int(sys.argv[1]) if len(sys.argv) > 1 else 2
    factor = float(sys.argv[2]) if len(sys.argv) > 2 else 1.0
    out = sys.argv[3] if len(sys.argv) > 3 else None
    dam = Dam(cells)
    print(f"{len(dam.m.t)} triangles, {dam.nu} displacements, {dam.np} heads", flush=True)
    dam.come_to_rest()
    table = [readings(dam)]
    for day, longest in STAGES:
        dam.advance(day * DAY, longest / factor * DAY)
        table.append(readings(dam))
        print(f"day {day}: inflow {dam.inflow:.3g} m2/s, {dam.yielded[~dam.m.clay].sum()} points of the shells have "
              f"yielded", flush=True)
        days = [0] + [d for d, _ in STAGES][:len(table) - 1]
        if out:
            write(out, days, table)
    for name in table[0]:
        print(f"{name:16s}", " ".join(f"{row[name]:11.5g}" for row in table))


def write(out, days, table):
    """OUT/QUANTITY_DAY.csv: number of the place and value."""
    os.makedirs(out, exist_ok=True)
    for day, row in zip(days, table):
        for name in ("psi", "shift", "rise", "across", "upright"):
            with open(os.path.join(out, f"{name}_{day}d.csv"), "w") as file:
                file.write("place,value\n")
                k = 0
                while f"{name}[{k}]" in row:
                    file.write(f"{k},{row[f'{name}[{k}]']:.6g}\n")
                    k += 1


if __name__ == "__main__":
    main()
