// How far the shape of an element reaches: points whose box is that of the geometry, without tessellating it.
//
// Exact for everything bounded by points, lines and planes; circles and arcs are sampled (at most 0.5 % of the radius
// short), splines give their control points, and of a boolean difference or intersection the first operand counts.
// Lengths in the file's unit.
#pragma once

#include <map>
#include <unordered_map>

#include "building/ifc/ifc_placement.hpp"

namespace plumbline::ifc {

using PointCloud = std::vector<Eigen::Vector3d>;

/// A kind of geometry that is not read; the message names it.
struct UnsupportedGeometry : step::Error {
  using step::Error::Error;
};

/// One item of a representation.
struct ItemExtent {
  PointCloud points;  ///< in the coordinates of the representation
  std::optional<Eigen::Vector3d>
      axis_middle;  ///< of an extrusion, a cylinder or a straight rod: the middle of its axis
  /// Polygons of its boundary without their holes, where they were asked for and all of them can be told; else empty.
  std::vector<PointCloud> faces = {};
};

class Extents {
 public:
  /// `radian` is radians in one plane angle unit of the file. `with_faces`: ItemExtent::faces are made too.
  Extents(const Model& model, double radian, bool with_faces = false);

  /// The extents of the items of an IfcProductDefinitionShape that show the body of the element; mapped items come as
  /// the items they show. Throws UnsupportedGeometry, or step::Error for damage.
  std::vector<ItemExtent> of_shape(std::uint64_t shape, std::uint64_t referrer);

  ItemExtent of_item(std::uint64_t item, std::uint64_t referrer, int depth = 0);
  PointCloud of_curve(std::uint64_t curve, std::uint64_t referrer, int depth = 0) const;
  PointCloud of_profile(std::uint64_t profile, std::uint64_t referrer, int depth = 0) const;

 private:
  std::vector<ItemExtent> of_representation(const Entity& representation, int depth);
  std::vector<ItemExtent> of_mapped_item(const Entity& item, int depth);
  ItemExtent of_extrusion(const Entity& solid, int depth) const;
  ItemExtent of_revolution(const Entity& solid, int depth) const;
  ItemExtent of_rod(const Entity& solid, int depth) const;
  ItemExtent of_primitive(const Entity& solid) const;
  /// Whether all of them are polygons.
  bool add_faces(const std::vector<std::uint64_t>& faces, std::uint64_t referrer, ItemExtent& extent) const;
  void add_loop(const Entity& loop, PointCloud& points) const;
  void add_indexed_faces(const Entity& item, ItemExtent& extent) const;
  /// The outline of a profile, point after point; empty where that is not known.
  PointCloud outline_of(std::uint64_t profile, std::uint64_t referrer) const;

  /// Counts instances visited and points made; throws UnsupportedGeometry when an element, or all of them together,
  /// need more than any building does: a few lines of nested items can describe 10^12 of them.
  void charge(std::size_t work) const;

  const Model& model_;
  double radian_;
  bool with_faces_;
  mutable std::size_t work_left_, work_left_of_file_;
  std::unordered_map<std::uint64_t, std::vector<ItemExtent>>
      maps_;  // by IfcRepresentationMap: they are shown many times
};

}  // namespace plumbline::ifc
