// What the nodes share that take points from photographs: faces, photographs that fit the memory, the way out.
#pragma once

#include <array>
#include <cstdio>

#include "artifacts/folder.hpp"
#include "faces.hpp"
#include "partial_tiles.hpp"
#include "photographs.hpp"
#include "plumbline/node.hpp"
#include "surface/dense/facet_tile.hpp"
#include "surface_artifacts.hpp"

namespace plumbline::surface {

struct DepthNode : Node {
  List<Image> images{"images", "the photographs"};
  In<Poses> poses{"poses", frame("frame=?F"), "their orientations, with the joint covariance of all"};
  In<Camera> camera{"camera", "the cameras that took them, as they were adjusted with the poses"};
  Optional<Design> design{"design", frame("frame=?F"), "whose panels are measured"};
  Optional<Points> points{"points", frame("frame=?F"), "without a design: the plane of these points is measured"};
  Param<double> search{"search", 0.05, "m", between(0.001, 0.5), "how far before and behind the design's face to look"};
  Param<double> pitch{"pitch", 0.02, "m", between(0.0005, 1), "between points; never less than a facet's own size"};
  Param<double> tile{"tile", 0.25, "m", between(0.02, 5), "edge of the parts that are measured at a time"};
  Param<double> margin{"margin", 0.05, "m", between(0, 5),
                       "without a design: how far beyond the points the plane reaches"};
  Param<int64_t> half{"half", 5, between(3, 15), "a facet has (2 half + 1)² samples, a pixel apart"};
  Param<int64_t> min_views{"min_views", 3, between(2, 20), "photographs that have to agree on a facet"};
  Param<double> min_correlation{"min_correlation", 0.7, "1", between(0.1, 0.99),
                                "of what the photographs show of a facet"};
  Param<double> max_sigma{"max_sigma", 0.002, "m", between(1e-6, 0.1), "a facet known worse is a hole"};
  Param<double> memory{"memory", 1.5, "GiB", between(0.05, 64), "for the photographs' pixels"};
  Out<SurfacePoints> surface{"surface", frame("frame=?F"), "the points"};
  Out<Folder> files{"files", "where they lie"};

  void run(Context& context) override;

 protected:
  /// Appends the tiles of a face, one for each of parts_of, and keeps each as soon as it is known.
  virtual void measure_face(Context& context, const Photographs& photographs, const std::vector<FacetView>& views,
                            const PanelFace& face, std::vector<FacetTile>& tiles, PartialTiles& kept) const = 0;
  /// Rectangles of a face, `tile` wide and high.
  std::vector<Rectangle> parts_of(const PanelFace& face) const;

 private:
  Faces wanted_faces(Context& context, const Photographs& photographs) const;
  std::vector<size_t> that_fit(Context& context, const Photographs& photographs, const PanelFace& face,
                               std::uint64_t limit) const;
  void commit(Context& context, const Photographs& photographs, const Faces& faces,
              const std::vector<size_t>& face_of_tile, std::vector<FacetTile> tiles) const;
};

}  // namespace plumbline::surface
