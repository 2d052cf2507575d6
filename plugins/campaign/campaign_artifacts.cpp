#include "campaign_artifacts.hpp"

#include <algorithm>
#include <fstream>

#include "geometry/packed_symmetric.hpp"
#include "survey/model/merge_surveys.hpp"
#include "survey_files/survey_format.hpp"

namespace plumbline::campaign {

namespace fs = std::filesystem;

std::string read_text(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(stream), {}};
  if (!stream) throw CampaignError(path, 0, "the file cannot be read");
  return text;
}

CameraT to_artifact(const CameraCalibration& c, const std::string& source) {
  CameraT camera;
  camera.id = c.id;
  camera.width = c.camera.width;
  camera.height = c.camera.height;
  camera.pixel_pitch = c.pixel_pitch;
  const auto parameters = c.camera.parameters();
  camera.parameters.assign(parameters.begin(), parameters.end());
  camera.covariance = pack_symmetric(c.covariance);
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
    plate->nominal_rotation = upright_plate(e.facing_azimuth);
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

PointsT to_artifact(const std::vector<ControlPoint>& entries) {
  PointsT points;
  Eigen::VectorXd variances(static_cast<Eigen::Index>(3 * entries.size()));
  for (std::size_t i = 0; i < entries.size(); ++i) {
    auto point = std::make_unique<PointT>();
    point->id = entries[i].id;
    point->position = entries[i].position;
    point->sigma = entries[i].sigma;
    point->role = "control";
    points.points.push_back(std::move(point));
    variances.segment<3>(static_cast<Eigen::Index>(3 * i)) = entries[i].sigma.array().square();
  }
  for (Eigen::Index i = 0; i < variances.size(); ++i) {
    for (Eigen::Index j = 0; j <= i; ++j) points.covariance.push_back(i == j ? variances[i] : 0.0);
  }
  return points;
}

CampaignDescription describe(const FolderT& given, const fs::path& root, CampaignUse use) {
  std::vector<std::string> names;
  for (const auto& entry : given.files) names.push_back(entry->path);
  const fs::path yaml = root / "campaign.yaml";
  const bool there = std::find(names.begin(), names.end(), "campaign.yaml") != names.end();
  if (!there && use == CampaignUse::photographs) return find_campaign(root, names);
  if (!there)
    throw CampaignError(yaml, 0, "this file is missing; it tells what the folder holds, see docs/campaign_folder.md");
  return parse_campaign(read_text(yaml), yaml, names, use);
}

KnownControl read_control(const CampaignDescription& description, const fs::path& root, Context& context) {
  if (description.control.empty()) return {};
  KnownControl known;
  known.points = parse_control(read_text(root / description.control), root / description.control, &known.warnings);
  for (std::string& warning : known.warnings) {
    warning = description.control + ": " + warning;
    context.warn(warning);
  }
  return known;
}

/// All survey files in one. A network adjusted from part of its readings must not look like one adjusted from all.
SurveyObservationsT read_surveys(const CampaignDescription& description, const fs::path& root,
                                 const KnownControl& known, bool strict, Context& context) {
  std::vector<survey::SurveyObservations> parts;
  for (const std::string& path : description.survey) {
    parts.push_back(survey::read_survey(read_text(root / path), path));  // by its own name, wherever it lies
    for (const auto& skipped : parts.back().skipped) {
      const std::string place = skipped.source.file + ":" + std::to_string(skipped.source.line);
      if (strict)
        throw std::runtime_error(place + ": found " + skipped.found + ", expected " + skipped.expected +
                                 ". Mend the file, or go on without these readings with strict=false");
      context.warn(place + ": passed over " + skipped.found + ", expected " + skipped.expected);
    }
    for (const std::string& warning : parts.back().warnings) context.warn(path + ": " + warning);
  }
  survey::MergeOptions options;
  for (const ControlPoint& point : known.points) options.known.push_back(point.id);
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
