#include "field_node.hpp"

#include <map>
#include <set>

namespace plumbline::markers {
namespace {

/// Sets size and place of the markers that are in the layout; tells of those that are not.
void apply_layout(const PlatesT& plates, const PointsT& points, double tag_size, BlockInput& input) {
  std::map<std::string, const PointT*> position;
  for (const auto& point : points.points) position[point->id] = point.get();
  std::map<std::pair<std::string, int>, const PlateT*> plate_of;
  for (const auto& plate : plates.plates) {
    const auto added = plate_of.emplace(std::make_pair(plate->tag_family, plate->tag_id), plate.get());
    if (!added.second)
      throw std::runtime_error("the layout has tag " + std::to_string(plate->tag_id) + " twice, as " +
                               added.first->second->anchor + " and " + plate->anchor + "; correct the layout");
  }
  std::set<std::string> unknown;
  for (Marker& marker : input.block.markers) {
    auto found = plate_of.find({marker.family, marker.id});
    if (found == plate_of.end()) found = plate_of.find({"", marker.id});  // layouts that name no family
    if (found == plate_of.end() || !position.count(found->second->anchor)) {
      unknown.insert(marker.name());
      continue;
    }
    const PlateT& plate = *found->second;
    marker.size = plate.tag_size > 0 ? plate.tag_size : tag_size;
    if (!(marker.size > 0))
      throw std::runtime_error("the layout does not say how large tag " + marker.name() +
                               " is; set tag_size to its edge in metres");
    const Eigen::Quaterniond rotation = plate.nominal_rotation.normalized();
    marker.world_from_tag =
        RigidTransform{rotation, position[plate.anchor]->position + rotation * plate.tag_centre_in_plate};
  }
  if (unknown.empty()) return;
  std::string list;
  for (const auto& name : unknown) list += (list.empty() ? "" : ", ") + name;
  input.warnings.push_back((unknown.size() == 1 ? "tag " : "tags ") + list + " of the photographs " +
                           (unknown.size() == 1 ? "is" : "are") +
                           " not in the layout: placed from the photographs, where several show them");
  for (Marker& marker : input.block.markers)
    if (!marker.world_from_tag && tag_size > 0) marker.size = tag_size;
  // Without a size of its own a tag outside the layout cannot help.
  std::erase_if(input.block.views,
                [&](const MarkerView& view) { return !(input.block.markers[view.marker].size > 0); });
  for (Marker& marker : input.block.markers)
    if (!(marker.size > 0)) marker.size = 1;
}

}  // namespace

void AdjustMarkerField::run(Context& context) {
  std::vector<ImageT> photographs;
  for (size_t i = 0; i < images.size(); ++i) photographs.push_back(images.unpack(i));
  std::vector<CameraT> known;
  for (size_t i = 0; i < calibrations.size(); ++i) known.push_back(calibrations.unpack(i));
  BlockInput input = block_of(photographs, observations.unpack(), known, {*tag_size, *cameras});
  apply_layout(plates.unpack(), layout.unpack(), *tag_size, input);
  for (const auto& image : input.left_out) context.warn("left out: " + image.path + ": " + image.reason);
  for (const auto& text : input.warnings) context.warn(text);
  if (!has_place(input.block))
    throw std::runtime_error(
        "no photograph shows a tag of the layout" +
        (input.left_out.empty() ? std::string()
                                : " (" + input.left_out.front().path + " " + input.left_out.front().reason + ")") +
        ". Check the family of the tags, that the layout has their numbers, and which camera took them");
  MarkerOptions options;
  options.shape_sigma = *shape_sigma, options.twist_sigma = *twist_sigma;
  options.size_sigma = *size_sigma, options.inset_sigma = *corner_inset_sigma, options.reject_above = *reject_above;
  options.layout_position_sigma = *position_sigma, options.layout_rotation_sigma = *rotation_sigma;
  const MarkerResult result = adjust_lens_and_block(input.block, options);
  for (const auto& text : result.left_out) context.warn("left out: " + text);
  for (const auto& text : result.warnings) context.warn(text);
  context.metric("rms", result.rms, "px");
  double oriented = 0;
  for (const auto& image : result.images) oriented += image.oriented;
  context.metric("images_oriented", oriented, "1");
  poses_file.commit(file_of("poses.json", "application/json", poses_json(input, result)));
  table.commit(file_of("points.csv", "text/csv", points_csv(input.block, result)));
  block.commit(file_of("block.json", "application/json", block_json(input, result)));
  points.commit(points_of(input.block, result));
  poses.commit(poses_of(input.block, result));
}

bool AdjustMarkerField::has_place(const MarkerBlock& given) {
  for (const auto& view : given.views)
    if (given.markers[view.marker].world_from_tag) return true;
  return false;
}

}  // namespace plumbline::markers
