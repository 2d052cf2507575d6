"""usage: test_terminal.py PLUMBLINE WORK     What people see: no control codes where none belong (TERM=dumb, NO_COLOR, pipes), lines that fit 80 and
200 columns, verdicts in colour, an end that says what came out."""
import os
import pathlib
import re
import shutil
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "support"))
import on_terminal as terminal
from on_terminal import plain

PROGRAM, WORK = os.path.abspath(sys.argv[1]), pathlib.Path(sys.argv[2])
shutil.rmtree(WORK, ignore_errors=True)
WORK.mkdir(parents=True)
BASE = {**{k: v for k, v in os.environ.items() if k not in ("NO_COLOR", "COLUMNS")}, "PLUMBLINE_STORE": str(WORK / "store"), "TERM": "xterm-256color"}
faults = []


def expect(holds, what):
    if not holds:
        faults.append(what)


def on_terminal(words, columns=80, rows=40, **environment):
    return terminal.on_terminal([PROGRAM, *words], columns, rows, WORK, {**BASE, **environment})[1]


run = ["run", "observations", "floors=1", "images_per_floor=6", "--out", "out"]
dumb = on_terminal(run, TERM="dumb")
expect("\x1b" not in dumb, f"TERM=dumb has control codes: {dumb!r}")
expect("\r" not in dumb, f"TERM=dumb writes over its lines: {dumb!r}")
expect("\x1b[3" not in on_terminal(run, NO_COLOR="1"), "NO_COLOR has colours")
ended = plain(on_terminal(run))
expect("Result" in ended and "sigma0" in ended, f"the run ends without its result: {ended[-400:]}")
piped = subprocess.run([PROGRAM, *run], capture_output=True, text=True, cwd=WORK, env=BASE)
expect("\x1b" not in piped.stdout + piped.stderr and "\r" not in piped.stdout, "a pipe gets control codes")

# A verdict that is no pass is seen: the site's anchors are off by more than their tolerance.
judged = on_terminal(["run", "single_floor", "columns=3", "camera=quick_6mp", "--out", "site"])
expect(re.search(r"\x1b\[[0-9;]*m[^\x1b]*FAIL", judged), "no FAIL in colour")
expect("\x1b[" in judged, "a terminal has no colour")
expect(not re.search(r"\b0 \x1b\[3[0-9]m(pass|undecided)", judged), "a count of none is coloured as a verdict")
german = on_terminal(["run", "single_floor", "columns=3", "camera=quick_6mp", "language=de", "--out", "site"])
expect(re.search(r"\x1b\[31m(AUSSERHALB|keine Freigabe)", german), "no AUSSERHALB in colour")
expect("Took part:" in plain(judged), "the run does not say what took part")
expect(not re.search(r"about \d+\.\d+ s", plain(judged)), "time left to hundredths of a second")

