// What a site hands over, read from its folder: campaign.yaml and the files it names. docs/campaign_folder.md shows
// each file. Nothing is guessed: an unknown key, a missing file or a unit that is not expected is an error with file
// and line, and all of them are told at once.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <filesystem>
#include <functional>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/text/name_pattern.hpp"
#include "control/points/control_point.hpp"
#include "geometry/camera.hpp"
#include "plumbline/failure.hpp"
#include "plumbline/rigid_transform.hpp"

namespace plumbline::campaign {

/// what() is "file:line: what was found, what was expected".
class CampaignError : public BadInput {
 public:
  using BadInput::BadInput;
  CampaignError(const std::filesystem::path& file, int line, const std::string& what)
      : BadInput(file.string() + (line > 0 ? ":" + std::to_string(line) : "") + ": " + what) {}
};

/// What is wrong with a folder, one thing after the other, so that it can be mended in one go.
class Problems {
 public:
  /// Runs `action`; what it throws is one problem, or several with a line each. False if it threw.
  bool attempt(const std::function<void()>& action);
  void add(const CampaignError& problem) { lines_.push_back(problem.what()); }
  bool empty() const { return lines_.empty(); }
  /// Throws CampaignError with a line for each problem, if there are any: the first 25, and how many more.
  void raise() const;

