"""Types the commands of docs/measured.toml and compares what comes out."""
import json
import math
import os
import pathlib
import re
import resource
import shlex
import shutil
import subprocess
import xml.etree.ElementTree as xml

from . import rows as data


def processor_time():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def step_into(value, step):
    """One step of a pointer; [key=text;key.of.it=text] takes the one element of a list that has these."""
    if not step.startswith("["):
        return value[int(step)] if isinstance(value, list) else value[step]
    def has(one, key, text):
        for part in key.split("."):
            one = one.get(part) if isinstance(one, dict) else None
        return str(one) == text
    wanted = dict(part.split("=", 1) for part in step[1:-1].split(";"))
    found = [one for one in value if all(has(one, key, text) for key, text in wanted.items())]
    if len(found) != 1:
        raise KeyError(f"{len(found)} elements have {step}")
    return found[0]


def of_text(wanted, text):
    """The first group of the regular expression, where it stands first; or `over` all places."""
    found = re.findall(wanted["text"], text, re.M)
    if wanted.get("over") == "count":
        return len(found)
    if not found:
        return None
    numbers = [float(one) for one in found]
    return {"most": max, "sum": sum}[wanted["over"]](numbers) if "over" in wanted else numbers[0]


class Run:
    """One command: how it ended, what it printed, its output folder, its processor time."""

    def __init__(self, words, out, environment=None):
        before = processor_time()
        done = subprocess.run(words, capture_output=True, text=True, cwd=data.ROOT, env={**os.environ, **(environment or {})})
        self.code, self.text, self.out, self.time = done.returncode, done.stdout + done.stderr, pathlib.Path(out), processor_time() - before

    def metric(self, name):
        node, name = name.split(".")
        for line in open(self.out / "run.jsonl", encoding="utf-8"):
            event = json.loads(line)
            if event.get("event") == "node" and event["name"] == node:
                for metric in event.get("metrics", []):
                    if metric["name"] == name:
                        return metric["value"]
        return None

    def property(self, name):
        """What a test recorded: Suite.Name/property, or the only one that is called so."""
        for file in sorted(self.out.glob("*.xml")):
            for case in xml.parse(file).getroot().iter("testcase"):
                found = {p.get("name"): p.get("value") for p in case.iter("property")}
                if name in found:
                    return float(found[name])
        return None

    def value(self, wanted):
        """The figure that the value's source names; None if it is not there."""
        if "metric" in wanted:
            return self.metric(wanted["metric"])
        if "property" in wanted:
            return self.property(wanted["property"])
        if "time" in wanted:
            return self.time
        file = self.out / wanted["file"] if "file" in wanted else None
        if file and not file.exists():
            return None
        if "text" in wanted:
            return of_text(wanted, file.read_text(encoding="utf-8") if file else self.text)
        value = json.loads(file.read_text(encoding="utf-8"))
        for step in re.findall(r"\[[^\]]*\]|[^/]+", wanted["pointer"]):
            try:
                value = step_into(value, step)
            except (KeyError, IndexError):
                return None
        return value


def has_modules(interpreter, modules):
    return subprocess.run([interpreter, "-c", "import " + ", ".join(modules)], capture_output=True).returncode == 0


class Environments:
    """Virtual environments for scripts that take `python3` from PATH, where another one may stand before the one with the modules."""

    def __init__(self, scratch):
        self.scratch, self.made = pathlib.Path(scratch), {}

    def folder(self, modules):
        """An environment whose python3 has the modules; None if no interpreter here has them all."""
        key = tuple(sorted(modules))
        if key not in self.made:
            found = [p for p in (shutil.which("python3"), "/usr/bin/python3") if p and shutil.which(p) and has_modules(p, key)]
            self.made[key] = self.scratch / ("python-" + "-".join(key)) if found else None
            if found:
                subprocess.run([found[0], "-m", "venv", "--without-pip", "--system-site-packages", self.made[key]], check=True)
        return self.made[key]


class Line:
    """A line of the table."""
    WIDTHS = (46, 24, 11, 11, 10)
    HEAD = ("claim", "figure", "stated", "found", "within", "verdict")

    def __init__(self, row, value, found, verdict):
        def short(number):
            return number if isinstance(number, str) else f"{number:.5g}"
        name = " ".join(filter(None, [value.get("of", ""), f"[{value['unit']}]" if value.get("unit") else ""]))
        within = ("≤ " if value.get("most") else "") + short(value["tolerance"])
        self.cells = (row["claim"], name, short(value["value"]), short(found), within, verdict)

    def __str__(self):
        return self.laid_out(self.cells)

    @classmethod
    def laid_out(cls, cells):
        cut = [text if len(text) <= width else text[:width - 1] + "…" for text, width in zip(cells, cls.WIDTHS)]
        return "  ".join([text.ljust(width) for text, width in zip(cut, cls.WIDTHS)] + [cells[-1]])


