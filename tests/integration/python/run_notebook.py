"""usage: run_notebook.py NOTEBOOK WORK PYTHON     Executes the cells of a notebook one after the other in the folder WORK, with the package
in PYTHON, as a kernel would; pictures are drawn without a screen. Says which cell failed. 77: a module it needs is not there."""
import importlib.util
import json
import os
import pathlib
import shutil
import sys
import traceback

notebook, work, package = (pathlib.Path(argument).resolve() for argument in sys.argv[1:4])
shutil.rmtree(work, ignore_errors=True)
work.mkdir(parents=True)
os.chdir(work)
sys.path.insert(0, str(package))
os.environ.update(MPLBACKEND="Agg", PLUMBLINE_STORE=str(work / "store"), XDG_CACHE_HOME=str(work / "cache"), MPLCONFIGDIR=str(work / "mpl"))
cells = [cell for cell in json.loads(notebook.read_text(encoding="utf-8"))["cells"] if cell["cell_type"] == "code"]
text = "".join("".join(cell["source"]) for cell in cells)
for module in ("numpy", "flatbuffers", "matplotlib"):
    if (module in text or module != "matplotlib") and importlib.util.find_spec(module) is None:
        print(f"skipped: {sys.executable} has no {module}")
        sys.exit(77)
names = {"__name__": "__main__"}
for number, cell in enumerate(cells, 1):
    if cell.get("outputs"):
        sys.exit(f"{notebook}: cell {number} is kept with its output: clear it")
    try:
        exec(compile("".join(cell["source"]), f"{notebook.name} cell {number}", "exec"), names)
    except BaseException:
        traceback.print_exc()
        sys.exit(f"{notebook}: cell {number} failed")
