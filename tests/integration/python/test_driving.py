"""usage: test_driving.py PLUMBLINE PYTHON     What `import plumbline` does where the program refuses, where it is interrupted, and with what lies there
from another time. Needs nothing but Python."""
import importlib.util
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import unittest.mock
import warnings

PROGRAM = os.path.abspath(sys.argv.pop(1))
sys.path.insert(0, sys.argv.pop(1))
sys.dont_write_bytecode = True
import plumbline  # noqa: E402

SLOW = "plumbline: 1\nvars: {seed: 3}\nnodes: {site: {use: simulate.campaign, with: {floors: 3, columns: 4, camera: quick_6mp, images_per_floor: 8}}}\noutputs: {site: site.folder}\n"


class Driving(unittest.TestCase):
    def setUp(self):
        place = tempfile.TemporaryDirectory()
        self.addCleanup(place.cleanup)
        self.work = pathlib.Path(place.name) / "a folder"
        self.work.mkdir()
        os.chdir(self.work)
        self.addCleanup(os.chdir, "/")
        os.environ.update(PLUMBLINE=PROGRAM, PLUMBLINE_STORE=str(self.work / "store"), XDG_CACHE_HOME=str(self.work / "cache"))
        pathlib.Path("points.csv").write_text("name,E,N,H,sigma\nA,1,2,3,0.001\n")
        pathlib.Path("p.yaml").write_text("plumbline: 1\nvars: {file: points.csv}\nnodes:\n  points: {use: read.points, with: {file: \"${file}\"}}\noutputs: {points.json: points.points}\n")
        pathlib.Path("slow.yaml").write_text(SLOW)

    def running(self):
        told = subprocess.run(["pgrep", "-f", f"{self.work}/out of slow"], capture_output=True, text=True).stdout
        return told.split()

    def test_pipes_are_closed_and_none_keeps_the_default(self):
        with warnings.catch_warnings():
            warnings.simplefilter("error", ResourceWarning)
            run = plumbline.run("p.yaml", out="out dir", file=None)
        self.assertEqual((run.status, run.nodes["points"].status, str(run.outputs["points.json"])), ("ok", "executed", "out dir/points.json"))

    def test_rounds_that_did_not_end_are_not_usable(self):
        table = "name,E,N,H,sigma\n" + "".join(f"P{i},{3 * i},{i * i % 7},{i % 3},0.001\n" for i in range(9))
        pathlib.Path("control.csv").write_text(table)
        pathlib.Path("measured.csv").write_text(table.replace("P4,12,2,1", "P4,12.05,2,1").replace("P7,21,0,1", "P7,21,0.04,1"))
        with self.assertWarnsRegex(plumbline.NotUsable, "its rounds did not come to their end"):
            run = plumbline.run("outlier_search", out="r", points="measured.csv", control="control.csv", set={"rounds.most": 1})
        for one in (run, plumbline.Run("r")):
            self.assertEqual((one.status, one.usable), ("ok", False))
        crate = subprocess.run([PROGRAM, "export", "r", "--format", "ro-crate"], capture_output=True, text=True, check=True).stdout
        self.assertIn(": ok, but not to be used as it is", crate)

    def test_of_rounds_the_last_counts_and_all_are_told(self):
        table = "name,E,N,H,sigma\n" + "".join(f"P{i},{3 * i},{i * i % 7},{i % 3},0.001\n" for i in range(9))
        pathlib.Path("control.csv").write_text(table)
        pathlib.Path("measured.csv").write_text(table.replace("P4,12,2,1", "P4,12.05,2,1"))
        run = plumbline.run("outlier_search", out="r", points="measured.csv", control="control.csv")
        self.assertEqual((run.nodes["search"].round, run.nodes["search"].metrics["left_out"]), (2, 0))
        self.assertEqual([(n.name, n.round, n.metrics["left_out"]) for n in run.earlier if n.name == "search"], [("search", 1, 1)])
        self.assertRegex(str(run.messages), r"\('search@1', 'left out: P4")
        # An invalid result of an earlier round is none of the run, and where the record says whether it is usable, that holds.
        record = pathlib.Path("r/run.jsonl")
        lines = record.read_text().splitlines()
        said = [line.replace('"metrics":[', '"metrics":[{"name":"invalid","value":1,"unit":"1"},') if '"name":"search"' in line and '"round":1' in line else line for line in lines]
        self.assertNotEqual(lines, said)
        for end in (said[-1], said[-1].replace('"usable":true,', "")):
            record.write_text("\n".join(said[:-1] + [end]) + "\n")
            self.assertTrue(plumbline.Run("r").usable, end)
        record.write_text("\n".join(said[:-1] + [said[-1].replace('"usable":true', '"usable":false')]) + "\n")
        self.assertFalse(plumbline.Run("r").usable)

    def test_items_of_a_list_stay_what_they_are(self):
        self.assertEqual(plumbline._text(["a, b", "c", 'he said "x"', "it's", " blank", ""]),
                         """["a, b", c, 'he said "x"', "it's", " blank", ""]""")
        self.assertEqual(plumbline._text([1, 2.5, True, None]), "[1, 2.5, true, ~]")
        with self.assertRaisesRegex(plumbline.UsageError, "both kinds of quotes"):
            plumbline._text(["it's \"x\""])

    def table(self):
        pathlib.Path("points.csv").write_text("name,E,N,H,sigma\nA,1,2,3.5,0.001\nB,4,5,6.25,0.002\n")
        return plumbline.run("p.yaml", out="o").table("points.points", "points")

    @unittest.skipUnless(importlib.util.find_spec("pandas"), "python3-pandas is not installed")
    def test_a_table_is_a_data_frame_where_pandas_is(self):
        import pandas
        table = self.table()
        self.assertIsInstance(table, pandas.DataFrame)
        self.assertEqual((list(table["id"]), table.loc[table.id == "B", "position_z"].item()), (["A", "B"], 6.25))
        self.assertEqual((str(table.dtypes["position_z"]), table["sigma_x"].max()), ("float64", 0.002))

    @unittest.skipUnless(importlib.util.find_spec("numpy"), "python3-numpy is not installed")
    def test_a_table_is_arrays_by_name_without_pandas(self):
        with unittest.mock.patch.dict(sys.modules, {"pandas": None}):
            table = self.table()
        self.assertIsInstance(table, dict)
        self.assertEqual((list(table["id"]), table["position_z"].tolist()), (["A", "B"], [3.5, 6.25]))

    def test_what_is_not_there_is_told_by_its_name(self):
        with self.assertRaisesRegex(plumbline.UsageError, "there is no run in nowhere: give the output folder"):
            plumbline.Run("nowhere")
        os.environ["PLUMBLINE"] = "/nowhere/plumbline"
        with self.assertRaisesRegex(plumbline.PlumblineError, "PLUMBLINE names /nowhere/plumbline, which is no program"):
            plumbline.pipelines()

    def test_a_record_of_another_time_is_not_taken_for_this_run(self):
        pathlib.Path("points.csv").write_text("name,E,N,H,sigma\nA,1,2,x,0.001\n")
        with self.assertRaises(plumbline.RunFailed):
            plumbline.run("p.yaml", out="o")
        pathlib.Path("points.csv").write_text("name,E,N,H,sigma\nA,1,2,3,0.001\n")
        pathlib.Path("store2").write_text("no folder")
        with self.assertRaises(plumbline.PlumblineError) as told:
            plumbline.run("p.yaml", out="o", store="store2")
        self.assertNotIsInstance(told.exception, plumbline.RunFailed)
        self.assertIn("store2", str(told.exception))

    def test_what_progress_raises_ends_the_run(self):
        def refuse(node):
            raise ZeroDivisionError(node.name)
        with self.assertRaises(ZeroDivisionError):
            plumbline.run("p.yaml", out=self.work / "out of slow", progress=refuse)
        self.assertEqual(self.running(), [])
        self.assertEqual(threading.active_count(), 1)

    def test_ctrl_c_ends_the_run(self):
        def interrupt():
            for _ in range(400):
                if (self.work / "out of slow/run.jsonl").exists():
                    break
                time.sleep(0.05)
            os.kill(os.getpid(), signal.SIGINT)
        threading.Thread(target=interrupt).start()
        with self.assertRaises(KeyboardInterrupt):
            plumbline.run("slow.yaml", out=self.work / "out of slow")
        self.assertEqual(self.running(), [])


if __name__ == "__main__":
    unittest.main()
