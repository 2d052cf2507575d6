// adjust.marker_field: photographs in a field of tags whose places are known approximately.
#pragma once

#include "artifacts/plates.hpp"
#include "output.hpp"
#include "plumbline/node.hpp"

namespace plumbline::markers {

struct AdjustMarkerField : Node {
  static constexpr Info info{"adjust.marker_field", "", 4,
                             "Orients photographs in a field of tags with an approximate layout"};
  List<Image> images{"images", "the photographs, for what EXIF says of their cameras"};
  In<TagObservations> observations{"observations", "the tags in them"};
  In<Plates> plates{"plates", frame("frame=?F"), "the tags of the layout"};
  In<Points> layout{"points", frame("frame=?F"), "the places of their plates"};
  List<Camera> calibrations{
      "camera",
      "calibration of the one camera, or of several by the names of `cameras`; none: every camera "
      "calibrates itself"};
  Param<double> tag_size{"tag_size", 0.0, "m", between(0, 100),
                         "edge of the tags between their detected corners, where the layout does not say it"};
  Param<double> position_sigma{"position_sigma", 0.02, "m", between(1e-6, 10),
                               "standard deviation of the layout's coordinates, each axis"};
  Param<double> rotation_sigma{"rotation_sigma", 0.02, "rad", between(1e-6, 3),
                               "standard deviation of a tag's rotation, about each axis"};
  Param<double> size_sigma{"size_sigma", 1e-3, "1", between(0, 1),
                           "prior standard deviation of each tag's printed size, relative"};
  Param<double> twist_sigma{"twist_sigma", 1e-2, "1", between(0, 0.1),
                            "prior standard deviation of how far a tag's corners lie out of its plane (wavy paper), "
                            "relative to half its edge; 0: tags are plane"};
  Param<double> shape_sigma{"shape_sigma", 0.0, "1", between(0, 0.1),
                            "the same in the plane, for prints that are no squares; 0: they are"};
  Param<double> corner_inset_sigma{
      "corner_inset_sigma", 0.3, "px", between(0, 10),
      "prior standard deviation of how far the detector draws tag edges inwards, where it states none"};
  Param<double> reject_above{"reject_above", 8.0, "1", at_least(0),
                             "tags whose rms residual is this many times the median are left out; 0 keeps all"};
  Param<std::string> cameras{"cameras", "by_folder", one_of("by_folder", "by_name", "by_file", "one"),
                             "by_folder: photographs of another folder are from another camera; by_name: of another "
                             "name around the number (cam0_17.png, 17_cam0.png), too; by_file: every folder is a "
                             "moment (17/cam0.png)"};
  Out<File> poses_file{"file", "poses.json: every photograph with its pose or the reason why it has none"};
  Out<File> table{"table", "points.csv: the tags after the adjustment"};
  Out<File> block{"block", "block.json: the adjustment with its statistics, residuals and what was left out"};
  Out<Points> points{"points", frame("frame=?F"), "the tags' centres with their full covariance"};
  Out<Poses> poses{"poses", frame("frame=?F"), "exterior orientations with covariance"};

  void run(Context& context) override;

 private:
  static bool has_place(const MarkerBlock& given);
};

}  // namespace plumbline::markers
