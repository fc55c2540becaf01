"""Case files written by a program. A scene is drawn upright at the origin, then rotated and moved."""
import numpy as np

WATER, WEIGHT, G = 1000.0, 9810.0, 9.81  # kg/m3, N/m3, m/s2


def box(x0, y0, x1, y1):
    return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]], float)


def inside(polygon, points):
    """For each point, whether it lies in the polygon."""
    x, y = np.asarray(points, float).T
    result = np.zeros(len(x), bool)
    for (xa, ya), (xb, yb) in zip(polygon, np.roll(polygon, -1, axis=0)):
        if ya != yb:
            result ^= ((ya > y) != (yb > y)) & (x < xa + (y - ya) / (yb - ya) * (xb - xa))
    return result


class Scene:
    """angle: rotation of the whole drawing against the lattice of particles [rad]; gravity: further rotation of gravity against
    the drawing's y axis [rad]; place: position of the drawing's origin [m]; strength: of gravity [m/s2]; end: duration [s]."""

    def __init__(self, spacing, end, angle=0.0, place=(0.0, 0.0), gravity=0.0, strength=G, title=""):
        self.spacing, self.end, self.angle, self.title = spacing, end, angle, title
        c, s = (np.round(v, 15) + 0.0 for v in (np.cos(angle), np.sin(angle)))  # exact at right angles
        self.turn = np.array([[c, -s], [s, c]])
        self.place = np.asarray(place, float)
        self.local_up = np.array([-np.sin(gravity), np.cos(gravity)]) if gravity else np.array([0.0, 1.0])
        self.up = self.turn @ self.local_up
        self.strength = strength
        self.parts, self.model, self.gauge_interval, self.extra = [], "rigid", end / 50.0, {}

    def at(self, points):
        return (np.atleast_2d(points) @ self.turn.T + self.place).tolist()

    def head(self, value):
        """Converts a head above the drawing's origin to a head above the origin of coordinates [m]."""
        return float(value + self.up @ self.place)

    def add(self, part, **keys):
        self.parts.append((part, keys))

    def shape(self, points):
        """Keys of a polygon in a case file. An upright rectangle becomes a box where the drawing is not rotated."""
        points = np.asarray(points, float)
        lower, upper = points.min(0), points.max(0)
        corners = {tuple(p) for p in points.tolist()}
        box = {(x, y) for x in (lower[0], upper[0]) for y in (lower[1], upper[1])}
        if not self.angle and len(points) == 4 and corners == box:
            return {"min": self.at(lower)[0], "max": self.at(upper)[0]}
        return {"shape": "polygon", "points": self.at(points)}

    def soil(self, points, **keys):
        self.add("soil", **self.shape(points), **keys)

    def water(self, points):
        self.add("fluid.region", **self.shape(points))

    def wall(self, points, **keys):
        self.add("wall", points=self.at(points), **keys)

    def face(self, points, **keys):
        if "head" in keys:
            keys["head"] = self.head(keys["head"])
        self.add("water_face", points=self.at(points), **keys)

    def gauge(self, name, phase, kind, points=None, **keys):
        self.add("gauge", name=name, phase=phase, kind=kind, **({"points": self.at(points)} if points is not None else {}), **keys)

    def text(self):
        gravity = (-self.strength * self.up).tolist()
        lines = ["[case]", f"title = {toml(self.title)}", f"end_time = {toml(self.end)}", f"gravity = {toml(gravity)}"]
        for kind, keys in sorted(self.parts, key=lambda part: part[0] == "fluid.region"):
            if kind != "fluid.region":
                lines += [f"[[{kind}]]"] + [f"{key} = {toml(value)}" for key, value in keys.items()]
        if any(kind in ("fluid.region", "water_face") for kind, _ in self.parts):
            lines += ["[fluid]", f"particle_spacing = {toml(self.spacing)}"]
            for kind, keys in self.parts:
                if kind == "fluid.region":
                    lines += ["[[fluid.region]]"] + [f"{key} = {toml(value)}" for key, value in keys.items()]
        lines += ["[solid]", f'model = "{self.model}"']
        if self.model != "rigid":
            lines.append(f"particle_spacing = {toml(self.spacing)}")
        lines += ["[output]", f"gauge_interval = {toml(self.gauge_interval)}"]
        return "\n".join(lines) + "\n"


def toml(value):
    if isinstance(value, str):
        return '"' + value.replace('"', "'") + '"'
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(toml(v) for v in value) + "]"
    return repr(float(value))
