"""Pictures of particles as the bodies they fill: every place takes the colour of the particle nearest to it."""
import numpy as np


def spacing(x):
    """Distance between neighbours inside a body [m], from how many lie within a few of them; x: [n, 2 or 3]."""
    n, dimensions = x.shape
    if n < 2:
        return 1.0
    chosen = np.random.default_rng(0).choice(n, min(n, int(np.clip(4e6 / n, 20, 200))), replace=False)
    near = [np.sqrt(np.partition(((x - x[i]) ** 2).sum(axis=1), 1)[1]) for i in chosen]
    reach = 4.69 * float(np.median(near))  # a circle of as much room in a lattice as it holds points, 69
    if reach == 0.0:
        return 1.0
    volume = np.pi * reach**2 if dimensions == 2 else 4.0 / 3.0 * np.pi * reach**3
    count = np.array([np.count_nonzero(((x - x[i]) ** 2).sum(axis=1) <= reach**2) for i in chosen])
    own = (volume / count) ** (1.0 / dimensions)
    return float(np.quantile(own, 0.25))  # those near a surface have fewer


SURFACE = 0.7


class Canvas:
    """A grid of pixels over a part of the plane, fine enough for particles this far apart."""

    def __init__(self, lower, upper, dx):
        size = np.asarray(upper) - np.asarray(lower)
        self.pixel = float(np.clip(dx / 8.0, size.max() / 1800, size.max() / 600))
        self.lower = np.asarray(lower, dtype=float)
        self.shape = tuple(int(np.ceil(s / self.pixel)) for s in size[::-1])
        self.extent = (lower[0], lower[0] + self.shape[1] * self.pixel, lower[1], lower[1] + self.shape[0] * self.pixel)

    def nearest(self, x, values, size, reach):
        """Values of the particles nearest to each pixel [rows, columns], NaN where none is within `reach` times its size;
        x: [n, 2], size: [n] edges of the squares they stand for."""
        found = np.full(self.shape, np.nan)
        best = np.ones(self.shape)  # squared distance over squared reach
        far = reach * np.asarray(size) / self.pixel
        at = (x - self.lower) / self.pixel - 0.5
        home = np.rint(at).astype(int)
        most = int(np.ceil(far.max(initial=0.0)))
        for row in range(-most, most + 1):
            for column in range(-most, most + 1):
                place = home + (column, row)
                distance = ((place - at) ** 2).sum(axis=1) / far**2
                ok = (distance < 1.0) & (place >= 0).all(axis=1) & (place < self.shape[::-1]).all(axis=1)
                i, j, d, v = place[ok, 1], place[ok, 0], distance[ok], values[ok]
                nearer = d < best[i, j]
                best[i[nearer], j[nearer]] = d[nearer]
                found[i[nearer], j[nearer]] = v[nearer]
        return found

    def cover(self, x, size):
        """How far each pixel lies inside the body of these particles: 1 inside, 0 outside, SURFACE half a spacing from the last."""
        inside = np.isfinite(self.nearest(x, np.ones(len(x)), size, 0.75)).astype(float)  # half a diagonal, and a little
        width = max(1, int(round(0.35 * float(np.median(size)) / self.pixel)))
        box = np.ones(2 * width + 1) / (2 * width + 1)
        for axis in (0, 1, 0, 1):
            inside = np.apply_along_axis(lambda line: np.convolve(line, box, mode="same"), axis, inside)
        return inside

    def fill(self, x, values, size):
        """The same as `nearest`, without holes, in the body that the particles make; and its cover."""
        cover = self.cover(x, size)
        return np.where(cover > SURFACE, self.nearest(x, values, size, 1.5), np.nan), cover
