// adjust.marker_board: tags in unknown places, from photographs alone.
#pragma once

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "geometry/median.hpp"
#include "output.hpp"
#include "photo/markers/marker_datum.hpp"
#include "photo/markers/marker_halves.hpp"
#include "photo/markers/marker_truth.hpp"
#include "plumbline/node.hpp"

namespace plumbline::markers {

struct AdjustMarkerBoard : Node {
  static constexpr Info info{"adjust.marker_board", "", 8,
                             "Adjusts photographs of tags in unknown places: a free network with self-calibration"};
  List<Image> images{"images", "the photographs, for what EXIF says of their cameras"};
  In<TagObservations> observations{"observations", "the tags in them"};
  List<Camera> calibrations{"camera",
                            "calibration of the one camera, or of several by the names of `cameras`; none: every "
                            "camera calibrates itself"};
  Param<double> tag_size{"tag_size", 0.0, "m", between(0, 100),
                         "edge of the tags between their detected corners; 0: unknown, `distance` gives the scale"};
  Param<std::string> distance{"distance", "",
                              "A,B,metres[,sigma]: distance between the centres of tags A and B; it gives the scale in "
                              "place of the printed size"};
  Param<double> size_sigma{"size_sigma", 1e-3, "1", between(0, 1),
                           "prior standard deviation of each tag's printed size, relative"};
  Param<double> twist_sigma{"twist_sigma", 1e-2, "1", between(0, 0.1),
                            "prior standard deviation of how far a tag's corners lie out of its plane (wavy paper), "
                            "relative to half its edge; 0: tags are plane"};
  Param<double> shape_sigma{"shape_sigma", 0.0, "1", between(0, 0.1),
                            "the same in the plane, for prints that are no squares; 0: they are"};
  Param<double> print_sigma{"print_sigma", 1e-4, "m", between(0, 1),
                            "what is not known of the printed size of all tags together; states how good lengths are"};
  Param<double> corner_inset_sigma{
      "corner_inset_sigma", 0.3, "px", between(0, 10),
      "prior standard deviation of how far the detector draws tag edges inwards, where it states none"};
  Param<double> reject_above{"reject_above", 5.0, "1", at_least(0),
                             "tags whose rms residual is this many times the median are left out; 0 keeps all"};
  Param<std::string> cameras{
      "cameras", "by_folder", one_of("by_folder", "by_name", "by_file", "one"),
      "by_folder: photographs of another folder are from another camera; by_name: of another name around the "
      "number (cam0_17.png), too; by_file: every folder is a moment (17/cam0.png); one: only size, model "
      "and focal length tell"};
  Param<bool> compare{
      "compare_halves", true,
      "adjust halves of the photographs, too, by turns, by time and by place, and warn where they differ by "
      "more than they may; it takes three times as long again"};
  Out<File> tags{"tags", "tags.json: centre, corners and sigma of every tag"};
  Out<File> block{"block", "block.json: the adjustment with its statistics, residuals and what was left out"};
  Out<Points> points{"points", frame("frame=board"), "the tags' centres with their full covariance"};
  Out<Poses> poses{"poses", frame("frame=board"), "exterior orientations with covariance"};
  OutList<Camera> adjusted{"cameras", "interior orientations after the adjustment"};

