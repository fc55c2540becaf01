#!/usr/bin/python3
"""Serves one page that shows runs, finished or in progress, to a browser on this machine: `poretwin view [RUN...]`.

Uses only the standard library. A request names a run by its number and a file of a fixed list, never a path.
"""
import argparse
import hmac
import html
import http.server
import ipaddress
import json
import mimetypes
import os
import pathlib
import re
import secrets
import signal
import socket
import sys
import threading
import urllib.parse

import build
import references
import runs
import snapshot

FIRST_PORT, PORTS = 8470, 20  # tried in this order, so that links remain valid from one start to the next
LONGEST = 1 << 23  # bytes of a file in one answer
CONNECTIONS = 64
BAD_FILES = 5  # exit code of poretwin
SAFE_HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; style-src 'self'; "
                               "img-src 'self' blob: data:; media-src blob:; connect-src 'self'; base-uri 'none'; form-action 'none'; "
                               "frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Embedder-Policy": "require-corp",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "camera=(), microphone=(), geolocation=(), usb=()",
    "Cache-Control": "no-store",
}
RUN_PATH = re.compile(r"/api/runs/([0-9]{1,6})/(status|gauges|references|fluid\.vtkhdf|solid\.vtkhdf)")
RANGE = re.compile(r"bytes=([0-9]{1,15})-([0-9]{1,15})")


class Access:
    """Access control. A token admits one browser; the cookie for which it is exchanged is valid until the server ends."""

    def __init__(self, announce):
        self.announce = announce
        self.lock = threading.Lock()
        self.session = secrets.token_urlsafe(32)
        self.token = secrets.token_urlsafe(32)

    def redeem(self, token):
        with self.lock:
            good = same(token, self.token)
            if good:
                self.token = secrets.token_urlsafe(32)
        if good:
            self.announce("for another browser", self.token)
        return good

    def knows(self, cookie):
        return same(cookie, self.session)


def same(one, other):
    return hmac.compare_digest(one.encode(), other.encode())


def is_address(host):
    try:
        ipaddress.ip_address(host.strip("[]"))
    except ValueError:
        return False
    return True


def is_loopback(host):
    return host == "localhost" or (is_address(host) and ipaddress.ip_address(host.strip("[]")).is_loopback)


class Server(http.server.ThreadingHTTPServer):
    daemon_threads = True
    allow_reuse_address = True

    def __init__(self, address, page, found, case_roots, announce):
        self.address_family = socket.AF_INET6 if ":" in address[0] else socket.AF_INET
        self.files = {f"/{path.relative_to(page).as_posix()}": path for path in page.rglob("*") if path.is_file()}
        self.runs, self.case_roots = found, case_roots
        self.kept = snapshot.Kept()
        self.far = not is_loopback(address[0])
        self.names = {"localhost"} | ({address[0].lower(), socket.gethostname().lower(), socket.getfqdn().lower()} if self.far else set())
        self.places = threading.BoundedSemaphore(CONNECTIONS)
        super().__init__(address, Handler)
        self.cookie = f"poretwin_view_{self.server_address[1]}"  # cookies are not separated by port
        self.access = Access(lambda what, token: announce(what, f"{self.url()}/?token={token}"))

    def url(self):
        host = self.server_address[0]
        return f"http://{f'[{host}]' if ':' in host else host}:{self.server_address[1]}"

    def is_ours(self, host):
        """Whether the Host header is one of this server's. A name that a stranger's name server maps to this machine is refused (DNS rebinding)."""
        name = re.sub(r":\d+$", "", host).lower()
        return name in self.names or is_loopback(name) or (self.far and is_address(name))

    def process_request(self, request, client_address):
        if not self.places.acquire(timeout=5):
            self.shutdown_request(request)
            return
        super().process_request(request, client_address)

    def process_request_thread(self, request, client_address):
        try:
            super().process_request_thread(request, client_address)
        finally:
            self.places.release()

    def handle_error(self, request, client_address):
        if not isinstance(sys.exc_info()[1], (ConnectionError, TimeoutError)):
            super().handle_error(request, client_address)


