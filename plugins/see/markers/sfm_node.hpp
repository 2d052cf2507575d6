// colmap.sfm: photographs without markers to a sparse model.
#pragma once

#include "artifacts/folder.hpp"
#include "photo/colmap/program.hpp"
#include "plumbline/node.hpp"

namespace plumbline::markers {

struct ColmapSfm : Node {
  static constexpr Info info{
      "colmap.sfm", "", 1,
      "Sparse model of photographs without markers, by the program colmap (apt install colmap). It has no scale and a "
      "frame of its own; adjust.colmap_control takes it to surveyed points. With more than one thread it is not the "
      "same twice"};
  Param<FolderPath> photographs{"photographs", required, "folder with JPEG, PNG or TIFF files, also in folders below"};
  Param<std::string> camera_model{
      "camera_model", "SIMPLE_RADIAL",
      one_of("SIMPLE_PINHOLE", "PINHOLE", "SIMPLE_RADIAL", "RADIAL", "OPENCV", "FULL_OPENCV"), "COLMAP's name of it"};
  Param<bool> one_camera{"one_camera", true, "all photographs are of one camera with one focus"};
  Param<int64_t> max_image_size{"max_image_size", 3200, "px", between(100, 100000),
                                "larger photographs are reduced for the features"};
  Param<int64_t> max_features{"max_features", 8192, between(100, 1000000), "an image"};
  Param<int64_t> threads{"threads", 1, between(1, 256), "of COLMAP; the model is the same twice with one only"};
  Param<double> time_limit{"time_limit", 3600.0, "s", between(1, 1e7), "of each of COLMAP's three programs"};
  Param<FilePath> program{"program",
                          {colmap::usual_program},
                          "COLMAP: a name on PATH, or a path; what it and its libraries are is part of the key"};
  Out<Folder> model{"model", "the model as COLMAP text files"};

  void run(Context& context) override;
};

}  // namespace plumbline::markers
