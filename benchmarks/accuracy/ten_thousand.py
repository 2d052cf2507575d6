#!/usr/bin/env python3
"""What judging thousands of anchors costs: a drawn building through design, judgement, accuracy, as-built IFC, BCF and page.

    benchmarks/accuracy/ten_thousand.py build/bin/plumbline 30 20 SN            2400 anchors, 1140 panels on two facades of 30 storeys
    benchmarks/accuracy/ten_thousand.py build/bin/plumbline 50 25 SENW          10 000 anchors, 4800 panels
    benchmarks/accuracy/ten_thousand.py build/bin/plumbline 30 20 SN --joint    the covariance of all anchors is one matrix, 207 MB

Prints the processor time (user and system) and the peak memory of the program, without the Python that draws the points, and how many anchors
pass. Python's standard library; the node that draws wants Debian's python3-numpy and python3-flatbuffers.
"""
import argparse
import os
import re
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.dont_write_bytecode = True
sys.path.insert(0, str(HERE / "nodes"))
import drawn_building  # noqa: E402


def run(arguments, pipeline, *more):
    """Exit code, processor time [s] and peak memory [bytes] of the program and what it starts."""
    nodes = str(HERE / "nodes")
    settings = {**os.environ, "PLUMBLINE_PLUGIN_PATH": nodes}
    process = subprocess.Popen([arguments.program, "run", str(pipeline), *more], env=settings, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    said = process.stderr.read()
    _, status, used = os.wait4(process.pid, 0)
    code = os.waitstatus_to_exitcode(status)
    if code not in (0, 3):
        sys.exit(f"{pipeline} ended with {code}: {said[-3000:]}")
    return code, used.ru_utime, used.ru_stime, 1024 * used.ru_maxrss


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("program")
    parser.add_argument("floors", type=int)
    parser.add_argument("columns", type=int)
    parser.add_argument("facades", choices=("S", "SN", "SENW"))
    parser.add_argument("--joint", action="store_true", help="all anchors are correlated with all")
    parser.add_argument("--out", help="folder that keeps what was delivered")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="ten_thousand.") as scratch:
        scratch, size = Path(scratch), (arguments.floors, arguments.columns, arguments.facades)
        design, out = scratch / "design.ifc", Path(arguments.out or scratch / "out")
        drawn_building.write_ifc(design, *size)
        anchors, panels = sum(1 for _ in drawn_building.anchors(*size)), sum(1 for _ in drawn_building.panels(*size))
        given = [f"floors={size[0]}", f"columns={size[1]}", f"facades={size[2]}", f"joint={str(arguments.joint).lower()}", "--store", str(scratch / "store")]
        # Drawn beforehand, and taken from the store: that Python is no part of what is measured.
        only_drawn = scratch / "drawn.yaml"
        text = (HERE / "ten_thousand.yaml").read_text()
        only_drawn.write_text(re.sub(r"(?m)^  (?!drawn:)\w+: \{use: .*\n", "", text.split("outputs:")[0]).replace("design: ~, ", ""))
        run(arguments, only_drawn, *given)
        code, user, system, peak = run(arguments, HERE / "ten_thousand.yaml", f"design={design}", *given, "--out", str(out))
        summary = (out / "summary.txt").read_text()
    print(f"{anchors} anchors, {panels} panels, exit code {code}")
    print(f"processor time {user + system:.2f} s ({user:.2f} + {system:.2f} of the system)")
    print(f"peak memory {peak / 1e6:.0f} MB")
    print(next(line for line in summary.splitlines() if "Installation" in line))


main()
