#include "surface/dense/facet.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "surface/dense/patch.hpp"

namespace plumbline::surface {
namespace {

constexpr double kMinContrast = 1.0;  // grey values; below it a patch is rounding and noise

/// A photograph's share of a facet: the map at the start, and its patch at the current height.
struct Share {
  int number = 0;
  LocalMap map;
  Eigen::Vector2d parallax;
  Patch patch;
  bool taken = false;  ///< whether `patch` holds something to compare
};

std::vector<Share> shares_of(const FacadePlane& plane, const Eigen::Vector2d& place, double height, double margin,
                             const std::vector<FacetView>& views) {
  std::vector<Share> shares;
  for (size_t k = 0; k < views.size(); ++k) {
    const auto map = map_at(*views[k].view, plane, {place.x(), place.y(), height}, margin);
    if (map) shares.push_back({static_cast<int>(k), *map, map->parallax(), {}, false});
  }
  return shares;
}

/// Takes the patch of a share at `raise` [m] above where its map is, with a slope; `level` of the pyramid.
bool take(Share& share, const FacetView& view, double raise, const Eigen::Vector2d& slope, double spacing, int half,
          int level, bool cubic) {
  const double scale = 1.0 / (1 << level);
  const auto& by = share.map.by_place;
  const Eigen::Vector2d at = share.map.pixel + by.col(2) * raise;
  const Eigen::Vector2d pixel = (at.array() + 0.5) * scale - 0.5;
  const Eigen::Vector2d by_i = (by.col(0) + by.col(2) * slope.x()) * (spacing * scale);
  const Eigen::Vector2d by_j = (by.col(1) + by.col(2) * slope.y()) * (spacing * scale);
  share.taken = sample_patch(view.image->level[level], pixel, by_i, by_j, half, cubic, share.patch);
  if (!share.taken) return false;
  normalise(share.patch);
  share.taken = share.patch.contrast >= kMinContrast;
  return share.taken;
}

Eigen::ArrayXf mean_patch(const std::vector<Share>& shares) {
  Eigen::ArrayXf mean = Eigen::ArrayXf::Zero(shares.front().patch.values.size());
  for (const Share& share : shares) mean += share.patch.values;
  return mean / static_cast<float>(shares.size());
}

/// Of a photograph with the pattern, noise apart: the root of its mean correlation with the `count - 1` others, as two
/// noisy patches agree by the product of what each agrees with the pattern by. With the mean of all, two photographs
/// would agree by 0.7 whatever they show, since each is a part of it. Of two nobody is a third who would contradict
/// what agrees by chance at one of many heights: there the correlation itself counts.
double correlation(const Share& share, const Eigen::ArrayXf& mean, size_t count) {
  const double all = static_cast<double>(count);
  const double others = (all * static_cast<double>((share.patch.values * mean).mean()) - 1) / (all - 1);
  return count == 2 ? others : std::sqrt(std::max(0.0, others));
}

/// Mean correlation of pairs of patches: (K² |T|² − K) / (K (K − 1)), since all have contrast 1.
double agreement(const std::vector<Share>& shares) {
  const double count = static_cast<double>(shares.size());
  return (count * static_cast<double>(mean_patch(shares).square().mean()) - 1) / (count - 1);
}

double agreement_at(std::vector<Share>& all, const std::vector<FacetView>& views, double raise, double spacing,
                    int half, int level, int min_views) {
  std::vector<Share> taken;
  for (Share& share : all)
    if (take(share, views[share.number], raise, Eigen::Vector2d::Zero(), spacing, half, level, false))
      taken.push_back(share);
  return static_cast<int>(taken.size()) < min_views ? -1 : agreement(taken);
}

/// Slopes of the mean patch by u and v, times `spacing`; zero on its border, which has no neighbours.
void gradients(const Eigen::ArrayXf& mean, int half, Eigen::ArrayXd& by_u, Eigen::ArrayXd& by_v) {
  const int n = 2 * half + 1;
  by_u = by_v = Eigen::ArrayXd::Zero(n * n);
  for (int j = 1; j + 1 < n; ++j)
    for (int i = 1; i + 1 < n; ++i) {
      const int at = j * n + i;
      by_u(at) = 0.5 * static_cast<double>(mean(at + 1) - mean(at - 1));
      by_v(at) = 0.5 * static_cast<double>(mean(at + n) - mean(at - n));
    }
}

/// One linearisation: what the photographs say of height and slope together.
struct Normal {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  Eigen::Matrix2d texture = Eigen::Matrix2d::Zero();  ///< Σ of the gradients' products, less the share of noise [1/m²]
  double squares = 0;
  int residuals = 0;
  Eigen::ArrayXXd
      pull;  ///< what each place, all photographs together, pulls the height by (its gradient times residual)
  std::vector<Eigen::Vector3d> of_view;  ///< what each photograph, all places together, pulls height and slopes by
  std::vector<FacetPull> pulls;          ///< of each photograph, without `height`
};

Normal linearise(const std::vector<Share>& shares, int half, double spacing) {
  Normal normal;
  const Eigen::ArrayXf mean = mean_patch(shares);
  Eigen::ArrayXd by_u, by_v;
  gradients(mean, half, by_u, by_v);
  const int n = 2 * half + 1;
  normal.pull = Eigen::ArrayXXd::Zero(n - 2, n - 2);
  normal.of_view.assign(shares.size(), Eigen::Vector3d::Zero());
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const Share& share : shares) middle += share.parallax / static_cast<double>(shares.size());
  for (const Share& share : shares) normal.pulls.push_back({0, share.parallax - middle, Eigen::Vector2d::Zero()});
  for (int j = 1; j + 1 < n; ++j)
    for (int i = 1; i + 1 < n; ++i) {
      const int at = j * n + i;
      const Eigen::Vector2d gradient = Eigen::Vector2d(by_u(at), by_v(at)) / spacing;
      const Eigen::Vector3d place(1, (i - half) * spacing, (j - half) * spacing);
      normal.texture += gradient * gradient.transpose();
      for (size_t k = 0; k < shares.size(); ++k) {
        const Eigen::Vector3d row = gradient.dot(shares[k].parallax - middle) * place;
        const double residual = static_cast<double>(shares[k].patch.values(at) - mean(at));
        normal.of_view[k] -= row * residual;
        normal.pulls[k].moved += gradient * residual;
        normal.matrix += row * row.transpose();
        normal.right -= row * residual;
        normal.pull(i - 1, j - 1) += row(0) * residual;
        normal.squares += residual * residual;
      }
      normal.residuals += static_cast<int>(shares.size());
    }
  return normal;
}

/// Variance of a normalised grey value about the pattern: of K values the mean takes one, mean and contrast of each
/// photograph two.
double variance_of(const Normal& normal, size_t views) {
  const double count = static_cast<double>(views);
  const double inner = normal.residuals / count;
  const double freedom = (count - 1) * inner - 2 * count - 3;
  return freedom > 1 ? normal.squares / freedom : 0;
}

/// Facet::neighbours. Source: Newey and West (1987), with a window of Bartlett's in both directions.
double of_neighbours(const Eigen::ArrayXXd& pull) {
  constexpr Eigen::Index window = 4;
  const Eigen::Index n = pull.rows();
  const double alone = pull.square().sum();
  if (!(alone > 0) || n < window) return 1;
  double together = alone;
  for (Eigen::Index j = 0; j < window; ++j)
    for (Eigen::Index i = j == 0 ? 1 : 1 - window; i < window; ++i) {
      const Eigen::Index apart = std::abs(i), first = i < 0 ? apart : 0;
      const double weight = (1 - static_cast<double>(apart) / window) * (1 - static_cast<double>(j) / window);
      together +=
          2 * weight * (pull.block(first, 0, n - apart, n - j) * pull.block(first + i, j, n - apart, n - j)).sum();
    }
  return together / alone;
}

/// Sigma, `neighbours` and `pulls`. `held`: the slopes' own information, `weight`: the height's, noise apart.
void state_errors(const Normal& normal, const Eigen::Matrix3d& held, double variance, double weight, Facet& facet) {
  const Eigen::Vector3d by = (normal.matrix + held).inverse().col(0);
  const double of_noise = normal.matrix(0, 0) / weight;  // noise of the mean patch is in `matrix`, and holds no height
  facet.sigma = std::sqrt(variance * of_noise * by(0));
  facet.neighbours = of_neighbours(normal.pull);
  facet.pulls = normal.pulls, facet.texture = normal.texture;
  for (size_t k = 0; k < facet.pulls.size(); ++k) facet.pulls[k].height = of_noise * by.dot(normal.of_view[k]);
}

/// Facet::set_aside. `all`, of which `agreeing` were kept, by their patches at the same height as those.
double with_set_aside(const std::vector<Share>& all, const std::vector<Share>& agreeing, double variance) {
  if (!(variance > 0)) return 1;
  const Eigen::ArrayXf mean = mean_patch(agreeing);
  double sum = variance * static_cast<double>(agreeing.size()), count = static_cast<double>(agreeing.size());
  for (const Share& share : all) {
    const auto is_it = [&share](const Share& kept) { return kept.number == share.number; };
    if (!share.taken || std::any_of(agreeing.begin(), agreeing.end(), is_it)) continue;
    sum += static_cast<double>((share.patch.values - mean).square().mean()), count += 1;
  }
  return std::max(1.0, sum / count / variance);
}

void settle(const Normal& normal, const Eigen::Matrix3d& held, const std::vector<Share>& shares, double spacing,
            Facet& facet) {
  const double variance = variance_of(normal, shares.size());
  const double inner = normal.residuals / static_cast<double>(shares.size());
  // Noise of the mean patch looks like texture: each gradient has the variance of half a grey value's, over K.
  const double noise = 0.5 * variance / static_cast<double>(shares.size()) / (spacing * spacing) * inner;
  Eigen::Matrix2d texture = normal.texture - noise * Eigen::Matrix2d::Identity();
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const Share& share : shares) middle += share.parallax / static_cast<double>(shares.size());
  double weight = 0;
  for (const Share& share : shares) {
    const Eigen::Vector2d p = share.parallax - middle;
    weight += p.dot(texture * p);
  }
  if (!(weight > 0)) {
    facet.outcome = FacetOutcome::no_texture;
    return;
  }
  state_errors(normal, held, variance, weight, facet);
  for (const Share& share : shares) {
    facet.views.push_back(share.number);
    facet.by_shift.push_back(-(texture * (share.parallax - middle)) / weight);
  }
}

}  // namespace

