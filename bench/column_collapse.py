#!/usr/bin/env python3
"""Error against run time of a collapsing column: the default and a paper-like preset.

One command: bench/column_collapse.py [--bin build/release/bin] [--out bench/results/column_collapse] [--spacings 0.01 0.005 0.0025]
Writes column_collapse.csv and .png. Error: run-out at a thickness of l_i/20 against Lube's law, and against the finest default run.
"""
import argparse
import csv
import json
import pathlib
import subprocess

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

GATE, LAW, BULK_WEIGHT = 0.1, 0.12, 2650 * 9.81 * 0.1  # m, m, Pa
PRESETS = {
    "default": [],
    # CFL 0.2, alpha = 1 as in the paper, nothing that keeps the flow regular.
    "paper-like": ["solid.courant=0.2", "solid.artificial_viscosity=1", "solid.regular_flow=false"],
}


def run(programs, case, spacing, settings, out):
    command = [str(programs / "poretwin"), "run", str(case), "--out", str(out), "--quiet", "--no-pictures"]
    for setting in [f"solid.particle_spacing={spacing}", *settings]:
        command += ["--set", setting]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    summary = json.loads((out / "solid.summary.json").read_text())
    last = {}
    with open(out / "gauges.csv", newline="") as file:
        for row in csv.DictReader(file):
            last[row["gauge"]] = float(row["value"])
    return {"cpu_s": summary["cpu_s"], "substeps": summary["counters"]["substeps"], **last}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bin", type=pathlib.Path, default="build/release/bin")
    parser.add_argument("--case", type=pathlib.Path, default="cases/column_collapse/case.toml")
    parser.add_argument("--out", type=pathlib.Path, default="bench/results/column_collapse")
    parser.add_argument("--spacings", type=float, nargs="+", default=[0.01, 0.005, 0.0025], help="m, coarse to fine")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    rows = []
    for preset, settings in PRESETS.items():
        for spacing in arguments.spacings:
            found = run(arguments.bin, arguments.case, spacing, settings, arguments.out / f"{preset}_{spacing}")
            rows.append({"preset": preset, "spacing_m": spacing, "cpu_s": found["cpu_s"], "substeps": found["substeps"],
                         "front_m": found["front"], "tip_m": found["tip"], "law_m": LAW,
                         "front_error": abs(found["front"] - LAW) / LAW, "noise": found["noise"] / BULK_WEIGHT,
                         "density_error": found["density"]})
            print(f"{preset:12} l_i/{GATE / spacing:.0f}: {found['cpu_s']:.1f} s, front {found['front']:.4f} m", flush=True)
    finest = [r for r in rows if r["preset"] == "default"][-1]["front_m"]
    for row in rows:
        row["front_from_finest"] = abs(row["front_m"] - finest) / finest
    with open(arguments.out / "column_collapse.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys())
        writer.writeheader()
        writer.writerows(rows)
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.6))
    for preset in PRESETS:
        mine = [r for r in rows if r["preset"] == preset]
        axes[0].loglog([r["cpu_s"] for r in mine], [max(r["front_error"], 1e-3) for r in mine], "o-", label=preset)
        axes[1].loglog([r["cpu_s"] for r in mine], [r["noise"] for r in mine], "o-", label=preset)
    axes[0].set_ylabel("error of the run-out against Lube's law")
    axes[1].set_ylabel("stress noise / (rho g H)")
    for axis in axes:
        axis.set_xlabel("CPU time [s]")
        axis.grid(alpha=0.3, which="both")
        axis.legend()
    figure.tight_layout()
    figure.savefig(arguments.out / "column_collapse.png", dpi=120)


if __name__ == "__main__":
    main()
