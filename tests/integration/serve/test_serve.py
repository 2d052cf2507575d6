"""usage: test_serve.py PLUMBLINE     What `plumbline serve` answers, and what it must not."""
import json
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

PLUMBLINE = os.path.abspath(sys.argv.pop(1))


class Served(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        work = cls.work = pathlib.Path(cls.temporary.name)
        cls.environment = dict(os.environ, PLUMBLINE_STORE=str(work / "store"), XDG_CACHE_HOME=str(work / "cache"))
        (work / "secret.txt").write_text("secret")
        (work / "points.csv").write_text("name,x,y,z,sigma\nA,1,2,3,0.001\nB,4,5,6,0.001\n")
        (work / "p.yaml").write_text("plumbline: 1\nvars: {file: points.csv}\nnodes:\n  points: {use: read.points, with: {file: \"${file}\"}}\noutputs: {points.json: points.points}\n")
        (work / "other.csv").write_text("name,x,y,z,sigma\nA,1,2,3.5,0.001\nB,4,5,6,0.001\n")
        for out, file in (("one", "points.csv"), ("two", "other.csv")):
            subprocess.run([PLUMBLINE, "run", "p.yaml", "file=" + file, "--out", "out/" + out, "-q"], cwd=work, env=cls.environment, check=True)
        out = cls.out = work / "out"
        (out / "one/page.html").write_text("<script>1</script>")
        (out / "one/Turm Süd.txt").write_text("umlaut")
        (out / "one/.hidden").write_text("secret")
        (out / "one/link.txt").symlink_to(work / "secret.txt")
        (out / "one/up").symlink_to(work)
        (out / "linked").symlink_to(out / "one")
        os.mkfifo(out / "one/pipe")
        # A record that is none, and what it says as markup.
        (out / "odd").mkdir()
        (out / "odd/run.jsonl").write_text('{"event":"run_start","pipeline":"<img src=x>","time":7}\n{"event":"node","name":[]}\nnonsense\n')
        cls.start()

    @classmethod
    def start(cls):
        cls.server = subprocess.Popen([PLUMBLINE, "serve", "out"], cwd=cls.work, env=cls.environment, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        cls.address = cls.server.stdout.readline().strip()
        cls.port = int(cls.address.split(":")[2].split("/")[0])
        cls.token = cls.address.split("token=")[1]

    @classmethod
    def tearDownClass(cls):
        cls.server.send_signal(signal.SIGINT)
        assert cls.server.wait(10) == 130
        cls.server.stdout.close()
        cls.temporary.cleanup()

    def raw(self, data, timeout=8):
        with socket.create_connection(("127.0.0.1", self.port), timeout=timeout) as connection:
            connection.sendall(data)
            answer = b""
            while part := connection.recv(65536):
                answer += part
        return answer

    def ask(self, path, host=None, token=True, more=(), method="GET"):
        lines = [f"{method} {path} HTTP/1.1", f"Host: {host or f'127.0.0.1:{self.port}'}", *more]
        if token:
            lines.append(f"Authorization: Bearer {self.token}")
        head, _, body = self.raw(("\r\n".join(lines) + "\r\n\r\n").encode()).partition(b"\r\n\r\n")
        return int(head.split()[1]), head.decode(), body

    def test_the_token_is_asked_for_and_leaves_the_address(self):
        self.assertEqual(self.ask("/", token=False)[0], 401)
        self.assertEqual(self.ask("/?token=0" + self.token[1:] if self.token[0] != "0" else "/?token=1" + self.token[1:], token=False)[0], 401)
        self.assertEqual(self.ask("/api/runs", token=False, more=["Cookie: plumbline_1=" + self.token])[0], 401)
        self.assertEqual(self.ask("/api/runs", token=False, more=["Authorization: Bearer"])[0], 401)
        status, head, _ = self.ask("/?token=" + self.token, token=False)
        self.assertEqual(status, 303)
        self.assertIn("Location: /\r\n", head)
        self.assertIn("HttpOnly; SameSite=Lax", head)
        cookie = head.split("Set-Cookie: ")[1].split(";")[0]
        self.assertEqual(self.ask("/api/runs", token=False, more=["Cookie: a=b; " + cookie])[0], 200)

    def test_another_name_that_points_here_gets_nothing(self):
        for host in ("evil.example", f"evil.example:{self.port}", "127.0.0.1", f"127.0.0.1.evil.example:{self.port}", f"localhost.evil:{self.port}", "[::1]:1", ""):
            self.assertEqual(self.ask("/api/runs", host=host or " ")[0], 421, host)
        self.assertEqual(self.ask("/api/runs", host=f"localhost:{self.port}")[0], 200)
        self.assertEqual(self.raw(f"GET / HTTP/1.1\r\nAuthorization: Bearer {self.token}\r\n\r\n".encode()).split()[1], b"421")

    def test_runs_their_nodes_artifacts_and_differences(self):
        listed = json.loads(self.ask("/api/runs")[2])["runs"]
        by_id = {r["id"]: r for r in listed}
        self.assertLessEqual({"one", "two", "odd"}, set(by_id))
        self.assertNotIn("linked", by_id)
        self.assertEqual((by_id["one"]["status"], by_id["one"]["files"]), ("ok", ["points.json"]))
        run = json.loads(self.ask("/api/run?id=one")[2])
        self.assertEqual(run["nodes"][0]["name"], "points")
        self.assertIn('"A"', self.ask("/api/artifact?id=one&node=points&port=points&item=0")[2].decode())
        self.assertEqual(self.ask("/api/artifact?id=one&node=points&port=points&item=7")[0], 404)
        self.assertIn("3.5", self.ask("/api/diff?a=one&b=two")[2].decode())
        self.assertEqual(self.ask("/api/diff?a=one&b=..")[0], 404)
        self.assertEqual(self.ask("/api/run?id=../one")[0], 404)
        status, head, body = self.ask("/files/one/page.html")
        self.assertEqual((status, body), (200, b"<script>1</script>"))
        self.assertIn("Content-Security-Policy: sandbox allow-scripts allow-popups allow-downloads;", head)
        self.assertEqual(self.ask("/files/one/Turm%20S%C3%BCd.txt")[2], b"umlaut")
        status, head, body = self.ask("/files/one/page.html", method="HEAD")
        self.assertEqual((status, body), (200, b""))
        self.assertIn("default-src 'none'", self.ask("/")[1])

    def test_a_record_that_leaves_things_out_or_is_of_any_size_ends_nothing(self):
        out = self.out / "bare"
        out.mkdir()
        start = json.dumps({"event": "run_start", "time": "", "pipeline": "p.yaml"})
        (out / "run.jsonl").write_text(start + '\n{"event":"node","name":"a"}\n{"event":"node","name":"b","outputs":{"p":["0"]}}\n{"event":"node","name":"c","outputs":7}\n{"event":"node","name":"d","outputs":{"p":7}}\n')
        huge = self.out / "huge"
        huge.mkdir()
        with (huge / "run.jsonl").open("w") as record:
            record.write(start + "\n")
            record.truncate(1 << 40)
        for _ in range(2):
            status, _, body = self.ask("/api/runs")
            self.assertEqual(status, 200)
            self.assertLessEqual({"one", "bare", "huge"}, {r["id"] for r in json.loads(body)["runs"]})
        for node in "abcd":
            self.assertIn(self.ask(f"/api/artifact?id=bare&node={node}&port=p&item=0")[0], (404, 500), node)
        self.assertIn("\nVmHWM:", (status := pathlib.Path(f"/proc/{self.server.pid}/status").read_text()))
        self.assertLess(int(status.split("VmHWM:")[1].split()[0]), 600_000, "kB")
        (huge / "run.jsonl").unlink()

    def test_nothing_outside_of_the_folder(self):
        for path in ("../secret.txt", "..%2fsecret.txt", "%2e%2e/secret.txt", "one/../../secret.txt", "one/%2e%2e/%2e%2e/secret.txt", "one/..%5c..%5csecret.txt",
                     "%252e%252e/secret.txt", "/" + str(self.work / "secret.txt"), str(self.work / "secret.txt"), "one/link.txt", "one/up/secret.txt", "linked/page.html",
                     "one/.hidden", "one//page.html", "one/./page.html", "one", "one/", "", "one/pipe", "one/page.html/", "one/page.html%20", "..", "%c0%ae%c0%ae/secret.txt"):
            status, _, body = self.ask("/files/" + path)
            self.assertEqual(status, 404, path)
            self.assertNotIn(b"secret", body, path)
        self.assertEqual(self.ask("/files/one/page.html%00.txt")[0], 400)
        self.assertEqual(self.ask("/files/one/page.html%4")[0], 400)

    def test_what_is_no_request_is_refused_and_bounded(self):
        self.assertEqual(self.ask("/", method="POST")[0], 405)
        self.assertEqual(self.ask("http://127.0.0.1/")[0], 400)
        for bad in (b"\r\n\r\n", b"GET\r\n\r\n", b"GET / HTTP/9\r\n\r\n", b"\0\xff\x16\x03\r\n\r\n", b"GET / HTTP/1.1\r\n: x\r\n\r\n",
                    b"GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n", b"GET /?a=1&a=2 HTTP/1.1\r\n\r\n"):
            self.assertEqual(self.raw(bad).split()[1], b"400", bad)
        self.assertEqual(self.raw(b"GET /" + b"a" * 100000 + b" HTTP/1.1\r\n\r\n").split()[1], b"431")
        # Headers without end.
        with socket.create_connection(("127.0.0.1", self.port), timeout=8) as endless:
            endless.sendall(b"GET / HTTP/1.1\r\n")
            with self.assertRaises(OSError):
                for _ in range(100000):
                    endless.sendall(b"X: " + b"y" * 1000 + b"\r\n")

    def test_slow_ones_do_not_keep_others_out(self):
        slow = [socket.create_connection(("127.0.0.1", self.port)) for _ in range(200)]
        for one in slow:
            try:
                one.sendall(b"GET / HTTP/1.1\r\nX")
            except OSError:
                pass
        started = time.monotonic()
        self.assertEqual(self.ask("/api/runs")[0], 200)
        self.assertLess(time.monotonic() - started, 5)
        # One byte a time does not help beyond the limit for a head.
        drip = socket.create_connection(("127.0.0.1", self.port), timeout=20)
        drip.sendall(b"GET / HTTP/1.1\r\n")
        try:
            while time.monotonic() - started < 15:
                drip.sendall(b"x")
                time.sleep(0.2)
            self.fail("a request may drip for 15 s")
        except OSError:
            pass
        for one in [*slow, drip]:
            one.close()
        self.assertEqual(self.ask("/api/runs")[0], 200)

    def test_a_run_is_followed_as_it_goes(self):
        out = self.out / "going"
        out.mkdir()
        start = {"event": "run_start", "time": "2026-01-01T00:00:00Z", "start": 1.0, "pipeline": "slow.yaml", "arguments": [], "process": os.getpid()}
        record = out / "run.jsonl"
        record.write_text(json.dumps(start) + "\n" + '{"event":"node","name":"a","kind":"k","status":"exec')
        (out / ".plumbline-progress").write_text(json.dumps({"process": 1, "done": 0, "total": 2, "running": [{"name": "a", "items_done": 3, "items": 9}]}))
        going = json.loads(self.ask("/api/run?id=going")[2]) if self.ask("/api/runs")[0] == 200 else {}
        self.assertEqual((going["status"], going["nodes"], going["progress"]["running"][0]["items_done"]), ("running", [], 3))
        with record.open("a") as more:
            more.write('uted","outputs":{},"metrics":[{"name":"invalid","value":1,"unit":"1"}]}\n{"event":"run_end","status":"ok","seconds":2.0,"outputs":{}}\n')
        going = json.loads(self.ask("/api/run?id=going")[2])
        self.assertEqual((going["status"], going["nodes"][0]["status"]), ("not usable", "executed"))
        # A new run at its place.
        fresh = out / "fresh"
        fresh.write_text(json.dumps(dict(start, process=2 ** 22 + 5)) + "\n")
        fresh.rename(record)
        going = json.loads(self.ask("/api/run?id=going")[2])
        self.assertEqual((going["status"], going["nodes"]), ("ended without a word", []))

    def test_a_process_number_means_something_on_its_own_machine_until_it_is_started_anew(self):
        out = self.out / "elsewhere"
        out.mkdir()
        start = {"event": "run_start", "time": "2026-01-01T00:00:00Z", "start": 1.0, "pipeline": "p.yaml", "arguments": [], "process": 1}
        boot = pathlib.Path("/proc/sys/kernel/random/boot_id").read_text().strip()
        try:
            for host, status in (({"name": "another-machine"}, "no end in its record, from another-machine"), ({"name": socket.gethostname(), "boot": "earlier"}, "ended without a word"),
                                 ({"name": socket.gethostname(), "boot": boot}, "running")):
                (out / "fresh").write_text(json.dumps(dict(start, host=host)) + "\n")  # a file of its own: another run
                (out / "fresh").rename(out / "run.jsonl")
                runs = {r["id"]: r for r in json.loads(self.ask("/api/runs")[2])["runs"]}
                self.assertEqual(runs["elsewhere"]["status"], status)
            self.assertEqual(json.loads((self.out / "one/run.jsonl").read_text().splitlines()[0])["host"]["boot"], boot)
        finally:
            shutil.rmtree(out)

    def test_of_a_node_that_ran_in_rounds_each_shows_its_own_and_the_last_counts(self):
        out = self.out / "rounds"
        out.mkdir()
        first = json.loads((self.out / "one/run.jsonl").read_text().splitlines()[1])
        second = json.loads((self.out / "two/run.jsonl").read_text().splitlines()[1])
        start = {"event": "run_start", "time": "2026-01-01T00:00:00Z", "start": 1.0, "pipeline": "p.yaml", "arguments": [], "process": 1}
        first.update(round=1, metrics=[{"name": "invalid", "value": 1, "unit": "1"}])
        second.update(round=2)
        lines = [start, first, second, {"event": "run_end", "status": "ok", "seconds": 2.0, "outputs": {}}]
        try:
            for usable, status in ((None, "ok"), (True, "ok"), (False, "not usable")):
                if usable is not None:
                    lines[-1]["usable"] = usable
                (out / "fresh").write_text("".join(json.dumps(line) + "\n" for line in lines))
                (out / "fresh").rename(out / "run.jsonl")
                runs = {r["id"]: r for r in json.loads(self.ask("/api/runs")[2])["runs"]}
                self.assertEqual((runs["rounds"]["status"], runs["rounds"]["invalid"]), (status, status != "ok"))
            for node, z in (("points@1", "3"), ("points@2", "3.5"), ("points", "3.5")):
                points = json.loads(self.ask(f"/api/artifact?id=rounds&node={node}&port=points&item=0")[2])
                self.assertEqual(str(points["points"][0]["position"][2]).removesuffix(".0"), z, node)
            self.assertIn(b"n.round?'@'+n.round", self.ask("/")[2])
        finally:
            shutil.rmtree(out)

    def test_who_breaks_off_a_download_ends_nothing(self):
        large = self.out / "one/large.bin"
        with large.open("wb") as file:
            file.truncate(1 << 30)
        try:
            for _ in range(3):
                with socket.create_connection(("127.0.0.1", self.port), timeout=8) as connection:
                    connection.sendall(f"GET /files/one/large.bin HTTP/1.1\r\nHost: 127.0.0.1:{self.port}\r\nAuthorization: Bearer {self.token}\r\n\r\n".encode())
                    connection.recv(65536)
                time.sleep(0.3)
            self.assertEqual(self.ask("/api/runs")[0], 200)
            self.assertIsNone(self.server.poll())
        finally:
            large.unlink()

    def test_what_is_deleted_while_it_is_served_is_not_there(self):
        out = self.out / "gone"
        shutil.copytree(self.out / "two", out)
        self.assertEqual((self.ask("/api/runs")[0], self.ask("/api/run?id=gone")[0]), (200, 200))
        shutil.rmtree(out)
        for path in ("/api/run?id=gone", "/api/diff?a=one&b=gone", "/api/artifact?id=gone&node=points&port=points&item=0", "/files/gone/points.json"):
            status, _, body = self.ask(path)
            self.assertEqual(status, 404, path)
            self.assertNotIn(b"exception", body, path)
        # The whole folder, made again: `rm -r out` and another run.
        self.out.rename(self.work / "away")
        try:
            shutil.copytree(self.work / "away/two", self.out / "again")
            self.assertEqual([r["id"] for r in json.loads(self.ask("/api/runs")[2])["runs"]], ["again"])
            self.assertEqual(self.ask("/files/again/points.json")[0], 200)
        finally:
            shutil.rmtree(self.out, ignore_errors=True)
            (self.work / "away").rename(self.out)

    def test_one_answer_a_connection_and_the_whole_of_a_file(self):
        one = f"GET /files/one/page.html HTTP/1.1\r\nHost: 127.0.0.1:{self.port}\r\nAuthorization: Bearer {self.token}\r\nRange: bytes=0-3\r\n\r\n".encode()
        answer = self.raw(one + one)
        self.assertEqual(answer.count(b"HTTP/1.1 "), 1)
        self.assertIn(b"HTTP/1.1 200 OK\r\nConnection: close\r\n", answer)
        self.assertTrue(answer.endswith(b"\r\n\r\n<script>1</script>"))
        for method in ("OPTIONS", "PUT", "DELETE", "TRACE", "get"):
            status, head, _ = self.ask("/", method=method)
            self.assertEqual((status, "Allow: GET, HEAD" in head), (405, True), method)

    @unittest.skipUnless(shutil.which("chromium"), "chromium is not installed (scripts/setup --tests)")
    def test_sentences_of_a_result_are_broken_and_tables_are_not(self):
        out = self.out / "told"
        out.mkdir()
        try:
            start = {"event": "run_start", "time": "2026-01-01T00:00:00Z", "start": 1.0, "pipeline": "p.yaml", "arguments": [], "process": 1}
            (out / "run.jsonl").write_text(json.dumps(start) + '\n{"event":"run_end","status":"ok","seconds":2.0,"outputs":{}}\n')
            (out / "next.txt").write_text("Installation: FAIL\nfloor 1     3   pass\nNote: the stated uncertainties are too small\n")
            dom = subprocess.run(["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", f"--user-data-dir={self.work}/chromium2",
                                  "--virtual-time-budget=4000", "--dump-dom", self.address + "#told"], capture_output=True, text=True, timeout=60).stdout
            self.assertIn('<span class="row">floor 1', dom, dom[-2000:])
            self.assertIn('<span class="sentence">Note: the', dom)
        finally:
            shutil.rmtree(out)

    @unittest.skipUnless(shutil.which("chromium"), "chromium is not installed (scripts/setup --tests)")
    def test_a_browser_shows_the_runs_on_a_desk_and_on_a_telephone(self):
        for size in ("1300,900", "390,800"):
            dom = subprocess.run(["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", f"--user-data-dir={self.work}/chromium",
                                  "--virtual-time-budget=4000", f"--window-size={size}", "--dump-dom", self.address], capture_output=True, text=True, timeout=60).stdout
            for word in ("one", "two", "computed"):
                self.assertIn(f">{word}<", dom, f"{size}: {dom[-3000:]}")
            self.assertNotIn("<img", dom)  # a name that somebody wrote into a record
            self.assertIn('name="viewport"', dom)

    def test_that_it_was_computed_does_not_say_that_the_building_is_in_order(self):
        out = self.out / "loop"
        out.mkdir()
        start = {"event": "run_start", "time": "2026-01-01T00:00:00Z", "start": 1.0, "pipeline": "site_loop.yaml", "arguments": [], "process": 1}
        (out / "run.jsonl").write_text(json.dumps(start) + '\n{"event":"run_end","status":"ok","seconds":2.0,"outputs":{}}\n')
        (out / "next.txt").write_text("0 of 2 panels hang and are verified\nnext: give the job to the robots\n")
        self.assertEqual(self.ask("/api/runs")[0], 200)
        run = json.loads(self.ask("/api/run?id=loop")[2])
        self.assertEqual((run["status"], run["words"].splitlines()[0]), ("ok", "0 of 2 panels hang and are verified"))
        page = self.ask("/")[2]
        self.assertIn(b"ok:'computed'", page)
        self.assertNotIn(b"ok:'done'", page)


if __name__ == "__main__":
    unittest.main()
