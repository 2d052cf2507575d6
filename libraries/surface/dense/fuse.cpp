#include "surface/dense/fuse.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace plumbline::surface {
namespace {

struct PointAt {
  size_t tile, point;
  double height, sigma;
};

/// What one source says of a cell.
struct Said {
  std::vector<PointAt> points;
  double height = 0, variance = 0;  ///< its median and the random part of that [m], [m²]
  Eigen::VectorXd common;           ///< its systematic part by the source's own common errors [m]
  bool speaks = false;
};

double median_in_place(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The median has π/2 times the variance of the mean. A surface that is rough within the cell scatters by more than its
/// points state, and that is taken then.
void sum_up(Said& said, const PanelFace& face, const std::vector<MeasuredTile>& tiles, int rank, int least) {
  said.speaks = static_cast<int>(said.points.size()) >= least;
  if (!said.speaks) return;
  std::vector<double> heights, off;
  double variance = 0;
  for (const PointAt& point : said.points) heights.push_back(point.height), variance += point.sigma * point.sigma;
  said.height = median_in_place(heights);
  for (const double height : heights) off.push_back(std::abs(height - said.height));
  const double count = static_cast<double>(heights.size()), scatter = 1.4826 * median_in_place(off);
  said.variance = 0.5 * M_PI * std::max(variance / count, scatter * scatter) / count;
  said.common = Eigen::VectorXd::Zero(rank);
  const Eigen::Vector3d out = face.plane.axes.col(2);
  for (const PointAt& point : said.points) {
    const MeasuredTile& tile = tiles[point.tile];
    const Eigen::Vector3d arm = tile.points[point.point].offset.cast<double>();
    if (rank > 0)
      said.common +=
          (tile.factor.topRows<3>().transpose() * out + tile.factor.bottomRows<3>().transpose() * arm.cross(out)) /
          count;
  }
}

bool agree(const Said& a, const Said& b, double within) {
  const double variance = a.variance + b.variance + a.common.squaredNorm() + b.common.squaredNorm();
  return std::abs(a.height - b.height) <= within * std::sqrt(variance);
}

/// The sources that agree with one another's middle: those that agree with the one that most agree with, if they are
/// more than half of all that say something.
std::vector<bool> agreeing(const std::vector<Said>& said, double within) {
  std::vector<bool> best(said.size());
  size_t most = 0, speaking = 0;
  for (size_t i = 0; i < said.size(); ++i) {
    if (!said[i].speaks) continue;
    ++speaking;
    std::vector<bool> with(said.size());
    size_t count = 0;
    for (size_t j = 0; j < said.size(); ++j)
      with[j] = said[j].speaks && (i == j || agree(said[i], said[j], within)), count += with[j];
    if (count > most) most = count, best = with;
  }
  if (2 * most <= speaking) std::fill(best.begin(), best.end(), false);
  return best;
}

/// Numbers of the faces that may have points within `reach` of the one of number `which`, which is not among them.
std::vector<size_t> around(const std::vector<PanelFace>& faces, size_t which, double reach) {
  const auto radius = [&](const PanelFace& face) { return std::hypot(0.5 * face.width, 0.5 * face.height, reach); };
  std::vector<size_t> numbers;
  for (size_t f = 0; f < faces.size(); ++f)
    if (f != which &&
        (faces[f].plane.origin - faces[which].plane.origin).norm() < radius(faces[f]) + radius(faces[which]))
      numbers.push_back(f);
  return numbers;
}

/// Whether another face has the point at `height` above the one of number `which`.
bool is_of_another(const std::vector<PanelFace>& faces, size_t which, const std::vector<size_t>& others,
                   const Eigen::Vector3d& point, double height) {
  return std::any_of(others.begin(), others.end(), [&](size_t f) {
    const Eigen::Vector3d at = faces[f].plane.local(point);
    if (std::abs(at.x()) > 0.5 * faces[f].width || std::abs(at.y()) > 0.5 * faces[f].height) return false;
    return std::abs(at.z()) < std::abs(height) || (f < which && std::abs(at.z()) <= std::abs(height));
  });
}

}  // namespace

FusedFace fuse_face(const std::vector<PanelFace>& faces, size_t which,
                    const std::vector<std::vector<MeasuredTile>>& sources, const std::vector<int>& ranks, double reach,
                    const FuseOptions& options) {
  const PanelFace& face = faces.at(which);
  const std::vector<size_t> others = around(faces, which, reach);
  const int columns = std::max(1, static_cast<int>(face.width / options.cell)),
            rows = std::max(1, static_cast<int>(face.height / options.cell));
  std::vector<std::vector<Said>> cells(static_cast<size_t>(columns) * rows, std::vector<Said>(sources.size()));
  int rank = 0;
  for (size_t s = 0; s < sources.size(); ++s) {
    rank += ranks[s];
    for (size_t t = 0; t < sources[s].size(); ++t) {
      const MeasuredTile& tile = sources[s][t];
      if (tile.factor.cols() != ranks[s])
        throw std::invalid_argument("a tile of source " + std::to_string(s + 1) + " has " +
                                    std::to_string(tile.factor.cols()) + " common errors, the source " +
                                    std::to_string(ranks[s]));
      for (size_t p = 0; p < tile.points.size(); ++p) {
        const Eigen::Vector3d point = tile.at(tile.points[p]), at = face.plane.local(point);
        const auto c = static_cast<int>(std::floor((at.x() / face.width + 0.5) * columns)),
                   r = static_cast<int>(std::floor((at.y() / face.height + 0.5) * rows));
        const double sigma = static_cast<double>(tile.points[p].sigma);
        if (c < 0 || r < 0 || c >= columns || r >= rows || !(std::abs(at.z()) <= reach + 6 * sigma)) continue;
        if (is_of_another(faces, which, others, point, at.z())) continue;
        cells[static_cast<size_t>(r) * columns + c][s].points.push_back({t, p, at.z(), sigma});
      }
    }
  }
  const double larger = options.may_share_errors ? std::sqrt(static_cast<double>(sources.size())) : 1;
  FusedFace fused;
  std::vector<std::vector<size_t>> place(sources.size());  // of a source's tile among the fused ones
  Eigen::Index column = 0;
  for (size_t s = 0; s < sources.size(); ++s) {
    for (const MeasuredTile& tile : sources[s]) {
      place[s].push_back(fused.tiles.size());
      fused.tiles.push_back({tile.centre, {}, Eigen::MatrixXd::Zero(6, rank)});
      fused.tiles.back().factor.middleCols(column, ranks[s]) = larger * tile.factor;
    }
    column += ranks[s];
  }
  for (std::vector<Said>& said : cells) {
    int speaking = 0;
    for (size_t s = 0; s < sources.size(); ++s) {
      sum_up(said[s], face, sources[s], ranks[s], options.least_points);
      speaking += said[s].speaks;
    }
    const std::vector<bool> kept = agreeing(said, options.agreement);
    const bool any = std::find(kept.begin(), kept.end(), true) != kept.end();
    ++(speaking == 0   ? fused.counts.empty
       : !any          ? fused.counts.contradicted
       : speaking == 1 ? fused.counts.alone
                       : fused.counts.agreed);
    for (size_t s = 0; s < sources.size(); ++s)
      for (const PointAt& point : said[s].points)
        if (kept[s]) {
          MeasuredPoint copy = sources[s][point.tile].points[point.point];
          copy.sigma *= static_cast<float>(larger);
          fused.tiles[place[s][point.tile]].points.push_back(copy);
        }
  }
  std::erase_if(fused.tiles, [](const MeasuredTile& tile) { return tile.points.empty(); });
  return fused;
}

}  // namespace plumbline::surface
