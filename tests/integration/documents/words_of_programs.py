"""Whether a line of a document is one that its program takes, without running it: the program is there, and takes these words, by its own
parser (Python's argparse) or by the usage at the head of its source. What takes hours, or what only others have, is held by this."""
import json
import pathlib
import re
import shlex
import subprocess
import sys

# Runs a script up to where its parser has taken the words.
PARSED = """
import argparse, importlib.util, runpy, sys, unittest.mock
for name in ("cv2", "numpy"):
    if not importlib.util.find_spec(name):
        sys.modules[name] = unittest.mock.MagicMock()
taken = argparse.ArgumentParser.parse_args
def stop(self, *words, **named):
    taken(self, *words, **named)
    print("the words were taken")
    sys.exit(0)
argparse.ArgumentParser.parse_args = stop
sys.dont_write_bytecode = True
sys.argv = sys.argv[1:]
runpy.run_path(sys.argv[0], run_name="__main__")
"""
PLACE = r"[A-Z][A-Z0-9_]*(\.\w+)?"  # in a usage, what the reader fills in


def as_pattern(usage):
    """A usage as a regular expression of words that each have a NUL before them: `FOLDER [RUNS [known]]`, `a | b`, `FILE...`, `[--most N]`."""
    pattern = ""
    for token in re.findall(r"\[|\]|\||\.\.\.|(?:(?!\.\.\.)[^\s\[\]|])+", usage):
        if token in "[]|":
            pattern += {"[": "(?:", "]": ")?", "|": "|"}[token]
        elif token == "...":
            pattern = re.sub(r"(\(\?:\\0(?:\(\?!--\))?[^()]*\))$", r"\1+", pattern)
        elif "=" in token:
            pattern += r"(?:\0\w[\w.]*=[^\0]+)"
        else:
            pattern += r"(?:\0(?!--)[^\0]*)" if re.fullmatch(PLACE, token) else rf"(?:\0{re.escape(token)})"
    return pattern


def usages(source, name):
    """The words behind the program's name where the head of its source says how it is called; a usage that goes on is indented."""
    lines = [re.sub(r"^\s*(//|#)", "", line) for line in source.read_text(encoding="utf-8").splitlines()[:30]]
    found = []
    for i, line in enumerate(lines):
        for match in re.finditer(rf"(?:^|[\s/\"]){re.escape(name)}(?=\s|$)([^:]*?)(?=\s{{2,}}|(?<!\.)[.,;:](?:\s|$)|$)", line):
            if not re.search(r"[a-z] [a-z]+ [a-z]", re.sub(r"\[.*\]", "", match[1])):  # words of a sentence
                found.append(match[1])
    return found


def source_of(root, program):
    """Where a program comes from, None if there is none, and of several names of one kind the first."""
    if "/" in program and not program.startswith("build/"):
        return next((file for file in [root / program] if file.is_file()), None)
    name = program.split("/")[-1]
    if name.endswith(".py"):
        return next((file for top in ("benchmarks", "tests", "scripts", "docs") for file in sorted((root / top).rglob(name))), None)
    for lists in (root / "benchmarks").glob("*/CMakeLists.txt"):
        if made := re.search(rf"add_executable\({name} (\S+?\.cpp)", lists.read_text(encoding="utf-8")):
            return lists.parent / made[1]
    return None


def of_build_tools(root, words):
    """ctest, cmake and ninja in this tree: presets, options of ours, names of tests and of programs."""
    line, wrong = " ".join(words), []
    presets = {p["name"] for kind, listed in json.loads((root / "CMakePresets.json").read_text()).items() if kind.endswith("Presets") for p in listed}
    # Not of build folders: other tests make and take away folders there meanwhile.
    tops = [top for top in root.iterdir() if top.is_dir() and not top.name.startswith(("build", "."))]
    lists = "".join(file.read_text(encoding="utf-8") for top in [root, *tops]
                    for file in (top.glob("CMakeLists.txt") if top == root else top.rglob("CMakeLists.txt")))
    tests = lists + "".join(file.read_text(encoding="utf-8") for file in (root / "tests").rglob("*.cpp"))
    wrong += [f"there is no preset {name}" for name in re.findall(r"--preset (\S+)", line) if name not in presets]
    wrong += [f"there is no option {name}" for name in re.findall(r"-D(PLUMBLINE_\w+)", line) if f"option({name} " not in lists]
    wrong += [f"no test is called {name}" for name in re.findall(r" -R (\S+)", line)
              if not re.search(rf"\b{re.escape(name)}|\({re.escape(name).replace(chr(92) + '.', ',[ ]*')}", tests)
              and not ("." in name and re.search(rf"\b{name.split('.')[0]}\.\$\{{", lists) and re.search(rf"\b{name.split('.')[1]}\b", lists))]
    if words[0] == "ninja":
        wrong += [f"nothing is called {name} that could be built" for name in words[1:]
                  if not name.startswith("-") and name != "build" and not re.search(rf"(add_executable|plumbline_add_test)\({name}\b", lists)]
    return "; ".join(wrong)


def fault(root, line):
    """What is wrong with the line, or nothing."""
    words = shlex.split(re.sub(r"^(?:[A-Z_]+=\S+ )*", "", line.split(" | ")[0].replace("[", " ").replace("]", " ")))
    words = [word.removesuffix("...") for word in words if word != "..."]
    if words[0] in ("ctest", "cmake", "ninja"):
        return "" if "-S" in words else of_build_tools(root, words)
    if words[0].startswith("build/tests/"):
        return of_build_tools(root, ["ninja", words[0].split("/")[-1]])
    if words[0].startswith("/usr/bin/"):
        return ""
    source = source_of(root, words[0])
    if source is None:
        return f"there is no program {words[0]}"
    if len(words) == 1:
        return ""  # it is only named
    if source.suffix == ".py" or source.read_bytes().startswith(b"#!/usr/bin/env python3"):
        if "argparse" in source.read_text(encoding="utf-8"):
            done = subprocess.run([sys.executable, "-c", PARSED, source, *words[1:]], capture_output=True, text=True)
            return "" if "the words were taken" in done.stdout else "its parser says: " + (done.stderr.strip() or "nothing").splitlines()[-1]
    told = usages(source, words[0].split("/")[-1])
    given = "".join("\0" + word for word in words[1:])
    if any(re.fullmatch(as_pattern(usage), given) for usage in told):
        return ""
    return f"{source.relative_to(root)} says it is called as: " + "; ".join(usage.strip() for usage in told)
