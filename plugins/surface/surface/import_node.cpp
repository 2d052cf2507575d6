#include "import_node.hpp"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <optional>
#include <string_view>

#include "geometry/packed_symmetric.hpp"
#include "plumbline/stop.hpp"
#include "scan_unit.hpp"
#include "surface/cloud/cloud_file.hpp"
#include "surface/dense/scan_shift.hpp"
#include "surface_artifacts.hpp"

namespace plumbline::surface {
namespace {

constexpr double kFeetApart = 0.3048006096012192 - 0.3048;  // in one foot, of US surveys and international [m]

std::string in_millimetres(double metres) { return fmt::format("{:.{}f} mm", 1e3 * metres, 1e3 * metres < 1 ? 2 : 0); }

/// How far apart points at these coordinates lie in the two feet.
double feet_apart(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  return kFeetApart * low.cwiseAbs().cwiseMax(high.cwiseAbs()).norm();
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
  return fmt::format("({:.2f}, {:.2f}, {:.2f}) to ({:.2f}, {:.2f}, {:.2f})", low.x(), low.y(), low.z(), high.x(),
                     high.y(), high.z());
}

/// Parts of faces that points of the sample lie on, if the coordinates are in that unit. Parts and not points: what
/// lies near the scanner has thousands, and in another unit a lawn may come to lie on one panel.
size_t parts_hit(const ScanTiles& tiles, const Sample& sample, ToFaces to_faces, double unit) {
  to_faces.unit = unit;
  std::vector<bool> hit(tiles.tiles().size());
  for (const Eigen::Vector3d& point : sample.points())
    if (const auto tile = tiles.tile_of(to_faces(point))) hit[*tile] = true;
  return static_cast<size_t>(std::count(hit.begin(), hit.end(), true));
}

/// "set unit: mm"; of feet both, as nobody can tell them by where points lie.
std::string advice(const Unit& unit, const cloud::CloudSummary& file) {
  if (std::string_view(unit.name).find("ft") == std::string_view::npos) return std::string("set unit: ") + unit.name;
  return "set unit: ft for international feet (0.3048 m) or unit: us_ft for US survey feet (1200/3937 m); here they "
         "lie " +
         in_millimetres(feet_apart(file.low, file.high)) + " apart";
}

/// Refuses a cloud that lies elsewhere: in another unit, where nobody states one and another would put its points on
/// the faces, or in another frame.
void check_place(const std::vector<PanelFace>& faces, const ScanTiles& tiles, const Sample& sample,
                 const ToFaces& to_faces, bool unit_stated, const cloud::CloudSummary& file) {
  const size_t now = parts_hit(tiles, sample, to_faces, to_faces.unit);
  const bool none =
      std::none_of(tiles.tiles().begin(), tiles.tiles().end(), [](const ScanTile& tile) { return tile.points > 0; });
  if (unit_stated && !none) return;
  size_t most = now;
  const Unit* better = nullptr;
  for (const Unit& unit : kUnits)
    if (const size_t count = parts_hit(tiles, sample, to_faces, unit.metres); count > 3 * most)
      most = count, better = &unit;
  const std::string of = " of " + std::to_string(tiles.tiles().size()) + " parts of the faces have points";
  if (better)
    throw std::runtime_error(std::to_string(now) + of + " if the coordinates are in " + name_of_unit(to_faces.unit) +
                             ", " + std::to_string(most) + " if they are in " + better->name + "; " +
                             (unit_stated ? "is the stated unit wrong? " : "") + advice(*better, file));
  if (!none) return;
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e300), high = -low, face_low = low, face_high = high;
  for (const auto& point : sample.points()) low = low.cwiseMin(to_faces(point)), high = high.cwiseMax(to_faces(point));
  for (const PanelFace& face : faces)
    face_low = face_low.cwiseMin(face.plane.origin), face_high = face_high.cwiseMax(face.plane.origin);
  constexpr double kOffTheFaces = 0.005;  // [m]
  if (const double step = file.resolution.maxCoeff() * to_faces.unit * to_faces.scale;
      step > kOffTheFaces && ((low.array() - step) <= face_high.array()).all() &&
      ((high.array() + step) >= face_low.array()).all())
    throw std::runtime_error(
        "no point of the scan lies on a face: its coordinates are written in steps of " + in_millimetres(step) +
        ", which takes them off it; write doubles, more decimals or a finer scale of LAS, or shift "
        "the cloud to smaller coordinates before it is written");
  throw std::runtime_error("no point of the scan lies on a face: the scan reaches from " + box_text(low, high) +
                           " m, the middles of the faces from " + box_text(face_low, face_high) +
                           " m; is it in another frame? Connect the 'registration' that leads to the design's, or look "
                           "further with 'search'");
}

/// Of panels whose outer side is only supposed; empty: of none.
std::string words_of_guessed(const std::vector<std::string>& panels) {
  constexpr size_t most = 5;
  if (panels.empty()) return "";
  std::string names;
  for (size_t i = 0; i < std::min(most, panels.size()); ++i) names += (i ? ", " : "") + panels[i];
  if (panels.size() > most) names += fmt::format(" and {} more", panels.size() - most);
  return "Which side is outside is supposed, and confirmed by nothing, of " + names +
         ": offsets, bows, twists and steps have the other sign if it is the other one, and what is hollow bulges, "
         "which "
         "is flat under a straightedge; 'seen_from', the scanner's stations, or a rule for the facade settles it.";
}

/// Box about the faces with as much beside them as three of the largest are wide or high: where a scan would be that
/// lies some panels beside its own.
Eigen::AlignedBox3d around(const std::vector<PanelFace>& faces, double search) {
  Eigen::AlignedBox3d box;
  for (const PanelFace& face : faces) {
    const double reach = 3.5 * std::max(face.width, face.height) + search;
    box.extend(Eigen::Vector3d(face.plane.origin - Eigen::Vector3d::Constant(reach)));
    box.extend(Eigen::Vector3d(face.plane.origin + Eigen::Vector3d::Constant(reach)));
  }
  return box;
}

/// Panels that are all alike do not say which is which.
WhichPanels which_panels(const std::vector<PanelFace>& faces, const ScanTiles& tiles, const Sample& near) {
  constexpr const char* settled =
      "the 'registration' by surveyed points settles it, or 'place_confirmed' of dense.import, when somebody has seen "
      "it";
  const ScanPlaces places = places_of_scan(faces, tiles, near.points());
  if (!places.better.empty())
    return {
        fmt::format("the scan has points on {} of {} panels, and on {} if it is moved by {}: what it shows may be the "
                    "panels beside those that they are taken for; {}",
                    places.panels, faces.size(), places.better[0].panels, places.better[0].words, settled),
        ""};
  if (!places.equal.empty())
    return {"",
            fmt::format("Nothing in the scan confirms which panel is which: moved by {} it has points on as many ({} "
                        "of {}); {}.",
                        places.equal[0].words, places.panels, faces.size(), settled)};
  return {};
}

/// Refuses coordinates that are written in coarser steps than the scanner's noise: all points of a wall then lie on a
/// few of them, and it looks flat whatever it is.
void check_steps(const std::vector<PanelFace>& faces, const ScanTiles& tiles, const ToFaces& to_faces,
                 const Eigen::Vector3d& steps, double noise) {
  for (const ScanTile& tile : tiles.tiles()) {
    if (tile.points == 0) continue;
    const Eigen::Vector3d out = to_faces.frame.rotation.conjugate() * faces[tile.face].plane.axes.col(2);
    const double across = out.cwiseProduct(steps).norm() * to_faces.unit * to_faces.scale;
    if (across > noise)
      throw std::runtime_error(
          "across the face of " + faces[tile.face].id + " the coordinates are written in steps of " +
          in_millimetres(across) + ", 'noise' is " + in_millimetres(noise) +
          ": flatness and place would be those of the steps; write doubles, more decimals or a finer "
          "scale of LAS, or shift the cloud to smaller coordinates before it is written");
  }
}

ScanPlace stated_place(double place_sigma, double turn_sigma, const Eigen::Vector3d& middle) {
  ScanPlace place;
  place.pivot = middle, place.covariance = Eigen::MatrixXd::Zero(6, 6);
  place.covariance.diagonal().head<3>().setConstant(turn_sigma * turn_sigma);
  place.covariance.diagonal().tail<3>().setConstant(place_sigma * place_sigma);
  return place;
}

/// A scanner that was set up on the survey's control is in the survey's frame, and not in the one that the anchors were
/// brought to. Empty where these are one, or so far apart that the scan would not lie on the panels.
std::string other_frame(const TransformT& anchors, const Eigen::Vector3d& middle) {
  constexpr double kSame = 1e-4, kFarthest = 1;  // [m]
  const double scale = std::isfinite(anchors.scale) ? anchors.scale : 1;
  const double moved =
      (scale * (anchors.to_from_from.rotation * middle) + anchors.to_from_from.translation - middle).norm();
  if (!(moved > kSame && moved < kFarthest)) return {};
  return fmt::format(
      "The anchors were moved by {:.1f} mm to the design, the scan was not: if it was registered to the control of the "
      "survey, panels and anchors are judged in two frames, and depth.in.registration=frames.transform brings it "
      "along.",
      1e3 * moved);
}

/// What the scan's place is off by: from the registration, from what the user states, and, where anything is stated,
/// also of each scan by itself (`apart`), from the steps that all coordinates of the file are written in.
std::vector<ScanPlace> places_of(const std::optional<TransformT>& registration, double place_sigma, double turn_sigma,
                                 bool apart, const Eigen::Vector3d& middle, const Eigen::Matrix3d& of_steps) {
  std::vector<ScanPlace> places;
  if (registration && !registration->covariance.empty()) {
    ScanPlace place;
    place.pivot = registration->to_from_from.translation;
    const size_t rows = registration->covariance.size() == packed_size(7) ? 7 : 6;
    place.covariance = unpack_symmetric(registration->covariance, rows, "the registration");
    if (rows == 7) place.covariance.row(6) /= registration->scale, place.covariance.col(6) /= registration->scale;
    places.push_back(place);
  }
  const bool steps_alone = places.empty() && apart && !of_steps.isZero(0);
  if (place_sigma > 0 || turn_sigma > 0 || steps_alone) places.push_back(stated_place(place_sigma, turn_sigma, middle));
  if (!places.empty()) places.front().covariance.block<3, 3>(3, 3) += of_steps;
  return places;
}

Eigen::Vector3d middle_of(const std::vector<PanelFace>& faces) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const PanelFace& face : faces) middle += face.plane.origin / static_cast<double>(faces.size());
  return middle;
}

