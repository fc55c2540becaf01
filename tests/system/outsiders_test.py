#!/usr/bin/python3
"""A healthy run over TCP while an outsider sends a thousand HELLOs a second to its coupler, without keys and with keys of
another run.

The run must end with the same gauges as one that nobody disturbs, its coupler must take at most 100 MB more memory and write at most
1 MB more to its log, and the three processes must take at most 10 % more CPU time. Both runs go side by side, so that other work on
the machine slows them alike; CPU time is compared, since wall time depends on that work still more.

usage: outsiders_test.py FOLDER_OF_PROGRAMS SOURCE_FOLDER [SECONDS]     SECONDS: how long a run should take, 60 by default
"""
import os
import pathlib
import socket
import subprocess
import sys
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor

PROGRAMS, SOURCE = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
SECONDS = float(sys.argv[3]) if len(sys.argv) > 3 else 60.0
sys.path.insert(0, str(SOURCE / "clients" / "python"))

import zmq
from poretwin import wire

RATE = 1000  # HELLOs a second
MOST_MEMORY, MOST_LOG, MOST_TIME = 100e6, 1e6, 1.10  # bytes, bytes, ratio


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


def hello():
    header = wire.pb.Header()
    header.protocol_major, header.protocol_minor = wire.PROTOCOL
    header.sequence, header.sender = 1, "fluid"
    header.hello.role, header.hello.dimension, header.hello.case_digest = "fluid", 2, "0" * 16
    header.hello.software = "outsider"
    return header.SerializeToString()


def knock(address, keys, stop, sent):
    """Sends HELLOs until it is stopped; keys: public and secret key of a participant of another run and the public key of this run's
    coupler, or None."""
    s = zmq.Context.instance().socket(zmq.DEALER)
    s.linger, s.sndhwm = 0, 100000
    if keys:
        s.curve_publickey, s.curve_secretkey, s.curve_serverkey = keys
    s.connect(address)
    message, start = hello(), time.time()
    while not stop.is_set():
        for _ in range(RATE // 100):
            try:
                s.send(message, zmq.NOBLOCK)
            except zmq.Again:
                pass
            sent[0] += 1
        time.sleep(max(0.0, sent[0] / RATE - (time.time() - start)))
    s.close()


def curve_keys(file):
    """The public and secret key of a participant, and the public key of its coupler, from a file of `poretwin keys`."""
    lines = (line.split() for line in pathlib.Path(file).read_text().splitlines() if not line.startswith("#"))
    values = {line[0]: line[1].encode() for line in lines if len(line) == 2}
    return values["public"], values["secret"], values["peer"]


def memory(pid):
    try:
        for line in open(f"/proc/{pid}/status"):
            if line.startswith("VmHWM"):
                return int(line.split()[1]) * 1024
    except OSError:
        pass
    return 0


class Result:
    pass


def run(folder, end, keys=None, outsider=False, others=None):
    """One run of terzaghi by three processes; `end`: of the case [s]."""
    folder.mkdir()
    address = f"tcp://127.0.0.1:{free_port()}"
    processes, start = {}, time.time()
    for name in ("coupler", "fluid", "solid"):
        command = [PROGRAMS / f"poretwin-{name}", "--case", SOURCE / "cases" / "terzaghi" / "case.toml", "--out", folder / name,
                   "--set", f"case.end_time={end}", "--set", "output.interval=0", "--bind" if name == "coupler" else "--connect", address]
        if keys:
            command += ["--keys", keys / ("coupler.key" if name == "coupler" else "participant.key")]
        processes[name] = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=open(folder / f"{name}.log", "w"))
    stop, sent, most = threading.Event(), [0], 0
    thread = threading.Thread(target=knock, args=(address, others, stop, sent))
    if outsider:
        thread.start()
    result = Result()
    exits, result.cpu = {}, 0.0
    while len(exits) < len(processes):
        for name in set(processes) - set(exits):
            pid, status, usage = os.wait4(processes[name].pid, os.WNOHANG)
            if pid:
                exits[name] = processes[name].returncode = os.waitstatus_to_exitcode(status)
                result.cpu += usage.ru_utime + usage.ru_stime
            elif time.time() - start > 10.0 * SECONDS + 60.0:
                processes[name].kill()
        if "coupler" not in exits:
            most = max(most, memory(processes["coupler"].pid))
        time.sleep(0.1)
    stop.set()
    result.exits = [exits[name] for name in processes]
    if outsider:
        thread.join()
    result.wall, result.memory, result.sent = time.time() - start, most, sent[0]
    result.log = (folder / "coupler.log").stat().st_size
    result.gauges = [(folder / name / f"gauges.{name}.csv").read_bytes() for name in ("fluid", "solid")]
    print(f"{folder.name}: exits {result.exits}, {result.wall:.1f} s, {result.cpu:.1f} CPU s, {most / 1e6:.0f} MB, log {result.log} bytes, "
          f"{result.sent} HELLOs", flush=True)
    return result


def main():
    wrong = []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for k in ("own", "others"):
            subprocess.run([PROGRAMS / "poretwin", "keys", folder / k], check=True, stdout=subprocess.DEVNULL)
        stolen = curve_keys(folder / "others" / "participant.key")[:2] + curve_keys(folder / "own" / "participant.key")[2:]
        first = run(folder / "first", 0.5)
        end = 0.5 * SECONDS / first.wall
        for kind, keys, others in (("without keys", None, None), ("with keys", folder / "own", stolen)):
            tag = kind.replace(" ", "_")
            with ThreadPoolExecutor() as both:
                quiet = both.submit(run, folder / f"quiet_{tag}", end, keys)
                loud = both.submit(run, folder / f"loud_{tag}", end, keys, True, others)
                quiet, loud = quiet.result(), loud.result()
            for what, bad in (("it does not end in order", loud.exits != [0, 0, 0] or quiet.exits != [0, 0, 0]),
                              ("the outsider did not knock", loud.sent < 0.5 * RATE * loud.wall),
                              ("another result", loud.gauges != quiet.gauges),
                              ("memory", loud.memory - quiet.memory > MOST_MEMORY),
                              ("log", loud.log - quiet.log > MOST_LOG),
                              ("CPU time", loud.cpu > MOST_TIME * quiet.cpu)):
                if bad:
                    wrong.append(f"{kind}: {what}")
    print("wrong: " + "; ".join(wrong) if wrong else "as if nobody had knocked")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
