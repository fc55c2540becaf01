#!/usr/bin/python3
"""Runs cases/terzaghi for permeabilities k of 1e-2 .. 1e-6 m/s and exchange windows (time steps of the coupling) of 1e-5 .. 1 s,
and compares each run with an exact solution. Writes OUT/consolidation.csv; OUT is the folder of --out.

Errors are the largest errors of the degree of consolidation (error_U) and of the base pressure over the load (error_p), from
Terzaghi's dimensionless time Tv = 0.1 on. Where a run to Tv = 0.2 would take more than --windows windows, they are those of the
second half of --windows windows. Bounds of the errors: 0.01 with windows shorter than 0.005 in Tv, 0.03 with windows shorter than
0.025, 1 with longer windows (such runs only have to stay bounded).

The reference is Terzaghi's series with the inertia of both phases, which dominates at k = 1e-2 m/s. Over an impermeable base the
water fills the volume that the grains leave, n v_w = -n_s v_s, and the two momentum equations become one. For the displacement u
and the pore pressure p along z (subscripts t and z: derivatives; other symbols: docs/theory/symbols.md):

    m u_tt + (gamma_w / k) u_t = M u_zz,    m = n_s rho_s + rho_w n_s^2 / n,
    p_z = rho_w (n_s / n) u_tt + (gamma_w / k) u_t.

At k = 1e-2 m/s the exact base pressure jumps by 0.17 of the load when the front of the wave arrives. In a scheme with a front of
finite width the largest error is therefore at least half of 0.17. `--check` compares the series with a solution of the original
equations (both momentum equations and continuity) by finite differences.
"""
import argparse
import pathlib
import sys

import numpy as np
from plot import write_csv
from runs import PROGRAM, Run

HEIGHT, MODULUS, WEIGHT, LOAD = 0.4, 3e6 * 0.7 / (1.3 * 0.4), 9810.0, 1e3  # m, constrained modulus [Pa], unit weight of water [N/m3], Pa
POROSITY, GRAINS, WATER = 0.4, 2600.0, 1000.0  # 1, densities [kg/m3]
CONDUCTIVITIES = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6]
WINDOWS = [1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0]


def reference(k, t):
    """Degree of consolidation, and base pressure over the load, at the times t [s], for the conductivity k [m/s]."""
    kappa = (np.pi / HEIGHT * (np.arange(2000) + 0.5))[:, None]
    start = 2.0 * LOAD / (MODULUS * HEIGHT * kappa**2) * (-1.0) ** np.arange(2000)[:, None]  # LOAD z / M as a series of sin(kappa z)
    mass, drag = (1.0 - POROSITY) * GRAINS + WATER * (1.0 - POROSITY) ** 2 / POROSITY, WEIGHT / k
    t = np.asarray(t)[None, :]
    # Roots of m s^2 + drag s + M kappa^2 = 0; the smaller one is computed without cancellation.
    root = np.sqrt(drag**2 - 4.0 * mass * MODULUS * kappa**2 + 0j)
    fast = -(drag + root) / (2.0 * mass)
    slow = MODULUS * kappa**2 / (mass * fast)
    share = fast / (fast - slow)
    a = [start * (share * slow**n * np.exp(slow * t) + (1.0 - share) * fast**n * np.exp(fast * t)).real for n in range(3)]
    top = np.sin(kappa * HEIGHT)
    consolidation = 1.0 - np.sum(a[0] * top, axis=0) * MODULUS / (LOAD * HEIGHT)
    pressure = -np.sum((WATER * (1.0 - POROSITY) / POROSITY * a[2] + drag * a[1]) / kappa, axis=0)
    return consolidation, pressure / LOAD


def two_phases(k, rows, step, end):
    """Solution by finite differences, independent of the series: velocities of grains and water are at the nodes of a staggered
    grid, pressure and stress between them; time steps [s] by backward Euler. Returns times [s], degree of consolidation, base
    pressure over the load."""
    h, grains, drag = HEIGHT / rows, 1.0 - POROSITY, WEIGHT * POROSITY**2 / k
    width = np.diag(np.r_[np.full(rows - 1, h), 0.5 * h])  # the lowest node, at rest on the base, is left out
    fall = np.eye(rows, k=1) - np.eye(rows)  # differences of values between the nodes; zero above the top
    stiffness = MODULUS / h * fall @ fall.T  # minus the matrix that gives the forces of displacements
    zero = np.zeros((rows, rows))
    system = np.block([
        [width * (grains * GRAINS / step + drag) + step * stiffness, -drag * width, grains * fall],
        [-drag * width, width * (POROSITY * WATER / step + drag), POROSITY * fall],
        [grains * fall.T, POROSITY * fall.T, zero],
    ])
    inverse = np.linalg.inv(system)
    u, v, w, load = np.zeros(rows), np.zeros(rows), np.zeros(rows), np.r_[np.zeros(rows - 1), -LOAD]
    t, history = step * np.arange(1, round(end / step) + 1), []
    for _ in t:
        rest = np.r_[width @ v * (grains * GRAINS / step) - stiffness @ u + load, width @ w * (POROSITY * WATER / step), np.zeros(rows)]
        v, w, p = np.split(inverse @ rest, 3)
        u = u + step * v
        history.append((-u[-1] * MODULUS / (LOAD * HEIGHT), p[0] / LOAD))
    return t, *np.array(history).T


