"""The client through which a phase takes part in a coupled run. It does the handshake, carries out the coupler's commands within
deadlines, and sends heartbeats."""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import json
import os
import re
import select
import signal
import socket
import sys
import threading
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
import zmq
from zmq.utils.monitor import recv_monitor_message

from . import state, wire
from .case import Case
from .phase import Inbox, Phase, Refused, Window

pb = wire.pb


class PeerError(Exception):
    """The run cannot continue; `code` is the exit code (docs/protocol.md)."""

    def __init__(self, text: str, code: int = 3) -> None:
        super().__init__(text)
        self.code = code


def log(line: str) -> None:
    """Writes one line to stderr, in the form common to all processes of a run."""
    print(time.strftime("[%H:%M:%S] ", time.gmtime()) + line, file=sys.stderr, flush=True)


class Line:
    """The connection to the coupler, a DEALER socket. The phase's thread and the thread of the heartbeats use it under one lock."""

    def __init__(self, address: str) -> None:
        self.context = zmq.Context()
        self.socket = self.context.socket(zmq.DEALER)
        self.socket.set(zmq.LINGER, 2000)
        self.socket.set(zmq.SNDHWM, 0)
        self.socket.set(zmq.RCVHWM, 0)
        self.socket.set(zmq.RECONNECT_IVL, 50)
        self.monitor = self.socket.get_monitor_socket(zmq.EVENT_HANDSHAKE_SUCCEEDED | zmq.EVENT_DISCONNECTED)
        self.lock = threading.Lock()
        self.woken, self.waker = os.pipe()
        os.set_blocking(self.woken, False)
        os.set_blocking(self.waker, False)
        self.signals = select.poll()
        for file in (int(self.socket.get(zmq.FD)), int(self.monitor.get(zmq.FD)), self.woken):
            self.signals.register(file, select.POLLIN)
        self.address = address
        self.open = False
        self.lost = False
        self.socket.connect(address)

    def send(self, frames: list[Any]) -> None:
        """Sends frames; the caller must have the lock."""
        self.socket.send_multipart(frames, copy=True)
        # Sending also reads pending events of the socket, and so consumes the signal for which receive() may be waiting.
        if int(self.socket.get(zmq.EVENTS)) & zmq.POLLIN:
            self.wake()

    def wake(self) -> None:
        with contextlib.suppress(BlockingIOError):
            os.write(self.waker, b"!")

    def receive(self, milliseconds: int) -> list[bytes] | None:
        """The next message, or None. Releases the lock while it waits, so that heartbeats can be sent."""
        frames = self.look()
        if frames is None and not self.lost:
            self.signals.poll(milliseconds)
            with contextlib.suppress(BlockingIOError):
                os.read(self.woken, 4096)
            frames = self.look()
        return frames

    def look(self) -> list[bytes] | None:
        with self.lock:
            if (frames := self.take()) is not None:
                return frames
            while self.monitor.poll(0):
                event = recv_monitor_message(self.monitor)["event"]
                if event == zmq.EVENT_HANDSHAKE_SUCCEEDED:
                    self.open = True
                elif self.open:
                    self.lost = True
            return self.take()  # once the connection is closed, the coupler's last message may still be in the queue

    def take(self) -> list[bytes] | None:
        with contextlib.suppress(zmq.Again):
            frames: list[bytes] = self.socket.recv_multipart(zmq.NOBLOCK)
            return frames
        return None

    def close(self) -> None:
        with self.lock:
            self.socket.disable_monitor()
            self.monitor.close(linger=0)
            self.socket.close(linger=0 if self.lost or not self.open else 2000)
        self.context.term()
        os.close(self.woken)
        os.close(self.waker)


