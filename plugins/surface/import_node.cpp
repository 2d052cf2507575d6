#include "import_node.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <optional>

#include "cloud/cloud_file.hpp"
#include "geometry/packed_symmetric.hpp"
#include "plumbline/stop.hpp"
#include "surface_artifacts.hpp"

namespace plumbline::surface {
namespace {

struct Unit {
  const char* name;
  double metres;
};
constexpr Unit kUnits[] = {{"m", 1}, {"cm", 0.01}, {"mm", 0.001}, {"ft", 0.3048}, {"us_ft", 1200.0 / 3937}};

std::string name_of_unit(double metres) {
  for (const Unit& unit : kUnits)
    if (std::abs(unit.metres / metres - 1) < 1e-9) return unit.name;
  return std::to_string(metres) + " m";
}

/// Metres in one unit of the file. Throws if what is asked for and what the file says differ.
double unit_of(const cloud::CloudSummary& file, const std::string& wanted, const Context& context) {
  if (wanted == "from_file") {
    if (std::isfinite(file.unit)) return file.unit;
    context.warn("the file does not say its unit; its coordinates are taken for metres ('unit' says another)");
    return 1;
  }
  const double asked =
      std::find_if(std::begin(kUnits), std::end(kUnits), [&](const Unit& u) { return wanted == u.name; })->metres;
  if (std::isfinite(file.unit) && std::abs(file.unit / asked - 1) > 1e-9)
    throw std::runtime_error("'unit' is " + wanted + ", but the file says that its coordinates are in " +
                             name_of_unit(file.unit) + "; leave 'unit' out, or mend the file");
  return asked;
}

/// From coordinates of the file to the frame of the faces.
struct ToFaces {
  double unit = 1, scale = 1;
  RigidTransform frame;
  Eigen::Vector3d operator()(const Eigen::Vector3d& point) const {
    return frame.rotation * (scale * unit * point) + frame.translation;
  }
};

/// Every k-th point, so many that they tell where a cloud lies.
class Sample {
 public:
  void add(const Eigen::Vector3d& point) {
    if (seen_++ % every_ != 0) return;
    points_.push_back(point);
    if (points_.size() < 65536) return;
    for (size_t i = 0; i < points_.size() / 2; ++i) points_[i] = points_[2 * i];
    points_.resize(points_.size() / 2);
    every_ *= 2;
  }
  const std::vector<Eigen::Vector3d>& points() const { return points_; }

