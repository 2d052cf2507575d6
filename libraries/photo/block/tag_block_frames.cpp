// Whether control and approximate values speak of the same places.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "base/text/words.hpp"
#include "geometry/exchanged_places.hpp"
#include "geometry/similarity.hpp"
#include "least_squares/problem/defects.hpp"
#include "photo/block/tag_block_model.hpp"

namespace plumbline::block {
namespace {

constexpr double same_place = 0.25;  ///< [m] closer than two plates hang
constexpr double near_enough = 2;    ///< [m] approximate values this far off are good enough to start from

struct PlatePair {
  size_t plate = 0;  ///< index into start.plates
  Eigen::Vector3d placed, surveyed;
};

std::vector<PlatePair> pairs_of(const TagBlock& block, const TagStart& start) {
  std::vector<PlatePair> pairs;
  for (size_t k = 0; k < block.control.plates.size(); ++k) {
    const auto at = std::find(start.plates.begin(), start.plates.end(), block.control.plates[k]);
    if (at == start.plates.end()) continue;
    const size_t plate = static_cast<size_t>(at - start.plates.begin());
    pairs.push_back({plate, start.world_from_plate[plate].translation,
                     block.control.position.segment<3>(3 * static_cast<Eigen::Index>(k))});
  }
  return pairs;
}

bool is_figure(const std::vector<Eigen::Vector3d>& points) {
  double area = 0, length = 0;
  for (const auto& p : points)
    for (const auto& q : points) {
      length = std::max(length, (p - points[0]).norm());
      area = std::max(area, (p - points[0]).cross(q - points[0]).norm());
    }
  return points.size() >= 3 && area > 0.02 * length * length;
}

/// The similarity that most control points agree with: the largest residual leaves until all are near, or half is gone.
struct Agreement {
  SimilarityMotion motion;
  std::vector<PlatePair> agreeing, other;
  bool found = false;
};

Agreement agree(std::vector<PlatePair> pairs) {
  Agreement result;
  const size_t least = std::max<size_t>(3, (pairs.size() + 2) / 2);
  while (pairs.size() >= least) {
    std::vector<Eigen::Vector3d> from, to;
    for (const auto& p : pairs) from.push_back(p.placed), to.push_back(p.surveyed);
    if (!is_figure(from) || !is_figure(to)) return result;
    result.motion = fit_similarity(from, to, true);
    const auto residual = [&](const PlatePair& p) { return (result.motion * p.placed - p.surveyed).norm(); };
    const auto worst = std::max_element(
        pairs.begin(), pairs.end(), [&](const PlatePair& a, const PlatePair& b) { return residual(a) < residual(b); });
    if (residual(*worst) < same_place) {
      result.agreeing = pairs;
      result.found = true;
      return result;
    }
    result.other.push_back(*worst);
    pairs.erase(worst);
  }
  return result;
}

std::string in_words(const SimilarityMotion& motion, const Eigen::Vector3d& at) {
  const Eigen::AngleAxisd turn(motion.rotation);
  const double shift = (motion * at - at).norm();
  return fmt::format("{:.3g} {} apart, turned by {:.2f} degrees", shift > 1000 ? shift / 1000 : shift,
                     shift > 1000 ? "km" : "m", std::abs(turn.angle()) * 180 / M_PI);
}

[[noreturn]] void refuse_scale(double scale) {
  const std::pair<double, const char*> units[] = {{0.3048, "metres where feet were expected"},
                                                  {1 / 0.3048, "feet"},
                                                  {1000, "millimetres"},
                                                  {100, "centimetres"},
                                                  {0.001, "metres where millimetres were expected"}};
  std::string cause = "another unit, or tags whose size is not the one given";
  for (const auto& [factor, name] : units)
    if (std::abs(scale / factor - 1) < 0.02) cause = std::string("the control is in ") + name + ", or the tag size is";
  throw std::runtime_error(std::string("distances between control points are ") + fmt::format("{:.4g}", scale) +
                           " times those between the plates in the images: " + cause);
}

/// Control against the similarity of all the others, one point after the other.
struct LeftAlone {
  double others = 0;  ///< largest residual of the others [m]
  Eigen::Vector3d off = Eigen::Vector3d::Zero();
};

std::vector<LeftAlone> left_alone(const std::vector<PlatePair>& pairs) {
  std::vector<LeftAlone> result;
  for (size_t k = 0; k < pairs.size(); ++k) {
    std::vector<Eigen::Vector3d> from, to;
    for (size_t i = 0; i < pairs.size(); ++i)
      if (i != k) from.push_back(pairs[i].placed), to.push_back(pairs[i].surveyed);
    if (!is_figure(from) || !is_figure(to)) return {};
    const SimilarityMotion motion = fit_similarity(from, to, true);
    LeftAlone one;
    for (size_t i = 0; i < from.size(); ++i) one.others = std::max(one.others, (motion * from[i] - to[i]).norm());
    one.off = pairs[k].surveyed - motion * pairs[k].placed;
    result.push_back(one);
  }
  return result;
}

/// Control points that lie where other plates hang.
void refuse_exchanged(const TagBlock& block, const TagStart& start, const Agreement& agreement) {
  std::vector<std::string> exchanged;
  std::vector<Eigen::Vector3d> placed, surveyed;
  for (const PlatePair& pair : agreement.other)
    placed.push_back(agreement.motion * pair.placed), surveyed.push_back(pair.surveyed);
  const auto anchor = [&](size_t k) { return block.plates[start.plates[agreement.other[k].plate]].anchor; };
  const auto tell = [&](size_t thing, size_t place) {
    exchanged.push_back("the plate of " + anchor(thing) + " hangs where the survey has " + anchor(place));
  };
  for (const ExchangedPlace& pair : exchanged_places(placed, surveyed)) {
    tell(pair.thing, pair.place);
    if (pair.mutual) tell(pair.place, pair.thing);
  }
  if (!exchanged.empty())
    throw std::runtime_error(text::enumerate(exchanged) +
                             ": plates or names in the survey are exchanged; correct the plate table or the survey");
}

}  // namespace

std::optional<FarControl> furthest_control(const TagBlock& block) {
  constexpr size_t least = 6, most = 1000;  // fewer hardly check each other
  constexpr double apart = 10, stands_out = 5;
  if (block.control.plates.size() < least || block.control.plates.size() > most) return std::nullopt;
  std::vector<std::string> unused;
  const TagStart start = start_tag_block(block, std::vector<bool>(block.observations.size(), true), unused);
  const std::vector<PlatePair> pairs = pairs_of(block, start);
  if (pairs.size() < least || pairs.size() > most) return std::nullopt;
  const std::vector<LeftAlone> without = left_alone(pairs);
  if (without.empty()) return std::nullopt;
  size_t worst = 0;
  for (size_t k = 0; k < without.size(); ++k)
    if (without[k].others < without[worst].others) worst = k;
  double next = std::numeric_limits<double>::infinity();
  for (size_t k = 0; k < without.size(); ++k)
    if (k != worst) next = std::min(next, without[k].others);
  const double rest = without[worst].others;
  return FarControl{start.plates[pairs[worst].plate], pairs.size(), without[worst].off,
                    without[worst].off.norm() > apart * rest && next > stands_out * rest};
}

std::string in_words(const FarControl& far, const TagBlock& block) {
  const Eigen::Vector3d off = 1e3 * far.off;
  return fmt::format(
      "of the control that of {} lies furthest from where the photographs and all the others have it, by {:.1f}, "
      "{:.1f}, {:.1f} mm: is it right?",
      block.plates[far.plate].anchor, off.x(), off.y(), off.z());
}

void move_to_control(const TagBlock& block, TagStart& start, std::vector<std::string>& warnings) {
  const std::vector<PlatePair> pairs = pairs_of(block, start);
  if (pairs.size() < 3) return;
  const Agreement agreement = agree(pairs);
  if (!agreement.found) return;
  if (std::abs(agreement.motion.scale - 1) > 0.05) refuse_scale(agreement.motion.scale);
  refuse_exchanged(block, start, agreement);
  double furthest = 0;
  for (const PlatePair& pair : agreement.agreeing) furthest = std::max(furthest, (pair.placed - pair.surveyed).norm());
  if (furthest < near_enough) return;
  std::vector<Eigen::Vector3d> from, to;
  for (const PlatePair& pair : agreement.agreeing) from.push_back(pair.placed), to.push_back(pair.surveyed);
  const SimilarityMotion motion = fit_similarity(from, to, false);
  const RigidTransform move{motion.rotation, motion.translation};
  warnings.push_back("survey and approximate positions (design) are in different frames, " +
                     in_words(motion, agreement.agreeing.front().placed) +
                     ": the image block was adjusted in the frame of the survey");
  for (auto& plate : start.world_from_plate) plate = move * plate;
  for (auto& pose : start.cam_from_world) pose = pose * move.inverse();
}

}  // namespace plumbline::block
