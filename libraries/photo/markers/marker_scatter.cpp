#include "photo/markers/marker_scatter.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "geometry/linear_algebra/decompositions.hpp"
#include "geometry/median.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::markers {
namespace {

constexpr int pose_size = 6;

/// Columns of a photograph's share by what they are.
struct Columns {
  std::vector<int> kept;          ///< kept unknowns
  std::vector<Eigen::Index> at;   ///< where these stand in the share
  std::vector<Eigen::Index> own;  ///< where the camera's parameters and the effects do; −1: the share has none
};

class Propagation {
 public:
  Propagation(const MarkerModel& model, const bundle::Layout& layout, const std::vector<PhotographShare>& shares,
              const Eigen::MatrixXd& cofactor, MarkerResult& result)
      : model_(model), layout_(layout), shares_(shares), cofactor_(cofactor), result_(result) {
    for (const PhotographShare& share : shares) {
      Columns one;
      for (std::size_t k = 0; k < share.columns.size(); ++k)
        if (share.columns[k] < cofactor.rows())
          one.kept.push_back(share.columns[k]), one.at.push_back(static_cast<Eigen::Index>(k));
      columns_.push_back(one);
    }
  }

  /// Tags: by how much the change of their centres with each photograph left out scatters more than they should.
  /// Leaving one out takes its share of the information with it, so these changes are too large, and without that too
  /// small, by about as much: the geometric mean of both variances counts, of the tags the median.
  void scale_tags() {
    constexpr std::size_t fewest = 8;
    const std::size_t n = shares_.size();
    if (n < fewest) return;
    std::vector<int> centres;
    const int poses = pose_size * static_cast<int>(model_.problem.images.size());
    for (std::size_t j = 0; j < model_.markers.size(); ++j)
      for (int k = 0; k < 3; ++k)
        centres.push_back(layout_.offset(layout_.block({bundle::Kind::plate, static_cast<int>(j)})) - poses + k);
    const auto rows = static_cast<Eigen::Index>(centres.size());
    Eigen::MatrixXd left_out(rows, static_cast<Eigen::Index>(n)), own = left_out;
    for (std::size_t i = 0; i < n; ++i) {
      stop_point();
      const auto at = static_cast<Eigen::Index>(i);
      left_out.col(at) = change_without(shares_[i], cofactor_, centres);
      own.col(at) = cofactor_(centres, columns_[i].kept) * shares_[i].score(columns_[i].at);
    }
    std::vector<double> ratios;
    for (Eigen::Index j = 0; j < rows; j += 3) {
      const double formal = cofactor_(centres, centres).diagonal().segment<3>(j).sum();
      ratios.push_back(left_out.middleRows<3>(j).norm() * own.middleRows<3>(j).norm() / formal);
    }
    const double larger = ratios.empty() ? 1 : upper_median(ratios);
    if (!(larger > 1) || !std::isfinite(larger)) return;
    result_.centre_covariance *= larger;
    for (AdjustedMarker& marker : result_.markers)
      marker.centre_covariance *= larger, marker.rotation_covariance *= larger;
  }

  void add_of(std::size_t camera) {
    const CameraTruth& truth = result_.cameras[camera].truth;
    const CameraEvidence& evidence = truth.evidence;
    std::vector<int> interior;
    const std::vector<int> nine = interior_columns(model_.problem, layout_, static_cast<int>(camera));
    for (const int parameter : evidence.parameters) interior.push_back(nine[parameter]);
    const auto p = static_cast<Eigen::Index>(interior.size());
    Eigen::MatrixXd explained = Eigen::MatrixXd::Zero(p, p);
    if (!truth.own_effects.empty()) {
      place_own(evidence, interior);
      constexpr std::size_t at_once = 32;  // photographs: bounds what the columns take
      for (std::size_t first = 0; first < evidence.members.size(); first += at_once) {
        stop_point();
        std::vector<std::size_t> part;
        for (std::size_t k = first; k < std::min(first + at_once, evidence.members.size()); ++k) part.push_back(k);
        const Eigen::MatrixXd moved = moved_by(evidence, truth.own_effects, part, false);
        explained += moved(interior, Eigen::all) * moved(interior, Eigen::all).transpose();
        add(moved, evidence, truth.own_effects, part, false);
      }
      std::vector<std::size_t> all(evidence.members.size());
      for (std::size_t k = 0; k < all.size(); ++k) all[k] = k;
      const Eigen::MatrixXd moved = moved_by(evidence, truth.common_effects, all, true);
      explained += moved(interior, Eigen::all) * moved(interior, Eigen::all).transpose();
      add(moved, evidence, truth.common_effects, all, true);
    }
    add(beyond(truth, interior, explained), evidence, {}, {}, false);
  }

  /// By the corners' variance factor: in the covariance that is written for a camera it is, too.
  void scale_poses(double factor) {
    corners_ = factor;
    for (AdjustedMarkerImage& image : result_.images) {
      image.covariance *= factor;
      image.geometry_sigma = std::sqrt(image.covariance.topLeftCorner<3, 3>().trace());
    }
  }

