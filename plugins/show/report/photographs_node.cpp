#include "show/report/photographs_node.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/text/whole_file.hpp"

namespace plumbline::report {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kListing = "photographs.json";
constexpr const char* kFormat = "plumbline-photographs/1";

Json point(const Eigen::Vector2d& at) { return {at.x(), at.y()}; }
Json point(const std::optional<Eigen::Vector2d>& at) { return at ? point(*at) : Json(nullptr); }
std::optional<Eigen::Vector2d> point_of(const Json& json) {
  if (json.is_null()) return std::nullopt;
  return Eigen::Vector2d(json.at(0).get<double>(), json.at(1).get<double>());
}

std::string file_of(std::size_t i) { return "part_" + std::to_string(1000 + i).substr(1) + ".jpg"; }

Json to_json(const AnchorPhotograph& part, const std::string& file) {
  Json outline = Json::array();
  for (const Eigen::Vector2d& corner : part.outline) outline.push_back(point(corner));
  return {{"anchor", part.anchor},
          {"verdict", EnumNameToleranceVerdict(part.verdict)},
          {"photograph", part.photograph},
          {"tag", part.tag},
          {"file", file},
          {"size", {part.width, part.height}},
          {"marker", outline},
          {"design", point(part.design)},
          {"as_built", point(part.as_built)}};
}

AnchorPhotograph part_of(const Json& json) {
  AnchorPhotograph part;
  part.anchor = json.at("anchor"), part.photograph = json.at("photograph"), part.tag = json.at("tag");
  part.verdict = json.at("verdict") == EnumNameToleranceVerdict(ToleranceVerdict::fail) ? ToleranceVerdict::fail
                                                                                        : ToleranceVerdict::undecided;
  part.width = json.at("size").at(0), part.height = json.at("size").at(1);
  for (const Json& corner : json.at("marker")) part.outline.push_back(*point_of(corner));
  part.design = point_of(json.at("design")), part.as_built = point_of(json.at("as_built"));
  return part;
}

}  // namespace

void ReportPhotographs::run(Context& context) {
  PhotographSources sources;
  for (size_t i = 0; i < tags.size(); ++i) sources.tags.push_back(tags.unpack(i));
  for (size_t i = 0; i < images.size(); ++i)
    sources.files[images[i].path()->str()] = context.resolve(images[i].uri()->str());
  sources.plates = plates.unpack();
  if (poses) sources.poses = poses.unpack();
  if (camera) sources.camera = camera.unpack();
  const AnchorPhotographs found = photographs_of(deviation.unpack(), sources);
  const auto place = folder.make_folder();
  FolderT listing;
  listing.uri = place.uri;
  const auto write = [&](const std::string& name, const std::string& bytes) {
    std::ofstream(place.path + "/" + name, std::ios::binary) << bytes;
    auto entry = std::make_unique<FolderEntryT>();
    entry->path = name, entry->sha256 = context.digest(place.path + "/" + name), entry->size = bytes.size();
    listing.files.push_back(std::move(entry));
  };
  Json parts = Json::array();
  for (std::size_t i = 0; i < found.parts.size(); ++i) {
    write(file_of(i), found.parts[i].jpeg);
    parts.push_back(to_json(found.parts[i], file_of(i)));
  }
  const Json document = {{"format", kFormat},
                         {"units", {{"length", "px of the photograph, from the part's corner"}}},
                         {"parts", parts},
                         {"not_shown", found.not_shown},
                         {"not_read", found.not_read},
                         {"not_cut", found.not_cut},
                         {"left_out", found.left_out}};
  write(kListing, document.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
  std::sort(listing.files.begin(), listing.files.end(), [](const auto& a, const auto& b) { return a->path < b->path; });
  for (const auto& [path, reason] : found.not_read) context.warn(path + " cannot be shown: " + reason);
  for (const auto& [anchor, reason] : found.not_cut) context.warn("anchor " + anchor + " is not shown: " + reason);
  context.info(std::to_string(found.parts.size()) + " parts of photographs of what is not in order");
  folder.commit(listing);
}

AnchorPhotographs read_photographs(const Context& context, const FolderT& folder) {
  const auto bytes_of = [&](const std::string& name) {
    const auto found =
        std::find_if(folder.files.begin(), folder.files.end(), [&](const auto& file) { return file->path == name; });
    if (found == folder.files.end())
      throw std::runtime_error("'photographs' has no file " + name +
                               "; connect the port 'folder' of report.photographs");
    return text::read_whole(context.resolve("sha256:" + (*found)->sha256 + "/" + name));
  };
  const Json document = Json::parse(bytes_of(kListing), nullptr, false);
  if (document.is_discarded() || document.value("format", "") != kFormat)
    throw std::runtime_error(std::string("the file ") + kListing + " of 'photographs' is none of report.photographs");
  AnchorPhotographs photographs;
  for (const Json& part : document.at("parts")) {
    photographs.parts.push_back(part_of(part));
    photographs.parts.back().jpeg = bytes_of(part.at("file"));
  }
  photographs.not_shown = document.at("not_shown").get<std::vector<std::string>>();
  photographs.not_read = document.at("not_read").get<std::map<std::string, std::string>>();
  photographs.not_cut = document.at("not_cut").get<std::map<std::string, std::string>>();
  photographs.left_out = document.at("left_out");
  return photographs;
}

}  // namespace plumbline::report