class Participant:
    """A solver's side of the exchange of messages in docs/protocol.md. poretwin.main() runs it; a solver rarely uses it directly."""

    def __init__(self, address: str, role: str, wait_deadline: float = 60.0, coupler_deadline: float = 60.0,
                 say_every: float = 5.0) -> None:
        self.line = Line(address)
        self.role = role
        self.wait_deadline, self.coupler_deadline, self.say_every = wait_deadline, coupler_deadline, say_every
        self.session = ""
        self.sequence = 0
        self.step = self.iteration = 0
        self.doing, self.doing_since = "computing", time.monotonic()
        self.heard = time.monotonic()
        self.last = "none"
        self.waiting_for = ""
        self.revision_sent: int | None = None
        self.interrupted = False
        self.stop = threading.Event()
        self.thread: threading.Thread | None = None
        self.n_active = 0

    # Sending

    def send(self, header: Any, frames: Iterable[Any] = ()) -> None:
        with self.line.lock:
            self.sequence += 1
            header.protocol_major, header.protocol_minor = wire.PROTOCOL
            header.session, header.sender, header.sequence = self.session, self.role, self.sequence
            self.line.send(wire.encode(header, frames))

    def answer(self, time_now: float = 0.0) -> Any:
        return pb.Header(step=self.step, iteration=self.iteration, time=time_now)

    def beat(self, interval: float) -> None:
        while not self.stop.wait(interval):
            header = pb.Header(step=self.step)
            header.heartbeat.doing = self.doing
            header.heartbeat.since = time.monotonic() - self.doing_since
            header.heartbeat.interrupted = self.interrupted
            self.send(header)

    def set_doing(self, what: str) -> None:
        self.doing, self.doing_since = what, time.monotonic()

    # Receiving

    def next(self, deadline: float, silence: bool) -> tuple[str, Any, dict[str, np.ndarray]]:
        """The next message that is no heartbeat: kind, header, arrays. silence: whether the deadline [s] counts from the last message of
        any kind, not from the call."""
        start = said = time.monotonic()
        while True:
            frames = self.line.receive(100)
            now = time.monotonic()
            if frames:
                self.heard = now
                header, arrays = wire.decode(frames)
                if header.protocol_major != wire.PROTOCOL[0]:
                    raise PeerError(f"refused: protocol: expected {wire.PROTOCOL[0]}.x, the coupler speaks "
                                    f"{header.protocol_major}.{header.protocol_minor}")
                kind = header.WhichOneof("body")
                if kind == "heartbeat":
                    self.waiting_for = header.heartbeat.waiting_for
                    continue
                self.last = f"{kind.upper()} step {header.step} (t = {header.time:g} s)"
                if kind == "abort":
                    raise PeerError(f"the run was aborted by {header.abort.culprit}: {header.abort.reason}", header.abort.exit_code or 1)
                if kind == "bye":
                    raise PeerError("the coupler left: " + header.bye.reason)
                return kind, header, arrays
            if self.line.lost:
                raise PeerError(f"the coupler is gone: its connection closed; last message: {self.last}")
            if now - (self.heard if silence else start) > deadline:
                raise PeerError(f"nothing came from the coupler at {self.line.address} for {deadline:g} s; last message: {self.last}")
            if now - said >= self.say_every:
                said = now
                log(f"{self.role}: waiting for {self.waiting_for or 'the coupler'} ({now - start:.0f} s), last message {self.last}")

    def request_case(self) -> Case:
        header = pb.Header()
        header.case_request.role = self.role
        self.send(header)
        kind, answer, _ = self.next(self.wait_deadline, silence=False)
        if kind != "case_file":
            raise PeerError(f"expected the case from the coupler, got {self.last}")
        return Case(answer.case_file.text, answer.case_file.overrides, answer.case_file.digest, answer.case_file.dimension)

    def join(self, phase: Phase, digest: str, checkpoints: Iterable[str] = ()) -> None:
        header = pb.Header()
        hello = header.hello
        hello.role, hello.dimension, hello.case_digest = self.role, phase.dimension, digest
        for specs, out in ((phase.gives(), hello.gives), (phase.takes(), hello.takes)):
            for spec in specs:
                out.add(name=spec.name, unit=spec.unit, components=spec.components, mask=spec.mask, in_time=spec.in_time,
                        mapping=getattr(pb, spec.mapping.upper()))
        hello.software, hello.process, hello.host = "poretwin for Python", os.getpid(), socket.gethostname()
        hello.keeps_checkpoints = True
        hello.checkpoints.extend(checkpoints)
        self.sequence = 0
        self.send(header)
        kind, answer, _ = self.next(self.wait_deadline, silence=False)
        if kind == "reject":
            r = answer.reject
            raise PeerError(f"refused by the coupler: {r.field}: expected {r.expected}, got {r.got}" + (f"; {r.reason}" if r.reason else ""))
        if kind != "welcome":
            raise PeerError(f"expected WELCOME, got {self.last}")
        self.session = answer.session
        interval = min(max(answer.welcome.heartbeat_interval, 0.01), 10.0)
        self.thread = threading.Thread(target=self.beat, args=(interval,), daemon=True)
        self.thread.start()

    def publish(self, phase: Phase, time_now: float) -> None:
        publication = phase.publish()
        points = publication.points
        header = self.answer(time_now)
        frames: list[Any] = []
        header.publication.proposed_interval = publication.proposed_interval
        header.publication.limited_by = publication.limited_by
        header.points.dimension, header.points.revision = phase.dimension, points.revision
        header.points.n, header.points.n_active = len(points), points.n_active
        header.points.sent = self.revision_sent != points.revision
        self.n_active = points.n_active
        if header.points.sent:
            wire.add_array(header, frames, "@position", "m", np.reshape(points.position, (len(points), phase.dimension)))
            wire.add_array(header, frames, "@volume", f"m^{phase.dimension}", points.volume)
            wire.add_array(header, frames, "@smoothing_length", "m", points.smoothing_length)
            wire.add_array(header, frames, "@owner", "1", points.owner)
            self.revision_sent = points.revision
        for spec in phase.gives():
            values = np.asarray(publication.fields.get(spec.name, np.zeros(len(points) * spec.components)), dtype=float)
            wire.add_array(header, frames, spec.name, spec.unit, values if spec.components == 1 else values.reshape(-1, spec.components))
        self.set_doing("waiting")
        self.send(header, frames)

    def inbox(self, phase: Phase, arrays: dict[str, np.ndarray]) -> Inbox:
        for name, values in arrays.items():
            if len(values) != self.n_active:
                raise PeerError(f"field '{name}' came for {len(values)} points, {self.n_active} were expected")
        missing = [f.name for f in phase.takes() if f.name not in arrays]
        if missing:
            raise PeerError(f"field '{missing[0]}' was expected in the exchange and did not arrive")
        arrays = dict(arrays)
        return Inbox(arrays.pop("@coverage"), arrays.pop("@asymmetry"), spread=arrays.pop("@spread", None), fields=arrays)

    def leave(self, kind: str, reason: str, code: int = 0) -> None:
        header = self.answer()
        if kind == "abort":
            header.abort.culprit, header.abort.reason, header.abort.exit_code = self.role, reason, code
        else:
            header.bye.reason = reason
        self.stop.set()
        self.send(header)

    def close(self) -> None:
        self.stop.set()
        if self.thread:
            self.thread.join()
        self.line.close()


