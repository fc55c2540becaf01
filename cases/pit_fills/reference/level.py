"""Level of the pit in time, and what has run over: writes level.csv and prints the spilled volume.

Two layers of thickness D and length L, with the head H at their far ends, lead to a pit in which water stands at h. The discharge of
one layer is exact at every level: below the roof k (H D - D^2 / 2 - h^2 / 2) / L (Charny's integral over the height, with the part of
the flow that is full up to the roof), above it k D (H - h) / L. While the level is below the roof, pores above the water table beside
the pit fill again; their volume is estimated with Dupuit's parabola.
"""

K, D, L, H, POROSITY, AREA, SPILL = 1e-4, 1.0, 4.0, 3.0, 0.05, 4.0, 1.5
STOP, RAIN_FROM, RAIN, END = 20000.5, 50000.5, 1e-5, 1.2e5


def discharge(h):
    """Of both layers into the pit [m2/s]."""
    return 2.0 * K * ((H * D - 0.5 * D * D - 0.5 * h * h) if h < D else D * (H - h)) / L


def dry(h):
    """Volume of the pores above the water table in both layers [m2]: between the roof and a parabola of the depth squared."""
    if h >= D:
        return 0.0
    per_width = 0.5 * discharge(h)
    length = K * (D * D - h * h) / (2.0 * per_width)
    return 2.0 * POROSITY * length * (D - 2.0 / 3.0 * (D**3 - h**3) / (D * D - h * h))


def store(h):
    """Change of the pit's water and of the pores' water per change of the level [m]."""
    step = 1e-6
    return AREA - (dry(h + step) - dry(h)) / step


def main():
    dt, h, spilled, time = 1.0, 0.0, 0.0, STOP
    rows = ["t_s,level_m", "0,0", f"{STOP:g},0"]
    while time < END:
        step = min(dt, END - time)

        def rate(level, at):
            rain = RAIN * AREA if at >= RAIN_FROM else 0.0
            return (discharge(level) + rain) / store(level)

        middle = h + 0.5 * step * rate(h, time)
        now = h + step * rate(middle, time + 0.5 * step)
        spilled += AREA * max(0.0, now - SPILL)
        h = min(now, SPILL)
        time += step
        if abs(time % 1000.0) < 0.6 or time == END:
            rows.append(f"{time:g},{h:.6f}")
    with open("level.csv", "w", encoding="utf-8") as file:
        file.write("\n".join(rows) + "\n")
    print(f"steady inflow of the dry pit {discharge(0.0):.6g} m2/s, spilled {spilled:.5f} m2")


if __name__ == "__main__":
    main()
