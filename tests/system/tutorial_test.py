#!/usr/bin/python3
"""Checks that a tutorial works: writes its files, runs its commands one after the other, and compares what they print.

tutorial_test.py PROGRAM PAGE [--pictures]

In the page, by the words after the three backticks of a block:
  toml FILE     is written to FILE, replacing it
  toml FILE +   is appended to FILE
  sh            is run line by line, with `poretwin` in PATH, in a temporary folder; exit code 0 is expected
  text X        is compared with what the last `sh` printed: each line must occur there, words literally, numbers within the relative
                error X; `...` stands for omitted lines
An image whose title is the path of a picture must have been drawn there; --pictures copies it, reduced, into the page's folder.
"""
import os
import pathlib
import re
import resource
import subprocess
import sys
import tempfile

NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"


def blocks(page):
    """(line, info, body) of each fenced block."""
    info, body, first = None, [], 0
    for number, line in enumerate(page.splitlines(), 1):
        if line.startswith("```"):
            if info is None:
                info, body, first = line[3:].strip(), [], number
            else:
                yield first, info, "\n".join(body) + "\n"
                info = None
        elif info is not None:
            body.append(line)


def fits(wanted, found, part):
    """Whether two lines are the same, except for numbers that agree within the relative error `part`."""
    if re.sub(NUMBER, "#", wanted).split() != re.sub(NUMBER, "#", found).split():
        return False
    pairs = zip(re.findall(NUMBER, wanted), re.findall(NUMBER, found))
    return all(abs(float(w) - float(f)) <= part * max(abs(float(w)), abs(float(f))) + 1e-12 for w, f in pairs)


def main():
    program, page = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
    text, wrong, printed = page.read_text(), [], ""
    environment = os.environ | {"PATH": f"{program.parent}:{os.environ['PATH']}"}
    with tempfile.TemporaryDirectory() as scratch:
        place = pathlib.Path(scratch)
        for line, info, body in blocks(text):
            kind, *rest = info.split()
            if kind == "toml":
                with open(place / rest[0], "a" if rest[1:] == ["+"] else "w") as file:
                    file.write(("\n" if rest[1:] == ["+"] else "") + body)
            elif kind == "sh":
                printed = ""
                for command in body.splitlines():
                    done = subprocess.run(["bash", "-c", command], cwd=place, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
                    printed += done.stdout
                    if done.returncode != 0:
                        raise SystemExit(f"{page.name}:{line}: `{command}` ended with {done.returncode}:\n{done.stdout}")
                print(f"{page.name}:{line}: {resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime:.1f} CPU s so far\n{body}{printed}", flush=True)
            elif kind == "text":
                rows = printed.splitlines()
                for wanted in body.splitlines():
                    if wanted.strip() != "..." and not any(fits(wanted, row, float(rest[0])) for row in rows):
                        wrong.append(f"{page.name}:{line}: not printed: {wanted}\n  but:\n" + "\n".join(f"    {row}" for row in rows))
            else:
                wrong.append(f"{page.name}:{line}: a block of no known kind: '{info}'")
        for target, origin in re.findall(r'!\[[^]]*\]\((\S+) "([^"]*)"\)', text):
            if not (place / origin).is_file():
                wrong.append(f"{page.name}: {origin} was not drawn")
            elif "--pictures" in sys.argv:
                sys.path.insert(0, str(page.parents[2] / "bench"))
                from gallery import small
                (page.parent / target).parent.mkdir(exist_ok=True)
                small(place / origin, page.parent / target)
            elif not (page.parent / target).is_file():
                wrong.append(f"{page.name}: {target} is missing")
    if wrong:
        raise SystemExit("\n".join(wrong))


if __name__ == "__main__":
    main()