  void run(Context& context) override {
    if (*tag_size == 0 && distance->empty())
      throw std::runtime_error(
          "nothing gives the scale: set tag_size to the edge of a tag in metres (0.05 for 50 mm), "
          "or distance to A,B,metres between the centres of two tags");
    std::vector<ImageT> photographs;
    for (size_t i = 0; i < images.size(); ++i) photographs.push_back(images.unpack(i));
    std::vector<CameraT> known;
    for (size_t i = 0; i < calibrations.size(); ++i) known.push_back(calibrations.unpack(i));
    const TagObservationsT seen = observations.unpack();
    // Without a size any will do: the distance replaces it.
    BlockInput input = block_of(photographs, seen, known, {*tag_size > 0 ? *tag_size : 0.1, *cameras});
    for (const auto& image : input.left_out) context.warn("left out: " + image.path + ": " + image.reason);
    for (const auto& text : input.warnings) context.warn(text);
    if (input.block.views.empty())
      throw std::runtime_error("no photograph shows a usable tag" +
                               (input.left_out.empty()
                                    ? std::string()
                                    : ": " + input.left_out.front().path + ": " + input.left_out.front().reason) +
                               ". Check the family of the tags");
    MarkerOptions options;
    options.print_sigma = *print_sigma, options.shape_sigma = *shape_sigma, options.twist_sigma = *twist_sigma;
    options.size_sigma = *size_sigma, options.inset_sigma = *corner_inset_sigma, options.reject_above = *reject_above;
    if (!distance->empty()) options.distance = parse_distance(*distance, input.block);
    MarkerResult result = adjust_lens_and_block(input.block, options);
    if (options.distance) check_distance(input.block, options, result);
    const std::string print = stretched_print(input.block, options, result);
    if (!print.empty()) tell_instead(print, result);
    MarkerResult told_by_the_print = result;
    const std::vector<MarkerHalves> halves =
        *compare ? halves_of(input.block, options, print.empty() ? result : told_by_the_print)
                 : std::vector<MarkerHalves>();
    for (const auto& text : result.left_out) context.warn("left out: " + text);
    for (const auto& text : result.warnings) context.warn(text);
    context.metric("rms", result.rms, "px");
    context.metric("degrees_of_freedom", result.degrees_of_freedom, "1");
    tags.commit(file_of("tags.json", "application/json", tags_json(input.block, result)));
    block.commit(file_of("block.json", "application/json", block_json(input, result, halves)));
    points.commit(points_of(input.block, result));
    poses.commit(poses_of(input.block, result));
    for (size_t c = 0; c < input.block.cameras.size(); ++c)
      adjusted.commit(camera_artifact(input.block.cameras[c], result.cameras[c]));
  }

 private:
  static bool cameras_scatter(const MarkerResult& result) {
    constexpr double told = 1.5;
    return std::any_of(result.cameras.begin(), result.cameras.end(), [](const AdjustedMarkerCamera& camera) {
      return camera.truth.change || (camera.truth.empirical.judged && camera.truth.empirical.factor > told);
    });
  }

  /// A print that is wider than high makes cameras seem to change with the way they are held: whether tags that may be
  /// no squares explain it.
  static std::string stretched_print(const MarkerBlock& block, MarkerOptions options, const MarkerResult& result) {
    constexpr double free = 0.02, least = 5e-4, beyond_chance = 5;
    if (options.shape_sigma > 0 || result.markers.size() < 3 || !cameras_scatter(result)) return "";
    options.shape_sigma = free;
    try {
      const MarkerResult shaped = adjust_marker_block(block, options);
      double mean = 0, squares = 0;
      const auto n = static_cast<double>(shaped.markers.size());
      for (const AdjustedMarker& marker : shaped.markers) mean += marker.shape[0] / n;
      for (const AdjustedMarker& marker : shaped.markers) squares += std::pow(marker.shape[0] - mean, 2);
      const double sigma = std::sqrt(squares / (n * (n - 1)));
      if (!(std::abs(mean) > std::max(least, beyond_chance * sigma)) || cameras_scatter(shaped)) return "";
      return fmt::format(
          "the tags are {:.2f} \u00b1 {:.2f} % {} than they are high: a print that a program or a printer stretched. "
          "As "
          "that they explain what else would be a camera that changes: block.with.shape_sigma={} lets them be no "
          "squares. Measure both of their sides",
          200 * std::abs(mean), 200 * sigma, mean > 0 ? "wider" : "narrower", free);
    } catch (const std::runtime_error&) {
      return "";
    }
  }

  /// In the place of what the photographs seem to say of their cameras: it has the same cause.
  static void tell_instead(const std::string& print, MarkerResult& result) {
    for (const AdjustedMarkerCamera& camera : result.cameras)
      for (const std::string& seeming : warnings_of(camera.truth))
        std::erase_if(result.warnings, [&](const std::string& text) { return text.ends_with(seeming); });
    result.warnings.insert(result.warnings.begin(), print);
  }

