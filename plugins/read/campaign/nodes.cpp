// read.campaign: the folder of a site as artifacts. The work is in campaign_folder.hpp and campaign_artifacts.hpp.
#include <optional>

#include "artifacts/file_artifact.hpp"
#include "artifacts/image.hpp"
#include "artifacts/image_tags.hpp"
#include "artifacts/input_files_text.hpp"
#include "artifacts/poses.hpp"
#include "base/text/whole_file.hpp"
#include "beside_mistakes.hpp"
#include "building/ifc/mapping_table.hpp"
#include "building/judgement/tolerance_classes.hpp"
#include "campaign_cameras.hpp"
#include "listed_campaign.hpp"
#include "photo/images/photograph_header.hpp"
#include "photo_campaign_node.hpp"
#include "propose_node.hpp"
#include "reader_files_node.hpp"
#include "recognise_tables.hpp"
#include "whole_design.hpp"
#include "workbook_tables.hpp"

namespace {

using namespace plumbline;
namespace fs = std::filesystem;

std::vector<campaign::PlateEntry> read_plates(const fs::path& path, Context& context,
                                              campaign::CampaignUse use = campaign::CampaignUse::site) {
  std::vector<std::string> warnings;
  const std::string table = campaign::table_text(path, campaign::is_table_of_plates, "a table of plates");
  auto entries = campaign::parse_plates(table, path, use, &warnings);
  for (const std::string& warning : warnings) context.warn(warning);
  return entries;
}

/// Likewise of tolerance_file(): what is wrong with it is told with all else that is wrong with the folder.
FileT mapping_file(campaign::ListedCampaign& site) {
  FileT table;
  table.name = "mapping.csv";
  if (site.description.mapping.empty()) return table;
  table.name = fs::path(site.description.mapping).filename().string();
  site.problems.attempt([&] {
    const fs::path path = site.root / site.description.mapping;
    const std::string rows = campaign::table_text(path, campaign::is_table_of_names, "a table of points and elements");
    ifc::parse_mapping(rows, path.string());
    table.media_type = "text/csv";
    table.content.assign(rows.begin(), rows.end());
  });
  return table;
}

FileT tolerance_file(campaign::ListedCampaign& site) {
  FileT table;
  table.name = "tolerances.csv";
  if (site.description.tolerances.empty()) return table;
  table.name = fs::path(site.description.tolerances).filename().string();
  site.problems.attempt([&] {
    const fs::path path = site.root / site.description.tolerances;
    const std::string rows =
        campaign::table_text(path, judgement::is_table_of_tolerances, "a table of tolerance classes");
    judgement::parse_tolerance_classes(rows, path.string());
    table.media_type = "text/csv";
    table.content.assign(rows.begin(), rows.end());
  });
  return table;
}

/// By reference, like the photographs: a design may have hundreds of megabytes.
FileT design_reference(const campaign::ListedCampaign& site) {
  const FolderEntryT& design = site.entry(site.description.design);
  const std::string name = fs::path(design.path).filename().string();
  return file_reference(name, "application/x-step", "sha256:" + design.sha256 + "/" + name, design.sha256);
}

struct ReadCampaign : Node {
  static constexpr Info info{"read.campaign", "", 12, "Reads the folder of a site: campaign.yaml and what it names"};
  In<Folder> folder{"folder", "a folder with a campaign.yaml; see docs/campaign_folder.md"};
  Optional<SurveyReadings> added{"readings", frame("frame=building"),
                                 "survey files that readers of other plugins have read: parts/readers.yaml"};
  OutList<Image> images{"images", "the photographs, by reference, ordered by path"};
  OutList<ImageTags> observations{"observations", "tags that were measured already, where campaign.yaml names a table"};
  Out<Camera> camera{"camera", "the calibration, or all of several, with the uncertainty its file states"};
  Out<Plates> plates{"plates", frame("frame=building"), "which tag stands for which anchor"};
  Out<SurveyObservations> survey{"survey", frame("frame=building"),
                                 "all survey files in one; the datum is in `control`"};
  Out<Points> control{"control", frame("frame=building"), "the control points as given"};
  Param<bool> strict{"strict", true,
                     "refuse survey files of which anything has to be skipped; otherwise it is a warning"};
  Param<std::string> takes{"takes", "any", one_of("any", "photographs", "observations"),
                           "refuse a folder that has the other at once: what comes after it could only say that "
                           "there are no images"};
  Param<bool> alone{"alone", false, "of photographs alone: refuse a folder with survey files or control points"};
  Param<std::vector<std::string>> families{"families", std::vector<std::string>{},
                                           "of a check, tags that the run looks for: beside other mistakes those are "
                                           "told of which campaign.account would tell next; none: they are not"};
  Out<File> design_file{"design_file", "the design IFC as it is, by reference"};
  Out<File> mapping{"mapping", "the mapping table from points to elements of the design; empty without one"};
  Out<File> tolerances{"tolerances", "the project's table of tolerance classes; empty without one"};
  Out<InputFiles> inputs{"inputs", "the files that were read, and evidence that `unused` sets aside"};
  Out<InputFiles> unread{"unread", "what else lies in the folder"};

