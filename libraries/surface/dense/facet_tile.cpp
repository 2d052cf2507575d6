#include "surface/dense/facet_tile.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <stdexcept>

#include "geometry/linear_algebra/decompositions.hpp"
#include "plumbline/stop.hpp"
#include "surface/dense/facet_sigmas.hpp"

namespace plumbline::surface {
namespace {

/// The photographs of a tile: those with the smallest pixels on the ground first, but one that looks along a ray
/// already taken (within 3 % of the height's parallax) only when no other is left, and none from the place of another.
std::vector<FacetView> best_views(const FacadePlane& plane, const Eigen::Vector2d& place,
                                  const std::vector<FacetView>& views, int most, double* spacing) {
  struct Candidate {
    FacetView view;
    Eigen::Vector2d parallax;
    double ground;
  };
  std::vector<Candidate> candidates;
  for (const FacetView& view : views) {
    const auto map = map_at(*view.view, plane, {place.x(), place.y(), 0}, 8);
    if (map && map->parallax().norm() < 2.5) candidates.push_back({view, map->parallax(), map->ground_pixel()});
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const auto& a, const auto& b) { return a.ground < b.ground; });
  while (!candidates.empty() && candidates.back().ground > 2.5 * candidates.front().ground) candidates.pop_back();
  std::vector<Candidate> chosen, near;
  for (const Candidate& candidate : candidates) {
    const auto within = [&](double slope) {
      return
          [&candidate, slope](const Candidate& other) { return (other.parallax - candidate.parallax).norm() < slope; };
    };
    if (std::any_of(chosen.begin(), chosen.end(), within(kOnePlace)) ||
        std::any_of(near.begin(), near.end(), within(kOnePlace)))
      continue;
    const bool alike = std::any_of(chosen.begin(), chosen.end(), within(0.03));
    (alike ? near : chosen).push_back(candidate);
  }
  chosen.insert(chosen.end(), near.begin(), near.end());
  if (static_cast<int>(chosen.size()) > most) chosen.resize(most);
  std::vector<FacetView> result;
  *spacing = 0;
  for (const Candidate& candidate : chosen) {
    result.push_back(candidate.view);
    *spacing = std::max(*spacing, candidate.ground);
  }
  return result;
}

/// Row of the derivatives of a facet's height by all orientations.
Eigen::VectorXd by_orientations(const FacadePlane& plane, const Eigen::Vector3d& place, const Facet& facet,
                                const std::vector<FacetView>& views, const OrientationCovariance& orientations) {
  Eigen::VectorXd row = Eigen::VectorXd::Zero(orientations.size());
  for (size_t i = 0; i < facet.views.size(); ++i) {
    const View& view = *views[facet.views[i]].view;
    const auto map = map_at(view, plane, place, -1e6);
    if (!map) continue;
    const Eigen::RowVector2d by_pixel = facet.by_shift[i].transpose() * map->by_place.leftCols<2>().inverse();
    if (view.orientation >= 0)
      row.segment<8>(orientations.of_image(view.orientation)) += (by_pixel * map->by_image).transpose();
    if (view.camera_number < orientations.cameras)
      row.segment<9>(orientations.of_camera(view.camera_number)) += (by_pixel * map->by_camera).transpose();
  }
  return row;
}

/// Least squares of a height and two slopes over the facets' rows, weighted as a plane would weight them.
struct TileSensitivity {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::MatrixXd right;
  void add(const Eigen::Vector2d& from_centre, double weight, const Eigen::VectorXd& row) {
    const Eigen::Vector3d base(1, from_centre.x(), from_centre.y());
    if (right.size() == 0) right = Eigen::MatrixXd::Zero(3, row.size());
    normal += weight * base * base.transpose();
    right.noalias() += weight * base * row.transpose();
  }
  Eigen::MatrixXd solved(double size, int count) const {
    Eigen::Matrix3d regular = normal;  // one or two facets say nothing of slopes
    const double weight = normal(0, 0) / std::max(count, 1);
    regular(1, 1) += 1e-3 * weight * size * size, regular(2, 2) += 1e-3 * weight * size * size;
    return regular.ldlt().solve(right);
  }
};

/// Starts of a cell: what the coarse search found there and around, without doubles.
std::vector<double> starts_of(const std::vector<std::vector<double>>& found, int columns, int rows, int column, int row,
                              double apart) {
  std::vector<double> starts;
  for (int ring = 0; ring <= 1; ++ring)
    for (int r = std::max(row - ring, 0); r <= std::min(row + ring, rows - 1); ++r)
      for (int c = std::max(column - ring, 0); c <= std::min(column + ring, columns - 1); ++c) {
        const auto& here = found[static_cast<size_t>(r) * columns + c];
        for (size_t k = 0; k < (ring == 0 ? here.size() : std::min<size_t>(here.size(), 1)); ++k)
          if (std::none_of(starts.begin(), starts.end(), [&](double s) { return std::abs(s - here[k]) < apart; }))
            starts.push_back(here[k]);
      }
  return starts;
}

}  // namespace

