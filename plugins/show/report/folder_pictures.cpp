#include "show/report/folder_pictures.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "base/text/whole_file.hpp"

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

}  // namespace plumbline::report
