// What photographs pull facets apart by, against the heights' errors that really come of it.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "geometry/median.hpp"
#include "surface/dense/facet_sigmas.hpp"
#include "surface/dense/facet_tile.hpp"

namespace plumbline::surface {
namespace test_facet_sigmas {

constexpr size_t kViews = 6;

/// Facets of one tile as least squares leave them, if the pattern of each photograph is moved by `alike` on all facets
/// and by `own` on each by itself [m]. Source: the normal equations of heights with shifted patterns, written out.
class MovedPatterns {
 public:
  explicit MovedPatterns(std::uint64_t seed) : engine_(seed) {
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    for (Eigen::Vector2d& parallax : parallaxes_) parallax = 0.4 * drawn(), mean += parallax / kViews;
    for (Eigen::Vector2d& parallax : parallaxes_) parallax -= mean;
  }
  std::vector<Facet> facets(size_t count, double alike, double own) {
    std::vector<Eigen::Vector2d> common;
    for (size_t k = 0; k < kViews; ++k) common.push_back(alike * drawn());
    std::vector<Facet> made;
    for (size_t f = 0; f < count; ++f) made.push_back(one(common, own));
    return made;
  }

 private:
  Eigen::Vector2d drawn() { return {normal_(engine_), normal_(engine_)}; }
  Facet one(const std::vector<Eigen::Vector2d>& common, double own) {
    Facet facet;
    facet.outcome = FacetOutcome::measured, facet.sigma = 1e-4;
    const Eigen::Vector2d a = drawn(), b = drawn();
    facet.texture = 1e6 * (a * a.transpose() + b * b.transpose() + 0.5 * Eigen::Matrix2d::Identity());
    std::vector<Eigen::Vector2d> shifts;
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    double weight = 0;
    for (size_t k = 0; k < kViews; ++k) {
      shifts.push_back(common[k] + own * drawn()), mean += shifts.back() / kViews;
      weight += parallaxes_[k].dot(facet.texture * parallaxes_[k]);
    }
    // Of the shifts that this facet alone has; the height that all of them together make is what is to be stated.
    for (size_t k = 0; k < kViews; ++k) facet.height -= parallaxes_[k].dot(facet.texture * shifts[k]) / weight;
    for (size_t k = 0; k < kViews; ++k) {
      FacetPull pull;
      pull.moved = facet.texture * (shifts[k] - mean + parallaxes_[k] * facet.height);
      pull.height = -parallaxes_[k].dot(pull.moved) / weight;
      pull.parallax = parallaxes_[k];
      facet.pulls.push_back(pull), facet.views.push_back(static_cast<int>(k));
      facet.by_shift.push_back(-(facet.texture * parallaxes_[k]) / weight);
    }
    return facet;
  }

