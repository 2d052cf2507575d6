"""usage: test_commands.py PLUMBLINE ROOT WORK [REGEX]     Every command of every document is run: what stands in code blocks and in spans of the
pages, in folders that hold what the page speaks of. command_rules.py says how; a command that no rule there knows, and that fails as it
stands, is a fault; so is a rule that serves none, and a reason for not running one that names no file of the tree.
The tutorial and the pages by task are typed in tests of their own, from the first line to the last; the figures of measured.md by scripts/measured.
What a pipeline ends with is looked at on a terminal of 80 columns and 24 rows, in English and in German.
With a regular expression: only commands in which it is found, in the folder as it is, where there is one."""
import json
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
import urllib.request

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "support"))
import command_rules
import commands_of_pages
import on_terminal
import painted_targets
from command_rules import DROPPED, OTHER_ENDS, OTHERS, ROUND, SERVED, SMALL, SMALL_OF, TAGS, WHERE

PROGRAM, ROOT, WORK = os.path.abspath(sys.argv[1]), pathlib.Path(sys.argv[2]).resolve(), pathlib.Path(sys.argv[3]).resolve()
ONLY = sys.argv[4] if len(sys.argv) > 4 else ""
LONG = bool(os.environ.get("PLUMBLINE_LONG"))
TYPED_ELSEWHERE = ("docs/tutorial.md", "docs/howto/", "docs/measured")  # the last by scripts/measured
DATA = pathlib.Path(os.environ.get("PLUMBLINE_TEST_DATA") or ROOT.parent / "shared/data")
RULES = command_rules.rules(DATA)
ENVIRONMENT = {**os.environ, "PATH": f"{pathlib.Path(PROGRAM).parent}:{os.environ['PATH']}", "PLUMBLINE_STORE": str(WORK / ".store"),
               "XDG_CACHE_HOME": str(WORK / ".cache"), "PLUMBLINE_PLUGIN_PATH": str(ROOT / "python/examples")}


def shell(line):
    return subprocess.run(["bash", "-c", f"timeout 300 {line}" if line.startswith("plumbline") else line], cwd=WORK,
                          env=ENVIRONMENT, stdin=subprocess.DEVNULL, capture_output=True, text=True)


def must(line):
    done = shell(line)
    if done.returncode:
        sys.exit(f"prepare: {line}: exit code {done.returncode}\n{done.stderr[-2000:]}")


