#include "surface_artifacts.hpp"

#include <fmt/core.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <stdexcept>

#include "geometry/packed_symmetric.hpp"

namespace plumbline::surface {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
static_assert(sizeof(MeasuredPoint) == 16, "tiles are written as they lie in memory");

Eigen::MatrixXd matrix_of(const std::vector<double>& values, Eigen::Index rows, Eigen::Index columns,
                          const std::string& what) {
  if (static_cast<Eigen::Index>(values.size()) != rows * columns)
    throw std::runtime_error(what + " has " + std::to_string(values.size()) + " values, expected " +
                             std::to_string(rows * columns));
  return Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(values.data(), rows,
                                                                                                  columns);
}

std::string number(fmt::format_string<double&> format, double value) {
  return std::isfinite(value) ? fmt::format(format, value) : "";
}

}  // namespace

std::vector<double> row_by_row(const Eigen::Ref<const Eigen::MatrixXd>& matrix) {
  std::vector<double> values;
  for (Eigen::Index r = 0; r < matrix.rows(); ++r)
    for (Eigen::Index c = 0; c < matrix.cols(); ++c) values.push_back(matrix(r, c));
  return values;
}

std::unique_ptr<SurfaceFaceT> describe(const PanelFace& face, const std::string& guid) {
  auto result = std::make_unique<SurfaceFaceT>();
  result->id = face.id, result->guid = guid;
  result->origin = face.plane.origin;
  result->right = face.plane.axes.col(0), result->up = face.plane.axes.col(1), result->out = face.plane.axes.col(2);
  result->width = face.width, result->height = face.height, result->thickness = face.thickness;
  return result;
}

PanelFace face_of(const SurfaceFaceT& face) {
  PanelFace result;
  result.id = face.id;
  result.plane.origin = face.origin;
  result.plane.axes << face.right, face.up, face.out;
  if ((result.plane.axes.transpose() * result.plane.axes - Eigen::Matrix3d::Identity()).norm() > 1e-6 ||
      result.plane.axes.determinant() < 0)
    throw std::runtime_error("the axes of face '" + face.id + "' are not right, up and out of a right-handed frame");
  result.width = face.width, result.height = face.height, result.thickness = face.thickness;
  return result;
}

void append_points(const MeasuredTile& tile, const std::string& path) {
  std::ofstream stream(path, std::ios::binary | std::ios::app);
  stream.write(reinterpret_cast<const char*>(tile.points.data()),
               static_cast<std::streamsize>(tile.points.size() * sizeof(MeasuredPoint)));
  stream.close();
  if (!stream) throw std::runtime_error("cannot write " + path + "; is the disk full?");
}

MeasuredTile read_tile(const SurfaceTileT& tile, int rank, const std::string& path) {
  MeasuredTile result;
  result.centre = tile.centre;
  result.factor = matrix_of(tile.factor, 6, rank, "the factor of a tile");
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error || size != tile.points * sizeof(MeasuredPoint))
    throw std::runtime_error(path + " has " + std::to_string(error ? 0 : size) + " bytes, expected " +
                             std::to_string(tile.points * sizeof(MeasuredPoint)) + " for " +
                             std::to_string(tile.points) + " points");
  result.points.resize(tile.points);
  std::ifstream stream(path, std::ios::binary);
  stream.read(reinterpret_cast<char*>(result.points.data()), static_cast<std::streamsize>(size));
  if (!stream) throw std::runtime_error("cannot read " + path);
  return result;
}

