#include "photo/pose/tag_checks.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

namespace plumbline::pose {

std::string unknown_tags(const std::vector<ImageTagsT>& images, const PlatesT& plates) {
  std::set<std::pair<std::string, int>> listed;
  for (const auto& plate : plates.plates) listed.insert({plate->tag_family, plate->tag_id});
  std::map<std::pair<std::string, int>, int> unknown;
  for (const ImageTagsT& image : images)
    for (const auto& tag : image.tags)
      if (!listed.count({tag->family, tag->id})) ++unknown[{tag->family, tag->id}];
  if (unknown.empty()) return "";
  std::string names;
  std::size_t shown = 0;
  for (const auto& [key, count] : unknown)
    if (++shown <= 6)
      names += (shown > 1 ? ", " : "") + key.first + " " + std::to_string(key.second) + " (in " +
               std::to_string(count) + (count == 1 ? " image)" : " images)");
  return std::to_string(unknown.size()) + (unknown.size() == 1 ? " tag is" : " tags are") +
         " in no row of the plate table and " + (unknown.size() == 1 ? "was" : "were") + " not used: " + names +
         (shown > 6 ? ", …" : "");
}

namespace {

/// Photographs that were held by hand, or by a crane, differ by hundreds of pixels; one that was saved again, by
/// hundredths of one.
constexpr double same_place = 1.0 / 3;  // [px]

using TagsById = std::map<std::pair<std::string, int>, const TagT*>;

/// Root mean square distance of the corners that two images share [px]; infinite unless they share three tags and most
/// of those of the one with fewer.
double distance_of(const TagsById& a, const TagsById& b) {
  double squares = 0;
  std::size_t shared = 0;
  for (const auto& [id, tag] : a) {
    const auto other = b.find(id);
    if (other == b.end()) continue;
    ++shared;
    for (std::size_t k = 0; k < std::min(tag->corners.size(), other->second->corners.size()); ++k)
      squares += (tag->corners[k] - other->second->corners[k]).squaredNorm();
    if (squares > 1e4) return std::numeric_limits<double>::infinity();
  }
  const std::size_t fewer = std::min(a.size(), b.size());
  if (shared == 0 || shared < std::min<std::size_t>(3, fewer) || 5 * shared < 4 * fewer)
    return std::numeric_limits<double>::infinity();
  return std::sqrt(squares / (4.0 * static_cast<double>(shared)));
}

}  // namespace

std::vector<std::string> same_photographs(const std::vector<ImageTagsT>& images) {
  std::vector<std::map<std::pair<std::string, int>, const TagT*>> tags(images.size());
  for (std::size_t i = 0; i < images.size(); ++i)
    for (const auto& tag : images[i].tags) tags[i].emplace(std::pair(tag->family, tag->id), tag.get());
  std::vector<std::string> sentences;
  for (std::size_t j = 0; j < images.size(); ++j)
    for (std::size_t i = 0; i < j; ++i) {
      const double apart = distance_of(tags[i], tags[j]);
      if (!(apart < same_place)) continue;
      const std::string text = fmt::format(" show the same tags {}: they are ",
                                           apart == 0 ? "in the same places" : "within a third of a pixel");
      sentences.push_back(images[j].path + " and " + images[i].path + text +
                          (apart == 0 ? "the same photograph, which counts twice; take one away"
                                      : "one photograph saved twice, which counts twice, or two from the very same "
                                        "place, which add little; take one away"));
      break;
    }
  return sentences;
}

}  // namespace plumbline::pose
