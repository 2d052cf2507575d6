#include "surface/dense/facet_sigmas.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include "geometry/median.hpp"
#include "surface/dense/facet_relief.hpp"

namespace plumbline::surface {
namespace {

/// Of relief too fine for a facet, the part by which its height is off: by that 99 % of the differences of two
/// measurements of the walls of fountain-P11 and Herz-Jesus-P8 lie within 3 sigma (benchmarks/surfaces).
constexpr double kPartOfRelief = 1.0 / 3;

/// What a photograph is off on all facets alike.
struct CommonShift {
  Eigen::Matrix2d texture = Eigen::Matrix2d::Zero();
  int facets = 0;
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();  ///< [m]
};

/// Height by which the common shifts move a facet [m].
double raised_by(const Facet& facet, const std::map<int, CommonShift>& common) {
  double raised = 0;
  for (size_t k = 0; k < facet.pulls.size(); ++k) raised += facet.by_shift[k].dot(common.at(facet.views[k]).shift);
  return raised;
}

/// Least squares of shifts and heights in turn; what shifts and heights may do in each other's place they take as it
/// comes, since only what is left counts.
std::map<int, CommonShift> common_shifts(const std::vector<const Facet*>& facets) {
  std::map<int, CommonShift> common;
  for (const Facet* facet : facets)
    for (size_t k = 0; k < facet->pulls.size(); ++k)
      common[facet->views[k]].texture += facet->texture, ++common[facet->views[k]].facets;
  for (int round = 0; round < 6; ++round) {
    std::map<int, Eigen::Vector2d> moved;
    for (const auto& of_view : common) moved[of_view.first].setZero();
    for (const Facet* facet : facets) {
      const double raised = raised_by(*facet, common);
      for (size_t k = 0; k < facet->pulls.size(); ++k)
        moved[facet->views[k]] += facet->pulls[k].moved - facet->texture * facet->pulls[k].parallax * raised;
    }
    for (auto& [view, of_view] : common) {
      if (of_view.facets < 2) continue;  // of a facet alone nothing says what it has in common with others
      const double little = 1e-6 * of_view.texture.trace();  // texture of one direction fixes no shift across it
      of_view.shift = (of_view.texture + little * Eigen::Matrix2d::Identity()).inverse() * moved[view];
    }
  }
  return common;
}

double apart_of(const Facet& facet, const std::map<int, CommonShift>& common) {
  const double raised = raised_by(facet, common), count = static_cast<double>(facet.pulls.size());
  double apart = 0, left = 0;
  for (size_t k = 0; k < facet.pulls.size(); ++k) {
    const FacetPull& pull = facet.pulls[k];
    const CommonShift& all = common.at(facet.views[k]);
    const double own = pull.height - facet.by_shift[k].dot(all.shift + pull.parallax * raised);
    apart += own * own * (all.facets > 1 ? static_cast<double>(all.facets) / (all.facets - 1) : 1);
    const double share = -facet.by_shift[k].dot(pull.parallax);  // of the height's weight
    left += share * (1 - 1 / count - share);
  }
  return left > 1e-3 && facet.sigma > 0 ? apart / left / (facet.sigma * facet.sigma) : 1;
}

}  // namespace

ViewScatter view_scatter(const std::vector<const Facet*>& facets) {
  const std::map<int, CommonShift> common = common_shifts(facets);
  ViewScatter scatter;
  double count = 0, mean = 0;
  for (const Facet* facet : facets) {
    const bool known = facet->outcome == FacetOutcome::measured && !facet->pulls.empty();
    scatter.apart.push_back(known ? apart_of(*facet, common) : 1);
    scatter.uneven.push_back(known ? raised_by(*facet, common) : std::nan(""));
    if (known) count += 1, mean += scatter.uneven.back();
  }
  for (double& uneven : scatter.uneven) uneven = std::isnan(uneven) ? 0 : uneven - mean / count;
  return scatter;
}

std::vector<double> stated_sigmas(const std::vector<const Facet*>& facets, double others) {
  const ViewScatter scatter = view_scatter(facets);
  const std::vector<double> relief = relief_around(facets);
  double neighbours = 0, apart = 0, count = 0;
  for (size_t i = 0; i < facets.size(); ++i)
    if (facets[i]->outcome == FacetOutcome::measured)
      neighbours += facets[i]->neighbours, apart += scatter.apart[i], count += 1;
  const double common = std::max({1.0, neighbours / std::max(count, 1.0), apart / std::max(count, 1.0)});
  std::vector<double> sigmas;
  for (size_t i = 0; i < facets.size(); ++i) {
    const Facet& facet = *facets[i];
    const double own = std::max(0.0, static_cast<double>(facet.pulls.size()) - 2);
    const double larger = std::max(common, (others * common + own * scatter.apart[i]) / (others + own));
    const double of_form = kPartOfRelief * relief[i];
    sigmas.push_back(facet.outcome == FacetOutcome::measured
                         ? std::sqrt(facet.sigma * facet.sigma * larger * facet.set_aside +
                                     scatter.uneven[i] * scatter.uneven[i] + of_form * of_form)
                         : 0);
  }
  return sigmas;
}

std::vector<double> sigmas_within(const std::vector<const Facet*>& facets, double most) {
  std::vector<const Facet*> left = facets;
  std::vector<size_t> numbers(facets.size());
  std::iota(numbers.begin(), numbers.end(), size_t{0});
  std::vector<double> sigmas(facets.size(), std::numeric_limits<double>::infinity());
  // Of a facade where all facets are known a little worse than asked for none is another thing than the rest.
  std::vector<double> measured;
  const std::vector<double> first = stated_sigmas(left);
  for (size_t i = 0; i < left.size(); ++i)
    if (left[i]->outcome == FacetOutcome::measured) measured.push_back(first[i]);
  constexpr double far_worse = 3;  // than half of the others
  if (!measured.empty()) most = std::max(most, far_worse * upper_median(measured));
  for (;;) {
    const std::vector<double> found = stated_sigmas(left);
    const double worst = found.empty() ? 0 : *std::max_element(found.begin(), found.end());
    if (!(worst > most)) {
      for (size_t i = 0; i < left.size(); ++i) sigmas[numbers[i]] = found[i];
      return sigmas;
    }
    size_t kept = 0;
    for (size_t i = 0; i < left.size(); ++i)
      if (!(found[i] > std::max(most, 0.5 * worst))) left[kept] = left[i], numbers[kept++] = numbers[i];
    left.resize(kept), numbers.resize(kept);
  }
}

}  // namespace plumbline::surface
