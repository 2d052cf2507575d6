// calibrate.board: the interior orientation of cameras from photographs of a board.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "artifacts/board_points.hpp"
#include "artifacts/camera.hpp"
#include "artifacts/camera_artifact.hpp"
#include "artifacts/file.hpp"
#include "geometry/median.hpp"
#include "output.hpp"
#include "photo/cameras/camera_groups.hpp"
#include "photo/markers/repeated_sights.hpp"
#include "plumbline/node.hpp"

namespace {

using namespace plumbline;
using namespace plumbline::markers;
using Json = nlohmann::ordered_json;

FileT file_of(const std::string& name, const std::string& media_type, const std::string& text) {
  FileT file;
  file.name = name, file.media_type = media_type;
  file.content.assign(text.begin(), text.end());
  return file;
}

CameraT artifact_of(const Calibrated& one, const std::string& id) {
  CameraT camera;
  camera.id = id;
  set_interior(one.calibration.camera, one.calibration.covariance, camera);
  camera.source = "calibration on a " + one.selection.board;
  return camera;
}

struct CalibrateBoard : Node {
  static constexpr Info info{
      "calibrate.board", "", 10,
      "Calibrates cameras on photographs of a board: parameters, covariance, uncertainty over the image, rigs"};
  List<BoardPoints> points{"points", "the board's points in each photograph"};
  Param<std::string> lens{"lens", "by_photographs", one_of("by_photographs", "brown", "fisheye"),
                          "how the lens bends rays: Brown's model, or a fisheye's (Kannala and Brandt); "
                          "by_photographs: Brown's, unless the "
                          "fisheye's foretells photographs better that neither was fitted to"};
  Param<std::vector<std::string>> free{"free",
                                       {"fx", "fy", "cx", "cy", "k1", "k2", "k3", "k4", "p1", "p2"},
                                       "parameters to estimate, those of them that the lens has"};
  Param<double> bend_sigma{
      "bend_sigma", 0.001, "m", between(0, 1),
      "prior standard deviation of how far the board bulges, along x and along y; 0 holds it flat"};
  Param<double> reject_above{"reject_above", 5.0, "1", at_least(0),
                             "points whose residual is this many times the median are left out; 0 keeps all"};
  Param<std::string> cameras{
      "cameras", "by_folder", one_of("by_folder", "by_name", "by_file", "one"),
      "by_folder: photographs of another folder are from another camera; by_name: of another name around the "
      "number (left01.jpg, right01.jpg), too; by_file: every folder is a moment (01/left.jpg, 01/right.jpg)"};
  Param<std::string> id{"id", "camera", "name of the camera in its file, where there is one"};
  OutList<Camera> calibrated{"cameras", "the interior orientations with their full covariance"};
  Out<File> yaml{"yaml", "camera.yaml, as campaign folders take it; several cameras each under its name"};
  Out<File> json{"json",
                 "calibration.json: parameters, sigmas, correlations, rms_px, images[]; of several cameras "
                 "cameras[] of these, and rig[]"};

