// predict.targets, detect.target: surveyed crosshairs and quadrant targets in photographs, near where they are
// expected.
#pragma once

#include "artifacts/camera.hpp"
#include "artifacts/file.hpp"
#include "artifacts/image.hpp"
#include "artifacts/points.hpp"
#include "artifacts/poses.hpp"
#include "plumbline/node.hpp"

namespace plumbline::detect {

struct PredictTargets : Node {
  static constexpr Info info{"predict.targets", "", 1, "Says where points are to be seen in oriented photographs"};
  List<Image> images{"images", "photographs"};
  In<Points> points{"points", frame("frame=?F"), "targets in space"};
  In<Poses> poses{"poses", frame("frame=?F"), "exterior orientations of the photographs"};
  List<Camera> cameras{"cameras", "the camera of all images, or several that are called as the images' folders"};
  Out<File> places{"places", "places.csv: image, point, x, y [px], of those that lie in the photograph"};

  void run(Context& context) override;
};

struct DetectTarget : Node {
  static constexpr Info info{"detect.target", "", 1, "Measures crosshairs and quadrant targets near predicted places"};
  List<Image> images{"images", "photographs"};
  In<File> places{"places",
                  "where targets are expected: a table image, point, x, y, a gcp_list.txt, or observations.json of a "
                  "detector (the centres of its tags)"};
  Param<std::string> kind{"kind", "any", one_of("any", "quadrants", "crosshair"), "what the targets look like"};
  Param<double> search{"search", 10.0, "px", between(0.5, 200), "how far a centre may be from its prediction"};
  Param<double> max_radius{"max_radius", 24.0, "px", between(5, 200),
                           "of the part that is fitted, at most; it grows as long as it looks like the target"};
  Param<double> min_contrast{"min_contrast", 20.0, "grey levels", between(1, 255), "below it nothing is measured"};
  Param<double> sigma_floor{"sigma_floor", 0.002, "px", between(0, 10), "added in quadrature to the fit's sigma"};
  Param<std::string> pixel_origin{"pixel_origin", "centre", one_of("centre", "corner"),
                                  "what (0, 0) is in `places`: the centre of the top-left pixel or its corner"};
  Out<File> table{"table", "targets.csv: image, point, x, y, sigma [px] of those that were measured"};
  Out<File> report{"report",
                   "targets.json: images[] {path, targets[] {point, kind, predicted, centre, covariance, radius, blur, "
                   "misfit, problem}}, every prediction with what came of it"};

  void run(Context& context) override;
};

}  // namespace plumbline::detect
