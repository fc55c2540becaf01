"""Bishop's simplified method of slices (Bishop 1955), for the references of cases: factor of safety of one slip circle, and a search over
circles."""
import numpy as np
from scipy.interpolate import LinearNDInterpolator, NearestNDInterpolator
from scipy.optimize import minimize
from scipy.spatial import cKDTree


def factor(vertical, cohesion, friction, sine, driving):
    """Factor of safety of one circle. Arrays over the slices: vertical [N/m]: weight less the force of the pore pressure on the base, not below
    zero, since a base carries no tension; cohesion [N/m]: cohesion times the width; friction: tan(phi) with the angle of friction phi; sine: of
    the inclination of the base. driving [N/m]: moment of the weight about the centre, over the radius."""
    cosine = np.sqrt(1.0 - sine**2)
    f = 1.5
    for _ in range(100):
        new = ((cohesion + vertical * friction) / (cosine + sine * friction / f)).sum() / driving
        if abs(new - f) < 1e-7:
            break
        f = new
    return f


def base_of(xc, yc, radius, x):
    """Elevation [m] of the lower half of the circle about (xc, yc) at x."""
    return yc - np.sqrt(np.maximum(radius**2 - (x - xc) ** 2, 0.0))


def lowest(value, tried, **options):
    """The lowest value(v) and its v, by the simplex method of Nelder and Mead, started from the best five of the vectors `tried`. Infinite values
    count as large. options: of Nelder-Mead."""
    def of(v):
        found = value(v)
        return found if np.isfinite(found) else 1e9
    best = sorted(((of(v), v) for v in tried), key=lambda t: t[0])[:5]
    found = min((minimize(of, v, method="Nelder-Mead", options=options) for _, v in best), key=lambda f: f.fun)
    return found.fun, found.x


def lowest_between(top, length, ends, sagittas, of_circle):
    """Lowest of_circle(centre, radius) over circles. A circle is given by the x of its ends on the ground, (upper, lower) [m], and its sagitta [m].
    The ground, top(x), falls to the right and ends at x = length."""
    def value(v):
        upper, lower, sag = v
        if not (0.0 < sag and 0.0 < upper < lower < length):
            return np.inf
        p, q = np.array([upper, top(upper)]), np.array([lower, top(lower)])
        chord = np.linalg.norm(q - p)
        radius = (chord**2 / 4.0 + sag**2) / (2.0 * sag)
        normal = np.array([p[1] - q[1], q[0] - p[0]]) / chord  # up and to the right
        return of_circle(0.5 * (p + q) + (radius - sag) * normal, radius)
    return lowest(value, [(u, l, s) for u, l in ends for s in sagittas], xatol=1e-2, fatol=1e-4)[0]


def read_frame(root, step):
    """Points [m], pore pressure [Pa] and degree of saturation of pore water as a field, from frame `step` of a VTKHDF file."""
    first, count = int(root["Steps/PointOffsets"][step]), int(root["NumberOfPoints"][step])
    rows = slice(first, first + count)
    pressure, saturation = (root["PointData"][name][rows].astype(float) for name in ("pore_pressure", "degree_of_saturation"))
    return root["Points"][rows][:, :2].astype(float), pressure, saturation


class PoreWater:
    """Pore water at any point of a dam from a frame of read_frame(): pressure and saturation are linear between the points. Beyond the outermost points,
    which lie half a spacing inside the soil, the pressure continues with its slope there; the saturation is that of the nearest point."""

    def __init__(self, x, pressure, saturation):
        self.x, self.values = x, np.stack([pressure, saturation], axis=1)
        self.linear, self.near = LinearNDInterpolator(x, self.values), NearestNDInterpolator(x, np.arange(len(x)))
        around = cKDTree(x).query(x, 9)[1][:, 1:]  # slope by least squares over the eight nearest points
        self.slope = np.array([np.linalg.lstsq(x[n] - x[i], pressure[n] - pressure[i], rcond=None)[0] for i, n in enumerate(around)])

    def at(self, x, y):
        """Pressure [Pa] and saturation."""
        points = np.stack([x, y], axis=-1)
        found = self.linear(points)
        lost = np.isnan(found[..., 0])
        nearest = self.near(points[lost]).astype(int)
        found[lost] = self.values[nearest]
        found[lost, 0] += (self.slope[nearest] * (points[lost] - self.x[nearest])).sum(axis=-1)
        return found[..., 0], found[..., 1]


def acting(pressure, saturation, residual):
    """The pressure [Pa] that acts on the skeleton: as it is below the water table, above it times the effective saturation (Bishop's stress with
    chi = S_e). residual: residual saturation."""
    return np.where(pressure < 0.0, np.clip((saturation - residual) / (1.0 - residual), 0.0, 1.0) * pressure, pressure)
