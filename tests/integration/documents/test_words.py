"""usage: test_words.py ROOT     Lines of documents that call scripts and programs of benchmarks, those that are not run among them, hold words
that their programs take; planted slips of the pen are found."""
import os
import pathlib
import re
import sys

import commands_of_pages
import words_of_programs

ROOT = pathlib.Path(sys.argv[1])
PLANTED = ["scripts/mutate --biuld --files 3", "scripts/mutate --run --most many", "scripts/mutate --run --agian old.jsonl", "scripts/test --slow",
           "benchmarks/calibration/calibration_sets.py --folder FOLDER", "benchmarks/site_mistakes/site_mistakes.py build/bin/plumbline --campains 20",
           "loop_benchmark 1 2 3 4 5 6 7 8 9 10", "judgement_benchmark false_pass 100", "build/bin/detect_benchmark compare FAMILY a.jpg --repet 3",
           "detct_benchmark scene x.jpg", "strecha.py PLUMBLINE FOLDER", "stereo_benchmark fountain", "cmake --preset relase",
           "cmake -DPLUMBLINE_BENCHMARK=ON", "ctest -R Nobody.IsCalledSo", "ninja -C build survey_benchmark"]
faults, lines = [], 0
for page, line, _ in commands_of_pages.other_lines(ROOT):
    for part in line.split(" && "):
        lines += 1
        script = ROOT / part.split()[0]
        if re.match(r"(benchmarks|scripts)/", part) and script.is_file() and not os.access(script, os.X_OK):
            faults.append(f"{page}: `{part}`: the script cannot be called so, it is not executable")
        if wrong := words_of_programs.fault(ROOT, part):
            faults.append(f"{page}: `{part}`: {wrong}")
for line in PLANTED:
    if not words_of_programs.fault(ROOT, line):
        faults.append(f"`{line}` is taken for right")
if lines < 100:
    faults.append(f"only {lines} lines were found")
print(f"{lines} lines")
for fault in faults:
    print(fault)
sys.exit(1 if faults else 0)
