// Single readers and writers: points, image observations, COLMAP models, gcp_list.txt, PLY.
#pragma once

#include "artifacts/camera.hpp"
#include "artifacts/file.hpp"
#include "artifacts/folder.hpp"
#include "artifacts/points.hpp"
#include "artifacts/poses.hpp"
#include "artifacts/tag_observations.hpp"
#include "control/points/control_table.hpp"
#include "photo/cameras/colmap_files.hpp"
#include "photo/markers/control_block.hpp"
#include "plumbline/node.hpp"

namespace plumbline::markers {

struct ReadPoints : Node {
  static constexpr Info info{"read.points", "", 2,
                             "Reads surveyed points from CSV (name, x, y, z, sigma, role) or gcp_list.txt"};
  Param<FilePath> file{"file", required, "the file"};
  Param<std::string> axes{
      "axes", "as_named", one_of("as_named", "x_east", "x_north"),
      "what columns x and y are: east and north, or north and east; as_named: as other columns and the "
      "values tell, with a warning"};
  Out<Points> points{"points", frame("frame=survey"), "the points; sigmas that the file does not say are nan"};
  void run(Context& context) override;
};

struct ReadImageObservations : Node {
  static constexpr Info info{"read.image_observations", "", 1,
                             "Reads the tags of photographs back from observations.json or observations.csv"};
  Param<FilePath> file{"file", required, "observations.json of a detector, or the observations.csv of a campaign"};
  Out<TagObservations> observations{"observations", "the tags with their covariances"};
  void run(Context& context) override;
};

struct ReadColmap : Node {
  static constexpr Info info{"read.colmap", "", 1, "Reads a COLMAP model, text or binary"};
  Param<FolderPath> folder{"folder", required, "folder with cameras, images and points3D"};
  OutList<Camera> cameras{"cameras", "interior orientations, in the order of their ids"};
  Out<Poses> poses{"poses", frame("frame=colmap"), "exterior orientations, in the order of the images' ids"};
  Out<Points> points{"points", frame("frame=colmap"), "the model's points; sigmas are not known"};
  void run(Context& context) override;
};

/// What a table of control leaves to be known: what was assumed, and what was not used.
void tell(const control::ControlTable& table, const std::string& file, Context& context);

/// Surveyed points as an artifact.
PointsT point_artifacts(const std::vector<ControlPoint>& control);

/// Interior and exterior orientations of a model, in the order of their ids.
std::vector<CameraT> camera_artifacts(const cameras::ColmapModel& model);
PosesT pose_artifacts(const cameras::ColmapModel& model);

/// The model as COLMAP text files in the folder at `path`, which the host knows as `uri`.
FolderT write_model(const cameras::ColmapModel& model, const std::string& uri, const std::string& path,
                    Context& context);

struct WriteColmap : Node {
  static constexpr Info info{"write.colmap", "", 1, "Writes cameras, poses and points as a COLMAP model, text"};
  In<Poses> poses{"poses", frame("frame=?F"), "exterior orientations"};
  List<Camera> cameras{"cameras", "the camera of all images, or several that are called as the images' folders"};
  Optional<Points> points{"points", frame("frame=?F"), "points of the model"};
  Optional<TagObservations> observations{
      "observations", "tags whose id, or family:id, is the name of a point: their centres become features of it"};
  Out<Folder> model{"model", "cameras.txt, images.txt and points3D.txt; the corner of the top-left pixel is (0, 0)"};
  void run(Context& context) override;
};

struct WriteGcp : Node {
  static constexpr Info info{"write.gcp", "", 1,
                             "Writes surveyed points and their measurements as OpenDroneMap's gcp_list.txt"};
  In<Points> points{"points", frame("frame=?F"), "surveyed points"};
  In<TagObservations> observations{"observations",
                                   "tags whose id, or family:id, is the name of a point; their centres are written"};
  Param<std::string> projection{"projection", "LOCAL", "first line, such as EPSG:32632"};
  Out<File> file{"file", "gcp_list.txt; the corner of the top-left pixel is (0, 0)"};
  void run(Context& context) override;
};

struct WritePly : Node {
  static constexpr Info info{"write.ply", "", 1, "Writes points as a PLY cloud"};
  In<Points> points{"points", frame("frame=?F"), "the points"};
  Param<std::string> name{"name", "points.ply", "base name of the file"};
  Out<File> file{"file", "PLY, ascii, doubles"};
  void run(Context& context) override;
};

}  // namespace plumbline::markers
