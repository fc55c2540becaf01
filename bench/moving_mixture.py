#!/usr/bin/python3
"""Runs saturated soil that moves as a mixture with its water: cases/saturated_block, shear_wave, sinking_disc and sliding_slope for several
conductivities k, spacings and exchange windows (time steps of the coupling). Compares each run with the exact value and with its dry twin (the soil
without water). Prints one table per case; with --out it also writes OUT/moving_mixture.csv.

Columns of the tables, by scene (t: time of the value):

    block  v/exact      speed of the block 0.1 m above the base at 0.2 s, over g sin(25 degrees) t, which is exact for any k
           v/exact_0.1  the same ratio at 0.1 s
           lowest       lowest value of this ratio from 0.05 s on; negative: the block has turned round
    shear  rms          error of the soil's mean velocity over the depth against the exact solution until 0.15 s, over the initial velocity v0
           rms/dry      rms over the rms of the dry twin at the same spacing
           mode_5       largest amplitude of the first mode in its fifth period, over the exact amplitude (dry: over the undamped amplitude)
           energy       largest rise of the energy of both phases above an earlier value, over the initial kinetic energy
    disc   a/exact      mean acceleration until 0.15 s over g (rho_sat - rho_w) / (rho_sat + C rho_w), with the added mass C = 1.047 in this tank
    slope  v/exact      speed of a frictional layer at mid-depth at 0.2 s, started with hydrostatic pressure, over g (sin(25 degrees) -
                        (gamma' / gamma_sat) cos(25 degrees) tan(20 degrees)) t, with the buoyant and the saturated unit weight gamma' and
                        gamma_sat (dry: without their quotient)
           v/exact_0.1  the same ratio at 0.1 s
           stress_min   lowest effective stress across the slope at mid-depth, over the initial stress; exact: 1
           stress_max   highest effective stress there, over the initial stress; exact: 1
    every  fastest      largest speed of any water particle [m/s]

Exact shear wave: the mode of wave number q = (m + 1/2) pi / H in the height H starts with the velocity 2 v0 / ((m + 1/2) pi). For the displacement X
and velocity U of the soil and the water's velocity W (primes: time derivatives; other symbols: docs/theory/symbols.md) it follows
X' = U, n_s rho_s U' = -G q^2 X - C (U - W), n rho_w W' = C (U - W), C = gamma_w n^2 / k. `--check` compares this with cases/shear_wave/reference.
"""
import argparse
import pathlib
import sys

import numpy as np
from plot import write_csv
from runs import PROGRAM, Run

HERE = pathlib.Path(__file__).resolve().parent
CASES = HERE.parent / "cases"
G, WEIGHT, WATER, GRAINS, POROSITY = 9.81, 9810.0, 1000.0, 2600.0, 0.4  # m/s2, N/m3, kg/m3, kg/m3, 1
HEIGHT, SHEAR, PUSH = 0.2, 3e6 / 2.6, 0.1  # of the shear wave: height [m], shear modulus [Pa], initial velocity [m/s]
ADDED_MASS = 1.047  # of a disc of 0.1 m radius in the middle of a tank of 1.2 m by 1.2 m, over the displaced water (sums of images)
HEIGHTS = np.arange(0.01, 0.2, 0.02)  # m, of the gauges `speed`


def modes(k, t, count):
    """Velocity of the soil [m/s] in the first `count` modes at the times t [s]: an array [mode, time]; k = inf: soil without water."""
    soil, water = (1.0 - POROSITY) * GRAINS, POROSITY * WATER
    drag = 0.0 if np.isinf(k) else WEIGHT * POROSITY**2 / k
    velocities = np.empty((count, len(t)))
    for m in range(count):
        q = (m + 0.5) * np.pi / HEIGHT
        start = 2.0 * PUSH / ((m + 0.5) * np.pi) * np.array([0.0, 1.0, 1.0])
        system = np.array([[0.0, 1.0, 0.0], [-SHEAR * q * q / soil, -drag / soil, drag / soil], [0.0, drag / water, -drag / water]])
        values, vectors = np.linalg.eig(system)
        share = np.linalg.solve(vectors, start.astype(complex))
        velocities[m] = (vectors[1] * share @ np.exp(values[:, None] * t)).real
    return velocities


def period(k):
    """Period of the first mode [s]. k = inf: that of the soil alone. Otherwise from the zeros of its velocity within 0.06 s; where there are too
    few, that of soil and water that move together."""
    soil = (1.0 - POROSITY) * GRAINS
    if np.isinf(k):
        return 4.0 * HEIGHT * np.sqrt(soil / SHEAR)
    t = np.linspace(0.0, 0.06, 60001)
    v = modes(k, t, 1)[0]
    down = np.flatnonzero((v[:-1] > 0.0) & (v[1:] <= 0.0))
    return t[down[1]] - t[down[0]] if len(down) > 1 else 4.0 * HEIGHT * np.sqrt((soil + POROSITY * WATER) / SHEAR)


