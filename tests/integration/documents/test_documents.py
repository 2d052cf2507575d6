"""usage: test_documents.py PLUMBLINE ROOT     Every link of every document leads somewhere, every table is one, and every command line
with `plumbline` in it is one that the program takes: command, options, pipeline, variables."""
import functools
import json
import os
import pathlib
import re
import shlex
import subprocess
import sys


PROGRAM, ROOT = os.path.abspath(sys.argv[1]), pathlib.Path(sys.argv[2])
PAGES = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"), *ROOT.glob("benchmarks/**/*.md")])
PAGES = [page for page in PAGES if "reference" not in page.parts]
faults = []


@functools.cache
def ask(*words):
    done = subprocess.run([PROGRAM, *words], capture_output=True, text=True, cwd=ROOT)
    return done.stdout if done.returncode == 0 else None


COMMANDS = [line.split()[0] for line in ask("--help").split("Subcommands:")[-1].splitlines() if line[:2] == "  " and line[2:3].strip()]
PIPELINES = {p["name"] for p in json.loads(ask("list", "pipelines", "--json"))}
BENCHES = {file.stem for file in ROOT.glob("benchmarks/**/*.yaml")}


def slug(heading):
    """As GitHub makes an anchor of a heading."""
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).strip().lower()
    return re.sub(r"[^\w\- ]", "", text).replace(" ", "-")


@functools.cache
def anchors(page):
    text = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)
    return {slug(m.group(1)) for m in re.finditer(r"^#+ +(.*)$", text, re.M)} | set(re.findall(r'<a id="([^"]+)">', text))


def check_links(page, text):
    text = re.sub(r"^```.*?^```", "", text, flags=re.M | re.S)
    for match in re.finditer(r"\]\(([^)\s]+)\)", text):
        target = match.group(1)
        if re.match(r"[a-z]+:", target):
            continue
        path, _, anchor = target.partition("#")
        there = (page.parent / path).resolve() if path else page
        if not there.exists():
            faults.append(f"{page}: {target}: there is no such file")
        elif anchor and there.suffix == ".md" and anchor not in anchors(there):
            faults.append(f"{page}: {target}: there is no such heading")


def check_tables(page, text):
    lines = re.sub(r"^```.*?^```", lambda m: "\n" * m.group().count("\n"), text, flags=re.M | re.S).splitlines()
    for number, line in enumerate(lines):
        if not line.startswith("|"):
            continue
        first = number
        while first > 0 and lines[first - 1].startswith("|"):
            first -= 1
        if first + 1 >= len(lines) or not re.fullmatch(r"\|(\s*:?-+:?\s*\|)+", lines[first + 1].strip()):
            faults.append(f"{page}:{number + 1}: a row that stands in no table")


def command_lines(text):
    """Lines of code blocks, and code spans, that call the program."""
    for block in re.finditer(r"^```(.*?)\n(.*?)^```", text, re.M | re.S):
        if block.group(1) in ("", "sh", "bash"):
            yield from block.group(2).replace("\\\n", " ").splitlines()
    for span in re.finditer(r"(?<!`)(`+)(?!`)(.+?)(?<!`)\1(?!`)", re.sub(r"^```.*?^```", "", text, flags=re.M | re.S), re.S):
        yield span.group(2).replace("\n", " ")


def is_open(word):
    """A place that the reader fills: NAME, FOLDER, …"""
    return not word or "…" in word or "..." in word or re.fullmatch(r"[A-Z][A-Z0-9_.:/-]*", word) or word.startswith(("$", "[", "<"))


def variables_of(pipeline):
    told = ask("describe", pipeline, "--json")
    return {v["name"] for v in json.loads(told)["variables"]} if told else set()


