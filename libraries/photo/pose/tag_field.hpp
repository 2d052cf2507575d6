// Tags as a pose sees them: the plate of every tag with its anchor's approximate coordinates, and the view of one tag
// in one image.
#pragma once

#include <map>
#include <optional>
#include <utility>

#include "artifacts/camera_artifact.hpp"
#include "photo/pose/pose_node.hpp"

namespace plumbline::pose {

/// The plate of every tag, with its anchor's approximate coordinates.
class Field {
 public:
  struct Entry {
    const PlateT* plate;
    const PointT* point;
  };

  Field(const PlatesT& plates, const PointsT& points) {
    std::map<std::string, const PointT*> by_id;
    for (const auto& point : points.points) by_id[point->id] = point.get();
    for (const auto& plate : plates.plates) {
      const auto point = by_id.find(plate->anchor);
      if (point == by_id.end() || !point->second->position.allFinite()) continue;
      if (!(point->second->position.cwiseAbs().maxCoeff() < furthest))  // it would be the mean of all others, too
        throw std::runtime_error("anchor " + plate->anchor +
                                 " is more than 1e9 m from the origin by its approximate coordinates; correct them: "
                                 "expected are metres");
      const auto added =
          entries_.emplace(std::make_pair(plate->tag_family, plate->tag_id), Entry{plate.get(), point->second});
      if (!added.second)
        throw std::runtime_error("tag " + plate->tag_family + " " + std::to_string(plate->tag_id) +
                                 " stands for two anchors, " + added.first->second.plate->anchor + " and " +
                                 plate->anchor + "; correct the plate table");
      if (!(plate->tag_size > 0))
        throw std::runtime_error("the plate of anchor " + plate->anchor + " has no tag_size; give it in metres");
    }
  }
  const Entry* find(const TagT& tag) const {
    const auto found = entries_.find({tag.family, tag.id});
    return found == entries_.end() ? nullptr : &found->second;
  }
  std::size_t size() const { return entries_.size(); }
  const std::map<std::pair<std::string, int>, Entry>& entries() const { return entries_; }

 private:
  static constexpr double furthest = 1e9;  ///< [m]
  std::map<std::pair<std::string, int>, Entry> entries_;
};

/// Nothing for a tag whose corners cannot be: too few, or outside of where the distortion can be inverted.
std::optional<TagView> view_of(const TagT& tag, const Field::Entry& entry, const BrownCamera& camera,
                               const PoseSettings& settings);

}  // namespace plumbline::pose
