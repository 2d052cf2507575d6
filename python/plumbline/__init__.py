"""Drives the program `plumbline`: runs pipelines and benches, and gives what came out as numpy arrays.

    import plumbline

    run = plumbline.run("site_campaign", folder="tower_east", out="result")
    run.outputs["report.html"]                    # where it is
    run.nodes["accuracy"].metrics["rmse_z"]       # numbers of a node
    points = run.artifact("block.points")         # {"points": [...], "covariance": array, ...}
    table = run.table("block.points", "points")   # a column an array; a pandas.DataFrame where pandas is installed

Variables of the pipeline are keyword arguments; parameters, kinds and connections of nodes stand in `set`, as on the command line:
set={"poses.use": "pose.opencv"}. A run that failed raises RunFailed with what failed and where; wrong use raises UsageError. A result
that must not be used (exit code 3) is returned with `usable` False and a warning.

The program is found on PATH, or by the environment variable PLUMBLINE.
"""
import json
import os
import pathlib
import shutil
import subprocess
import threading
import warnings
from collections import OrderedDict

__all__ = ["run", "bench", "show", "describe", "pipelines", "Run", "Node", "PlumblineError", "UsageError", "RunFailed", "Failure"]
__version__ = "0.2.0"


class PlumblineError(Exception):
    """Whatever the program refuses or cannot do; the text is the program's own."""


class UsageError(PlumblineError):
    """Nothing was run: an unknown pipeline, variable or parameter, or a pipeline that is not valid."""


class Failure:
    """A node that failed: its name and kind, the place in the pipeline, and the message."""

    def __init__(self, node, kind, at, message):
        self.node, self.kind, self.at, self.message = node, kind, at, message

    def __repr__(self):
        return f"Failure({self.node!r}, {self.kind!r}, at {self.at!r}: {self.message})"


class RunFailed(PlumblineError):
    """`failures` has each node that failed; `run` what was done all the same."""

    def __init__(self, run, text):
        self.run = run
        self.failures = [Failure(n.name, n.kind, n.at, n.error) for n in run.nodes.values() if n.status == "failed"]
        super().__init__("\n".join(f.message for f in self.failures) or text)


class NotUsable(UserWarning):
    """A result is there, and a node says that it must not be used, or its rounds did not come to their end."""


class Node:
    """What a run tells of a node: name, kind, round (0 of a pipeline without), status, seconds, metrics by name, warnings, messages,
    and its outputs' types by port."""

    def __init__(self, record):
        self.record = record
        self.name, self.kind, self.status = record["name"], record["kind"], record["status"]
        self.at, self.error = record.get("at", ""), record.get("error", "")
        self.seconds = record.get("seconds", 0.0)
        self.metrics = {m["name"]: m["value"] for m in record.get("metrics", [])}
        self.round = record.get("round", 0)
        self.warnings, self.messages = record.get("warnings", []), record.get("messages", [])
        self.types = record.get("types", {})

    def __repr__(self):
        return f"<{self.name} ({self.kind}): {self.status}>"


class Run:
    """A run that was made, or one that lies on the disk: Run("out/site_campaign"). Of a node that ran in rounds `nodes` has the last;
    the others are in `earlier`."""

    def __init__(self, folder, store=None):
        self.folder = pathlib.Path(folder)
        self.store = store
        self.nodes, self.earlier, self.outputs = OrderedDict(), [], {}
        self.status, self.unfinished = "not ended", False
        if not (self.folder / "run.jsonl").is_file():
            raise UsageError(f"there is no run in {self.folder}: give the output folder of a run, which holds a run.jsonl")
        with open(self.folder / "run.jsonl", encoding="utf-8") as lines:
            for line in lines:
                try:
                    self._take(json.loads(line))
                except json.JSONDecodeError:  # cut off by a crash
                    continue
        if self.usable is None:  # the program that wrote it did not say so, or did not come to its end
            self.usable = not self.unfinished and not any((n.metrics.get("invalid") or 0) > 0 for n in self.nodes.values())

    usable = None

    def _take(self, event):
        what = event.get("event")
        if what == "node":
            node = Node(event)
            if node.name in self.nodes:
                self.earlier.append(self.nodes[node.name])
            self.nodes[node.name] = node
        elif what == "run_end":
            self.status = event.get("status", "")
            self.unfinished = not event.get("rounds", {}).get("finished", True)
            self.usable = event.get("usable")
            for name in self._names(event.get("outputs", [])):
                if (self.folder / name).exists():
                    self.outputs[name] = self.folder / name

    @staticmethod
    def _names(outputs):
        if isinstance(outputs, dict):
            return list(outputs)
        return [o["file"] if isinstance(o, dict) else o for o in outputs]

    @property
    def warnings(self):
        """All warnings, as (node, text); of a round before the last as ("node@1", text)."""
        return self._told("warnings")

    @property
    def messages(self):
        """What nodes say that is no warning, such as whom a search left out; as `warnings`."""
        return self._told("messages")

    def _told(self, what):
        return [(name, text) for name, node in [(f"{n.name}@{n.round}", n) for n in self.earlier] + list(self.nodes.items())
                for text in getattr(node, what)]

    def artifact(self, port):
        """The artifact of "node.port" as a dict; lists of numbers are numpy arrays. A list of artifacts is a list."""
        return _arrays(json.loads(_output(["show", f"{self.folder / 'run.jsonl'}:{port}"], self.store)))

    def table(self, port, field):
        """A list of tables in an artifact, such as the points of "block.points", by columns: numpy arrays by name, or a
        pandas.DataFrame where pandas is installed. What is missing in a row is nan or None; nested tables are left out."""
        return _columns(self.artifact(port)[field])

    def __repr__(self):
        return f"<Run {self.folder}: {self.status}{'' if self.usable else ', not to be used'}, {len(self.nodes)} nodes>"