  void run(Context& context) override {
    std::vector<BoardPointsT> photographs;
    std::vector<std::string> paths;
    std::set<std::string> told;  // by whoever searched them
    for (size_t i = 0; i < points.size(); ++i) {
      photographs.push_back(points.unpack(i)), paths.push_back(photographs.back().path);
      const bool by_pitch = photographs.back().contradicts && std::isfinite(photographs.back().marker_ratio);
      if (!photographs.back().problem.empty() && !by_pitch) told.insert(paths.back());
    }
    const std::string by = cameras::cameras_told(paths, *cameras);
    const std::string suspects = by == "by_folder" ? cameras::suspected_cameras(paths) : "";
    if (!suspects.empty())
      context.warn(
          "the photographs are called " + suspects +
          ", each with the same numbers, and count as one camera's: cameras=by_name calibrates each by itself, "
          "cameras=one says that it is one");
    refuse_wrong_board(photographs);
    excuse_board(photographs);
    if (const std::string text = wrong_ratio(photographs); !text.empty()) context.warn(text);
    CalibrationOptions options;
    options.free = *free, options.bend_sigma = *bend_sigma, options.reject_above = *reject_above;
    std::vector<Calibrated> all;
    for (Selection& selection : select(photographs, by)) {
      if (selection.views.size() < 3 && !selection.left_out.empty())
        throw std::runtime_error("the board was found in " + std::to_string(selection.views.size()) + " of " +
                                 std::to_string(photographs.size()) + " photographs; needed are 3. " +
                                 selection.left_out.front().first + ": " + selection.left_out.front().second);
      for (const auto& [path, reason] : selection.left_out)
        if (!told.count(path)) context.warn("left out: " + path + ": " + reason);
      all.emplace_back().selection = std::move(selection);
      Calibrated& one = all.back();
      try {
        calibrate_told(one, options);
      } catch (const std::runtime_error& error) {
        if (one.selection.camera.empty()) throw;
        throw Failure(kind_of(error), "camera " + one.selection.camera + ": " + error.what());
      }
      const std::string name = one.selection.camera.empty() ? "" : one.selection.camera + ": ";
      if (const std::string text = repeated_sights(one.selection.views); !text.empty()) context.warn(name + text);
      for (const auto& text : warnings_of(one)) context.warn(name + text);
      const auto& camera = one.calibration.camera;
      const auto sigma = [&](int i) { return std::sqrt(one.calibration.covariance(i, i)); };
      context.info(name + fmt::format("fx {:.2f} +- {:.2f}, fy {:.2f} +- {:.2f} px (1 sigma), {} photographs",
                                      camera.fx, sigma(0), camera.fy, sigma(1), one.calibration.views.size()));
    }
    double squares = 0, count = 0;
    for (const auto& one : all) {
      squares += one.calibration.rms * one.calibration.rms * one.calibration.observations;
      count += one.calibration.observations;
      calibrated.commit(artifact_of(one, one.selection.camera.empty() ? *id : one.selection.camera));
    }
    context.metric("rms", std::sqrt(squares / count), "px");
    yaml.commit(file_of("camera.yaml", "application/yaml", yaml_of(all, *id)));
    json.commit(
        file_of("calibration.json", "application/json",
                document(all, by, options, context).dump(1, ' ', false, Json::error_handler_t::replace) + "\n"));
  }

 private:
  /// A board file that more photographs contradict than agree with: those that agree show too little of the board.
  static void refuse_wrong_board(const std::vector<BoardPointsT>& photographs) {
    const BoardPointsT* first = nullptr;
    size_t against = 0, good = 0;
    for (const auto& p : photographs) {
      good += p.problem.empty(), against += p.contradicts;
      if (p.contradicts && !first) first = &p;
    }
    if (against <= good) return;
    throw std::runtime_error(std::to_string(against) + " of " + std::to_string(photographs.size()) +
                             " photographs contradict the board file, " + std::to_string(good) + " agree with it. " +
                             first->path + ": " + first->problem);
  }

  void calibrate_told(Calibrated& one, const CalibrationOptions& options) const {
    const Selection& selection = one.selection;
    std::optional<LensModel> told;
    if (*lens != "by_photographs") told = *lens == "fisheye" ? LensModel::fisheye : LensModel::brown;
    static_cast<JudgedCalibration&>(one) =
        calibrate_and_judge(selection.views, selection.width, selection.height, options, told);
  }

