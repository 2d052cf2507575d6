#include "surface/dense/panel_surface.hpp"

#include <fmt/core.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <map>

#include "geometry/median.hpp"
#include "surface/dense/hidden_waves.hpp"
#include "surface/dense/panel_samples.hpp"
#include "surface/dense/straightedge.hpp"

namespace plumbline::surface {
namespace {

std::vector<Sample> own_samples(const PanelFace& face, const std::vector<MeasuredTile>& tiles,
                                const PanelOptions& options) {
  std::vector<Sample> samples;
  const double across = 0.5 * face.width - options.border, up = 0.5 * face.height - options.border;
  for (size_t t = 0; t < tiles.size(); ++t)
    for (const MeasuredPoint& point : tiles[t].points) {
      const Eigen::Vector3d arm = point.offset.cast<double>();
      const Eigen::Vector3d local = face.plane.local(tiles[t].centre + arm);
      if (std::abs(local.x()) > across || std::abs(local.y()) > up || !local.allFinite()) continue;
      // A little further than a surface may lie: noise that is cut off on one side would pull the surface inside.
      if (!(point.sigma > 0) || std::abs(local.z()) > options.reach + 6 * static_cast<double>(point.sigma)) continue;
      samples.push_back({local.x(), local.y(), local.z(), static_cast<double>(point.sigma), t, arm});
    }
  return samples;
}

using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// How often each place has a point. Told by one place in sixteen, chosen by its own bits: all points of a place are
/// chosen or none.
double times_repeated(const std::vector<Sample>& samples, const std::vector<MeasuredTile>& tiles) {
  std::vector<std::array<double, 3>> places;
  for (const Sample& s : samples) {
    // Whichever tile it is of; a tenth of a micrometre, as offsets are of single precision.
    const Eigen::Vector3d place = tiles[s.tile].centre + s.arm;
    const std::array<double, 3> at = {std::round(1e7 * place.x()), std::round(1e7 * place.y()),
                                      std::round(1e7 * place.z())};
    std::uint64_t hash = 0;
    for (const double value : at) hash = (hash ^ std::bit_cast<std::uint64_t>(value)) * 0x9E3779B97F4A7C15ULL;
    if (hash >> 60 == 0 || samples.size() < 1000) places.push_back(at);
  }
  if (places.empty()) return 1;
  std::sort(places.begin(), places.end());
  const auto distinct = std::unique(places.begin(), places.end()) - places.begin();
  return static_cast<double>(places.size()) / static_cast<double>(distinct);
}

/// Tukey's weights about the median height: what stands a good deal before the panel is out from the start, where least
/// squares over all points would bend the surface towards it and keep it.
void start_at_the_median(const std::vector<Sample>& samples, std::vector<double>& weight) {
  std::vector<double> heights, off;
  for (const Sample& sample : samples) heights.push_back(sample.h);
  const double middle = upper_median(heights);
  for (const Sample& sample : samples) off.push_back(std::abs(sample.h - middle));
  const double scale = std::max(1.4826 * upper_median(off), 1e-4);
  for (size_t i = 0; i < samples.size(); ++i) {
    const double r = (samples[i].h - middle) / (6 * scale);
    weight[i] = std::abs(r) < 1 ? (1 - r * r) * (1 - r * r) : 0;
  }
}

/// Weighted least squares of the six base functions; weights of Tukey's biweight on robustly scaled residuals, which
/// leaves out what is something else. Weights end in `weight`. A scan has a hundred thousand points on a panel: nothing
/// here is made anew for each of them.
Vector6 fit(const PanelFace& face, const std::vector<Sample>& samples, std::vector<double>& weight, Matrix6& normal) {
  Vector6 solution = Vector6::Zero();
  std::vector<double> residuals(samples.size()), sizes(samples.size());
  start_at_the_median(samples, weight);
  for (int pass = 0; pass < 8; ++pass) {
    normal.setZero();
    Vector6 right = Vector6::Zero();
    for (size_t i = 0; i < samples.size(); ++i) {
      const Vector6 base = base_of(face, samples[i]);
      const double p = weight[i] / (samples[i].sigma * samples[i].sigma);
      const Vector6 weighted = p * base;
      normal.noalias() += weighted * base.transpose();
      right += samples[i].h * weighted;
    }
    solution = normal.ldlt().solve(right);
    if (pass == 7) break;
    for (size_t i = 0; i < samples.size(); ++i) {
      residuals[i] = (samples[i].h - base_of(face, samples[i]).dot(solution)) / samples[i].sigma;
      sizes[i] = std::abs(residuals[i]);
    }
    const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
    std::nth_element(sizes.begin(), middle, sizes.end());
    const double scale = std::max(1.4826 * *middle, 1e-12);
    for (size_t i = 0; i < samples.size(); ++i) {
      const double r = residuals[i] / (6 * scale);
      weight[i] = std::abs(r) < 1 ? (1 - r * r) * (1 - r * r) : 0;
    }
  }
  return solution;
}

/// Systematic part of a linear function of the points: Σ gain_i · normal · (t + ω × arm).
Eigen::MatrixXd systematic(const PanelFace& face, const std::vector<Sample>& samples,
                           const std::vector<MeasuredTile>& tiles, const std::vector<double>& weight,
                           const Matrix6& inverse) {
  Eigen::Index rank = 0;
  for (const MeasuredTile& tile : tiles) rank = std::max(rank, tile.factor.cols());
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(6, rank);
  if (rank == 0) return result;
  const Eigen::Vector3d out = face.plane.axes.col(2);
  std::vector<Matrix6> gain(tiles.size(), Matrix6::Zero());
  for (size_t i = 0; i < samples.size(); ++i) {
    Eigen::Matrix<double, 1, 6> row;  // of the tile's (t, ω): out · (ω × arm) = ω · (arm × out)
    row << out.transpose(), samples[i].arm.cross(out).transpose();
    const Vector6 weighted = weight[i] / (samples[i].sigma * samples[i].sigma) * base_of(face, samples[i]);
    gain[samples[i].tile].noalias() += weighted * row;
  }
  for (size_t t = 0; t < tiles.size(); ++t)
    if (tiles[t].factor.cols() > 0) result.leftCols(tiles[t].factor.cols()) += inverse * gain[t] * tiles[t].factor;
  return result;
}

/// Why the surface may be cut: it comes to where points are no longer taken. Empty if it does not.
std::string at_the_border(const PanelFace& face, const std::vector<Sample>& samples, const std::vector<double>& weight,
                          const Vector6& form, double widened, const PanelOptions& options) {
  const double border = std::min(options.search, options.reach);
  double furthest = 0, sigma = 0;
  for (size_t i = 0; i < samples.size(); ++i) {
    if (!(weight[i] > 0)) continue;
    const double height = std::abs(base_of(face, samples[i]).dot(form)), own = widened * samples[i].sigma;
    if (height + 4 * own > furthest + 4 * sigma) furthest = height, sigma = own;
  }
  if (furthest + 4 * sigma < border) return "";
  return fmt::format(
      "at the border of the search: its surface is up to {:.1f} mm from the design's face, its points have a noise of "
      "{:.1f} mm, and it is looked for within {:.0f} mm; look further with 'search' and 'reach'",
      1e3 * furthest, 1e3 * sigma, 1e3 * border);
}

/// Cells where most points do not count and agree with each other: a dent, or something in front of the panel.
struct OutlyingCells {
  std::vector<std::vector<size_t>> points;  ///< of each
  size_t filled = 0;                        ///< cells that have points at all
};
OutlyingCells outlying_cells(const PanelFace& face, const std::vector<Sample>& samples, const std::vector<char>& counts,
                             double widened, const PanelOptions& options) {
  constexpr size_t least = 3;  // points that can agree with each other
  const Division division(face, options);
  std::map<size_t, std::vector<size_t>> outlying;  // points by cell
  std::vector<size_t> others(static_cast<size_t>(division.columns) * division.rows);
  for (size_t i = 0; i < samples.size(); ++i)
    if (counts[i])
      ++others[division.cell_of(samples[i])];
    else
      outlying[division.cell_of(samples[i])].push_back(i);
  OutlyingCells result;
  for (size_t cell = 0; cell < others.size(); ++cell) result.filled += others[cell] > 0 || outlying.contains(cell);
  for (auto& [cell, points] : outlying) {
    if (points.size() < least || points.size() <= others[cell]) continue;
    std::vector<double> heights, off;
    for (size_t i : points) heights.push_back(samples[i].h);
    const double middle = upper_median(heights);
    for (double h : heights) off.push_back(std::abs(h - middle));
    if (upper_median(off) > 2 * widened * samples[points[0]].sigma) continue;
    result.points.push_back(std::move(points));
  }
  return result;
}

/// PanelSurface::before.
std::vector<Eigen::Vector2d> lying_before(const PanelFace& face, const std::vector<Sample>& samples,
                                          const OutlyingCells& cells, const Vector6& form) {
  constexpr double least = 0.002;  // what is nearer hides no edge, and is the panel's own more often [m]
  std::vector<Eigen::Vector2d> before;
  for (const std::vector<size_t>& points : cells.points) {
    std::vector<double> off;
    Eigen::Vector2d middle = Eigen::Vector2d::Zero();
    for (size_t i : points) {
      off.push_back(samples[i].h - base_of(face, samples[i]).dot(form));
      middle += Eigen::Vector2d(samples[i].u, samples[i].v) / static_cast<double>(points.size());
    }
    if (upper_median(off) > least) before.push_back(middle);
  }
  return before;
}

/// Why the fitted surface may be that of something before the panel: nothing can be seen through a panel, so what lies
/// behind a good part of the fitted surface, beside the rest of it, is the panel, or the panel is broken. Empty if
/// little does: a dent.
std::string stands_before(const PanelFace& face, const std::vector<Sample>& samples, const OutlyingCells& cells,
                          const Vector6& form) {
  constexpr double share = 0.1, least = 0.001;  // of the cells; how far behind [m]
  std::vector<double> behind;
  for (const std::vector<size_t>& points : cells.points) {
    std::vector<double> off;
    for (size_t i : points) off.push_back(base_of(face, samples[i]).dot(form) - samples[i].h);
    if (const double middle = upper_median(off); middle > least) behind.push_back(middle);
  }
  if (static_cast<double>(behind.size()) < share * static_cast<double>(cells.filled) || behind.empty()) return "";
  return fmt::format(
      "{:.0f} % of it lies {:.1f} mm behind the rest: nobody knows which is the panel's surface and which stands "
      "before the panel (a board, a net, a frame), or whether it is broken",
      100 * static_cast<double>(behind.size()) / static_cast<double>(cells.filled), 1e3 * upper_median(behind));
}

/// Cells known so many times less surely than the panel's median say nothing of its form that the others do not.
constexpr double kUnsure = 5;

/// Cells of the face with the mean of their points: for coverage and straightedges.
HeightGrid grid_of(const PanelFace& face, const std::vector<Sample>& samples, const std::vector<MeasuredTile>& tiles,
                   const std::vector<char>& counts, double widened, const PanelOptions& options) {
  const Division division(face, options);
  HeightGrid grid(division.columns, division.rows, {division.across, division.up});
  Eigen::Index rank = 0;
  for (const MeasuredTile& tile : tiles) rank = std::max(rank, tile.factor.cols());
  const Eigen::Vector3d out = face.plane.axes.col(2);
  Eigen::VectorXd common = Eigen::VectorXd::Zero(rank);
  for (size_t i = 0; i < samples.size(); ++i) {
    if (!counts[i]) continue;
    const Sample& s = samples[i];
    const auto& factor = tiles[s.tile].factor;
    if (factor.cols() < rank) common.setZero();
    if (factor.cols() > 0) {
      auto own = common.head(factor.cols());
      own.noalias() = factor.topRows<3>().transpose() * out;
      own.noalias() += factor.bottomRows<3>().transpose() * s.arm.cross(out);
    }
    grid.add({s.u, s.v}, s.h, s.sigma * widened, common);
  }
  grid.leave_out_unsure(kUnsure);
  return grid;
}

double coverage_of(const PanelFace& face, const std::vector<Sample>& samples, const std::vector<char>& counts,
                   const PanelOptions& options) {
  const Division division(face, options);
  std::vector<char> filled(static_cast<size_t>(division.columns) * division.rows);
  for (size_t i = 0; i < samples.size(); ++i)
    if (counts[i]) filled[division.cell_of(samples[i])] = 1;
  return static_cast<double>(std::count(filled.begin(), filled.end(), 1)) / static_cast<double>(filled.size());
}

/// Where cells are empty: whether that is because points are further apart than the cells are wide. Then each cell that
/// has points has few, and cells of about twice their distance have some everywhere; half a panel that was seen has
/// neither.
void tell_spacing(const PanelFace& face, const std::vector<Sample>& samples, const std::vector<char>& counts,
                  const PanelOptions& options, PanelSurface& panel) {
  constexpr double few = 2.5, everywhere = 0.98, widest = 3, step = 1.1;  // points in a cell; share; distances; factor
  const Division division(face, options);
  const auto points = static_cast<double>(std::count(counts.begin(), counts.end(), 1));
  panel.spacing = std::sqrt(division.across * division.up / std::max(1.0, points));
  const double filled = panel.coverage * division.columns * division.rows;
  if (panel.coverage >= everywhere || points > few * filled) return;
  PanelOptions wider = options;
  while ((wider.cell *= step) <= std::max(widest * panel.spacing, step * options.cell)) {
    if (coverage_of(face, samples, counts, wider) < everywhere) continue;
    constexpr double round = 0.005;  // [m]
    panel.covering_cell = round * std::ceil(wider.cell / round);
    return;
  }
}

/// Why points cover too little of the panel.
std::string too_little(const PanelSurface& panel, const PanelOptions& options) {
  const std::string text =
      fmt::format("points cover {} % of it, {} % are needed", static_cast<int>(100 * panel.coverage),
                  static_cast<int>(100 * options.least_coverage));
  if (!std::isfinite(panel.covering_cell)) return text;
  return text + fmt::format(
                    ": they are {:.0f} mm apart, and coverage counts in cells of {:.0f} mm; with 'cell' of "
                    "surface.panels = {:.0f} mm all have points",
                    1e3 * panel.spacing, 1e3 * options.cell, 1e3 * panel.covering_cell);
}

/// What the points of one cell say beside the fitted surface.
struct CellMisfit {
  std::vector<double> residuals;
  double weight = 0;
  double variance() const { return M_PI / 2 / weight; }  ///< of the median of normal residuals
};

/// Of the cells along one edge: the median of each and of the one behind it, carried on to the edge by a straight line.
/// Where one of the two lies off by more than any bent edge, something stands before the panel (a tag's plate, a
/// clamp): that says nothing of the panel's edge, unless it is so along half of it.
class AtTheEdge {
 public:
  AtTheEdge(double border, double size) : further_(border / size + 0.5) {}
  void add(const CellMisfit& outer, const CellMisfit& inner) {
    if (outer.residuals.empty() || inner.residuals.empty()) return;
    constexpr double something_else = 0.01;  // [m]
    const double here = upper_median(outer.residuals), behind = upper_median(inner.residuals);
    Sums& sums = std::max(here, behind) > something_else ? before_ : own_;
    sums.squares += std::pow((1 + further_) * here - further_ * behind, 2), ++sums.count;
    sums.noise += std::pow(1 + further_, 2) * outer.variance() + std::pow(further_, 2) * inner.variance();
  }
  /// Rms beyond what noise makes; none where it may be noise (two standard deviations of a mean of squares).
  double rms() const {
    constexpr double least = 4, sure = 2;
    const bool all = before_.count > own_.count;
    const double count = own_.count + (all ? before_.count : 0), noise = own_.noise + (all ? before_.noise : 0);
    if (count < least) return 0;
    const double excess = (own_.squares + (all ? before_.squares : 0) - noise) / count;
    return excess > sure * std::sqrt(2 / count) * noise / count ? std::sqrt(excess) : 0;
  }

