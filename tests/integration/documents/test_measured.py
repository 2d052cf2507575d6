"""usage: test_measured.py ROOT WORK     The rows of docs/measured.toml are data: planted mistakes are named, and a figure that does not come out, or
files that are not there, are told by `scripts/measured --check`."""
import os
import pathlib
import re
import shutil
import subprocess
import sys

ROOT, WORK = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
shutil.rmtree(WORK, ignore_errors=True)
WORK.mkdir(parents=True)
SOUND = """[[part]]
heading = 'One'
[[part.row]]
claim = 'two words are printed'
on = 'this machine'
check = {command = "printf 'rms 1.25 px\\nrms 2.5 px\\n'", values = [{of = 'rms', value = 1.3, tolerance = 0.1, unit = 'px', text = 'rms ([0-9.]+) px'}]}
"""
faults = []


def measured(text, *words, **environment):
    (WORK / "rows.toml").write_text(text, encoding="utf-8")
    done = subprocess.run([sys.executable, ROOT / "scripts/measured", *words, "--data", WORK / "rows.toml"], capture_output=True, text=True,
                          env={**os.environ, **environment})
    return done.returncode, done.stdout + done.stderr


def expect(holds, what):
    if not holds:
        faults.append(what)


def changed(old, new):
    assert old in SOUND, old
    return SOUND.replace(old, new)


code, said = measured(SOUND, "--current")
expect(code == 0, f"a sound row is refused: {said}")
for text, words in (
    (changed("claim = 'two words are printed'\n", ""), "needs 'claim'"),
    (changed("on = 'this machine'\n", ""), "needs 'on'"),
    (SOUND[:SOUND.index("check =")], "needs a check"),
    (changed("tolerance = 0.1, ", ""), "needs 'tolerance'"),
    (changed("value = 1.3", "value = '1.3'"), "needs 'value', a number"),
    (changed("tolerance = 0.1", "tolerance = -0.1"), "not negative"),
    (changed("unit =", "units ="), "unknown key 'units'"),
    (changed("on =", "note = 'x'\nby_hand = 'hours'\non ="), "unknown key 'by_hand'"),
    (changed(", text = 'rms ([0-9.]+) px'", ""), "needs one of"),
    (changed("text = 'rms ([0-9.]+) px'", "text = 'rms ([0-9.+ px'"), "no regular expression"),
    (changed("text = 'rms ([0-9.]+) px'", "file = 'block.json'"), "needs either 'pointer' or 'text'"),
    (changed("text = 'rms ([0-9.]+) px'", "property = 'rms'"), "are of tests"),
    (changed("command =", "test = 'Corners.Are', command ="), "either 'command' or 'test'"),
    (changed("check = {command = \"printf 'rms 1.25 px\\nrms 2.5 px\\n'\"", "check = {test = 'Nobody.IsCalledSo'"), "which is not there"),
    (changed("'two words are printed'", "'" + "two words " * 30 + "'"), "a cell of 3"),
    (SOUND + SOUND[SOUND.index("[[part.row]]"):], "stands twice"),
    (changed("check = {command = \"printf 'rms 1.25 px\\nrms 2.5 px\\n'\"", "check = {test = 'FirstHour.surveyor'").replace(
        "text = 'rms ([0-9.]+) px'", "asserts = 'took " + "4 4'"), "has no line"),
):
    code, said = measured(text, "--current")
    expect(code == 1 and words in said, f"'{words}' is not said of\n{text}\n  but {code}: {said}")

