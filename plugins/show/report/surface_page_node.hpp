// report.surfaces: panels and joints as they are, on a page of their own.
#pragma once

#include "artifacts/file.hpp"
#include "artifacts/folder.hpp"
#include "artifacts/surface_judgement.hpp"
#include "artifacts/surfaces.hpp"
#include "plumbline/node.hpp"
#include "show/report/folder_pictures.hpp"

namespace plumbline::report {

struct ReportSurfaces : Node {
  static constexpr Info info{
      "report.surfaces", "", 2,
      "One offline HTML file: heat map of the panels on the elevation of each facade, joints, verdicts"};
  In<Surfaces> surfaces{"surfaces", frame("frame=?F"), "panels, and joints where they were measured"};
  Optional<SurfaceJudgement> surface_judgement{"surface_judgement", "their verdicts"};
  Optional<Folder> orthophoto{"orthophoto", "of surface.orthophoto: the facades' pictures"};
  Param<std::string> title{"title", "Surfaces of panels and joints", "heading"};
  Param<std::string> language{"language", "en", one_of("en", "de"), "of the page"};
  Param<std::string> units{"units", "mm", one_of("mm", "in"), "of lengths on the page; data files keep theirs"};
  Out<File> out{"file", "surfaces.html"};

  void run(Context& context) override;
};

}  // namespace plumbline::report
