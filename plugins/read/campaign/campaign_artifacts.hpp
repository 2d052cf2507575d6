// What campaign_folder.hpp reads, as artifacts.
#pragma once

#include <filesystem>
#include <map>
#include <memory>

#include "artifacts/camera.hpp"
#include "artifacts/folder.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "artifacts/survey_artifact.hpp"
#include "campaign_folder.hpp"
#include "photo/images/photograph_header.hpp"
#include "plumbline/node.hpp"

namespace plumbline::campaign {

/// Size and EXIF of a photograph, whose file is read to its end mark: a truncated one is found before anyone decodes
/// it. Throws CampaignError.
PhotographHeader header_of(const std::filesystem::path& path);

CameraT to_artifact(const CameraCalibration& calibration, const std::string& source);
PlatesT to_artifact(const std::vector<PlateEntry>& entries);
PointsT to_artifact(const std::vector<ControlPoint>& entries);

/// Of E, N and H [m²]; zero in the rows of what is not known.
Eigen::Matrix3d covariance_of(const ControlPoint& point);

struct KnownControl {
  std::vector<ControlPoint> points;
  std::vector<std::string> warnings;  ///< what was assumed of them, such as which column is the east
};

/// The control points; none if the campaign names no file. What is assumed is a warning of the node, too.
KnownControl read_control(const CampaignDescription& description, const std::filesystem::path& root, Context& context);

/// By path below the folder: what readers of other plugins have read of it.
using AddedReadings = std::map<std::string, std::unique_ptr<SurveyObservationsT>>;

/// One for each file that campaign.yaml names, in its order: of `added` if it is there, else by the reader that its
/// content calls for. Throws at what has to be skipped if `strict`.
std::vector<survey::SurveyObservations> read_survey_files(const CampaignDescription& description,
                                                          const std::filesystem::path& root, const AddedReadings& added,
                                                          bool strict, Context& context);

/// All survey files in one. A network adjusted from part of its readings must not look like one adjusted from all:
/// `strict` refuses what would have to be skipped. What was assumed of files and control goes with the readings, so
/// that the network's findings, its verdict and its page tell it.
SurveyObservationsT read_surveys(const CampaignDescription& description, const std::filesystem::path& root,
                                 const AddedReadings& added, const KnownControl& known, bool strict, Context& context);

}  // namespace plumbline::campaign