std::unique_ptr<PanelSurfaceFiguresT> describe(const PanelSurface& panel, const PanelFace& face,
                                               const std::string& guid, int rank) {
  auto result = std::make_unique<PanelSurfaceFiguresT>();
  result->face = describe(face, guid);
  result->not_measured = panel.not_measured;
  result->points = panel.points, result->outliers = panel.outliers;
  result->coverage = panel.coverage;
  result->spacing = panel.spacing, result->covering_cell = panel.covering_cell;
  result->tilt = Eigen::Vector2d::Constant(kNan);
  result->form = result->form_sigma = Eigen::Vector3d::Constant(kNan);
  if (!panel.not_measured.empty()) return result;
  result->rms = panel.rms, result->variance_factor = panel.variance_factor;
  result->offset = panel.plane(0), result->tilt = panel.plane.tail<2>();
  result->covariance = pack_symmetric(panel.plane_covariance());
  result->random_covariance = pack_symmetric(panel.plane_random);
  result->form = panel.form.tail<3>();
  const Eigen::Matrix<double, 6, 6> form = panel.form_covariance();
  result->form_sigma = form.diagonal().tail<3>().cwiseSqrt();
  result->coefficients.assign(panel.form.data(), panel.form.data() + 6);
  result->coefficients_random = pack_symmetric(panel.form_random);
  Eigen::MatrixXd factor = Eigen::MatrixXd::Zero(6, rank);
  factor.leftCols(panel.form_factor.cols()) = panel.form_factor;
  result->coefficients_factor = row_by_row(factor);
  result->edge_misfit.assign(panel.edge_misfit.data(), panel.edge_misfit.data() + 4);
  result->hidden = panel.hidden;
  for (const Eigen::Vector2d& middle : panel.before)
    result->before.insert(result->before.end(), {middle.x(), middle.y()});
  for (const Gap& gap : panel.flatness) {
    auto entry = std::make_unique<SurfaceGapT>();
    entry->length = gap.length, entry->positions = gap.positions, entry->place = gap.place;
    if (gap.positions > 0)
      entry->gap = gap.gap, entry->sigma = gap.sigma, entry->noise_mean = gap.noise_mean,
      entry->noise_sigma = gap.noise_sigma, entry->with_outlying = gap.with_outlying;
    result->flatness.push_back(std::move(entry));
  }
  return result;
}

PanelSurface panel_of(const PanelSurfaceFiguresT& figures, int rank) {
  PanelSurface panel;
  panel.id = figures.face->id, panel.not_measured = figures.not_measured;
  if (!panel.not_measured.empty()) return panel;
  panel.form = matrix_of(figures.coefficients, 6, 1, "panel '" + panel.id + "'");
  panel.form_random = unpack_symmetric(figures.coefficients_random, 6, "panel '" + panel.id + "'");
  panel.form_factor =
      matrix_of(figures.coefficients_factor, 6, rank, "the systematic errors of panel '" + panel.id + "'");
  panel.half_width = 0.5 * figures.face->width, panel.half_height = 0.5 * figures.face->height;
  if (std::isfinite(figures.cell)) panel.cell = figures.cell;
  for (size_t i = 0; i + 1 < figures.before.size(); i += 2)
    panel.before.emplace_back(figures.before[i], figures.before[i + 1]);
  if (!figures.edge_misfit.empty())
    panel.edge_misfit = matrix_of(figures.edge_misfit, 4, 1, "the misfit at the edges of panel '" + panel.id + "'");
  return panel;
}

std::unique_ptr<JointFiguresT> describe(const MeasuredJoint& measured, const Joint& joint) {
  auto result = std::make_unique<JointFiguresT>();
  result->first = joint.a, result->second = joint.b, result->upright = joint.upright;
  result->first_panel = static_cast<int>(joint.face_a), result->second_panel = static_cast<int>(joint.face_b);
  result->origin = joint.plane.origin, result->along = joint.plane.axes.col(1);
  result->nominal_width = joint.width, result->length = joint.length;
  result->not_measured = measured.not_measured, result->looked_at = measured.stations_looked_at;
  result->closed = measured.closed, result->nominal_step = joint.step;
  for (const JointStation& station : measured.stations) {
    auto place = std::make_unique<JointPlaceT>();
    place->along = station.along, place->width = station.width, place->width_sigma = station.width_sigma;
    place->step = station.step, place->step_sigma = station.step_sigma, place->views = station.views;
    place->width_random = station.width_random;
    place->shift = station.shift, place->shift_sigma = station.shift_sigma;
    place->width_by_edge = {station.width_by_edge.x(), station.width_by_edge.y()};
    result->places.push_back(std::move(place));
  }
  if (measured.stations.empty()) return result;
  result->narrowest = static_cast<int>(measured.narrowest), result->widest = static_cast<int>(measured.widest);
  result->largest_step = static_cast<int>(measured.largest_step);
  result->largest_shift = static_cast<int>(measured.largest_shift);
  return result;
}

std::unique_ptr<BesidePlaceT> describe(const CommonPlace& place) {
  auto result = std::make_unique<BesidePlaceT>();
  const auto of = [](const CommonOffset& offset) { return offset.stands_out() ? offset.mean : std::nan(""); };
  result->facade = place.facade, result->out = of(place.out), result->right = of(place.right),
  result->up = of(place.up);
  return result;
}