const char* to_string(FacetOutcome outcome) {
  switch (outcome) {
    case FacetOutcome::measured:
      return "measured";
    case FacetOutcome::too_few_views:
      return "too few photographs see it";
    case FacetOutcome::no_texture:
      return "nothing on it to measure";
    case FacetOutcome::no_agreement:
      return "the photographs disagree";
    case FacetOutcome::ambiguous:
      return "two heights fit alike";
    case FacetOutcome::outside_search:
      return "at the border of the search";
  }
  return "";
}

std::vector<double> search_heights(const FacadePlane& plane, const Eigen::Vector2d& place, double spacing,
                                   const std::vector<FacetView>& views, const FacetOptions& options, size_t most,
                                   bool* ambiguous) {
  *ambiguous = false;
  constexpr int level = Pyramid::levels - 1;
  const double coarse = spacing * (1 << level);
  std::vector<Share> shares = shares_of(plane, place, 0, 0, views);
  if (static_cast<int>(shares.size()) < options.min_views) return {};
  double slope = 0;
  for (const Share& a : shares)
    for (const Share& b : shares) slope = std::max(slope, (a.parallax - b.parallax).norm());
  if (!(slope > 0.02)) return {};  // rays that are all alike fix no height
  const double step = 0.7 * coarse / slope;
  const int reach = static_cast<int>(std::ceil(options.search / step));
  std::vector<double> found(static_cast<size_t>(2 * reach + 1));
  for (int s = -reach; s <= reach; ++s)
    found[s + reach] = agreement_at(shares, views, s * step, coarse, options.half, level, options.min_views);
  std::vector<size_t> peaks;
  for (size_t s = 0; s < found.size(); ++s)
    if (found[s] > 0.3 && (s == 0 || found[s] >= found[s - 1]) && (s + 1 == found.size() || found[s] > found[s + 1]))
      peaks.push_back(s);
  std::sort(peaks.begin(), peaks.end(), [&](size_t a, size_t b) { return found[a] > found[b]; });
  if (peaks.size() > 1 && found[peaks[1]] > found[peaks[0]] - options.repetition) *ambiguous = true;
  std::vector<double> heights;
  for (size_t k = 0; k < std::min(most, peaks.size()); ++k)
    heights.push_back((static_cast<int>(peaks[k]) - reach) * step);
  return heights;
}