  /// Tags and cameras by three divisions of the photographs; the worst that contradicts is told, and a camera that
  /// changed is tried as two.
  static std::vector<MarkerHalves> halves_of(const MarkerBlock& block, const MarkerOptions& options,
                                             MarkerResult& result) {
    std::vector<MarkerHalves> all;
    for (const HalvesBy by : {HalvesBy::turns, HalvesBy::time, HalvesBy::place})
      if (const auto halves = compare_halves(block, options, result, by)) all.push_back(*halves);
    const MarkerHalves* worst = nullptr;
    for (const MarkerHalves& halves : all)
      if (halves.contradict() && (!worst || halves.worst() > worst->worst())) worst = &halves;
    bool changed = false;
    for (std::size_t c = 0; c < result.cameras.size(); ++c) {
      changed = changed || result.cameras[c].truth.change;
      const std::string two = as_two_cameras(block, options, result, c);
      const std::string of = result.cameras.size() > 1 ? "camera " + block.cameras[c].id + ": " : "";
      if (!two.empty()) result.warnings.push_back(of + two);
    }
    if (worst && !changed) tell(*worst, all, result);
    return all;
  }

  /// One warning of what the photographs say of the cameras and of the halves; halves by turns that agree show that it
  /// goes with places, which is not the cameras.
  static void tell(const MarkerHalves& worst, const std::vector<MarkerHalves>& all, MarkerResult& result) {
    const bool only_by_place =
        worst.by == HalvesBy::place && std::all_of(all.begin(), all.end(), [](const MarkerHalves& halves) {
          return halves.by == HalvesBy::place || !halves.contradict();
        });
    const std::string words = in_words(worst, only_by_place);
    for (const AdjustedMarkerCamera& camera : result.cameras) {
      const std::string scatter = in_words(camera.truth.empirical, camera.truth.scatter);
      if (scatter.empty()) continue;
      for (std::string& warning : result.warnings)
        if (warning.ends_with(scatter)) {
          warning += ". And " + words;
          return;
        }
    }
    result.warnings.push_back(words);
  }

  /// Where both are given the distance counts: what it says of the tags' size is held against that, by the standard
  /// deviations of both. Where it is given alone a slip of its unit makes tags that nobody prints.
  void check_distance(const MarkerBlock& given, const MarkerOptions& options, MarkerResult& result) const {
    constexpr double beyond_chance = 4, smallest = 0.002, largest = 3;  // [m]
    if (result.markers.empty()) return;
    std::vector<double> scales;
    for (const AdjustedMarker& marker : result.markers) scales.push_back(marker.scale);
    const double scale = median(scales), measured = scale * given.markers.front().size;
    if (*tag_size == 0) {
      if (measured < smallest || measured > largest)
        result.warnings.push_back(
            fmt::format("with distance={} the tags measure {:.6g} mm, which no tag that is printed does: is it in "
                        "metres, between the centres of these two tags?",
                        distance->c_str(), 1e3 * measured));
      return;
    }
    double places = 0;  // variance of the ends in the photographs
    for (const AdjustedMarker& marker : result.markers)
      if (marker.marker == options.distance->from || marker.marker == options.distance->to)
        places += marker.centre_covariance.trace();
    const double sigma = std::hypot(result.scale_sigma, scale_sigma_by_size(given, options, result),
                                    std::sqrt(places) / options.distance->length);
    if (!(std::abs(std::log(scale)) > beyond_chance * sigma)) return;
    result.warnings.push_back(fmt::format(
        "with distance={} the tags measure {:.6g} mm, tag_size says {:.6g} mm, {:.2f} % off where both together are "
        "good to {:.2f} %: the distance counts, and all lengths are wrong if it is. Is it in metres, between the "
        "centres of these two tags? Is tag_size the edge as it was printed?",
        distance->c_str(), 1e3 * measured, 1e3 * *tag_size, 100 * std::abs(scale - 1), 100 * sigma));
  }
};

}  // namespace plumbline::markers
