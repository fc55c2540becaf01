"""The style of poretwin's figures and the function that writes them; `plot`, reports and benchmarks use them.

Needs the Debian package python3-matplotlib.
"""
import pathlib

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the backend is chosen)

FORMATS = ("png", "svg", "pdf")
# Widths [inches] of figures: of a journal's page (180 mm), and of three quarters of it. Figures are printed at the size at which
# they are drawn.
PAGE, COLUMN = 7.1, 5.3
PRINT_DPI = 300  # resolution of particles inside vector figures; journals require it of colour pictures
STYLE = {
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.linewidth": 0.8,
    "axes.grid": False,
    "grid.alpha": 0.3,
    "grid.linewidth": 0.5,
    "legend.frameon": False,
    "legend.fontsize": 8,
    "lines.linewidth": 1.4,
    "lines.markersize": 4,
    "mathtext.fontset": "dejavusans",
    # Colours of Okabe & Ito (2008), distinguishable with colour blindness, too; without their yellow, which is too pale on paper.
    "axes.prop_cycle": matplotlib.cycler(color=["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000"]),
    "figure.dpi": 100,
    "savefig.dpi": 200,
    "savefig.bbox": "tight",
    "savefig.pad_inches": 0.04,
    "pdf.fonttype": 42,  # fonts as TrueType: journals refuse Type 3
    "svg.hashsalt": "poretwin",  # the same figure always has the same bytes
}
REFERENCE = {"linestyle": "none", "marker": "o", "mfc": "white", "zorder": 3}  # style of reference points or curves
AROUND = {"fluid": "#d8d5cf", "solid": "#d3e5f3"}  # colour behind the water (soil) and behind the soil (water)
WATER_LINE = "#2b7bba"
BODY = {"fluid": "water", "solid": "soil"}  # name of a phase above a picture

# For each field: name, and symbol as in docs/theory/symbols.md and the paper.
FLUID = {
    "pore_pressure": ("pore pressure", "p_w"),
    "velocity": ("velocity of the water", r"\mathbf{v}_w"),
    "relative_flux": ("discharge through the soil", r"n_w(\mathbf{v}_w-\mathbf{v}_s)"),
    "void_fraction": ("void fraction", "n_w"),
    "pressure_head": ("pressure head", r"\psi"),
    "degree_of_saturation": ("degree of saturation", "S_r"),
    "water_content": ("water content", r"\theta"),
}
SOLID = {
    "pore_pressure": ("pore pressure", "p_w"),
    "velocity": ("velocity of the soil", r"\mathbf{v}_s"),
    "displacement": ("displacement", r"\mathbf{u}"),
    "effective_stress": ("effective stress", r"\sigma'"),
    "total_stress": ("total stress", r"\sigma"),
    "accumulated_plastic_strain": ("plastic strain", r"\bar{\varepsilon}_p"),
    "failing_strain": ("plastic strain in failing", ""),
    "local_factor_of_safety": ("local factor of safety", ""),
    "failing_displacement": ("displacement in failing", ""),
    "water_force": ("force of the water on the soil", ""),
    "wall_slip": ("slip along walls", ""),
    "coverage": ("coverage by water", ""),
    "degree_of_saturation": ("degree of saturation", "S_r"),
    "void_fraction": ("void fraction", "n_w"),
    "mobilised_friction": ("mobilised friction", r"\varphi_m"),
    "pore_pressure_ratio": ("pore pressure ratio", "r_u"),
}
UNITS = {"degrees": "°", "m/s2": "m/s²", "m2": "m²", "m3": "m³", "m2/s": "m²/s", "m3/s": "m³/s", "kg/m3": "kg/m³"}
# Perceptually uniform colour maps. MAPS: for the fields named there, dark where soil yields or is wet; MAP: for every other field; SIGNED_MAP: for
# fields with values of both signs, white at zero.
MAPS = {"accumulated_plastic_strain": "magma_r", "failing_strain": "magma_r", "local_factor_of_safety": "magma", "degree_of_saturation": "cividis_r"}
MAP, SIGNED_MAP = "viridis", "RdBu_r"


def use(**more):
    plt.rcParams.update(STYLE | more)


def label(phase, field, component=""):
    """Label of a field for a colour bar, without the unit. component: "xx" and the like; "| |": the length of a vector; "": the field itself."""
    words, symbol = (FLUID if phase == "fluid" else SOLID).get(field, (field.replace("_", " "), ""))
    if component == "| |":
        words, symbol = words.replace("velocity", "speed"), symbol and rf"|{symbol}|"
    elif component:
        if not symbol:
            words += f" {component}"
        stem, _, below = symbol.replace(r"\mathbf", "").replace("{v}", "v").replace("{u}", "u").partition("_")
        symbol = symbol and rf"{stem}_{{{below + ',' if below else ''}{component}}}"
    return f"{words} ${symbol}$" if symbol else words


def unit(text):
    """A unit in brackets; empty for a pure number."""
    return f" [{UNITS.get(text, text)}]" if text not in ("", "1") else ""


def prefix(value, of):
    """Factor and unit with prefix (kPa, mm) that make numbers short: value / factor is the number in that unit."""
    if of not in ("Pa", "m", "m/s", "N"):
        return 1.0, of
    for factor, sign in ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ")):
        if value >= factor:
            return factor, sign + of
    return 1.0, of


def number(value):
    """A number with four digits; without a power of ten at common sizes: 15000, 0.35."""
    return f"{float(f'{value:.4g}'):g}"


# Units of time: duration [s] of the shortest run for which the unit is used, length of the unit [s], its name.
TIMES = [(3.0 * 365.25 * 86400.0, 365.25 * 86400.0, "years"), (2.0 * 86400.0, 86400.0, "days"), (2e4, 3600.0, "h"), (0.0, 1.0, "s")]


def time_unit(span):
    """Length [s] and name of the unit that suits a span of time [s]."""
    return next((unit, name) for least, unit, name in TIMES if span >= least)


def time(value, unit=None):
    """A time [s] with its unit."""
    length, name = unit or time_unit(abs(value))
    return f"{number(value / length)} {name}"


def save(figure, path):
    """Writes a figure in the format given by its name's ending; the same figure always gives the same bytes."""
    path = pathlib.Path(path)
    kind = path.suffix[1:]
    undated = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(kind)
    figure.savefig(path, metadata=undated, **({} if kind == "png" else {"dpi": PRINT_DPI}))
    plt.close(figure)
    return path
