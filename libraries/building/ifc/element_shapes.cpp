#include "building/ifc/element_shapes.hpp"

#include <Eigen/Geometry>
#include <unordered_map>

namespace plumbline::ifc {

void ElementShapes::read(const Entity& entity, Element& element) {
  std::vector<ItemExtent> items;
  try {
    if (const auto shape = entity.optional_reference("Representation")) items = extents_.of_shape(*shape, entity.id());
  } catch (const UnsupportedGeometry& reason) {
    auto& [count, first] = unread_[reason.what()];
    if (++count == 1) first = element.ifc_class + " '" + element.name + "' (#" + std::to_string(element.instance) + ")";
    return;
  } catch (const step::Error& error) {  // a dangling reference, an argument of another kind
    auto& [count, first] = damage_["IFCPRODUCTDEFINITIONSHAPE, whose elements keep the origin of their placement,"];
    if (++count == 1) first = error.what();
    return;
  }
  Eigen::AlignedBox3d box;
  for (const ItemExtent& item : items)
    for (const Eigen::Vector3d& point : item.points) box.extend(Eigen::Vector3d(point * metres_));
  if (box.isEmpty() || !box.min().allFinite() || !box.max().allFinite()) return;
  element.has_box = true;
  element.box_low = box.min();
  element.box_high = box.max();
  const Eigen::Vector3d slack = Eigen::Vector3d::Constant(kPlacementSlack);
  Eigen::Vector3d local = Eigen::Vector3d::Zero();
  if (!Eigen::AlignedBox3d(box.min() - slack, box.max() + slack).contains(local)) {
    const bool axis = items.size() == 1 && items[0].axis_middle;
    element.rule = axis ? ReferencePointRule::axis_middle : ReferencePointRule::bounding_box_centre;
    local = axis ? Eigen::Vector3d(*items[0].axis_middle * metres_) : box.center();
  }
  element.position = element.project_from_element * local;
  if (!element.is_anchor || items.size() < 2) return;
  for (const ItemExtent& item : items) {
    Eigen::AlignedBox3d own;
    for (const Eigen::Vector3d& point : item.points) own.extend(Eigen::Vector3d(point * metres_));
    element.item_positions.push_back(element.project_from_element * own.center());
  }
}

void ElementShapes::tell_unread(Design& design) const {
  for (const auto& [kind, unread] : unread_) {
    const auto& [count, first] = unread;
    design.warnings.push_back(
        (count == 1 ? first + " keeps the origin of its placement"
                    : std::to_string(count) + " elements, such as " + first + ", keep the origin of their placement") +
        " as reference point: " + kind);
  }
}

void place_aggregates(const Tree& tree, Design& design) {
  std::unordered_map<std::uint64_t, std::size_t> index;
  for (std::size_t i = 0; i < design.elements.size(); ++i) index[design.elements[i].instance] = i;
  std::map<std::size_t, Eigen::AlignedBox3d> boxes;  // in the axes of the aggregate
  for (const Element& part : design.elements) {
    std::uint64_t above = part.instance;
    for (int depth = 0; depth < 100; ++depth) {
      const auto up = tree.whole.find(above);
      if (up == tree.whole.end() || !index.contains(up->second)) break;
      above = up->second;
      Element& whole = design.elements[index[above]];
      if (depth == 0) design.elements[index[part.instance]].parent_guid = whole.guid;
      if (whole.has_box || !part.has_box) continue;
      const RigidTransform whole_from_part = whole.project_from_element.inverse() * part.project_from_element;
      for (int corner = 0; corner < 8; ++corner) {
        const Eigen::Vector3d point(corner & 1 ? part.box_high.x() : part.box_low.x(),
                                    corner & 2 ? part.box_high.y() : part.box_low.y(),
                                    corner & 4 ? part.box_high.z() : part.box_low.z());
        boxes[index[above]].extend(Eigen::Vector3d(whole_from_part * point));
      }
    }
  }
  for (const auto& [i, box] : boxes) {
    Element& whole = design.elements[i];
    whole.has_box = true;
    whole.box_low = box.min();
    whole.box_high = box.max();
    const Eigen::Vector3d slack = Eigen::Vector3d::Constant(kPlacementSlack);
    if (Eigen::AlignedBox3d(box.min() - slack, box.max() + slack).contains(Eigen::Vector3d::Zero().eval())) continue;
    whole.rule = ReferencePointRule::parts_centre;
    whole.position = whole.project_from_element * Eigen::Vector3d(box.center());
  }
}

const char* name_of(ReferencePointRule rule) {
  switch (rule) {
    case ReferencePointRule::placement:
      return "placement";
    case ReferencePointRule::axis_middle:
      return "axis_middle";
    case ReferencePointRule::bounding_box_centre:
      return "bounding_box_centre";
    case ReferencePointRule::parts_centre:
      return "parts_centre";
  }
  return "";
}

}  // namespace plumbline::ifc
