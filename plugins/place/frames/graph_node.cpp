#include "place/frames/graph_node.hpp"

#include <fmt/core.h>

#include <cmath>

#include "artifacts/frame_artifact.hpp"
#include "artifacts/joint_memory.hpp"
#include "base/text/csv_table.hpp"
#include "building/ifc/georeference.hpp"

namespace plumbline::frames {
namespace {

/// Adds map_from_building by the standard's reading of the design's map conversion, unless the survey itself is in map
/// coordinates by this or another reading: then its frame is the map.
void add_map(const DesignT& design, FrameGraph& graph) {
  const DesignMapConversionT& map = *design.map_conversion;
  const auto readings = ifc::readings_of({map.eastings, map.northings, map.orthogonal_height, map.x_axis_abscissa,
                                          map.x_axis_ordinate, map.scale, map.scale_given, map.crs_name, map.map_unit},
                                         design.length_unit);
  const Eigen::Vector3d origin_in_survey = graph.links().front().apply_inverse(Eigen::Vector3d::Zero());
  for (const ifc::Reading& reading : readings)
    if ((reading.transform.translation - origin_in_survey).norm() < 1e-6) return;
  const ifc::PlanTransform& transform = readings.front().transform;
  FrameLink link;
  link.to = "map", link.from = "building";
  link.origin = "map conversion of " + design.file_name + (map.crs_name.empty() ? "" : " to " + map.crs_name) +
                ", as the standard reads it; not checked against surveyed points";
  link.to_from_from.rotation = Eigen::Quaterniond(std::cos(transform.angle / 2), 0, 0, std::sin(transform.angle / 2));
  link.to_from_from.translation = transform.translation;
  link.scale = transform.scale;
  link.plan_only = true;
  graph.add(link);
}

std::string number(double value) {
  if (!std::isfinite(value)) return "";
  return fmt::format("{:.5f}", value);
}

/// One line for each point in each frame.
std::string coordinates_csv(const FrameGraph& graph, const PointsT& points) {
  FramePoints given;
  for (const auto& point : points.points) given.positions.push_back(point->position);
  if (!points.covariance.empty())
    given.covariance = unpack_symmetric(points.covariance, 3 * points.points.size(), "input 'points'");
  std::string text = "id,frame,x,y,z,sigma_x,sigma_y,sigma_z\n";
  for (const std::string& frame : graph.frames()) {
    const FramePoints there = graph.express(given, frame, "building");
    for (std::size_t i = 0; i < there.positions.size(); ++i) {
      text += text::csv_field(points.points[i]->id) + "," + frame;
      for (int c = 0; c < 3; ++c) text += "," + number(there.positions[i](c));
      for (int c = 0; c < 3; ++c) {
        const auto row = static_cast<Eigen::Index>(3 * i) + c;
        text += "," + (there.covariance.size() > 0 ? number(std::sqrt(there.covariance(row, row))) : "");
      }
      text += "\n";
    }
  }
  return text;
}

}  // namespace

void FramesGraph::run(Context& context) {
  announce_joint(context, joint_size(points), 6);
  FrameGraph graph;
  graph.add(frame_link(survey.unpack(), "building", "survey"));
  if (registration) {
    FrameLink link = frame_link(registration.unpack(), "building", "block");
    if (link.origin.empty()) link.origin = "registration of the block to surveyed anchors";
    graph.add(link);
  }
  if (design) {
    const DesignT read = design.unpack();
    if (read.map_conversion) add_map(read, graph);
  }
  SiteFramesT out;
  for (const FrameLink& link : graph.links()) {
    auto item = std::make_unique<NamedTransformT>();
    item->to = link.to, item->from = link.from;
    item->transform = std::make_unique<TransformT>(transform_artifact(link));
    out.links.push_back(std::move(item));
  }
  FileT file;
  file.name = "frames.csv", file.media_type = "text/csv";
  const std::string text = coordinates_csv(graph, points ? points.unpack() : PointsT());
  file.content.assign(text.begin(), text.end());
  coordinates.commit(file);
  frames.commit(out);
}

}  // namespace plumbline::frames
