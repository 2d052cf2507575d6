// report.image_block: the page of a block of photographs. report.model_block: the same where the photographs themselves
// are not at hand.
#pragma once

#include "artifacts/file.hpp"
#include "artifacts/image.hpp"
#include "plumbline/node.hpp"

namespace plumbline::report {

struct ReportImageBlock : Node {
  static constexpr Info info{"report.image_block", "", 1, "HTML page of a block of photographs"};
  In<File> block{"block", "the block.json of adjust.marker_board, adjust.marker_field or adjust.colmap_control"};
  List<Image> images{"images", "the photographs, for crops of the worst observations"};
  Param<std::string> title{"title", "Image block", "heading"};
  Param<std::string> subtitle{"subtitle", "", "line below the heading"};
  Param<std::string> name{"name", "report.html", "base name of the file"};
  Out<File> out{"file", "one HTML file that needs no network"};

  void run(Context& context) override;
};

struct ReportModelBlock : Node {
  static constexpr Info info{"report.model_block", "", 1, "HTML page of a block whose photographs may not be at hand"};
  In<File> block{"block", "the block.json of adjust.colmap_control or of any other block"};
  Param<FolderPath> photographs{"photographs", FolderPath{},
                                "folder with the photographs, by the names the block has for them: crops are shown"};
  Param<std::string> title{"title", "Image block", "heading"};
  Param<std::string> subtitle{"subtitle", "", "line below the heading"};
  Param<std::string> name{"name", "report.html", "base name of the file"};
  Out<File> out{"file", "one HTML file that needs no network"};

  void run(Context& context) override;
};

}  // namespace plumbline::report