/// Columns: the errors that all scans share, then those of each scan by itself, which are 0 for the others.
Eigen::MatrixXd factor_of_all(const std::vector<ScanPlace>& common, const std::optional<ScanPlace>& own, size_t scan,
                              int rank, const Eigen::Vector3d& centre) {
  Eigen::MatrixXd factor = Eigen::MatrixXd::Zero(6, rank);
  Eigen::Index column = 0;
  for (const ScanPlace& place : common) {
    const auto part = factor_of(place, centre);
    factor.middleCols(column, part.cols()) = part;
    column += part.cols();
  }
  if (own) factor.middleCols(column + 6 * static_cast<Eigen::Index>(scan), 6) = factor_of(*own, centre);
  return factor;
}

std::string file_name(size_t tile) { return fmt::format("{:06}.points", tile); }

}  // namespace

std::string ImportCloud::cloud_path(Context& context) const {
  if (!by_reference && file->path.empty())
    throw std::runtime_error("there is no cloud: set 'file' to its path, or connect 'scan'");
  if (!by_reference) return file->path;
  if (!file->path.empty())
    throw std::runtime_error(
        "'file' is set and 'scan' is connected: which of them is the cloud? Take one of them away");
  const FileT given = by_reference.unpack();
  if (given.uri.empty())
    throw std::runtime_error("input 'scan' holds the bytes of " + given.name +
                             "; a cloud is taken by reference: set 'file' to its path");
  return context.resolve(given.uri);
}