def served(line):
    """Starts what serves a page, asks for the page, and stops it as a person does; what went wrong, or nothing."""
    process = subprocess.Popen(line.split(), cwd=WORK, env=ENVIRONMENT, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    late = threading.Timer(60, process.kill)
    late.start()
    said = ""
    while "http" not in said:
        one = process.stdout.readline()
        said += one
        if not one:
            break
    address = re.search(r"http\S+", said)
    browser = urllib.request.build_opener(urllib.request.HTTPCookieProcessor())  # the token comes back as a cookie
    page = browser.open(address[0]).read() if address else b""
    process.send_signal(signal.SIGINT)
    said += process.communicate()[0]
    late.cancel()
    return "" if b"<html" in page and process.returncode in (0, 130) else f"exit code {process.returncode}, page of {len(page)} bytes\n  {said}"


def centre(corners):
    """Where the diagonals of a tag meet."""
    (a, b), (c, d), (e, f), (g, h) = corners
    t = ((c - a) * (d - h) - (d - b) * (c - g)) / ((e - a) * (d - h) - (f - b) * (c - g))
    return a + t * (e - a), b + t * (f - b)


def prepare_sites():
    for name, more in (("site", ""), ("observed", ", photographs: observed"), ("small", "")):
        size = "columns: 2, camera: quick_6mp, images_per_floor: 4" if name == "small" else "columns: 3, camera: quick_6mp, images_per_floor: 6"
        (WORK / "make.yaml").write_text(f"plumbline: 1\nvars: {{seed: 2}}\nnodes: {{site: {{use: simulate.campaign, with: {{floors: 1, {size}{more}}}}}}}\n"
                                        "outputs: {site: site.folder}\n")
        must(f"plumbline run make.yaml --out made_{name} -q && cp -r made_{name}/site {name} && chmod -R u+w {name}")
    must("cp -r site alone && rm -r alone/survey alone/control.csv && sed -i -E '/^(survey|control):/d' alone/campaign.yaml")
    must("cp site/survey/total_station.gsi job.gsi; mkdir epochs; "  # measured again: distances off by less than 0.1 mm
         "for day in 1 2 3; do sed -E 's/(31\\.\\.08\\+[0-9]{15})[0-9] /\\1'$day' /' job.gsi > epochs/day$day.gsi; done; cp epochs/day3.gsi later.gsi")
    (WORK / "epochs/campaign.yaml").write_text("plumbline_campaign: 1\nsurvey: [day1.gsi, day2.gsi, day3.gsi]\n")
    # The same readings on a map: known points at its scale there (k of the central meridian, reduced from 147.5 m), in a block of coordinates.
    with open(WORK / "map.gsi", "w", encoding="ascii") as file:
        for number, row in enumerate((WORK / "site/control.csv").read_text().splitlines()[1:], 9001):
            name, *place = row.split(",")[:4]
            e, n, h = [round(1e3 * (float(value) * scale + there)) for value, scale, there in zip(place, (0.999577, 0.999577, 1), (500000, 5400000, 100))]
            file.write(f"*11{number:04d}+{name:0>16} 81..10+{e:016d} 82..10+{n:016d} 83..10+{h:016d} \n")
        file.write((WORK / "job.gsi").read_text(encoding="ascii"))
    must("plumbline run survey_network file=job.gsi --out network -q")
    must("plumbline run site_campaign folder=site --out out/may -q")
    # A round, and what a robot said when it had done it.
    must(f"plumbline run site_loop folder=site {ROUND} --out rounds/0 -q")
    job = json.loads((WORK / "rounds/0/job.json").read_text())
    done = [{"actionId": f"{job['jobId']}:{item['id']}:{item['revision']}", "actionStatus": "FINISHED"} for item in job["items"]]
    (WORK / "states.jsonl").write_text(json.dumps({
        "headerId": 1, "timestamp": "2026-05-05T09:00:00.00Z", "version": "2.0.0", "manufacturer": "RobotCompany", "serialNumber": "001",
        "orderId": job["jobId"], "orderUpdateId": 0, "lastNodeId": "", "lastNodeSequenceId": 0, "driving": False, "nodeStates": [], "edgeStates": [],
        "actionStates": done, "batteryState": {"batteryCharge": 80, "charging": False}, "operatingMode": "AUTOMATIC", "errors": [],
        "safetyState": {"eStop": "NONE", "fieldViolation": False}}) + "\n")


def prepare_photographs():
    """A public board as the points that were surveyed on it: measured in the photographs, pointed at, and in a COLMAP model."""
    (WORK / "board.yaml").write_text("type: tags\ncolumns: 4\nrows: 5\nmarker: 0.0375\ngap: 0.005\ndictionary: DICT_6X6_1000\n")
    must("plumbline example board")
    must("cut -d, -f1-4 board/control.csv > points.csv; mkdir few; cp board/board_??.jpg few; rm few/board_?[39].jpg")
    (WORK / "model.yaml").write_text("plumbline: 1\ninclude: [pipelines/marker_board.yaml]\nnodes: {model: {use: write.colmap, in: {poses: block.poses, "
                                     "cameras: [block.cameras], points: block.points, observations: all.observations}}}\noutputs: {sparse: model.model}\n")
    must(f"plumbline run model.yaml folder=board {TAGS} tag_size=0.0375 --out known -q")
    must("plumbline run calibrate_camera folder=board board=board.yaml --out known_camera -q")
    of_tag = {row.split(",")[3]: row.split(",")[0] for row in (WORK / "board/plates.csv").read_text().splitlines()[1:]}
    measured, clicked = ["image,point,x,y"], ["image,point,x,y"]
    for image in json.loads((WORK / "known/observations.json").read_text())["images"]:
        for tag in image["tags"]:
            x, y = centre(tag["corners"])
            measured.append(f"{image['path']},{of_tag[str(tag['id'])]},{x:.3f},{y:.3f}")
            clicked.append("{},T{},{:.1f},{:.1f}".format(image["path"], tag["id"], *tag["corners"][0]))
    (WORK / "measured.csv").write_text("\n".join(measured) + "\n")
    (WORK / "clicked.csv").write_text("\n".join(clicked) + "\n")
    (WORK / "sets.json").write_text(json.dumps([{"name": "board", "folder": "few", "pattern": "*.jpg", "family": "DICT_6X6_1000", "tag_size": "0.0375",
                                                 "detector": "aruco"}]))
    painted_targets.write(WORK)
    # A repository as calibration_sets.py clones them.
    must("mkdir -p clones/somebody+board && cp -r few clones/somebody+board/few && cd clones/somebody+board && git init -q . && git add -A && "
         "git -c user.name=n -c user.email=m commit -q -m board")
    (WORK / "calibration_sets.json").write_text(json.dumps({"board": ["somebody/board", "HEAD", "few/*.jpg", (WORK / "board.yaml").read_text()]}))


def prepare():
    shutil.rmtree(WORK, ignore_errors=True)
    WORK.mkdir(parents=True)
    for name in ("docs", "benchmarks", "pipelines", "python", "scripts"):
        (WORK / name).symlink_to(ROOT / name)
    prepare_sites()
    prepare_photographs()
    # The panel of the small site as a scanner sees it, with 1 mm of noise; as LAS by what writes clouds.
    dice = random.Random(1)
    (WORK / "scan.xyz").write_text("".join(f"{1.005 + 0.01 * i:.3f} {dice.gauss(-0.225, 0.001):.4f} {0.005 + 0.01 * k:.3f}\n" for i in range(200) for k in range(400)))
    must("plumbline run scan_planes scan=scan.xyz unit=m 'planes.with.seen_from=[2, -8, 1.6]' --out planes -q && cp planes/cloud/*.las scan.las")
    (WORK / "mutants.jsonl").write_text(json.dumps({"file": "libraries/survey/x.cpp", "line": 1, "rule": "a < b", "is": "a <= b", "tests": 2, "result": "killed"}) + "\n")


def ruled(line, rules, used, kind):
    """What is typed for a line by the first rule that fits, or nothing."""
    for number, (pattern, instead) in enumerate(rules):
        match = re.fullmatch(pattern, line)
        if match:
            used.add((kind, number))
            return line if instead is None else instead if instead.startswith(WHERE) else match.expand(instead)
    return None


def typed(line, used):
    found = ruled(line, RULES, used, "rule")
    if found is not None and found != line:
        return found
    for word, by in (("describe KIND", "describe survey.adjust"), ("describe FILE", "describe survey.adjust"), ("FILE", "pipelines/observations.yaml"),
                     ("PIPELINE", "read_survey file=job.gsi")):
        line = re.sub(rf"\b{word}\b", by, line)
    return line


def dropped(line, command):
    """Names of parameters of `line` that `command` lacks and for which no reason is said."""
    names = [set(re.findall(r"(?<![\w.])([A-Za-z_][\w.]*)=", text)) for text in (line, command)]
    pipeline = re.match(r"plumbline run (\S+)", command)
    return sorted(names[0] - names[1] - DROPPED.get(pipeline and pipeline[1], (set(), ""))[0])


used, ran, faults, elsewhere, checked = set(), {}, [], [], set()


def not_here(page, line, why):
    named = re.findall(r"(?:tests|scripts|benchmarks|\.ci)/[\w./]+\w", why)
    if not named or not all((ROOT / file).exists() for file in named):
        faults.append(f"{page}: `{line}`: the reason for not running it names no file of the tree: {why}")
    elsewhere.append((page, line, why))


def exit_fault(code, right, said):
    return "" if code == right else f"exit code {code}\n  " + "\n  ".join(said.splitlines()[-4:])


def ends_on_a_screen(command, right):
    """Runs a pipeline on a terminal of 80 columns and 24 rows, in German again where it speaks it (from the store, so only what writes): the
    result stands at the end and fits."""
    name = re.match(r"(?:plumbline run )(\S+)", command)[1]
    file = next((f for f in (WORK / name, ROOT / "pipelines" / f"{name}.yaml") if f.is_file()), None)
    spoken = file and re.search(r"[{ ]language: ", file.read_text()) and "language=" not in command
    for line in (command, re.sub(r"--out (\S+)", r"language=de --out \1_de", command))[:2 if spoken else 1]:
        if line != command:  # the same round once more into another folder would be another job for the same robots
            for note in WORK.glob("rounds/*/journal.next"):
                note.unlink()
        code, said = on_terminal.on_terminal(["bash", "-c", f"timeout 300 {line}"], 80, 24, WORK, {**ENVIRONMENT, "TERM": "xterm"})
        if wrong := exit_fault(code, right, on_terminal.plain(said)):
            return wrong
        told = on_terminal.result_of(said)
        if not any(told) or "run.jsonl" not in said:
            return f"it ends without its result: {line}"
        if wrong := on_terminal.too_large(told, 80, 24):
            return f"its result does not fit a screen: {line}\n  {wrong}"
    return ""


def run(page, line, command):
    if command in ran or not re.search(ONLY, command):
        return
    begin = time.monotonic()
    if command.startswith(SERVED):
        wrong = served(command[len(SERVED):])
    else:
        with_output = command
        if command.startswith("plumbline run ") and "--out" not in command and "--help" not in command:
            with_output = f"{command} --out out/{len(ran)}"
        if command.startswith("plumbline new "):
            shutil.rmtree(WORK / "NEW", ignore_errors=True)
        if re.match(r"plumbline run (?!.*(--help|--json))", command):
            wrong = ends_on_a_screen(with_output, OTHER_ENDS.get(command, 0))
        else:
            done = shell(with_output)
            wrong = exit_fault(done.returncode, OTHER_ENDS.get(command, 0), done.stdout + done.stderr)
    ran[command] = time.monotonic() - begin
    if wrong:
        faults.append(f"{page}: `{line}`\n  ran as: {command}\n  {wrong}")


def of_program(page, line):
    command = typed(line, used)
    if command.startswith(WHERE):
        return not_here(page, line, command[len(WHERE):])
    pipeline = command.split()[2] if command.startswith("plumbline run ") else ""
    command = command.replace("SMALL", SMALL_OF.get(pipeline, SMALL))
    if lost := dropped(line, command):
        faults.append(f"{page}: `{line}`\n  its rule drops {', '.join(lost)}: it runs `{command}`")
    if str(DATA) in command and not DATA.exists():
        return elsewhere.append((page, line, f"{DATA} is not here"))
    run(page, line, command)


def of_others(page, line, block):
    """Scripts and programs of the benchmarks. test_words.py holds them to their words, whether they are run or not."""
    command = ruled(line, OTHERS, used, "other")
    if command is None:  # what a page names in passing, or as the source of a figure
        return checked.add(line) if not block else faults.append(f"{page}: `{line}`: no rule says how it is run")
    if command.startswith(WHERE):
        return not_here(page, line, command[len(WHERE):])
    for name in re.findall(r"PROGRAMS/(\S+)", command):
        if not (pathlib.Path(PROGRAM).parent / name).exists():
            if LONG:
                faults.append(f"{page}: `{line}`: {name} is not built")
            return checked.add(line)  # built and run by scripts/test --long
    if "camera_mistakes" in command and subprocess.run(["python3", "-c", "import cv2"], capture_output=True).returncode:
        return not_here(page, line, "needs python3-opencv, as benchmarks/camera_mistakes/camera_mistakes.py says")
    run(page, line, command.replace("PROGRAMS", str(pathlib.Path(PROGRAM).parent)))


if not (ONLY and WORK.exists()):
    prepare()
for page, line in commands_of_pages.all_lines(ROOT):
    if not page.startswith(TYPED_ELSEWHERE):
        of_program(page, line)
for page, line, block in commands_of_pages.other_lines(ROOT):
    if not page.startswith(TYPED_ELSEWHERE):
        for part in line.split(" && "):
            of_others(page, part, block)
for kind, rules in (("rule", RULES), ("other", OTHERS)):
    for number, (pattern, instead) in enumerate(rules):
        if (kind, number) not in used:
            faults.append(f"no document has a command for the rule {pattern}")
if len(ran) < 100 and not ONLY:
    faults.append(f"only {len(ran)} commands were found")

print(f"{len(ran)} commands run in {sum(ran.values()):.0f} s, the longest:")
for command, seconds in sorted(ran.items(), key=lambda item: -item[1])[:12]:
    print(f"  {seconds:5.1f} s  {command}")
print(f"{len(checked)} held to the words that their programs take: hours, or data of others")
print(f"{len(elsewhere)} not here, and held to their words:")
for page, line, why in sorted(set(elsewhere)):
    print(f"  {page}: {line}: {why}")
for fault in faults:
    print(fault)
sys.exit(1 if faults else 0)