  /// A photograph whose markers have another size than those of the others says nothing of the board file.
  /// Several of the same size show another board, unless they are blurred.
  static void excuse_board(std::vector<BoardPointsT>& photographs) {
    constexpr double alike = 0.005, one_board = 0.03;  // relative: blur makes each another size
    const auto good = ratios_of_good(photographs);
    if (good.empty()) return;
    const std::string others = fmt::format("of the {} other{} {:.3f}, {}", good.size(), good.size() == 1 ? "" : "s",
                                           upper_median(good), of_the_file(photographs, upper_median(good)));
    for (auto& p : photographs) {
      if (!p.contradicts || !std::isfinite(p.marker_ratio)) continue;
      std::set<std::string> like;  // a copy of a photograph is no second witness
      for (const BoardPointsT& other : photographs)
        if (other.contradicts && other.moved.empty() && std::abs(other.marker_ratio / p.marker_ratio - 1) < alike)
          like.insert(other.sha256.empty() ? other.path : other.sha256);
      const std::string measure =
          fmt::format("its markers measure {:.3f} of their squares or spacing, ", p.marker_ratio);
      if (!p.moved.empty())
        p.problem = measure + "those " + others + ": " + p.moved;
      else if (std::abs(p.marker_ratio / upper_median(good) - 1) < one_board)
        p.problem = measure + "those " + others +
                    ": it is the same board, and left out because 'marker' or the squares in the file are wrong; "
                    "mend the file";
      else if (like.size() > 1)
        p.problem = measure + fmt::format(
                                  "and so do those of {} photographs together; those {}: it shows another "
                                  "board. Put its photographs into a folder of their own, with a board file",
                                  like.size(), others);
      else
        p.problem = measure + "those " + others + ": this one is blurred, or was moved while it was taken";
    }
  }

  static std::vector<double> ratios_of_good(const std::vector<BoardPointsT>& photographs) {
    std::vector<double> ratios;
    for (const auto& p : photographs)
      if (!p.contradicts && std::isfinite(p.marker_ratio)) ratios.push_back(p.marker_ratio);
    return ratios;
  }

  static double stated_ratio(const std::vector<BoardPointsT>& photographs) {
    for (const auto& p : photographs)
      if (std::isfinite(p.stated_marker_ratio)) return p.stated_marker_ratio;
    return std::nan("");
  }

  static std::string of_the_file(const std::vector<BoardPointsT>& photographs, double measured) {
    constexpr double as_printed = 0.02;  // relative: blur and ink
    const double stated = stated_ratio(photographs);
    return std::abs(measured / stated - 1) < as_printed ? "as the board file has it"
                                                        : fmt::format("the board file has {:.3f}", stated);
  }

  /// Each photograph by itself may be off by 6 %, as a blurred one is; that most of them are off says something of the
  /// file.
  static std::string wrong_ratio(const std::vector<BoardPointsT>& photographs) {
    constexpr double limit = 0.04;  // relative; of public sets with the right file 0.031 at most, of 480 rows
    const auto good = ratios_of_good(photographs);
    const double stated = stated_ratio(photographs);
    if (good.empty() || !(std::abs(upper_median(good) / stated - 1) > limit)) return "";
    return fmt::format(
        "in most of the {} photographs the markers measure {:.3f} of their squares or spacing, the board file has "
        "{:.3f}: measure the board, 'marker' or the squares in the file are wrong by {:.0f} %, or all photographs are "
        "blurred",
        good.size(), upper_median(good), stated, 100 * std::abs(upper_median(good) / stated - 1));
  }

  static Json document(const std::vector<Calibrated>& all, const std::string& by, const CalibrationOptions& options,
                       Context& context) {
    if (all.size() == 1) return calibration_json(all[0]);
    Json list = Json::array();
    for (const auto& one : all) {
      Json entry = {{"id", one.selection.camera}};
      entry.update(calibration_json(one));
      list.push_back(entry);
    }
    std::vector<std::string> warnings;
    Json rig = rig_json(all, by, options, warnings);
    for (const auto& text : warnings) context.warn(text);
    return {
        {"cameras", list},
        {"rig_is",
         "camera from reference, from one adjustment of all cameras: rotation quaternion w, x, y, z; translation in "
         "m; covariance of a rotation vector in the camera's frame [rad], then of the translation [m]; halves: mean "
         "square difference of two halves of the moments over its covariance; parameters of the camera there"},
        {"rig", rig},
        {"warnings", warnings}};
  }
};

}  // namespace

PLUMBLINE_PLUGIN("calibrate", PLUMBLINE_BUILD_ID, "MIT", CalibrateBoard)
