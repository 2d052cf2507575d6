// The height of one small piece of a facade from all photographs that see it at once: least squares matching in object
// space, so that no photograph is the reference and no disparity has to be intersected afterwards.
//
// What a photograph shows of the facet is taken through the current height and slope; where they are wrong the patches
// lie beside each other by their parallaxes, and Gauss-Newton steps bring them together. Patches are compared after
// their own mean and contrast are taken out. Source: Wrobel (1987), Facets stereo vision; Helava (1988), Object-space
// least-squares correlation; Grün (1985), Adaptive least squares correlation, for the covariance.
#pragma once

#include <cstdint>
#include <vector>

#include "surface/dense/view.hpp"

namespace plumbline::surface {

enum class FacetOutcome : std::uint8_t {
  measured,
  too_few_views,   ///< fewer photographs than asked for see it
  no_texture,      ///< nothing on it fixes a height within the limit
  no_agreement,    ///< the photographs show different things: glass, a mirror, something in front
  ambiguous,       ///< a second height fits as well: a pattern that repeats
  outside_search,  ///< the best height lies at the border of what was searched
};
const char* to_string(FacetOutcome outcome);

struct FacetOptions {
  int half = 5;                  ///< a patch has (2 · half + 1)² samples
  double search = 0.05;          ///< heights from −search to search are looked at [m]
  int min_views = 3;             ///< photographs that have to agree
  double min_correlation = 0.7;  ///< of a photograph with the pattern that all show, noise apart
  double min_share = 0.6;        ///< of the photographs that see it have to agree: in a mirror a few may by chance
  double repetition = 0.02;      ///< a second height within so much of the best correlation is as good
  double max_sigma = 0.002;      ///< of a height [m]
};

/// One photograph of a facet.
struct FacetView {
  const View* view = nullptr;
  const Pyramid* image = nullptr;
};

/// What one photograph says of a facet against the others.
struct FacetPull {
  double height = 0;                                   ///< by which it pulls the height; zero of all together [m]
  Eigen::Vector2d parallax = Eigen::Vector2d::Zero();  ///< of its rays against the mean of all: by height [m/m]
  Eigen::Vector2d moved = Eigen::Vector2d::Zero();     ///< `texture` times the shift of its pattern against the mean
};

struct Facet {
  FacetOutcome outcome = FacetOutcome::too_few_views;
  Eigen::Vector2d place = Eigen::Vector2d::Zero();  ///< of its middle, u and v [m]
  double extent = 0;                                ///< of its edges; 0: as far as to the next facet [m]
  double height = 0;                                ///< [m]
  double sigma = 0;  ///< random part only: noise of the photographs, each place by itself [m]
  /// How many times larger the height's variance is because neighbouring places pull alike: where a facet is no plane,
  /// or the photographs show it in their own ways. 1 ± 0.4 of one facet if each place errs by itself.
  double neighbours = 1;
  /// How many times larger the grey values' variance is with the photographs that were left out because they disagree:
  /// the others were chosen for their agreement, and state the facet as if nobody had contradicted.
  double set_aside = 1;
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();  ///< by u and v
  double correlation = 0;                           ///< mean over the photographs that agree
  std::vector<int> views;                           ///< those, numbers into the list given
  /// What a shift of the pattern by 1 m in each of `views` does to the height: by u and v [m/m].
  std::vector<Eigen::Vector2d> by_shift;
  std::vector<FacetPull> pulls;                       ///< of each of `views`; empty where they were not matched at once
  Eigen::Matrix2d texture = Eigen::Matrix2d::Zero();  ///< what fixes a shift of the pattern: Σ g gᵀ of its slopes
};

/// Heights that fit at the coarsest level, the best first; at most `most`. `spacing`: of the samples at full
/// resolution [m]; place: u and v [m].
std::vector<double> search_heights(const FacadePlane& plane, const Eigen::Vector2d& place, double spacing,
                                   const std::vector<FacetView>& views, const FacetOptions& options, size_t most,
                                   bool* ambiguous);

/// The facet at (u, v), started from `start` [m].
Facet match_facet(const FacadePlane& plane, const Eigen::Vector2d& place, double spacing, double start,
                  const std::vector<FacetView>& views, const FacetOptions& options);

}  // namespace plumbline::surface
