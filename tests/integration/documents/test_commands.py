"""usage: test_commands.py PLUMBLINE ROOT WORK     Every command of every document is run: what stands in code blocks and in spans of the
pages, in folders that hold what the page speaks of. A command that takes minutes runs with PLUMBLINE_LONG only; one that cannot run here is
named with its reason. A command that no rule below knows how to run, and that fails as it stands, is a fault; so is a rule that serves none.
The tutorial and the pages by task are typed in tests of their own, from the first line to the last."""
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import time

import commands_of_pages


PROGRAM, ROOT, WORK = os.path.abspath(sys.argv[1]), pathlib.Path(sys.argv[2]).resolve(), pathlib.Path(sys.argv[3]).resolve()
LONG = bool(os.environ.get("PLUMBLINE_LONG"))
TYPED_ELSEWHERE = ("docs/tutorial.md", "docs/howto/")
DATA = pathlib.Path(os.environ.get("PLUMBLINE_TEST_DATA") or ROOT.parent / "shared/data")

TAGS = "detector=aruco family=DICT_6X6_1000"
SMALL = "floors=2 columns=2 camera=quick_6mp"  # the same pipeline on a site of which the photographs are small
ROUND = "first=true now=2026-05-05T08:00:00Z measured=2026-05-04T08:00:00Z"
MINUTES, WHERE = "LONG: ", "NOT HERE: "
# What is typed for a command (regular expression over the whole line), in the folder that `prepare` makes. The first that fits holds.
RULES = [
    # Names that pages use, where a line is run as it stands otherwise.
    (r"plumbline (new|watch|bench|run|run --rehash|run --isolate|serve|schema|list|describe|doctor|help|cache)", r"plumbline \1 --help"),
    (r"plumbline bench FILE", "plumbline bench quick --seeds 1-2 --out out/quick"),
    (r"plumbline new (TEMPLATE|survey_reader) NAME", "plumbline new survey_reader mine --out NEW"),
    (r"plumbline new (planner|robot) NAME", r"plumbline new \1 mine --out NEW"),
    (r"plumbline new pose_solver plane", "plumbline new pose_solver plane --out NEW"),
    (r"(plumbline (?:describe|doctor|validate|plan|graph|verify|verify --each)) (KIND|FILE|PIPELINE)", None),
    (r"PLUMBLINE_PLUGIN_PATH=build/lib/plumbline plumbline run …|plumbline describe demo.lift|plane/check",
     WHERE + "built against an installation in Installed.TemplatesBuildPassTheirTestsAndRun and Installed.OutsidePlugin"),
    (r"plumbline serve (out.*)", WHERE + "ends when somebody stops it: Serve.* in tests/integration/serve"),
    (r"plumbline watch .*", WHERE + "ends when somebody stops it: Watch.* in tests/integration/cli/test_watch.cpp"),
    (r"plumbline-robots .*|plumbline run site_loop \.\.\. .*", WHERE + "wants a broker and robots: Robots.* in tests/integration/robots"),
    # Sites.
    (r"plumbline run site_campaign folder=june (epoch=\S+ before=out/may/as_built.json)", r"plumbline run site_campaign folder=site \1"),
    (r"(plumbline run (?:site_campaign|site_survey|site_surfaces|survey_campaign|site_campaign_joint)) folder=\S+(.*)", r"\1 folder=site"),
    (r"plumbline run site_campaign", "plumbline run site_campaign folder=site"),
    (r"plumbline run (site_observations|plan_installation) folder=\S+(.*)", r"plumbline run \1 folder=observed\2"),
    (r"plumbline run site_loop folder=(\S+) first=true(.*)", r"plumbline run site_loop folder=site " + ROUND + " --out rounds/1"),
    (r"plumbline run site_loop folder=tuesday .*",
     "plumbline run site_loop folder=site state=rounds/1/state.json now=2026-05-06T08:00:00Z measured=2026-05-05T10:00:00Z --out rounds/2"),
    (r"plumbline run epoch_series .*", "plumbline run epoch_series folder=epochs movements.with.days=[0,30,61]"),
    (r"plumbline campaign (init|check) \S+", r"plumbline campaign check site"),
    # Surveys.
    (r'plumbline run survey_network file=job.gsi "network.with.exclude=.*', 'plumbline run survey_network file=job.gsi "network.with.exclude=[point F01-C03-R2: knocked over, line job.gsi:46: read twice]"'),
    (r"plumbline run survey_network file=job.gsi map=EPSG:25832.*", WHERE + "the survey of the site lies in no map: Georeference.* in tests/unit/survey"),
    (r"plumbline run (?:pipelines/)?(survey_network|read_survey)(?:\.yaml)? file=(?:…|FILE|job\.gsi)(.*?)( --out OUT)?", r"plumbline run \1 file=job.gsi\2"),
    (r"plumbline run survey_network", "plumbline run survey_network file=job.gsi"),
    (r"plumbline run compare_epochs before=a.gsi after=b.gsi.*", "plumbline run compare_epochs before=job.gsi after=job.gsi"),
    (r"plumbline run (.*)file=docs/examples/(.*)", None),
    (r"plumbline run (\S+) (before=docs/examples/.*)", None),
    (r"plumbline run plan_survey file=layout.csv.*", "plumbline run plan_survey file=docs/examples/survey_plan.csv"),
    (r"plumbline show out --relative F01-C01-R1 F03-C04-R2", None),
    (r"plumbline show (…:block.points|RUN/run.jsonl:NODE.PORT)", "plumbline show network/run.jsonl:network.points"),
    (r"plumbline why NODE( \[RUN\])?", "plumbline why network network"),
    (r"plumbline diff RUN RUN.*", "plumbline diff network network --tolerance 1e-9"),
    (r"plumbline export RUN --format (trace|ro-crate)( > \S+)?", r"plumbline export network --format \1"),
    (r"plumbline journal .*", "plumbline journal executed --check"),
    (r"plumbline cache prune.*", "plumbline cache prune --keep 200GiB --days 3000"),
    (r"plumbline run outlier_search .*", "plumbline run outlier_search points=points.csv control=points.csv"),
    # Photographs.
    (r"plumbline example board", "plumbline example another_board"),
    (r"plumbline run photo_campaign folder=\S+(.*)", f"plumbline run photo_campaign folder=board {TAGS}"),
    (r"plumbline run photo_surfaces folder=\S+", f"plumbline run photo_surfaces folder=board {TAGS}"),
    (r"plumbline run detect_images .*", f"plumbline run detect_images folder=board {TAGS}"),
    (r"plumbline run marker_board .*", f"plumbline run marker_board folder=board {TAGS} tag_size=0.0375"),
    (r"plumbline run calibrate_camera folder=\S+ board=\S+(.*?)( --out OUT)?", r"plumbline run calibrate_camera folder=board board=board.yaml\1"),
    (r"plumbline run marker_field .*",
     f"plumbline run marker_field folder=board {TAGS} layout=known/tags.json camera=known_camera/camera.yaml tag_size=0.0375"),
    (r"plumbline run (measure_targets|sfm_control|colmap_control) .*",
     WHERE + "needs photographs of surveyed points that somebody pointed at, which may not be shipped: test_control of tests/unit/markers on rendered ones"),
    (r"plumbline run scan_(surfaces|planes) .*", WHERE + "needs a scan: Surfaces of tests/integration/surface make one"),
    (r"plumbline run image_block folder=blocks/aicon", f"plumbline run image_block folder={DATA}/blocks/aicon"),
    (r'plumbline run image_block folder=… (project|control)=.*|plumbline run image_block(?: folder=… "block.with.free=\[\]")?',
     f'plumbline run image_block folder={DATA}/blocks/aicon "block.with.free=[]"'),
    (r"plumbline run read_design file=building.ifc", "plumbline run read_design file=site/design.ifc"),
    # Simulated sites, small ones.
    (r"plumbline run (single_floor|full_height) camera=quick_6mp optics=real seed=…", MINUTES + r"plumbline run \1 SMALL optics=real"),
    (r"plumbline run (full_height surfaces=on .*)", MINUTES + r"plumbline run \1 camera=quick_6mp"),
    (r"plumbline run (?:pipelines/)?(full_height|full_height_free|single_floor)(?:\.yaml)?(?: camera=quick_6mp)?((?: (?!--out|seed=|camera=)\S+)*)( --out \S+| seed=…)?",
     r"plumbline run \1 SMALL\2"),
    (r"plumbline run full_height camera=hasselblad_100mp", MINUTES + "plumbline run full_height camera=hasselblad_100mp"),
    (r"plumbline run building shape=(\S+)", r"plumbline run building shape=\1 floors=1"),
    (r"plumbline run execution_loop", "plumbline run execution_loop floors=2 --out executed"),
    (r"plumbline run facade_surfaces", MINUTES + "plumbline run facade_surfaces"),
    (r"plumbline graph full_height --format mermaid", None),
    (r"plumbline run (plan_images|observations).*", None),
    # Benches.
    (r"plumbline bench quick --out out/quick", "plumbline bench quick --seeds 1-2 --out out/quick"),
    (r"plumbline bench quick --out out/quick --archive supplement", "plumbline bench quick --seeds 1-2 --out out/quick --archive supplement"),
    (r"plumbline bench verify (\S+).*", "plumbline bench verify supplement --cells 4"),
    (r"plumbline bench quick|plumbline bench benchmarks/paper/quick.yaml", MINUTES + "plumbline bench quick --out out/whole_quick"),
    (r"plumbline bench benchmarks/crossval.yaml folder=…", "plumbline bench benchmarks/crossval.yaml folder=site --seeds 1-2 --out out/crossval"),
    (r"plumbline bench (benchmarks/paper/(?:rendered|detectors).yaml).*", MINUTES + r"plumbline bench \1 --seeds 1 --out out/rendered"),
    (r"plumbline bench (benchmarks/\S+\.yaml).*", MINUTES + r"plumbline bench \1 --seeds 1-2 --out out/paper"),
]
# Lines that call something else than the program.
OTHERS = [
    (r"scripts/(demo|test|setup|package|mutate|measured|docs)\b.*", "what CI itself does, or hours of processor time"),
    (r"(cmake|ninja|ctest)\b.*", "builds this tree"),
    (r"(PLUMBLINE_SHOW=1 )?(build/bin|benchmarks)/\S+.*", "benchmarks, which are no part of the build; their figures stand in their pages"),
    (r"/usr/bin/python3 -m pip install .*", "tests/integration/python/package.sh"),
]
# Parameters that a line of a page has and its command here does not, by the pipeline.
DROPPED = {
    "site_loop": ({"reports.with.json", "reports.with.hilti", "reported_at"}, "reports of robots and tools: tests/integration/loop"),
    "image_block": ({"project", "control", "block.use", "files.with.image_size"}, "blocks of others that may not be shipped: tests/golden"),
    "full_height": ({"camera", "seed"}, "SMALL has a camera of its own"),
    "single_floor": ({"camera", "seed"}, "SMALL has a camera of its own"),
}
SMALL_OF = {"single_floor": "columns=3 camera=quick_6mp"}
# What ends with another exit code than 0, and is right to: a measurement or a judgement that is no result (3).
OTHER_ENDS = {"plumbline run site_surfaces folder=site": 3, "plumbline run observations floors=1 depth_distortion=0.1": 3}

