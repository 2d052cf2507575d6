// read.campaign: the folder of a site as artifacts. The work is in campaign_folder.hpp, image_header.hpp and
// survey_files.hpp.
#include <algorithm>
#include <fstream>
#include <map>

#include "artifacts/camera.hpp"
#include "artifacts/file_artifact.hpp"
#include "artifacts/folder.hpp"
#include "artifacts/image.hpp"
#include "artifacts/image_tags.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "artifacts/survey_artifact.hpp"
#include "campaign_folder.hpp"
#include "image_header.hpp"
#include "plumbline/node.hpp"
#include "survey/model/merge_surveys.hpp"
#include "survey_files/survey_format.hpp"

namespace {

using namespace plumbline;
namespace fs = std::filesystem;

std::string read_text(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(stream), {}};
  if (!stream) throw campaign::CampaignError(path, 0, "the file cannot be read");
  return text;
}

CameraT to_artifact(const campaign::CameraCalibration& c, const std::string& source) {
  CameraT camera;
  camera.id = c.id;
  camera.width = c.camera.width;
  camera.height = c.camera.height;
  camera.pixel_pitch = c.pixel_pitch;
  const auto parameters = c.camera.parameters();
  camera.parameters.assign(parameters.begin(), parameters.end());
  if (std::any_of(c.sigmas.begin(), c.sigmas.end(), [](double s) { return s > 0; })) {
    for (std::size_t i = 0; i < c.sigmas.size(); ++i) {
      for (std::size_t j = 0; j <= i; ++j) camera.covariance.push_back(i == j ? c.sigmas[i] * c.sigmas[i] : 0.0);
    }
  }
  camera.source = source;
  return camera;
}

PlatesT to_artifact(const std::vector<campaign::PlateEntry>& entries) {
  PlatesT plates;
  for (const campaign::PlateEntry& e : entries) {
    auto plate = std::make_unique<PlateT>();
    plate->anchor = e.anchor;
    plate->tag_family = e.tag_family;
    plate->tag_id = e.tag_id;
    plate->tag_size = e.tag_size;
    plate->tag_centre_in_plate = e.tag_centre_in_plate;
    plate->nominal_rotation = campaign::upright_plate(e.facing_azimuth);
    plate->batch = e.batch;
    plate->role = e.role;
    plate->floor = e.floor;
    plate->column = e.column;
    plate->row = e.row;
    plates.plates.push_back(std::move(plate));
  }
  return plates;
}

