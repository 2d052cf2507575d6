#include "least_squares/sparse/pattern.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace plumbline::least_squares {
namespace {

constexpr std::size_t smallest_list = 32, most_bits = 8192;

void sort_unique(std::vector<int>& list) {
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
}

}  // namespace

Pattern::Pattern(std::vector<int> sizes) : sizes_(std::move(sizes)), offsets_{0} {
  for (int size : sizes_) {
    if (size < 0) throw std::out_of_range("a block of " + std::to_string(size) + " unknowns");
    offsets_.push_back(offsets_.back() + size);
  }
  if (sizes_.size() <= most_bits) {
    for (std::size_t b = 0; b < sizes_.size(); ++b) bits_.emplace_back(sizes_.size() - b);
  } else {
    after_.resize(sizes_.size());
    tidy_at_.assign(sizes_.size(), smallest_list);
  }
}

void Pattern::couple(int a, int b) {
  if (std::min(a, b) < 0 || std::max(a, b) >= block_count())
    throw std::out_of_range("blocks " + std::to_string(a) + " and " + std::to_string(b) + " of " +
                            std::to_string(block_count()));
  if (a == b) return;
  const int first = std::min(a, b);
  if (!bits_.empty()) {
    bits_[first][std::max(a, b) - first] = true;
    return;
  }
  std::vector<int>& list = after_[first];
  list.push_back(std::max(a, b));
  if (list.size() < tidy_at_[first]) return;
  sort_unique(list);
  tidy_at_[first] = std::max(smallest_list, 2 * list.size());
}

void Pattern::couple(std::span<const int> blocks) {
  for (std::size_t i = 0; i < blocks.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) couple(blocks[i], blocks[j]);
}

std::vector<int> Pattern::after(int block) const {
  std::vector<int> list;
  for (int b = block + 1; b < block_count() && !bits_.empty(); ++b)
    if (bits_[block][b - block]) list.push_back(b);
  if (!bits_.empty()) return list;
  list = after_[block];
  sort_unique(list);
  return list;
}

SymmetricBlocks::SymmetricBlocks(const Pattern& pattern) : offsets_{0} {
  std::size_t begin = 0;
  for (int b = 0; b < pattern.block_count(); ++b) {
    offsets_.push_back(offsets_.back() + pattern.size(b));
    Column& column = columns_.emplace_back();
    column.rows = pattern.after(b);
    column.rows.insert(column.rows.begin(), b);
    column.starts = {0};
    for (int row : column.rows) column.starts.push_back(column.starts.back() + pattern.size(row));
    column.begin = begin;
    begin += static_cast<std::size_t>(column.height()) * static_cast<std::size_t>(pattern.size(b));
  }
  values_.assign(begin, 0.0);
}

std::size_t SymmetricBlocks::bytes(const Pattern& pattern) {
  std::size_t bytes = 0;
  for (int b = 0; b < pattern.block_count(); ++b) {
    const std::vector<int> after = pattern.after(b);
    std::size_t height = static_cast<std::size_t>(pattern.size(b));
    for (int row : after) height += static_cast<std::size_t>(pattern.size(row));
    bytes += sizeof(double) * height * static_cast<std::size_t>(pattern.size(b)) + sizeof(Column) +
             2 * sizeof(int) * (after.size() + 2);
  }
  return bytes;
}

std::size_t SymmetricBlocks::find(int row, int column) const {
  const Column& own = columns_.at(column);
  const auto at = std::lower_bound(own.rows.begin(), own.rows.end(), row);
  if (at == own.rows.end() || *at != row)
    throw std::out_of_range("blocks " + std::to_string(row) + " and " + std::to_string(column) +
                            " do not meet in the pattern, or the first is above the second");
  return static_cast<std::size_t>(at - own.rows.begin());
}

SymmetricBlocks::Values SymmetricBlocks::at(int row, int column) {
  const Column& own = columns_[column];
  return {values_.data() + own.begin + own.starts[find(row, column)], size(row), size(column),
          Eigen::OuterStride<>(own.height())};
}

SymmetricBlocks::ConstValues SymmetricBlocks::at(int row, int column) const {
  const Column& own = columns_[column];
  return {values_.data() + own.begin + own.starts[find(row, column)], size(row), size(column),
          Eigen::OuterStride<>(own.height())};
}

void SymmetricBlocks::add(int row, int column, const Eigen::Ref<const Eigen::MatrixXd>& values) {
  if (row >= column)
    at(row, column) += values;
  else
    at(column, row) += values.transpose();
}

void SymmetricBlocks::set_zero() { std::fill(values_.begin(), values_.end(), 0.0); }

Eigen::VectorXd SymmetricBlocks::diagonal() const {
  Eigen::VectorXd result(unknown_count());
  for (int b = 0; b < block_count(); ++b) result.segment(offset(b), size(b)) = at(b, b).diagonal();
  return result;
}

Eigen::MatrixXd SymmetricBlocks::multiply(const Eigen::Ref<const Eigen::MatrixXd>& x) const {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(x.rows(), x.cols());
  for (int b = 0; b < block_count(); ++b) {
    const auto own = x.middleRows(offset(b), size(b));
    for (int row : column(b).rows) {
      const auto block = at(row, b);
      if (row == b) {
        result.middleRows(offset(b), size(b)) += block.selfadjointView<Eigen::Lower>() * own;
        continue;
      }
      result.middleRows(offset(row), size(row)) += block * own;
      result.middleRows(offset(b), size(b)) += block.transpose() * x.middleRows(offset(row), size(row));
    }
  }
  return result;
}

void SymmetricBlocks::scale(const Eigen::VectorXd& s) {
  for (int b = 0; b < block_count(); ++b)
    for (int row : column(b).rows) {
      auto block = at(row, b);
      block =
          (s.segment(offset(row), size(row)).asDiagonal() * block * s.segment(offset(b), size(b)).asDiagonal()).eval();
    }
}

}  // namespace plumbline::least_squares