def mean_velocity(k, t):
    """Mean velocity of the soil over its height [m/s] at the times t [s]."""
    return modes(k, t, 400).T @ (1.0 / ((np.arange(400) + 0.5) * np.pi))


def fifth(k):
    """The times between which the fifth period of the first mode lies [s], and the mode's largest exact velocity in this period [m/s]."""
    span = np.array([4.0, 5.0]) * period(k)
    return span, modes(k, np.linspace(*span, 2001), 1)[0].max()


def check():
    for k in (0.1, 1e-2, 1e-3, 1e-4, 1e-6):
        right = np.loadtxt(CASES / "shear_wave" / "reference" / f"mean_velocity_{k:g}.csv", delimiter=",", skiprows=2)
        off = np.abs(mean_velocity(k, right[:, 0]) - right[:, 1]).max()
        print(f"k = {k:g} m/s: mean velocity off by {off:.1e} m/s; period {1e3 * period(k):.3f} ms, "
              f"first mode in the fifth period {fifth(k)[1]:.5f} m/s of {4.0 * PUSH / np.pi:.5f}")


def at(run, gauge, t):
    times, values = run.gauges[gauge]
    return np.interp(t, times, values)


def fastest(run):
    return run.gauges["fastest"][1].max() if "fastest" in run.gauges else np.nan


def block(run, _k):
    slope = G * np.sin(np.radians(25.0))
    times, v = run.gauges["speed[1]"]
    late = times >= 0.05
    return {"v/exact": v[-1] / (slope * times[-1]), "v/exact_0.1": at(run, "speed[1]", 0.1) / (slope * 0.1),
            "lowest": (v[late] / (slope * times[late])).min()}


def shear(run, k):
    times, momentum = run.gauges["soil_x"]
    grid = np.arange(0.0, min(0.15, times[-1]) + 1e-9, 5e-4)
    mean = np.interp(grid, times, momentum) / (0.4 * HEIGHT * (1.0 - POROSITY) * GRAINS)
    span, right = fifth(k)
    times = run.gauges["speed[0]"][0]
    mode = sum(0.2 * np.sin(0.5 * np.pi * y / HEIGHT) * run.gauges[f"speed[{i}]"][1] for i, y in enumerate(HEIGHTS))
    late = (times >= span[0]) & (times <= span[1])
    energy = run.gauges["soil_energy"][1].copy()
    if "water_energy" in run.gauges:
        energy += at(run, "water_energy", run.gauges["soil_energy"][0])
    mass = (1.0 - POROSITY) * GRAINS + (POROSITY * WATER if "water_energy" in run.gauges else 0.0)
    return {"rms": np.sqrt(np.mean((mean - mean_velocity(k, grid)) ** 2)) / PUSH, "mode_5": mode[late].max() / right if late.any() else np.nan,
            "energy": (energy - np.minimum.accumulate(energy)).max() / (0.5 * mass * PUSH**2 * 0.4 * HEIGHT)}


def disc(run, _k):
    times, momentum = run.gauges["disc_y"]
    mass = (1.0 - POROSITY) * GRAINS * np.pi * 0.1**2  # kg/m, 49.0
    if "grains" in run.gauges:
        mass = GRAINS * run.gauges["grains"][1][0]
    saturated = (1.0 - POROSITY) * GRAINS + POROSITY * WATER
    right = G * (saturated - WATER) / (saturated + ADDED_MASS * WATER)
    return {"a/exact": -momentum[-1] / mass / times[-1] / right}


def slope(run, k):
    share = 1.0 if np.isinf(k) else 960.0 / 1960.0
    a = G * (np.sin(np.radians(25.0)) - share * np.cos(np.radians(25.0)) * np.tan(np.radians(20.0)))
    times, v = run.gauges["speed[1]"]
    stress = run.gauges["stress[1]"][1] / run.gauges["stress[1]"][1][0]
    return {"v/exact": v[-1] / (a * times[-1]), "v/exact_0.1": at(run, "speed[1]", 0.1) / (a * 0.1), "stress_min": stress.min(), "stress_max": stress.max()}


# For each scene: function that computes the columns, case, number of soils, end of the run [s], conductivities [m/s].
SCENES = {
    "block": (block, "saturated_block", 2, 0.2, [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7]),
    "shear": (shear, "shear_wave", 1, 0.17, [0.1, 1e-2, 1e-3, 1e-4, 1e-6]),
    "disc": (disc, "sinking_disc", 1, 0.15, [1e-2, 1e-3, 1e-5]),
    "slope": (slope, "sliding_slope", 1, 0.2, [1e-3, 1e-4, 1e-6]),
}