  void run(Context& context) override {
    const campaign::CampaignUse use = *alone ? campaign::CampaignUse::alone : campaign::CampaignUse::site;
    campaign::ListedCampaign site(folder.unpack(), context.resolve(std::string(folder->uri()->string_view())), use,
                                  campaign::given_by(added));
    const campaign::CampaignDescription& description = site.description;
    const fs::path& root = site.root;
    const auto attempt = [&](bool there, const auto& action) {
      if (there) site.problems.attempt(action);
    };
    attempt(*takes != "any", [&] { require_what_is_taken(description); });

    std::optional<campaign::CampaignCameras> cameras;
    std::vector<campaign::PlateEntry> entries;
    campaign::KnownControl known;
    SurveyObservationsT readings;
    std::vector<ImageT> photographs;
    std::vector<campaign::ObservedTag> tags;
    attempt(!description.cameras.empty(), [&] { cameras.emplace(description, root); });
    attempt(!description.plates.empty(), [&] { entries = read_plates(root / description.plates, context, use); });
    attempt(true, [&] { known = campaign::read_control(description, root, context); });
    attempt(!description.survey.empty() || *alone,
            [&] { readings = campaign::read_surveys(description, root, site.added, known, *strict, context); });
    for (const std::string& path : description.images)
      attempt(true, [&] {
        if (cameras)
          photographs.push_back(image_of(site.entry(path), root, cameras->of(path)));
        else
          campaign::header_of(root / path);  // whether it is whole does not wait for its camera
      });
    attempt(cameras && !description.observations.empty(), [&] {
      const fs::path table = root / description.observations;
      const auto camera_of = [&](const std::string& image) -> const BrownCamera& { return cameras->of(image).camera; };
      tags = campaign::parse_observations(
          campaign::table_text(table, campaign::is_table_of_tags, "a table of measured tags"), table, camera_of);
    });
    const FileT table = mapping_file(site), classes = tolerance_file(site);
    campaign::look_at_design(site);
    if (!families->empty())
      campaign::look_at_what_belongs_together(site, campaign::to_artifact(entries), known.points, readings, *families,
                                              context);
    site.warn_of_what_is_left(context);
    site.problems.raise();

    camera.commit(cameras->artifact());
    plates.commit(campaign::to_artifact(entries));
    control.commit(campaign::to_artifact(known.points));
    survey.commit(readings);
    for (const ImageT& image : photographs) images.commit(image);
    const std::size_t observed = commit_observations(tags, *cameras);
    mapping.commit(table);
    tolerances.commit(classes);
    design_file.commit(design_reference(site));
    inputs.commit(site.inputs(context, photographs.empty() ? observed : photographs.size(), readings_of(readings)));
    unread.commit(site.unread());
  }

 private:
  void require_what_is_taken(const campaign::CampaignDescription& description) const {
    if (*takes == "observations" && description.observations.empty() && !description.images.empty())
      throw BadInput(
          "campaign.yaml names photographs, and no table of tags that were measured already ('observations'), which "
          "this pipeline is for; photographs: plumbline run site_campaign folder=FOLDER");
    if (*takes == "photographs" && description.images.empty() && !description.observations.empty())
      throw BadInput(
          "campaign.yaml names tags that were measured already ('observations'), and no photographs, which this "
          "pipeline is for; measured tags: plumbline run site_observations folder=FOLDER");
  }

