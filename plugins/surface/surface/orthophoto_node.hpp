// Pictures of facades without perspective, from the photographs and the surfaces that were measured in them.
#pragma once

#include "artifacts/file.hpp"
#include "artifacts/folder.hpp"
#include "artifacts/surfaces.hpp"
#include "photographs.hpp"
#include "plumbline/node.hpp"
#include "surface/dense/panel_painter.hpp"

namespace plumbline::surface {

struct OrthophotoNode : Node {
  static constexpr Info info{
      "surface.orthophoto", "", 2,
      "Facades without perspective, from photographs that are held against each other: TIFF and world file"};
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
  Param<int64_t> compare{"compare", 5, between(1, 20),
                         "photographs of a panel that are held against each other; 1: none are"};
  Param<double> memory{"memory", 1.5, "GiB", between(0.05, 64), "for the photographs' pixels"};
  Out<Folder> folder{
      "folder",
      "facade_1.tif, facade_1.tfw (metres to the right and up on the facade), facade_1_shown.tif (255 as most of "
      "several "
      "photographs show it, 170 from one unchecked, 85 they contradict, 0 not seen), facade_1.jpg (small), …, "
      "facades.csv: where each lies"};
  Out<File> seams{"seams", "which photograph each panel is from, and how much of it is checked or black, CSV"};

  void run(Context& context) override;

 private:
  PaintCounts paint_panel(Context& context, const PanelPainter& painter) const;
  static void tell(Context& context, const std::string& panel, size_t views, const PaintCounts& counts);
};

}  // namespace plumbline::surface
