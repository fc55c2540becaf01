#!/usr/bin/python3
"""Makes a run folder of any size without running anything: made_run.py FOLDER PARTICLES FRAMES [--flat] [--names]."""
import argparse
import pathlib

import h5py
import numpy as np


def write(path, frames, fields):
    """frames: [(time, positions, {field: values})]; fields: {name: unit}."""
    with h5py.File(path, "w") as file:
        root = file.create_group("VTKHDF")
        root.attrs["Version"] = np.array([2, 0])
        root.attrs["Type"] = np.bytes_("UnstructuredGrid")
        packed = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
        points = np.concatenate([x for _, x, _ in frames])
        root.create_dataset("Points", data=points, chunks=(min(5461, max(1, len(points))), 3), **packed)
        counts = np.array([len(x) for _, x, _ in frames], dtype=np.int64)
        root["NumberOfPoints"] = counts
        steps = root.create_group("Steps")
        steps.attrs["NSteps"] = np.int64(len(frames))
        steps["Values"] = np.array([t for t, _, _ in frames])
        steps["PointOffsets"] = np.concatenate([[0], np.cumsum(counts)[:-1]])
        data = root.create_group("PointData")
        for name, unit in fields.items():
            values = np.concatenate([f[name] for _, _, f in frames])
            made = data.create_dataset(name, data=values, chunks=(min(16384 // (values.shape[1] if values.ndim > 1 else 1), len(values)), *values.shape[1:]), **packed)
            made.attrs["unit"], made.attrs["description"] = unit, f"{name}, made"


def made(particles, count, three, markup):
    random = np.random.default_rng(1)
    side = round(particles ** (1 / 3)) if three else round(particles**0.5)
    axis = (np.arange(side) + 0.5) / side
    grid = np.stack(np.meshgrid(*[axis] * (3 if three else 2), indexing="ij"), axis=-1).reshape(-1, 3 if three else 2)
    grid = grid if three else np.pad(grid, ((0, 0), (0, 1)))
    name = '<img src=x onerror="window.hit=1">' if markup else "pore_pressure"
    for step in range(count):
        x = grid + 0.1 * np.sin(0.3 * step) * grid[:, :1] * np.array([0.0, 1.0, 0.0]) + random.normal(0, 1e-4, grid.shape) * [1, 1, 1 if three else 0]
        velocity = 0.1 * np.cross([0, 0, 1.0], x - 0.5)
        volume = np.full(len(x), 1.0 / len(x))
        yield 0.1 * step, x, {name: 9810 * (1 - x[:, 2 if three else 1]) + 100 * step, "velocity": velocity, "volume": volume}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("particles", type=int)
    parser.add_argument("frames", type=int)
    parser.add_argument("--flat", action="store_true", help="in two dimensions")
    parser.add_argument("--markup", action="store_true", help="names that would be markup")
    options = parser.parse_args()
    (options.folder / "log").mkdir(parents=True, exist_ok=True)
    frames = list(made(options.particles, options.frames, not options.flat, options.markup))
    write(options.folder / "fluid.vtkhdf", frames, {name: {"velocity": "m/s", "volume": "m3"}.get(name, "Pa") for name in frames[0][2]})
    hostile = '<img src=x onerror="window.hit=1">'
    case, gauge, words = (hostile, f'"{hostile.replace(chr(34), chr(34) * 2)}"', hostile) if options.markup else ("made", "level", "it went wrong")
    case = case.replace('"', '\\"')
    (options.folder / "run.toml").write_text(f'case = "{case}"\ncase_file = ""\noverrides = []\nstarted = "2026-01-01T00:00:00Z"\nended = "2026-01-01T00:01:00Z"\n'
                                             f'exit = 3\nreason = "fluid: {case}"\nwall_s = 60.0\n')
    (options.folder / "gauges.fluid.csv").write_text("time_s,gauge,value,unit\n" + "".join(f"{t:g},{gauge},{t * t:g},m\n" for t, _, _ in frames))
    (options.folder / "log" / "fluid.log").write_text(f"[10:00:00] fluid: error: {words}\n")


if __name__ == "__main__":
    main()