 private:
  void place_own(const CameraEvidence& evidence, const std::vector<int>& interior) {
    const int kept = static_cast<int>(cofactor_.rows());
    std::vector<int> wanted = interior;
    for (int e = 0; e < effect_count; ++e) wanted.push_back(kept + e);
    for (const int member : evidence.members) {
      const std::vector<int>& there = shares_[member].columns;
      columns_[member].own.clear();
      for (const int column : wanted) {
        const auto found = std::lower_bound(there.begin(), there.end(), column);
        columns_[member].own.push_back(found != there.end() && *found == column ? found - there.begin() : -1);
      }
    }
  }

  /// Columns of `matrix` at these places; none where a place is −1.
  static Eigen::MatrixXd taken(const Eigen::MatrixXd& matrix, const std::vector<Eigen::Index>& places) {
    Eigen::MatrixXd result = Eigen::MatrixXd::Zero(matrix.rows(), static_cast<Eigen::Index>(places.size()));
    for (std::size_t k = 0; k < places.size(); ++k)
      if (places[k] >= 0) result.col(static_cast<Eigen::Index>(k)) = matrix.col(places[k]);
    return result;
  }

  /// How all kept unknowns move with the effects of some photographs: of each in columns of its own, or of all in the
  /// same.
  Eigen::MatrixXd moved_by(const CameraEvidence& evidence, const std::vector<Eigen::MatrixXd>& effects,
                           const std::vector<std::size_t>& part, bool shared) const {
    const Eigen::Index width = effects.front().cols();
    Eigen::MatrixXd moved =
        Eigen::MatrixXd::Zero(cofactor_.rows(), shared ? width : width * static_cast<Eigen::Index>(part.size()));
    for (std::size_t k = 0; k < part.size(); ++k) {
      const int member = evidence.members[part[k]];
      const Columns& own = columns_[member];
      const Eigen::MatrixXd score = taken(shares_[member].information, own.own) * effects[part[k]];
      moved.middleCols(shared ? 0 : width * static_cast<Eigen::Index>(k), width) +=
          cofactor_(Eigen::all, own.kept) * score(own.at, Eigen::all);
    }
    return moved;
  }

  /// What the covariance of the camera is larger by than the formal one and what is explained, as columns that move all
  /// kept unknowns with it.
  Eigen::MatrixXd beyond(const CameraTruth& truth, const std::vector<int>& interior,
                         const Eigen::MatrixXd& explained) const {
    const Eigen::MatrixXd& formal = truth.evidence.formal;
    const Eigen::LLT<Eigen::MatrixXd> root(formal);
    if (interior.empty() || root.info() != Eigen::Success) return Eigen::MatrixXd::Zero(cofactor_.rows(), 0);
    const Eigen::MatrixXd more = truth.empirical.written - corners_ * formal - explained;
    const Eigen::MatrixXd half = root.matrixL().solve(more);
    const Eigen::MatrixXd white = root.matrixL().solve(Eigen::MatrixXd(half.transpose()));
    const linear_algebra::SymmetricEigen axes(0.5 * (white + white.transpose()));
    const Eigen::MatrixXd turned = root.matrixU().solve(axes.eigenvectors());
    return cofactor_(Eigen::all, interior) * turned * axes.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
  }

  /// Into the covariances of photographs. A photograph's pose also takes its own effects itself.
  void add(const Eigen::MatrixXd& moved, const CameraEvidence& evidence, const std::vector<Eigen::MatrixXd>& effects,
           const std::vector<std::size_t>& part, bool shared) {
    std::vector<Eigen::MatrixXd> poses;
    for (std::size_t i = 0; i < shares_.size(); ++i)
      poses.emplace_back(shares_[i].pose_by(Eigen::all, columns_[i].at) * moved(columns_[i].kept, Eigen::all));
    for (std::size_t k = 0; k < part.size(); ++k) {
      const int member = evidence.members[part[k]];
      const Eigen::Index width = effects[part[k]].cols();
      poses[member].middleCols(shared ? 0 : width * static_cast<Eigen::Index>(k), width) -=
          taken(shares_[member].pose_by, columns_[member].own) * effects[part[k]];
    }
    for (std::size_t i = 0; i < poses.size(); ++i)
      result_.images[model_.images[i]].covariance += poses[i] * poses[i].transpose();
  }

  const MarkerModel& model_;
  const bundle::Layout& layout_;
  const std::vector<PhotographShare>& shares_;
  const Eigen::MatrixXd& cofactor_;
  MarkerResult& result_;
  std::vector<Columns> columns_;
  double corners_ = 1;
};

}  // namespace

void add_scatter(const MarkerModel& model, const bundle::Layout& layout, const std::vector<PhotographShare>& shares,
                 const Eigen::MatrixXd& cofactor, MarkerResult& result) {
  Propagation propagation(model, layout, shares, cofactor, result);
  double corners = 1;
  for (const AdjustedMarkerCamera& camera : result.cameras) corners = std::max(corners, camera.truth.corner_factor);
  propagation.scale_tags();
  propagation.scale_poses(corners);
  for (std::size_t c = 0; c < result.cameras.size(); ++c)
    if (!result.cameras[c].truth.evidence.parameters.empty()) propagation.add_of(c);
}

}  // namespace plumbline::markers
