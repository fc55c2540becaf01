"""Reads a results file as of its last flush, even while its writer changes it.

The writer copies what it is about to replace to FILE.undo first, and a flush empties that file (common/output/undo_driver.cpp).
So a piece of FILE is read first and FILE.undo after it: whatever has changed meanwhile is there with its old bytes. Every flush
has a stamp; where it is the same before and after, all that was read belongs to one state of the file.
"""
import collections
import os
import stat
import struct
import threading
import time

HEADER = struct.Struct("<QQQ")  # length at the flush, its stamp, 0
PIECE = struct.Struct("<QQ")  # position, number of bytes that follow
PATIENCE = 2.0  # s; longest wait for a flush in progress, which takes a moment
LARGEST_KEPT = 1 << 26  # bytes of a file that is kept whole while it is written
MOST_KEPT = 1 << 28  # bytes of all files that are kept


class Unreadable(Exception):
    """The file cannot be read; the message says which and why."""


def open_file(name, folder):
    """Opens a regular file in an open folder; None where there is none. Symbolic links are refused: a run contains none."""
    try:
        descriptor = os.open(name, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC, dir_fd=folder)
    except FileNotFoundError:
        return None
    except OSError as error:
        raise Unreadable(f"{name}: {'is a symbolic link, which is not followed' if error.errno == 40 else error.strerror}")
    if not stat.S_ISREG(os.fstat(descriptor).st_mode):
        os.close(descriptor)
        raise Unreadable(f"{name}: is not a regular file")
    return descriptor


def state_of(file, undo):
    """Tag and length of the file at its last flush; None while the writer is in the middle of an operation."""
    here = os.fstat(file)
    if undo is None:
        return f"{here.st_ino:x}-{here.st_mtime_ns:x}-{here.st_size:x}", here.st_size
    journal = os.fstat(undo)
    if journal.st_size == 0:
        return f"{here.st_ino:x}-{journal.st_mtime_ns:x}", here.st_size
    if journal.st_size < HEADER.size:
        return None
    length, stamp, nothing = HEADER.unpack(os.pread(undo, HEADER.size, 0).ljust(HEADER.size, b"\0"))
    if nothing != 0:  # from a program without stamps
        stamp = journal.st_mtime_ns
    return f"{here.st_ino:x}-{stamp:x}", length


def restore(data, first, undo):
    """Replaces changed bytes in `data`, which begins at position `first` of the file, by the old ones in FILE.undo."""
    journal = os.pread(undo, os.fstat(undo).st_size, 0)
    pieces, at = [], 8
    while at + PIECE.size <= len(journal):
        where, count = PIECE.unpack_from(journal, at)
        at += PIECE.size
        if at + count > len(journal):
            break  # incomplete: the file has not been changed there yet
        pieces.append((where, count, at))
        at += count
    # Of several copies the oldest is right, so it is applied last.
    for where, count, start in reversed(pieces):
        low, high = max(where, first), min(where + count, first + len(data))
        if low < high:
            data[low - first : high - first] = journal[start + low - where : start + high - where]


def read(folder, name, first=0, count=0):
    """(tag, length, bytes) of the file at its last flush; None where there is no such file."""
    deadline = time.monotonic() + PATIENCE
    while True:
        file = open_file(name, folder)
        if file is None:
            return None
        undo = None
        try:
            undo = open_file(name + ".undo", folder)
            before = state_of(file, undo)
            if before is not None:
                wanted = max(0, min(count, before[1] - first))
                data = bytearray(os.pread(file, wanted, first).ljust(wanted, b"\0"))
                if undo is not None:
                    restore(data, first, undo)
                elif (now := open_file(name + ".undo", folder)) is not None:
                    os.close(now)  # the file has been replaced since it was opened
                    continue
                if state_of(file, undo) == before:
                    return (*before, bytes(data))
        finally:
            os.close(file)
            if undo is not None:
                os.close(undo)
        if time.monotonic() > deadline:
            raise Unreadable(f"{name}: changes faster than it can be read")
        time.sleep(0.002)


class Kept:
    """Whole files as of the flush at which a reader opened them.

    A reader needs many requests for one frame. A fast run flushes in between, and then no two pieces would belong together.
    """

    def __init__(self):
        self.lock = threading.Lock()
        self.files = collections.OrderedDict()  # (whose, name, tag) -> bytes, the most recently used last

    def open(self, whose, folder, name):
        """(tag, length) of a file at its last flush, as read() gives them; the file is kept if it is being written and not too large."""
        found = read(folder, name)
        if found is None:
            return None
        tag, length, _ = found
        with self.lock:
            known = (whose, name, tag) in self.files
        if known or length > LARGEST_KEPT or not being_written(folder, name):
            return tag, length
        found = read(folder, name, 0, LARGEST_KEPT)
        if found is None:
            return None
        tag, length, data = found
        if len(data) == length:  # else it has grown beyond the limit since
            with self.lock:
                self.files[whose, name, tag] = data
                while sum(map(len, self.files.values())) > MOST_KEPT:
                    self.files.popitem(last=False)
        return tag, length

    def read(self, whose, folder, name, tag, first, count):
        """(tag, length, bytes) of the state with this tag where it is kept, else of the last flush; None where there is no such file."""
        with self.lock:
            data = self.files.get((whose, name, tag))
            if data is not None:
                self.files.move_to_end((whose, name, tag))
        return read(folder, name, first, count) if data is None else (tag, len(data), data[first : first + count])


def being_written(folder, name):
    undo = open_file(name + ".undo", folder)
    if undo is not None:
        os.close(undo)
    return undo is not None
