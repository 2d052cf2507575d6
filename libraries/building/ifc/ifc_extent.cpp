// Extents of solids and of representations.
#include "building/ifc/ifc_extent.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace plumbline::ifc {
namespace {

constexpr int kDeepestPlacement = 64;
constexpr int kSamplesOfRevolution = 32;
/// Instances and points that one element may need: the densest real ones (scanned ornaments) have some 10^5.
constexpr std::size_t kWorkOfElement = 2'000'000;
/// The same for a whole file, which grows with it: honest geometry shows every byte a few times.
constexpr std::size_t kWorkOfSmallFile = 20'000'000;

Eigen::Vector3d middle(const PointCloud& points) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& point : points) box.extend(point);
  return box.center();
}

void append(PointCloud& to, const PointCloud& from) { to.insert(to.end(), from.begin(), from.end()); }

void transform(ItemExtent& item, const Eigen::Affine3d& motion) {
  for (Eigen::Vector3d& point : item.points) point = motion * point;
  if (item.axis_middle) item.axis_middle = motion * *item.axis_middle;
  for (PointCloud& face : item.faces)
    for (Eigen::Vector3d& point : face) point = motion * point;
}

/// Between two outlines of as many points, one after the other.
void add_strip(const PointCloud& from, const PointCloud& to, std::vector<PointCloud>& faces) {
  for (std::size_t i = 0; i < from.size(); ++i) {
    const std::size_t next = (i + 1) % from.size();
    faces.push_back({from[i], from[next], to[next], to[i]});
  }
}

Eigen::Affine3d affine(const RigidTransform& motion) {
  Eigen::Affine3d result = Eigen::Affine3d::Identity();
  result.linear() = motion.rotation.toRotationMatrix();
  result.translation() = motion.translation;
  return result;
}

/// IfcCartesianTransformationOperator: axes, origin and scales (IfcBaseAxis).
Eigen::Affine3d read_operator(const Model& model, std::uint64_t id, std::uint64_t referrer) {
  const Entity op = model.entity(id, referrer);
  const bool flat = op.keyword().starts_with("IFCCARTESIANTRANSFORMATIONOPERATOR2D");
  const auto axis = [&](const char* attribute, const Eigen::Vector3d& fallback) {
    const auto given = op.optional_reference(attribute);
    return given ? read_direction(model, *given, id) : fallback;
  };
  const Eigen::Vector3d z = flat ? Eigen::Vector3d::UnitZ() : axis("Axis3", Eigen::Vector3d::UnitZ());
  Eigen::Vector3d x = axis("Axis1", Eigen::Vector3d::UnitX());
  x -= z * z.dot(x);
  if (x.norm() < 1e-9) op.fail("Axis1", "an axis that is not parallel to Axis3");
  x.normalize();
  Eigen::Vector3d y = z.cross(x);
  if (op.optional_reference("Axis2") && axis("Axis2", y).dot(y) < 0) y = -y;  // a mirror
  const bool non_uniform = op.keyword().ends_with("NONUNIFORM");
  const double scale = op.optional_number("Scale").value_or(1);
  Eigen::Affine3d result = Eigen::Affine3d::Identity();
  result.linear().col(0) = x * scale;
  result.linear().col(1) = y * (non_uniform ? op.optional_number("Scale2").value_or(scale) : scale);
  result.linear().col(2) = z * (non_uniform && !flat ? op.optional_number("Scale3").value_or(scale) : scale);
  result.translation() = read_point(model, op.reference("LocalOrigin"), id);
  return result;
}

/// Which representations show the element itself, best first; others (axes, foot prints, clearances) say nothing of
/// where it is.
int rank_of(const std::string& identifier) {
  if (identifier == "Body") return 0;
  for (const char* other :
       {"Axis", "FootPrint", "Profile", "Clearance", "Annotation", "Plan", "Box", "CoG", "Reference", "Lighting"})
    if (identifier == other) return identifier == "Box" ? 2 : 3;
  return 1;
}

}  // namespace