 private:
  std::vector<Eigen::Vector3d> points_;
  std::uint64_t seen_ = 0, every_ = 1;
};

std::string box_text(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  char text[200];
  std::snprintf(text, sizeof text, "(%.2f, %.2f, %.2f) to (%.2f, %.2f, %.2f)", low.x(), low.y(), low.z(), high.x(),
                high.y(), high.z());
  return text;
}

/// Refuses a cloud that lies elsewhere: in another unit, where another would put its points on the faces, or in another
/// frame.
void check_place(const std::vector<PanelFace>& faces, const ScanTiles& tiles, const Sample& sample,
                 const ToFaces& to_faces) {
  const auto hits = [&](double unit) {
    ToFaces other = to_faces;
    other.unit = unit;
    return std::count_if(sample.points().begin(), sample.points().end(),
                         [&](const Eigen::Vector3d& point) { return tiles.on_a_face(other(point)); });
  };
  const auto now = hits(to_faces.unit),
             enough = static_cast<std::ptrdiff_t>(std::min<size_t>(20, sample.points().size()));
  auto most = now;
  const Unit* better = nullptr;
  for (const Unit& unit : kUnits)
    if (const auto count = hits(unit.metres); count > 3 * most && count >= enough) most = count, better = &unit;
  const std::string of = " of " + std::to_string(sample.points().size()) + " sampled points lie on the faces";
  if (better)
    throw std::runtime_error(std::to_string(now) + of + " if the coordinates are in " + name_of_unit(to_faces.unit) +
                             ", " + std::to_string(most) + " if they are in " + better->name +
                             "; set unit: " + better->name);
  if (std::any_of(tiles.tiles().begin(), tiles.tiles().end(), [](const ScanTile& tile) { return tile.points > 0; }))
    return;
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e300), high = -low, face_low = low, face_high = high;
  for (const auto& point : sample.points()) low = low.cwiseMin(to_faces(point)), high = high.cwiseMax(to_faces(point));
  for (const PanelFace& face : faces)
    face_low = face_low.cwiseMin(face.plane.origin), face_high = face_high.cwiseMax(face.plane.origin);
  throw std::runtime_error("no point of the scan lies on a face: the scan reaches from " + box_text(low, high) +
                           " m, the middles of the faces from " + box_text(face_low, face_high) +
                           " m; is it in another frame? Connect the 'registration' that leads to the design's, or look "
                           "further with 'search'");
}

/// What the scan's place is off by: from the registration, and from what the user states.
std::vector<ScanPlace> places_of(const std::optional<TransformT>& registration, double place_sigma, double turn_sigma,
                                 const Eigen::Vector3d& middle) {
  std::vector<ScanPlace> places;
  if (registration && !registration->covariance.empty()) {
    ScanPlace place;
    place.pivot = registration->to_from_from.translation;
    const size_t rows = registration->covariance.size() == packed_size(7) ? 7 : 6;
    place.covariance = unpack_symmetric(registration->covariance, rows, "the registration");
    if (rows == 7) place.covariance.row(6) /= registration->scale, place.covariance.col(6) /= registration->scale;
    places.push_back(place);
  }
  if (place_sigma > 0 || turn_sigma > 0) {
    ScanPlace place;
    place.pivot = middle, place.covariance = Eigen::MatrixXd::Zero(6, 6);
    place.covariance.diagonal().head<3>().setConstant(turn_sigma * turn_sigma);
    place.covariance.diagonal().tail<3>().setConstant(place_sigma * place_sigma);
    places.push_back(place);
  }
  return places;
}

std::vector<Eigen::Vector3d> stations_of(const std::vector<double>& values) {
  if (values.size() % 3 != 0)
    throw std::runtime_error("'seen_from' has " + std::to_string(values.size()) +
                             " values, expected x, y and z of each station");
  std::vector<Eigen::Vector3d> stations;
  for (size_t i = 0; i < values.size(); i += 3) stations.emplace_back(values[i], values[i + 1], values[i + 2]);
  return stations;
}

Eigen::Vector3d middle_of(const std::vector<PanelFace>& faces) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const PanelFace& face : faces) middle += face.plane.origin / static_cast<double>(faces.size());
  return middle;
}

Eigen::MatrixXd factor_of_all(const std::vector<ScanPlace>& places, int rank, const Eigen::Vector3d& centre) {
  Eigen::MatrixXd factor(6, rank);
  Eigen::Index column = 0;
  for (const ScanPlace& place : places) {
    const auto part = factor_of(place, centre);
    factor.middleCols(column, part.cols()) = part;
    column += part.cols();
  }
  return factor;
}

std::string file_name(size_t tile) {
  char name[32];
  std::snprintf(name, sizeof name, "%06zu.points", tile);
  return name;
}

}  // namespace

