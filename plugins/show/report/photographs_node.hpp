// report.photographs: parts of photographs around the anchors that are not in order, as files and for the page.
#pragma once

#include "artifacts/camera.hpp"
#include "artifacts/deviation.hpp"
#include "artifacts/folder.hpp"
#include "artifacts/image.hpp"
#include "artifacts/image_tags.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/poses.hpp"
#include "plumbline/node.hpp"
#include "show/report/anchor_photographs.hpp"

namespace plumbline::report {

struct ReportPhotographs : Node {
  static constexpr Info info{"report.photographs", "", 2,
                             "Of each failing or undecided anchor the part of the photograph around its marker"};
  In<Deviation> deviation{"deviation", frame("frame=?F"), "as-built minus design, judged"};
  List<Image> images{"images", "the photographs"};
  List<ImageTags> tags{"tags", "the tags that were detected in them"};
  In<Plates> plates{"plates", frame("frame=?F"), "which tag is at which anchor"};
  Optional<Poses> poses{"poses", frame("frame=?F"),
                        "the photographs' poses as adjusted, for the place where the design has an anchor"};
  Optional<Camera> camera{"camera", "the camera of these poses"};
  Out<Folder> folder{"folder", "photographs.json and a grey JPEG for each part"};

  void run(Context& context) override;
};

/// What the folder of report.photographs holds.
AnchorPhotographs read_photographs(const Context& context, const FolderT& folder);

}  // namespace plumbline::report