class Record:
    """The file OUT/gauges.ROLE.csv. Values are written only once it is certain that their window will not be repeated."""

    def __init__(self, out: Path, role: str, resume: bool = False) -> None:
        self.path = out / f"gauges.{role}.csv"
        self.pending = False
        if not resume:
            self.path.write_text("time_s,gauge,value,unit\n")

    def size(self) -> int:
        return self.path.stat().st_size

    def cut(self, size: int) -> None:
        os.truncate(self.path, size)

    def write(self, phase: Phase, time_now: float) -> None:
        if self.pending:
            with self.path.open("a") as file:
                for name, (value, unit) in phase.gauges().items():
                    file.write(f"{time_now!r},{name},{float(value)!r},{unit}\n")
        self.pending = False


class Checkpoints:
    """The files OUT/checkpoints/ROLE-NAME.state. A file consists of a checksum and the data (state.py). A file with this name is always
    complete, since it is renamed to it only after it has been written."""

    def __init__(self, out: Path, role: str) -> None:
        self.folder, self.role = out / "checkpoints", role

    def path(self, name: str) -> Path:
        if not re.fullmatch("[0-9a-z-]{1,64}", name):
            raise PeerError(f"checkpoint '{name[:64]}': expected a name of at most 64 digits, small letters and hyphens")
        return self.folder / f"{self.role}-{name}.state"

    def names(self) -> list[str]:
        """Names of the checkpoints that are complete."""
        found = []
        for path in sorted(self.folder.glob(f"{self.role}-*.state")):
            data = path.read_bytes()
            if hashlib.sha256(data[32:]).digest() == data[:32]:
                found.append(path.stem[len(self.role) + 1:])
        return found

    def keep_only(self, names: Iterable[str]) -> None:
        for path in self.folder.glob(f"{self.role}-*"):
            if path not in [self.path(name) for name in names]:
                path.unlink()

    def write(self, name: str, content: Any) -> None:
        self.folder.mkdir(exist_ok=True)
        data = state.dump(content)
        part = self.path(name).with_suffix(".part")
        with part.open("wb") as file:
            file.write(hashlib.sha256(data).digest() + data)
            file.flush()
            os.fsync(file.fileno())
        part.rename(self.path(name))
        folder = os.open(self.folder, os.O_RDONLY)
        os.fsync(folder)
        os.close(folder)

    def read(self, name: str) -> Any:
        """The content that write() stored. Raises PeerError where the file contains something else."""
        try:
            return state.load(self.path(name).read_bytes()[32:])
        except state.StateError as error:
            raise PeerError(f"{self.path(name)}: cannot be resumed from: {error}; begin anew without --resume", 5) from error


