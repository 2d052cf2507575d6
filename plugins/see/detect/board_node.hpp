// detect.board: the points of a calibration board in every photograph.
#pragma once

#include <fmt/core.h>

#include "artifacts/board_points.hpp"
#include "artifacts/image.hpp"
#include "base/text/whole_file.hpp"
#include "detector_node.hpp"
#include "photo/detect/board.hpp"
#include "photo/images/grey_image.hpp"
#include "photo/images/motion_blur.hpp"
#include "plumbline/node.hpp"

namespace plumbline::detect {

struct DetectBoard : Node {
  static constexpr Info info{"detect.board", "", 6,
                             "Finds a calibration board (chessboard, ChArUco or grid of tags) and measures its points"};
  Each<Image> images{"images", "photographs of the board"};
  Param<FilePath> board{"board", required, "board file (YAML); docs/camera_calibration.md has an example of each kind"};
  Out<BoardPoints> points{"points", "the points that were found, or why none were"};

  void run(Context& context) override {
    const double pixels = static_cast<double>(images->width()) * images->height();
    context.reserve_memory(static_cast<uint64_t>(static_cast<double>(images->size()) + 14 * pixels));
    const Board pattern = parse_board(text::read_whole(board->path), board->path);
    BoardPointsT result;
    result.path = images->path()->str();
    result.sha256 = images->sha256()->str();
    result.board = pattern.words();
    result.taken_with = taken_with();
    try {
      const GreyImage grey = read_grey_image(context.resolve(images->uri()->str()));
      result.width = grey.width, result.height = grey.height;
      const SeenBoard seen = find_board(grey, pattern);
      result.problem = seen.problem, result.marker_ratio = seen.marker_ratio, result.contradicts = seen.contradicts;
      result.corner_inset_sigma = seen.inset_sigma;
      result.stated_marker_ratio = stated_ratio(pattern), result.moved = in_words(motion_blur(grey));
      for (const SeenPoint& p : seen.points) {
        auto point = std::make_unique<BoardPointT>();
        point->id = p.id, point->board = p.board, point->pixel = p.pixel, point->sigma = p.sigma;
        result.points.push_back(std::move(point));
      }
      check_pitch(pattern, board->path, seen, result);
      if (!seen.problem.empty() && !seen.contradicts) result.problem += why(grey, pattern);
      if (seen.contradicts) result.problem += " (" + board->path + ")";
    } catch (const ImageFileError& error) {
      result.problem = error.what();
    }
    // Whether one photograph or the file is wrong shows in all of them: calibrate.board tells.
    const bool by_pitch = result.contradicts && std::isfinite(result.marker_ratio);
    if (!result.problem.empty() && !by_pitch) context.warn(result.path + ": " + result.problem);
    if (result.problem.empty() && !result.moved.empty()) context.warn(result.path + ": " + result.moved);
    points.commit(result);
  }

 private:
  std::string taken_with() const {
    std::string text = images->model() ? images->model()->str() : "";
    if (images->serial() && images->serial()->size() > 0) text += (text.empty() ? "" : " ") + images->serial()->str();
    if (!(images->focal_length() > 0)) return text;
    const std::string focal = fmt::format("{:.3g} mm", 1e3 * images->focal_length());
    return text + (text.empty() ? "" : ", ") + focal;
  }

  /// What else explains that the board was not found.
  static std::string why(const GreyImage& grey, const Board& pattern) {
    if (pattern.kind != BoardKind::chessboard && !find_board(mirrored(grey), pattern).points.empty())
      return ". The photograph is mirrored: it is found after a flip. Export it from the camera without mirroring";
    const std::string others =
        pattern.kind == BoardKind::chessboard ? "" : tags_of_another_family(grey, {pattern.dictionary.name});
    if (!others.empty()) return "; it shows " + others + ": the dictionary of the board file is wrong";
    const std::string reason = why_nothing_is_found(grey);
    return reason.empty() ? "" : "; " + reason;
  }

  /// nan of a board without markers.
  static double stated_ratio(const Board& pattern) {
    if (pattern.kind == BoardKind::chessboard) return std::nan("");
    return pattern.marker / (pattern.kind == BoardKind::tags ? pattern.marker + pattern.gap : pattern.square);
  }

  /// Markers of another size against their squares or spacing than the file says: one of its two lengths is wrong. Blur
  /// and ink move every edge of a tag, by up to half a pixel.
  static void check_pitch(const Board& pattern, const std::string& file, const SeenBoard& seen, BoardPointsT& result) {
    if (pattern.kind == BoardKind::chessboard || !std::isfinite(seen.marker_ratio)) return;
    const bool tags = pattern.kind == BoardKind::tags;
    const double stated = stated_ratio(pattern);
    const double limit = tags ? std::max(0.04, 1 / seen.marker_pixels) : 0.06;
    if (std::abs(seen.marker_ratio / stated - 1) < limit) return;
    const double pitch = tags ? pattern.marker + pattern.gap : pattern.square;
    result.problem = fmt::format(
        "the {} measure {:.3f} of {}, {:.3f} is in {}: 'marker' or '{}' there is wrong ({} {:.4g} m, 'marker' would be "
        "{:.3g} m)",
        tags ? "tags" : "markers", seen.marker_ratio, tags ? "their spacing" : "a square", stated, file,
        tags ? "gap" : "square", tags ? "in steps of" : "with squares of", pitch, seen.marker_ratio * pitch);
    result.points.clear(), result.contradicts = true;
  }
};

}  // namespace plumbline::detect
