#include "surface/dense/pair_heights.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <set>

#include "surface/dense/patch.hpp"

namespace plumbline::surface {
namespace {

double median(std::vector<float>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return static_cast<double>(*middle);
}

/// What both photographs show of a cell at a height, and how far apart a height moves them on the facade.
struct Compared {
  double correlation = -1, sigma = 0;  ///< of the height by the photographs' noise [m]
  double step = 0;                     ///< that brings what they show together [m]
};

std::optional<Compared> compare(const FacadePlane& plane, const Eigen::Vector3d& place, const FacetView& a,
                                const FacetView& b, int half) {
  const auto ma = map_at(*a.view, plane, place, 4), mb = map_at(*b.view, plane, place, 4);
  if (!ma || !mb) return std::nullopt;
  const double spacing = std::max(ma->ground_pixel(), mb->ground_pixel());
  Patch pa, pb;
  if (!sample_patch(a.image->level[0], ma->pixel, spacing * ma->by_place.col(0), spacing * ma->by_place.col(1), half,
                    true, pa) ||
      !sample_patch(b.image->level[0], mb->pixel, spacing * mb->by_place.col(0), spacing * mb->by_place.col(1), half,
                    true, pb))
    return std::nullopt;
  normalise(pa), normalise(pb);
  Compared result;
  if (!(pa.contrast > 0 && pb.contrast > 0)) return result;
  const int n = 2 * half + 1;
  result.correlation = static_cast<double>((pa.values * pb.values).mean());
  const Eigen::ArrayXf mean = 0.5f * (pa.values + pb.values);
  // Mean and contrast of both were taken out, and the height is fitted.
  const double variance = static_cast<double>((pa.values - pb.values).square().sum()) / (n * n - 5);
  const Eigen::Vector2d apart = (ma->parallax() - mb->parallax()) / spacing;  // samples per metre of height
  double weight = 0, right = 0;
  for (int j = 1; j + 1 < n; ++j)
    for (int i = 1; i + 1 < n; ++i) {
      const int at = j * n + i;
      const Eigen::Vector2d gradient(0.5 * static_cast<double>(mean(at + 1) - mean(at - 1)),
                                     0.5 * static_cast<double>(mean(at + n) - mean(at - n)));
      const double by_height = gradient.dot(apart);
      weight += by_height * by_height;
      right -= by_height * static_cast<double>(pa.values(at) - pb.values(at));
    }
  // Noise looks like texture: each gradient of the mean of both has an eighth of the variance of their difference.
  const double texture = weight - (n - 2) * (n - 2) * apart.squaredNorm() * variance / 8;
  // Where the height is wrong by dh the patches lie apart by their parallaxes, each half of it from their mean.
  if (weight > 0) result.step = std::clamp(right / weight, -1 / apart.norm(), 1 / apart.norm());
  result.sigma = texture > 0 ? std::sqrt(variance / texture) : 1e3;
  return result;
}

}  // namespace

std::optional<size_t> CellGrid::at(double u, double v) const {
  const Eigen::Vector2d size = step();
  const double c = (u - area.low.x()) / size.x(), r = (v - area.low.y()) / size.y();
  if (!(c >= 0 && r >= 0 && c < columns && r < rows)) return std::nullopt;
  return static_cast<size_t>(r) * columns + static_cast<size_t>(c);
}

PairHeight cell_height(const CellGrid& grid, size_t cell, std::vector<float>& heights, double expected,
                       const RectifiedPair& pair, const std::vector<FacetView>& views, const PairOptions& options) {
  PairHeight result;
  const Eigen::Vector2d at = grid.middle(cell);
  const FacetView &a = views[pair.left], &b = views[pair.right];
  if (!map_at(*a.view, grid.plane, {at.x(), at.y(), 0}, 8) || !map_at(*b.view, grid.plane, {at.x(), at.y(), 0}, 8))
    return result;
  result.state = PairHeight::State::no_disparity;
  if (static_cast<double>(heights.size()) < 0.5 * expected) return result;
  result.height = median(heights);
  auto compared = compare(grid.plane, {at.x(), at.y(), result.height}, a, b, options.half);
  for (int i = 0; options.refine && compared && i < 6; ++i) {
    const double step = compared->step;
    result.height += step;
    compared = compare(grid.plane, {at.x(), at.y(), result.height}, a, b, options.half);
    if (std::abs(step) < 0.02 * (compared ? compared->sigma : 0)) break;
  }
  if (!compared) return result;
  const Eigen::Vector3d place(at.x(), at.y(), result.height);
  result.state =
      compared->correlation >= options.min_correlation ? PairHeight::State::found : PairHeight::State::differs;
  // What a disparity more is in height.
  const Eigen::Vector3d here = pair.rectified(grid.plane.world(place));
  const double by_disparity =
      std::abs(grid.plane.local(pair.world(here + Eigen::Vector3d(0, 0, 0.01))).z() - result.height) / 0.01;
  result.sigma = std::hypot(compared->sigma, by_disparity * options.matching_sigma);
  return result;
}

Facet agreed_facet(const CellGrid& grid, size_t cell, const std::vector<RectifiedPair>& pairs,
                   const std::vector<PairHeight>& heights, const std::vector<FacetView>& views,
                   const PairOptions& options) {
  Facet facet;
  facet.place = grid.middle(cell);
  std::set<size_t> seeing, saying;
  std::vector<float> said;
  bool differs = false;
  for (size_t p = 0; p < pairs.size(); ++p) {
    if (heights[p].state == PairHeight::State::not_seen) continue;
    seeing.insert(pairs[p].left), seeing.insert(pairs[p].right);
    differs = differs || heights[p].state == PairHeight::State::differs;
    if (heights[p].state != PairHeight::State::found) continue;
    saying.insert(pairs[p].left), saying.insert(pairs[p].right);
    said.push_back(static_cast<float>(heights[p].height));
  }
  if (static_cast<int>(seeing.size()) < options.min_views) return facet;
  facet.outcome = differs ? FacetOutcome::no_agreement : FacetOutcome::no_texture;
  if (static_cast<int>(saying.size()) < options.min_views || said.size() < 2) return facet;
  const size_t all = said.size();
  const double middle = median(said);
  std::set<size_t> agreeing;
  double weights = 0, sum = 0;
  std::vector<size_t> taken;
  for (size_t p = 0; p < pairs.size(); ++p) {
    const PairHeight& one = heights[p];
    if (one.state != PairHeight::State::found || std::abs(one.height - middle) > 3 * std::sqrt(2.0) * one.sigma)
      continue;
    agreeing.insert(pairs[p].left), agreeing.insert(pairs[p].right), taken.push_back(p);
    weights += 1 / (one.sigma * one.sigma), sum += one.height / (one.sigma * one.sigma);
  }
  facet.outcome = FacetOutcome::no_agreement;
  if (static_cast<int>(agreeing.size()) < options.min_views || taken.size() < 2 ||
      static_cast<double>(taken.size()) < options.min_share * static_cast<double>(all))
    return facet;
  facet.height = sum / weights;
  // Pairs share photographs: of K of them K - 1 are independent at most, however many pairs they make.
  const double independent =
      std::min(1.0, (static_cast<double>(agreeing.size()) - 1) / static_cast<double>(taken.size()));
  // Each pair errs by its own orientations too: where not all pairs say something of a cell, that differs from cell to
  // cell.
  double scatter = 0;
  for (const size_t p : taken) scatter += std::pow((heights[p].height - facet.height) / heights[p].sigma, 2);
  const double factor = std::max(1.0, scatter / (static_cast<double>(taken.size()) - 1));
  facet.sigma = std::sqrt(factor / (weights * independent));
  facet.outcome = FacetOutcome::measured;
  if (!(facet.sigma <= options.max_sigma)) facet.outcome = FacetOutcome::no_texture;
  if (std::abs(facet.height) > options.search) facet.outcome = FacetOutcome::outside_search;
  const Eigen::Vector2d at = grid.middle(cell);
  for (const size_t view : agreeing) facet.views.push_back(static_cast<int>(view)), facet.by_shift.emplace_back(0, 0);
  for (const size_t p : taken) {
    const Eigen::Vector3d place(at.x(), at.y(), facet.height);
    const auto a = map_at(*views[pairs[p].left].view, grid.plane, place, -1e6),
               b = map_at(*views[pairs[p].right].view, grid.plane, place, -1e6);
    if (!a || !b) continue;
    const Eigen::Vector2d apart = a->parallax() - b->parallax();
    const Eigen::Vector2d share = apart / apart.squaredNorm() / (heights[p].sigma * heights[p].sigma * weights);
    const auto of = [&](size_t view) {
      return static_cast<size_t>(std::distance(agreeing.begin(), agreeing.find(view)));
    };
    facet.by_shift[of(pairs[p].left)] -= share, facet.by_shift[of(pairs[p].right)] += share;
  }
  return facet;
}

}  // namespace plumbline::surface
