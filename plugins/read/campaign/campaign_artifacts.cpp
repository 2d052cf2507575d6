#include "campaign_artifacts.hpp"

#include <algorithm>
#include <cmath>

#include "artifacts/camera_artifact.hpp"
#include "base/text/whole_file.hpp"
#include "geometry/packed_symmetric.hpp"
#include "recognise_tables.hpp"
#include "survey/files/survey_format.hpp"
#include "survey/start/merge_surveys.hpp"
#include "workbook_tables.hpp"

namespace plumbline::campaign {

namespace fs = std::filesystem;

PhotographHeader header_of(const fs::path& path) {
  try {
    return read_photograph_header(path, ReadTo::end_of_file);
  } catch (const std::runtime_error& error) {
    throw CampaignError(path, 0,
                        std::string(error.what()) + "; copy it again from the camera, or leave it out by 'unused'");
  }
}

CameraT to_artifact(const CameraCalibration& c, const std::string& source) {
  CameraT camera;
  camera.id = c.id;
  camera.pixel_pitch = c.pixel_pitch;
  set_interior(c.camera, c.covariance, camera);
  camera.source = source;
  return camera;
}

PlatesT to_artifact(const std::vector<PlateEntry>& entries) {
  PlatesT plates;
  for (const PlateEntry& e : entries) {
    auto plate = std::make_unique<PlateT>();
    plate->anchor = e.anchor;
    plate->tag_family = e.tag_family;
    plate->tag_id = e.tag_id;
    plate->tag_size = e.tag_size;
    plate->tag_centre_in_plate = e.tag_centre_in_plate;
    // A plate that lies flat says nothing of where its anchor faces.
    plate->nominal_rotation =
        std::isnan(e.facing_azimuth) ? Eigen::Quaterniond::Identity() : upright_plate(e.facing_azimuth);
    plate->batch = e.batch;
    plate->role = e.role;
    plate->floor = e.floor;
    plate->column = e.column;
    plate->row = e.row;
    if (e.mounting_sigma.allFinite()) plate->mounting_sigma.assign(e.mounting_sigma.begin(), e.mounting_sigma.end());
    plates.plates.push_back(std::move(plate));
  }
  return plates;
}

Eigen::Matrix3d covariance_of(const ControlPoint& point) {
  Eigen::Matrix3d correlation = Eigen::Matrix3d::Identity();
  const int pairs[3][2] = {{0, 1}, {0, 2}, {1, 2}};
  for (int k = 0; k < 3; ++k)
    correlation(pairs[k][0], pairs[k][1]) = correlation(pairs[k][1], pairs[k][0]) = point.correlation(k);
  // A coordinate that is not known has no variance; nobody reads that of one that is nan.
  const Eigen::Vector3d sigma = point.sigma.array().isNaN().select(Eigen::Vector3d::Zero(), point.sigma);
  return sigma.asDiagonal() * correlation * sigma.asDiagonal();
}

PointsT to_artifact(const std::vector<ControlPoint>& entries) {
  PointsT points;
  const auto n = static_cast<Eigen::Index>(3 * entries.size());
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(n, n);
  for (std::size_t i = 0; i < entries.size(); ++i) {
    auto point = std::make_unique<PointT>();
    point->id = entries[i].name;
    point->position = entries[i].position;
    point->sigma = entries[i].sigma;
    point->role = "control";
    points.points.push_back(std::move(point));
    covariance.block<3, 3>(static_cast<Eigen::Index>(3 * i), static_cast<Eigen::Index>(3 * i)) =
        covariance_of(entries[i]);
  }
  points.covariance = pack_symmetric(covariance);
  return points;
}

KnownControl read_control(const CampaignDescription& description, const fs::path& root, Context& context) {
  if (description.control.empty()) return {};
  KnownControl known;
  known.points = parse_control(control_text(root / description.control), root / description.control, &known.warnings);
  for (std::string& warning : known.warnings) {
    warning = description.control + ": " + warning;
    context.warn(warning);
  }
  return known;
}

namespace {

std::string place_of(const survey::SkippedLine& skipped) {
  return skipped.source.file + ":" + std::to_string(skipped.source.line);
}

/// All of a file at once: who mends one line and runs again learns of the next one only then.
void refuse_skipped(const std::vector<survey::SkippedLine>& skipped) {
  constexpr std::size_t most = 10;
  if (skipped.empty()) return;
  std::string text;
  for (std::size_t i = 0; i < std::min(skipped.size(), most); ++i)
    text +=
        (i ? "\n" : "") + place_of(skipped[i]) + ": found " + skipped[i].found + ", expected " + skipped[i].expected;
  if (skipped.size() > most)
    text += "\n" + skipped.front().source.file + ": and " + std::to_string(skipped.size() - most) + " more of the kind";
  throw std::runtime_error(text + ". Mend the file, or go on without these readings with strict=false");
}

}  // namespace

std::vector<survey::SurveyObservations> read_survey_files(const CampaignDescription& description, const fs::path& root,
                                                          const AddedReadings& added, bool strict, Context& context) {
  std::vector<survey::SurveyObservations> parts;
  Problems problems;
  for (const std::string& path : description.survey)
    problems.attempt([&] {
      const auto read = added.find(path);
      if (read != added.end() && !read->second)
        throw std::runtime_error(path +
                                 " was offered to a reader of another plugin, and nobody has read it: connect "
                                 "survey.collect, not campaign.files_for, to 'readings'");
      parts.push_back(read != added.end() ? survey::from_artifact(*read->second)
                                          : survey::read_survey(text::read_whole(root / path),
                                                                path));  // by its own name, wherever it lies
      if (strict) refuse_skipped(parts.back().skipped);
      for (const auto& skipped : parts.back().skipped)
        context.warn(place_of(skipped) + ": passed over " + skipped.found + ", expected " + skipped.expected);
      for (const std::string& warning : parts.back().warnings) context.warn(path + ": " + warning);
    });
  problems.raise();
  for (survey::SurveyObservations& part : parts)
    if (!description.instrument.empty()) part.info.instrument = description.instrument;
  return parts;
}

/// All survey files in one. A network adjusted from part of its readings must not look like one adjusted from all.
SurveyObservationsT read_surveys(const CampaignDescription& description, const fs::path& root,
                                 const AddedReadings& added, const KnownControl& known, bool strict, Context& context) {
  if (description.survey.empty()) {  // of photographs alone: its name and date
    survey::SurveyObservations none;
    none.info.date = description.date, none.info.title = description.name;
    if (!description.date_remark.empty()) context.warn(description.date_remark);
    return survey::to_artifact(none);
  }
  std::vector<survey::SurveyObservations> parts = read_survey_files(description, root, added, strict, context);
  if (!description.date_remark.empty()) context.warn(description.date_remark);
  // What campaign.yaml says holds for all files; where it is silent, the files may differ.
  for (survey::SurveyObservations& part : parts) {
    if (!description.date.empty()) part.info.date = description.date;
    if (!description.name.empty()) part.info.title = description.name;
  }
  survey::MergeOptions options;
  for (const ControlPoint& point : known.points) options.known.push_back(point.name);
  survey::MergedSurvey merged = survey::merge_surveys(parts, options);
  auto& all = merged.survey;
  all.warnings.insert(all.warnings.end(), known.warnings.begin(), known.warnings.end());
  for (const survey::Finding& finding : merged.findings) {
    if (finding.severity == survey::Finding::Severity::note) {
      context.info(finding.text);
      continue;
    }
    all.warnings.push_back(finding.text);  // of which the network's findings, the verdict and the page tell
    context.warn(finding.text);
  }
  if (!description.instrument.empty()) all.info.instrument = description.instrument;
  if (!description.date.empty()) all.info.date = description.date;
  if (!description.name.empty()) all.info.title = description.name;
  return survey::to_artifact(all);
}

}  // namespace plumbline::campaign
