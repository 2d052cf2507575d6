#include "photo/block/control_words.hpp"

#include <fmt/core.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "base/text/words.hpp"
#include "geometry/linear_algebra/decompositions.hpp"
#include "geometry/similarity.hpp"
#include "least_squares/problem/defects.hpp"

namespace plumbline::block {
namespace {

/// The error of all tag offsets, in the plates' axes [m], if it explains nine tenths of the squares; else zero.
Eigen::Vector3d common_offset(const TagBlock& block, const TagBlockResult& result) {
  std::vector<std::pair<Eigen::Vector3d, Eigen::Matrix3d>> rows;  // residual, rotation
  std::vector<Eigen::Vector3d> places;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (size_t k = 0; k < block.control.plates.size(); ++k) {
    const auto at = std::find(result.plates.begin(), result.plates.end(), block.control.plates[k]);
    if (at == result.plates.end()) continue;
    const auto j = at - result.plates.begin();
    const Eigen::Vector3d adjusted = result.anchors.segment<3>(3 * j);
    rows.emplace_back(adjusted - block.control.position.segment<3>(3 * static_cast<Eigen::Index>(k)),
                      result.world_from_plate[j].toRotationMatrix());
    places.push_back(adjusted);
    centre += adjusted;
  }
  const auto n = static_cast<Eigen::Index>(rows.size());
  if (n < 6) return Eigen::Vector3d::Zero();
  centre /= static_cast<double>(n);
  Eigen::MatrixXd a(3 * n, 9);
  Eigen::VectorXd r(3 * n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const auto& [residual, rotation] = rows[k];
    a.block<3, 3>(3 * k, 0).setIdentity();
    a.block<3, 3>(3 * k, 3) = -skew(places[k] - centre);
    a.block<3, 3>(3 * k, 6) = rotation;
    r.segment<3>(3 * k) = residual;
  }
  const auto rest = [&](Eigen::Index columns, Eigen::VectorXd& x) {
    x = linear_algebra::least_squares_solution(a.leftCols(columns), r);
    return (r - a.leftCols(columns) * x).squaredNorm();
  };
  Eigen::VectorXd motion, all;
  const double before = rest(6, motion), after = rest(9, all);
  return after < 0.1 * before ? Eigen::Vector3d(all.tail<3>()) : Eigen::Vector3d::Zero();
}

}  // namespace

std::string control_in_words(const TagBlock& block, const TagBlockResult& result) {
  const Eigen::Vector3d offset = common_offset(block, result);
  if (offset.norm() > 0.002)
    return fmt::format(
        "; the offset of the tag on its plate is wrong on all plates: by about {:.0f}, {:.0f}, {:.0f} mm in the plate "
        "table's tag_x, tag_y, tag_z",
        1e3 * offset.x(), 1e3 * offset.y(), 1e3 * offset.z());
  std::vector<std::pair<double, std::string>> worst;
  for (const AdjustedControl& control : result.control) {
    double w = 0;
    for (const auto& coordinate : control.coordinates) w = std::max(w, std::abs(coordinate.w));
    worst.emplace_back(-w, block.plates[control.plate].anchor);
  }
  std::sort(worst.begin(), worst.end());
  std::vector<std::string> names;
  for (size_t i = 0;
       i < std::min<size_t>(worst.size(), 3) && worst[i].first < -4 && worst[i].first < 0.5 * worst[0].first; ++i) {
    names.push_back(worst[i].second + fmt::format(" (w = {:.0f})", -worst[i].first));
  }
  return names.empty() ? ""
                       : "; most at " + text::enumerate(names) +
                             ": its surveyed point, its tag or the offset of the tag on its plate is wrong";
}

namespace {

/// Two control points and how much longer their distance is in the block.
struct Pair {
  std::size_t a, b;
  double ratio;
};

/// All pairs in the order of their ratio, and the share of them, first to last, that has one scale within a tenth up
/// and down; approximate values are better than that.
struct Figure {
  std::vector<Pair> pairs;
  std::size_t first = 0, count = 0;
};

Figure figure_of(const std::vector<Eigen::Vector3d>& in_block, const std::vector<Eigen::Vector3d>& in_control) {
  Figure figure;
  std::vector<Pair>& pairs = figure.pairs;
  for (std::size_t i = 0; i < in_block.size(); ++i)
    for (std::size_t j = i + 1; j < in_block.size(); ++j)
      if (const double ratio = (in_block[i] - in_block[j]).norm() / (in_control[i] - in_control[j]).norm();
          ratio > 0 && std::isfinite(ratio))
        pairs.push_back({i, j, ratio});
  std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.ratio < b.ratio; });
  for (std::size_t i = 0, end = 0; i < pairs.size(); ++i) {
    while (end < pairs.size() && pairs[end].ratio <= 1.2 * pairs[i].ratio) ++end;
    if (end - i > figure.count) figure.first = i, figure.count = end - i;
  }
  return figure;
}

}  // namespace

