#!/usr/bin/env python3
"""The standard deviations of calibrations on public photographs, set by set.

    benchmarks/calibration/calibration_sets.py --program build/bin/calibration_benchmark --folder FOLDER [--sets FILE] [SET ...]

Clones what a set is from into FOLDER (or takes a clone that stands there as OWNER+NAME), and prints what
calibration_benchmark says of it. Nothing of it is in this tree. FILE: sets of one's own in place of those below, JSON of the same form.
"""
import argparse
import json
import pathlib
import subprocess
import tempfile

# name: repository, commit, photographs, board. Lengths of a square are not known of all; they scale the poses alone.
SETS = {
    "webcam_moved": ("bimalka98/Camera-Calibration-and-Backprojection", "3ed60fda00fe7d59298b7376b8dc83b0eb9923ae",
                     "images-static_checkerboard/*.jpg", "type: chessboard\ncolumns: 9\nrows: 7\nsquare: 0.02\n"),
    "webcam_held": ("bimalka98/Camera-Calibration-and-Backprojection", "3ed60fda00fe7d59298b7376b8dc83b0eb9923ae",
                    "images-static_camera/*.jpg", "type: chessboard\ncolumns: 9\nrows: 7\nsquare: 0.02\n"),
    "toolbox": ("ginevracoal/zhang-camera-calibration", "81892294e93230f67b15129122911af642045505",
                "src/images/*.tif", "type: chessboard\ncolumns: 13\nrows: 12\nsquare: 0.03\n"),
    "grey_left": ("present-cjn/stereo-vision-python", "510e577e6e86a0c5d22b79840c610638aada9f39",
                  "data/calibration_images/left*.jpg", "type: chessboard\ncolumns: 11\nrows: 8\nsquare: 0.02\n"),
    "grey_right": ("present-cjn/stereo-vision-python", "510e577e6e86a0c5d22b79840c610638aada9f39",
                   "data/calibration_images/right*.jpg", "type: chessboard\ncolumns: 11\nrows: 8\nsquare: 0.02\n"),
    "robot_wide": ("LimHaeryong/Camera-Calibration-using-Ceres-Solver", "73ad4659b1a2c49a7fb832bb3dd5d056da7a69a6",
                   "resources/checkerboard/*.png", "type: chessboard\ncolumns: 8\nrows: 6\nsquare: 0.03\n"),
    "laptop": ("MayankD409/AutoCalib", "dc7a837270c5ffb394a126f1f56aedbdb142a438",
               "calibration_images/*.jpg", "type: chessboard\ncolumns: 8\nrows: 6\nsquare: 0.025\n"),
    "overhead": ("natkehoe/EGH400-Camera-Calibration", "8204b05f5e4bd86c6b6b9106cf6b3a9f52cce42b",
                 "CamCalibrationTransformsTEMPLATE/CalibrationImages/*.png",
                 "type: chessboard\ncolumns: 8\nrows: 6\nsquare: 0.025\n"),
    "robot_cell": ("niconielsen32/ComputerVision", "37b279fa44e28fe3ea859bc8f14f5353a6b93e54",
                   "cameraCalibration/calibration/*.png", "type: chessboard\ncolumns: 24\nrows: 17\nsquare: 0.02\n"),
    "pixel_xl": ("anki-mittal/Camera-Caliberation", "bfd42a4ffc82d91a477e8e0b62b827768d9451a8",
                 "Code/Calibration_Imgs/*.jpg", "type: chessboard\ncolumns: 9\nrows: 6\nsquare: 0.0215\n"),
    "plate_1": ("rlav440/pyCamSet", "b180327e77a2679dcb371bbebea2ee2792f16557",
                "tests/test_data/calibration_charuco/1/*.jpg",
                "type: charuco\ncolumns: 20\nrows: 20\nsquare: 0.004\nmarker: 0.0032\ndictionary: DICT_4X4_1000\n"),
    "plate_2": ("rlav440/pyCamSet", "b180327e77a2679dcb371bbebea2ee2792f16557",
                "tests/test_data/calibration_charuco/2/*.jpg",
                "type: charuco\ncolumns: 20\nrows: 20\nsquare: 0.004\nmarker: 0.0032\ndictionary: DICT_4X4_1000\n"),
    "plate_3": ("rlav440/pyCamSet", "b180327e77a2679dcb371bbebea2ee2792f16557",
                "tests/test_data/calibration_charuco/3/*.jpg",
                "type: charuco\ncolumns: 20\nrows: 20\nsquare: 0.004\nmarker: 0.0032\ndictionary: DICT_4X4_1000\n"),
    "wide_left": ("shubhamwagh/stereo-calib", "27460e4f88712a58e88e00a59cc131e5acf1e2a1", "dataset/left/*.png",
                  "type: charuco\ncolumns: 31\nrows: 16\nsquare: 0.04933\nmarker: 0.03846\ndictionary: DICT_4X4_250\n"),
    "wide_right": ("shubhamwagh/stereo-calib", "27460e4f88712a58e88e00a59cc131e5acf1e2a1", "dataset/right/*.png",
                   "type: charuco\ncolumns: 31\nrows: 16\nsquare: 0.04933\nmarker: 0.03846\ndictionary: DICT_4X4_250\n"),
}


def git(folder, *arguments):
    return subprocess.run(["git", "--git-dir", folder, *arguments], check=True, capture_output=True).stdout


def repository_of(folder, name):
    """The git directory of a clone without a work tree."""
    for place in (folder / name.replace("/", "+") / "repo", folder / name.replace("/", "+")):
        for git_dir in (place / ".git", place):
            if (git_dir / "HEAD").exists():
                return str(git_dir)
    place = folder / name.replace("/", "+")
    subprocess.run(["git", "clone", "--quiet", "--bare", f"https://github.com/{name}.git", str(place)], check=True)
    return str(place)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", required=True, help="calibration_benchmark")
    parser.add_argument("--folder", required=True, type=pathlib.Path, help="where the clones are")
    parser.add_argument("--sets", type=pathlib.Path, help="JSON: {name: [repository, commit, photographs, board file's text]}")
    parser.add_argument("names", nargs="*", metavar="SET", help=f"of {', '.join(SETS)}; without: all")
    arguments = parser.parse_args()
    sets = json.loads(arguments.sets.read_text()) if arguments.sets else SETS
    if unknown := [name for name in arguments.names if name not in sets]:
        parser.error(f"no set is called {', '.join(unknown)}; there are {', '.join(sets)}")
    for name in arguments.names or sets:
        repository, commit, photographs, board = sets[name]
        git_dir = repository_of(arguments.folder, repository)
        parent = str(pathlib.PurePosixPath(photographs).parent)
        listed = git(git_dir, "ls-tree", "-r", "--name-only", commit, parent + "/").decode().splitlines()
        with tempfile.TemporaryDirectory() as place:
            paths = []
            for path in listed:
                if pathlib.PurePosixPath(path).match(photographs):
                    paths.append(pathlib.Path(place) / pathlib.PurePosixPath(path).name)
                    paths[-1].write_bytes(git(git_dir, "show", f"{commit}:{path}"))
            (pathlib.Path(place) / "board.yaml").write_text(board)
            subprocess.run([arguments.program, name, f"{place}/board.yaml", *map(str, paths)], check=True)


if __name__ == "__main__":
    main()