def run(pipeline, out=None, *, set=None, progress=None, store=None, threads=None, overwrite=False, **variables):
    """Runs a pipeline: a file, or the name of a shipped one.

    `progress` is called with a Node as each ends; True prints a line for each. Returns a Run. Raises UsageError if nothing could be
    run, RunFailed if a node failed. A variable that is None keeps the pipeline's own value; in `set` None leaves
    a parameter out.
    """
    out = pathlib.Path(out) if out else pathlib.Path("out") / pathlib.Path(pipeline).stem
    words = ["run", str(pipeline)] + _assigned(variables)
    words += [f"{name}={_text(value)}" for name, value in (set or {}).items()]
    words += ["--out", str(out), "--json"] + _store(store)
    words += ["--threads", str(threads)] if threads else []
    words += ["--overwrite"] if overwrite else []
    tell = (lambda node: print(f"{node.status:10}{node.name} ({node.kind})", flush=True)) if progress is True else progress
    before = _state(out / "run.jsonl")
    code, errors = _follow(words, tell)
    if code == 130:
        raise KeyboardInterrupt
    if code == 2 or _state(out / "run.jsonl") == before:  # a record that lies there is of another run
        raise (UsageError if code == 2 else PlumblineError)(errors)
    made = Run(out, store)
    if code not in (0, 3):
        raise RunFailed(made, errors)
    made.usable = code == 0
    if code == 3:
        why = "its rounds did not come to their end" if made.unfinished else "a node says that its result must not be used"
        warnings.warn(f"{out}: {why}", NotUsable, stacklevel=2)
    return made


def bench(file, out=None, *, seeds=None, scenarios=(), store=None, **variables):
    """Runs a bench file and returns its results: the content of bench.json. Cells that failed are in it and raise nothing.

    `seeds` in place of the file's: "1-20", a number, or numbers as in range(1, 21); `scenarios`: only these of the file's.
    """
    out = pathlib.Path(out) if out else pathlib.Path("out") / pathlib.Path(file).stem
    words = ["bench", str(file)] + _assigned(variables)
    words += ["--out", str(out), "--json"] + _store(store)
    for name in [scenarios] if isinstance(scenarios, str) else scenarios:
        words += ["--scenario", name]
    if seeds is not None:
        words += ["--seeds"] + [str(seed) for seed in ([seeds] if isinstance(seeds, (str, int)) else seeds)]
    done = subprocess.run([_program(), *words], capture_output=True, text=True, check=False)
    if done.returncode == 130:
        raise KeyboardInterrupt
    if done.returncode == 2 or not done.stdout.strip():  # what lies in `out` is of another time
        raise (UsageError if done.returncode == 2 else PlumblineError)(done.stderr.strip())
    with open(out / "bench.json", encoding="utf-8") as stream:
        return json.load(stream)


def show(artifact, store=None):
    """An artifact by the start of its hash, by "RUN/run.jsonl:node.port" or from a file, as Run.artifact() gives it."""
    return _arrays(json.loads(_output(["show", str(artifact)], store)))


def describe(name):
    """What `plumbline describe` tells of a kind of node, a pipeline or an artifact, as a dict."""
    return json.loads(_output(["describe", name, "--json"]))


