"""Builds the page from view/page with Debian's nodejs and npm, on first use and whenever its sources change."""
import fcntl
import hashlib
import os
import pathlib
import shutil
import subprocess
import sys

SOURCE = pathlib.Path(__file__).resolve().parent / "page"


class CannotBuild(Exception):
    """The page cannot be built; the message says what is missing and what to do."""


def sources():
    return sorted(path for path in SOURCE.rglob("*") if path.is_file() and "node_modules" not in path.parts)


def fingerprint():
    digest = hashlib.sha256()
    for path in sources():
        digest.update(str(path.relative_to(SOURCE)).encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()


def install_node(say):
    """Installs Debian's packages of the commands that are missing, where that is possible."""
    missing = [command for command in ("node", "npm") if shutil.which(command) is None]
    if not missing:
        return
    packages = ["nodejs" if command == "node" else command for command in missing]
    wanted = (f"the page is built with the command{'s' if len(missing) > 1 else ''} {' and '.join(missing)}, not found in PATH; "
              f"install the package{'s' if len(packages) > 1 else ''} {' and '.join(packages)}")
    root = [] if os.geteuid() == 0 else [shutil.which("sudo")]
    if None in root or shutil.which("apt-get") is None:
        raise CannotBuild(f"{wanted}: apt-get install {' '.join(packages)} (as root)")
    say(f"installing {' '.join(packages)}")
    for step in (["apt-get", "update"], ["apt-get", "install", "-y", "--no-install-recommends", *packages]):
        if subprocess.run([*root, "env", "DEBIAN_FRONTEND=noninteractive", *step], stdout=subprocess.DEVNULL).returncode:
            raise CannotBuild(f"{wanted}: `{' '.join(step)}` failed")


def run(command, folder, what, lock):
    # The command inherits the lock: if it outlives this process, killed, it keeps the next one waiting.
    done = subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, pass_fds=[lock.fileno()])
    if done.returncode:
        raise CannotBuild(f"{what} failed in {folder}:\n{done.stdout.strip()[-2000:]}\n"
                          "Fetching the page's packages needs the network once; afterwards none is needed.")


def page(built, say):
    """Builds the page where necessary; returns its folder, below `built`."""
    built.mkdir(parents=True, exist_ok=True)
    target, stamp = built / "page", built / "page.stamp"
    with open(built / "build.lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # two builds at a time would overwrite each other's files
        wanted = fingerprint()
        if target.is_dir() and stamp.exists() and stamp.read_text() == wanted:
            return target
        install_node(say)
        work = built / "work"
        say("building the page (once)")
        copy_sources(work)
        run(["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund"], work, "npm ci", lock)
        run(["npx", "--no-install", "vite", "build", "--outDir", "dist", "--emptyOutDir"], work, "vite build", lock)
        stamp.unlink(missing_ok=True)
        shutil.rmtree(target, ignore_errors=True)
        (work / "dist").rename(target)
        stamp.write_text(wanted)
    return target


def main():
    """Builds the page as a step of the tests: build.py FOLDER."""
    try:
        print(page(pathlib.Path(sys.argv[1]), print))
    except CannotBuild as error:
        sys.exit(str(error))


def copy_sources(work):
    if work.exists():
        for path in work.iterdir():
            if path.name != "node_modules":
                shutil.rmtree(path) if path.is_dir() else path.unlink()
    for path in sources():
        copy = work / path.relative_to(SOURCE)
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, copy)


if __name__ == "__main__":
    main()
