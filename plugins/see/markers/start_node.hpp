// adjust.marker_start: where cameras and tags are, from photographs and surveyed tags alone: the start of an
// adjustment.
#pragma once

#include "artifacts/image_tags.hpp"
#include "artifacts/plates.hpp"
#include "output.hpp"
#include "plumbline/node.hpp"

namespace plumbline::markers {

struct AdjustMarkerStart : Node {
  static constexpr Info info{"adjust.marker_start", "", 3,
                             "Places cameras and tags in the frame of a survey, without a layout or a calibration"};
  List<Image> images{"images", "the photographs, for what EXIF says of their camera"};
  In<TagObservations> observations{"observations", "the tags in them"};
  In<Plates> plates{"plates", frame("frame=?F"),
                    "which tag stands for which point; empty: a point is called as the number of its tag, or "
                    "family:number"};
  In<Points> points{"points", frame("frame=?F"), "the surveyed points"};
  List<Camera> calibration{"cameras",
                           "calibration of the one camera, or of several by the names of parameter `cameras`; none: "
                           "they are started from EXIF or from the tags"};
  Param<double> tag_size{"tag_size", 0.0, "m", between(0, 100),
                         "edge of the tags between their detected corners, where the plates do not say it; 0: the "
                         "surveyed points give it"};
  Param<std::string> cameras{
      "cameras", "by_folder", one_of("by_folder", "by_name", "by_file", "one"),
      "by_folder: photographs of another folder are from another camera; by_name: of another name around the "
      "number (cam0_17.png), too; by_file: every folder is a moment (17/cam0.png); one: only size, EXIF model and "
      "focal length tell"};
  Out<Plates> placed{"plates", frame("frame=?F"), "the plates as they hang, and the tags that stand for no point"};
  Out<Poses> poses{"poses", frame("frame=?F"), "approximate exterior orientations"};
  Out<Camera> camera{"camera",
                     "the calibration, or the start of a self-calibration with weak priors; several cameras in one"};
  OutList<ImageTags> usable{"observations", "the tags of the photographs that can take part"};

  void run(Context& context) override;
};

}  // namespace plumbline::markers