def check_command(page, line):
    line = line.split("#")[0].split(" | ")[0].split(" && ")[0].split("; ")[0].strip()
    line = re.sub(r"^(?:\$ )?(?:[A-Z_]+=\S+\s+)*", "", line)
    match = re.match(r"\$?(?:\S*/)?plumbline\s+(.*)$", line)
    if not match:
        return
    try:
        words = shlex.split(match.group(1).replace("[", "").replace("]", ""))
    except ValueError:
        faults.append(f"{page}: `{line}`: its quotes do not match")
        return
    words = [w for w in words if w not in (">", ">>")]
    if not words or is_open(words[0]):
        return
    command = words.pop(0)
    if command in ("--version", "--help", "help", "version"):
        return
    if command not in COMMANDS:
        faults.append(f"{page}: `{line}`: there is no command '{command}'")
        return
    help_words = [command]
    if words and command in ("campaign", "bench", "cache") and not is_open(words[0]) and ask(command, words[0], "--help") and re.search(r"^  " + re.escape(words[0]) + r"\b", ask(command, "--help") or "", re.M):
        help_words.append(words.pop(0))
    known = ask(*help_words, "--help") or ""
    for word in words:
        if word.startswith("--") and not re.search(re.escape(word.split("=")[0]) + r"\b", known):
            faults.append(f"{page}: `{line}`: `{' '.join(help_words)}` has no option {word}")
    plain = [w for w in words if not w.startswith("-")]
    if command in ("run", "watch", "plan", "validate", "graph", "verify") and plain and not is_open(plain[0]):
        pipeline = plain[0]
        of_tree = pipeline.endswith(".yaml") and (ROOT / pipeline).exists()
        if pipeline not in PIPELINES and not of_tree:
            if "/" in pipeline or not pipeline.endswith(".yaml"):  # a file of the reader's own may be called as it likes
                faults.append(f"{page}: `{line}`: there is no pipeline '{pipeline}'")
            return
        known_variables = variables_of(pipeline)
        for word in plain[1:]:
            key = word.partition("=")[0]
            if "=" in word and "." not in key and key != "seed" and not is_open(key) and key not in known_variables:
                faults.append(f"{page}: `{line}`: {pipeline} has no variable '{key}'; it has {', '.join(sorted(known_variables))}")
    if command == "bench" and plain and plain[0] != "verify" and not is_open(plain[0]):
        own = plain[0].endswith(".yaml") and "/" not in plain[0]
        if not own and plain[0] not in BENCHES and not (ROOT / plain[0]).exists():
            faults.append(f"{page}: `{line}`: there is no bench '{plain[0]}'")
    if command == "describe" and plain and not is_open(plain[0]) and not re.search(r"\b(mine|demo|plane|my|own|lift|squares)\b", plain[0]):
        if ask("describe", plain[0]) is None:
            faults.append(f"{page}: `{line}`: there is nothing of that name")


for page in PAGES:
    text = page.read_text(encoding="utf-8")
    check_links(page, text)
    check_tables(page, text)
    if page.name != "CHANGELOG.md":
        for line in command_lines(text):
            check_command(page.relative_to(ROOT), line)
guide = (ROOT / "docs/writing_a_plugin.md").read_text(encoding="utf-8")
adjuster = (ROOT / "templates/adjuster/@name@.cpp").read_text(encoding="utf-8").replace("@name@", "mine")
if f"```cpp\n{adjuster}```" not in guide:
    faults.append("the adjuster of docs/writing_a_plugin.md is not that of templates/adjuster")
if adjuster.count("\n") > 60:
    faults.append(f"the adjuster of the guide has {adjuster.count(chr(10))} lines")
told = re.search(r"^## (\d+\.\d+\.\d+)", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.M)
versions = {"CHANGELOG.md": told.group(1) if told else "", "plumbline --version": ask("--version").split()[1],
            "python/pyproject.toml": re.search(r'^version = "(.*)"', (ROOT / "python/pyproject.toml").read_text(), re.M).group(1),
            "python/plumbline/__init__.py": re.search(r'^__version__ = "(.*)"', (ROOT / "python/plumbline/__init__.py").read_text(), re.M).group(1)}
if len(set(versions.values())) != 1:
    faults.append(f"the versions differ: {versions}")
if not re.search(r"\(commit (unknown|[0-9a-f]{7,}(-dirty)?)\)", ask("--version")):
    faults.append(f"plumbline --version says no commit: {ask('--version')}")
summary = subprocess.run([sys.executable, ROOT / "benchmarks/paper/results", "--check"], capture_output=True, text=True)
if summary.returncode != 0:
    faults.append(summary.stderr.strip())
print(f"{len(PAGES)} pages")
for fault in faults:
    print(fault)
sys.exit(1 if faults else 0)