void ImportCloud::run(Context& context) {
  if (!design && !points)
    throw std::runtime_error("connect 'design', whose panels are measured, or 'points', whose plane is");
  const auto stations = stations_of(*seen_from);
  const Faces faces = design ? faces_of(design.unpack(), stations) : face_through(points.unpack(), stations, *margin);
  for (const auto& what : faces.left_out) context.warn("not measured: " + what);
  if (faces.faces.empty())
    throw std::runtime_error(
        "the design has no panel with a face that could be measured; mark the panels in it, or connect 'points'");
  ToFaces to_faces;
  std::optional<TransformT> fit;
  if (registration) {
    fit = registration.unpack();
    if (fit->plan_only)
      throw std::runtime_error(
          "the registration scales the plan only, as a map does; a scan needs one that scales heights too, or none");
    to_faces.frame = fit->to_from_from, to_faces.scale = std::isfinite(fit->scale) ? fit->scale : 1;
  }
  const cloud::CloudSummary before = cloud::look_at_cloud(file->path);
  to_faces.unit = unit_of(before, *unit, context);

  const auto folder = files.make_folder();
  const auto path_of = [&](size_t t) { return folder.path + "/" + file_name(t); };
  ScanTiles tiles(faces.faces, *search, *tile, [&](size_t t, const std::vector<MeasuredPoint>& some) {
    MeasuredTile part;
    part.points = some;
    append_points(part, path_of(t));
  });
  context.reserve_memory(tiles.tiles().size() * 1024 * sizeof(MeasuredPoint) + (8u << 20));
  Sample sample;
  const cloud::CloudSummary read =
      cloud::read_cloud(file->path, [&](const std::vector<Eigen::Vector3d>& some, double done) {
        if (context.cancelled()) throw Stopped();
        context.progress(done, "points");
        for (const auto& point : some) {
          sample.add(point);
          tiles.add(to_faces(point), *noise);
        }
      });
  tiles.flush();
  context.info(read.format + ": " + std::to_string(read.points) + " points");
  if (read.without_place > 0)
    context.warn(std::to_string(read.without_place) + " points have no coordinates (NaN) and are left out");
  if (read.withheld > 0)
    context.info(std::to_string(read.withheld) + " points are withheld or noise, as the file says, and are left out");
  check_place(faces.faces, tiles, sample, to_faces);

  commit(context, faces, tiles, places_of(fit, *place_sigma, *turn_sigma, middle_of(faces.faces)), folder.path,
         folder.uri);
}

void ImportCloud::commit(Context& context, const Faces& faces, const ScanTiles& tiles,
                         const std::vector<ScanPlace>& places, const std::string& folder,
                         const std::string& uri) const {
  SurfacePointsT artifact;
  artifact.source = "scan", artifact.warnings = faces.left_out;
  for (const ScanPlace& place : places) artifact.rank += static_cast<int>(place.covariance.rows());
  FolderT listing;
  listing.uri = uri;
  double covered = 0;
  std::int64_t empty = 0;
  for (size_t t = 0; t < tiles.tiles().size(); ++t) {
    const ScanTile& from = tiles.tiles()[t];
    if (from.points == 0) {
      ++empty;
      continue;
    }
    auto entry = std::make_unique<SurfaceTileT>();
    entry->sha256 = context.digest(folder + "/" + file_name(t)),
    entry->uri = "sha256:" + entry->sha256 + "/" + file_name(t);
    entry->points = from.points, entry->centre = from.centre;
    entry->factor = row_by_row(factor_of_all(places, artifact.rank, from.centre));
    auto listed = std::make_unique<FolderEntryT>();
    listed->path = file_name(t), listed->sha256 = entry->sha256, listed->size = from.points * sizeof(MeasuredPoint);
    listing.files.push_back(std::move(listed));
    artifact.measured += static_cast<std::int64_t>(from.points);
    artifact.tiles.push_back(std::move(entry));
    const PanelFace& face = faces.faces[from.face];
    covered += face.width * face.height / (std::ceil(face.width / *tile) * std::ceil(face.height / *tile));
  }
  for (size_t f = 0; f < faces.faces.size(); ++f) artifact.faces.push_back(describe(faces.faces[f], faces.guids[f]));
  if (empty > 0) {
    auto entry = std::make_unique<SurfaceHolesT>();
    entry->reason = "parts without a point of the scan", entry->count = empty;
    artifact.holes.push_back(std::move(entry));
  }
  artifact.spacing = std::sqrt(covered / static_cast<double>(std::max<std::int64_t>(1, artifact.measured)));
  context.info(std::to_string(artifact.measured) + " points on " + std::to_string(faces.faces.size()) + " faces");
  context.metric("points", static_cast<double>(artifact.measured), "1");
  context.metric("parts_without_points", static_cast<double>(empty), "1");
  surface.commit(artifact);
  files.commit(listing);
}

}  // namespace plumbline::surface
