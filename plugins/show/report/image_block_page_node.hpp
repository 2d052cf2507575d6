// report.image_block: the page of a block of photographs. report.model_block: the same where the photographs themselves
// are not at hand. report.tag_block, report.target_block: the same of a block as the adjusters give it.
#pragma once

#include "artifacts/block.hpp"
#include "artifacts/camera.hpp"
#include "artifacts/file.hpp"
#include "artifacts/image.hpp"
#include "artifacts/image_block.hpp"
#include "artifacts/image_tags.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "artifacts/poses.hpp"
#include "plumbline/node.hpp"

namespace plumbline::report {

struct ReportImageBlock : Node {
  static constexpr Info info{"report.image_block", "", 2, "HTML page of a block of photographs"};
  In<File> block{"block", "the block.json of adjust.marker_board, adjust.marker_field or adjust.colmap_control"};
  List<Image> images{"images", "the photographs, for crops of the worst observations"};
  Param<std::string> title{"title", "Image block", "heading"};
  Param<std::string> subtitle{"subtitle", "", "line below the heading"};
  Param<std::string> name{"name", "report.html", "base name of the file"};
  Param<std::string> language{"language", "en", one_of("en", "de"), "of the page"};
  Param<std::string> units{"units", "mm", one_of("mm", "in"), "of lengths on the page; data files keep theirs"};
  Out<File> out{"file", "one HTML file that needs no network"};

  void run(Context& context) override;
};

struct ReportModelBlock : Node {
  static constexpr Info info{"report.model_block", "", 2, "HTML page of a block whose photographs may not be at hand"};
  In<File> block{"block", "the block.json of adjust.colmap_control or of any other block"};
  Param<FolderPath> photographs{"photographs", FolderPath{},
                                "folder with the photographs, by the names the block has for them: crops are shown"};
  Param<std::string> title{"title", "Image block", "heading"};
  Param<std::string> subtitle{"subtitle", "", "line below the heading"};
  Param<std::string> name{"name", "report.html", "base name of the file"};
  Param<std::string> language{"language", "en", one_of("en", "de"), "of the page"};
  Param<std::string> units{"units", "mm", one_of("mm", "in"), "of lengths on the page; data files keep theirs"};
  Out<File> out{"file", "one HTML file that needs no network"};

  void run(Context& context) override;
};

struct ReportTagBlock : Node {
  static constexpr Info info{"report.tag_block", "", 2,
                             "HTML page of a block of marker plates, from what an adjuster made of what"};
  In<Block> block{"block", frame("frame=?F"), "the block of adjust.schur, adjust.ceres or adjust.joint"};
  In<Points> points{"points", frame("frame=?F"), "its adjusted points"};
  In<Poses> poses{"poses", frame("frame=?F"), "its adjusted poses"};
  In<Camera> camera{"camera", "its adjusted camera, or several"};
  In<Plates> plates{"plates", frame("frame=?F"), "the plates that were adjusted"};
  List<ImageTags> observations{"observations", "the tags that were adjusted"};
  List<Image> images{"images", "the photographs, for crops of the worst observations"};
  Param<std::string> title{"title", "Image block", "heading"};
  Param<std::string> subtitle{"subtitle", "", "line below the heading"};
  Param<std::string> name{"name", "image_block.html", "base name of the file"};
  Param<std::string> language{"language", "en", one_of("en", "de"), "of the page"};
  Param<std::string> units{"units", "mm", one_of("mm", "in"), "of lengths on the page; data files keep theirs"};
  Out<File> out{"file", "one HTML file that needs no network"};

  void run(Context& context) override;
};

struct ReportTargetBlock : Node {
  static constexpr Info info{"report.target_block", "", 3, "HTML page of an adjusted block of measured targets"};
  In<Block> block{"block", frame("frame=?F"), "the block of adjust.schur or adjust.ceres"};
  In<ImageBlock> measured{"measured", frame("frame=?G"), "what was adjusted, such as that of read.image_block"};
  Param<std::string> title{"title", "Image block", "heading"};
  Param<std::string> subtitle{"subtitle", "", "line below the heading"};
  Param<std::string> name{"name", "report.html", "base name of the file"};
  Param<std::string> language{"language", "en", one_of("en", "de"), "of the page"};
  Param<std::string> units{"units", "mm", one_of("mm", "in"), "of lengths on the page; data files keep theirs"};
  Out<File> out{"file", "one HTML file that needs no network"};

  void run(Context& context) override;
};

}  // namespace plumbline::report
