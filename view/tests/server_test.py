#!/usr/bin/python3
"""The server of `poretwin view`: access, readable files, and that a file which is being written is read as of its last flush."""
import fcntl
import http.client
import json
import os
import pathlib
import re
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import unittest.mock

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
import build  # noqa: E402
import references  # noqa: E402
import runs  # noqa: E402
import server  # noqa: E402
import snapshot  # noqa: E402

RUN_FILE = 'case = "<b>case</b>"\ncase_file = "/nowhere/case.toml"\nstarted = "2026-01-01T00:00:00Z"\n'


def make_run(folder, ended=True):
    (folder / "log").mkdir(parents=True)
    (folder / "run.toml").write_text(RUN_FILE + ('ended = "2026-01-01T00:00:09Z"\nexit = 0\nreason = ""\nwall_s = 9.0\n' if ended else ""))
    (folder / "fluid.vtkhdf").write_bytes(bytes(range(256)) * 64)
    (folder / "gauges.fluid.csv").write_text("time_s,gauge,value,unit\n0,level,1.5,m\n1,level,nan,m\n2,\"<i>x,y</i>\",3,Pa\n2,lev")
    (folder / "log" / "coupler.log").write_text("[10:00:00] coupler: hello\n[10:00:01] coupler: error: <script>alert(1)</script>\n")