FacetTile tile_of(const FacadePlane& plane, const Rectangle& area,
                  const std::vector<std::pair<Eigen::Vector2d, Facet>>& facets, const std::vector<FacetView>& views,
                  const OrientationCovariance& orientations, double max_sigma) {
  FacetTile tile;
  tile.place = 0.5 * (area.low + area.high);
  tile.measured.centre = plane.world({tile.place.x(), tile.place.y(), 0});
  tile.sensitivity = Eigen::MatrixXd::Zero(3, orientations.size());
  TileSensitivity sensitivity;
  std::vector<const Facet*> all;
  for (const auto& [at, facet] : facets) all.push_back(&facet);
  const std::vector<double> sigmas = sigmas_within(all, max_sigma);
  for (size_t i = 0; i < facets.size(); ++i) {
    const auto& [at, facet] = facets[i];
    const FacetOutcome outcome = std::isinf(sigmas[i]) ? FacetOutcome::no_agreement : facet.outcome;
    ++tile.outcomes[static_cast<size_t>(outcome)];
    if (outcome != FacetOutcome::measured) continue;
    const Eigen::Vector3d place(at.x(), at.y(), facet.height);
    tile.measured.points.push_back(
        {(plane.world(place) - tile.measured.centre).cast<float>(), static_cast<float>(sigmas[i])});
    sensitivity.add(at - tile.place, 1 / (sigmas[i] * sigmas[i]),
                    by_orientations(plane, place, facet, views, orientations));
  }
  if (!tile.measured.points.empty() && orientations.size() > 0)
    tile.sensitivity =
        sensitivity.solved(0.5 * (area.high - area.low).norm(), static_cast<int>(tile.measured.points.size()));
  return tile;
}

FacetTile measure_tile(const FacadePlane& plane, const Rectangle& area, const std::vector<FacetView>& all_views,
                       const OrientationCovariance& orientations, const TileOptions& options) {
  double spacing = 0;
  const std::vector<FacetView> views =
      best_views(plane, 0.5 * (area.low + area.high), all_views, options.max_views, &spacing);
  const Eigen::Vector2d size = area.high - area.low;
  const double own = views.empty() ? 0 : (2 * options.facet.half - 1) * spacing;
  const double pitch = std::max(options.pitch, own);
  const int columns = std::max(1, static_cast<int>(size.x() / pitch)),
            rows = std::max(1, static_cast<int>(size.y() / pitch));
  if (static_cast<int>(views.size()) < options.facet.min_views) {
    FacetTile tile = tile_of(plane, area, {}, views, orientations, options.facet.max_sigma);
    tile.outcomes[static_cast<size_t>(FacetOutcome::too_few_views)] = columns * rows;
    return tile;
  }
  const Eigen::Vector2d step(size.x() / columns, size.y() / rows);
  // The coarse patches are four times as large, so that they need to stand only as densely.
  const double coarse_pitch = 4 * own;
  const int coarse_columns = std::max(1, static_cast<int>(std::ceil(size.x() / coarse_pitch)));
  const int coarse_rows = std::max(1, static_cast<int>(std::ceil(size.y() / coarse_pitch)));
  std::vector<std::vector<double>> found(static_cast<size_t>(coarse_columns) * coarse_rows);
  std::vector<char> ambiguous(found.size());
  for (int r = 0; r < coarse_rows; ++r)
    for (int c = 0; c < coarse_columns; ++c) {
      const Eigen::Vector2d at =
          area.low + Eigen::Vector2d((c + 0.5) / coarse_columns * size.x(), (r + 0.5) / coarse_rows * size.y());
      bool two = false;
      found[static_cast<size_t>(r) * coarse_columns + c] =
          search_heights(plane, at, spacing, views, options.facet, 2, &two);
      ambiguous[static_cast<size_t>(r) * coarse_columns + c] = two;
    }
  std::vector<std::pair<Eigen::Vector2d, Facet>> facets;
  for (int r = 0; r < rows; ++r) {
    stop_point();
    for (int c = 0; c < columns; ++c) {
      const Eigen::Vector2d at = area.low + Eigen::Vector2d((c + 0.5) * step.x(), (r + 0.5) * step.y());
      const int cc = std::min(coarse_columns - 1, static_cast<int>((c + 0.5) / columns * coarse_columns));
      const int cr = std::min(coarse_rows - 1, static_cast<int>((r + 0.5) / rows * coarse_rows));
      Facet best;
      best.outcome = FacetOutcome::no_texture, best.place = at;
      for (double start : starts_of(found, coarse_columns, coarse_rows, cc, cr, 0.5 * spacing)) {
        Facet facet = match_facet(plane, at, spacing, start, views, options.facet);
        const bool better = facet.outcome == FacetOutcome::measured
                                ? best.outcome != FacetOutcome::measured || facet.correlation > best.correlation + 1e-6
                                : best.outcome != FacetOutcome::measured;
        if (better) best = std::move(facet);
        if (best.outcome == FacetOutcome::measured && best.correlation > 0.95) break;
      }
      if (best.outcome == FacetOutcome::measured && ambiguous[static_cast<size_t>(cr) * coarse_columns + cc])
        best.outcome = FacetOutcome::ambiguous;
      facets.emplace_back(at, std::move(best));
    }
  }
  return tile_of(plane, area, facets, views, orientations, options.facet.max_sigma);
}