 private:
  struct Sums {
    double squares = 0, noise = 0, count = 0;
  };
  double further_;
  Sums own_, before_;
};

/// What is known so much less surely than the rest along the edges says nothing of them.
void leave_out_unsure(std::vector<CellMisfit>& cells, double times) {
  std::vector<double> weights;
  weights.reserve(cells.size());
  for (const CellMisfit& cell : cells)
    if (cell.weight > 0) weights.push_back(cell.weight);
  if (weights.empty()) return;
  const double least = upper_median(weights) / (times * times);
  for (CellMisfit& cell : cells)
    if (cell.weight < least) cell = {};
}

/// Of all points, also those that the fit left out: what is bent far off lies there together.
Eigen::Vector4d edge_misfit(const PanelFace& face, const std::vector<Sample>& samples, const Vector6& form,
                            double widened, const PanelOptions& options) {
  const Division division(face, options);
  const int columns = division.columns, rows = division.rows;
  std::vector<CellMisfit> cells(static_cast<size_t>(columns) * rows);
  for (const Sample& sample : samples) {
    const size_t cell = division.cell_of(sample);
    const int c = static_cast<int>(cell) % columns, r = static_cast<int>(cell) / columns;
    if (std::min({c, r, columns - 1 - c, rows - 1 - r}) > 1) continue;
    cells[cell].residuals.push_back(sample.h - base_of(face, sample).dot(form));
    cells[cell].weight += 1 / std::pow(widened * sample.sigma, 2);
  }
  leave_out_unsure(cells, kUnsure);
  const auto cell = [&](int c, int r) -> const CellMisfit& { return cells[static_cast<size_t>(r) * columns + c]; };
  const double wide = division.across / columns, high = division.up / rows;
  AtTheEdge left(options.border, wide), right = left, below(options.border, high), above = below;
  for (int r = 0; r < rows && columns > 2; ++r)
    left.add(cell(0, r), cell(1, r)), right.add(cell(columns - 1, r), cell(columns - 2, r));
  for (int c = 0; c < columns && rows > 2; ++c)
    below.add(cell(c, 0), cell(c, 1)), above.add(cell(c, rows - 1), cell(c, rows - 2));
  return {left.rms(), right.rms(), below.rms(), above.rms()};
}

/// By how much neighbouring points are off together more than each by itself says: waves of the panel, or errors of the
/// scanner or of the photographs that reach further than a point. Mean squares of residuals' means over parts of one,
/// two and four cells, over what noise makes; the largest that is no accident, at least 1.
double together(const PanelFace& face, const std::vector<Sample>& samples, const std::vector<double>& weight,
                const Vector6& form, double noise, const PanelOptions& options) {
  constexpr double unknowns = 6, least_freedom = 6, sure = 2.5;
  double factor = 1;
  for (const int size : {1, 2, 4}) {
    PanelOptions coarse = options;
    coarse.cell = size * options.cell;
    const Division division(face, coarse);
    std::vector<double> weights(static_cast<size_t>(division.columns) * division.rows), sums(weights.size());
    for (size_t i = 0; i < samples.size(); ++i) {
      if (!(weight[i] > 0)) continue;
      const double p = 1 / (noise * samples[i].sigma * samples[i].sigma);
      const size_t part = division.cell_of(samples[i]);
      weights[part] += p, sums[part] += p * (samples[i].h - base_of(face, samples[i]).dot(form));
    }
    double squares = 0, count = 0;
    for (size_t part = 0; part < weights.size(); ++part)
      if (weights[part] > 0) squares += sums[part] * sums[part] / weights[part], ++count;
    const double freedom = count - unknowns;
    if (freedom < least_freedom) continue;
    const double found = squares / freedom;
    if (found > 1 + sure * std::sqrt(2 / freedom)) factor = std::max(factor, found);
  }
  return factor;
}

}  // namespace

Vector6 PanelSurface::base(double u, double v) const { return base_at(u / half_width, v / half_height); }

PanelSurface measure_panel(const PanelFace& face, const std::vector<MeasuredTile>& tiles, const PanelOptions& options) {
  PanelSurface panel;
  panel.id = face.id;
  if (!(face.width > 2 * options.border && face.height > 2 * options.border)) {
    panel.not_measured = "the panel is smaller than twice the border that is left out";
    return panel;
  }
  const std::vector<Sample> samples = own_samples(face, tiles, options);
  panel.points = static_cast<int>(samples.size());
  if (panel.points < options.least_points) {
    panel.not_measured = panel.points == 0 ? "no point was measured on it"
                                           : std::to_string(panel.points) + " points were measured on it, " +
                                                 std::to_string(options.least_points) + " are needed";
    return panel;
  }
  std::vector<double> weight(samples.size(), 1.0);
  Matrix6 normal;
  const Vector6 form = fit(face, samples, weight, normal);
  double squares = 0, weighted = 0, sum = 0;
  for (size_t i = 0; i < samples.size(); ++i) {
    const double residual = samples[i].h - base_of(face, samples[i]).dot(form);
    panel.outliers += !(weight[i] > 0);
    if (weight[i] > 0) squares += residual * residual, sum += 1;
    weighted += weight[i] * std::pow(residual / samples[i].sigma, 2);
  }
  panel.rms = std::sqrt(squares / std::max(sum, 1.0));
  // Tukey's weights take from the squares of normal residuals too; at 6 times the scale they leave 84.5 %.
  panel.variance_factor = sum > 6 ? weighted / (sum - 6) / 0.845 : 1;
  const double widened = std::sqrt(std::max(1.0, panel.variance_factor));
  const double few = 0.5;  // share of outliers above which the rest is an arbitrary choice
  if ((widened > options.most_scatter && panel.rms > options.least_scatter) || panel.outliers > few * panel.points) {
    panel.not_measured = fmt::format(
        "its {} points contradict each other: they scatter by {:.1f} mm about the best surface, {:.1f} times what they "
        "state, and {} lie elsewhere; glass, a mirror, or something in front",
        panel.points, 1e3 * panel.rms, widened, panel.outliers);
    return panel;
  }
  panel.not_measured = at_the_border(face, samples, weight, form, widened, options);
  if (!panel.not_measured.empty()) return panel;
  std::vector<char> counts;
  for (double w : weight) counts.push_back(w > 0);
  const OutlyingCells outlying = outlying_cells(face, samples, counts, widened, options);
  panel.not_measured = stands_before(face, samples, outlying, form);
  if (!panel.not_measured.empty()) return panel;
  panel.repeated = times_repeated(samples, tiles);
  const HeightGrid grid = grid_of(face, samples, tiles, counts, widened * std::sqrt(panel.repeated), options);
  panel.coverage = grid.coverage();
  tell_spacing(face, samples, counts, options, panel);
  if (panel.coverage < options.least_coverage) {
    panel.not_measured = too_little(panel, options);
    return panel;
  }
  const Matrix6 inverse = normal.ldlt().solve(Matrix6::Identity());
  const Eigen::MatrixXd common = systematic(face, samples, tiles, weight, inverse);
  panel.form = form;
  const double noise = panel.repeated * widened * widened;
  panel.form_random = noise * together(face, samples, weight, form, noise, options) * inverse;
  panel.form_factor = common;
  panel.half_width = 0.5 * face.width, panel.half_height = 0.5 * face.height;
  // By the points' own noise, as far as it is known: what they scatter by more may be the misfit itself.
  panel.edge_misfit = edge_misfit(face, samples, form, std::sqrt(panel.repeated), options);
  panel.before = lying_before(face, samples, outlying, form), panel.cell = options.cell;
  panel.hidden = hidden_in_cells(face, samples, counts, form, options);
  // The best plane of that form over the whole panel: (1 − x²) has the mean 2/3 and no slope.
  Eigen::Matrix<double, 3, 6> plane = Eigen::Matrix<double, 3, 6>::Zero();
  plane(0, 0) = 1, plane(0, 3) = plane(0, 4) = 2.0 / 3;
  plane(1, 1) = 2 / face.width, plane(2, 2) = 2 / face.height;
  panel.plane = plane * panel.form;
  panel.plane_random = plane * panel.form_random * plane.transpose();
  panel.plane_factor = plane * panel.form_factor;
  panel.plane_systematic = panel.plane_factor * panel.plane_factor.transpose();
  for (double length : options.straightedges) panel.flatness.push_back(grid.largest_gap(length));
  if (outlying.points.empty()) return panel;
  for (const std::vector<size_t>& points : outlying.points)
    for (const size_t i : points) counts[i] = 1;
  const HeightGrid whole = grid_of(face, samples, tiles, counts, widened * std::sqrt(panel.repeated), options);
  for (Gap& gap : panel.flatness) gap.with_outlying = whole.largest_gap(gap.length).gap;
  return panel;
}

}  // namespace plumbline::surface
