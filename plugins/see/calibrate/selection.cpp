#include "selection.hpp"

#include <Eigen/Eigenvalues>
#include <array>
#include <map>

#include "geometry/edge_inset.hpp"
#include "photo/cameras/camera_groups.hpp"

namespace plumbline::markers {
namespace {

/// Whether the points lie so nearly in one line that they give no pose: their spread across it is below a tenth of that
/// along it.
bool in_one_line(const std::vector<CalibrationPoint>& points) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const auto& p : points) mean += p.board.head<2>() / static_cast<double>(points.size());
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const auto& p : points) scatter += (p.board.head<2>() - mean) * (p.board.head<2>() - mean).transpose();
  const Eigen::Vector2d spread = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(scatter).eigenvalues();
  return !(spread(0) > 0.01 * spread(1));
}

/// What most of the usable photographs of that size were taken with; empty if EXIF does not say it, or if it is not
/// asked.
std::string usual_camera(const std::vector<const BoardPointsT*>& photographs, const Selection& of, bool ask) {
  std::map<std::string, int> times;
  for (const auto* p : photographs)
    if (ask && p->problem.empty() && p->width == of.width && p->height == of.height && !p->taken_with.empty())
      ++times[p->taken_with];
  std::string usual;
  for (const auto& [camera, number] : times)
    if (usual.empty() || number > times[usual]) usual = camera;
  return usual;
}

/// CalibrationPoint::by_inset of the corners of tags, four each under 4 times its number and what follows.
void add_insets(const BoardPointsT& photograph, CalibrationView& view) {
  if (!(photograph.corner_inset_sigma > 0)) return;  // nan: the board's points are none of edges
  std::map<int, size_t> places;
  for (size_t k = 0; k < photograph.points.size(); ++k) places[photograph.points[k]->id] = k;
  for (const auto& [id, place] : places) {
    if (id % 4 != 0) continue;
    std::array<size_t, 4> at{};
    std::array<Eigen::Vector2d, 4> corners;
    bool whole = true;
    for (int c = 0; c < 4 && whole; ++c) {
      const auto found = places.find(id + c);
      whole = found != places.end();
      if (whole) at[c] = found->second;
    }
    if (!whole) continue;
    for (size_t c = 0; c < 4; ++c) corners[c] = view.points[at[c]].pixel;
    const auto moved = moved_by_inset(corners);
    for (size_t c = 0; c < 4; ++c) view.points[at[c]].by_inset = photograph.corner_inset_sigma * moved[c];
  }
}

Selection select_one(const std::vector<const BoardPointsT*>& photographs, bool tell_bodies) {
  Selection result;
  std::map<std::pair<int, int>, int> sizes;
  for (const auto* p : photographs)
    if (p->problem.empty()) ++sizes[{p->width, p->height}];
  int most = 0;
  for (const auto& [size, number] : sizes)
    if (number > most) most = number, result.width = size.first, result.height = size.second;
  const std::string camera = usual_camera(photographs, result, tell_bodies);
  std::map<std::string, std::string> by_content;
  for (const auto* p : photographs) {
    result.board = p->board;
    const auto [same, is_new] = by_content.emplace(p->sha256, p->path);
    if (!p->problem.empty()) {
      result.left_out.emplace_back(p->path, p->problem);
    } else if (p->width != result.width || p->height != result.height) {
      const bool turned = p->width == result.height && p->height == result.width;
      result.left_out.emplace_back(p->path,
                                   "has " + std::to_string(p->width) + " x " + std::to_string(p->height) +
                                       " pixels where the others have " + std::to_string(result.width) + " x " +
                                       std::to_string(result.height) +
                                       (turned ? ": a program turned its pixels; use the file as the camera wrote it"
                                               : "; one calibration is for one size: put those of another size "
                                                 "into a folder of their own"));
    } else if (!camera.empty() && !p->taken_with.empty() && p->taken_with != camera) {
      result.left_out.emplace_back(p->path, "was taken with another camera or focal length (" + p->taken_with +
                                                ") than the others (" + camera +
                                                "): put each camera's photographs into a folder of its own; "
                                                "cameras=one says that it is one camera all the same");
    } else if (!p->sha256.empty() && !is_new) {
      result.left_out.emplace_back(p->path, "is the same file as " + same->second);
    } else {
      CalibrationView view;
      view.path = p->path;
      for (const auto& point : p->points)
        view.points.push_back({point->board, point->pixel, point->sigma > 0 ? point->sigma : 0.1});
      add_insets(*p, view);
      if (view.points.size() < 4 || in_one_line(view.points))
        result.left_out.emplace_back(p->path, "its " + std::to_string(view.points.size()) +
                                                  " points of the board lie in one line and give no pose");
      else
        result.views.push_back(std::move(view));
    }
  }
  return result;
}

}  // namespace

std::vector<Selection> select(const std::vector<BoardPointsT>& photographs, const std::string& cameras) {
  constexpr size_t enough = 3;
  std::map<std::string, std::vector<const BoardPointsT*>> groups;
  for (const auto& p : photographs) groups[cameras::camera_name(p.path, cameras)].push_back(&p);
  std::vector<Selection> result, small;
  for (const auto& [name, members] : groups) {
    Selection selection = select_one(members, cameras != "one");
    if (groups.size() > 1) selection.camera = name.empty() ? "photographs beside the folders" : name;
    (selection.views.size() >= enough || groups.size() == 1 ? result : small).push_back(std::move(selection));
  }
  if (result.empty()) return small;
  if (result.size() == 1) result.front().camera.clear();
  for (const Selection& one : small) {
    auto& left_out = result.front().left_out;
    left_out.insert(left_out.end(), one.left_out.begin(), one.left_out.end());
    for (const auto& view : one.views)
      left_out.emplace_back(view.path, "is one of " + std::to_string(one.views.size()) +
                                           " usable photographs of camera '" + one.camera +
                                           "': too few to calibrate it");
  }
  return result;
}

}  // namespace plumbline::markers
