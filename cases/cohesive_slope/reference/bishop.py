#!/usr/bin/python3
"""Factor of safety of the slope by Bishop's simplified method of slices: the lowest over all circles through the soil.

Usage: bishop.py            the dry slope and the same slope under water (buoyant weight)
"""
import math

HEIGHT, RUN, CREST = 10.0, 20.0, 12.0  # m: height, horizontal length of the slope, of the crest
COHESION, FRICTION = 10e3, math.radians(20.0)


def ground(x):
    return HEIGHT if x <= CREST else max(0.0, HEIGHT - (x - CREST) * HEIGHT / RUN)


def bishop(xc, yc, r, weight, slices=60):
    """None where the circle does not cut a sensible body out of the soil above the firm base."""
    if yc - r < 0.0:  # below the base: not in this soil
        return None
    # Ends: where the circle meets the ground.
    xs = [xc - r + 2.0 * r * k / 2000 for k in range(2001)]
    inside = [x for x in xs if 0.0 < x < CREST + RUN and yc - math.sqrt(max(0.0, r * r - (x - xc) ** 2)) < ground(x)]
    if len(inside) < 20 or inside[0] >= CREST or inside[0] <= 0.05:
        return None
    a, b = inside[0], inside[-1]
    width = (b - a) / slices
    parts = []
    for k in range(slices):
        x = a + (k + 0.5) * width
        bottom = yc - math.sqrt(r * r - (x - xc) ** 2)
        height = ground(x) - bottom
        if height <= 0.0:
            continue
        parts.append((weight * height * width, math.asin((xc - x) / r)))
    driving = sum(w * math.sin(angle) for w, angle in parts)
    if driving <= 0.0:
        return None
    f = 1.3
    for _ in range(100):
        resisting = sum((COHESION * width + w * math.tan(FRICTION)) /
                        (math.cos(angle) + math.sin(angle) * math.tan(FRICTION) / f) for w, angle in parts)
        new = resisting / driving
        if abs(new - f) < 1e-6:
            break
        f = new
    return f


def lowest(weight):
    best, at = math.inf, None
    centre, reach, step = (25.0, 22.0), 20.0, 2.0
    while step > 0.1:
        n = round(reach / step)
        for i in range(-n, n + 1):
            for j in range(-n, n + 1):
                xc, yc = centre[0] + i * step, centre[1] + j * step
                if yc <= HEIGHT:
                    continue
                toe = math.hypot(CREST + RUN - xc, yc)
                for share in (1.0, 0.99, 0.97, 0.94):
                    f = bishop(xc, yc, share * min(toe, yc), weight, 30) if share * toe > yc else bishop(
                        xc, yc, share * toe, weight, 30)
                    if f and f < best:
                        best, at = f, (xc, yc, share)
        centre, reach, step = at[:2], 2.0 * step, 0.4 * step
    return best, at


if __name__ == "__main__":
    for name, weight in (("dry", 20e3), ("under water", 0.7 * 1912.48 * 9.81)):
        f, circle = lowest(weight)
        print(f"{name}: gamma = {weight / 1e3:.2f} kN/m3, F = {f:.3f}, centre ({circle[0]:.1f}, {circle[1]:.1f}) m")
