#include "surface/dense/common_place.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "geometry/median.hpp"
#include "geometry/statistics.hpp"

namespace plumbline::surface {
namespace {

const double kSameFacade = std::cos(10 * M_PI / 180);

/// One panel or joint.
struct Off {
  double value, random, common;  ///< [m]; random variance [m²], common standard deviation [m]
  double at = 0;                 ///< along the facade in that direction [m]
};

CommonOffset mean_of(const std::vector<Off>& all) {
  CommonOffset result;
  result.count = static_cast<int>(all.size());
  if (all.empty()) return result;
  const double count = static_cast<double>(all.size());
  double random = 0, common = 0;
  for (const Off& one : all) {
    result.mean += one.value / count;
    random += one.random / (count * count), common += one.common / count;
  }
  result.sigma = std::sqrt(random + common * common);
  for (const Off& one : all) result.scatter += std::pow(one.value - result.mean, 2) / count;
  result.scatter = std::sqrt(result.scatter);
  return result;
}

/// The line through what they are off, by their places.
CommonScale scale_of(const std::vector<Off>& all) {
  constexpr double least = 2e-4;  // joints are not known to less [m]
  CommonScale result;
  result.count = static_cast<int>(all.size());
  if (all.size() < 3) return result;
  const auto count = static_cast<double>(all.size());
  double at = 0, value = 0, squares = 0, products = 0, misfit = 0;
  for (const Off& one : all) at += one.at / count, value += one.value / count;
  for (const Off& one : all) {
    squares += (one.at - at) * (one.at - at), products += (one.at - at) * (one.value - value);
    for (const Off& other : all) result.span = std::max(result.span, one.at - other.at);
  }
  if (!(squares > 0)) return result;
  result.slope = products / squares;
  for (const Off& one : all) misfit += std::pow(one.value - value - result.slope * (one.at - at), 2);
  result.sigma = std::max(least, std::sqrt(misfit / (count - 2))) / std::sqrt(squares);
  return result;
}

/// The best plane at the panel's middle: (1 − x²) has the mean 2/3.
Off out_of(const PanelSurface& surface) {
  Vector6 mean;
  mean << 1, 0, 0, 2.0 / 3, 2.0 / 3, 0;
  return {mean.dot(surface.form), mean.dot(surface.form_random * mean), (mean.transpose() * surface.form_factor).norm(),
          0};
}

/// Of the places along a joint.
bool shift_of(const MeasuredJoint& joint, Off& off) {
  std::vector<double> shifts, sigmas;
  for (const JointStation& station : joint.stations)
    if (std::isfinite(station.shift)) shifts.push_back(station.shift), sigmas.push_back(station.shift_sigma);
  if (shifts.empty()) return false;
  off = {median(shifts), 0, median(sigmas), 0};
  return true;
}

}  // namespace

bool CommonOffset::stands_out() const {
  constexpr double sure = 4, alike = 3, matters = 0.002;
  constexpr int least = 3;
  const double size = std::abs(mean);
  return count >= least && size > sure * sigma && size > alike * scatter && size > matters;
}

bool CommonScale::stands_out() const {
  constexpr double chance = 1e-3, matters = 0.002;
  constexpr int least = 4;
  if (count < least || !(sigma > 0) || !(std::abs(slope) * span > matters)) return false;
  return std::abs(slope) > student_t_quantile(1 - chance / 2, count - 2) * sigma;
}

std::vector<CommonPlace> common_places(const std::vector<PanelFace>& faces, const std::vector<PanelSurface>& surfaces,
                                       const std::vector<Joint>& joints, const std::vector<MeasuredJoint>& found) {
  std::vector<CommonPlace> places;
  for (const PanelFace& first : faces) {
    const Eigen::Vector3d out = first.plane.axes.col(2);
    const auto here = [&](const FacadePlane& plane) { return plane.axes.col(2).dot(out) > kSameFacade; };
    bool told = false;
    for (const CommonPlace& place : places) told = told || place.facade.dot(out) > kSameFacade;
    if (told) continue;
    std::vector<Off> planes, right, up;
    for (size_t f = 0; f < faces.size(); ++f)
      if (here(faces[f].plane) && surfaces[f].not_measured.empty()) planes.push_back(out_of(surfaces[f]));
    for (size_t j = 0; j < joints.size(); ++j)
      if (Off off; here(joints[j].plane) && shift_of(found[j], off)) {
        off.at = first.plane.axes.col(joints[j].upright ? 0 : 1).dot(joints[j].plane.origin);
        (joints[j].upright ? right : up).push_back(off);
      }
    places.push_back({first.id, out, mean_of(planes), mean_of(right), mean_of(up), scale_of(right), scale_of(up)});
  }
  return places;
}

std::string words_of_common_places(const std::vector<CommonPlace>& places) {
  std::string list;
  for (const CommonPlace& place : places) {
    const auto add = [&](const CommonOffset& offset, const char* what, const char* positive, const char* negative) {
      if (!offset.stands_out()) return;
      if (!list.empty()) list += "; ";
      if (places.size() > 1) list += "of the facade with " + place.first + ": ";
      list += fmt::format("all {} {} lie {:.1f} ± {:.1f} mm {}", offset.count, what, 1e3 * std::abs(offset.mean),
                          1e3 * offset.sigma, offset.mean > 0 ? positive : negative);
    };
    add(place.out, "panels", "before their place", "behind their place");
    add(place.right, "upright joints", "to the right of their place", "to the left of their place");
    add(place.up, "joints across", "above their place", "below their place");
  }
  if (list.empty()) return list;
  return "What was measured is beside its place as a whole, by more than is stated of that: " + list +
         ". Either the building is, or the scan's place is known less well than 'place_sigma' or its registration say; "
         "surveyed points tell which. Flatness, bow, steps and joint widths do not depend on it.";
}

std::string words_of_common_scales(const std::vector<CommonPlace>& places) {
  std::string list;
  for (const CommonPlace& place : places) {
    const auto add = [&](const CommonScale& scale, const char* what, const char* positive, const char* negative) {
      if (!scale.stands_out()) return;
      if (!list.empty()) list += "; ";
      if (places.size() > 1) list += "of the facade with " + place.first + ": ";
      list += fmt::format("{} {} lie {:.2f} ± {:.2f} mm further {} with each metre", scale.count, what,
                          1e3 * std::abs(scale.slope), 1e3 * scale.sigma, scale.slope > 0 ? positive : negative);
    };
    add(place.width, "upright joints", "to the right", "to the left");
    add(place.height, "joints across", "up", "down");
  }
  if (list.empty()) return list;
  return "What was measured is not as large as the design: " + list +
         ". Either the panels hang with another pitch, or the scan has another scale (its unit or map, a temperature): "
         "a length that was measured otherwise tells which. Shifts hold it, and so do sizes of panels; flatness, bow "
         "and "
         "steps do not depend on it.";
}

}  // namespace plumbline::surface
