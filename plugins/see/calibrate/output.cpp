#include "output.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <sstream>

#include "photo/cameras/camera_files.hpp"

namespace plumbline::markers {

using Json = nlohmann::ordered_json;

namespace {

Json grid_json(const std::vector<double>& values) {
  Json table = Json::array();
  for (int row = 0; row < map_rows; ++row) {
    Json line = Json::array();
    for (int column = 0; column < map_columns; ++column) line.push_back(values[row * map_columns + column]);
    table.push_back(line);
  }
  return table;
}

Json images_json(const Selection& selection, const Calibration& c) {
  Json images = Json::array();
  for (const auto& view : c.views) {
    const CalibrationView& given = selection.views[view.view];
    double left = 1e9, right = -1e9, top = 1e9, bottom = -1e9;
    Json points = Json::array();
    for (size_t k = 0; k < view.points.size(); ++k) {
      const Eigen::Vector2d& p = given.points[view.points[k]].pixel;
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

std::string with_capital(std::string text) {
  if (!text.empty()) text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text;
}

/// Parts that differ by more than the scatter of the photographs, which is in their covariances.
void add_parts(const std::vector<CalibrationParts>& all, std::vector<std::string>& warnings) {
  const CalibrationParts* worst = contradiction_of(all);
  if (!worst) return;
  warnings.push_back(fmt::format(
      "{} give cameras whose parameters differ by {:.1f} times what their covariances allow (chi-squared {:.0f} of {} "
      "degrees of freedom; {:.2f} px in the median over the image): the model does not fit this lens or this board, or "
      "the camera changed between them. The standard deviations are made larger by that",
      with_capital(worst->split), std::sqrt(worst->statistic / worst->freedom), worst->statistic, worst->freedom,
      worst->difference));
}

/// Which lens the photographs show, where that is not Brown's as asked for.
void add_lens(const LensComparison& lenses, LensModel used, std::vector<std::string>& warnings) {
  const bool as_fisheye = used == LensModel::fisheye;
  if (!lenses.is_fisheye()) {
    if (as_fisheye && lenses.only_fisheye)
      warnings.emplace_back(
          "The lens is a fisheye: Brown's model does not fit the photographs at all, and it is calibrated with the "
          "fisheye's (Kannala and Brandt)");
    return;
  }
  warnings.push_back(fmt::format(
      "The lens is a fisheye: over {:.0f} degrees off the axis, {} fit to {:.2f} px with the fisheye's model (Kannala "
      "and Brandt, 8 parameters) and to {:.2f} px with Brown's (9). {}",
      lenses.widest * 180 / M_PI, lenses.held_out ? "photographs that the lens was not fitted to" : "the photographs",
      lenses.fisheye, lenses.brown,
      as_fisheye ? "It is calibrated as one, which camera.yaml says"
                 : "As Brown's it is wrong towards the corners by more than its standard deviations: "
                   "lens=fisheye"));
}

/// Coverage in a 4 × 4 grid of the image.
void add_coverage(const Selection& selection, const Calibration& c, std::vector<std::string>& warnings) {
  std::array<int, 16> cells{};
  for (const auto& view : c.views)
    for (const int k : view.points) {
      const Eigen::Vector2d& p = selection.views[view.view].points[k].pixel;
      const int x = std::clamp(static_cast<int>(4 * p.x() / selection.width), 0, 3),
                y = std::clamp(static_cast<int>(4 * p.y() / selection.height), 0, 3);
      ++cells[4 * y + x];
    }
  const auto empty = std::count_if(cells.begin(), cells.end(), [](int n) { return n < 5; });
  if (empty > 0) {
    warnings.push_back(
        fmt::format("{} of 16 parts of the image hold hardly any point: the distortion there is a guess. Bring the "
                    "board into every corner",
                    static_cast<int>(empty)));
  }
}

}  // namespace

std::vector<std::string> warnings_of(const Calibrated& one) {
  const Selection& selection = one.selection;
  const Calibration& c = one.calibration;
  std::vector<std::string> warnings;
  std::string text;
  add_lens(one.lenses, c.camera.lens, warnings);
  const size_t before = warnings.size();
  if (one.aspect)
    warnings.push_back(with_capital(in_words(*one.aspect)));
  else
    for (const std::string& words : markers::warnings_of(c.truth)) warnings.push_back(with_capital(words));
  if (!one.aspect && c.truth.change && !one.as_two.empty()) warnings[before] += ". " + with_capital(one.as_two);
  if (!c.truth.empirical.judged) {
    warnings.push_back(fmt::format(
        "{} photographs are too few to see how they scatter ({} are needed): the standard deviations are {:.1f} times "
        "those that the corners give, because photographs of a board usually scatter so much more than their corners",
        c.truth.empirical.photographs, fewest_to_scatter, c.truth.empirical.factor));
  }
  if (!c.truth.change && !one.aspect) add_parts(one.parts, warnings);
  if (c.rms > std::min(2.0, 1.5e-3 * std::max(selection.width, selection.height))) {
    warnings.push_back(
        fmt::format("The points fit to {:.1f} px only: the board file does not describe this board (lengths, columns "
                    "and rows), the board is not rigid, or the lens is none of this model (a fisheye)",
                    c.rms));
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
  if (c.held_highest)
    warnings.push_back(
        std::string("The photographs do not determine the ") +
        (c.camera.lens == LensModel::fisheye ? "fourth radial coefficient: k4" : "third radial coefficient: k3") +
        " is held at 0. Bring the board into the corners of the image");
  add_coverage(selection, c, warnings);
  if (c.bend_x_sigma > 0 && std::max(std::abs(c.bend_x) / c.bend_x_sigma, std::abs(c.bend_y) / c.bend_y_sigma) > 4) {
    warnings.push_back(
        fmt::format("The board is bent: its middle stands {:.2f} mm (along x) and {:.2f} mm (along y) before its "
                    "edges; this is taken into account",
                    1e3 * c.bend_x, 1e3 * c.bend_y));
  }
  return warnings;
}

namespace {

Json parts_json(const std::vector<CalibrationParts>& all) {
  Json list = Json::array();
  for (const CalibrationParts& parts : all)
    list.push_back({{"split", parts.split},
                    {"median_difference_px", parts.difference},
                    {"median_expected_px", parts.expected},
                    {"chi_squared", parts.statistic},
                    {"degrees_of_freedom", parts.freedom}});
  return list;
}

Json scatter_json(const Calibrated& one) {
  const Calibration& c = one.calibration;
  const EmpiricalCovariance& empirical = c.truth.empirical;
  Json formal, ratio;
  for (std::size_t i = 0; i < c.truth.evidence.parameters.size(); ++i) {
    const char* name = c.camera.names()[c.truth.evidence.parameters[i]];
    const Eigen::Index k = static_cast<Eigen::Index>(i);
    formal[name] = std::sqrt(c.truth.evidence.formal(k, k));
    ratio[name] = empirical.sigma_ratio(k);
  }
  return {{"judged", empirical.judged},
          {"photographs", empirical.photographs},
          {"factor", empirical.factor},
          {"by_order", empirical.by_order},
          {"by_place", empirical.by_place},
          {"by_parts", shown_too_small_by(one.parts)},
          {"bootstrap_over_scatter", empirical.bootstrap_ratio},
          {"formal_sigmas", formal},
          {"sigma_over_formal", ratio}};
}

/// A row of the correlation matrix; 0 with what is held.
Json correlations_of(const Eigen::MatrixXd& covariance, Eigen::Index k, Eigen::Index count) {
  Json row = Json::array();
  for (Eigen::Index j = 0; j < count; ++j) {
    const double scale = std::sqrt(covariance(k, k) * covariance(j, j));
    row.push_back(scale > 0 ? covariance(k, j) / scale : (k == j ? 1.0 : 0.0));
  }
  return row;
}

}  // namespace

Json calibration_json(const Calibrated& one) {
  const Selection& selection = one.selection;
  const Calibration& c = one.calibration;
  Json parameters, sigmas, correlations = Json::array();
  const auto values = c.camera.parameters();
  const auto names = c.camera.names();
  const auto count = static_cast<Eigen::Index>(names.size());
  for (size_t i = 0; i < names.size(); ++i) {
    const Eigen::Index k = static_cast<Eigen::Index>(i);
    parameters[names[i]] = values[i];
    sigmas[names[i]] = std::sqrt(c.covariance(k, k));
    correlations.push_back(correlations_of(c.covariance, k, count));
  }
  Json rejected = Json::array(), warnings = Json::array(), covariance = Json::array();
  for (const auto& text : c.rejected) rejected.push_back(text);
  Json halves = {{"median_difference_px", nullptr}, {"median_expected_px", nullptr}};
  if (!one.parts.empty())
    halves = {{"median_difference_px", one.parts.front().difference},
              {"median_expected_px", one.parts.front().expected}};
  for (const auto& text : warnings_of(one)) warnings.push_back(text);
  for (Eigen::Index i = 0; i < count; ++i)
    for (Eigen::Index j = 0; j <= i; ++j) covariance.push_back(c.covariance(i, j));
  return {
      {"board", selection.board},
      {"width", selection.width},
      {"height", selection.height},
      {"lens", name_of(c.camera.lens)},
      {"model",
       c.camera.lens == LensModel::fisheye
           ? "fisheye (Kannala and Brandt), as OpenCV's: fx, fy, cx, cy, k1, k2, k3, k4; the centre of the top-left "
             "pixel is (0, 0)"
           : "Brown, as OpenCV: fx, fy, cx, cy, k1, k2, k3, p1, p2; the centre of the top-left pixel is (0, 0)"},
      {"parameters", parameters},
      {"sigmas", sigmas},
      {"parameter_order", std::vector<std::string>(names.begin(), names.end())},
      {"correlations", correlations},
      {"covariance_lower_triangle", covariance},
      {"rms_px", c.rms},
      {"sigma_px", c.sigma},
      {"observations", c.observations},
      {"unknowns", c.unknowns},
      {"degrees_of_freedom", c.degrees_of_freedom},
      {"board_bend_m", {c.bend_x, c.bend_y}},
      {"board_bend_sigma_m", {c.bend_x_sigma, c.bend_y_sigma}},
      {"scatter_of_photographs", scatter_json(one)},
      {"halves", halves},
      {"parts", parts_json(one.parts)},
      {"lenses",
       {{"fisheye_px", one.lenses.fisheye > 0 ? Json(one.lenses.fisheye) : Json()},
        {"brown_px", one.lenses.brown > 0 ? Json(one.lenses.brown) : Json()},
        {"of_photographs_not_fitted_to", one.lenses.held_out},
        {"widest_deg", one.lenses.widest > 0 ? Json(one.lenses.widest * 180 / M_PI) : Json()}}},
      {"projection_uncertainty_px", grid_json(projection_uncertainty(c.camera, c.covariance, map_columns, map_rows))},
      {"warnings", warnings},
      {"rejected", rejected},
      {"images", images_json(selection, c)}};
}

namespace {

/// What the standard deviations of the file are made of.
std::vector<std::string> remarks_of(const Calibrated& one) {
  const Calibration& c = one.calibration;
  const EmpiricalCovariance& empirical = c.truth.empirical;
  std::string text;
  if (!empirical.judged)
    text = fmt::format(
        "sigmas: {:.2f} times those of the corners alone, as is usual: {} photographs are too few to see how they "
        "scatter",
        empirical.factor, empirical.photographs);
  else if (empirical.factor > 1.05)
    text = fmt::format("sigmas: {:.2f} times those of the corners alone, because the {} photographs scatter that much",
                       empirical.factor, empirical.photographs);
  else
    text = fmt::format("sigmas: of the corners; the {} photographs scatter no more than these allow",
                       empirical.photographs);
  std::vector<std::string> remarks = {text};
  if (const CalibrationParts* parts = contradiction_of(one.parts)) {
    remarks.push_back(fmt::format("and that {:.1f} times, because {} differ by so much",
                                  std::sqrt(parts->statistic / parts->freedom), parts->split));
  }
  if (c.truth.change) remarks.push_back("NOT ONE CAMERA: " + in_words(*c.truth.change, c.truth.evidence));
  return remarks;
}

}  // namespace

std::string yaml_of(const std::vector<Calibrated>& cameras, const std::string& id) {
  std::string text;
  for (const auto& one : cameras) {
    const std::string name = cameras.size() == 1 ? id : one.selection.camera;
    const std::string own =
        cameras::camera_yaml({name, one.calibration.camera, one.calibration.covariance, "", remarks_of(one)});
    if (cameras.size() == 1) return own;
    std::string quoted = name;
    for (size_t at = 0; (at = quoted.find_first_of("\"\\", at)) != std::string::npos; at += 2) quoted.insert(at, "\\");
    text += "\"" + quoted + "\":\n";
    std::istringstream lines(own);
    for (std::string line; std::getline(lines, line);) text += "  " + line + "\n";
  }
  return text;
}

}  // namespace plumbline::markers
