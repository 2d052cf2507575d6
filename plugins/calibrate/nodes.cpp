// calibrate.board: the interior orientation of a camera from photographs of a board.
#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "artifacts/board_points.hpp"
#include "artifacts/camera.hpp"
#include "artifacts/file.hpp"
#include "geometry/packed_symmetric.hpp"
#include "markers/calibration.hpp"
#include "markers/camera_files.hpp"
#include "plumbline/node.hpp"

namespace {

using namespace plumbline;
using namespace plumbline::markers;
using Json = nlohmann::ordered_json;

constexpr int columns = 25, rows = 19;  // of the maps over the image

FileT file_of(const std::string& name, const std::string& media_type, const std::string& text) {
  FileT file;
  file.name = name, file.media_type = media_type;
  file.content.assign(text.begin(), text.end());
  return file;
}

double median(std::vector<double> values) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  if (values.empty()) return std::nan("");
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

/// The photographs that take part, and why others don't.
struct Selection {
  std::vector<CalibrationView> views;
  std::vector<std::pair<std::string, std::string>> left_out;  ///< path, reason
  int width = 0, height = 0;
  std::string board;
};

Selection select(const std::vector<BoardPointsT>& photographs) {
  Selection result;
  std::map<std::pair<int, int>, int> sizes;
  for (const auto& p : photographs)
    if (p.problem.empty()) ++sizes[{p.width, p.height}];
  int most = 0;
  for (const auto& [size, number] : sizes)
    if (number > most) most = number, result.width = size.first, result.height = size.second;
  std::map<std::string, std::string> by_content;
  for (const auto& p : photographs) {
    result.board = p.board;
    const auto [same, is_new] = by_content.emplace(p.sha256, p.path);
    if (!p.problem.empty()) {
      result.left_out.emplace_back(p.path, p.problem);
    } else if (p.width != result.width || p.height != result.height) {
      const bool turned = p.width == result.height && p.height == result.width;
      result.left_out.emplace_back(p.path,
                                   "has " + std::to_string(p.width) + " x " + std::to_string(p.height) +
                                       " pixels where the others have " + std::to_string(result.width) + " x " +
                                       std::to_string(result.height) +
                                       (turned ? ": a program turned its pixels; use the file as the camera wrote it"
                                               : "; one calibration is for one size"));
    } else if (!p.sha256.empty() && !is_new) {
      result.left_out.emplace_back(p.path, "is the same file as " + same->second);
    } else {
      CalibrationView view;
      view.path = p.path;
      for (const auto& point : p.points)
        view.points.push_back({point->board, point->pixel, point->sigma > 0 ? point->sigma : 0.1});
      result.views.push_back(std::move(view));
    }
  }
  return result;
}

struct Halves {
  double difference = std::nan(""), expected = std::nan("");  ///< medians over the image [px]
};

/// Every other photograph against the rest: with the right model they differ by about √(u₀² + u₁²).
Halves compare_halves(const Selection& selection, const CalibrationOptions& options) {
  std::vector<CalibrationView> halves[2];
  for (size_t i = 0; i < selection.views.size(); ++i) halves[i % 2].push_back(selection.views[i]);
  Halves result;
  if (halves[1].size() < 4) return result;
  try {
    const Calibration a = calibrate(halves[0], selection.width, selection.height, options),
                      b = calibrate(halves[1], selection.width, selection.height, options);
    const auto ua = projection_uncertainty(a.camera, a.covariance, columns, rows),
               ub = projection_uncertainty(b.camera, b.covariance, columns, rows);
    std::vector<double> expected;
    for (size_t i = 0; i < ua.size(); ++i) expected.push_back(std::hypot(ua[i], ub[i]));
    result.difference = median(projection_difference(a.camera, b.camera, columns, rows));
    result.expected = median(expected);
  } catch (const std::runtime_error&) {
    // Half of the photographs may be too few; the page then says that there is no such check.
  }
  return result;
}

Json grid_json(const std::vector<double>& values) {
  Json table = Json::array();
  for (int row = 0; row < rows; ++row) {
    Json line = Json::array();
    for (int column = 0; column < columns; ++column)
      line.push_back(values[static_cast<size_t>(row * columns + column)]);
    table.push_back(line);
  }
  return table;
}

Json images_json(const Selection& selection, const Calibration& c) {
  Json images = Json::array();
  for (const auto& view : c.views) {
    const CalibrationView& given = selection.views[static_cast<size_t>(view.view)];
    double left = 1e9, right = -1e9, top = 1e9, bottom = -1e9;
    Json points = Json::array();
    for (size_t k = 0; k < view.points.size(); ++k) {
      const Eigen::Vector2d& p = given.points[static_cast<size_t>(view.points[k])].pixel;
      left = std::min(left, p.x()), right = std::max(right, p.x()), top = std::min(top, p.y()),
      bottom = std::max(bottom, p.y());
      points.push_back({p.x(), p.y(), view.residuals[k].x(), view.residuals[k].y()});
    }
    const double covered = view.points.empty() ? 0
                                               : (right - left) * (bottom - top) /
                                                     (static_cast<double>(selection.width) * selection.height);
    const RigidTransform& t = view.cam_from_board;
    images.push_back({{"path", given.path},
                      {"used", true},
                      {"reason", ""},
                      {"points", view.points.size()},
                      {"rms_px", view.rms},
                      {"coverage", covered},
                      {"tilt_deg", view.tilt * 180 / M_PI},
                      {"rotation", {t.rotation.w(), t.rotation.x(), t.rotation.y(), t.rotation.z()}},
                      {"translation", {t.translation.x(), t.translation.y(), t.translation.z()}},
                      {"residuals", points}});
  }
  for (const auto& [path, reason] : selection.left_out)
    images.push_back({{"path", path}, {"used", false}, {"reason", reason}});
  return images;
}

std::vector<std::string> warnings_of(const Selection& selection, const Calibration& c, const Halves& halves) {
  std::vector<std::string> warnings;
  char text[400];
  if (halves.expected > 0 && halves.difference > 2.5 * halves.expected) {
    std::snprintf(
        text, sizeof text,
        "Two halves of the photographs give cameras that differ by %.3f px (median over the image) where their "
        "uncertainties make %.3f px expected: the model does not fit this lens or this board, and the standard "
        "deviations are too small by a factor of about %.1f",
        halves.difference, halves.expected, halves.difference / halves.expected);
    warnings.emplace_back(text);
  }
  double tilted = 0;
  for (const auto& view : c.views) tilted += view.tilt > 20 * M_PI / 180;
  if (tilted < 0.25 * static_cast<double>(c.views.size()))
    warnings.emplace_back(
        "Most photographs look straight at the board: the principal distance then hangs on the distance. Tilt "
        "the board by 30 to 50 degrees in half of them");
  if (c.held_flat)
    warnings.emplace_back(
        "The photographs are too much alike to tell a bend of the board from the lens: the board is taken as flat, and "
        "the standard deviations know nothing of a bend");
  // Coverage in a 4 × 4 grid of the image.
  std::array<int, 16> cells{};
  for (const auto& view : c.views)
    for (const int k : view.points) {
      const Eigen::Vector2d& p = selection.views[static_cast<size_t>(view.view)].points[static_cast<size_t>(k)].pixel;
      const int x = std::clamp(static_cast<int>(4 * p.x() / selection.width), 0, 3),
                y = std::clamp(static_cast<int>(4 * p.y() / selection.height), 0, 3);
      ++cells[static_cast<size_t>(4 * y + x)];
    }
  const auto empty = std::count_if(cells.begin(), cells.end(), [](int n) { return n < 5; });
  if (empty > 0) {
    std::snprintf(text, sizeof text,
                  "%d of 16 parts of the image hold hardly any point: the distortion there is a guess. Bring the board "
                  "into every corner",
                  static_cast<int>(empty));
    warnings.emplace_back(text);
  }
  if (c.bend_x_sigma > 0 && std::max(std::abs(c.bend_x) / c.bend_x_sigma, std::abs(c.bend_y) / c.bend_y_sigma) > 4) {
    std::snprintf(text, sizeof text,
                  "The board is bent: its middle stands %.2f mm (along x) and %.2f mm (along y) before its edges; this "
                  "is taken into account",
                  1e3 * c.bend_x, 1e3 * c.bend_y);
    warnings.emplace_back(text);
  }
  return warnings;
}

Json calibration_json(const Selection& selection, const Calibration& c, const Halves& halves) {
  Json parameters, sigmas, correlations = Json::array();
  const auto values = c.camera.parameters();
  for (size_t i = 0; i < values.size(); ++i) {
    const Eigen::Index k = static_cast<Eigen::Index>(i);
    parameters[BrownCamera::parameter_names[i]] = values[i];
    sigmas[BrownCamera::parameter_names[i]] = std::sqrt(c.covariance(k, k));
    Json row = Json::array();
    for (Eigen::Index j = 0; j < 9; ++j) {
      const double scale = std::sqrt(c.covariance(k, k) * c.covariance(j, j));
      row.push_back(scale > 0 ? c.covariance(k, j) / scale : (k == j ? 1.0 : 0.0));
    }
    correlations.push_back(row);
  }
  Json rejected = Json::array(), warnings = Json::array(), covariance = Json::array();
  for (const auto& text : c.rejected) rejected.push_back(text);
  for (const auto& text : warnings_of(selection, c, halves)) warnings.push_back(text);
  for (Eigen::Index i = 0; i < 9; ++i)
    for (Eigen::Index j = 0; j <= i; ++j) covariance.push_back(c.covariance(i, j));
  return {{"board", selection.board},
          {"width", selection.width},
          {"height", selection.height},
          {"model", "Brown, as OpenCV: fx, fy, cx, cy, k1, k2, k3, p1, p2; the centre of the top-left pixel is (0, 0)"},
          {"parameters", parameters},
          {"sigmas", sigmas},
          {"parameter_order",
           std::vector<std::string>(BrownCamera::parameter_names.begin(), BrownCamera::parameter_names.end())},
          {"correlations", correlations},
          {"covariance_lower_triangle", covariance},
          {"rms_px", c.rms},
          {"sigma_px", c.sigma},
          {"observations", c.observations},
          {"unknowns", c.unknowns},
          {"degrees_of_freedom", c.degrees_of_freedom},
          {"board_bend_m", {c.bend_x, c.bend_y}},
          {"board_bend_sigma_m", {c.bend_x_sigma, c.bend_y_sigma}},
          {"halves", {{"median_difference_px", halves.difference}, {"median_expected_px", halves.expected}}},
          {"projection_uncertainty_px", grid_json(projection_uncertainty(c.camera, c.covariance, columns, rows))},
          {"warnings", warnings},
          {"rejected", rejected},
          {"images", images_json(selection, c)}};
}

struct CalibrateBoard : Node {
  static constexpr Info info{
      "calibrate.board", "", 1,
      "Calibrates a camera on photographs of a board: parameters, covariance, uncertainty over the image"};
  List<BoardPoints> points{"points", "the board's points in each photograph"};
  Param<std::vector<std::string>> free{
      "free", {"fx", "fy", "cx", "cy", "k1", "k2", "k3", "p1", "p2"}, "parameters to estimate"};
  Param<double> bend_sigma{
      "bend_sigma", 0.001, "m", between(0, 1),
      "prior standard deviation of how far the board bulges, along x and along y; 0 holds it flat"};
  Param<double> reject_above{"reject_above", 5.0, "1", at_least(0),
                             "points whose residual is this many times the median are left out; 0 keeps all"};
  Param<std::string> id{"id", "camera", "name of the camera in its file"};
  Out<Camera> camera{"camera", "the interior orientation with its full covariance"};
  Out<File> yaml{"yaml", "camera.yaml, as campaign folders take it"};
  Out<File> json{"json", "calibration.json: parameters, sigmas, correlations, rms_px, images[]"};

