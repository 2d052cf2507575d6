#include "photo/block/image_block_folder.hpp"

#include <algorithm>
#include <stdexcept>

#include "photo/block/aicon_files.hpp"
#include "photo/block/bal_files.hpp"
#include "photo/block/control_list.hpp"
#include "photo/block/photomodeler_files.hpp"
#include "plumbline/folder_files.hpp"

namespace plumbline::block {
namespace {

namespace fs = std::filesystem;

enum class Format { aicon, photomodeler, bal };
struct Found {
  fs::path path;  ///< file, or the folder of an AICON block
  Format format;
};

/// All blocks in a folder and below, by path.
std::vector<Found> blocks_in(const fs::path& folder) {
  std::vector<Found> found;
  for (const std::string& file : list_files(folder).files) {
    if (is_system_file(file)) continue;
    const fs::path path = folder / file;
    const std::string name = path.filename().string();
    if (path.extension() == ".phc")
      found.push_back({path.parent_path(), Format::aicon});
    else if (path.extension() == ".txt" && name.find("pmexport") != std::string::npos)
      found.push_back({path, Format::photomodeler});
    else if (path.extension() == ".txt" && looks_like_photomodeler(path))
      found.push_back({path, Format::photomodeler});
    else if ((path.extension() == ".txt" || path.extension() == ".bal") && looks_like_bal(path))
      found.push_back({path, Format::bal});
  }
  std::sort(found.begin(), found.end(), [](const Found& a, const Found& b) { return a.path < b.path; });
  // Several .phc files of one folder are one block that its reader refuses with their names.
  found.erase(std::unique(found.begin(), found.end(), [](const Found& a, const Found& b) { return a.path == b.path; }),
              found.end());
  return found;
}

/// Names of the files that a block was read from.
std::vector<std::string> files_of(const Found& found) {
  if (found.format != Format::aicon) return {found.path.filename().string()};
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(found.path)) {
    const std::string end = entry.path().extension().string();
    for (const char* part : {".phc", ".obc", ".eor", ".ior", ".scale"})
      if (end == part) names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::string colmap_hint(const fs::path& folder) {
  for (const char* name : {"images.bin", "images.txt", "sparse/0/images.bin", "sparse/0/images.txt"})
    if (fs::is_regular_file(folder / name)) return "; a COLMAP model is adjusted by `plumbline run colmap_control`";
  return "";
}

}  // namespace

ReadBlock read_image_block(const fs::path& folder, const std::string& project, const std::string& control,
                           const std::vector<std::string>& check, const std::array<int, 2>& image_size) {
  if (!fs::is_directory(folder)) throw std::runtime_error(folder.string() + " is not a folder");
  std::vector<Found> found = blocks_in(folder);
  std::vector<std::string> names;
  for (const auto& block : found) names.push_back(fs::relative(block.path, folder).string());
  if (!project.empty())
    std::erase_if(found, [&](const Found& block) {
      return block.path.filename().string().rfind(project, 0) != 0 &&
             fs::relative(block.path, folder).string().rfind(project, 0) != 0;
    });
  if (found.size() != 1)
    throw std::runtime_error(
        folder.string() + (names.empty()
                               ? " holds no AICON block (.phc, .obc, .eor, .ior), no PhotoModeler text export "
                                 "(*pmexport*.txt) and no bundle adjustment problem (BAL)" +
                                     colmap_hint(folder)
                               : " holds " + std::to_string(names.size()) + " blocks (" + few_of(names) + ")" +
                                     (project.empty() ? ": choose one with project=BEGINNING_OF_ITS_NAME"
                                                      : ", and project=" + project + " does not choose one of them")));
  ReadBlock read;
  const fs::path& path = found[0].path;
  if (found[0].format == Format::aicon) {
    AiconBlock block = read_aicon_folder(path);
    read = {std::move(block.block), block.measurements_read, std::move(block.left_out)};
  } else {
    read = found[0].format == Format::bal ? read_bal_file(path, bal_pixel_pitch)
                                          : read_photomodeler_export(path, image_size);
  }
  read.files = files_of(found[0]);
  if (!control.empty()) {
    const fs::path inside = folder / control, beside = path.parent_path() / control;
    const fs::path file = fs::is_regular_file(inside)   ? inside
                          : fs::is_regular_file(beside) ? beside
                                                        : fs::path(control);
    add_control(file, check, read);
    read.files.push_back(file.filename().string());
  } else if (!check.empty()) {
    throw std::runtime_error("check points need a list of coordinates: control=FILE");
  }
  drop_unusable(read);
  return read;
}

}  // namespace plumbline::block