def one(a, scene, k, spacing, window):
    """Makes one run and returns its table row; k None: the dry twin."""
    judge, case, soils, end, _ = SCENES[scene]
    dry = k is None
    settings = [f"{'solid' if dry else 'fluid'}.particle_spacing={spacing}", "output.interval=0", *a.set]
    if not dry:
        settings += [f"soil.{i}.hydraulic_conductivity={k}" for i in range(soils)]
        settings += [f"coupling.interval={window}"] if window else []
    run = Run(CASES / case / ("dry.toml" if dry else "case.toml"), settings, a.program, a.longest, threads=a.threads)
    row = {"scene": scene, "k": k, "spacing_m": spacing, "window_s": window, "end_s": np.nan, "windows": int(run.counter("fluid", "windows") or 0),
           "wall_s": round(run.wall, 1), "exit": run.exit, "remark": run.reason.replace("\n", " ")[:160] if run.exit else ""}
    try:
        row["end_s"] = max(times[-1] for times, _ in run.gauges.values())
        row |= judge(run, np.inf if dry else k) | {"fastest": fastest(run)}
    except (KeyError, ValueError, IndexError):
        row["remark"] = row["remark"] or "too few readings"
    if row["end_s"] < 0.999 * end and not row["remark"]:
        row["remark"] = f"ended at {row['end_s']:.3g} s"
    return row


def table(scene, rows):
    dry = {row["spacing_m"]: row for row in rows if row["k"] is None}
    names = [name for name in rows[0] if name not in ("scene", "k", "spacing_m", "window_s", "end_s", "windows", "wall_s", "exit", "remark", "fastest")]
    if scene == "shear":
        for row in rows:
            base = dry.get(row["spacing_m"], {}).get("rms", np.nan)
            row["rms/dry"] = row.get("rms", np.nan) / base
        names.insert(1, "rms/dry")
    names.append("fastest")
    print(f"\n{scene:<6} {'k m/s':>8} {'spacing':>8} {'window s':>9}" + "".join(f"{name:>12}" for name in names) + f"{'windows':>9}{'wall s':>8}")
    for row in rows:
        k, window = ("dry" if row["k"] is None else f"{row['k']:g}"), ("" if row["k"] is None else f"{row['window_s']:g}" if row["window_s"] else "own")
        print(f"{scene:<6} {k:>8} {row['spacing_m']:>8g} {window:>9}" + "".join(f"{row.get(name, np.nan):>12.4g}" for name in names)
              + f"{row['windows']:>9}{row['wall_s']:>8.1f}" + (f"  exit {row['exit']}: {row['remark']}" if row["remark"] else ""))
    sys.stdout.flush()


def window(text):
    return None if text == "own" else float(text)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", nargs="+", choices=SCENES, default=list(SCENES))
    parser.add_argument("--spacings", type=float, nargs="+", default=[0.02], help="m (default 0.02)")
    parser.add_argument("--conductivities", type=float, nargs="+", help="m/s (default: those of each scene)")
    parser.add_argument("--windows", type=window, nargs="+", default=[None, 1e-3], help="longest exchange windows [s]; `own`: what the solvers propose "
                        "(default own 1e-3; the cases ask for own 1e-2 1e-3 1e-4 1e-5)")
    parser.add_argument("--build", type=pathlib.Path, help="build directory whose bin/poretwin runs (default build/release)")
    parser.add_argument("--threads", type=int, default=1, help="of each solver")
    parser.add_argument("--longest", type=float, default=300.0, help="s, of one run")
    parser.add_argument("--set", action="append", default=[], help="override a key of every run")
    parser.add_argument("--out", type=pathlib.Path, help="folder of moving_mixture.csv (default: none is written)")
    parser.add_argument("--check", action="store_true", help="only: the exact solution against the reference of the case")
    a = parser.parse_args()
    if a.check:
        return check()
    a.program = a.build.resolve() / "bin" / "poretwin" if a.build else PROGRAM
    everything = []
    for scene in a.scenes:
        rows = []
        for spacing in a.spacings:
            if (CASES / SCENES[scene][1] / "dry.toml").exists():
                rows.append(one(a, scene, None, spacing, None))
            rows += [one(a, scene, k, spacing, w) for k in a.conductivities or SCENES[scene][4] for w in a.windows]
        table(scene, rows)
        everything += rows
    if a.out:
        a.out.mkdir(parents=True, exist_ok=True)
        names = list(dict.fromkeys(name for row in everything for name in row))
        write_csv(a.out / "moving_mixture.csv", [{name: row.get(name, "") for name in names} for row in everything])


if __name__ == "__main__":
    main()
