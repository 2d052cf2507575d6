#include "show/report/surface_page_node.hpp"

#include <algorithm>

#include "base/text/whole_file.hpp"
#include "building/ifc/enlarged_surfaces.hpp"
#include "show/report/language.hpp"
#include "show/report/surface_page.hpp"

namespace plumbline::report {

std::vector<FacadePicture> read_pictures(const Context& context, const FolderT& folder) {
  return facade_pictures([&](const std::string& name) {
    const auto found =
        std::find_if(folder.files.begin(), folder.files.end(), [&](const auto& file) { return file->path == name; });
    if (found == folder.files.end())
      throw std::runtime_error("'orthophoto' has no file " + name +
                               "; connect the port 'folder' of surface.orthophoto");
    std::string bytes = text::read_whole(context.resolve("sha256:" + (*found)->sha256 + "/" + name));
    if (bytes.size() != (*found)->size)
      throw std::runtime_error("the file " + name + " of 'orthophoto' has " + std::to_string(bytes.size()) +
                               " bytes, " + std::to_string((*found)->size) + " are expected");
    return bytes;
  });
}

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