ENVIRONMENT = {**os.environ, "PATH": f"{pathlib.Path(PROGRAM).parent}:{os.environ['PATH']}", "PLUMBLINE_STORE": str(WORK / ".store"),
               "XDG_CACHE_HOME": str(WORK / ".cache"), "PLUMBLINE_PLUGIN_PATH": str(ROOT / "python/examples")}


def shell(line):
    return subprocess.run(["bash", "-c", f"timeout {7200 if LONG else 300} {line}" if line.startswith("plumbline") else line], cwd=WORK,
                          env=ENVIRONMENT, stdin=subprocess.DEVNULL, capture_output=True, text=True)


def must(line):
    done = shell(line)
    if done.returncode:
        sys.exit(f"prepare: {line}: exit code {done.returncode}\n{done.stderr[-2000:]}")


def prepare():
    shutil.rmtree(WORK, ignore_errors=True)
    WORK.mkdir(parents=True)
    for name in ("docs", "benchmarks", "pipelines", "python"):
        (WORK / name).symlink_to(ROOT / name)
    for name, more in (("site", ""), ("observed", ", photographs: observed")):
        (WORK / "make.yaml").write_text("plumbline: 1\nvars: {seed: 2}\nnodes: {site: {use: simulate.campaign, with: {floors: 1, columns: 3, "
                                        f"camera: quick_6mp, images_per_floor: 6{more}}}}}}}\noutputs: {{site: site.folder}}\n")
        must(f"plumbline run make.yaml --out made_{name} -q && cp -r made_{name}/site {name} && chmod -R u+w {name}")
    must("cp site/survey/total_station.gsi job.gsi; mkdir epochs; for day in 1 2 3; do cp job.gsi epochs/day$day.gsi; done")
    (WORK / "epochs/campaign.yaml").write_text("plumbline_campaign: 1\nsurvey: [day1.gsi, day2.gsi, day3.gsi]\n")
    (WORK / "board.yaml").write_text("type: tags\ncolumns: 4\nrows: 5\nmarker: 0.0375\ngap: 0.005\ndictionary: DICT_6X6_1000\n")
    must("plumbline example board")
    must("cut -d, -f1-4 board/control.csv > points.csv")
    must(f"plumbline run marker_board folder=board {TAGS} tag_size=0.0375 --out known -q")
    must("plumbline run calibrate_camera folder=board board=board.yaml --out known_camera -q")
    must("plumbline run survey_network file=job.gsi --out network -q")
    must("plumbline run site_campaign folder=site --out out/may -q")