# The result of a building is at most a screen, says so where it is shortened, and breaks no word. Its file and a pipe have all of it.
tower = ["run", "building", "floors=4", "--out", "tower"]
for columns, rows in ((80, 24), (200, 24), (80, 60)):
    result = plain(on_terminal(tower, columns, rows)).split("tower/run.jsonl\n")[1].splitlines()
    taken = sum(max(1, -(-len(line) // columns)) for line in result)
    expect(taken < rows, f"the result takes {taken} rows of {rows} at {columns} columns")
    expect(result[0].startswith("Installation:") and "Took part:" in " ".join(result[-3:]), f"the result lacks its beginning or end: {result}")
    expect(any(re.search(r"… \+\d+(: tower/summary.txt| and )", line) for line in result) == (rows == 24), f"at {rows} rows: {result}")
    expect(not any(len(line) > columns and "  " not in line for line in result), f"a sentence is not broken between words: {result}")
# In the longer words of German, and of other lengths, it is a screen, too.
for more in (["language=de"], ["language=de", "units=in"], ["units=in"]):
    for columns in (80, 200):
        result = terminal.result_of(on_terminal([*tower[:-1], "spoken", *more], columns, 24))
        expect(not terminal.too_large(result, columns, 24), f"{' '.join(more)} at {columns} columns: {terminal.too_large(result, columns, 24)}")
        expect(len(result) > 15, f"{' '.join(more)}: no result: {result}")
# A survey in German, to its last line; a file that is left empty is asked for by the name of its parameter.
made = [PROGRAM, "run", str(WORK / "make.yaml"), "--out", "made", "-q"]
(WORK / "make.yaml").write_text("plumbline: 1\nnodes: {site: {use: simulate.campaign, with: {floors: 1, columns: 2, photographs: observed}}}\noutputs: {site: site.folder}\n")
subprocess.run(made, cwd=WORK, env=BASE, capture_output=True)
verdict = " ".join(terminal.result_of(on_terminal(["run", "survey_network", "file=made/site/survey/total_station.gsi", "language=de", "--out", "network"], 80, 24)))
for words in ("überzählig; Datum:", "Größte Abweichungen", "falsch um", "Am unsichersten bei 95 %: in der Lage"):
    expect(words in verdict, f"'{words}' is not in the German result of a survey: {verdict}")
refused = subprocess.run([PROGRAM, "run", "read_survey", "file="], capture_output=True, text=True, cwd=WORK, env=BASE)
expect(refused.returncode == 2 and "parameter 'file'" in refused.stderr and "takes a file, found ''" in refused.stderr, f"an empty file: {refused.stderr}")
whole = (WORK / "tower/summary.txt").read_text()
expect(subprocess.run([PROGRAM, *tower], capture_output=True, text=True, cwd=WORK, env=BASE).stdout.endswith(whole), "a pipe gets less than the summary")

# Tables and help; a word that is longer than its column stands alone.
commands = re.findall(r"^  (\w+) ", on_terminal(["--help"], 200).split("Subcommands:")[1], re.M)
expect(len(commands) > 15 and "describe" in commands, f"commands that --help names: {commands}")
shown = [["--help"], *([command, "--help"] for command in commands), ["bench", "verify", "--help"], ["campaign", "init", "--help"],
         ["list"], ["list", "pipelines"], ["list", "artifacts"], ["describe", "site_campaign"], ["describe", "adjust.schur"],
         ["describe", "colmap.sfm"], ["describe", "pose.opengv"], ["describe", "plumbline.ImageBlock/1"], ["doctor"]]
for columns in (80, 200):
    for words in shown:
        text = plain(on_terminal(words, columns))
        long = [line for line in text.splitlines() if len(line) > columns and (len(line.split()) > 1 or words[0] == "list")]
        expect(not long, f"{' '.join(words)} at {columns} columns: {long[:1]}")
# What matters most is no longer than a line either: a failure, what follows from it, warnings, what a check finds. A word or a command
# between backticks may be.
def too_wide(text, columns):
    return [line for line in plain(text).splitlines() if len(line) > columns and len(re.sub(r"`[^`]*`", "", line).split()) > 1]


for name in [f"Protokoll der Besprechung vom {day}. Mai mit allen Beteiligten.docx" for day in range(1, 9)]:
    (WORK / "made/site" / name).write_text("PK")
for columns in (80, 200):
    for words in (["run", "survey_network", "file=made/site/survey/total_station.gsi", "profile=ics50_assumed", "--out", f"network{columns}"],
                  ["campaign", "check", "made/site"]):
        wide = too_wide(on_terminal(words, columns), columns)
        expect(not wide, f"{' '.join(words)} at {columns} columns: {wide[:1]}")
(WORK / "made/site/survey/dienstag.txt").write_bytes((WORK / "made/site/survey/total_station.gsi").read_bytes())
for columns in (80, 200):
    failed = on_terminal(["run", "site_observations", "folder=made/site", "--out", "failed"], columns)
    expect("FAILED" in plain(failed) and "dienstag.txt" in plain(failed), f"it does not fail: {failed[-400:]}")
    expect(not too_wide(failed, columns), f"a failure at {columns} columns: {too_wide(failed, columns)[:1]}")
refused = subprocess.run([PROGRAM, "run", "site_observations", "folder=made/site", "--out", "failed"], capture_output=True, text=True, cwd=WORK, env=BASE)
expect(any(len(line) > 200 for line in refused.stderr.splitlines()), f"a pipe gets broken lines: {refused.stderr}")
# The headline of a result is never cut, and what fails stands before what explains.
(WORK / "given.txt").write_text("""Installation: FAIL. Anchors against the design: 5 pass, 11 undecided, 2 fail; panels: 0 pass, 2 undecided, 2 fail; surfaces and joints: 0 pass, 0 undecided, 0 fail, 16 not judged.
NOT JUDGED: surfaces, *: flatness(1m)=3mm: 4 of 4 are not judged: """ + "no point was measured on F01-P01; " * 12 + """the last.
  F01-C02-R2           FAIL       vertical -7.58 +- 0.59 mm (limit 5.00)
  F01-C01-R2           FAIL       horizontal 6.35 +- 0.69 mm (limit 5.00)
""" + "".join(f"  F01-C03-R{n}           undecided  horizontal 5.70 +- 0.69 mm (limit 5.00)\n" for n in range(8)) + """  … and 3 more anchors; report.html lists them all
  panel F01-P01        FAIL       slots of the anchors 7.9 mm (limit 5 mm)
  panel F01-P02        FAIL       anchor F01-C02-R2 vertical -7.6 mm (limit 5 mm)
  panel F02-P02        undecided  anchor F02-C02-R1 horizontal 5.5 mm (limit 5 mm)
Anchors and panels pass from a probability of 95 % on that all judged of them is within tolerance.
Tolerance 5.00 mm, for comparisons with a guard band of 1.65 u; u and what stands behind +- are standard uncertainties (1 sigma).
anchors [mm]                number  pass undecided  fail   RMSE_z predicted  max|dz|
check against survey             6     6         0     0     0.30      0.36     0.52
control against survey *        12    12         0     0     0.26      0.31     0.46
* no evidence of accuracy: these anchors took part in the adjustment
check against survey        number      r_f     D(F)     u(D)  verdict    to the floor above
floor 1                          3     0.14     0.14     0.20  pass       0.27 +- 0.31
floor 2                          3    -0.12     0.02     0.33  pass
Took part: 12 photographs, 840 readings, 18 files of the folder.
""")
(WORK / "given.yaml").write_text("plumbline: 1\nnodes: {given: {use: read.file, with: {file: given.txt}}}\noutputs: {summary.txt: given.file}\n")
given = terminal.result_of(on_terminal(["run", "given.yaml", "--out", "given"], 80, 24))
for words in ("0 fail, 16 not judged.", "F01-C02-R2", "F01-C01-R2", "panel F01-P01", "panel F01-P02", "Took part: 12"):
    expect(words in " ".join(given), f"'{words}' is not in the result at 80 x 24: {given}")
expect(not terminal.too_large(given, 80, 24), f"{terminal.too_large(given, 80, 24)}: {given}")
# Where no node says what took part, the files that were named are told, and of a folder what lists were made of it.
expect("Read: 1 file (total_station.gsi)." in plain(on_terminal(["run", "given.yaml", "given.with.file=made/site/survey/total_station.gsi", "--out", "named"], 80, 60)),
       "a run does not say what it read")
for fault in faults:
    print(fault)
sys.exit(1 if faults else 0)
