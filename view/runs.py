"""The runs below the named folders, and what their files report of them."""
import csv
import json
import math
import os
import re
import socket
import tomllib

import snapshot

PHASES = ("fluid", "solid")
PROCESSES = ("coupler", "fluid", "solid")
MARKS = ("run.toml", "fluid.vtkhdf", "solid.vtkhdf")  # a folder with one of these is a run
DEPTH = 4  # levels of folders that are searched below a named one
TAIL = 1 << 18  # bytes at the end of each log that are searched
MESSAGES = 200
GAUGE_BYTES = 1 << 21  # bytes of a gauge file in one answer


def is_run(path):
    return any(os.path.isfile(os.path.join(path, mark)) for mark in MARKS)


def open_folder(root, parts):
    """Descriptor of a folder below `root`; symbolic links on the way are refused."""
    descriptor = os.open(root, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    for part in parts:
        above = descriptor
        try:
            descriptor = os.open(part, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC, dir_fd=above)
        finally:
            os.close(above)
    return descriptor


class Run:
    def __init__(self, root, parts):
        self.root, self.parts = root, parts
        self.name = "/".join([os.path.basename(root), *parts])

    def folder(self):
        """A context that keeps the folder open."""
        return Folder(self.root, self.parts)


class Folder:
    def __init__(self, root, parts):
        self.place = root, parts

    def __enter__(self):
        self.descriptor = open_folder(*self.place)
        return self

    def __exit__(self, *_):
        os.close(self.descriptor)

    def text(self, name, limit=1 << 20, tail=False):
        """The first (or last) `limit` bytes of a file as text; empty where there is no such file."""
        file = snapshot.open_file(name, self.descriptor)
        if file is None:
            return ""
        with os.fdopen(file, "rb") as stream:
            if tail:
                stream.seek(max(0, os.fstat(file).st_size - limit))
            return stream.read(limit).decode("utf-8", "replace")

    def sub(self, name):
        """Descriptor of a folder inside, or None."""
        try:
            return os.open(name, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC, dir_fd=self.descriptor)
        except OSError:
            return None


class Runs:
    """All runs below the named folders. A run keeps its number once it has been found."""

    def __init__(self, folders):
        self.roots = [os.path.realpath(folder) for folder in folders]
        self.known = []

    def find(self):
        there = {(run.root, *run.parts) for run in self.known}
        for root in self.roots:
            for parts in sorted(below(root)):
                if (root, *parts) not in there:
                    self.known.append(Run(root, parts))
        return self.known


def below(root, parts=()):
    path = os.path.join(root, *parts)
    if is_run(path):
        yield parts
        return
    if len(parts) == DEPTH:
        return
    try:
        with os.scandir(path) as entries:
            folders = [entry.name for entry in entries if entry.is_dir(follow_symlinks=False) and not entry.name.startswith(".")]
    except OSError:
        return
    for name in folders:
        yield from below(root, (*parts, name))


def parsed(read, text):
    try:
        data = read(text)
    except ValueError:
        return {}
    return data if isinstance(data, dict) else {}


def record_of(folder):
    return parsed(tomllib.loads, folder.text("run.toml"))


def lock_held(folder):
    """Whether a process on this machine has locked run.lock. The system's list is read: trying to lock could keep a run out of its folder."""
    file = snapshot.open_file("run.lock", folder.descriptor)
    if file is None:
        return False
    here = os.fstat(file)
    os.close(file)
    place = f"{os.major(here.st_dev):02x}:{os.minor(here.st_dev):02x}:{here.st_ino}"
    try:
        with open("/proc/locks") as locks:
            if any(line.split()[5] == place for line in locks if "->" not in line):
                return True
    except OSError:
        pass
    # Some file systems show other numbers in that list: then the process that signed the file is looked up.
    words = folder.text("run.lock").partition("\n")[2].split()
    return len(words) >= 2 and words[1] == socket.gethostname() and words[0].isdigit() and is_poretwin(words[0])


def is_poretwin(process):
    try:
        with open(f"/proc/{process}/comm") as name:
            return name.read().strip() == "poretwin"
    except OSError:
        return False


STATES = {0: "finished", 6: "in doubt", 130: "interrupted"}


def state_of(record, running):
    if running:
        return "running"
    if "exit" not in record:
        return "broken off" if record else "unknown"
    return STATES.get(record["exit"], "failed")


def clean(number):
    return number if isinstance(number, (int, float)) and math.isfinite(number) else None


def messages_of(folder):
    """The last warnings and errors of the logs."""
    found = []
    logs = folder.sub("log")
    if logs is None:
        return found
    try:
        for process in PROCESSES:
            file = snapshot.open_file(f"{process}.log", logs)
            if file is None:
                continue
            with os.fdopen(file, "rb") as stream:
                stream.seek(max(0, os.fstat(file).st_size - TAIL))
                text = stream.read(TAIL).decode("utf-8", "replace")
            for line in text.splitlines():
                kind = "error" if "error:" in line else "warning" if "warning:" in line else None
                if kind:
                    time = re.match(r"\[(\d\d:\d\d:\d\d)\] ", line)
                    words = line[time.end() :] if time else line
                    if not words.startswith(process):
                        words = f"{process}: {words}"
                    found.append({"kind": kind, "time": time.group(1) if time else "", "text": words[:4000]})
    finally:
        os.close(logs)
    return sorted(found, key=lambda message: message["time"])[-MESSAGES:]


def doing_of(folder):
    """What a run does before its time advances: the search for equilibrium, as reported in the solid's log."""
    logs = folder.sub("log")
    if logs is None:
        return ""
    try:
        file = snapshot.open_file("solid.log", logs)
        if file is None:
            return ""
        with os.fdopen(file, "rb") as stream:
            stream.seek(max(0, os.fstat(file).st_size - 4096))
            lines = stream.read(4096).decode("utf-8", "replace").splitlines()
        return lines[-1] if lines and lines[-1].startswith("rest of the soil") else ""
    finally:
        os.close(logs)


def summaries_of(folder):
    result = []
    for process in PROCESSES:
        data = parsed(json.loads, folder.text(f"{process}.summary.json"))
        if data:
            seconds = data.get("seconds") if isinstance(data.get("seconds"), dict) else {}
            result.append({"process": process, "wall": clean(data.get("wall_s")), "cpu": clean(data.get("cpu_s")),
                           "seconds": {str(k): clean(v) for k, v in seconds.items()}})
    return result


def status(run):
    with run.folder() as folder:
        record = record_of(folder)
        running = "exit" not in record and lock_held(folder)
        progress = parsed(json.loads, folder.text("progress.json")) if running else {}
        files = {}
        for phase in PHASES:
            try:
                found = snapshot.read(folder.descriptor, f"{phase}.vtkhdf")
                if found:
                    files[phase] = {"tag": found[0], "bytes": found[1]}
            except snapshot.Unreadable as error:
                files[phase] = {"error": str(error)}
        return {
            "name": run.name,
            "case": str(record.get("case", "")),
            "state": state_of(record, running),
            "exit": record.get("exit"),
            "reason": str(record.get("reason", "")),
            "started": str(record.get("started", "")),
            "ended": str(record.get("ended", "")),
            "wall": clean(record.get("wall_s")),
            "overrides": [str(text) for text in record.get("overrides", [])],
            "progress": {key: clean(value) if key != "waiting_for" else str(value) for key, value in progress.items()},
            "doing": doing_of(folder) if running and not progress.get("t") else "",
            "messages": messages_of(folder) if "exit" not in record else
                        [{"kind": "warning", "time": "", "text": str(text)} for text in record.get("warnings", [])] +
                        [message for message in messages_of(folder) if message["kind"] == "error"],
            "summaries": summaries_of(folder) if not running else [],
            "files": files,
        }


def gauges(run, cursor):
    """Readings since `cursor`, by gauge. `more`: there are more readings to ask for at once."""
    answer = {"series": {}, "cursor": {}, "more": False}
    with run.folder() as folder:
        names = [f"gauges.{phase}.csv" for phase in PHASES]
        opened = [(name, snapshot.open_file(name, folder.descriptor)) for name in names]
        if all(file is None for _, file in opened):
            opened = [("gauges.csv", snapshot.open_file("gauges.csv", folder.descriptor))]
        for name, file in opened:
            if file is None:
                continue
            with os.fdopen(file, "rb") as stream:
                at = cursor.get(name, 0)
                size = os.fstat(file).st_size
                if at > size:  # a resumed run has cut off what came after its checkpoint
                    at = 0
                stream.seek(at)
                text = stream.read(GAUGE_BYTES)
            whole = text.rfind(b"\n") + 1  # the last line may be incomplete
            answer["cursor"][name] = at + whole
            answer["more"] |= at + len(text) < size
            for row in csv.reader(text[:whole].decode("utf-8", "replace").splitlines()):
                add_reading(answer["series"], row)
    return answer


def add_reading(series, row):
    try:
        time, gauge, value, unit = float(row[0]), row[1], float(row[2]), row[3]
    except (ValueError, IndexError):
        return  # the heading
    entry = series.setdefault(gauge, {"unit": unit, "time": [], "value": []})
    entry["time"].append(time)
    entry["value"].append(clean(value))