def typed(line, used):
    """What is run for a line of a page, with the mark of its rule before it."""
    for number, (pattern, instead) in enumerate(RULES):
        match = re.fullmatch(pattern, line)
        if not match:
            continue
        used.add(number)
        if instead is not None:
            return instead if instead.startswith(WHERE) else match.expand(instead)
        break
    for word, by in (("describe KIND", "describe survey.adjust"), ("describe FILE", "describe survey.adjust"), ("FILE", "pipelines/observations.yaml"),
                     ("PIPELINE", "read_survey file=job.gsi")):
        line = re.sub(rf"\b{word}\b", by, line)
    return line


def dropped(line, command):
    """Names of parameters of `line` that `command` lacks and for which no reason is said."""
    names = [set(re.findall(r"(?<![\w.])([A-Za-z_][\w.]*)=", text)) for text in (line, command)]
    pipeline = re.match(r"plumbline run (\S+)", command)
    return sorted(names[0] - names[1] - DROPPED.get(pipeline and pipeline[1], (set(), ""))[0])


prepare()
used, others, ran, faults, later, elsewhere = set(), set(), {}, [], [], []
for page, line in commands_of_pages.all_lines(ROOT):
    if page.startswith(TYPED_ELSEWHERE):
        continue
    command = typed(line, used)
    if command.startswith(WHERE):
        elsewhere.append((page, line, command[len(WHERE):]))
        continue
    if command.startswith(MINUTES):
        command = command[len(MINUTES):]
        if not LONG:
            later.append((page, line))
            continue
    if lost := dropped(line, command):
        faults.append(f"{page}: `{line}`\n  its rule drops {', '.join(lost)}: it runs `{command}`")
    pipeline = command.split()[2] if command.startswith("plumbline run ") else ""
    command = command.replace("SMALL", SMALL_OF.get(pipeline, SMALL))
    if command in ran:
        continue
    if str(DATA) in command and not DATA.exists():
        elsewhere.append((page, line, f"{DATA} is not here"))
        continue
    if command.startswith("plumbline run ") and "--out" not in command and "--help" not in command:
        command_typed = f"{command} --out out/{len(ran)}"
    else:
        command_typed = command
    if command.startswith("plumbline new "):
        shutil.rmtree(WORK / "NEW", ignore_errors=True)
    begin = time.monotonic()
    done = shell(command_typed)
    ran[command] = time.monotonic() - begin
    if done.returncode != OTHER_ENDS.get(command, 0):
        faults.append(f"{page}: `{line}`\n  ran as: {command_typed}\n  exit code {done.returncode}\n  " + "\n  ".join((done.stdout + done.stderr).splitlines()[-4:]))
for page, line in commands_of_pages.other_lines(ROOT):
    if page.startswith(TYPED_ELSEWHERE):
        continue
    reason = next((why for pattern, why in OTHERS if re.fullmatch(pattern, line)), None)
    if reason:
        others.add((page, line, reason))
for number, (pattern, instead) in enumerate(RULES):
    if number not in used:
        faults.append(f"no document has a command for the rule {pattern}")
if len(ran) < 60:
    faults.append(f"only {len(ran)} commands were found")

print(f"{len(ran)} commands run in {sum(ran.values()):.0f} s, the longest:")
for command, seconds in sorted(ran.items(), key=lambda item: -item[1])[:8]:
    print(f"  {seconds:5.1f} s  {command}")
print(f"{len(later)} only with PLUMBLINE_LONG:")
for page, line in later:
    print(f"  {page}: {line}")
print(f"{len(elsewhere) + len(others)} not here:")
for page, line, why in [*elsewhere, *sorted(others)]:
    print(f"  {page}: {line}: {why}")
for fault in faults:
    print(fault)
sys.exit(1 if faults else 0)
