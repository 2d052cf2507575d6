// A piece of a facade measured facet by facet: points, holes with their reason, and the share of the photographs'
// orientations in the heights.
#pragma once

#include <array>
#include <utility>

#include "surface/dense/facet.hpp"
#include "surface/dense/measured_points.hpp"

namespace plumbline::surface {

/// u and v on a facade's plane [m].
struct Rectangle {
  Eigen::Vector2d low = Eigen::Vector2d::Zero(), high = Eigen::Vector2d::Zero();
};

struct FacetTile {
  MeasuredTile measured;                            ///< without factor
  Eigen::Vector2d place = Eigen::Vector2d::Zero();  ///< of its centre, u and v [m]
  /// Height error = (1, u − place.u, v − place.v) · sensitivity · (errors of the orientations, in the order of
  /// OrientationCovariance).
  Eigen::MatrixXd sensitivity;
  std::array<int, 6> outcomes{};  ///< facets by FacetOutcome
};

struct TileOptions {
  FacetOptions facet;
  double pitch =
      0.02;  ///< between the centres of facets; no less than a facet's size is used, so that noise is each's own [m]
  int max_views = 8;  ///< the best ones: small on the ground, and far from each other
};

/// Measures `area` of the plane. `orientations`: unknowns of all photographs and cameras, of which only the numbers are
/// used here. Same input, same bits.
FacetTile measure_tile(const FacadePlane& plane, const Rectangle& area, const std::vector<FacetView>& views,
                       const OrientationCovariance& orientations, const TileOptions& options);

/// A tile of facets, each at its place (u, v), with the share of the orientations in their heights; standard deviations
/// as sigmas_within says: what comes out less sure than `max_sigma` [m] is a hole, as its photographs disagree.
FacetTile tile_of(const FacadePlane& plane, const Rectangle& area,
                  const std::vector<std::pair<Eigen::Vector2d, Facet>>& facets, const std::vector<FacetView>& views,
                  const OrientationCovariance& orientations, double max_sigma);

/// `rows`, derivatives of lengths by the orientations, times a root of their joint covariance: F with F Fᵀ = rows Σ
/// rowsᵀ, in as few columns as hold all but `lost` of the variance. Throws as add_systematic_part().
Eigen::MatrixXd reduced_factor(const Eigen::MatrixXd& rows, const OrientationCovariance& orientations,
                               double lost = 1e-6);

/// Gives all tiles, measured on one of `planes` each, their factor: what the orientations' joint covariance says of
/// each, reduced to the directions that hold all but `lost` of the variance. Throws std::invalid_argument for a
/// covariance of another size, and std::runtime_error for one that is not positive semidefinite.
void add_systematic_part(std::vector<FacetTile>& tiles, const std::vector<FacadePlane>& planes,
                         const OrientationCovariance& orientations, double lost = 1e-6);

}  // namespace plumbline::surface