  void run(Context& context) override {
    std::vector<BoardPointsT> photographs;
    for (size_t i = 0; i < points.size(); ++i) photographs.push_back(points.unpack(i));
    const Selection selection = select(photographs);
    if (selection.views.size() < 3 && !selection.left_out.empty())
      throw std::runtime_error("the board was found in " + std::to_string(selection.views.size()) + " of " +
                               std::to_string(photographs.size()) + " photographs; needed are 3. " +
                               selection.left_out.front().first + ": " + selection.left_out.front().second);
    CalibrationOptions options;
    options.free = *free, options.bend_sigma = *bend_sigma, options.reject_above = *reject_above;
    const Calibration c = calibrate(selection.views, selection.width, selection.height, options);
    const Halves halves = compare_halves(selection, options);
    for (const auto& text : warnings_of(selection, c, halves)) context.warn(text);
    context.metric("rms", c.rms, "px");
    CameraT artifact;
    artifact.id = *id, artifact.width = selection.width, artifact.height = selection.height;
    const auto values = c.camera.parameters();
    artifact.parameters.assign(values.begin(), values.end());
    artifact.covariance = pack_symmetric(c.covariance);
    artifact.source = "calibration on a " + selection.board;
    camera.commit(artifact);
    yaml.commit(file_of("camera.yaml", "application/yaml", camera_yaml({*id, c.camera, c.covariance, ""})));
    json.commit(
        file_of("calibration.json", "application/json",
                calibration_json(selection, c, halves).dump(1, ' ', false, Json::error_handler_t::replace) + "\n"));
  }
};

}  // namespace

PLUMBLINE_PLUGIN("calibrate", "0.1.0", "MIT", CalibrateBoard)
