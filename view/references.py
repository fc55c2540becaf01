"""Reference values for the gauges of a run, from the verify.toml of its case (cli/metrics.cpp, `marks`).

A run of a case is compared with the references of a [[run]] of verify.toml that has the same settings, except those that change
the cost but not the problem: end, spacing, windows, output.
"""
import pathlib
import re
import tomllib

EFFORT = re.compile(r"(case\.end_time|fluid\.particle_spacing|solid\.particle_spacing|coupling\..*|output\..*)\s*=")


def settings(assignments, effort=True):
    return sorted(re.sub(r"\s*=\s*", "=", text) for text in assignments if effort or not EFFORT.match(text))


def rows_of(path):
    """Rows of numbers of a CSV file, without comments and heading."""
    rows = []
    for line in path.read_text().splitlines():
        try:
            rows.append([float(cell) for cell in line.split(",")])
        except ValueError:
            continue
    return rows


def case_folder(record, roots):
    """The folder of the run's case, if it is below one of `roots`: a run.toml must not choose other files to read."""
    file = pathlib.Path(str(record.get("case_file", "")))
    if not file.is_absolute() or not file.is_file():
        return None
    folder = file.resolve().parent
    return folder if any(folder.is_relative_to(root) for root in roots) else None


def inside(folder, name):
    path = (folder / name).resolve()
    return path if path.is_relative_to(folder) and path.is_file() else None


def references(record, roots, gauges):
    """Reference marks {gauge, time, value, time_error, value_error, text}; time None: the last reading of the whole run."""
    folder = case_folder(record, roots)
    if folder is None:
        return []
    marks = from_verify(folder, record, gauges) if (folder / "verify.toml").is_file() else []
    marked = {mark["gauge"] for mark in marks}
    for gauge in gauges:
        path = inside(folder, f"reference/{gauge}.csv") if gauge not in marked and "/" not in gauge else None
        for row in rows_of(path) if path else []:
            if len(row) == 2:
                marks.append(mark(gauge, row[0], row[1], f"reference/{gauge}.csv"))
    return marks


def mark(gauge, time, value, text, time_error=0.0, value_error=0.0):
    return {"gauge": gauge, "time": time, "value": value, "time_error": time_error, "value_error": value_error, "text": text}


def from_verify(folder, record, gauges):
    try:
        data = tomllib.loads((folder / "verify.toml").read_text())
    except (ValueError, OSError):
        return []
    runs = data.get("run") or [{"name": "default"}]
    file = pathlib.Path(str(record["case_file"])).name
    ours = record.get("overrides", [])
    like = {run["name"]: settings(run.get("set", [])) == settings(ours) for run in runs
            if run.get("case", "case.toml") == file and run.get("command", "run") == "run"
            and settings(run.get("set", []), effort=False) == settings(ours, effort=False)}
    marks = {}
    for metric in data.get("metric", []):
        run = metric.get("run", runs[0]["name"])
        if run not in like or any(key in metric for key in ("plus", "minus", "weights", "baseline", "align")):
            continue
        try:
            for found in marks_of(metric, folder, gauges, to_the_end=like[run]):
                marks.setdefault((found["gauge"], found["time"], found["value"]), found)
        except (KeyError, IndexError, TypeError, OSError):
            continue  # `poretwin verify` reports its faults
    return list(marks.values())


def marks_of(metric, folder, gauges, to_the_end):
    op, gauge, text = metric["op"], metric.get("gauge", ""), metric.get("name", "")
    scale, tolerance, reference = metric.get("scale", 1.0), metric.get("tolerance", 0.0), metric.get("reference")
    at = metric.get("at")
    judged = at is not None or to_the_end  # a shorter run does not reach the reading to which the reference belongs
    path = inside(folder, metric["reference_csv"]) if "reference_csv" in metric else None
    if op in ("value", "relative") and "from" not in metric and judged:
        off = tolerance * (abs(reference) if op == "relative" else 1.0)
        yield mark(gauge, at, reference / scale, text, value_error=off / abs(scale))
    elif op == "crossing":
        yield mark(gauge, reference, metric.get("limit", 0.0) / scale, text, time_error=tolerance * reference)
    elif op == "curve":
        curve = rows_of(path) if path else metric["curve"]
        for time, right in curve if isinstance(curve, list) else []:
            if metric.get("from", time) <= time <= metric.get("to", time):
                yield mark(gauge, time, right / scale, text)
    elif op in ("l2", "profile") and judged:
        names = metric.get("gauges") or sorted((name for name in gauges if name.partition("[")[0] == gauge),
                                               key=lambda name: int(name.partition("[")[2].rstrip("]") or 0))
        right = [row[-1] for row in rows_of(path)] if path else metric["references"]
        for name, value in zip(names, right):
            yield mark(name, at, value / scale, text)