Extents::Extents(const Model& model, double radian, bool with_faces)
    : model_(model),
      radian_(radian),
      with_faces_(with_faces),
      work_left_(kWorkOfElement),
      work_left_of_file_(std::max(kWorkOfSmallFile, 4 * model.file().bytes().size())) {}

void Extents::charge(std::size_t work) const {
  if (work <= work_left_ && work <= work_left_of_file_) {
    work_left_ -= work, work_left_of_file_ -= work;
    return;
  }
  const bool file = work > work_left_of_file_;
  work_left_ = 0;
  throw UnsupportedGeometry(file ? "the shapes of this file repeat nested items more often than any building needs"
                                 : "its shape repeats nested items more than " + std::to_string(kWorkOfElement) +
                                       " times");
}

std::vector<ItemExtent> Extents::of_shape(std::uint64_t shape_id, std::uint64_t referrer) {
  work_left_ = kWorkOfElement;
  const Entity shape = model_.entity(shape_id, referrer);
  std::array<std::vector<std::uint64_t>, 3> ranked;
  for (const std::uint64_t id : shape.references("Representations")) {
    const int rank = rank_of(model_.entity(id, shape_id).text("RepresentationIdentifier"));
    if (rank < 3) ranked[rank].push_back(id);
  }
  for (const auto& representations : ranked) {
    std::vector<ItemExtent> items;
    for (const std::uint64_t id : representations)
      for (ItemExtent& item : of_representation(model_.entity(id, shape_id), 0)) items.push_back(std::move(item));
    if (!items.empty()) return items;
  }
  return {};
}

std::vector<ItemExtent> Extents::of_representation(const Entity& representation, int depth) {
  if (depth > kDeepestPlacement)
    throw UnsupportedGeometry("mapped items are nested deeper than " + std::to_string(depth));
  std::vector<ItemExtent> items;
  charge(1);
  for (const std::uint64_t id : representation.references("Items")) {
    const Entity item = model_.entity(id, representation.id());
    if (item.keyword() == "IFCSTYLEDITEM") continue;
    if (item.keyword() == "IFCMAPPEDITEM") {
      for (ItemExtent& mapped : of_mapped_item(item, depth)) items.push_back(std::move(mapped));
    } else {
      items.push_back(of_item(id, representation.id(), depth));
    }
  }
  std::erase_if(items, [](const ItemExtent& item) { return item.points.empty(); });
  return items;
}

std::vector<ItemExtent> Extents::of_mapped_item(const Entity& item, int depth) {
  const std::uint64_t source = item.reference("MappingSource");
  if (!maps_.contains(source)) {
    const Entity map = model_.entity(source, item.id());
    std::vector<ItemExtent> shown =
        of_representation(model_.entity(map.reference("MappedRepresentation"), source), depth + 1);
    // The operator acts on coordinates seen from the mapping origin.
    const Eigen::Affine3d from_origin =
        affine(read_axis_placement(model_, map.reference("MappingOrigin"), source)).inverse();
    for (ItemExtent& extent : shown) transform(extent, from_origin);
    maps_[source] = std::move(shown);
  }
  for (const ItemExtent& extent : maps_[source]) charge(1 + extent.points.size());
  std::vector<ItemExtent> items = maps_[source];
  const Eigen::Affine3d motion = read_operator(model_, item.reference("MappingTarget"), item.id());
  for (ItemExtent& extent : items) transform(extent, motion);
  return items;
}