def drive(phase: Phase, participant: Participant, record: Record, counts: dict[str, int], checkpoints: Checkpoints) -> str:
    """Carries out the coupler's commands until FINISH; returns the reason that FINISH gives."""
    now = before = 0.0
    advanced = False
    participant.publish(phase, now)
    while True:
        kind, header, arrays = participant.next(participant.coupler_deadline, silence=True)
        participant.step, participant.iteration = header.step, header.iteration
        participant.set_doing("writing" if kind in ("finish", "checkpoint") else "computing")
        if kind == "checkpoint":
            record.write(phase, now)
            checkpoints.keep_only(header.checkpoint.keep)
            checkpoints.write(header.checkpoint.name, (phase.state(), now, dict(counts), record.size()))
            answer = participant.answer(now)
            answer.checkpoint_written.name = header.checkpoint.name
            participant.set_doing("waiting")
            participant.send(answer)
        elif kind == "resume":
            content, now, then, size = checkpoints.read(header.resume.name)
            phase.resume(content)
            counts.update(then)
            record.cut(size)
            participant.revision_sent = None
            participant.publish(phase, now)
        elif kind == "initialise":
            checkpoints.keep_only([])
            phase.initialise(participant.inbox(phase, arrays))
            participant.publish(phase, now)
            record.pending = header.initialise.record_gauges
            record.write(phase, now)
        elif kind == "advance":
            record.write(phase, now)
            phase.save()
            advanced = False
            try:
                phase.advance(Window(header.step, header.time, header.interval), participant.inbox(phase, arrays))
            except Refused as refused:
                counts["rejected"] += 1
                answer = participant.answer(header.time)
                answer.interval = header.interval
                answer.reject.code = pb.REJECT_STEP
                answer.reject.field, answer.reject.reason = "interval", str(refused)
                answer.reject.expected = f"at most {refused.suggested_interval:g} s"
                answer.reject.got = f"{header.interval:g} s"
                answer.reject.suggested_interval = refused.suggested_interval
                participant.set_doing("waiting")
                participant.send(answer)
                continue
            before, now, advanced = now, header.time + header.interval, True
            counts["windows"] += 1
            participant.publish(phase, now)
            record.pending = header.advance.record_gauges
        elif kind == "restore":
            phase.restore()
            participant.revision_sent = None
            record.pending = False
            if advanced:
                now, advanced = before, False
                counts["windows"] -= 1
                counts["rejected"] += 1
        elif kind == "finish":
            record.write(phase, now)
            participant.leave("bye", header.finish.reason)
            return str(header.finish.reason)
        else:
            raise PeerError(f"an unexpected {participant.last} came in")


def main(role: str, make_phase: Callable[[Case], Phase]) -> int:
    """The main function of a solver; returns the exit code. make_phase(case) makes the phase. The command-line arguments are those that
    `poretwin run` passes."""
    parser = argparse.ArgumentParser(description=f"A {role} for poretwin.")
    parser.add_argument("--connect", required=True, metavar="ADDRESS", help="ipc:///path or tcp://host:port")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR")
    parser.add_argument("--case", help="ignored: the coupler sends its case")
    parser.add_argument("--set", action="append", help="ignored: the coupler sends its overrides")
    parser.add_argument("--wait-deadline", type=float, default=60.0, metavar="S")
    parser.add_argument("--frozen-deadline", type=float, default=30.0, metavar="S")
    parser.add_argument("--resume", action="store_true", help="go on from a checkpoint in DIR")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    start, counts = time.monotonic(), {"windows": 0, "rejected": 0}
    participant = Participant(arguments.connect, role, arguments.wait_deadline, 2.0 * arguments.frozen_deadline)

    def note(*_: object) -> None:
        participant.interrupted = True

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, note)
    code, reason = 0, "end"
    try:
        case = participant.request_case()
        phase = make_phase(case)
        checkpoints = Checkpoints(arguments.out, role)
        participant.join(phase, case.digest, checkpoints.names() if arguments.resume else ())
        reason = drive(phase, participant, Record(arguments.out, role, arguments.resume), counts, checkpoints)
        code = 130 if reason == "interrupted" else 0
    except PeerError as error:
        code, reason = error.code, str(error)
    except Exception as error:  # raised by the phase: the other processes must be informed
        code, reason = 1, f"{type(error).__name__}: {error}"
        participant.leave("abort", reason, code)
    participant.close()
    if code not in (0, 130):
        log(f"{role}: error: {reason}")
    summary = {"process": role, "exit": code, "reason": reason, "wall_s": time.monotonic() - start, "cpu_s": time.process_time(),
               "seconds": {}, "steps": counts, "counters": {}, "files": [f"gauges.{role}.csv"]}
    (arguments.out / f"{role}.summary.json").write_text(json.dumps(summary, indent=2) + "\n")
    return code