 private:
  std::vector<std::string> lines_;
};

/// A calibration, and whose photographs it is for.
struct CameraOfImages {
  std::string file;                   ///< its camera.yaml
  std::vector<std::string> patterns;  ///< of the names of its photographs; empty: all
};

using text::matches_pattern;

/// campaign.yaml with its patterns resolved. Paths are relative to the folder, with forward slashes, ordered by name.
struct CampaignDescription {
  std::string name;
  std::vector<std::string> images;
  std::string observations;             ///< tags that were measured already; then `images` may be empty
  std::vector<CameraOfImages> cameras;  ///< may be empty where photographs calibrate themselves
  std::string plates, control, design;  ///< control may be empty: then the survey files hold the datum
  std::string mapping;                  ///< from points to elements of the design; may be empty
  std::string tolerances;               ///< the project's tolerance classes; may be empty
  std::vector<std::string> survey;
  std::vector<std::string> survey_in_order;  ///< the same as written: epochs, oldest first
  std::string instrument;                    ///< name of an instrument profile; may be empty
  std::string date;                          ///< when it was measured, ISO 8601; may be empty
  std::string date_remark;                   ///< how the date was understood, where somebody might read it otherwise
  /// What is to be left out, though it lies there: files, and sheets of workbooks as "Tables.xlsx#Sheet".
  std::vector<std::string> unused;
  /// Nothing there says which table the known points are in: each key was understood, and 'control' is none of them.
  bool control_left_out = true;
  std::vector<std::string> remarks;  ///< what is no mistake and may be one: patterns of `unused` that fit nothing
};

/// What is to be done with a campaign, and so what it must hold.
enum class CampaignUse {
  site,         ///< all of it
  alone,        ///< the same of photographs alone: neither survey files nor control points
  photographs,  ///< photographs (or observations), and survey files or control points; the rest if it is there
  survey,       ///< survey files; images, camera, plates and design are left alone
  measured      ///< survey files, plates and design: anchors are measured by total station; images are left alone
};

/// `files`: what the folder holds, as relative paths with forward slashes. `shown` names campaign.yaml in messages.
/// Throws CampaignError with all that is wrong: unknown or missing key (with the near one), a file that is not there, a
/// pattern without a match.
CampaignDescription parse_campaign(const std::string& yaml, const std::filesystem::path& shown,
                                   std::vector<std::string> files, CampaignUse use = CampaignUse::site);
/// The same; what is wrong goes to `problems`, and what could be understood is returned.
CampaignDescription parse_campaign(const std::string& yaml, const std::filesystem::path& shown,
                                   std::vector<std::string> files, CampaignUse use, Problems& problems);

/// The same for a folder without campaign.yaml, for CampaignUse::photographs: all photographs in it, what lies in
/// survey/, and camera.yaml, plates.csv and control.csv. `folder` is for messages. Throws CampaignError.
CampaignDescription find_campaign(const std::filesystem::path& folder, std::vector<std::string> files);

/// Throws CampaignError if there is no campaign.yaml and one lies there under another name, such as campaign.yml or
/// campaign.yaml.txt, which nothing would read.
void refuse_misnamed_campaign(const std::filesystem::path& folder, const std::vector<std::string>& files);

struct CameraCalibration {
  std::string id, make, model;
  double pixel_pitch = 0;  ///< [m]; nan if not given
  BrownCamera camera;
  /// In the order and units of InteriorOrientation::names(); 0: exact. All 0 if the file gives none.
  std::array<double, BrownCamera::parameter_count> sigmas{};
  Eigen::MatrixXd covariance;  ///< 9 × 9 of them, with the file's correlations; empty if all are exact
};
/// A camera.yaml. `pixel_origin: corner` (COLMAP, libapriltag) is shifted to our convention. Throws CampaignError.
CameraCalibration parse_camera(const std::string& yaml, const std::filesystem::path& shown);

/// One tag in one image, as another program measured it.
struct ObservedTag {
  std::string image, family;
  int id = 0;
  std::array<Eigen::Vector2d, 4> corners;  ///< bottom left, bottom right, top right, top left [px], first pixel (0, 0)
  double sigma = 0;                        ///< of a corner coordinate [px]
};
/// An observations.csv, in the order of images and tags. `camera_of`, from the name of an image, may throw
/// std::runtime_error. Throws CampaignError, also for a tag that an image has twice and a corner outside of the
/// camera's image.
std::vector<ObservedTag> parse_observations(const std::string& csv, const std::filesystem::path& shown,
                                            const std::function<const BrownCamera&(const std::string&)>& camera_of);

struct PlateEntry {
  std::string anchor, tag_family, batch, role;  ///< role "control" or "check"
  int tag_id = 0, floor = 0, column = 0, row = 0;
  double tag_size = 0;                                            ///< [m]
  Eigen::Vector3d tag_centre_in_plate = Eigen::Vector3d::Zero();  ///< [m]
  double facing_azimuth = 0;  ///< of the plate's outward normal, clockwise from north [rad]
  /// Standard deviations of where the plate sits on its anchor, along its axes [m]; nan: not given.
  Eigen::Vector3d mounting_sigma = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
};
/// What the columns of plates.csv may be called, with the name used for each here: German ones, too.
const std::map<std::string, std::string>& plate_column_names();
/// A plates.csv, ordered by anchor. Throws CampaignError, also for an anchor or a tag that occurs twice. With
/// CampaignUse::photographs role (control), floor (1), size (nan), offsets (0) and azimuth (0) may be left out; with
/// CampaignUse::measured all of the tag, role (control) and azimuth (nan); with CampaignUse::alone role (control).
/// A column that is none of the table's is left out, and `warnings` says so; one that is nearly called like one of them
/// is an error.
std::vector<PlateEntry> parse_plates(const std::string& csv, const std::filesystem::path& shown,
                                     CampaignUse use = CampaignUse::site, std::vector<std::string>* warnings = nullptr);

/// Rotation of an upright plate whose normal is horizontal: frame_from_plate for a frame of E, N, H.
Eigen::Quaterniond upright_plate(double facing_azimuth);

using control::ControlPoint;
/// A control.csv, in the dialect of all tables of control (control/control_table.hpp); nan where a point has no height
/// or no place in the plan. Without standard deviations 1 mm is assumed, which `warnings` says, as all that was assumed
/// or is not used. Throws CampaignError.
std::vector<ControlPoint> parse_control(const std::string& csv, const std::filesystem::path& shown,
                                        std::vector<std::string>* warnings = nullptr);

/// A row of truth/cameras.csv, likewise.
struct TrueCamera {
  std::string image;
  RigidTransform camera_from_building;
};
/// Throws std::runtime_error with the line.
std::vector<TrueCamera> parse_true_cameras(const std::string& csv, const std::filesystem::path& shown);

/// A row of truth/anchors.csv, which simulate.campaign writes.
struct TrueAnchor {
  std::string id, role;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< [m]
};
/// Throws CampaignError.
std::vector<TrueAnchor> parse_true_anchors(const std::string& csv, const std::filesystem::path& shown);

}  // namespace plumbline::campaign
