#include "observation_files.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>
#include <utility>

#include "base/text/csv_table.hpp"
#include "base/text/text.hpp"

namespace plumbline::markers {
namespace {

using Json = nlohmann::json;

[[noreturn]] void fail(const std::string& place, const std::string& what) {
  throw std::runtime_error(place + ": " + what);
}

int tag_id(double value, const std::string& place) {
  if (!(value >= 0 && value <= std::numeric_limits<int>::max()) || value != std::floor(value))
    fail(place, "the id is no whole number from 0 to " + std::to_string(std::numeric_limits<int>::max()));
  return static_cast<int>(value);
}

/// xx, xy, yy of a corner.
void add_covariance(const Json& entry, const std::string& place, TagT& tag) {
  if (!entry.is_array() || entry.size() != 3) fail(place, "a covariance has three numbers: xx, xy, yy [px²]");
  const double xx = entry[0].get<double>(), xy = entry[1].get<double>(), yy = entry[2].get<double>();
  if (!(xx > 0 && yy > 0 && xx * yy - xy * xy > 0) || !std::isfinite(xx + yy))
    fail(place, "found " + entry.dump() + ", which is no covariance (xx and yy above zero, xx yy above xy²)");
  for (const double value : {xx, xy, yy}) tag.corner_covariances.push_back(value);
}

std::unique_ptr<TagT> tag_of(const Json& entry, const std::string& place) {
  auto tag = std::make_unique<TagT>();
  tag->family = entry.at("family").get<std::string>();
  tag->id = tag_id(entry.at("id").get<double>(), place);
  tag->refined = entry.value("refined", false);
  for (const auto& c : entry.at("corners")) {
    tag->corners.push_back({c.at(0).get<double>(), c.at(1).get<double>()});
    if (!tag->corners.back().allFinite()) fail(place, "a corner is no pair of numbers");
  }
  if (tag->corners.size() != 4) fail(place, "found " + std::to_string(tag->corners.size()) + " corners, expected 4");
  if (!entry.contains("covariance")) return tag;
  const Json& covariances = entry.at("covariance");
  if (covariances.size() != 4)
    fail(place, "found " + std::to_string(covariances.size()) + " covariances, expected one of each of the 4 corners");
  for (const auto& c : covariances) add_covariance(c, place, *tag);
  return tag;
}

TagObservationsT from_json(const std::string& text, const std::string& name) {
  TagObservationsT result;
  try {
    const Json root = Json::parse(text);
    std::set<std::string> paths;
    for (const Json& entry : root.at("images")) {
      auto image = std::make_unique<ImageTagsT>();
      image->path = entry.at("path").get<std::string>();
      if (!paths.insert(image->path).second) fail("image '" + image->path + "'", "stands here a second time");
      image->width = entry.value("width", 0), image->height = entry.value("height", 0);
      image->problem = entry.value("problem", std::string());
      if (entry.contains("corner_inset_sigma"))
        image->corner_inset_sigma = entry.at("corner_inset_sigma").get<double>();
      if (!std::isnan(image->corner_inset_sigma) &&
          !(image->corner_inset_sigma >= 0 && image->corner_inset_sigma <= 10))
        fail("image '" + image->path + "'",
             "corner_inset_sigma is " + text::format_shortest(image->corner_inset_sigma) + ", expected are 0 to 10 px");
      for (const Json& tag : entry.at("tags"))
        image->tags.push_back(
            tag_of(tag, "image '" + image->path + "', tag " + std::to_string(image->tags.size() + 1)));
      result.images.push_back(std::move(image));
    }
  } catch (const std::exception& error) {
    throw std::runtime_error(name + ": not the observations.json of a detector (" + error.what() +
                             "); docs/photographs.md has its fields");
  }
  return result;
}

constexpr std::array<const char*, 12> kColumns = {"image", "family", "tag_id", "x0", "y0", "x1",
                                                  "y1",    "x2",     "y2",     "x3", "y3", "sigma"};

/// Where the columns of the table stand.
std::array<std::size_t, 12> columns_of(const text::CsvTable& table, const std::string& name) {
  std::array<std::size_t, 12> places{};
  for (std::size_t k = 0; k < kColumns.size(); ++k) {
    std::size_t at = 0;
    while (at < table.header.size() && table.header[at].name != kColumns[k]) ++at;
    if (at == table.header.size())
      fail(
          name + ":" + std::to_string(std::max(1, table.header_line)),
          std::string("no column '") + kColumns[k] +
              "'; expected are image,family,tag_id,x0_px,y0_px, ... y3_px,sigma_px: corners bottom left, bottom right, "
              "top right, top left, the first pixel at (0, 0)");
    if (const std::string& unit = table.header[at].unit; k >= 3 && !unit.empty() && unit != "px")
      fail(name + ":" + std::to_string(table.header_line),
           "column '" + std::string(kColumns[k]) + "' is in '" + unit + "', expected are pixels (px)");
    places[k] = at;
  }
  return places;
}

TagObservationsT from_csv(const std::string& text, const std::string& name) {
  std::map<std::string, std::string> known;
  for (const char* column : kColumns) known[column] = column;
  const text::CsvTable table = text::read_csv(text, known);
  if (!table.doubtful.empty()) fail(name + ":" + std::to_string(table.doubtful.front().line), text::kDoubtfulRow);
  const auto columns = columns_of(table, name);
  TagObservationsT result;
  std::map<std::string, ImageTagsT*> images;
  std::set<std::pair<std::string, std::pair<std::string, int>>> seen;
  for (const text::CsvRow& row : table.rows) {
    const std::string place = name + ":" + std::to_string(row.line);
    const auto cell = [&](std::size_t k) -> const text::CsvCell& {
      if (columns[k] >= row.cells.size())
        fail(place, std::string("the cell of column '") + kColumns[k] + "' is missing");
      return row.cells[columns[k]];
    };
    const auto number = [&](std::size_t k) {
      const auto value = table.number(cell(k));
      if (!value || !std::isfinite(*value))
        fail(place, std::string(kColumns[k]) + ": found '" + cell(k).text + "', expected a number");
      return *value;
    };
    auto tag = std::make_unique<TagT>();
    tag->family = cell(1).text, tag->id = tag_id(number(2), place), tag->refined = true;
    for (std::size_t k = 3; k < 11; k += 2) tag->corners.push_back({number(k), number(k + 1)});
    const double sigma = number(11);
    if (!(sigma > 0)) fail(place, "sigma: found " + cell(11).text + ", expected more than 0 px");
    for (int corner = 0; corner < 4; ++corner)
      for (const double value : {sigma * sigma, 0.0, sigma * sigma}) tag->corner_covariances.push_back(value);
    const std::string path = cell(0).text;
    if (!seen.insert({path, {tag->family, tag->id}}).second)
      fail(place, "tag " + std::to_string(tag->id) + " stands here a second time in image '" + path + "'");
    ImageTagsT*& image = images[path];
    if (!image) {
      result.images.push_back(std::make_unique<ImageTagsT>());
      image = result.images.back().get();
      image->path = path;
    }
    image->tags.push_back(std::move(tag));
  }
  if (result.images.empty()) fail(name, "holds no tag");
  return result;
}

}  // namespace

TagObservationsT parse_observations(const std::string& text, const std::string& name) {
  const std::size_t first = text.find_first_not_of(" \t\r\n\xef\xbb\xbf");
  const bool json = first != std::string::npos && (text[first] == '{' || text[first] == '[');
  return json ? from_json(text.substr(first), name) : from_csv(text, name);
}

}  // namespace plumbline::markers
