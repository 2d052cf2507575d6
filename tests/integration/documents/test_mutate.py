"""usage: test_mutate.py ROOT WORK     The lines of the documents that call scripts/mutate are typed as they stand, in a tree of one library and one
test (in this tree they take hours). What the test holds is killed, what nobody asks for survives, and so the table says."""
import json
import pathlib
import shutil
import subprocess
import sys

import commands_of_pages

ROOT, WORK = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
FILES = {
    "CMakePresets.json": json.dumps({"version": 3, "configurePresets": [
        {"name": "release", "generator": "Ninja", "binaryDir": "${sourceDir}/build", "cacheVariables": {"CMAKE_BUILD_TYPE": "Release"}}]}),
    "CMakeLists.txt": "cmake_minimum_required(VERSION 3.21)\nproject(small CXX)\nset(CMAKE_CXX_STANDARD 20)\nfind_package(GTest REQUIRED)\n"
                      "add_subdirectory(libraries/area)\nadd_executable(test_area test_area.cpp)\ntarget_link_libraries(test_area area GTest::gtest_main)\n"
                      "set_target_properties(test_area PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)\n",
    "libraries/area/CMakeLists.txt": "add_library(area STATIC area.cpp)\n",
    "libraries/area/area.cpp": "double area(double width, double height) {\n  if (width <= 0 || height <= 0) return 0;\n  return width * height;\n}\n\n"
                               "double rim(double width, double height) {\n  const double twice = 2 * (width + height);\n  return twice;\n}\n",
    # The area is held to its value; of the rim only that it is some number.
    "test_area.cpp": "#include <gtest/gtest.h>\ndouble area(double, double);\ndouble rim(double, double);\nTEST(Area, OfARectangle) {\n"
                     "  EXPECT_EQ(area(2, 3), 6);\n  EXPECT_EQ(area(-1, 3), 0);\n  EXPECT_EQ(area(0, 3), 0);\n  EXPECT_EQ(area(3, -1), 0);\n  EXPECT_EQ(area(0.5, 2), 1);\n  EXPECT_EQ(area(2, 0.5), 1);\n}\n"
                     "TEST(Rim, IsANumber) { EXPECT_NE(rim(2, 3), -1); }\n",
    ".gitignore": "build-mutants/\nbuild/\n",
}


def lines_of_documents():
    """Those of blocks: what builds first, what reads a run last."""
    lines = [line for _, line, block in commands_of_pages.other_lines(ROOT) if block and line.startswith("scripts/mutate --")]
    return sorted(lines, key=lambda line: ("--build" not in line, "--again" in line, "--table" in line))


def typed(line):
    done = subprocess.run(line, shell=True, cwd=WORK, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{line}: exit code {done.returncode}\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return done.stdout


shutil.rmtree(WORK, ignore_errors=True)
for name, text in FILES.items():
    (WORK / name).parent.mkdir(parents=True, exist_ok=True)
    (WORK / name).write_text(text)
shutil.copytree(ROOT / "scripts/mutants", WORK / "scripts/mutants", ignore=shutil.ignore_patterns("__pycache__"))
shutil.copy(ROOT / "scripts/mutate", WORK / "scripts")
typed("mkdir build && git init -q . && git add -A")
lines = lines_of_documents()
if sum("--build" in line for line in lines) < 1 or sum("--run" in line for line in lines) < 3 or sum("--table" in line for line in lines) < 2:
    sys.exit(f"lines of the documents: {lines}")
tables = []
for line in lines:
    # One file has few places, so each gets a switch; the folder of the only test program.
    said = typed(line.split("#")[0].replace("--share 0.12", "--share 1").replace("--build ", "--build --programs test_area "))
    if "--table" in line:
        tables.append(said)
found = [json.loads(line) for line in (WORK / "build-mutants/run.jsonl").read_text().splitlines()]
of_area = [m["result"] for m in found if m["line"] <= 3]
of_rim = [m["result"] for m in found if m["line"] > 5]
faults = []
if len(of_area) < 4 or set(of_area) != {"killed"}:
    faults.append(f"what the test of the area holds: {found}")
if "survived" not in of_rim:
    faults.append(f"what nobody asks for: {found}")
if not all("| libraries/area |" in table and "| all |" in table for table in tables):
    faults.append(f"tables: {tables}")
print(f"{len(lines)} lines typed, {len(found)} places, {len(of_area)} of the area killed")
for fault in faults:
    print(fault)
sys.exit(1 if faults else 0)
