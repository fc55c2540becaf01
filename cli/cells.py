"""Draws bodies of particles: every pixel gets the colour of the nearest particle."""
import numpy as np


def spacing(x):
    """Distance between neighbours inside a body [m], from the number of particles within a few such distances. x [m]: positions [n, 2 or 3]."""
    n, dimensions = x.shape
    if n < 2:
        return 1.0
    chosen = np.random.default_rng(0).choice(n, min(n, int(np.clip(4e6 / n, 20, 200))), replace=False)
    near = [np.sqrt(np.partition(((x - x[i]) ** 2).sum(axis=1), 1)[1]) for i in chosen]
    reach = 4.69 * float(np.median(near))  # a circle of this radius contains 69 points of a lattice
    if reach == 0.0:
        return 1.0
    volume = np.pi * reach**2 if dimensions == 2 else 4.0 / 3.0 * np.pi * reach**3
    count = np.array([np.count_nonzero(((x - x[i]) ** 2).sum(axis=1) <= reach**2) for i in chosen])
    own = (volume / count) ** (1.0 / dimensions)
    return float(np.quantile(own, 0.25))  # particles near a surface count fewer neighbours


SURFACE = 0.7  # value of the cover (Canvas.smooth) at which the outline of a body is drawn
BODY = 0.75  # radius of the disc that a particle covers, over its size; slightly more than half the diagonal of its square


class Canvas:
    """A grid of pixels over a section of the plane. dx: distance between particles, which determines the size of a pixel; most: largest number of
    pixels along the longer side."""

    def __init__(self, lower, upper, dx, most=1800):
        size = np.asarray(upper) - np.asarray(lower)
        self.pixel = float(np.clip(dx / 8.0, size.max() / most, size.max() / 600))
        self.lower = np.asarray(lower, dtype=float)
        self.shape = tuple(int(np.ceil(s / self.pixel)) for s in size[::-1])
        self.extent = (lower[0], lower[0] + self.shape[1] * self.pixel, lower[1], lower[1] + self.shape[0] * self.pixel)

    def nearest(self, x, size, reach):
        """For each pixel [rows, columns] the index of the nearest particle, and the pixel's distance from it in units of the particle's size. A
        particle counts only within `reach` times its size; -1: no particle. x: positions [n, 2]; size [n]: edge lengths of the squares that the
        particles represent."""
        found = np.full(self.shape, -1)
        best = np.ones(self.shape)  # squared distance over squared reach
        far = reach * np.asarray(size) / self.pixel
        at = (x - self.lower) / self.pixel - 0.5
        most = int(np.ceil(far.max(initial=0.0)))
        if len(x) > (2 * most + 1) ** 2:
            self.search_by_offsets(at, far, most, found, best)
        else:
            self.search_by_particles(at, far, found, best)
        return found, reach * np.sqrt(best)

    def search_by_offsets(self, at, far, most, found, best):
        """Nearest particles by a loop over the offsets of pixels within reach; each offset is treated for all particles in one operation."""
        home = np.rint(at).astype(int)
        for row in range(-most, most + 1):
            for column in range(-most, most + 1):
                if max(abs(row) - 0.5, 0.0) ** 2 + max(abs(column) - 0.5, 0.0) ** 2 >= most**2:
                    continue  # out of every particle's reach
                place = home + (column, row)
                distance = ((place - at) ** 2).sum(axis=1) / far**2
                mine = np.flatnonzero((distance < 1.0) & (place >= 0).all(axis=1) & (place < self.shape[::-1]).all(axis=1))
                i, j, d = place[mine, 1], place[mine, 0], distance[mine]
                nearer = d < best[i, j]
                best[i[nearer], j[nearer]] = d[nearer]
                found[i[nearer], j[nearer]] = mine[nearer]

    def search_by_particles(self, at, far, found, best):
        """Nearest particles by a loop over particles, each treated for all pixels around it: faster where particles are few and large."""
        first, last = np.maximum(np.ceil(at - far[:, None]).astype(int), 0), np.floor(at + far[:, None]).astype(int) + 1
        for k in range(len(at)):
            rows, columns = slice(first[k, 1], max(last[k, 1], 0)), slice(first[k, 0], max(last[k, 0], 0))
            near, index = best[rows, columns], found[rows, columns]  # views
            n, m = near.shape
            distance = ((np.arange(n) + (first[k, 1] - at[k, 1])) ** 2)[:, None] + (np.arange(m) + (first[k, 0] - at[k, 0])) ** 2
            distance /= far[k] ** 2
            nearer = distance < near
            near[nearer], index[nearer] = distance[nearer], k

    def smooth(self, inside, size):
        """The cover of each pixel: the mask `inside`, averaged over about a spacing. It is 1 well inside a body, 0 outside, SURFACE at half a
        spacing from the outermost particle."""
        inside = inside.astype(float)
        width = max(1, int(round(0.35 * float(np.median(size)) / self.pixel)))
        for axis in (0, 1, 0, 1):
            ends = [(width + 1, width) if other == axis else (0, 0) for other in (0, 1)]
            sums = np.cumsum(np.pad(inside, ends), axis=axis)
            n = inside.shape[axis]
            inside = (sums.take(range(2 * width + 1, 2 * width + 1 + n), axis) - sums.take(range(n), axis)) / (2 * width + 1)
        return inside

    def cover(self, x, size):
        """The cover of each pixel by the body of these particles: 1 inside, 0 outside."""
        return self.smooth(self.nearest(x, size, BODY)[0] >= 0, size)

    def fill(self, x, values, size):
        """For each pixel the value of the nearest particle (NaN outside the particles' body), and the body's cover."""
        near, distance = self.nearest(x, size, 1.5)
        cover = self.smooth((near >= 0) & (distance < BODY), size)
        return np.where((cover > SURFACE) & (near >= 0), np.asarray(values, dtype=float)[near] if len(x) else np.nan, np.nan), cover
