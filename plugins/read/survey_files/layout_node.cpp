#include "layout_node.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <string_view>

#include "artifacts/survey_artifact.hpp"
#include "survey/files/survey_layout.hpp"

namespace plumbline::survey_files {

namespace {

/// frame_from_plate of an upright plate: y up, z out of it; nan if nobody knows where it faces.
Eigen::Quaterniond upright(double azimuth) {
  if (std::isnan(azimuth)) return Eigen::Quaterniond(azimuth, azimuth, azimuth, azimuth);
  const Eigen::Vector3d normal(std::sin(azimuth), std::cos(azimuth), 0);
  Eigen::Matrix3d axes;
  axes << Eigen::Vector3d::UnitZ().cross(normal), Eigen::Vector3d::UnitZ(), normal;
  return Eigen::Quaterniond(axes);
}

survey::SurveyObservations set_ups_of(const survey::SiteLayout& layout, const std::string& file) {
  survey::SurveyObservations s;
  s.info.format = "layout";
  s.files = {file};
  for (const survey::LayoutSetUp& set_up : layout.set_ups) {
    survey::Point point;
    point.id = set_up.id;
    point.coordinates = set_up.position;
    s.points.push_back(point);
    s.set_ups.push_back({set_up.id, set_up.id, survey::kNotGiven, {}});
    for (const std::string& marker : set_up.sees) {
      survey::Observation sight;
      sight.set_up = static_cast<int>(s.set_ups.size() - 1);
      sight.from = set_up.id;
      sight.to = marker;
      s.observations.push_back(std::move(sight));
    }
  }
  return s;
}

}  // namespace

void ReadLayout::run(Context& context) {
  const auto* content = file->content();
  const std::string name = file->name()->str();
  const survey::SiteLayout layout =
      survey::read_survey_layout({reinterpret_cast<const char*>(content->data()), content->size()}, name);
  PointsT points;
  PlatesT all;
  for (const survey::LayoutMarker& m : layout.markers) {
    auto point = std::make_unique<PointT>();
    point->id = m.id;
    point->position = m.position;
    point->sigma.setConstant(std::nan(""));
    points.points.push_back(std::move(point));
    auto plate = std::make_unique<PlateT>();
    plate->anchor = m.id;
    plate->tag_centre_in_plate.setZero();
    plate->nominal_rotation = upright(m.facing_azimuth);
    plate->floor = m.floor;
    plate->column = m.column;
    all.plates.push_back(std::move(plate));
  }
  context.info(std::to_string(layout.markers.size()) + " markers, " + std::to_string(layout.set_ups.size()) +
               " set-ups");
  markers.commit(points);
  plates.commit(all);
  set_ups.commit(survey::to_artifact(set_ups_of(layout, name)));
}

}  // namespace plumbline::survey_files
