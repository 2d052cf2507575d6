#include "building/judgement/block_covariance.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "geometry/packed_symmetric.hpp"

namespace plumbline::judgement {
namespace {

using Index = Eigen::Index;

std::size_t u(Index i) { return static_cast<std::size_t>(i); }

/// Items that `value(row, column)` of the lower triangle is not zero between; that is read row by row, until all so far
/// are one.
template <typename Value>
std::vector<std::vector<std::size_t>> joined_parts_of(Index items, Index step, const Value& value) {
  Partition partition(u(items));
  Index parts = 0;  // of the items so far
  for (Index item = 0; item < items; ++item) {
    ++parts;
    for (Index row = item * step; row < (item + 1) * step; ++row)
      for (Index column = 0; column < item * step && parts > 1; ++column)
        if (value(row, column) != 0 && partition.join(u(item), u(column / step))) --parts;
  }
  return partition.parts();
}

/// Their clusters, squares.
template <typename Value>
BlockCovariance::Cluster square_of(const std::vector<std::size_t>& part, Index step, const Value& value) {
  BlockCovariance::Cluster cluster;
  cluster.items.assign(part.begin(), part.end());
  const Index n = static_cast<Index>(part.size()) * step;
  Eigen::MatrixXd square(n, n);
  const auto source = [&](Index k) { return cluster.items[u(k / step)] * step + k % step; };
  for (Index i = 0; i < n; ++i)
    for (Index j = 0; j <= i; ++j) square(i, j) = square(j, i) = value(source(i), source(j));
  cluster.matrix = std::move(square);
  return cluster;
}

}  // namespace

Partition::Partition(std::size_t items) : parent_(items) { std::iota(parent_.begin(), parent_.end(), std::size_t{0}); }

std::size_t Partition::find(std::size_t item) {
  while (parent_[item] != item) item = parent_[item] = parent_[parent_[item]];
  return item;
}

bool Partition::join(std::size_t a, std::size_t b) {
  a = find(a), b = find(b);
  parent_[std::max(a, b)] = std::min(a, b);
  return a != b;
}

std::vector<std::vector<std::size_t>> Partition::parts() {
  std::vector<std::vector<std::size_t>> all;
  std::vector<std::size_t> number(parent_.size());
  for (std::size_t i = 0; i < parent_.size(); ++i) {
    const std::size_t first = find(i);  // the lowest of its part: it was numbered before
    if (first == i) number[i] = all.size(), all.emplace_back();
    all[number[first]].push_back(i);
  }
  return all;
}

BlockCovariance::BlockCovariance(std::vector<Cluster> clusters, Index items, Index step)
    : step_(step), clusters_(std::move(clusters)), where_(u(items)) {
  index();
}

BlockCovariance::BlockCovariance(const Eigen::MatrixXd& full, Index step) : step_(step) {
  if (full.rows() != full.cols() || full.rows() % step != 0)
    throw std::runtime_error("the covariance is " + std::to_string(full.rows()) + " x " + std::to_string(full.cols()) +
                             ", expected " + std::to_string(step) + " rows and columns for each point");
  where_.resize(u(full.rows() / step));
  const auto value = [&](Index row, Index column) { return full(row, column); };
  for (const std::vector<std::size_t>& part : joined_parts_of(items(), step, value))
    clusters_.push_back(square_of(part, step, value));
  index();
}

BlockCovariance BlockCovariance::independent(const std::vector<Eigen::Matrix3d>& blocks) {
  std::vector<Cluster> clusters;
  for (std::size_t i = 0; i < blocks.size(); ++i)
    clusters.push_back({{static_cast<Index>(i)}, SymmetricMatrix(Eigen::MatrixXd(blocks[i]))});
  return {std::move(clusters), static_cast<Index>(blocks.size()), 3};
}

BlockCovariance BlockCovariance::from_packed(std::span<const double> values, std::size_t points,
                                             const std::string& of) {
  if (values.empty()) return {};
  if (values.size() != packed_size(3 * points))
    unpack_symmetric({values.begin(), values.end()}, 3 * points, of);  // says what is wrong
  const auto value = [&](Index row, Index column) {
    const std::size_t r = u(std::max(row, column)), c = u(std::min(row, column));
    return values[packed_size(r) + c];
  };
  constexpr std::size_t many = 100;  // points: below it a square takes nothing, and is read more quickly
  const auto n = static_cast<Index>(points);
  std::vector<Cluster> clusters;
  for (const std::vector<std::size_t>& part : joined_parts_of(n, 3, value)) {
    if (part.size() <= many) {
      clusters.push_back(square_of(part, 3, value));
      continue;
    }
    const std::vector<Index> items(part.begin(), part.end());
    clusters.push_back({items, SymmetricMatrix::of_packed(values, items)});
  }
  return {std::move(clusters), n, 3};
}

void BlockCovariance::index() {
  for (std::size_t c = 0; c < clusters_.size(); ++c)
    for (std::size_t k = 0; k < clusters_[c].items.size(); ++k)
      where_[u(clusters_[c].items[k])] = {c, static_cast<Index>(k)};
}

double BlockCovariance::operator()(Index row, Index column) const {
  const Place &a = where_[u(row / step_)], &b = where_[u(column / step_)];
  const double common = common_.size() > 0 ? common_(row % step_, column % step_) : 0;
  if (a.cluster != b.cluster) return common;
  return common + clusters_[a.cluster].matrix(a.at * step_ + row % step_, b.at * step_ + column % step_);
}

Eigen::Matrix3d BlockCovariance::block(Index a, Index b) const {
  const Place &p = where_[u(a)], &q = where_[u(b)];
  Eigen::Matrix3d found = Eigen::Matrix3d::Zero();
  if (common_.size() > 0) found = common_;
  if (p.cluster == q.cluster) found += clusters_[p.cluster].matrix.block(p.at, q.at);
  return found;
}

Eigen::VectorXd BlockCovariance::diagonal() const {
  Eigen::VectorXd all(size());
  for (const Cluster& cluster : clusters_) {
    const Eigen::VectorXd own = cluster.matrix.diagonal();
    for (std::size_t k = 0; k < cluster.items.size(); ++k)
      all.segment(cluster.items[k] * step_, step_) = own.segment(static_cast<Index>(k) * step_, step_);
  }
  if (common_.size() > 0)
    for (Index i = 0; i < items(); ++i) all.segment(i * step_, step_) += common_.diagonal();
  return all;
}

double BlockCovariance::sum() const {
  const auto n = static_cast<double>(items());
  double all = common_.size() > 0 ? n * n * common_.sum() : 0;
  for (const Cluster& cluster : clusters_) all += cluster.matrix.sum();
  return all;
}

double BlockCovariance::squaredNorm() const {
  double all = 0, pairs = 0;  // of items in one cluster
  for (const Cluster& cluster : clusters_) {
    const auto n = static_cast<Index>(cluster.items.size());
    pairs += static_cast<double>(n * n);
    all += cluster.matrix.squared_norm(common_);
  }
  const auto n = static_cast<double>(items());
  return all + (common_.size() > 0 ? (n * n - pairs) * common_.squaredNorm() : 0);
}

bool BlockCovariance::allFinite() const {
  return common_.allFinite() &&
         std::all_of(clusters_.begin(), clusters_.end(), [](const Cluster& c) { return c.matrix.all_finite(); });
}

double BlockCovariance::quadratic(const Eigen::SparseVector<double>& weights) const {
  struct Entry {
    std::size_t cluster;
    Index row;
    double weight;
  };
  std::vector<Entry> entries;
  Eigen::VectorXd together = Eigen::VectorXd::Zero(step_);
  for (Eigen::SparseVector<double>::InnerIterator w(weights); w; ++w) {
    if (w.value() == 0) continue;
    together[w.index() % step_] += w.value();
    const Place& place = where_[u(w.index() / step_)];
    entries.push_back({place.cluster, place.at * step_ + w.index() % step_, w.value()});
  }
  std::stable_sort(entries.begin(), entries.end(),
                   [](const Entry& a, const Entry& b) { return a.cluster < b.cluster; });
  double all = common_.size() > 0 ? together.dot(common_ * together) : 0;
  for (std::size_t begin = 0, end = 0; begin < entries.size(); begin = end) {
    while (end < entries.size() && entries[end].cluster == entries[begin].cluster) ++end;
    const SymmetricMatrix& matrix = clusters_[entries[begin].cluster].matrix;
    for (std::size_t i = begin; i < end; ++i)
      for (std::size_t j = begin; j < end; ++j)
        all += entries[i].weight * entries[j].weight * matrix(entries[i].row, entries[j].row);
  }
  return all;
}

Eigen::MatrixXd BlockCovariance::dense(const std::vector<std::size_t>& items) const {
  if (size() == 0) return {};
  const auto n = static_cast<Index>(items.size());
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(n * step_, n * step_);
  if (common_.size() > 0) all = common_.replicate(n, n);
  for (Index i = 0; i < n; ++i)
    for (Index j = 0; j < n; ++j) {
      const Place &a = where_[items[u(i)]], &b = where_[items[u(j)]];
      if (a.cluster != b.cluster) continue;
      const SymmetricMatrix& matrix = clusters_[a.cluster].matrix;
      for (Index r = 0; r < step_; ++r)
        for (Index c = 0; c < step_; ++c)
          all(i * step_ + r, j * step_ + c) += matrix(a.at * step_ + r, b.at * step_ + c);
    }
  return all;
}

Eigen::MatrixXd BlockCovariance::dense() const {
  std::vector<std::size_t> all(u(items()));
  std::iota(all.begin(), all.end(), std::size_t{0});
  return dense(all);
}

template <typename Self>
BlockCovariance BlockCovariance::part_of(Self& self, const std::vector<std::size_t>& items) {
  if (self.size() == 0) return {};
  std::vector<std::vector<std::size_t>> of(self.clusters_.size());  // places in `items`
  for (std::size_t k = 0; k < items.size(); ++k) of[self.where_[items[k]].cluster].push_back(k);
  std::vector<Cluster> part;
  for (std::size_t c = 0; c < of.size(); ++c) {
    if (of[c].empty()) continue;
    auto& from = self.clusters_[c];
    std::vector<Index> own, places;
    Cluster cluster;
    for (const std::size_t k : of[c]) {
      own.push_back(static_cast<Index>(items[k])), places.push_back(self.where_[items[k]].at);
      cluster.items.push_back(static_cast<Index>(k));
    }
    if constexpr (!std::is_const_v<Self>) {
      if (own == from.items) {
        cluster.matrix = std::move(from.matrix);
        part.push_back(std::move(cluster));
        continue;
      }
    }
    cluster.matrix = from.matrix.of_items(places, self.step_);
    part.push_back(std::move(cluster));
  }
  BlockCovariance some(std::move(part), static_cast<Index>(items.size()), self.step_);
  some.common_ = self.common_;
  return some;
}

BlockCovariance BlockCovariance::subset(const std::vector<std::size_t>& items) const& { return part_of(*this, items); }

BlockCovariance BlockCovariance::subset(const std::vector<std::size_t>& items) && {
  BlockCovariance some = part_of(*this, items);
  *this = {};  // what was left out takes no room any more
  return some;
}

BlockCovariance BlockCovariance::heights() const {
  std::vector<Cluster> part;
  for (const Cluster& cluster : clusters_) {
    const auto n = static_cast<Index>(cluster.items.size());
    Eigen::MatrixXd matrix(n, n);
    for (Index i = 0; i < n; ++i)
      for (Index j = 0; j < n; ++j) matrix(i, j) = cluster.matrix(3 * i + 2, 3 * j + 2);
    part.push_back({cluster.items, std::move(matrix)});
  }
  BlockCovariance all(std::move(part), items(), 1);
  if (common_.size() > 0) all.common_ = common_.block<1, 1>(2, 2);
  return all;
}

BlockCovariance& BlockCovariance::operator*=(double factor) {
  for (Cluster& cluster : clusters_) cluster.matrix *= factor;
  common_ *= factor;
  return *this;
}

void BlockCovariance::add(Index point, const Eigen::Matrix3d& more) {
  const Place& place = where_[u(point)];
  clusters_[place.cluster].matrix.add(place.at, more);
}

}  // namespace plumbline::judgement
