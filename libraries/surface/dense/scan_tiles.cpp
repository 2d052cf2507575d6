#include "surface/dense/scan_tiles.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "geometry/linear_algebra/decompositions.hpp"

namespace plumbline::surface {
namespace {

constexpr size_t kBuffer = 1024;    // points of a tile that wait
constexpr double kMostTiles = 1e6;  // of a face
constexpr double kMostCells = 64;   // of the index along the longest edge of a face

std::int64_t cell_number(double coordinate, double cell) {
  return static_cast<std::int64_t>(std::floor(coordinate / cell));
}

std::uint64_t key_of(std::int64_t x, std::int64_t y, std::int64_t z) {
  constexpr std::uint64_t mask = (1ULL << 21) - 1;
  return (static_cast<std::uint64_t>(x) & mask) << 42 | (static_cast<std::uint64_t>(y) & mask) << 21 |
         (static_cast<std::uint64_t>(z) & mask);
}

}  // namespace

ScanTiles::ScanTiles(const std::vector<PanelFace>& faces, double reach, double edge, Sink sink, double beyond)
    : faces_(faces), reach_(reach), beyond_(beyond), sink_(std::move(sink)) {
  if (!(reach > 0) || !(edge > 0)) throw std::invalid_argument("reach and edge of tiles must be lengths above zero");
  if (!(beyond >= 0)) throw std::invalid_argument("how far points may lie beside a face must be a length");
  for (const PanelFace& face : faces_) cell_ = std::max(cell_, std::max(face.width, face.height) / kMostCells);
  for (size_t f = 0; f < faces_.size(); ++f) {
    const PanelFace& face = faces_[f];
    if (!(face.width * face.height / (edge * edge) < kMostTiles))
      throw std::invalid_argument("the face '" + face.id + "' of " + std::to_string(face.width) + " x " +
                                  std::to_string(face.height) + " m has too many tiles of " + std::to_string(edge) +
                                  " m");
    Layout layout;
    layout.first = tiles_.size();
    layout.columns = std::max(1, static_cast<int>(std::ceil(face.width / edge)));
    layout.rows = std::max(1, static_cast<int>(std::ceil(face.height / edge)));
    for (int r = 0; r < layout.rows; ++r)
      for (int c = 0; c < layout.columns; ++c) {
        const double u = ((c + 0.5) / layout.columns - 0.5) * face.width,
                     v = ((r + 0.5) / layout.rows - 0.5) * face.height;
        tiles_.push_back({f, face.plane.world({u, v, 0}), 0});
      }
    layouts_.push_back(layout);
    index(f);
  }
}

void ScanTiles::index(size_t f) {
  const PanelFace& face = faces_[f];
  const Eigen::Vector3d half(0.5 * face.width + beyond_, 0.5 * face.height + beyond_, reach_);
  const Eigen::Vector3d box = face.plane.axes.cwiseAbs() * half;
  const Eigen::Vector3d low = face.plane.origin - box, high = face.plane.origin + box;
  // Of a large slanted face the box holds cells far off its plane: those are left out.
  const double through = reach_ + 0.5 * std::sqrt(3.0) * cell_;
  for (std::int64_t x = cell_number(low.x(), cell_); x <= cell_number(high.x(), cell_); ++x)
    for (std::int64_t y = cell_number(low.y(), cell_); y <= cell_number(high.y(), cell_); ++y)
      for (std::int64_t z = cell_number(low.z(), cell_); z <= cell_number(high.z(), cell_); ++z) {
        const Eigen::Vector3d middle =
            cell_ * (Eigen::Vector3d(static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)) +
                     Eigen::Vector3d::Constant(0.5));
        if (std::abs(face.plane.local(middle).z()) <= through) faces_by_cell_[key_of(x, y, z)].push_back(f);
      }
}

