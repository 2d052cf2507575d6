#include "block/control_words.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "block/defects.hpp"

namespace plumbline::adjust {
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
                      result.world_from_plate[static_cast<size_t>(j)].toRotationMatrix());
    places.push_back(adjusted);
    centre += adjusted;
  }
  const auto n = static_cast<Eigen::Index>(rows.size());
  if (n < 6) return Eigen::Vector3d::Zero();
  centre /= static_cast<double>(n);
  Eigen::MatrixXd a(3 * n, 9);
  Eigen::VectorXd r(3 * n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const auto& [residual, rotation] = rows[static_cast<size_t>(k)];
    a.block<3, 3>(3 * k, 0).setIdentity();
    a.block<3, 3>(3 * k, 3) = -skew(places[static_cast<size_t>(k)] - centre);
    a.block<3, 3>(3 * k, 6) = rotation;
    r.segment<3>(3 * k) = residual;
  }
  const auto rest = [&](Eigen::Index columns, Eigen::VectorXd& x) {
    x = a.leftCols(columns).colPivHouseholderQr().solve(r);
    return (r - a.leftCols(columns) * x).squaredNorm();
  };
  Eigen::VectorXd motion, all;
  const double before = rest(6, motion), after = rest(9, all);
  return after < 0.1 * before ? Eigen::Vector3d(all.tail<3>()) : Eigen::Vector3d::Zero();
}

}  // namespace

std::string control_in_words(const TagBlock& block, const TagBlockResult& result) {
  const Eigen::Vector3d offset = common_offset(block, result);
  char text[200];
  if (offset.norm() > 0.002) {
    std::snprintf(
        text, sizeof text,
        "; the offset of the tag on its plate is wrong on all plates: by about %.0f, %.0f, %.0f mm in the plate "
        "table's tag_x, tag_y, tag_z",
        1e3 * offset.x(), 1e3 * offset.y(), 1e3 * offset.z());
    return text;
  }
  std::vector<std::pair<double, std::string>> worst;
  for (const AdjustedControl& control : result.control) {
    double w = 0;
    for (const auto& coordinate : control.coordinates) w = std::max(w, std::abs(coordinate.w));
    worst.emplace_back(-w, block.plates[static_cast<size_t>(control.plate)].anchor);
  }
  std::sort(worst.begin(), worst.end());
  std::vector<std::string> names;
  for (size_t i = 0;
       i < std::min<size_t>(worst.size(), 3) && worst[i].first < -4 && worst[i].first < 0.5 * worst[0].first; ++i) {
    std::snprintf(text, sizeof text, " (w = %.0f)", -worst[i].first);
    names.push_back(worst[i].second + text);
  }
  return names.empty() ? ""
                       : "; most at " + enumerate(names) +
                             ": its surveyed point, its tag or the offset of the tag on its plate is wrong";
}

}  // namespace plumbline::adjust