void ImportCloud::run(Context& context) {
  const std::string path = cloud_path(context);
  if (!design && !points)
    throw std::runtime_error("connect 'design', whose panels are measured, or 'points', whose plane is");
  const auto stations = stations_of(*seen_from);
  Faces faces = design ? faces_of(design.unpack(), stations) : face_through(points.unpack(), stations, *margin);
  leave_out_seen_from_behind(faces, stations);
  for (const auto& what : faces.left_out) context.warn("not measured: " + in_words(what));
  if (faces.faces.empty())
    throw std::runtime_error("the design has no panel with a face that could be measured" +
                             (faces.left_out.empty() ? "" : " (" + in_words(faces.left_out.front()) + ")") +
                             "; mark the panels in it, or connect 'points'");
  ToFaces to_faces;
  std::optional<TransformT> fit;
  if (registration) {
    fit = registration.unpack();
    if (fit->plan_only)
      throw std::runtime_error(
          "the registration scales the plan only, as a map does; a scan needs one that scales heights too, or none");
    to_faces.frame = fit->to_from_from, to_faces.scale = std::isfinite(fit->scale) ? fit->scale : 1;
  }
  const cloud::CloudSummary before = cloud::look_at_cloud(path);
  const UnitOfFile chosen = unit_of(before, *unit, context);
  to_faces.unit = chosen.metres;

  const auto folder = files.make_folder();
  // Further than `search` by its noise: a panel there would lose the points beyond it, and be pulled inside.
  const bool apart = *scan_sigma > 0 || *scan_turn_sigma > 0;
  size_t width = 0;  // of the numbering: tiles of a scan
  ScanTiles tiles(
      faces.faces, *search + 6 * *noise, *tile,
      [&](size_t t, size_t scan, const std::vector<MeasuredPoint>& some) {
        MeasuredTile part;
        part.points = some;
        append_points(part, folder.path + "/" + file_name(scan * width + t));
      },
      *beside);
  width = tiles.tiles().size();
  context.reserve_memory(tiles.tiles().size() * 1024 * sizeof(MeasuredPoint) + (8u << 20));
  Sample sample, near;  // of the whole, in the file's coordinates; around the faces, in theirs
  const Eigen::AlignedBox3d beside_faces = around(faces.faces, *search);
  const cloud::CloudSummary read =
      cloud::read_cloud(path, [&](const std::vector<Eigen::Vector3d>& some, double done, int scan) {
        if (context.cancelled()) throw Stopped();
        context.progress(done, "points");
        for (const auto& point : some) {
          sample.add(point);
          const Eigen::Vector3d placed = to_faces(point);
          if (beside_faces.contains(placed)) near.add(placed);
          tiles.add(placed, *noise, apart ? static_cast<size_t>(scan) : 0);
        }
      });
  tiles.flush();
  context.info(read.format + ": " + std::to_string(read.points) + " points");
  if (read.without_place > 0)
    context.warn(std::to_string(read.without_place) + " points have no coordinates (NaN) and are left out");
  if (read.withheld > 0)
    context.info(std::to_string(read.withheld) + " points are withheld or noise, as the file says, and are left out");
  if (read.without_pose > 0)
    context.warn(fmt::format(
        "{} of the {} scans in the file have no pose, the others do: their points are taken as they are written, and "
        "in "
        "the scanner's own frame they would lie elsewhere, or on other panels; export them registered, or without them",
        read.without_pose, read.scans));
  if (read.scans > 1 && !apart)
    context.warn(
        "there are " + std::to_string(read.scans) +
        " scans in the file, which are held to err alike, as one: what they differ by is in no standard deviation; "
        "'scan_sigma' and 'scan_turn_sigma' state what each is off by itself");
  if (read.either_foot && *unit == "from_file")
    context.warn(
        "the file says feet and not which: they are taken for international ones (0.3048 m); in US survey feet its "
        "points would lie up to " +
        in_millimetres(feet_apart(read.low, read.high)) + " from there; 'unit' says which, ft or us_ft");
  check_place(faces.faces, tiles, sample, to_faces, chosen.stated, read);
  check_steps(faces.faces, tiles, to_faces, read.resolution, *noise);
  WhichPanels which;
  if (!registration && !*place_confirmed) which = which_panels(faces.faces, tiles, near);
  if (!which.doubt.empty()) context.warn("nothing will be judged: " + which.doubt);
  if (!which.unconfirmed.empty()) context.warn(which.unconfirmed);
  if (anchors && !registration) which.other_frame = other_frame(anchors.unpack(), middle_of(faces.faces));
  if (!which.other_frame.empty()) context.warn(which.other_frame);
  if (const std::string words = words_of_guessed(faces.guessed); !words.empty()) context.warn(words);
  const Eigen::Matrix3d turn = to_faces.frame.rotation.toRotationMatrix();
  const Eigen::Vector3d steps = to_faces.unit * to_faces.scale * read.resolution;
  const Eigen::Matrix3d of_steps = turn * (steps.cwiseAbs2() / 12).asDiagonal() * turn.transpose();
  const Eigen::Vector3d middle = middle_of(faces.faces);
  std::optional<ScanPlace> own;
  if (apart) own = stated_place(*scan_sigma, *scan_turn_sigma, middle);
  commit(context, faces, tiles, places_of(fit, *place_sigma, *turn_sigma, apart, middle, of_steps), own, which,
         folder.path, folder.uri);
}

