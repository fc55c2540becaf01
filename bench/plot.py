"""What the benchmarks have in common: writing rows as CSV, drawing curves as PNG. Needs python3-matplotlib."""
import csv
import pathlib
import sys

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent / "cli"))  # after this folder: cli/ has a plot.py
import style  # noqa: E402
from style import plt  # noqa: E402

style.use(**{"savefig.dpi": 120})


def write_csv(path, rows):
    """Writes rows, dictionaries with the same keys, as CSV."""
    path = pathlib.Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    with open(path, "w", newline="") as stream:
        writer = csv.DictWriter(stream, fieldnames=list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)


def error_curves(path, title, rows, abscissae, error="error", label="scheme", bound=None):
    """Draws the error against each of `abscissae` (key of the rows: axis label), log-log, one curve for each value of
    `label`. bound: drawn as a line."""
    figure, panels = plt.subplots(1, len(abscissae), figsize=(4.5 * len(abscissae), 3.8), sharey=True, squeeze=False)
    for panel, (key, text) in zip(panels[0], abscissae.items()):
        for name in dict.fromkeys(row[label] for row in rows):
            points = sorted((row[key], row[error]) for row in rows if row[label] == name and row[error])
            if points:
                panel.loglog(*zip(*points), "o-", label=name)
        if bound:
            panel.axhline(bound, color="0.6", linestyle=":", label="bound")
        panel.set_xlabel(text)
        panel.grid(True, which="both")
        values = sorted({row[key] for row in rows if row[error]})
        if values and values[-1] < 10 * values[0]:  # too few decades for the labels of a logarithmic axis
            panel.set_xticks(values, [f"{value:.2g}" for value in values])
            panel.set_xticks([], minor=True)
    panels[0][0].set_ylabel("error")
    panels[0][0].legend()
    figure.suptitle(title)
    figure.tight_layout()
    style.save(figure, path)
