#include "photo_campaign_node.hpp"

#include "artifacts/camera_artifact.hpp"
#include "artifacts/input_files_text.hpp"
#include "base/text/whole_file.hpp"
#include "campaign_artifacts.hpp"
#include "geometry/packed_symmetric.hpp"
#include "listed_campaign.hpp"
#include "photo/cameras/camera_files.hpp"
#include "photo/images/photograph_header.hpp"
#include "reader_files_node.hpp"

namespace plumbline::campaign {
namespace {

namespace fs = std::filesystem;

CameraT artifact_of(const cameras::CameraFile& file, const std::string& name) {
  CameraT camera;
  camera.id = file.id;
  set_interior(file.camera, file.covariance.size() ? file.covariance : cameras::usual_covariance(file.camera), camera);
  camera.source = file.format + " file " + name;
  return camera;
}

/// Ours, or another program's, of one camera or of several by name. One of another program, without standard
/// deviations, starts a self-calibration.
std::vector<CameraT> cameras_of(const fs::path& path, const std::string& name, Context& context) {
  const std::string text = text::read_whole(path), key = "plumbline_camera";
  if (text.starts_with(key) || text.find("\n" + key) != std::string::npos)
    return {to_artifact(parse_camera(text, path), name)};
  std::vector<CameraT> cameras;
  for (const cameras::CameraFile& file : cameras::parse_camera_files(text, path.string())) {
    cameras.push_back(artifact_of(file, name));
    context.info(name + ": " + file.format + " camera " + file.id);
  }
  return cameras;
}

ImageT image_of(const FolderEntryT& entry, const fs::path& root) {
  ImageT image;
  image.path = entry.path;
  // By content: a folder that is moved, or made again, leaves all that follows as it is.
  image.uri = "sha256:" + entry.sha256 + "/" + fs::path(entry.path).filename().string();
  image.sha256 = entry.sha256;
  image.size = entry.size;
  try {
    const PhotographHeader header = read_photograph_header(root / entry.path);
    image.width = header.width, image.height = header.height;
    image.model = header.model, image.serial = header.serial, image.taken_at = header.taken_at;
    image.focal_length = header.focal_length, image.principal_distance = header.principal_distance;
    image.orientation = header.orientation;
  } catch (const std::runtime_error&) {
    // The detector, which reads the pixels, tells what is wrong with them.
  }
  return image;
}

/// Surveyed points of which nobody has the readings: coordinates that were measured.
SurveyObservationsT as_measured(const std::vector<ControlPoint>& points, const CampaignDescription& description) {
  survey::SurveyObservations all;
  survey::CoordinateGroup group;
  const auto n = static_cast<Eigen::Index>(3 * points.size());
  Eigen::VectorXd values(n);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(n, n);
  std::vector<Eigen::Index> known;
  for (std::size_t i = 0; i < points.size(); ++i) {
    survey::Point point;
    point.id = points[i].name, point.coordinates = points[i].position;
    all.points.push_back(point);
    const auto first = static_cast<Eigen::Index>(3 * i);
    values.segment<3>(first) = points[i].position;
    covariance.block<3, 3>(first, first) = covariance_of(points[i]);
    for (int axis = 0; axis < 3; ++axis) {
      if (std::isnan(points[i].position(axis))) continue;
      group.components.push_back({points[i].name, axis});
      known.push_back(first + axis);
    }
  }
  group.values = values(known), group.covariance = covariance(known, known);
  all.coordinates.push_back(group);
  all.files = {description.control};
  all.info.format = "csv", all.info.title = description.name, all.info.date = description.date;
  return survey::to_artifact(all);
}

/// Tables in folders below are taken for read by who put them there.
void warn_of_unread(const CampaignDescription& description, const std::vector<std::string>& names, Context& context) {
  for (const std::string& name : names) {
    const std::string file = fs::path(name).filename().string();
    if (file != "camera.yaml" && file != "plates.csv" && file != "control.csv") continue;
    const bool camera = !description.cameras.empty() && name == description.cameras.front().file;
    if (name == file || camera || name == description.plates || name == description.control) continue;
    context.warn(name + " is not read: it belongs into the folder itself" +
                 (file == "camera.yaml" ? "; one camera.yaml has several cameras, each under the name of its folder"
                                        : ", or into campaign.yaml by its name"));
  }
}

}  // namespace

void ReadPhotoCampaign::run(Context& context) {
  ListedCampaign site(folder.unpack(), context.resolve(std::string(folder->uri()->string_view())),
                      CampaignUse::photographs, given_by(added));
  const CampaignDescription& description = site.description;
  const fs::path& root = site.root;
  if (description.images.empty() && !description.observations.empty())
    site.problems.add(CampaignError(
        root / "campaign.yaml", 0, "names 'observations' and no images; pipelines/site_observations.yaml takes those"));
  const std::vector<std::string> names = site.names();
  if (const std::string unread_ones = unread_photographs(names); !unread_ones.empty())
    context.warn("photographs of " + root.string() + " are " + unread_ones);
  warn_of_unread(description, names, context);
  std::vector<CameraT> calibrated;
  std::vector<PlateEntry> entries;
  std::vector<std::string> warnings;
  KnownControl known;
  SurveyObservationsT readings;
  for (const CameraOfImages& camera : description.cameras)
    site.problems.attempt([&] {
      for (CameraT& one : cameras_of(root / camera.file, camera.file, context)) calibrated.push_back(std::move(one));
    });
  if (!description.plates.empty())
    site.problems.attempt([&] {
      const fs::path table = root / description.plates;
      entries = parse_plates(table_text(table, is_table_of_plates, "a table of plates"), table,
                             CampaignUse::photographs, &warnings);
    });
  site.problems.attempt([&] { known = read_control(description, root, context); });
  if (!description.survey.empty())
    site.problems.attempt([&] { readings = read_surveys(description, root, site.added, known, *strict, context); });
  site.warn_of_what_is_left(context);
  site.problems.raise();

  for (const std::string& warning : warnings) context.warn(warning);
  for (const std::string& path : description.images) images.commit(image_of(site.entry(path), root));
  for (const CameraT& camera : calibrated) cameras.commit(camera);
  plates.commit(to_artifact(entries));
  if (description.survey.empty()) {
    if (!description.date_remark.empty()) context.warn(description.date_remark);
    survey.commit(as_measured(known.points, description));
    control.commit(PointsT());
  } else {
    survey.commit(readings);
    control.commit(to_artifact(known.points));
  }
  inputs.commit(site.inputs(context, description.images.size(), readings_of(readings)));
  unread.commit(site.unread());
}

}  // namespace plumbline::campaign
