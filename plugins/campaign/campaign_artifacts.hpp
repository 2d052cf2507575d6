// What campaign_folder.hpp reads, as artifacts.
#pragma once

#include <filesystem>

#include "artifacts/camera.hpp"
#include "artifacts/folder.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "artifacts/survey_artifact.hpp"
#include "campaign_folder.hpp"
#include "plumbline/node.hpp"

namespace plumbline::campaign {

/// The file's bytes. Throws CampaignError.
std::string read_text(const std::filesystem::path& path);

CameraT to_artifact(const CameraCalibration& calibration, const std::string& source);
PlatesT to_artifact(const std::vector<PlateEntry>& entries);
PointsT to_artifact(const std::vector<ControlPoint>& entries);

/// campaign.yaml of a listed folder that lies at `root`. Throws CampaignError.
CampaignDescription describe(const FolderT& given, const std::filesystem::path& root, CampaignUse use);

/// The control points; none if the campaign names no file. What is assumed becomes a warning of the node.
std::vector<ControlPoint> read_control(const CampaignDescription& description, const std::filesystem::path& root,
                                       Context& context);

/// All survey files in one. A network adjusted from part of its readings must not look like one adjusted from all:
/// `strict` refuses what would have to be skipped.
SurveyObservationsT read_surveys(const CampaignDescription& description, const std::filesystem::path& root,
                                 const std::vector<ControlPoint>& known, bool strict, Context& context);

}  // namespace plumbline::campaign