class Handler(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    server_version, sys_version = "poretwin", ""
    disable_nagle_algorithm = True
    timeout = 60

    def log_message(self, *_):
        pass

    def do_GET(self):
        self.answer(body=True)

    def do_HEAD(self):
        self.answer(body=False)

    def answer(self, body):
        self.with_body = body
        path, _, query = self.path.partition("?")
        # Browsers send exactly one Host header; other numbers of them come from elsewhere.
        hosts = self.headers.get_all("Host", [])
        if len(hosts) != 1 or not self.server.is_ours(hosts[0]):
            return self.say(421, "This name is not of this server", "Open the address that poretwin view printed.")
        if self.headers.get("Sec-Fetch-Site") in ("cross-site", "same-site") and path != "/":
            return self.say(403, "Asked for by another page", "Open the address that poretwin view printed.")
        known = self.server.access.knows(self.cookie())
        token = urllib.parse.parse_qs(query).get("token", [""])[0]
        if path == "/" and token and body:
            if known or self.server.access.redeem(token):
                return self.let_in()
        if not known:
            return self.say(403, "This link has been used, or is not complete",
                            "Every link that poretwin view prints opens one browser. Its newest line has one that is still good.")
        try:
            return self.page(path, query)
        except snapshot.Unreadable as error:
            return self.json({"error": str(error)}, 503)
        except FileNotFoundError:
            return self.json({"error": "the folder of this run is gone"}, 410)
        except OSError as error:
            return self.json({"error": f"the run's files cannot be read: {error.strerror}"}, 503)

    def cookie(self):
        for part in self.headers.get("Cookie", "").split(";"):
            name, _, value = part.strip().partition("=")
            if name == self.server.cookie:
                return value
        return ""

    def let_in(self):
        self.send(303, b"", "text/plain", {
            "Location": "/", "Set-Cookie": f"{self.server.cookie}={self.server.access.session}; Path=/; HttpOnly; SameSite=Strict"})

    def page(self, path, query):
        if path == "/":
            path = "/index.html"
        if path in self.server.files:
            kind = mimetypes.guess_type(path)[0] or "application/octet-stream"
            return self.send(200, self.server.files[path].read_bytes(), kind)
        if path == "/api/runs":
            return self.json([run.name for run in self.server.runs.find()])
        found = RUN_PATH.fullmatch(path)
        if not found or int(found.group(1)) >= len(self.server.runs.known):
            return self.json({"error": "there is nothing here"}, 404)
        run, what = self.server.runs.known[int(found.group(1))], found.group(2)
        if what == "status":
            return self.json(runs.status(run))
        if what == "gauges":
            return self.json(runs.gauges(run, cursor_of(query)))
        if what == "references":
            return self.json(self.references(run, urllib.parse.parse_qs(query).get("gauge", [])))
        return self.piece(run, what)

    def references(self, run, gauges):
        with run.folder() as folder:
            record = runs.record_of(folder)
        return references.references(record, self.server.case_roots, gauges)

    def piece(self, run, name):
        """Bytes of a file as of its last flush. With an If-Match header: as of that flush, or an error (412).

        A HEAD request opens the file: its state is kept, so that all of it can be read however soon the next flush follows.
        """
        asked = RANGE.fullmatch(self.headers.get("Range", ""))
        if self.with_body and not asked:
            return self.json({"error": "ask for a range of bytes"}, 400)
        wanted = self.headers.get("If-Match", "")
        with run.folder() as folder:
            if asked:
                first, last = int(asked.group(1)), int(asked.group(2))
                found = self.server.kept.read(run.name, folder.descriptor, name, wanted.strip('"'), first, max(0, min(last - first + 1, LONGEST)))
            else:
                found = self.server.kept.open(run.name, folder.descriptor, name)
        if found is None:
            return self.json({"error": f"{name}: is not there (yet)"}, 404)
        tag, length = found[:2]
        headers = {"ETag": f'"{tag}"', "Accept-Ranges": "bytes"}
        if wanted and wanted != f'"{tag}"':
            return self.send(412, b"", "text/plain", headers)
        if not asked:
            return self.send(200, b"", "application/octet-stream", headers, length)
        data = found[2]
        if not data:
            return self.send(416, b"", "text/plain", {**headers, "Content-Range": f"bytes */{length}"})
        headers["Content-Range"] = f"bytes {first}-{first + len(data) - 1}/{length}"
        return self.send(206, data, "application/octet-stream", headers)

    def json(self, data, code=200):
        self.send(code, json.dumps(data, allow_nan=False).encode(), "application/json")

    def say(self, code, title, text):
        page = (f'<!doctype html><html lang="en"><meta charset="utf-8"><title>poretwin</title>'
                f"<h1>{html.escape(title)}</h1><p>{html.escape(text)}</p></html>")
        self.send(code, page.encode(), "text/html")

    def send(self, code, body, kind, headers=None, length=None):
        self.send_response(code)
        for name, value in {**SAFE_HEADERS, **(headers or {})}.items():
            self.send_header(name, value)
        self.send_header("Content-Type", f"{kind}; charset=utf-8" if kind.startswith("text/") else kind)
        self.send_header("Content-Length", str(len(body) if length is None else length))
        self.end_headers()
        if self.with_body:
            self.wfile.write(body)


def cursor_of(query):
    """Positions up to which the gauge files have been read: gauges.fluid.csv=1234&.."""
    pairs = urllib.parse.parse_qsl(query)
    return {name: int(at) for name, at in pairs if at.isascii() and at.isdigit() and len(at) < 16}


def say(text):
    print(f"poretwin view: {text}", flush=True)


def fail(message, code):
    print(f"poretwin: {message}", file=sys.stderr)
    sys.exit(code)


def arguments():
    parser = argparse.ArgumentParser(
        prog="poretwin view", description="Shows runs, finished or under way, on a page for this machine's browser.",
        epilog="Prints an address with a token that opens one browser; Ctrl-C ends. Exit codes: 0 ended, 2 bad command line, 5 files or port.")
    parser.add_argument("run", nargs="*", metavar="RUN", help="folder of a run, or a folder with runs below it (default: runs)")
    parser.add_argument("--port", type=int, help=f"port (default: the first free one of {FIRST_PORT} to {FIRST_PORT + PORTS - 1})")
    parser.add_argument("--bind", default="127.0.0.1", metavar="ADDRESS", help="address to listen at (default 127.0.0.1, this machine only)")
    parser.add_argument("--allow-any-address", action="store_true",
                        help="let --bind take an address that other machines reach; nothing is encrypted")
    parser.add_argument("--cases", nargs="+", default=[], type=pathlib.Path, metavar="DIR",
                        help="folders of cases whose references are drawn, beside cases/")
    parser.add_argument("--built", type=pathlib.Path, default=pathlib.Path("build/view"), help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.port is not None and not 0 <= options.port < 65536:
        parser.error(f"--port: expected 0 to 65535, found {options.port}")
    if not options.bind.isascii() or not (is_loopback(options.bind) or options.allow_any_address):
        parser.error(f"--bind {options.bind}: other machines reach that address, and nothing is encrypted; expected a loopback address, "
                     "or --allow-any-address on a network you trust")
    return options


def find_runs(folders):
    for folder in folders:
        if not os.path.isdir(folder):
            fail(f"{folder}: {'is a file' if os.path.exists(folder) else 'no such folder'}; expected the folder of a run, "
                 "such as runs/terzaghi, or one with runs below it", BAD_FILES)
    found = runs.Runs(folders)
    for folder, root in zip(folders, found.roots):
        if next(runs.below(root), None) is None:
            fail(f"{folder}: holds no run: expected {', '.join(runs.MARKS[:-1])} or {runs.MARKS[-1]} in it or in a folder below; "
                 "`poretwin run CASE` makes one", BAD_FILES)
    found.find()
    return found


def listen(options, *rest):
    ports = [options.port] if options.port is not None else range(FIRST_PORT, FIRST_PORT + PORTS)
    for port in ports:
        try:
            return Server((options.bind, port), *rest)
        except OSError as error:
            last = error
    fail(f"{options.bind}: port {ports[0]}{'' if len(ports) == 1 else f' to {ports[-1]}'}: {last.strerror or last}; "
         "choose another with --port (0: any free one)", BAD_FILES)


def main():
    options = arguments()
    found = find_runs(options.run or ["runs"])
    try:
        page = build.page(options.built, say)
    except build.CannotBuild as error:
        fail(f"view: {error}", BAD_FILES)
    except OSError as error:
        fail(f"view: {options.built}: the page cannot be built: {error}", BAD_FILES)
    source = pathlib.Path(__file__).resolve().parent.parent
    case_roots = [path.resolve() for path in [pathlib.Path("cases"), source / "cases", *options.cases] if path.is_dir()]
    server = listen(options, page, found, case_roots, lambda what, url: say(f"{what}: {url}"))
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: threading.Thread(target=server.shutdown).start())
    say(f"{len(found.known)} run{'s' if len(found.known) != 1 else ''}; Ctrl-C ends")
    if server.far:
        say("warning: whoever reaches this address can read what goes over it; an ssh tunnel to a loopback address is safer")
    say(f"open {server.url()}/?token={server.access.token}")
    server.serve_forever(poll_interval=0.1)
    server.server_close()
    say("ended")


if __name__ == "__main__":
    main()