Eigen::MatrixXd reduced_factor(const Eigen::MatrixXd& rows, const OrientationCovariance& orientations, double lost) {
  const Eigen::Index unknowns = orientations.size();
  if (orientations.matrix.rows() != unknowns || orientations.matrix.cols() != unknowns)
    throw std::invalid_argument("the covariance of the orientations has " + std::to_string(orientations.matrix.rows()) +
                                " rows, expected " + std::to_string(unknowns));
  std::vector<Eigen::Index> used;  // unknowns that are held have no variance
  for (Eigen::Index i = 0; i < unknowns; ++i)
    if (orientations.matrix(i, i) > 0) used.push_back(i);
  if (used.empty()) return Eigen::MatrixXd(rows.rows(), 0);
  const Eigen::VectorXd scale = orientations.matrix.diagonal()(used).cwiseSqrt();
  const Eigen::MatrixXd correlations =
      scale.cwiseInverse().asDiagonal() * orientations.matrix(used, used) * scale.cwiseInverse().asDiagonal();
  const linear_algebra::SymmetricEigen spectrum(correlations);
  if (!(spectrum.eigenvalues()(0) > -1e-6 * static_cast<double>(used.size())))
    throw std::runtime_error("the covariance of the orientations has a negative eigenvalue: it is none");
  const Eigen::MatrixXd root =
      scale.asDiagonal() * spectrum.eigenvectors() * spectrum.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
  const Eigen::MatrixXd stacked = rows(Eigen::all, used) * root;
  const linear_algebra::SymmetricEigen principal(stacked.transpose() * stacked);
  const double all = principal.eigenvalues().sum();
  Eigen::Index kept = 0;
  double rest = all;
  while (kept < root.cols() && rest > lost * all) rest -= principal.eigenvalues()(root.cols() - 1 - kept++);
  return stacked * principal.eigenvectors().rightCols(kept);
}

void add_systematic_part(std::vector<FacetTile>& tiles, const std::vector<FacadePlane>& planes,
                         const OrientationCovariance& orientations, double lost) {
  if (planes.size() != tiles.size()) throw std::invalid_argument("each tile needs its plane");
  // All tiles below each other; slopes count with half a metre's lever, so that the rows are lengths.
  constexpr double lever = 0.5;
  const Eigen::Vector3d lengths(1, lever, lever);
  Eigen::MatrixXd rows(3 * static_cast<Eigen::Index>(tiles.size()), orientations.size());
  for (size_t t = 0; t < tiles.size(); ++t)
    rows.middleRows<3>(3 * static_cast<Eigen::Index>(t)) = lengths.asDiagonal() * tiles[t].sensitivity;
  const Eigen::MatrixXd reduced = reduced_factor(rows, orientations, lost);
  const Eigen::Index kept = reduced.cols();
  if (kept == 0) return;
  for (size_t t = 0; t < tiles.size(); ++t) {
    const auto part = reduced.middleRows<3>(3 * static_cast<Eigen::Index>(t));
    auto& factor = tiles[t].measured.factor;
    const FacadePlane& plane = planes[t];
    factor.resize(6, kept);
    // h = F0 + Fu du + Fv dv is the displacement out · F0 with the rotation right · Fv − up · Fu.
    factor.topRows<3>() = plane.axes.col(2) * part.row(0);
    factor.bottomRows<3>() = plane.axes.col(0) * part.row(2) / lever - plane.axes.col(1) * part.row(1) / lever;
  }
}

}  // namespace plumbline::surface