  /// Returns the number of images.
  std::size_t commit_observations(const std::vector<campaign::ObservedTag>& tags,
                                  const campaign::CampaignCameras& cameras) {
    std::size_t count = 0;
    for (std::size_t first = 0, last = 0; first < tags.size(); first = last, ++count) {
      ImageTagsT image;
      image.path = tags[first].image;
      const campaign::CameraCalibration& calibration = cameras.of(image.path);
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
    return count;
  }

  static ImageT image_of(const FolderEntryT& entry, const fs::path& root,
                         const campaign::CameraCalibration& calibration) {
    const PhotographHeader header = campaign::header_of(root / entry.path);
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
    image.model = header.model;
    image.focal_length = header.focal_length;
    image.taken_at = header.taken_at;
    return image;
  }
};

struct ReadSurveyCampaign : Node {
  static constexpr Info info{"read.survey_campaign", "", 4,
                             "Reads the survey files and control points that a campaign.yaml names, and nothing else"};
  In<Folder> folder{"folder", "a folder with a campaign.yaml; images, camera, plates and design may be left out"};
  Optional<SurveyReadings> added{"readings", frame("frame=building"),
                                 "survey files that readers of other plugins have read: parts/readers.yaml"};
  Out<SurveyObservations> survey{"survey", frame("frame=building"),
                                 "all survey files in one; the datum is in `control`"};
  Out<Points> control{"control", frame("frame=building"), "the control points as given"};
  Param<bool> strict{"strict", true,
                     "refuse survey files of which anything has to be skipped; otherwise it is a warning"};

  Out<InputFiles> inputs{"inputs", "the files that were read, and survey files that `unused` sets aside"};
  Out<InputFiles> unread{"unread", "what else lies in the folder"};

  void run(Context& context) override {
    campaign::ListedCampaign site(folder.unpack(), context.resolve(std::string(folder->uri()->string_view())),
                                  campaign::CampaignUse::survey, campaign::given_by(added));
    campaign::KnownControl known;
    SurveyObservationsT readings;
    site.problems.attempt([&] { known = campaign::read_control(site.description, site.root, context); });
    site.problems.attempt(
        [&] { readings = campaign::read_surveys(site.description, site.root, site.added, known, *strict, context); });
    site.warn_of_what_is_left(context);
    site.problems.raise();
    control.commit(campaign::to_artifact(known.points));
    survey.commit(readings);
    inputs.commit(site.inputs(context, 0, readings_of(readings)));
    unread.commit(site.unread());
  }
};

/// Each file by itself: campaigns of one network at different times.
struct ReadSurveyEpochs : Node {
  static constexpr Info info{"read.survey_epochs", "", 5,
                             "Reads the survey files that a campaign.yaml names, one epoch each, in its order"};
  In<Folder> folder{"folder", "a folder with a campaign.yaml whose `survey` names the files, oldest first"};
  Optional<SurveyReadings> added{"readings", frame("frame=building"),
                                 "survey files that readers of other plugins have read: parts/readers.yaml"};
  OutList<SurveyObservations> epochs{"epochs", frame("frame=building"), "one for each file"};
  Param<bool> strict{"strict", true,
                     "refuse survey files of which anything has to be skipped; otherwise it is a warning"};
  Out<InputFiles> inputs{"inputs", "the files that were read, and survey files that `unused` sets aside"};
  Out<InputFiles> unread{"unread", "what else lies in the folder"};