code, said = measured(SOUND, "--check")
expect(code == 0 and "1.25" in said and "as told" in said, f"a figure that comes out: {code}: {said}")
code, said = measured(changed("value = 1.3", "value = 1.5"), "--check")
expect(code == 1 and "NOT AS TOLD" in said, f"a figure that does not come out: {code}: {said}")
code, said = measured(changed("unit = 'px'", "unit = 'px', over = 'most'"), "--check")
expect(code == 1 and " 2.5 " in said, f"the most of what is found: {code}: {said}")
code, said = measured(changed("value = 1.3", "value = 9, most = true"), "--check")
expect(code == 0, f"less where less is as good: {code}: {said}")
code, said = measured(changed("rms 2.5 px\\n'", "rms 2.5 px\\n' $OTHERS/somebody/something"), "--check", "--long", PLUMBLINE_OTHERS=str(WORK))
expect(code == 0 and "not here: somebody/something" in said, f"files that are not there: {code}: {said}")
code, said = measured(changed("check = {command =", "check = {long = true, command ="), "--check")
expect(code == 0 and "0 commands" in said, f"a long one without --long: {code}: {said}")
expect(all(len(line) <= 130 for line in said.splitlines()), f"lines of the table: {said}")

def refused(words, *arguments):
    done = subprocess.run([sys.executable, ROOT / "scripts/measured", *arguments], capture_output=True, text=True)
    said = done.stdout + done.stderr
    expect(done.returncode == 1 and words in said and "Traceback" not in said, f"'{words}' is not said of {arguments} but {done.returncode}: {said}")


# Of the pages themselves: short tables, their long commands in a list with a place to go to; notes in lines.
pages = sorted((ROOT / "docs/measured").glob("*.md"))
expect(len(pages) > 5, f"only {len(pages)} pages of figures")
for file in pages:
    page = file.read_text(encoding="utf-8")
    told, _, notes = page.partition("\n## Notes\n")
    notes = notes.partition("\n## Long commands\n")[0]
    expect(all(len(line) <= 400 for line in told.splitlines()), f"{file.name}: rows of more than 400 characters: {[line[:80] for line in told.splitlines() if len(line) > 400]}")
    expect(all(len(line) <= 200 for line in notes.splitlines()), f"{file.name}: long lines of notes: {[line[:80] for line in notes.splitlines() if len(line) > 200]}")
    for target in set(re.findall(r"\]\(#((?:command|note)-[0-9]+)\)", page)):
        expect(page.count(f'<a id="{target}"></a>') == 1, f"{file.name}: {target} leads nowhere")
    expect(len(page.split()) <= 4000, f"{file.name}: {len(page.split())} words, at most 4000")
expect(any("](#command-1)" in file.read_text(encoding="utf-8") for file in pages), "no command was too long for its row")

(WORK / "none.toml").write_text("rows = 3\n", encoding="utf-8")
(WORK / "broken.toml").write_text("rows =\n", encoding="utf-8")
refused("is a folder", "--check", "--data", WORK)
refused("cannot be read: No such file", "--check", "--data", WORK / "nothing.toml")
refused("has no [[part]]", "--current", "--data", WORK / "none.toml")
refused("is no TOML", "--data", WORK / "broken.toml")
refused("takes a regular expression", "--check", "--only", "(6")
refused("no row's claim or command holds it", "--check", "--only", "nobody claims this")
refused("add --long", "--check", "--only", "^42 kinds of mistakes")

# A script takes the python3 that PATH has first; the one with the modules may be another.
bare = WORK / "bare"
bare.mkdir()
(bare / "python3").write_text("#!/bin/sh\nexit 9\n", encoding="utf-8")
(bare / "python3").chmod(0o755)
path = {"PATH": f"{bare}:{os.environ['PATH']}"}
takes_python = changed("check = {command = \"printf 'rms 1.25 px\\nrms 2.5 px\\n'\"",
                       "check = {modules = ['json'], command = \"env python3 -c \\\"print('rms 1.25 px')\\\"\"")
code, said = measured(takes_python, "--check", **path)
expect(code == 0 and "as told" in said, f"another python3 stands before the one with the modules: {code}: {said}")
code, said = measured(takes_python.replace("'json'", "'nobody_has_this'"), "--check", **path)
expect(code == 0 and "not here: a python3 with nobody_has_this" in said, f"modules that are not there: {code}: {said}")
for fault in faults:
    print(fault)
sys.exit(1 if faults else 0)