class Served(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.place = pathlib.Path(tempfile.mkdtemp())
        make_run(cls.place / "runs" / "one")
        make_run(cls.place / "runs" / "deep" / "<img src=x>", ended=False)
        (cls.place / "secret.txt").write_text("secret")
        page = cls.place / "page"
        page.mkdir()
        (page / "index.html").write_text("<!doctype html>page")
        (page / "worker.js").write_text("1")
        cls.links = []
        cls.server = server.Server(("127.0.0.1", 0), page, found(cls.place / "runs"), [], lambda what, url: cls.links.append(url))
        cls.thread = threading.Thread(target=cls.server.serve_forever, kwargs={"poll_interval": 0.05})
        cls.thread.start()

    @classmethod
    def tearDownClass(cls):
        cls.server.shutdown()
        cls.thread.join()
        cls.server.server_close()
        shutil.rmtree(cls.place)

    def ask(self, path, headers=None, method="GET", known=True, host="127.0.0.1"):
        connection = http.client.HTTPConnection("127.0.0.1", self.server.server_address[1], timeout=10)
        connection.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
        sent = {"Host": f"{host}:{self.server.server_address[1]}"} if host else {}
        if known:
            sent["Cookie"] = f"other=1; {self.server.cookie}={self.server.access.session}"
        for name, value in {**sent, **(headers or {})}.items():
            connection.putheader(name, value)
        connection.endheaders()
        answer = connection.getresponse()
        answer.body = answer.read()
        connection.close()
        return answer

    def number_of(self, name):
        return json.loads(self.ask("/api/runs").body).index(name)

    def test_a_stranger_gets_nothing(self):
        for path in ("/", "/index.html", "/worker.js", "/api/runs", "/api/runs/0/status", "/api/runs/0/fluid.vtkhdf", "/?token=x", "/?token="):
            answer = self.ask(path, known=False)
            self.assertEqual(answer.status, 403, path)
            self.assertNotIn(b"case", answer.body)

    def test_a_token_opens_one_browser(self):
        token = self.server.access.token
        first = self.ask(f"/?token={token}", known=False)
        self.assertEqual(first.status, 303)
        cookie = first.getheader("Set-Cookie")
        self.assertIn("HttpOnly; SameSite=Strict", cookie)
        self.assertEqual(self.ask(f"/?token={token}", known=False).status, 403)
        self.assertEqual(self.ask("/", {"Cookie": cookie.partition(";")[0]}, known=False).status, 200)
        self.assertIn(self.server.access.token, self.links[-1])
        # A browser that has already been admitted only continues.
        before = self.server.access.token
        self.assertEqual(self.ask("/?token=old").status, 303)
        self.assertEqual(self.server.access.token, before)

    def test_a_look_ahead_does_not_use_the_token_up(self):
        token = self.server.access.token
        self.assertEqual(self.ask(f"/?token={token}", known=False, method="HEAD").status, 403)
        self.assertEqual(self.server.access.token, token)

    def test_other_names_of_this_machine_are_refused(self):
        for host in ("evil.example", "127.0.0.1.evil.example", "", "localhost.evil.example", "[::2]", "10.0.0.1"):
            self.assertEqual(self.ask("/", host=host).status, 421, host)
        for host in ("localhost", "127.0.0.1", "[::1]"):
            self.assertEqual(self.ask("/", host=host).status, 200, host)

    def test_other_pages_are_refused(self):
        for site in ("cross-site", "same-site"):
            self.assertEqual(self.ask("/api/runs", {"Sec-Fetch-Site": site}).status, 403)
        self.assertEqual(self.ask("/api/runs", {"Sec-Fetch-Site": "same-origin"}).status, 200)

    def test_nothing_but_the_runs_can_be_named(self):
        for path in ("/../secret.txt", "/..%2fsecret.txt", "/%2e%2e/secret.txt", "//etc/passwd", "/api/runs/0/../../secret.txt", "/api/runs/0/run.toml",
                     "/api/runs/0/log/coupler.log", "/api/runs/-1/status", "/api/runs/99/status", "/api/runs/0/fluid.vtkhdf/..", "/api/runs/00000000/status",
                     "/api/runs/%31/status", "/server.py", "/worker.js/", "/api/runs/0/fluid.vtkhdf.undo"):
            answer = self.ask(path)
            self.assertEqual(answer.status, 404, path)
            self.assertNotIn(b"secret", answer.body)

    def test_links_are_not_followed(self):
        folder = self.place / "runs" / "linked"
        make_run(folder)
        (folder / "solid.vtkhdf").symlink_to(self.place / "secret.txt")
        (self.place / "runs" / "outside").symlink_to(self.place)
        names = json.loads(self.ask("/api/runs").body)
        self.assertNotIn("runs/outside", names)
        number = self.number_of("runs/linked")
        answer = self.ask(f"/api/runs/{number}/solid.vtkhdf", {"Range": "bytes=0-3"})
        self.assertEqual(answer.status, 503)
        self.assertIn("symbolic link", json.loads(answer.body)["error"])
        (folder / "log" / "coupler.log").unlink()
        (folder / "log" / "coupler.log").symlink_to(self.place / "secret.txt")
        self.assertEqual(self.ask(f"/api/runs/{number}/status").status, 503)
        # The folder becomes a symbolic link after it was found.
        shutil.move(folder, self.place / "elsewhere")
        folder.symlink_to(self.place / "elsewhere")
        self.assertEqual(self.ask(f"/api/runs/{number}/status").status, 503)
        folder.unlink()
        self.assertEqual(self.ask(f"/api/runs/{number}/status").status, 410)

    def test_a_pipe_is_no_file(self):
        folder = self.place / "runs" / "pipe"
        make_run(folder)
        os.mkfifo(folder / "solid.vtkhdf")
        answer = self.ask(f"/api/runs/{self.number_of('runs/pipe')}/solid.vtkhdf", {"Range": "bytes=0-3"})
        self.assertEqual(answer.status, 503)

    def test_every_answer_has_strict_headers(self):
        for path, known in (("/", True), ("/api/runs", True), ("/nothing", True), ("/", False), ("/worker.js", True)):
            answer = self.ask(path, known=known)
            policy = answer.getheader("Content-Security-Policy")
            self.assertTrue(policy.startswith("default-src 'none'"))
            self.assertNotIn("unsafe-inline", policy)
            self.assertIn("frame-ancestors 'none'", policy)
            self.assertEqual(answer.getheader("X-Content-Type-Options"), "nosniff")
            self.assertEqual(answer.getheader("Cache-Control"), "no-store")
            self.assertEqual(answer.getheader("Referrer-Policy"), "no-referrer")
            self.assertIsNone(answer.getheader("Access-Control-Allow-Origin"))
            self.assertNotIn("Python", answer.getheader("Server"))
        self.assertIn("javascript", self.ask("/worker.js").getheader("Content-Type"))

    def test_only_reading(self):
        for method in ("POST", "PUT", "DELETE", "OPTIONS", "TRACE"):
            self.assertEqual(self.ask("/api/runs", method=method).status, 501, method)

    def test_ranges(self):
        number = self.number_of("runs/one")
        path = f"/api/runs/{number}/fluid.vtkhdf"
        head = self.ask(path, method="HEAD")
        self.assertEqual((head.status, head.getheader("Content-Length"), head.body), (200, "16384", b""))
        tag = head.getheader("ETag")
        answer = self.ask(path, {"Range": "bytes=254-257", "If-Match": tag})
        self.assertEqual((answer.status, answer.body, answer.getheader("Content-Range")), (206, b"\xfe\xff\x00\x01", "bytes 254-257/16384"))
        self.assertEqual(self.ask(path, {"Range": "bytes=16380-99999"}).body, b"\xfc\xfd\xfe\xff")
        self.assertEqual(self.ask(path, {"Range": "bytes=16384-16390"}).status, 416)
        self.assertEqual(self.ask(path, {"Range": "bytes=9-3"}).status, 416)
        self.assertEqual(self.ask(path, {"Range": "bytes=0-3", "If-Match": '"other"'}).status, 412)
        for bad in ("bytes=-5", "bytes=1-", "bytes=a-b", "lines=0-3", "bytes=0-1,4-5", "bytes=0-99999999999999999999"):
            self.assertEqual(self.ask(path, {"Range": bad}).status, 400, bad)
        self.assertEqual(self.ask(path).status, 400)
        self.assertEqual(self.ask(f"/api/runs/{number}/solid.vtkhdf", {"Range": "bytes=0-3"}).status, 404)

    def test_names_with_markup_stay_data(self):
        number = self.number_of("runs/deep/<img src=x>")
        answer = self.ask(f"/api/runs/{number}/status")
        self.assertEqual(answer.getheader("Content-Type"), "application/json")
        status = json.loads(answer.body)
        self.assertEqual((status["case"], status["state"]), ("<b>case</b>", "broken off"))
        self.assertEqual(status["messages"], [{"kind": "error", "time": "10:00:01", "text": "coupler: error: <script>alert(1)</script>"}])

    def test_gauges_come_in_whole_lines(self):
        folder = self.place / "runs" / "growing"
        make_run(folder)
        path = f"/api/runs/{self.number_of('runs/growing')}/gauges"
        first = json.loads(self.ask(path).body)
        self.assertEqual(first["series"]["level"], {"unit": "m", "time": [0.0, 1.0], "value": [1.5, None]})
        self.assertEqual(first["series"]["<i>x,y</i>"]["value"], [3.0])
        with open(folder / "gauges.fluid.csv", "a") as stream:
            stream.write("el,7,m\n")
        on = json.loads(self.ask(f"{path}?gauges.fluid.csv={first['cursor']['gauges.fluid.csv']}").body)
        self.assertEqual(on["series"], {"level": {"unit": "m", "time": [2.0], "value": [7.0]}})
        # The file is shorter than the cursor, after a return to a checkpoint: it is read from the beginning.
        again = json.loads(self.ask(f"{path}?gauges.fluid.csv=999999").body)
        self.assertEqual(len(again["series"]["level"]["time"]), 3)
        for bad in ("-4", "x", "9" * 40, "%D9%A1"):
            self.assertEqual(self.ask(f"{path}?gauges.fluid.csv={bad}").status, 200)

    def test_broken_records_are_no_failure(self):
        folder = self.place / "runs" / "odd"
        make_run(folder)
        (folder / "run.toml").write_bytes(b'case = "\xff\xfe\nexit = = 3')
        (folder / "fluid.summary.json").write_text("[1, 2")
        (folder / "progress.json").write_text('"t"')
        number = self.number_of("runs/odd")
        self.assertEqual(json.loads(self.ask(f"/api/runs/{number}/status").body)["state"], "unknown")

    def test_a_run_under_way(self):
        folder = self.place / "runs" / "live"
        make_run(folder, ended=False)
        (folder / "progress.json").write_text('{"t": 1.5, "end": 3, "step": 7, "dt": 0.1, "waiting_for": "solid"}\n')
        number = self.number_of("runs/live")
        with open(folder / "run.lock", "w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            status = json.loads(self.ask(f"/api/runs/{number}/status").body)
            self.assertEqual((status["state"], status["progress"]["waiting_for"], status["progress"]["t"]), ("running", "solid", 1.5))
        status = json.loads(self.ask(f"/api/runs/{number}/status").body)
        self.assertEqual((status["state"], status["progress"]), ("broken off", {}))

    def test_many_at_once(self):
        number = self.number_of("runs/one")
        results = []

        def many():
            for _ in range(10):
                results.append(self.ask(f"/api/runs/{number}/fluid.vtkhdf", {"Range": "bytes=0-999"}).body == (bytes(range(256)) * 4)[:1000])

        threads = [threading.Thread(target=many) for _ in range(20)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(results, [True] * 200)


def found(folder):
    result = runs.Runs([folder])
    result.find()
    return result


class TheLastFlush(unittest.TestCase):
    """Files in the states in which common/output/undo_driver.cpp leaves them during a write."""

    def setUp(self):
        self.place = pathlib.Path(tempfile.mkdtemp())
        self.file, self.undo = self.place / "f", self.place / "f.undo"
        self.folder = os.open(self.place, os.O_RDONLY)
        self.file.write_bytes(b"0123456789")

    def tearDown(self):
        os.close(self.folder)
        shutil.rmtree(self.place)

    def read(self):
        return snapshot.read(self.folder, "f", 0, 1000)

    def test_every_step_of_a_write_reads_the_same(self):
        stamp = 1_700_000_000_123_456_789
        self.undo.write_bytes(b"")
        os.utime(self.undo, ns=(stamp, stamp))
        at_rest = self.read()
        self.assertEqual(at_rest[1:], (10, b"0123456789"))
        journal = struct.pack("<QQQ", 10, stamp, 0)
        self.undo.write_bytes(journal)
        self.assertEqual(self.read(), at_rest)
        journal += struct.pack("<QQ", 2, 3) + b"234"
        self.undo.write_bytes(journal[:-1])  # an incomplete piece: the file has not been changed there
        self.assertEqual(self.read(), at_rest)
        self.undo.write_bytes(journal)
        self.file.write_bytes(b"01abc56789" + b"new at the end")
        self.assertEqual(self.read(), at_rest)
        journal += struct.pack("<QQ", 3, 2) + b"bc"  # the same place written twice: the older copy is right
        self.undo.write_bytes(journal)
        self.file.write_bytes(b"01aXY56789" + b"new at the end")
        self.assertEqual(self.read(), at_rest)
        journal += struct.pack("<QQ", 8, 2) + b"89"
        self.undo.write_bytes(journal)
        self.file.write_bytes(b"01aXY567")  # cut off
        self.assertEqual(self.read(), at_rest)
        self.assertEqual(snapshot.read(self.folder, "f", 3, 4)[2], b"3456")
        self.file.write_bytes(b"whole")
        self.undo.write_bytes(b"")
        after = self.read()
        self.assertEqual(after[1:], (5, b"whole"))
        self.assertNotEqual(after[0], at_rest[0])

    def test_a_header_on_its_way_is_waited_for(self):
        self.undo.write_bytes(struct.pack("<Q", 10))
        threading.Timer(0.1, lambda: self.undo.write_bytes(struct.pack("<QQQ", 10, 5, 0))).start()
        self.assertEqual(self.read()[1:], (10, b"0123456789"))

    def test_a_journal_without_stamps_reads_as_well(self):
        self.undo.write_bytes(struct.pack("<Q", 10) + struct.pack("<QQ", 0, 2) + b"01")
        self.file.write_bytes(b"ab23456789")
        self.assertEqual(self.read()[2], b"0123456789")

    def test_an_opened_file_can_be_read_after_the_next_flush(self):
        self.undo.write_bytes(b"")
        kept = snapshot.Kept()
        tag, length = kept.open("run", self.folder, "f")
        self.file.write_bytes(b"ab23456789")
        os.utime(self.undo, ns=(1, 1))
        self.assertEqual((length, kept.read("run", self.folder, "f", tag, 1, 3)), (10, (tag, 10, b"123")))
        later = kept.read("another run", self.folder, "f", tag, 1, 3)
        self.assertNotEqual(later[0], tag)
        self.assertEqual(later[2], b"b23")

    def test_only_files_that_are_being_written_are_kept(self):
        kept = snapshot.Kept()
        kept.open("run", self.folder, "f")
        self.assertEqual(len(kept.files), 0)
        self.undo.write_bytes(b"")
        kept.open("run", self.folder, "f")
        self.assertEqual(len(kept.files), 1)
        with unittest.mock.patch.object(snapshot, "being_written", side_effect=AssertionError("a state is kept once")):
            kept.open("run", self.folder, "f")

    def test_what_is_kept_has_a_limit(self):
        self.undo.write_bytes(b"")
        kept = snapshot.Kept()
        with unittest.mock.patch.object(snapshot, "MOST_KEPT", 25):
            tags = []
            for stamp in (1, 2, 3):
                os.utime(self.undo, ns=(stamp, stamp))
                tags.append(kept.open("run", self.folder, "f")[0])
        self.assertEqual([tag for _, _, tag in kept.files], tags[1:])
        with unittest.mock.patch.object(snapshot, "LARGEST_KEPT", 9):
            os.utime(self.undo, ns=(4, 4))
            kept.open("run", self.folder, "f")
        self.assertEqual([tag for _, _, tag in kept.files], tags[1:])


class WhileARealRunWrites(unittest.TestCase):
    """Repeated reads during a run that flushes all the time: each gives one consistent state."""

    @unittest.skipUnless(os.environ.get("PORETWIN"), "needs the program")
    def test_every_look_is_a_whole_file(self):
        import h5py  # a package of the tests, as for the pictures
        place = pathlib.Path(tempfile.mkdtemp())
        command = [os.environ["PORETWIN"], "run", str(HERE.parent.parent / "cases" / "dam_break"), "--out", str(place / "run"), "--until", "0.1", "--quiet",
                   "--no-pictures", "--set", "output.interval=0.0005", "--set", "fluid.particle_spacing=0.05"]
        writer = subprocess.Popen(command)
        try:
            looks, frames, torn, late = 0, 0, 0, 0
            while writer.poll() is None:
                if not (place / "run").is_dir():
                    continue
                folder = os.open(place / "run", os.O_RDONLY)
                try:
                    look = snapshot.read(folder, "fluid.vtkhdf", 0, 1 << 28)
                except snapshot.Unreadable:  # on a busy machine: the reader is stopped during every look
                    late += 1
                    continue
                finally:
                    os.close(folder)
                if look is None or len(look[2]) < 2048:
                    continue  # the library flushes once when it makes a file, before any content
                (place / "copy.h5").write_bytes(look[2])
                try:
                    with h5py.File(place / "copy.h5") as file:
                        steps = int(file["VTKHDF/Steps"].attrs["NSteps"])
                        for step in range(max(0, steps - 2), steps):
                            first, count = file["VTKHDF/Steps/PointOffsets"][step], file["VTKHDF/NumberOfPoints"][step]
                            torn += len(file["VTKHDF/PointData/velocity"][first : first + count]) != count
                            torn += not (abs(file["VTKHDF/Points"][first : first + count]) < 100).all()
                        torn += steps < frames
                        frames = steps
                except OSError:
                    torn += 1
                looks += 1
            self.assertEqual(writer.wait(), 0)
            self.assertEqual(torn, 0)
            self.assertGreater(looks, max(20, late))
            self.assertGreater(frames, 50)
        finally:
            writer.kill()
            writer.wait()
            shutil.rmtree(place)


class References(unittest.TestCase):
    def setUp(self):
        self.place = pathlib.Path(tempfile.mkdtemp()).resolve()
        self.case = self.place / "cases" / "thing"
        (self.case / "reference").mkdir(parents=True)
        (self.case / "case.toml").write_text("")
        (self.case / "reference" / "other.csv").write_text("# t, v\nt_s,v\n1,2\n3,4\n")
        (self.case / "verify.toml").write_text("""
            [[run]]
            name = "a"
            set = ["case.end_time=5"]
            [[run]]
            name = "b"
            set = ["soil.0.porosity=0.3"]
            [[metric]]
            name = "early"
            op = "value"
            gauge = "g"
            at = 2
            scale = 2
            reference = 8
            tolerance = 0.2
            [[metric]]
            name = "late"
            op = "relative"
            gauge = "g"
            reference = 10
            tolerance = 0.1
            [[metric]]
            name = "of another soil"
            run = "b"
            op = "value"
            gauge = "g"
            at = 2
            reference = 99
            [[metric]]
            name = "outside"
            op = "curve"
            gauge = "g"
            reference_csv = "../../secret.csv"
            """)
        (self.place / "secret.csv").write_text("1,2\n")

    def tearDown(self):
        shutil.rmtree(self.place)

    def marks(self, overrides, root=None):
        record = {"case_file": str(self.case / "case.toml"), "overrides": overrides}
        return [(m["gauge"], m["time"], m["value"], m["value_error"]) for m in references.references(record, [root or self.place / "cases"], ["g", "other"])]

    def test_what_a_whole_run_should_read(self):
        self.assertEqual(self.marks(["case.end_time=5"]), [("g", 2, 4.0, 0.1), ("g", None, 10.0, 1.0), ("other", 1.0, 2.0, 0.0), ("other", 3.0, 4.0, 0.0)])

    def test_a_shorter_run_has_no_last_reading(self):
        self.assertEqual(self.marks(["case.end_time=3"])[:2], [("g", 2, 4.0, 0.1), ("other", 1.0, 2.0, 0.0)])

    def test_another_soil_has_other_references(self):
        self.assertEqual(self.marks(["soil.0.porosity=0.3"])[0], ("g", 2, 99.0, 0.0))

    def test_a_run_does_not_choose_what_is_read(self):
        self.assertEqual(self.marks([], root=self.place / "others"), [])


class Command(unittest.TestCase):
    """The command `poretwin view`."""

    def setUp(self):
        self.place = pathlib.Path(tempfile.mkdtemp())
        make_run(self.place / "run")
        # A page that need not be built.
        self.built = self.place / "built"
        (self.built / "page").mkdir(parents=True)
        (self.built / "page" / "index.html").write_text("page")
        (self.built / "page.stamp").write_text(build.fingerprint())

    def tearDown(self):
        shutil.rmtree(self.place)

    def start(self, *options, **how):
        return subprocess.Popen([sys.executable, str(HERE.parent / "server.py"), "--built", str(self.built), *options], cwd=self.place, text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE, **how)

    def fails(self, *options, **how):
        process = self.start(*options, **how)
        _, error = process.communicate(timeout=20)
        return process.returncode, error

    def test_wrong_folders(self):
        (self.place / "empty").mkdir()
        for folder, words in (("nothing", "no such folder"), ("empty", "holds no run"), ("run/run.toml", "is a file")):
            code, error = self.fails(folder)
            self.assertEqual(code, 5)
            self.assertIn(words, error)
            self.assertIn(folder, error)

    def test_wrong_options(self):
        for options in (["run", "--port", "70000"], ["run", "--prt", "1"], ["run", "--bind", "0.0.0.0"], ["run", "--bind", "evil.example"]):
            self.assertEqual(self.fails(*options)[0], 2, options)
        self.assertIn("--allow-any-address", self.fails("run", "--bind", "0.0.0.0")[1])

    def test_a_port_in_use(self):
        with socket.socket() as other:
            other.bind(("127.0.0.1", 0))
            other.listen()
            port = other.getsockname()[1]
            code, error = self.fails("run", "--port", str(port))
        self.assertEqual(code, 5)
        self.assertIn(f"port {port}: Address already in use; choose another with --port", error)

    def test_without_node(self):
        (self.built / "page.stamp").write_text("older")
        tools = self.place / "bin"
        tools.mkdir()
        code, error = self.fails("run", env={"PATH": str(tools)})
        self.assertEqual(code, 5)
        self.assertIn("the commands node and npm, not found in PATH; install the packages nodejs and npm", error)

    def test_serves_until_it_is_stopped(self):
        for number in (signal.SIGINT, signal.SIGTERM):
            process = self.start("run", "--port", "0")
            lines = [process.stdout.readline(), process.stdout.readline()]
            self.assertIn("1 run; Ctrl-C ends", lines[0])
            port, token = re.fullmatch(r"poretwin view: open http://127\.0\.0\.1:(\d+)/\?token=([\w-]{43})\n", lines[1]).groups()
            connection = http.client.HTTPConnection("127.0.0.1", int(port), timeout=10)
            connection.request("GET", f"/?token={token}")
            self.assertEqual(connection.getresponse().status, 303)
            connection.close()
            start = time.monotonic()
            process.send_signal(number)
            out, error = process.communicate(timeout=10)
            self.assertEqual((process.returncode, error), (0, ""))
            self.assertIn("ended", out)
            self.assertLess(time.monotonic() - start, 3)


if __name__ == "__main__":
    unittest.main()
