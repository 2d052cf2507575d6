// read.camera, read.plates: what is known beforehand, from one file each.
#pragma once

#include "artifacts/camera.hpp"
#include "artifacts/camera_artifact.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "base/text/whole_file.hpp"
#include "geometry/packed_symmetric.hpp"
#include "photo/cameras/camera_files.hpp"
#include "photo/markers/layout_files.hpp"
#include "plumbline/node.hpp"

namespace plumbline::markers {

struct ReadCamera : Node {
  static constexpr Info info{"read.camera", "", 2,
                             "Reads an interior orientation: ours, OpenCV's YAML or XML, ROS, Kalibr, PhotonVision"};
  Param<FilePath> file{"file", FilePath{}, "the file; empty: no camera is known"};
  Param<std::string> which{"which", "",
                           "key of the camera in a file of several (ours, Kalibr's), such as cam1; empty: all"};
  Param<bool> exact{"exact", false,
                    "take the parameters as free of error; else a file without sigmas starts a "
                    "self-calibration with weak priors"};
  OutList<Camera> camera{"camera", "the interior orientations, with the uncertainty that the file states"};

  void run(Context& context) override {
    if (file->path.empty()) return;
    for (const cameras::CameraFile& read :
         cameras::parse_camera_files(text::read_whole(file->path), file->path, *which)) {
      CameraT result;
      result.id = read.id;
      const Eigen::MatrixXd stated = read.covariance.size() ? read.covariance : cameras::usual_covariance(read.camera);
      set_interior(read.camera, *exact ? Eigen::MatrixXd() : stated, result);
      result.source = read.format + " file";
      context.info(read.format + (read.camera.lens == LensModel::fisheye ? " camera, a fisheye, fx " : " camera, fx ") +
                   std::to_string(read.camera.fx) + " px");
      camera.commit(result);
    }
  }
};

struct ReadPlates : Node {
  static constexpr Info info{"read.plates", "", 1,
                             "Reads where tags are: WPILib JSON, tags.json, an ArUco marker map or a CSV table"};
  Param<FilePath> file{"file", required, "the file; docs/photographs.md has the formats"};
  Param<std::string> family{"family", "", "family of the tags, where the file does not say it; empty: any"};
  Param<double> tag_size{"tag_size", 0.0, "m", between(0, 100), "edge of the tags, where the file does not say it"};
  Out<Plates> plates{"plates", frame("frame=layout"), "one plate a tag, anchored at the tag's centre"};
  Out<Points> points{"points", frame("frame=layout"), "the centres of the tags"};

  void run(Context&) override {
    PlatesT table;
    PointsT centres;
    for (const LayoutTag& tag : parse_layout(text::read_whole(file->path), file->path)) {
      auto plate = std::make_unique<PlateT>();
      plate->anchor = (tag.family.empty() ? "tag " : tag.family + ":") + std::to_string(tag.id);
      plate->tag_family = tag.family.empty() ? *family : tag.family;
      plate->tag_id = tag.id;
      if (tag.size > 0 || *tag_size > 0) plate->tag_size = tag.size > 0 ? tag.size : *tag_size;
      plate->tag_centre_in_plate = Eigen::Vector3d::Zero();
      plate->nominal_rotation = tag.world_from_tag.rotation;
      plate->role = "control";
      auto point = std::make_unique<PointT>();
      point->id = plate->anchor;
      point->position = tag.world_from_tag.translation;
      point->sigma = Eigen::Vector3d::Constant(std::nan(""));
      table.plates.push_back(std::move(plate));
      centres.points.push_back(std::move(point));
    }
    plates.commit(table);
    points.commit(centres);
  }
};

}  // namespace plumbline::markers
