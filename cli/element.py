#!/usr/bin/python3
"""Draws a laboratory test on a soil: stress and volume against strain, and the stress path.

Called by `poretwin element`; needs the Debian packages python3-numpy and python3-matplotlib.
"""
import argparse
import pathlib

import numpy as np
import style
from style import plt


def draw(table, test, target):
    """Draws four panels into `target`: stress against strain; the path of the mean effective pressure p and the deviator q; volumetric
    strain (undrained: excess pore pressure) against strain; void ratio against p."""
    shears = test.startswith("simple_shear")
    strain = table["shear_strain" if shears else "axial_strain"]
    stress = table["stress_xy_Pa" if shears else "q_Pa"]
    factor, unit = style.prefix(max(np.abs(stress).max(), table["p_Pa"].max()), "Pa")
    figure, axes = plt.subplots(2, 2, figsize=(style.PAGE, 0.75 * style.PAGE), layout="constrained")
    strain_label = r"shear strain $\gamma_{xy}$" if shears else "axial strain"
    pressure_label = rf"mean effective pressure $p'$ [{unit}]"
    panels = [(strain, stress / factor, strain_label, rf"shear stress $\tau_{{xy}}$ [{unit}]" if shears else f"deviator $q$ [{unit}]"),
              (table["p_Pa"] / factor, table["q_Pa"] / factor, pressure_label, f"deviator $q$ [{unit}]")]
    if test.endswith("undrained"):
        panels.append((strain, table["excess_pore_pressure_Pa"] / factor, strain_label, f"excess pore pressure [{unit}]"))
    else:
        panels.append((strain, table["volumetric_strain"], strain_label, "volumetric strain (compression positive)"))
    panels.append((table["p_Pa"] / factor, table["void_ratio"], pressure_label, "void ratio $e$"))
    for panel, (x, y, x_label, y_label) in zip(axes.flat, panels):
        panel.plot(x, y)
        panel.set_xlabel(x_label)
        panel.set_ylabel(y_label)
        panel.grid(True)
    if table["p_Pa"].min() > 0.0:
        axes.flat[3].set_xscale("log")
    style.save(figure, target)
    print(target)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("table", type=pathlib.Path)
    parser.add_argument("--test", required=True)
    options = parser.parse_args()
    style.use()
    draw(np.genfromtxt(options.table, delimiter=",", names=True), options.test, options.table.with_suffix(".png"))


if __name__ == "__main__":
    main()
