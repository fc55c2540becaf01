"""Steady seepage with a free surface through a dam with vertical sides whose soil lies in inclined beds.

In coordinates in which lengths across the beds are multiplied by sqrt(k_h / k_v), the soil is isotropic with the
conductivity sqrt(k_h k_v) (Samsioe 1931), and the rectangular dam is a parallelogram. There the heads h are found by
linear finite elements on a mesh that ends at the free surface y = Y(x). No water passes the surface, and Newton's
iteration moves it until h = Y along it. Below its lower end is a seepage face, down to the tailwater.

Prints discharges and water tables on meshes of increasing fineness. Independent of poretwin. Run: python3 free_surface.py
"""
import numpy as np
import scipy.sparse
import scipy.sparse.linalg

LENGTH, UPSTREAM, TAILWATER = 8.0, 6.0, 1.0  # m
ALONG, RATIO, SLOPE = 1e-4, 10.0, -30.0  # m/s, 1, degrees: k_h, k_h / k_v, the beds fall downstream
READ_AT = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0)  # m


class Dam:
    """A mesh of 2 n^2 triangles in n columns, which become narrower towards the downstream side. slope: of the beds
    [degrees]; they rise downstream where it is positive."""

    def __init__(self, n, slope, ratio, length=LENGTH, upstream=UPSTREAM, tailwater=TAILWATER, along=ALONG):
        self.n, self.length, self.upstream, self.tailwater = n, length, upstream, tailwater
        c, s = np.cos(np.radians(slope)), np.sin(np.radians(slope))
        self.conductivity = along / np.sqrt(ratio)
        self.kxx, self.kxy = along * (c * c + s * s / ratio), along * (1.0 - 1.0 / ratio) * s * c
        self.stretch = np.eye(2) + (np.sqrt(ratio) - 1.0) * np.outer([-s, c], [-s, c])
        self.root = 1.0 - np.arange(n + 1) / n  # sqrt((L - x) / L) in each column
        self.x = length * (1.0 - self.root**2)
        i, j = (a.ravel() for a in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
        corners = [k * (n + 1) + l for k, l in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))]
        self.triangles = np.concatenate([np.stack([corners[0], corners[k], corners[k + 1]], 1) for k in (1, 2)])
        self.top = (np.arange(n + 1) + 1) * (n + 1) - 1  # the points on the surface

    def assemble(self, y):
        """The matrix of the points' balances, their inflows, and the heads where they are prescribed."""
        n = self.n
        # Towards the downstream side the points shift so that one of them is at the tailwater's level there.
        level = np.linspace(0.0, 1.0, n + 1)
        split = max(1, round(n * self.tailwater / y[-1]))
        shifted = np.interp(level, [0.0, split / n, 1.0], [0.0, self.tailwater / y[-1], 1.0])
        share = level + (1.0 - self.root[:, None]) ** 2 * (shifted - level)
        points = np.stack([np.repeat(self.x[:, None], n + 1, 1), share * y[:, None]], 2).reshape(-1, 2)
        corners = (points @ self.stretch.T)[self.triangles]
        edges = np.roll(corners, -1, 1) - np.roll(corners, -2, 1)  # opposite to each corner
        twice = np.abs(edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0])
        local = self.conductivity * np.einsum("eik,ejk->eij", edges, edges) / (2.0 * twice)[:, None, None]
        rows = np.repeat(self.triangles, 3, 1).ravel()
        columns = np.tile(self.triangles, (1, 3)).ravel()
        matrix = scipy.sparse.csr_matrix((local.ravel(), (rows, columns)))
        head = np.full(len(points), np.nan)
        head[: n + 1] = self.upstream
        head[-n - 1 : -1] = np.maximum(points[-n - 1 : -1, 1], self.tailwater)
        # At the surface's lower end p = 0 on both sides of a corner. Water leaves there as it falls freely in the soil
        # where it falls towards the side (k_xy < 0); otherwise the surface is tangent to the side and none leaves.
        inflow = np.zeros(len(points))
        inflow[-1] = 0.5 * (points[-1, 1] - points[-2, 1]) * min(0.0, self.kxy)
        return matrix, inflow, head

    def heads(self, y):
        matrix, inflow, head = self.assemble(y)
        free = np.isnan(head)
        head[free] = 0.0
        factors = scipy.sparse.linalg.splu(matrix[free][:, free].tocsc())
        head[free] = factors.solve((inflow - matrix @ head)[free])
        return head, free, factors, matrix

    def solve(self, y):
        """Newton's iteration for the surface. Returns Y, the discharge, and the heads along the base."""
        moving = np.arange(1, self.n + 1)
        gap = lambda y, head: head[self.top[1:]] - y[1:]
        head, free, factors, matrix = self.heads(y)
        for _ in range(40):
            left = gap(y, head)
            if np.abs(left).max() < 1e-9 * self.upstream:
                return y, (matrix @ head)[: self.n + 1].sum(), head[:: self.n + 1]
            step, balance = 1e-6 * self.upstream, np.zeros((int(free.sum()), self.n))
            for i in moving:
                other = y.copy()
                other[i] += step
                changed, inflow, there = self.assemble(other)
                there[free] = head[free]
                balance[:, i - 1] = (changed @ there - inflow)[free] / step
            response = np.zeros((len(head), self.n))
            response[free] = -factors.solve(balance)
            change = np.linalg.solve(response[self.top[1:]] - np.eye(self.n), -left)
            part = min(1.0, 0.1 * self.upstream / np.abs(change).max())
            for _ in range(6):
                other = y.copy()
                other[1:] += part * change
                head, free, factors, matrix = self.heads(other)
                if np.abs(gap(other, head)).max() < np.abs(left).max():
                    break
                part *= 0.5
            y = other
        raise RuntimeError("no surface found")

    def by_balance(self, y, base):
        """Discharge from the integral of k_xx dh/dx + k_xy dh/dy over the wet soil: Dupuit's formula (Charny 1951) for
        beds of any slope."""
        dupuit = self.kxx * (self.upstream**2 - self.tailwater**2) / 2.0
        return (dupuit - self.kxy * np.trapz(y - base, self.x)) / self.length


def refine(numbers, *dam):
    """Solutions with these numbers of columns; each is the first guess of the next."""
    last = None
    for n in numbers:
        mesh = Dam(n, *dam)
        if last is None:
            y = np.sqrt(mesh.upstream**2 - 0.7 * mesh.upstream**2 * mesh.x / mesh.length)
        else:
            y = np.interp(-mesh.root, -last.root, y)
        y, discharge, base = mesh.solve(y)
        last = mesh
        yield mesh, y, discharge, base


if __name__ == "__main__":
    # Without beds Dupuit's discharge is exact.
    for mesh, y, q, _ in refine((12, 24, 48), 0.0, 1.0, 16.0, 24.0, 4.0, 1.0):
        print(f"isotropic, {mesh.n} columns: discharge {q / 17.5 - 1.0:+.1e} off, lower end at {y[-1]:.3f} m", flush=True)
    for mesh, y, q, base in refine((12, 24, 48, 96), SLOPE, RATIO):
        print(
            f"beds, {mesh.n} columns: {q:.5e} m2/s, by balance {mesh.by_balance(y, base):.5e}; lower end at {y[-1]:.4f} "
            f"m; table {np.round(np.interp(READ_AT, mesh.x, y), 4)}, heads at the base "
            f"{np.round(np.interp(READ_AT, mesh.x, base), 4)}",
            flush=True,
        )