void add_pairs_without_joint(const std::vector<PanelFace>& faces, double widest, SurfacesT& surfaces) {
  for (const PairWithoutJoint& pair : pairs_without_joint(faces, widest)) {
    auto joint = std::make_unique<JointFiguresT>();
    joint->first = faces[pair.a].id, joint->second = faces[pair.b].id;
    joint->first_panel = static_cast<int>(pair.a), joint->second_panel = static_cast<int>(pair.b);
    joint->upright = pair.upright, joint->along = pair.along, joint->origin = pair.origin;
    joint->nominal_width = pair.width, joint->not_measured = pair.why;
    surfaces.joints.push_back(std::move(joint));
  }
}

void add_common_errors(const Eigen::MatrixXd& factor, SurfacesT& surfaces) {
  Eigen::Index row = 0;
  surfaces.joint_rank = static_cast<int>(factor.cols());
  for (auto& joint : surfaces.joints)
    for (auto& place : joint->places) place->width_factor = row_by_row(factor.row(row++));
}

std::string csv_text(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string result = "\"";
  for (char c : text) result += c == '"' ? "\"\"" : std::string(1, c);
  return result + "\"";
}

std::string panels_table(const SurfacesT& surfaces) {
  std::string text =
      "panel,not_measured,points,coverage,offset_mm,offset_sigma_mm,tilt_right_mm_per_m,tilt_right_sigma,tilt_up_mm_"
      "per_m,"
      "tilt_up_sigma,bow_across_mm,bow_across_sigma,bow_up_mm,bow_up_sigma,twist_mm,twist_sigma,rms_mm,straightedge_mm,"
      "gap_mm,gap_sigma_mm,gap_of_noise_mm\n";
  for (const auto& panel : surfaces.panels) {
    const auto mm = [](double value) { return number("{:.3f}", 1e3 * value) + ","; };
    text += csv_text(panel->face->id) + "," + csv_text(panel->not_measured) + "," + std::to_string(panel->points) +
            "," + number("{:.3f}", panel->coverage) + ",";
    if (!panel->not_measured.empty()) {
      text += ",,,,,,,,,,,,,,,,\n";
      continue;
    }
    const Eigen::MatrixXd covariance = unpack_symmetric(panel->covariance, 3, "a panel");
    const Eigen::Vector3d sigma = covariance.diagonal().cwiseSqrt();
    text += mm(panel->offset) + mm(sigma(0)) + mm(panel->tilt(0)) + mm(sigma(1)) + mm(panel->tilt(1)) + mm(sigma(2));
    for (int c = 0; c < 3; ++c) text += mm(panel->form(c)) + mm(panel->form_sigma(c));
    text += mm(panel->rms);
    const SurfaceGapT* longest = nullptr;
    for (const auto& gap : panel->flatness)
      if (gap->positions > 0) longest = gap.get();
    text += longest ? number("{:.0f}", 1e3 * longest->length) + "," + mm(longest->gap) +
                          number("{:.3f}", 1e3 * longest->sigma) + "," + number("{:.3f}", 1e3 * longest->noise_mean)
                    : ",,,";
    text += "\n";
  }
  return text;
}

std::string joints_table(const SurfacesT& surfaces) {
  std::string text =
      "first,second,runs,not_measured,nominal_mm,places,looked_at,narrowest_mm,narrowest_sigma,narrowest_at_mm,widest_"
      "mm,"
      "widest_sigma,widest_at_mm,step_mm,step_sigma,step_at_mm,shift_mm,shift_sigma,shift_at_mm\n";
  for (const auto& joint : surfaces.joints) {
    text += csv_text(joint->first) + "," + csv_text(joint->second) + "," + (joint->upright ? "up" : "across") + "," +
            csv_text(joint->not_measured) + "," + number("{:.2f}", 1e3 * joint->nominal_width) + "," +
            std::to_string(joint->places.size()) + "," + std::to_string(joint->looked_at);
    const auto place = [&](int index, double JointPlaceT::*value, double JointPlaceT::*sigma) {
      if (index < 0) return std::string(",,,");
      const JointPlaceT& at = *joint->places[index];
      return "," + number("{:.3f}", 1e3 * at.*value) + "," + number("{:.3f}", 1e3 * at.*sigma) + "," +
             number("{:.0f}", 1e3 * at.along);
    };
    text += place(joint->narrowest, &JointPlaceT::width, &JointPlaceT::width_sigma) +
            place(joint->widest, &JointPlaceT::width, &JointPlaceT::width_sigma) +
            place(joint->largest_step, &JointPlaceT::step, &JointPlaceT::step_sigma) +
            place(joint->largest_shift, &JointPlaceT::shift, &JointPlaceT::shift_sigma) + "\n";
  }
  return text;
}

}  // namespace plumbline::surface