def pipelines():
    """The pipelines that can be run by name: a list of dicts with name, summary and what they need."""
    return json.loads(_output(["list", "pipelines", "--json"]))


def _program():
    program = os.environ.get("PLUMBLINE") or shutil.which("plumbline")
    if not program:
        raise PlumblineError("the program plumbline is not on PATH; install it, or set PLUMBLINE to where it is")
    if os.environ.get("PLUMBLINE") and not shutil.which(program):
        raise PlumblineError(f"the environment variable PLUMBLINE names {program}, which is no program")
    return program


def _state(file):
    """What tells a record from one that was there before."""
    try:
        found = os.stat(file)
    except OSError:
        return None
    return found.st_ino, found.st_mtime_ns, found.st_size


def _assigned(values):
    return [f"{name}={_text(value)}" for name, value in values.items() if value is not None]


def _store(store):
    return ["--store", str(store)] if store else []


def _text(value):
    if value is None:
        return "~"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_item(v) for v in value) + "]"
    return str(value)


def _item(value):
    """One of a list: what the program would take apart or strip stands in quotes."""
    text = _text(value)
    if not isinstance(value, str) or text and text == text.strip(" ") and not set(text) & set(",'\""):
        return text
    quote = next((mark for mark in "\"'" if mark not in text), None)
    if quote is None:
        raise UsageError(f"an item of a list cannot have both kinds of quotes in it: {text}")
    return quote + text + quote


def _output(words, store=None):
    done = subprocess.run([_program(), *words, *_store(store)], capture_output=True, text=True, check=False)
    if done.returncode == 0:
        return done.stdout
    raise (UsageError if done.returncode == 2 else PlumblineError)(done.stderr.strip())


def _follow(words, tell):
    """Runs the program; `tell` hears of each node as it ends. Returns the exit code and what was said on standard error."""
    process = subprocess.Popen([_program(), *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, encoding="utf-8")
    errors = []
    reader = threading.Thread(target=lambda: errors.append(process.stderr.read()))
    try:
        reader.start()
        for line in process.stdout:
            if tell and line.startswith('{"event":"node"'):
                tell(Node(json.loads(line)))
    except BaseException as reason:  # Ctrl-C, or what `tell` raised
        rest = threading.Thread(target=process.stdout.read)  # or it could not go on to its end
        rest.start()
        try:
            process.wait(1 if isinstance(reason, KeyboardInterrupt) else 0)  # Ctrl-C in a terminal reaches both
        except subprocess.TimeoutExpired:
            process.terminate()  # it stops as soon as its nodes can; what was done is kept
        process.wait()
        rest.join()
        raise
    finally:
        process.wait()
        if reader.ident:  # it was begun
            reader.join()
        process.stdout.close()
        process.stderr.close()
    return process.returncode, "".join(errors).strip()


def _is_numbers(value):
    return isinstance(value, list) and value and all(isinstance(v, (int, float)) or v is None for v in value) \
        and not any(isinstance(v, bool) for v in value)


def _arrays(value):
    """Lists of numbers, and lists of such lists of one length, as arrays; null is nan."""
    import numpy as np
    if isinstance(value, dict):
        return {key: _arrays(item) for key, item in value.items()}
    if not isinstance(value, list) or not value:
        return value
    if _is_numbers(value):
        return np.array([float("nan") if v is None else v for v in value])
    if all(_is_numbers(v) for v in value) and len({len(v) for v in value}) == 1:
        return np.array([[float("nan") if v is None else v for v in row] for row in value])
    return [_arrays(item) for item in value]


def _columns(rows):
    import numpy as np
    names = list(OrderedDict.fromkeys(name for row in rows for name in row))
    columns = OrderedDict()
    for name in names:
        values = [row.get(name) for row in rows]
        if any(isinstance(v, (dict, list)) for v in values):
            continue
        arrays = [v for v in values if isinstance(v, np.ndarray)]
        if arrays:  # x, y, z of a position
            if len({a.shape for a in arrays}) == 1 and arrays[0].ndim == 1 and arrays[0].size <= 9:
                letters = "xyz" if arrays[0].size == 3 else [str(i) for i in range(arrays[0].size)]
                for i, letter in enumerate(letters):
                    columns[f"{name}_{letter}"] = np.array([float("nan") if v is None else v[i] for v in values])
        elif all(isinstance(v, (int, float)) or v is None for v in values):
            columns[name] = np.array([float("nan") if v is None else v for v in values])
        else:
            columns[name] = np.array(values, dtype=object)
    try:
        import pandas
        return pandas.DataFrame(columns)
    except ImportError:
        return dict(columns)
