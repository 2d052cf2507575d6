// Pictures of facades without perspective, from the photographs and the surfaces that were measured in them.
#pragma once

#include "artifacts/file.hpp"
#include "artifacts/folder.hpp"
#include "artifacts/surfaces.hpp"
#include "photographs.hpp"
#include "plumbline/node.hpp"

namespace plumbline::surface {

struct OrthophotoNode : Node {
  static constexpr Info info{
      "surface.orthophoto", "", 1,
      "Facades without perspective, each panel from the photograph that shows it best: TIFF and world file"};
  List<Image> images{"images", "the photographs"};
  In<Poses> poses{"poses", frame("frame=?F"), "their orientations, with the joint covariance of all"};
  In<Camera> camera{"camera", "the cameras that took them"};
  In<Surfaces> panels{"panels", frame("frame=?F"),
                      "the panels, as they are; those that were not measured lie as designed"};
  Param<double> pixel{"pixel", 0.002, "m", between(1e-5, 0.1), "edge of a pixel on the facade"};
  Param<double> margin{"margin", 0.02, "m", between(0, 5),
                       "around a facade's panels, and how far beyond its edge a panel's photograph is taken: joints"};
  Param<double> most{"most", 4e8, "1", between(1e4, 2e9),
                     "pixels of a picture, a byte each; they are larger where there would be more"};
  Param<double> memory{"memory", 1.5, "GiB", between(0.05, 64), "for the photographs' pixels"};
  Out<Folder> folder{
      "folder",
      "facade_1.tif, facade_1.tfw (metres to the right and up on the facade), …, facades.csv: where each lies"};
  Out<File> seams{"seams", "which photograph each panel is from, CSV"};

  void run(Context& context) override;
};

}  // namespace plumbline::surface
