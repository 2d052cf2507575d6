#include "show/report/surface_page_node.hpp"

#include "building/ifc/enlarged_surfaces.hpp"
#include "show/report/language.hpp"
#include "show/report/surface_page.hpp"

namespace plumbline::report {

void ReportSurfaces::run(Context& context) {
  const Speaking speaking(speech_of(*language, *units));
  SurfaceJudgementT judged;
  if (surface_judgement) judged = surface_judgement.unpack();
  std::vector<FacadePicture> pictures;
  if (orthophoto) pictures = read_pictures(context, orthophoto.unpack());
  FileT file;
  file.name = "surfaces.html", file.media_type = "text/html";
  SurfacesT measured = surfaces.unpack();
  ifc::enlarge(measured, judged.covariance_factor);
  const std::string html = render_surface_page(measured, surface_judgement ? &judged : nullptr, *title, pictures);
  file.content.assign(html.begin(), html.end());
  out.commit(file);
}

}  // namespace plumbline::report