class Checker:
    def __init__(self, program, scratch):
        self.program, self.scratch, self.runs = pathlib.Path(program), scratch, {}
        self.environments = Environments(scratch)
        self.folders = {"$DATA": pathlib.Path(os.environ.get("PLUMBLINE_TEST_DATA", data.ROOT / "../shared/data")).resolve(),
                        "$OTHERS": pathlib.Path(os.environ.get("PLUMBLINE_OTHERS", "/nonexistent"))}
        self.count = {"as told": 0, "NOT AS TOLD": 0, "not here": 0}

    def words(self, command, out):
        for name, folder in {**self.folders, "$SCRATCH": self.scratch, "$OUT": out, "build/bin/": f"{self.program.parent}/"}.items():
            command = command.replace(name, str(folder))
        words = shlex.split(command)
        if words[0] == "plumbline":
            words[0] = str(self.program)
            if words[1] in ("run", "bench"):
                words += ["--out", out]
        return words

    def once(self, command, environment=None):
        """A command is run once, whatever the number of rows that look at it."""
        if command not in self.runs:
            out = f"{self.scratch}/{len(self.runs)}"
            pathlib.Path(out).mkdir()
            self.runs[command] = Run(self.words(command, out), out, {"GTEST_OUTPUT": f"xml:{out}/"} if command.startswith("ctest") else environment)
        return self.runs[command]

    def missing(self, check):
        """What the check needs and is not here."""
        for repository in data.others(check):
            if not (self.folders["$OTHERS"] / repository).is_dir():
                return repository
        text = data.command(check) + check.get("before", "")
        if "$DATA" in text and not self.folders["$DATA"].is_dir():
            return "test data"
        first = self.words(data.command(check).replace("$HERE", check.get("here", "")), "-")[0]
        for program in [first, *check.get("wants", [])]:
            if not shutil.which(program) and not (data.ROOT / program).exists():
                return pathlib.Path(program).name
        modules = check.get("modules", [])
        if modules and not self.environments.folder(modules):
            return f"a python3 with {' and '.join(modules)}: apt-get install {' '.join('python3-' + module for module in modules)}"
        return None

    def environment(self, check):
        """What the command finds first in PATH."""
        if "modules" not in check:
            return None
        folder = self.environments.folder(check["modules"])
        return {"PATH": f"{folder}/bin:{os.environ['PATH']}", "VIRTUAL_ENV": str(folder)}

    def run(self, check, seed):
        """The run that a check looks at, or what went wrong."""
        for name, text in check.get("write", {}).items():
            pathlib.Path(self.scratch, name).write_text(text, encoding="utf-8")
        if "test" in check:
            name = re.escape(check["test"]).replace(r"\*", ".*")
            command = f"ctest --test-dir {self.program.parent.parent} -R '(^|/){name}(/|$)' --no-tests=error -V"
            run = self.once(command)
            if re.search(r"\*\*\*Skipped|\*\*\*Not Run", run.text) and not re.search(r"\bPassed\b", run.text):
                return "not here: the test was skipped"
        else:
            command = data.command(check).replace("{seed}", str(seed)).replace("$HERE", check.get("here", ""))
            if "before" in check:
                before = self.once(check["before"])
                if before.code not in (0, 3):
                    return f"`{check['before']}` ended with {before.code}: {before.text[-500:]}"
                command = command.replace("$BEFORE", str(before.out))
            run = self.once(command, self.environment(check))
        right = check.get("exit", [0, 3] if command.startswith("plumbline") else [0])
        return run if run.code in right else f"`{command}` ended with {run.code}: {run.text[-500:]}"

    def judged(self, row, value, runs):
        if "asserts" in value:
            return Line(row, value, "holds", "as told")
        found = [run.value(value) for run in runs]
        if None in found:
            return Line(row, value, "none", "NOT AS TOLD")
        factor = value.get("factor", 1)
        one = factor * (found[0] if len(found) == 1 else math.sqrt(sum(v * v for v in found) / len(found)))
        off = one - value["value"]
        good = off <= value["tolerance"] * (1 + 1e-9) if value.get("most") else abs(off) <= value["tolerance"] * (1 + 1e-9)
        return Line(row, value, one, "as told" if good else "NOT AS TOLD")

    def lines(self, row, check):
        """The table's lines of one check, and what is to be said of it."""
        if missing := self.missing(check):
            return [Line(row, value, "-", "not here") for value in data.values(check)], f"not here: {missing}"
        runs = [self.run(check, seed) for seed in check.get("seeds", [1])]
        if bad := [run for run in runs if isinstance(run, str)]:
            verdict = "not here" if bad[0].startswith("not here") else "NOT AS TOLD"
            return [Line(row, value, "none", verdict) for value in data.values(check)], bad[0]
        return [self.judged(row, value, runs) for value in data.values(check)], ""

    def check(self, row, check):
        lines, said = self.lines(row, check)
        for line in lines:
            self.count[line.cells[-1]] += 1
            print(line, flush=True)
        if said:
            print("  " + said, flush=True)