std::optional<ScanTiles::Hit> ScanTiles::nearest(const Eigen::Vector3d& point) const {
  const auto found = faces_by_cell_.find(
      key_of(cell_number(point.x(), cell_), cell_number(point.y(), cell_), cell_number(point.z(), cell_)));
  if (found == faces_by_cell_.end()) return std::nullopt;
  std::optional<Hit> best;
  double least = 0;
  for (size_t f : found->second) {
    const Eigen::Vector3d local = faces_[f].plane.local(point);
    const double beside_u = std::max(0.0, std::abs(local.x()) - 0.5 * faces_[f].width),
                 beside_v = std::max(0.0, std::abs(local.y()) - 0.5 * faces_[f].height);
    if (beside_u > beyond_ || beside_v > beyond_ || !(std::abs(local.z()) <= reach_)) continue;
    const double distance = std::hypot(beside_u, beside_v, local.z());
    if (!best || distance < least) best = Hit{f, local}, least = distance;
  }
  return best;
}

size_t ScanTiles::tile_at(const Hit& hit) const {
  const PanelFace& face = faces_[hit.face];
  const Layout& layout = layouts_[hit.face];
  const auto place = [](double local, double size, int count) {
    return std::clamp(static_cast<int>((local / size + 0.5) * count), 0, count - 1);
  };
  const int c = place(hit.local.x(), face.width, layout.columns), r = place(hit.local.y(), face.height, layout.rows);
  return layout.first + static_cast<size_t>(r) * layout.columns + c;
}

std::optional<size_t> ScanTiles::tile_of(const Eigen::Vector3d& point) const {
  const auto hit = nearest(point);
  return hit ? std::optional(tile_at(*hit)) : std::nullopt;
}

bool ScanTiles::add(const Eigen::Vector3d& point, double sigma, size_t scan) {
  const auto hit = nearest(point);
  if (!hit) return false;
  const size_t t = tile_at(*hit), place = scan * tiles_.size() + t;
  if (scan >= scans()) waiting_.resize((scan + 1) * tiles_.size()), counts_.resize(waiting_.size());
  waiting_[place].push_back({(point - tiles_[t].centre).cast<float>(), static_cast<float>(sigma)});
  ++tiles_[t].points, ++counts_[place];
  if (waiting_[place].size() < kBuffer) return true;
  sink_(t, scan, waiting_[place]);
  waiting_[place].clear();
  return true;
}

void ScanTiles::flush() {
  for (size_t place = 0; place < waiting_.size(); ++place) {
    if (!waiting_[place].empty()) sink_(place % tiles_.size(), place / tiles_.size(), waiting_[place]);
    waiting_[place] = {};
  }
}

Eigen::Matrix<double, 6, Eigen::Dynamic> factor_of(const ScanPlace& place, const Eigen::Vector3d& centre) {
  const Eigen::Index n = place.covariance.rows();
  Eigen::Matrix<double, 6, Eigen::Dynamic> factor(6, n);
  if (n == 0) return factor;
  if ((n != 6 && n != 7) || place.covariance.cols() != n || !place.covariance.allFinite())
    throw std::invalid_argument("the covariance of a scan's place has " + std::to_string(n) +
                                " rows, expected 6, or 7 with scale");
  const linear_algebra::SymmetricEigen spectrum(place.covariance);
  if (spectrum.eigenvalues()(0) < -1e-9 * std::max(spectrum.eigenvalues()(n - 1), 1e-30))
    throw std::invalid_argument("the covariance of the scan's place has a negative eigenvalue: it is none");
  const Eigen::MatrixXd root = spectrum.eigenvectors() * spectrum.eigenvalues().cwiseMax(0).cwiseSqrt().asDiagonal();
  const Eigen::Vector3d arm = centre - place.pivot;
  // turn × (p − pivot) = turn × arm + turn × (p − centre)
  factor.topRows<3>() = root.middleRows<3>(3) - skew(arm) * root.topRows<3>();
  if (n == 7) factor.topRows<3>() += arm * root.row(6);
  factor.bottomRows<3>() = root.topRows<3>();
  return factor;
}

}  // namespace plumbline::surface
