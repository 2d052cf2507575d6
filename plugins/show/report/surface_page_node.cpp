#include "show/report/surface_page_node.hpp"

#include "show/report/surface_page.hpp"

namespace plumbline::report {

void ReportSurfaces::run(Context&) {
  SurfaceJudgementT judged;
  if (surface_judgement) judged = surface_judgement.unpack();
  FileT file;
  file.name = "surfaces.html", file.media_type = "text/html";
  const std::string html = render_surface_page(surfaces.unpack(), surface_judgement ? &judged : nullptr, *title);
  file.content.assign(html.begin(), html.end());
  out.commit(file);
}

}  // namespace plumbline::report