  std::array<Eigen::Vector2d, kViews> parallaxes_;
  std::mt19937_64 engine_;
  std::normal_distribution<double> normal_{0, 1};
};

std::vector<const Facet*> listed(const std::vector<Facet>& facets) {
  std::vector<const Facet*> list;
  for (const Facet& facet : facets) list.push_back(&facet);
  return list;
}

/// The variance that is stated is that of the heights about what all of them are off by: that, the orientations'
/// covariance states.
TEST(FacetSigmas, VariancesAreThoseOfTheHeightsAboutTheirMean) {
  for (const double alike : {0.0, 3e-4, 2e-3}) {
    double variance = 0, stated = 0;
    constexpr int trials = 60;
    for (std::uint64_t trial = 0; trial < trials; ++trial) {
      const std::vector<Facet> facets = MovedPatterns(trial).facets(40, alike, 3e-4);
      const ViewScatter scatter = view_scatter(listed(facets));
      double sum = 0, squares = 0, own = 0;
      for (const Facet& facet : facets) sum += facet.height, squares += facet.height * facet.height;
      for (size_t i = 0; i < 40; ++i) own += scatter.apart[i] * 1e-8 / 40 + std::pow(scatter.uneven[i], 2) / 39;
      variance += (squares - sum * sum / 40) / 39 / trials, stated += own / trials;
    }
    EXPECT_NEAR(stated / variance, 1, 0.15) << alike;
  }
}

TEST(FacetSigmas, WhatAllFacetsShareMovesThemUnevenlyAndPullsNothingApart) {
  const std::vector<Facet> facets = MovedPatterns(1).facets(40, 2e-3, 0);
  const ViewScatter scatter = view_scatter(listed(facets));
  double uneven = 0;
  for (const double one : scatter.uneven) uneven += one * one / 40;
  for (const double apart : scatter.apart) EXPECT_LT(apart * 1e-8, 0.02 * uneven);
  EXPECT_GT(uneven, 1e-8);
  // Of a facet alone nobody can tell, and the larger is stated.
  const std::vector<Facet> alone = MovedPatterns(1).facets(1, 2e-3, 0);
  EXPECT_GT(stated_sigmas(listed(alone))[0], 2e-4);
}

TEST(FacetSigmas, OfFewPhotographsOrNoneItIsNotKnown) {
  Facet bare;
  bare.outcome = FacetOutcome::measured, bare.sigma = 2e-4, bare.neighbours = 4, bare.views = {0, 1, 2};
  Facet hole;
  const std::vector<const Facet*> both = {&bare, &hole};
  EXPECT_EQ(view_scatter(both).apart, (std::vector<double>{1, 1}));
  EXPECT_NEAR(stated_sigmas(both)[0], 4e-4, 1e-12) << "by its neighbouring places alone";
  EXPECT_EQ(stated_sigmas(both)[1], 0);
}

/// One whose photographs contradict each other, at the border of a plate before the facade, is a hole and leaves the
/// others as sure as they are.
TEST(FacetSigmas, WhatComesOutWorseThanAskedForIsAHole) {
  std::vector<Facet> facets = MovedPatterns(5).facets(40, 0, 1e-4);
  std::vector<const Facet*> all;
  for (const Facet& facet : facets) all.push_back(&facet);
  const double usual = upper_median(stated_sigmas(all));
  for (FacetPull& pull : facets[7].pulls) pull.height *= 1e3, pull.moved *= 1e3;
  EXPECT_LT(facets[7].sigma, 0.002);
  std::vector<std::pair<Eigen::Vector2d, Facet>> placed;
  for (size_t i = 0; i < facets.size(); ++i)
    placed.emplace_back(Eigen::Vector2d(0.02 * static_cast<double>(i), 0), facets[i]);
  const FacadePlane plane = facade_plane({0, 0, 0}, {0, -1, 0});
  View away;  // it sees none of it, so that nothing is said of orientations
  away.cam_from_world.translation = {0, 0, -100};
  const std::vector<FacetView> views(kViews, FacetView{&away, nullptr});
  const FacetTile tile = tile_of(plane, {{0, 0}, {0.8, 0.02}}, placed, views, {}, 0.002);
  EXPECT_EQ(tile.measured.points.size(), 39U);
  EXPECT_EQ(tile.outcomes[static_cast<size_t>(FacetOutcome::no_agreement)], 1);
  std::vector<double> sigmas;
  for (const MeasuredPoint& point : tile.measured.points) sigmas.push_back(static_cast<double>(point.sigma));
  EXPECT_NEAR(upper_median(sigmas), usual, 0.3 * usual);
}

/// Facets in a square, 20 mm apart, as large as that, on a plane that leans, each off by a tenth of a millimetre.
std::vector<Facet> in_a_square(int side, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal(0, 1);
  std::vector<Facet> facets(static_cast<size_t>(side) * side);
  for (size_t i = 0; i < facets.size(); ++i) {
    Facet& facet = facets[i];
    facet.outcome = FacetOutcome::measured, facet.sigma = 1e-4, facet.extent = 0.02;
    facet.place = 0.02 * Eigen::Vector2d(static_cast<double>(i % side), static_cast<double>(i / side)) +
                  Eigen::Vector2d(0.11, -0.27);
    facet.height = 0.3 * facet.place.x() - 0.2 * facet.place.y() + facet.sigma * normal(engine);
  }
  return facets;
}

/// A height that nothing around it supports is something else that was matched, however well: a hole, and its
/// neighbours stay as sure as they were.
TEST(FacetSigmas, AHeightThatStandsAloneIsAHole) {
  std::vector<Facet> facets = in_a_square(9, 2);
  const std::vector<double> even = stated_sigmas(listed(facets));
  EXPECT_LT(upper_median(even), 1.1e-4) << "noise alone is no relief, nor is a plane that leans";
  EXPECT_LT(*std::max_element(even.begin(), even.end()), 1.7e-4);
  for (const size_t alone : {size_t{30}, size_t{0}, size_t{44}}) {  // within, at a corner, at the border
    facets[alone].height += 0.02;
    const std::vector<double> sigmas = sigmas_within(listed(facets), 0.002);
    for (size_t i = 0; i < sigmas.size(); ++i)
      if (i == alone)
        EXPECT_TRUE(std::isinf(sigmas[i])) << alone << ": " << sigmas[i];
      else
        EXPECT_LT(sigmas[i], 2e-4) << alone << " " << i;
    facets[alone].height -= 0.02;
  }
  // Of two halves that stand 20 mm apart each supports itself.
  for (Facet& facet : facets) facet.height += facet.place.x() > 0.2 ? 0.02 : 0;
  const std::vector<double> step = sigmas_within(listed(facets), 0.002);
  EXPECT_LE(std::count_if(step.begin(), step.end(), [](double sigma) { return std::isinf(sigma); }), 18);
}

}  // namespace test_facet_sigmas
}  // namespace plumbline::surface
