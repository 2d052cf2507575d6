// Extents of curves and of profiles.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "building/ifc/ifc_extent.hpp"

namespace plumbline::ifc {
namespace {

constexpr int kSamplesOfCircle = 32;
constexpr int kDeepestNesting = 64;

[[noreturn]] void unsupported(const Entity& entity) {
  throw UnsupportedGeometry("geometry of kind " + entity.keyword() + " is not read");
}

void add_rectangle(PointCloud& points, double half_width, double half_height) {
  for (const double x : {-half_width, half_width})
    for (const double y : {-half_height, half_height}) points.emplace_back(x, y, 0);
}

/// Arc of an ellipse with the given half axes about the origin.
void add_arc(PointCloud& points, double a, double b, double from, double to) {
  for (int i = 0; i <= kSamplesOfCircle; ++i) {
    const double angle = from + (to - from) * i / kSamplesOfCircle;
    points.emplace_back(a * std::cos(angle), b * std::sin(angle), 0);
  }
}

void transform(PointCloud& points, const RigidTransform& motion) {
  for (Eigen::Vector3d& point : points) point = motion * point;
}

/// The arc through three points (by value: they may lie in `points`), sampled; the points alone if they lie on a line.
void add_arc_through(PointCloud& points, Eigen::Vector3d a, Eigen::Vector3d b, Eigen::Vector3d c) {
  const Eigen::Vector3d u = b - a, v = c - a, normal = u.cross(v);
  points.insert(points.end(), {a, b, c});
  if (normal.norm() <= 1e-9 * u.norm() * v.norm()) return;
  const Eigen::Vector3d to_centre = u.squaredNorm() * v.cross(normal) + v.squaredNorm() * normal.cross(u);
  const Eigen::Vector3d centre = a + to_centre / (2 * normal.squaredNorm());
  const Eigen::Vector3d x = a - centre, y = normal.normalized().cross(x);
  double end = std::atan2((c - centre).dot(y), (c - centre).dot(x));
  if (end <= 0) end += 2 * std::numbers::pi;  // the normal is chosen such that b lies ahead of a, and c ahead of b
  for (int i = 1; i < kSamplesOfCircle; ++i) {
    const double angle = end * i / kSamplesOfCircle;
    points.push_back(centre + std::cos(angle) * x + std::sin(angle) * y);
  }
}

/// The same in the order of the arc.
PointCloud arc_through(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  PointCloud sampled;
  add_arc_through(sampled, a, b, c);  // the three points, then those between their ends
  PointCloud arc = {a};
  arc.insert(arc.end(), sampled.begin() + 3, sampled.end());
  if (arc.size() == 1) arc.push_back(b);
  arc.push_back(c);
  return arc;
}

PointCloud read_point_list(const Model& model, std::uint64_t id, std::uint64_t referrer) {
  const Entity list = model.entity(id, referrer);
  PointCloud points;
  for (const step::Value& row : list.value("CoordList").items) {
    if (row.items.size() < 2 || row.items.size() > 3) list.fail("CoordList", "rows of two or three numbers");
    points.emplace_back(row.items[0].number, row.items[1].number, row.items.size() == 3 ? row.items[2].number : 0);
  }
  return points;
}

PointCloud indexed_curve(const Model& model, const Entity& curve) {
  PointCloud points = read_point_list(model, curve.reference("Points"), curve.id());
  const std::size_t count = points.size();
  for (const step::Value& segment : curve.value("Segments").items) {
    if (segment.text != "IFCARCINDEX" || segment.items.empty() || segment.items[0].items.size() != 3) continue;
    std::size_t index[3];
    for (std::size_t i = 0; i < 3; ++i) {
      const double number = segment.items[0].items[i].number;
      if (!(number >= 1) || number > static_cast<double>(count)) curve.fail("Segments", "indices of its points");
      index[i] = static_cast<std::size_t>(number) - 1;
    }
    add_arc_through(points, points[index[0]], points[index[1]], points[index[2]]);
  }
  return points;
}

/// Its points in their order, arcs sampled.
PointCloud outline_by_index(const Model& model, const Entity& curve) {
  const PointCloud points = read_point_list(model, curve.reference("Points"), curve.id());
  if (curve.value("Segments").items.empty()) return points;
  PointCloud outline;
  for (const step::Value& segment : curve.value("Segments").items) {
    if (segment.items.empty()) curve.fail("Segments", "lists of indices of its points");
    PointCloud part;
    for (const step::Value& number : segment.items[0].items) {
      if (!(number.number >= 1) || number.number > static_cast<double>(points.size()))
        curve.fail("Segments", "indices of its points");
      part.push_back(points[static_cast<std::size_t>(number.number) - 1]);
    }
    if (segment.text == "IFCARCINDEX" && part.size() == 3) part = arc_through(part[0], part[1], part[2]);
    outline.insert(outline.end(), part.begin(), part.end());
  }
  return outline;
}

/// Parameter of a trim that is given as a number; nothing if it is given as a point.
std::optional<double> trim_parameter(const Entity& curve, const char* attribute) {
  for (const step::Value& trim : curve.value(attribute).items)
    if (trim.kind == step::Kind::typed && !trim.items.empty() && trim.items[0].is_number()) return trim.items[0].number;
  return {};
}

std::optional<Eigen::Vector3d> trim_point(const Model& model, const Entity& curve, const char* attribute) {
  for (const step::Value& trim : curve.value(attribute).items)
    if (trim.kind == step::Kind::reference) return read_point(model, trim.id, curve.id());
  return {};
}

/// Of a conic: the angle of a trim, from its parameter or its point.
double trim_angle(const Model& model, const Entity& curve, const char* attribute, const RigidTransform& position,
                  double a, double b, double radian) {
  if (const auto parameter = trim_parameter(curve, attribute)) return *parameter * radian;
  const auto point = trim_point(model, curve, attribute);
  if (!point) curve.fail(attribute, "a parameter or a point");
  const Eigen::Vector3d local = position.inverse() * *point;
  return std::atan2(local.y() / b, local.x() / a);
}

PointCloud trimmed_curve(const Model& model, const Entity& curve, double radian) {
  const Entity basis = model.entity(curve.reference("BasisCurve"), curve.id());
  PointCloud points;
  if (basis.keyword() == "IFCLINE") {
    const Entity vector = model.entity(basis.reference("Dir"), basis.id());
    const Eigen::Vector3d start = read_point(model, basis.reference("Pnt"), basis.id());
    const Eigen::Vector3d step =
        read_direction(model, vector.reference("Orientation"), vector.id()) * vector.number("Magnitude");
    for (const char* attribute : {"Trim1", "Trim2"}) {
      if (const auto parameter = trim_parameter(curve, attribute))
        points.push_back(start + *parameter * step);
      else if (const auto point = trim_point(model, curve, attribute))
        points.push_back(*point);
    }
    return points;
  }
  if (basis.keyword() != "IFCCIRCLE" && basis.keyword() != "IFCELLIPSE") unsupported(basis);
  const bool circle = basis.keyword() == "IFCCIRCLE";
  const double a = basis.number(circle ? "Radius" : "SemiAxis1"), b = basis.number(circle ? "Radius" : "SemiAxis2");
  const RigidTransform position = read_axis_placement(model, basis.reference("Position"), basis.id());
  double from = trim_angle(model, curve, "Trim1", position, a, b, radian);
  double to = trim_angle(model, curve, "Trim2", position, a, b, radian);
  if (curve.value("SenseAgreement").text == "F") std::swap(from, to);
  if (!std::isfinite(from) || !std::isfinite(to)) curve.fail("Trim1", "finite angles");
  // Once round, and what a rounded parameter has beyond it, is all of the circle and not the rest of a division.
  constexpr double turn = 2 * std::numbers::pi;
  to = from + (to - from >= turn ? turn : std::remainder(to - from, turn));
  if (to <= from) to += turn;
  add_arc(points, a, b, from, to);
  transform(points, position);
  return points;
}

}  // namespace

PointCloud Extents::of_curve(std::uint64_t id, std::uint64_t referrer, int depth) const {
  const Entity curve = model_.entity(id, referrer);
  const std::string& kind = curve.keyword();
  if (depth > kDeepestNesting) throw UnsupportedGeometry("geometry is nested deeper than " + std::to_string(depth));
  charge(1);
  PointCloud points;
  if (kind == "IFCPOLYLINE" || kind == "IFCBSPLINECURVEWITHKNOTS" || kind == "IFCRATIONALBSPLINECURVEWITHKNOTS") {
    for (const std::uint64_t point : curve.references(kind == "IFCPOLYLINE" ? "Points" : "ControlPointsList"))
      points.push_back(read_point(model_, point, id));
  } else if (kind == "IFCCIRCLE" || kind == "IFCELLIPSE") {
    const bool circle = kind == "IFCCIRCLE";
    add_arc(points, curve.number(circle ? "Radius" : "SemiAxis1"), curve.number(circle ? "Radius" : "SemiAxis2"), 0,
            2 * std::numbers::pi);
    transform(points, read_axis_placement(model_, curve.reference("Position"), id));
  } else if (kind == "IFCTRIMMEDCURVE") {
    points = trimmed_curve(model_, curve, radian_);
  } else if (kind == "IFCINDEXEDPOLYCURVE") {
    points = indexed_curve(model_, curve);
  } else if (kind == "IFCCOMPOSITECURVE") {
    for (const std::uint64_t segment_id : curve.references("Segments")) {
      const Entity segment = model_.entity(segment_id, id);
      if (segment.keyword() != "IFCCOMPOSITECURVESEGMENT") unsupported(segment);
      const PointCloud part = of_curve(segment.reference("ParentCurve"), segment_id, depth + 1);
      points.insert(points.end(), part.begin(), part.end());
    }
  } else {
    unsupported(curve);
  }
  charge(points.size());
  return points;
}

PointCloud Extents::of_profile(std::uint64_t id, std::uint64_t referrer, int depth) const {
  const Entity profile = model_.entity(id, referrer);
  const std::string& kind = profile.keyword();
  if (depth > kDeepestNesting) throw UnsupportedGeometry("profiles are nested deeper than " + std::to_string(depth));
  charge(1);
  PointCloud points;
  if (kind == "IFCARBITRARYCLOSEDPROFILEDEF" || kind == "IFCARBITRARYPROFILEDEFWITHVOIDS")
    return of_curve(profile.reference("OuterCurve"), id);
  if (kind == "IFCCOMPOSITEPROFILEDEF") {
    for (const std::uint64_t part_id : profile.references("Profiles")) {
      const PointCloud part = of_profile(part_id, id, depth + 1);
      points.insert(points.end(), part.begin(), part.end());
      charge(part.size());
    }
    return points;
  }
  const auto box = [&](const char* width, const char* height) {
    add_rectangle(points, profile.number(width) / 2, profile.number(height) / 2);
  };
  if (kind.find("RECTANGLE") != std::string::npos)
    box("XDim", "YDim");
  else if (kind.starts_with("IFCCIRCLE"))
    add_arc(points, profile.number("Radius"), profile.number("Radius"), 0, 2 * std::numbers::pi);
  else if (kind == "IFCELLIPSEPROFILEDEF")
    add_arc(points, profile.number("SemiAxis1"), profile.number("SemiAxis2"), 0, 2 * std::numbers::pi);
  else if (kind == "IFCISHAPEPROFILEDEF")
    box("OverallWidth", "OverallDepth");
  else if (kind == "IFCTSHAPEPROFILEDEF" || kind == "IFCUSHAPEPROFILEDEF")
    box("FlangeWidth", "Depth");
  else if (kind == "IFCCSHAPEPROFILEDEF")
    box("Width", "Depth");
  else if (kind == "IFCLSHAPEPROFILEDEF")
    add_rectangle(points, profile.optional_number("Width").value_or(profile.number("Depth")) / 2,
                  profile.number("Depth") / 2);
  else if (kind == "IFCZSHAPEPROFILEDEF")
    add_rectangle(points, profile.number("FlangeWidth") - profile.number("WebThickness") / 2,
                  profile.number("Depth") / 2);
  else if (kind == "IFCTRAPEZIUMPROFILEDEF") {
    const double left = -profile.number("BottomXDim") / 2, y = profile.number("YDim") / 2;
    const double top = left + profile.number("TopXOffset");
    points = {{left, -y, 0}, {-left, -y, 0}, {top, y, 0}, {top + profile.number("TopXDim"), y, 0}};
  } else {
    unsupported(profile);
  }
  transform(points, read_axis_placement(model_, profile.optional_reference("Position"), id));
  return points;
}

PointCloud Extents::outline_of(std::uint64_t id, std::uint64_t referrer) const {
  const Entity profile = model_.entity(id, referrer);
  if (profile.keyword() == "IFCRECTANGLEPROFILEDEF") {
    PointCloud corners = of_profile(id, referrer);
    std::swap(corners[2], corners[3]);
    return corners;
  }
  if (!profile.keyword().starts_with("IFCARBITRARYCLOSEDPROFILEDEF") &&
      profile.keyword() != "IFCARBITRARYPROFILEDEFWITHVOIDS")
    return {};
  const Entity curve = model_.entity(profile.reference("OuterCurve"), id);
  PointCloud outline;
  if (curve.keyword() == "IFCPOLYLINE")
    outline = of_curve(curve.id(), id);
  else if (curve.keyword() == "IFCINDEXEDPOLYCURVE")
    outline = outline_by_index(model_, curve);
  else if (curve.keyword() == "IFCCOMPOSITECURVE")
    for (const std::uint64_t segment_id : curve.references("Segments")) {
      const Entity segment = model_.entity(segment_id, curve.id());
      PointCloud part = of_curve(segment.reference("ParentCurve"), segment_id);
      if (segment.value("SameSense").text == "F") std::reverse(part.begin(), part.end());
      outline.insert(outline.end(), part.begin(), part.end());
    }
  charge(outline.size());
  return outline;
}

}  // namespace plumbline::ifc
