// Nodes that write survey files of other programs: each picks a writer of libraries/survey/files.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "artifacts/survey_artifact.hpp"
#include "nodes.hpp"
#include "survey/files/gama.hpp"
#include "survey/files/gsi.hpp"
#include "survey/files/landxml.hpp"
#include "survey/files/starnet.hpp"
#include "survey/files/survey_csv.hpp"

namespace plumbline::survey_files {
namespace {

constexpr double pi = std::numbers::pi;

/// The format knows no faces: a reading in face 2 becomes that of face 1. Repeated sightings stay apart.
void reduce_to_face_1(survey::Observation& observation) {
  if (observation.face != 2) return;
  if (observation.kind == survey::ObservationKind::direction)
    observation.value = std::fmod(observation.value + pi, 2 * pi);
  if (observation.kind == survey::ObservationKind::zenith_angle) observation.value = 2 * pi - observation.value;
  observation.face = 0;
}

/// Without a point that holds the network, its datum is that of a free network on the coordinates there are:
/// gama-local finds none of its own from free stations.
void let_coordinates_hold(survey::SurveyObservations& survey) {
  using survey::CoordinateRole;
  const bool held = std::any_of(survey.points.begin(), survey.points.end(), [](const survey::Point& p) {
    return std::any_of(p.roles.begin(), p.roles.end(), [](CoordinateRole role) {
      return role == CoordinateRole::fixed || role == CoordinateRole::constrained;
    });
  });
  if (held) return;
  for (survey::Point& p : survey.points)
    for (int k = 0; k < 3; ++k)
      if (p.roles[k] == CoordinateRole::free && !std::isnan(p.coordinates[k])) p.roles[k] = CoordinateRole::constrained;
}

}  // namespace

survey::SurveyObservations WriterNode::survey_to_write() const {
  survey::SurveyObservations survey = survey::from_artifact(observations.unpack());
  if (!points) return survey;
  const PointsT given = points.unpack();
  std::map<std::string, const PointT*> known;
  for (const auto& p : given.points) known[p->id] = p.get();
  for (survey::Point& p : survey.points)
    if (const auto found = known.find(p.id); found != known.end())
      for (int k = 0; k < 3; ++k)
        if (std::isnan(p.coordinates[k])) p.coordinates[k] = found->second->position[k];
  return survey;
}

void WriterNode::deliver(const std::string& name, const char* media_type, const std::string& content) const {
  FileT result;
  result.name = name;
  result.media_type = media_type;
  result.content.assign(content.begin(), content.end());
  file.commit(result);
}

void WriteGsi::run(Context&) {
  survey::GsiWriteOptions options;
  if (*station_start == "station_coordinates") options.station_start = survey::GsiStationStart::station_coordinates;
  options.distance_unit = *resolution == "1 mm" ? 0 : *resolution == "0.1 mm" ? 6 : 8;
  deliver("survey.gsi", "text/plain", survey::write_gsi(survey_to_write(), options));
}

void WriteGama::run(Context&) {
  survey::SurveyObservations prepared = survey_to_write();
  for (survey::Observation& observation : prepared.observations) {
    reduce_to_face_1(observation);
    if (!std::isnan(observation.sigma)) continue;
    const bool zenith = observation.kind == survey::ObservationKind::zenith_angle;
    const bool angular = zenith || observation.kind == survey::ObservationKind::direction ||
                         observation.kind == survey::ObservationKind::angle ||
                         observation.kind == survey::ObservationKind::azimuth;
    observation.sigma =
        angular ? (zenith ? *zenith_angle_sigma : *direction_sigma) * 1e-3 * pi / 200 : *distance_sigma * 1e-3;
  }
  if (points) let_coordinates_hold(prepared);
  deliver("survey.gkf", "application/xml", survey::write_gama_xml(prepared));
}

void WriteLandXml::run(Context&) { deliver("survey.xml", "application/xml", survey::write_landxml(survey_to_write())); }

void WriteStarNet::run(Context&) {
  survey::SurveyObservations prepared = survey_to_write();
  for (survey::Observation& observation : prepared.observations) reduce_to_face_1(observation);
  deliver("survey.dat", "text/plain", survey::write_starnet(prepared));
}

void WriteSurveyCsv::run(Context&) { deliver("survey.csv", "text/csv", survey::write_survey_csv(survey_to_write())); }

}  // namespace plumbline::survey_files
