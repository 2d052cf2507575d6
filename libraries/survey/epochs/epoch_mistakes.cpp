#include "survey/epochs/epoch_mistakes.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "geometry/statistics.hpp"
#include "survey/epochs/epoch_scale.hpp"
#include "survey/words/network_words.hpp"

namespace plumbline::survey {

namespace {

using Eigen::Index;
using Eigen::Vector3d;

std::vector<const Movement*> moved_points(const Comparison& c) {
  std::vector<const Movement*> found;
  for (const Movement& m : c.movements)
    if (m.moved) found.push_back(&m);
  return found;
}

/// Size of the second epoch in units of the first, over the points that both have in plan: in plan alone, as soon as
/// one of them lacks a height. None where no points have a plan (bench marks), or all the same.
std::optional<double> size_ratio(const Epoch& first, const Epoch& second) {
  std::vector<std::pair<Vector3d, Vector3d>> places;
  bool heights = true;
  for (size_t i = 0; i < first.ids.size(); ++i) {
    const auto at = std::find(second.ids.begin(), second.ids.end(), first.ids[i]);
    if (at == second.ids.end()) continue;
    Vector3d p = first.coordinates.segment<3>(static_cast<Index>(3 * i)),
             q = second.coordinates.segment<3>(static_cast<Index>(3 * (at - second.ids.begin())));
    if (!p.head<2>().allFinite() || !q.head<2>().allFinite()) continue;
    heights &= std::isfinite(p.z()) && std::isfinite(q.z());
    places.emplace_back(p, q);
  }
  Vector3d a = Vector3d::Zero(), b = a;
  for (auto& [p, q] : places) {
    if (!heights) p.z() = q.z() = 0;
    a += p, b += q;
  }
  const double n = static_cast<double>(std::max<size_t>(1, places.size()));
  double before = 0, after = 0;
  for (const auto& [p, q] : places) before += (p - a / n).squaredNorm(), after += (q - b / n).squaredNorm();
  const double ratio = std::sqrt(after / before);
  return std::isfinite(ratio) ? std::optional(ratio) : std::nullopt;
}

/// A scale takes out of the difference what no chance would.
bool scale_is_significant(const Epoch& first, const Epoch& second, ComparisonOptions options) {
  options.localise = false;
  const Comparison as_it_is = compare_epochs(first, second, options);
  const double variance = as_it_is.critical / chi_squared_quantile(1 - options.alpha, std::max(1, as_it_is.rank));
  ++options.free_motions;
  const double explained = as_it_is.statistic - compare_epochs(first, second, options).statistic;
  return explained > variance * chi_squared_quantile(1 - options.alpha0, 1);
}

/// Not of one point of leverage: the tip of a tower that settles is a scale to all that stand below it.
bool scale_is_of_all(const Epoch& first, const Epoch& second, const ComparisonOptions& options,
                     const std::vector<const Movement*>& moved) {
  return std::all_of(moved.begin(), moved.end(), [&](const Movement* m) {
    std::vector<char> keep;
    for (const std::string& id : first.ids) keep.push_back(id != m->id);
    return scale_is_significant(part_of(first, keep), second, options);
  });
}

/// One scale takes out of the difference what no chance would, all of it, and fewer points have moved with it. A few
/// points that moved look the same, so that it is told beside their movements and not taken off.
std::optional<EpochMistake> other_scale(const Epoch& first, const Epoch& second, const ComparisonOptions& options,
                                        const Comparison& compared) {
  constexpr std::size_t kLeastMoved = 3;
  if (options.free_motions != 4 && options.free_motions != 6) return std::nullopt;
  const std::vector<const Movement*> moved = moved_points(compared);
  const std::optional<double> ratio = size_ratio(first, second);
  if (moved.size() < kLeastMoved || !ratio || !scale_is_significant(first, second, options)) return std::nullopt;
  ComparisonOptions with_scale = options;
  ++with_scale.free_motions;
  EpochMistake mistake{"", "", compare_epochs(first, second, with_scale), with_scale.free_motions, false};
  if (!mistake.comparison.congruent || moved_points(mistake.comparison).size() >= moved.size()) return std::nullopt;
  if (!scale_is_of_all(first, second, options, moved)) return std::nullopt;
  mistake.words =
      scale_in_words(*ratio) +
      ", which explains the difference: a ppm setting, a prism constant, a map scale or the temperature was "
      "another (10 K make concrete 100 ppm longer)";
  mistake.undone = "The movements hold it: whether points moved or all distances changed these epochs do not tell";
  return mistake;
}

/// Where a point went another one was, and the reverse.
bool are_exchanged(const Movement& a, const Movement& b) {
  constexpr double kShare = 0.05;  // of what lies between them: they may have moved besides
  double apart = 0, off = 0;
  for (Index c = 0; c < 3; ++c) {
    if (!std::isfinite(a.movement[c]) || !std::isfinite(b.movement[c])) continue;
    const double between = b.position[c] - a.position[c];
    apart += between * between;
    off += std::pow(a.movement[c] - between, 2) + std::pow(b.movement[c] + between, 2);
  }
  return std::sqrt(off) < kShare * std::sqrt(apart);
}

std::optional<EpochMistake> exchanged_names(const Epoch& first, const Epoch& second, const ComparisonOptions& options,
                                            const Comparison& compared) {
  const std::vector<const Movement*> all = moved_points(compared);
  Epoch mended = second;
  std::string names;
  for (size_t i = 0; i < all.size(); ++i)
    for (size_t j = i + 1; j < all.size(); ++j) {
      if (!are_exchanged(*all[i], *all[j])) continue;
      const auto named = [&](const std::string& id) {
        return static_cast<size_t>(std::find(second.ids.begin(), second.ids.end(), id) - second.ids.begin());
      };
      std::swap(mended.ids[named(all[i]->id)], mended.ids[named(all[j]->id)]);
      names += (names.empty() ? "" : "; ") + all[i]->id + " and " + all[j]->id;
    }
  if (names.empty()) return std::nullopt;
  EpochMistake mistake{"", "", compare_epochs(first, mended, options), options.free_motions, true};
  if (moved_points(mistake.comparison).size() >= all.size()) return std::nullopt;
  mistake.words = names + " have each other's name in one of the epochs: each lies where the other was";
  mistake.undone = "Compared as if the second had them exchanged; mend the names in its file";
  return mistake;
}

}  // namespace

std::optional<EpochMistake> find_epoch_mistake(const Epoch& first, const Epoch& second,
                                               const ComparisonOptions& options, const Comparison& compared) {
  if (compared.congruent || moved_points(compared).empty()) return std::nullopt;
  try {
    if (auto mistake = exchanged_names(first, second, options, compared)) return mistake;
    return other_scale(first, second, options, compared);
  } catch (const std::runtime_error&) {  // too few points for a scale
    return std::nullopt;
  }
}

std::string two_bodies_in_words(const Comparison& compared) {
  const std::vector<std::string>& others = compared.other_body;
  if (others.empty()) return "";
  std::vector<std::string> moved;
  for (const Exclusion& e : compared.excluded) moved.push_back(e.id);
  const std::string bodies = std::to_string(moved.size()) + " points moved as one body against " +
                             std::to_string(others.size()) + " others: ",
                    way = "`stable` of a series, or control that the epochs hold (datum fixed)";
  if (compared.bodies_are_rivals())
    return bodies + "which of the two stayed these readings cannot tell. Movements are given as if " + join(others, 4) +
           " had stayed; say which did: " + way;
  return bodies +
         (moved.size() < others.size() ? "the many are taken for what stayed. "
                                       : "the few are taken for what stayed. ") +
         "If " + join(moved, 4) + " are the references, it was the others that moved; then say so: " + way;
}

}  // namespace plumbline::survey
