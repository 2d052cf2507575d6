"""usage: test_followed_page.py PLUMBLINE     The page of `plumbline serve` in Chromium, on a desk and on a telephone: runs that begin, go on and
end while it is open appear on it, and it is not loaded again for that."""
import json
import os
import pathlib
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

PLUMBLINE = os.path.abspath(sys.argv.pop(1))
PIPELINE = "plumbline: 1\nvars: {file: points.csv}\nnodes:\n  points: {use: read.points, with: {file: \"${file}\"}}\noutputs: {points.json: points.points}\n"


class Browser:
    """Chromium, spoken to by its DevTools protocol through two pipes, which it has as files 3 and 4."""

    def __init__(self, profile):
        to_read, self.write = os.pipe()
        self.read, to_write = os.pipe()
        self.said, self.number = b"", 0

        def give_pipes():  # both free numbers first: one of the pipes may have 3 or 4 itself
            a, b = os.dup(to_read), os.dup(to_write)
            os.dup2(a, 3), os.dup2(b, 4)
        self.process = subprocess.Popen(["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", f"--user-data-dir={profile}",
                                         "--remote-debugging-pipe", "about:blank"], preexec_fn=give_pipes, close_fds=False, stdin=subprocess.DEVNULL,
                                        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
        os.close(to_read), os.close(to_write)

    def ask(self, method, session=None, seconds=30, **parameters):
        self.number += 1
        question = dict(id=self.number, method=method, params=parameters, **({"sessionId": session} if session else {}))
        os.write(self.write, json.dumps(question).encode() + b"\0")
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            message, zero, rest = self.said.partition(b"\0")
            if not zero:
                if select.select([self.read], [], [], 1)[0]:
                    self.said += os.read(self.read, 1 << 20)
                continue
            self.said = rest
            answer = json.loads(message)
            if answer.get("id") == self.number:
                assert "result" in answer, answer
                return answer["result"]
        raise TimeoutError(f"chromium did not answer {method} in {seconds} s")

    def open(self, address, width, height, mobile):
        target = self.ask("Target.createTarget", url="about:blank")["targetId"]
        page = self.ask("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        self.ask("Emulation.setDeviceMetricsOverride", page, width=width, height=height, deviceScaleFactor=1, mobile=mobile)
        self.ask("Page.navigate", page, url=address)
        return page

    def value(self, page, expression):
        return self.ask("Runtime.evaluate", page, expression=expression, returnByValue=True)["result"].get("value")

    def close(self):
        os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait()
        os.close(self.read), os.close(self.write)


@unittest.skipUnless(shutil.which("chromium"), "chromium is not installed (scripts/setup --tests)")
class Followed(unittest.TestCase):
    def setUp(self):
        place = tempfile.TemporaryDirectory()
        self.addCleanup(place.cleanup)
        self.work = pathlib.Path(place.name)
        self.environment = dict(os.environ, PLUMBLINE_STORE=str(self.work / "store"), XDG_CACHE_HOME=str(self.work / "cache"))
        (self.work / "p.yaml").write_text(PIPELINE)
        (self.work / "points.csv").write_text("name,x,y,z,sigma\nA,1,2,3,0.001\n")
        self.run_pipeline("first")
        server = subprocess.Popen([PLUMBLINE, "serve", "out"], cwd=self.work, env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.addCleanup(server.stdout.close)
        self.addCleanup(server.wait, 10)
        self.addCleanup(server.send_signal, signal.SIGINT)
        self.address = server.stdout.readline().strip()
        self.browser = Browser(self.work / "chromium")
        self.addCleanup(self.browser.close)

    def run_pipeline(self, out):
        subprocess.run([PLUMBLINE, "run", "p.yaml", "--out", "out/" + out, "-q"], cwd=self.work, env=self.environment, check=True, stderr=subprocess.DEVNULL)

    def wait_for(self, page, *words, seconds=20):
        """Until the page shows them, one after the other."""
        end, text = time.monotonic() + seconds, ""
        while time.monotonic() < end:
            text, at = self.browser.value(page, "document.body.innerText") or "", 0
            for word in words:
                at = text.find(word, at) + len(word) if at >= 0 and text.find(word, at) >= 0 else -1
            if at >= 0:
                return
            time.sleep(0.1)
        self.fail(f"{words} did not appear: {text}")

    def follow(self, page, name, year):
        """The newest run, of two nodes, as its record grows; then one of the program."""
        self.wait_for(page, "first", "computed")
        self.browser.value(page, "window.mark = 'the same page'")
        out = self.work / "out" / name
        out.mkdir()
        start = {"event": "run_start", "time": f"{year}-01-01T00:00:00Z", "start": 1.0, "pipeline": "slow.yaml", "arguments": [], "process": os.getpid()}
        (out / ".plumbline-progress").write_text(json.dumps({"process": 1, "done": 0, "total": 2, "running": [{"name": "tags", "items_done": 3, "items": 9}]}))
        (out / "run.jsonl").write_text(json.dumps(start) + "\n")
        self.wait_for(page, name, "running", "0 of 2 nodes", "tags", "3 of 9 items")
        (out / ".plumbline-progress").write_text(json.dumps({"process": 1, "done": 1, "total": 2, "running": [{"name": "block", "fraction": 0.5, "text": "iteration 4"}]}))
        with (out / "run.jsonl").open("a") as record:
            record.write('{"event":"node","name":"tags","kind":"k","status":"executed","items":9,"items_executed":9,"seconds":1.5,"outputs":{},"metrics":[]}\n')
        self.wait_for(page, "1 of 2 nodes", "block", "iteration 4", "tags", "executed")
        (out / ".plumbline-progress").unlink()
        (out / "summary.txt").write_text("Installation: PASS\n")
        with (out / "run.jsonl").open("a") as record:
            record.write('{"event":"run_end","status":"ok","seconds":2.0,"outputs":{}}\n')
        self.wait_for(page, name, "computed", "Installation: PASS", "tags", "executed")
        self.run_pipeline("real " + name)
        self.wait_for(page, "real " + name, "computed")
        self.assertEqual(self.browser.value(page, "window.mark"), "the same page")
        self.assertEqual(self.browser.value(page, "performance.getEntriesByType('navigation').length"), 1)

    def test_on_a_desk_and_on_a_telephone(self):
        for name, width, height, mobile in (("desk", 1300, 900, False), ("telephone", 390, 800, True)):
            with self.subTest(name):
                page = self.browser.open(self.address, width, height, mobile)
                self.follow(page, name, 2037 if mobile else 2036)
                self.assertEqual(self.browser.value(page, "innerWidth"), width)
                self.assertLessEqual(self.browser.value(page, "document.documentElement.scrollWidth"), width, "it scrolls sideways")
                # The list of runs beside the run chosen, or above it.
                beside = self.browser.value(page, "document.getElementById('run').getBoundingClientRect().left > 200")
                self.assertEqual(beside, not mobile)


if __name__ == "__main__":
    unittest.main()