  void run(Context& context) override {
    campaign::ListedCampaign site(folder.unpack(), context.resolve(std::string(folder->uri()->string_view())),
                                  campaign::CampaignUse::survey, campaign::given_by(added));
    site.description.survey = site.description.survey_in_order;
    std::vector<survey::SurveyObservations> read;
    site.problems.attempt(
        [&] { read = campaign::read_survey_files(site.description, site.root, site.added, *strict, context); });
    site.warn_of_what_is_left(context);
    site.problems.raise();  // a file that nobody named may be an epoch
    long readings = 0;
    for (const auto& epoch : read) {
      const SurveyObservationsT one = survey::to_artifact(epoch);
      readings += readings_of(one);
      epochs.commit(one);
    }
    inputs.commit(site.inputs(context, 0, readings));
    unread.commit(site.unread());
  }
};

struct ReadMeasuredCampaign : Node {
  static constexpr Info info{"read.measured_campaign", "", 5,
                             "Reads a folder whose anchors were measured by total station: survey files, control, "
                             "plates and design; photographs in it are left alone"};
  In<Folder> folder{"folder", "a folder with a campaign.yaml; images, observations and camera may be left out"};
  Optional<SurveyReadings> added{"readings", frame("frame=building"),
                                 "survey files that readers of other plugins have read: parts/readers.yaml"};
  Out<Plates> plates{"plates", frame("frame=building"), "which point stands for which anchor, and how it faces"};
  Out<SurveyObservations> survey{"survey", frame("frame=building"),
                                 "all survey files in one; the datum is in `control`"};
  Out<Points> control{"control", frame("frame=building"), "the control points as given"};
  Param<bool> strict{"strict", true,
                     "refuse survey files of which anything has to be skipped; otherwise it is a warning"};
  Out<File> design_file{"design_file", "the design IFC as it is, by reference"};
  Out<File> mapping{"mapping", "the mapping table from points to elements of the design; empty without one"};
  Out<File> tolerances{"tolerances", "the project's table of tolerance classes; empty without one"};
  Out<InputFiles> inputs{"inputs", "the files that were read, and survey files that `unused` sets aside"};
  Out<InputFiles> unread{"unread", "what else lies in the folder"};

  void run(Context& context) override {
    campaign::ListedCampaign site(folder.unpack(), context.resolve(std::string(folder->uri()->string_view())),
                                  campaign::CampaignUse::measured, campaign::given_by(added));
    campaign::KnownControl known;
    SurveyObservationsT readings;
    std::vector<campaign::PlateEntry> entries;
    if (!site.description.plates.empty())
      site.problems.attempt([&] {
        entries = read_plates(site.root / site.description.plates, context, campaign::CampaignUse::measured);
      });
    site.problems.attempt([&] { known = campaign::read_control(site.description, site.root, context); });
    site.problems.attempt(
        [&] { readings = campaign::read_surveys(site.description, site.root, site.added, known, *strict, context); });
    const FileT table = mapping_file(site), classes = tolerance_file(site);
    campaign::look_at_design(site);
    site.warn_of_what_is_left(context);
    site.problems.raise();
    plates.commit(campaign::to_artifact(entries));
    control.commit(campaign::to_artifact(known.points));
    survey.commit(readings);
    design_file.commit(design_reference(site));
    mapping.commit(table);
    tolerances.commit(classes);
    inputs.commit(site.inputs(context, 0, readings_of(readings)));
    unread.commit(site.unread());
  }
};

/// Only an evaluation may be fed from this.
struct ReadTruth : Node {
  static constexpr Info info{"read.truth", "", 2, "Reads the truth beside a simulated campaign; for evaluation only"};
  In<Folder> truth{"truth", "the folder `truth` of simulate.campaign"};
  Out<Points> points{"points", frame("frame=building"), "where the anchors really are; sigma 0"};
  Out<Poses> cameras{"poses", frame("frame=building"), "where the photographs were really taken; no covariance"};

  void run(Context& context) override {
    const fs::path folder = context.resolve(std::string(truth->uri()->string_view()));
    commit_cameras(folder / "cameras.csv");
    const fs::path path = folder / "anchors.csv";
    PointsT result;
    for (const campaign::TrueAnchor& anchor : campaign::parse_true_anchors(text::read_whole(path), path)) {
      auto point = std::make_unique<PointT>();
      point->id = anchor.id;
      point->position = anchor.position;
      point->sigma.setZero();
      point->role = anchor.role;
      result.points.push_back(std::move(point));
    }
    points.commit(result);
  }

 private:
  void commit_cameras(const fs::path& path) {
    PosesT result;
    for (const campaign::TrueCamera& camera : campaign::parse_true_cameras(text::read_whole(path), path)) {
      auto pose = std::make_unique<PoseT>();
      pose->path = "images/" + camera.image;
      pose->cam_from_world = camera.camera_from_building;
      result.poses.push_back(std::move(pose));
    }
    cameras.commit(result);
  }
};

}  // namespace

PLUMBLINE_PLUGIN("campaign", PLUMBLINE_BUILD_ID, "MIT", ReadCampaign, campaign::ReadPhotoCampaign, ReadSurveyCampaign,
                 ReadSurveyEpochs, ReadMeasuredCampaign, ReadTruth, campaign::ProposeCampaign,
                 campaign::AccountForCampaign, campaign::FilesForReader)