ItemExtent Extents::of_item(std::uint64_t id, std::uint64_t referrer, int depth) {
  const Entity item = model_.entity(id, referrer);
  const std::string& kind = item.keyword();
  if (depth > kDeepestPlacement) throw UnsupportedGeometry("geometry is nested deeper than " + std::to_string(depth));
  charge(1 + item.arguments().size());
  ItemExtent extent;
  if (kind.starts_with("IFCEXTRUDEDAREASOLID")) return of_extrusion(item, depth);
  if (kind.starts_with("IFCREVOLVEDAREASOLID")) return of_revolution(item, depth);
  if (kind.starts_with("IFCSWEPTDISKSOLID")) return of_rod(item, depth);
  if (kind.starts_with("IFCFACETEDBREP") || kind.starts_with("IFCADVANCEDBREP")) {
    const Entity shell = model_.entity(item.reference("Outer"), id);
    if (!add_faces(shell.references("CfsFaces"), shell.id(), extent)) extent.faces.clear();
  } else if (kind == "IFCFACEBASEDSURFACEMODEL" || kind == "IFCSHELLBASEDSURFACEMODEL") {
    bool straight = true;
    for (const std::uint64_t shell : item.references(kind[3] == 'F' ? "FbsmFaces" : "SbsmBoundary"))
      straight = add_faces(model_.entity(shell, id).references("CfsFaces"), shell, extent) && straight;
    if (!straight) extent.faces.clear();
  } else if (kind == "IFCTRIANGULATEDFACESET" || kind == "IFCPOLYGONALFACESET" ||
             kind == "IFCTRIANGULATEDIRREGULARNETWORK") {
    const Entity list = model_.entity(item.reference("Coordinates"), id);
    charge(list.value("CoordList").items.size());
    for (const step::Value& row : list.value("CoordList").items) {
      if (row.items.size() != 3) item.fail("Coordinates", "points of three numbers");
      extent.points.emplace_back(row.items[0].number, row.items[1].number, row.items[2].number);
    }
    if (with_faces_) add_indexed_faces(item, extent);
  } else if (kind == "IFCBOOLEANRESULT" || kind == "IFCBOOLEANCLIPPINGRESULT") {
    extent = of_item(item.reference("FirstOperand"), id, depth + 1);
    if (item.value("Operator").text == "UNION") extent.faces.clear();
    if (item.value("Operator").text == "UNION")
      append(extent.points, of_item(item.reference("SecondOperand"), id, depth + 1).points);
    charge(extent.points.size());
  } else if (kind == "IFCCSGSOLID") {
    return of_item(item.reference("TreeRootExpression"), id, depth + 1);
  } else if (kind == "IFCMAPPEDITEM") {
    for (const ItemExtent& mapped : of_mapped_item(item, depth)) append(extent.points, mapped.points);
  } else if (kind == "IFCGEOMETRICSET" || kind == "IFCGEOMETRICCURVESET") {
    for (const std::uint64_t part : item.references("Elements"))
      append(extent.points, of_item(part, id, depth + 1).points);
    charge(extent.points.size());
  } else if (kind == "IFCCARTESIANPOINT") {
    extent.points.push_back(read_point(model_, id, referrer));
  } else if (kind == "IFCBLOCK" || kind == "IFCRECTANGULARPYRAMID" || kind == "IFCRIGHTCIRCULARCYLINDER" ||
             kind == "IFCRIGHTCIRCULARCONE" || kind == "IFCSPHERE" || kind == "IFCBOUNDINGBOX") {
    return of_primitive(item);
  } else {
    extent.points = of_curve(id, referrer, depth);  // knows no other kind either, and says so
  }
  return extent;
}

ItemExtent Extents::of_extrusion(const Entity& solid, int depth) const {
  ItemExtent extent;
  extent.points = of_profile(solid.reference("SweptArea"), solid.id(), depth);
  const Eigen::Vector3d path =
      read_direction(model_, solid.reference("ExtrudedDirection"), solid.id()) * solid.number("Depth");
  PointCloud top = extent.points;
  if (solid.keyword().ends_with("TAPERED")) top = of_profile(solid.reference("EndSweptArea"), solid.id(), depth);
  const Eigen::Vector3d base = middle(extent.points);
  for (Eigen::Vector3d& point : top) point += path;
  append(extent.points, top);
  if (with_faces_ && !solid.keyword().ends_with("TAPERED")) {
    const PointCloud outline = outline_of(solid.reference("SweptArea"), solid.id());
    PointCloud end = outline;
    for (Eigen::Vector3d& point : end) point += path;
    charge(8 * outline.size());
    add_strip(outline, end, extent.faces);
    if (!outline.empty()) extent.faces.push_back(outline), extent.faces.push_back(end);
  }
  extent.axis_middle = base + path / 2;
  transform(extent, affine(read_axis_placement(model_, solid.optional_reference("Position"), solid.id())));
  return extent;
}

