// adjust.colmap_control: a COLMAP model with surveyed points measured in its photographs.
#pragma once

#include "artifacts/camera.hpp"
#include "artifacts/file.hpp"
#include "artifacts/folder.hpp"
#include "artifacts/points.hpp"
#include "artifacts/poses.hpp"
#include "plumbline/node.hpp"

namespace plumbline::markers {

struct AdjustColmapControl : Node {
  static constexpr Info info{"adjust.colmap_control", "", 5,
                             "Adjusts a COLMAP model together with surveyed points measured in its photographs"};
  Optional<Folder> sparse{"sparse", "the model, such as that of colmap.sfm, in place of the parameter"};
  Param<FolderPath> model{"model", FolderPath{}, "folder with cameras, images and points3D, .bin or .txt"};
  Param<FilePath> control{"control", required, "surveyed points: CSV (name, x, y, z, sigma, role) or gcp_list.txt"};
  Param<FilePath> observations{
      "observations", FilePath{},
      "where they are in the photographs: CSV (image, point, x, y, sigma), gcp_list.txt or observations.json"};
  Optional<File> measured{"measured", "the same as an artifact, such as targets.csv of detect.target"};
  Param<std::string> pixel_origin{"pixel_origin", "centre", one_of("centre", "corner"),
                                  "what (0, 0) is in the measurements: the centre of the top-left pixel or its corner"};
  Param<double> control_sigma{"control_sigma", 0.005, "m", between(1e-6, 10),
                              "of a surveyed coordinate whose file says none"};
  Param<double> measured_sigma{"measured_sigma", 0.5, "px", between(0.001, 100),
                               "of a measurement whose file says none"};
  Param<double> tie_sigma{"tie_sigma", 1.0, "px", between(0.001, 100), "of a tie point, before its variance component"};
  Param<bool> self_calibration{"self_calibration", true, "estimate the interior orientations, too"};
  Param<int64_t> max_tie_points{
      "max_tie_points", 600, between(0, 1000000),
      "tie points that take part, those with the longest tracks first; the others follow the cameras"};
  Param<bool> robust_control{"robust_control", true,
                             "set control aside that contradicts the photographs and the other control, at most a "
                             "third of it; each such point is named"};
  Param<double> reject_above{"reject_above", 5.0, "1", at_least(0),
                             "tie observations whose residual is this many times the median are left out"};
  Out<File> block{"block", "block.json: the adjustment with its statistics and residuals"};
  Out<File> table{"table", "points.csv: the surveyed points, adjusted minus surveyed, and their tests"};
  Out<Folder> adjusted{"model", "the model in the frame of the survey, as COLMAP text files"};
  OutList<Camera> cameras{"cameras", "adjusted interior orientations, in the order of their ids"};
  Out<Poses> poses{"poses", frame("frame=survey"), "adjusted exterior orientations"};
  Out<Points> points{"points", frame("frame=survey"), "the surveyed points as they are in the control file"};

  void run(Context& context) override;
};

}  // namespace plumbline::markers