Facet match_facet(const FacadePlane& plane, const Eigen::Vector2d& place, double spacing, double start,
                  const std::vector<FacetView>& views, const FacetOptions& options) {
  Facet facet;
  facet.place = place, facet.extent = 2 * options.half * spacing;
  std::vector<Share> shares = shares_of(plane, place, start, 0, views);
  double raise = 0;
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();
  // Half resolution brings the start within a pixel; the last steps at full resolution are cubic.
  for (int step = 0; step < 12; ++step) {
    const int level = step < 3 ? 1 : 0;
    const double sampling = spacing * (1 << level);
    std::vector<Share> agreeing;
    for (Share& share : shares)
      if (take(share, views[share.number], raise, slope, sampling, options.half, level, step > 4))
        agreeing.push_back(share);
    if (static_cast<int>(agreeing.size()) < options.min_views) {
      facet.outcome = shares.size() < static_cast<size_t>(options.min_views) ? FacetOutcome::too_few_views
                                                                             : FacetOutcome::no_texture;
      return facet;
    }
    if (step >= 3) {  // who disagrees goes, the worst first
      for (;;) {
        const Eigen::ArrayXf mean = mean_patch(agreeing);
        const auto worst = std::min_element(agreeing.begin(), agreeing.end(), [&](const Share& a, const Share& b) {
          return correlation(a, mean, agreeing.size()) < correlation(b, mean, agreeing.size());
        });
        if (correlation(*worst, mean, agreeing.size()) >= options.min_correlation) break;
        agreeing.erase(worst);
        if (static_cast<int>(agreeing.size()) < options.min_views ||
            static_cast<double>(agreeing.size()) < options.min_share * static_cast<double>(shares.size())) {
          facet.outcome = FacetOutcome::no_agreement;
          return facet;
        }
      }
    }
    const Normal normal = linearise(agreeing, options.half, sampling);
    const bool with_slope = step >= 3;
    Eigen::Vector3d change = Eigen::Vector3d::Zero();
    Eigen::Matrix3d matrix = normal.matrix;
    // A facade leans little: slopes are zero within a twentieth, which holds them where there is little texture.
    const double variance = variance_of(normal, agreeing.size());
    Eigen::Vector3d right = normal.right;
    if (with_slope && variance > 0) {
      matrix(1, 1) += variance / (0.05 * 0.05), matrix(2, 2) += variance / (0.05 * 0.05);
      right.tail<2>() -= variance / (0.05 * 0.05) * slope;
      change = matrix.ldlt().solve(right);
    } else if (matrix(0, 0) > 0) {
      change(0) = right(0) / matrix(0, 0);
    }
    if (!change.allFinite()) {
      facet.outcome = FacetOutcome::no_texture;
      return facet;
    }
    double most = 0;
    for (const Share& share : agreeing) most = std::max(most, share.parallax.norm());
    const double longest = 1.5 * sampling / std::max(most, 0.05);  // further than patches agree nothing is known
    change(0) = std::clamp(change(0), -longest, longest);
    raise += change(0);
    slope += change.tail<2>();
    const bool done = step > 5 && std::abs(change(0)) * std::max(most, 0.05) < 2e-3 * spacing;
    if (!done && step < 11) continue;
    if (std::abs(change(0)) * std::max(most, 0.05) > 0.1 * spacing) {  // steps that do not end
      facet.outcome = FacetOutcome::no_agreement;
      return facet;
    }
    facet.height = start + raise, facet.slope = slope;
    const Eigen::ArrayXf mean = mean_patch(agreeing);
    for (const Share& share : agreeing)
      facet.correlation += correlation(share, mean, agreeing.size()) / static_cast<double>(agreeing.size());
    facet.outcome = FacetOutcome::measured;
    settle(normal, matrix - normal.matrix, agreeing, spacing, facet);
    facet.set_aside = with_set_aside(shares, agreeing, variance);
    if (facet.outcome != FacetOutcome::measured) return facet;
    if (!(facet.sigma <= options.max_sigma)) facet.outcome = FacetOutcome::no_texture;
    if (std::abs(facet.height) > options.search) facet.outcome = FacetOutcome::outside_search;
    return facet;
  }
  return facet;
}

}  // namespace plumbline::surface