ItemExtent Extents::of_revolution(const Entity& solid, int depth) const {
  const PointCloud profile = of_profile(solid.reference("SweptArea"), solid.id(), depth);
  const Entity axis = model_.entity(solid.reference("Axis"), solid.id());
  const Eigen::Vector3d origin = read_point(model_, axis.reference("Location"), axis.id());
  const auto given = axis.optional_reference("Axis");
  const Eigen::Vector3d direction = given ? read_direction(model_, *given, axis.id()) : Eigen::Vector3d::UnitZ();
  const double angle = solid.number("Angle") * radian_;
  ItemExtent extent;
  charge(profile.size() * kSamplesOfRevolution);
  for (int i = 0; i <= kSamplesOfRevolution; ++i) {
    const Eigen::AngleAxisd turn(angle * i / kSamplesOfRevolution, direction);
    for (const Eigen::Vector3d& point : profile) extent.points.push_back(origin + turn * (point - origin));
  }
  if (with_faces_) {
    const PointCloud outline = outline_of(solid.reference("SweptArea"), solid.id());
    charge(4 * outline.size() * kSamplesOfRevolution);
    PointCloud before;
    for (int i = 0; i <= kSamplesOfRevolution; ++i) {
      PointCloud turned = outline;
      const Eigen::AngleAxisd turn(angle * i / kSamplesOfRevolution, direction);
      for (Eigen::Vector3d& point : turned) point = origin + turn * (point - origin);
      if (i > 0) add_strip(before, turned, extent.faces);
      if ((i == 0 || i == kSamplesOfRevolution) && !turned.empty()) extent.faces.push_back(turned);
      before = std::move(turned);
    }
  }
  transform(extent, affine(read_axis_placement(model_, solid.optional_reference("Position"), solid.id())));
  return extent;
}

/// A swept disk: circles about the points of its directrix, perpendicular to it.
ItemExtent Extents::of_rod(const Entity& solid, int depth) const {
  const PointCloud directrix = of_curve(solid.reference("Directrix"), solid.id(), depth);
  const double radius = solid.number("Radius");
  ItemExtent extent;
  charge(directrix.size() * 32);
  for (std::size_t i = 0; i < directrix.size(); ++i) {
    const Eigen::Vector3d& before = directrix[i ? i - 1 : 0];
    const Eigen::Vector3d& after = directrix[std::min(i + 1, directrix.size() - 1)];
    Eigen::Vector3d tangent = after - before;
    if (!(tangent.norm() > 0)) tangent = Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d u = tangent.unitOrthogonal(), v = tangent.normalized().cross(u);
    for (int k = 0; k < 32; ++k) {
      const double angle = k * M_PI / 16;
      extent.points.push_back(directrix[i] + radius * (std::cos(angle) * u + std::sin(angle) * v));
    }
  }
  if (directrix.size() == 2) extent.axis_middle = (directrix[0] + directrix[1]) / 2;
  return extent;
}

ItemExtent Extents::of_primitive(const Entity& solid) const {
  const std::string& kind = solid.keyword();
  ItemExtent extent;
  const auto box = [&](const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
    for (const double x : {low.x(), high.x()})
      for (const double y : {low.y(), high.y()})
        for (const double z : {low.z(), high.z()}) extent.points.emplace_back(x, y, z);
  };
  if (kind == "IFCBOUNDINGBOX") {
    const Eigen::Vector3d corner = read_point(model_, solid.reference("Corner"), solid.id());
    box(corner, corner + Eigen::Vector3d(solid.number("XDim"), solid.number("YDim"), solid.number("ZDim")));
    return extent;
  }
  if (kind == "IFCBLOCK" || kind == "IFCRECTANGULARPYRAMID")
    box({0, 0, 0},
        {solid.number("XLength"), solid.number("YLength"), solid.number(kind == "IFCBLOCK" ? "ZLength" : "Height")});
  else if (kind == "IFCSPHERE") {
    const Eigen::Vector3d reach = Eigen::Vector3d::Constant(solid.number("Radius"));
    box(-reach, reach);
  } else {
    const double radius = solid.number(kind == "IFCRIGHTCIRCULARCONE" ? "BottomRadius" : "Radius"),
                 height = solid.number("Height");
    for (int k = 0; k < 32; ++k)
      for (const double z : {0.0, height})
        extent.points.emplace_back(radius * std::cos(k * M_PI / 16), radius * std::sin(k * M_PI / 16), z);
    extent.axis_middle = Eigen::Vector3d(0, 0, height / 2);
  }
  transform(extent, affine(read_axis_placement(model_, solid.optional_reference("Position"), solid.id())));
  return extent;
}