def check():
    """Prints the largest differences between the series and two_phases(), from Tv = 0.1 on or, in short runs, over the second half.
    For the pressure it also prints the largest difference outside 1 ms before and after the front's arrival."""
    for k, end in ((1e-2, 0.04), (1e-6, 0.02)):
        unit = HEIGHT**2 * WEIGHT / (k * MODULUS)
        speed = np.sqrt(MODULUS / ((1.0 - POROSITY) * GRAINS + WATER * (1.0 - POROSITY) ** 2 / POROSITY))
        for rows in (20, 40, 80):
            t, consolidation, pressure = two_phases(k, rows, 2e-4 / rows, end)
            late = t >= (0.1 * unit if end > 0.2 * unit else 0.5 * end)
            off_u, off_p = (np.abs(mine - right)[late] for mine, right in zip((consolidation, pressure), reference(k, t)))
            away = np.abs(t[late] - HEIGHT / speed) > 1e-3
            print(f"k = {k:g} m/s, {rows} rows: consolidation {off_u.max():.4f}, base pressure {off_p.max():.4f} at {1e3 * t[late][off_p.argmax()]:.2f} ms, "
                  f"{off_p[away].max():.4f} beyond 1 ms", flush=True)


def write_references(folder):
    """Writes the reference curves of verify.toml, one per permeability and gauge: some 60 points per decade of time."""
    for k in CONDUCTIVITIES:
        unit = HEIGHT**2 * WEIGHT / (k * MODULUS)
        t = np.geomspace(1e-5 * unit, 1.2 * unit, 300)
        t = t[t > 1e-4]
        for name, values, what in zip(("consolidation", "base_pressure"), reference(k, t), ("degree of consolidation", "base pressure over the load")):
            rows = "".join(f"{x:.6g},{y:.6g}\n" for x, y in zip(t, values))
            head = f"# {what}, k = {k:g} m/s: Terzaghi (1943) with the inertia of both phases, by bench/consolidation.py --references\n"
            (folder / f"{name}_{k:g}.csv").write_text(head + "time_s,value\n" + rows)


def promise(step):
    return 0.01 if step <= 0.005 else 0.03 if step <= 0.025 else 1.0


def one(a, k, window):
    unit = HEIGHT**2 * WEIGHT / (k * MODULUS)  # s, at which Tv = 1
    whole = 1.2 * unit
    count = min(max(whole / window, 10), a.windows)
    end = count * window
    settings = [f"soil.0.hydraulic_conductivity={k}", f"coupling.interval={window}", f"case.end_time={end:.12g}", "output.interval=0",
                f"fluid.particle_spacing={a.spacing}", f"solid.particle_spacing={a.spacing}", *a.set]
    run = Run(a.case, settings, a.program, a.longest)
    row = {"k": k, "window_s": window, "step_in_Tv": window / unit, "windows": int(run.counter("coupler", "end_time_s") / window + 0.5),
           "Tv_end": end / unit, "error_U": np.nan, "error_p": np.nan, "promise": promise(window / unit), "exit": run.exit,
           "relaxed": int(run.counter("solid", "windows relaxed")), "cpu_s": round(run.cpu, 2), "verdict": ""}
    if run.exit == 0:
        (t, s), (tp, p) = run.gauges["settlement"], run.gauges["base_pressure"]
        final = LOAD * HEIGHT / MODULUS
        first = 0.1 * unit if end > 0.2 * unit else 0.5 * end
        late, late_p = t >= first, tp >= first
        row["error_U"] = np.abs(-s[late] / final - reference(k, t[late])[0]).max()
        row["error_p"] = np.abs(p[late_p] / LOAD - reference(k, tp[late_p])[1]).max()
        worst = max(row["error_U"], row["error_p"])
        row["verdict"] = "" if worst <= row["promise"] else "missed"
    else:
        row["verdict"] = run.reason.replace("\n", " ")[:200]
    return row


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=PROGRAM)
    parser.add_argument("--case", default="terzaghi")
    parser.add_argument("--spacing", type=float, default=0.01, help="m")
    parser.add_argument("--conductivities", type=float, nargs="+", default=CONDUCTIVITIES)
    parser.add_argument("--window", type=float, nargs="+", default=WINDOWS)
    parser.add_argument("--windows", type=int, default=2000, help="at most, of one run")
    parser.add_argument("--longest", type=float, default=600.0, help="s, of one run")
    parser.add_argument("--set", action="append", default=[], help="override a key of every run")
    parser.add_argument("--check", action="store_true", help="hold the series against finite differences of both phases and stop")
    parser.add_argument("--references", type=pathlib.Path, help="write the curves of the range there and stop")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("bench-results"))
    a = parser.parse_args()
    if a.references:
        return write_references(a.references)
    if a.check:
        return check()
    rows = []
    for k in a.conductivities:
        for window in a.window:
            rows.append(one(a, k, window))
            print(" ".join(f"{key}={value:.3g}" if isinstance(value, float) else f"{key}={value}" for key, value in rows[-1].items()), flush=True)
            write_csv(a.out / "consolidation.csv", rows)
    missed = sum(row["verdict"] != "" for row in rows)
    print(f"{len(rows) - missed} of {len(rows)} keep the promise")
    sys.exit(missed > 0)


if __name__ == "__main__":
    main()