std::vector<std::size_t> strangers_in_figure(const std::vector<Eigen::Vector3d>& in_block,
                                             const std::vector<Eigen::Vector3d>& in_control) {
  const Figure figure = figure_of(in_block, in_control);
  if (in_block.size() < 4 || 2 * figure.count < figure.pairs.size()) return {};
  std::vector<std::size_t> agree(in_block.size()), all(in_block.size()), strangers;
  for (std::size_t k = 0; k < figure.pairs.size(); ++k) {
    const bool same = k >= figure.first && k < figure.first + figure.count;
    for (const std::size_t point : {figure.pairs[k].a, figure.pairs[k].b}) ++all[point], agree[point] += same;
  }
  for (std::size_t i = 0; i < all.size(); ++i)
    if (2 * agree[i] < all[i]) strangers.push_back(i);
  return strangers;
}

void require_same_figure(const std::vector<std::string>& names, const std::vector<Eigen::Vector3d>& in_block,
                         const std::vector<Eigen::Vector3d>& in_control) {
  const Figure figure = figure_of(in_block, in_control);
  const std::vector<Pair>& pairs = figure.pairs;
  if (names.size() < 3 || pairs.empty() || 2 * figure.count >= pairs.size()) return;
  const Pair& low = pairs.front();
  const Pair& high = pairs.back();
  const auto words = [&](const Pair& p) {
    const std::string figures =
        fmt::format(", {:.4g} m by the control and {:.4g} in the block", (in_control[p.a] - in_control[p.b]).norm(),
                    (in_block[p.a] - in_block[p.b]).norm());
    return names[p.a] + " to " + names[p.b] + figures;
  };
  throw std::runtime_error("the " + std::to_string(names.size()) +
                           " control points are not the points of these names in the block: of " +
                           std::to_string(pairs.size()) + " distances between them only " +
                           std::to_string(figure.count) + " agree at one scale (" + words(low) + "; " + words(high) +
                           "); is the list that of another block, or numbered otherwise? Give the list of this block, "
                           "or say its names as the block has them");
}

void require_same_hand(const std::vector<Eigen::Vector3d>& in_block, const std::vector<Eigen::Vector3d>& in_control) {
  constexpr double far_better = 0.2;
  if (in_block.size() < 4) return;
  const auto rms_of = [&](double x_sign) {
    std::vector<Eigen::Vector3d> from = in_block;
    for (auto& point : from) point.x() *= x_sign;
    const SimilarityMotion motion = fit_similarity(from, in_control, true);
    double squares = 0;
    for (std::size_t k = 0; k < from.size(); ++k) squares += (in_control[k] - motion * from[k]).squaredNorm();
    return std::sqrt(squares / static_cast<double>(from.size()));
  };
  const double as_it_is = rms_of(1), mirrored = rms_of(-1);
  if (!(mirrored < far_better * as_it_is)) return;
  const std::string figures =
      fmt::format("mirrored it fits the approximate coordinates to {:.3g} m, as it is to {:.3g} m", mirrored, as_it_is);
  throw std::runtime_error(
      std::string("the control is the mirror image of the block: ") + figures +
      ". Are two of its coordinates exchanged (east and north), or has one the wrong sign? X, Y, Z "
      "have to be right-handed: X east, Y north, Z up");
}

}  // namespace plumbline::block
