#include "ids_node.hpp"

#include "artifacts.hpp"
#include "building/ifc/ids.hpp"

namespace plumbline::ifc {

void WriteIds::run(Context&) {
  FileT file;
  file.name = "asbuilt.ids", file.media_type = "application/xml";
  const std::string text = write_ids(from_artifact(design.unpack()), deviation.unpack(), {*epoch, "", *must_pass});
  file.content.assign(text.begin(), text.end());
  out.commit(file);
}

}  // namespace plumbline::ifc