bool Extents::add_faces(const std::vector<std::uint64_t>& faces, std::uint64_t referrer, ItemExtent& extent) const {
  charge(faces.size());
  bool straight = true;
  for (const std::uint64_t face_id : faces) {
    const Entity face = model_.entity(face_id, referrer);
    bool first = true;
    for (const std::uint64_t bound_id : face.references("Bounds")) {
      const Entity bound = model_.entity(bound_id, face_id);
      const Entity loop = model_.entity(bound.reference("Bound"), bound_id);
      const auto before = static_cast<std::ptrdiff_t>(extent.points.size());
      add_loop(loop, extent.points);
      straight = straight && loop.keyword() == "IFCPOLYLOOP";
      const bool outer = bound.keyword() == "IFCFACEOUTERBOUND";
      if (!with_faces_ || !(first || outer)) continue;
      if (!first) extent.faces.pop_back();
      extent.faces.emplace_back(extent.points.begin() + before, extent.points.end());
      first = false;
    }
  }
  return straight;
}

/// Triangles or polygons by the numbers of their points, counted from 1.
void Extents::add_indexed_faces(const Entity& item, ItemExtent& extent) const {
  const auto add = [&](const std::vector<step::Value>& numbers) {
    PointCloud face;
    charge(1 + numbers.size());
    for (const step::Value& value : numbers) {
      if (!(value.number >= 1) || value.number > static_cast<double>(extent.points.size()))
        item.fail("CoordIndex", "numbers of its points");
      face.push_back(extent.points[static_cast<std::size_t>(value.number) - 1]);
    }
    extent.faces.push_back(std::move(face));
  };
  if (item.keyword() != "IFCPOLYGONALFACESET") {
    if (item.value("PnIndex").items.empty())
      for (const step::Value& triangle : item.value("CoordIndex").items) add(triangle.items);
    return;
  }
  if (!item.value("PnIndex").items.empty()) return;
  for (const std::uint64_t face : item.references("Faces"))
    add(model_.entity(face, item.id()).value("CoordIndex").items);
}

void Extents::add_loop(const Entity& loop, PointCloud& points) const {
  const auto add_vertex = [&](std::uint64_t id, std::uint64_t referrer) {
    const Entity vertex = model_.entity(id, referrer);
    points.push_back(read_point(model_, vertex.reference("VertexGeometry"), id));
  };
  charge(loop.arguments().size());
  if (loop.keyword() == "IFCPOLYLOOP") {
    charge(loop.references("Polygon").size());
    for (const std::uint64_t point : loop.references("Polygon")) points.push_back(read_point(model_, point, loop.id()));
  } else if (loop.keyword() == "IFCVERTEXLOOP") {
    add_vertex(loop.reference("LoopVertex"), loop.id());
  } else {
    for (const std::uint64_t edge_id : loop.references("EdgeList")) {
      const Entity oriented = model_.entity(edge_id, loop.id());
      const Entity edge = model_.entity(oriented.reference("EdgeElement"), edge_id);
      add_vertex(edge.reference("EdgeStart"), edge.id());
      add_vertex(edge.reference("EdgeEnd"), edge.id());
      // Between its vertices a straight edge reaches no further; a full circle or a spline does.
      const std::uint64_t curve = edge.reference("EdgeGeometry");
      if (model_.keyword(curve) != "IFCLINE") append(points, of_curve(curve, edge.id()));
    }
  }
}

}  // namespace plumbline::ifc