PointsT to_artifact(const std::vector<campaign::ControlPoint>& entries) {
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

campaign::CampaignDescription describe(const FolderT& given, const fs::path& root, bool survey_only) {
  std::vector<std::string> names;
  for (const auto& entry : given.files) names.push_back(entry->path);
  const fs::path yaml = root / "campaign.yaml";
  if (std::find(names.begin(), names.end(), "campaign.yaml") == names.end())
    throw campaign::CampaignError(yaml, 0,
                                  "this file is missing; it tells what the folder holds, see docs/campaign_folder.md");
  return campaign::parse_campaign(read_text(yaml), yaml, names, survey_only);
}

std::vector<campaign::ControlPoint> read_control(const campaign::CampaignDescription& description, const fs::path& root,
                                                 Context& context) {
  if (description.control.empty()) return {};
  std::vector<std::string> warnings;
  auto points = campaign::parse_control(read_text(root / description.control), root / description.control, &warnings);
  for (const std::string& warning : warnings) context.warn(description.control + ": " + warning);
  return points;
}

/// All survey files in one. A network adjusted from part of its readings must not look like one adjusted from all.
SurveyObservationsT read_surveys(const campaign::CampaignDescription& description, const fs::path& root,
                                 const std::vector<campaign::ControlPoint>& known, bool strict, Context& context) {
  std::vector<plumbline::survey::SurveyObservations> parts;
  for (const std::string& path : description.survey) {
    parts.push_back(plumbline::survey::read_survey(read_text(root / path), path));  // by its own name, wherever it lies
    for (const auto& skipped : parts.back().skipped) {
      const std::string place = skipped.source.file + ":" + std::to_string(skipped.source.line);
      if (strict)
        throw std::runtime_error(place + ": found " + skipped.found + ", expected " + skipped.expected +
                                 ". Mend the file, or go on without these readings with strict=false");
      context.warn(place + ": passed over " + skipped.found + ", expected " + skipped.expected);
    }
    for (const std::string& warning : parts.back().warnings) context.warn(path + ": " + warning);
  }
  plumbline::survey::MergeOptions options;
  for (const campaign::ControlPoint& point : known) options.known.push_back(point.id);
  plumbline::survey::MergedSurvey merged = plumbline::survey::merge_surveys(parts, options);
  auto& all = merged.survey;
  for (const plumbline::survey::Finding& finding : merged.findings) {
    all.warnings.push_back(finding.text);
    if (finding.severity == plumbline::survey::Finding::Severity::note)
      context.info(finding.text);
    else
      context.warn(finding.text);
  }
  if (!description.instrument.empty()) all.info.instrument = description.instrument;
  if (!description.date.empty()) all.info.date = description.date;
  if (!description.name.empty()) all.info.title = description.name;
  return plumbline::survey::to_artifact(all);
}

struct ReadCampaign : Node {
  static constexpr Info info{"read.campaign", "", 5, "Reads the folder of a site: campaign.yaml and what it names"};
  In<Folder> folder{"folder", "a folder with a campaign.yaml; see docs/campaign_folder.md"};
  OutList<Image> images{"images", "the photographs, by reference, ordered by path"};
  OutList<ImageTags> observations{"observations", "tags that were measured already, where campaign.yaml names a table"};
  Out<Camera> camera{"camera", "the calibration, with the uncertainty its file states"};
  Out<Plates> plates{"plates", frame("frame=building"), "which tag stands for which anchor"};
  Out<SurveyObservations> survey{"survey", frame("frame=building"),
                                 "all survey files in one; the datum is in `control`"};
  Out<Points> control{"control", frame("frame=building"), "the control points as given"};
  Param<bool> strict{"strict", true,
                     "refuse survey files of which anything has to be skipped; otherwise it is a warning"};
  Out<File> design_file{"design_file", "the design IFC as it is"};
  Out<File> mapping{"mapping", "the mapping table from points to elements of the design; empty without one"};

  void run(Context& context) override {
    const FolderT given = folder.unpack();
    const fs::path root = context.resolve(given.uri);
    std::map<std::string, const FolderEntryT*> entries;
    for (const auto& entry : given.files) entries[entry->path] = entry.get();
    const auto description = describe(given, root, false);

    const auto calibration = campaign::parse_camera(read_text(root / description.camera), root / description.camera);
    camera.commit(to_artifact(calibration, description.camera));
    plates.commit(to_artifact(campaign::parse_plates(read_text(root / description.plates), root / description.plates)));
    const auto known = read_control(description, root, context);
    control.commit(to_artifact(known));
    survey.commit(read_surveys(description, root, known, *strict, context));
    for (const std::string& path : description.images) commit_image(*entries.at(path), root, calibration);
    if (!description.observations.empty()) {
      const fs::path table = root / description.observations;
      commit_observations(campaign::parse_observations(read_text(table), table, calibration.camera), calibration);
    }

    FileT table;
    table.name = description.mapping.empty() ? "mapping.csv" : fs::path(description.mapping).filename().string();
    if (!description.mapping.empty()) {
      const std::string rows = read_text(root / description.mapping);
      table.media_type = "text/csv";
      table.content.assign(rows.begin(), rows.end());
    }
    mapping.commit(table);

    design_file.commit(file_artifact(root / description.design, "application/x-step"));
  }

 private:
  void commit_observations(const std::vector<campaign::ObservedTag>& tags,
                           const campaign::CameraCalibration& calibration) {
    for (std::size_t first = 0, last = 0; first < tags.size(); first = last) {
      ImageTagsT image;
      image.path = tags[first].image;
      image.camera = calibration.id;
      image.width = calibration.camera.width;
      image.height = calibration.camera.height;
      for (; last < tags.size() && tags[last].image == image.path; ++last) {
        auto tag = std::make_unique<TagT>();
        tag->family = tags[last].family;
        tag->id = tags[last].id;
        tag->corners.assign(tags[last].corners.begin(), tags[last].corners.end());
        tag->refined = true;
        const double variance = tags[last].sigma * tags[last].sigma;
        for (int corner = 0; corner < 4; ++corner)
          for (const double value : {variance, 0.0, variance}) tag->corner_covariances.push_back(value);
        image.tags.push_back(std::move(tag));
      }
      observations.commit(image);
    }
  }

  void commit_image(const FolderEntryT& entry, const fs::path& root, const campaign::CameraCalibration& calibration) {
    const campaign::ImageHeader header = campaign::read_image_header(root / entry.path);
    if (header.width != calibration.camera.width || header.height != calibration.camera.height) {
      throw campaign::CampaignError(root / entry.path, 0,
                                    "the image has " + std::to_string(header.width) + " x " +
                                        std::to_string(header.height) + " pixels, camera '" + calibration.id +
                                        "' was calibrated with " + std::to_string(calibration.camera.width) + " x " +
                                        std::to_string(calibration.camera.height) +
                                        "; images must be as the camera wrote them, not rotated or scaled");
    }
    ImageT image;
    image.path = entry.path;
    // By content: a folder that is moved, or made again, leaves all that follows as it is.
    image.uri = "sha256:" + entry.sha256 + "/" + fs::path(entry.path).filename().string();
    image.sha256 = entry.sha256;
    image.size = entry.size;
    image.width = header.width;
    image.height = header.height;
    image.camera = calibration.id;
    image.model = header.make + (header.make.empty() || header.model.empty() ? "" : " ") + header.model;
    image.focal_length = header.focal_length;
    image.taken_at = header.taken_at;
    images.commit(image);
  }
};

struct ReadSurveyCampaign : Node {
  static constexpr Info info{"read.survey_campaign", "", 1,
                             "Reads the survey files and control points that a campaign.yaml names, and nothing else"};
  In<Folder> folder{"folder", "a folder with a campaign.yaml; images, camera, plates and design may be left out"};
  Out<SurveyObservations> survey{"survey", frame("frame=building"),
                                 "all survey files in one; the datum is in `control`"};
  Out<Points> control{"control", frame("frame=building"), "the control points as given"};
  Param<bool> strict{"strict", true,
                     "refuse survey files of which anything has to be skipped; otherwise it is a warning"};

  void run(Context& context) override {
    const FolderT given = folder.unpack();
    const fs::path root = context.resolve(given.uri);
    const auto description = describe(given, root, true);
    const auto known = read_control(description, root, context);
    control.commit(to_artifact(known));
    survey.commit(read_surveys(description, root, known, *strict, context));
  }
};

/// Only an evaluation may be fed from this.
struct ReadTruth : Node {
  static constexpr Info info{"read.truth", "", 1, "Reads the truth beside a simulated campaign; for evaluation only"};
  In<Folder> truth{"truth", "the folder `truth` of simulate.campaign"};
  Out<Points> points{"points", frame("frame=building"), "where the anchors really are; sigma 0"};

  void run(Context& context) override {
    const fs::path path = fs::path(context.resolve(std::string(truth->uri()->string_view()))) / "anchors.csv";
    PointsT result;
    for (const campaign::TrueAnchor& anchor : campaign::parse_true_anchors(read_text(path), path)) {
      auto point = std::make_unique<PointT>();
      point->id = anchor.id;
      point->position = anchor.position;
      point->sigma.setZero();
      point->role = anchor.role;
      result.points.push_back(std::move(point));
    }
    points.commit(result);
  }
};

}  // namespace

PLUMBLINE_PLUGIN("campaign", "0.1.0", "MIT", ReadCampaign, ReadSurveyCampaign, ReadTruth)