void ImportCloud::commit(Context& context, const Faces& faces, const ScanTiles& tiles,
                         const std::vector<ScanPlace>& common, const std::optional<ScanPlace>& own,
                         const WhichPanels& which, const std::string& folder, const std::string& uri) const {
  SurfacePointsT artifact;
  artifact.place_doubt = which.doubt;
  for (const std::string& open : {which.unconfirmed, which.other_frame})
    if (!open.empty()) artifact.warnings.push_back(open);
  if (const std::string words = words_of_guessed(faces.guessed); !words.empty()) artifact.warnings.push_back(words);
  artifact.source = "scan", artifact.left_out = copies_of(faces.left_out), artifact.search = *search;
  artifact.beside = *beside;
  for (const ScanPlace& place : common) artifact.rank += static_cast<int>(place.covariance.rows());
  if (own) artifact.rank += 6 * static_cast<int>(tiles.scans());
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
    for (size_t scan = 0; scan < tiles.scans(); ++scan) {
      const std::uint64_t points_here = tiles.points_of(t, scan);
      if (points_here == 0) continue;
      const std::string name = file_name(scan * tiles.tiles().size() + t);
      auto entry = std::make_unique<SurfaceTileT>();
      entry->sha256 = context.digest(folder + "/" + name), entry->uri = "sha256:" + entry->sha256 + "/" + name;
      entry->points = points_here, entry->centre = from.centre;
      entry->factor = row_by_row(factor_of_all(common, own, scan, artifact.rank, from.centre));
      auto listed = std::make_unique<FolderEntryT>();
      listed->path = name, listed->sha256 = entry->sha256, listed->size = points_here * sizeof(MeasuredPoint);
      listing.files.push_back(std::move(listed));
      artifact.tiles.push_back(std::move(entry));
    }
    artifact.measured += static_cast<std::int64_t>(from.points);
    const PanelFace& face = faces.faces[from.face];
    covered += face.width * face.height / (std::ceil(face.width / *tile) * std::ceil(face.height / *tile));
  }
  std::sort(listing.files.begin(), listing.files.end(), [](const auto& a, const auto& b) { return a->path < b->path; });
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
