// A sparse symmetric positive definite matrix by blocks of unknowns: which blocks meet, and their values.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

namespace plumbline::least_squares {

/// Blocks of unknowns (a pose, a point, a camera: any size, 0 too) and which of them meet in an observation. Numbers
/// are the caller's and stay so in everything that follows; the order of elimination is nobody's concern but the
/// analysis'.
class Pattern {
 public:
  explicit Pattern(std::vector<int> sizes);
  /// Any order, as often as wanted; a block always meets itself. Throws std::out_of_range.
  void couple(int a, int b);
  /// Each with each.
  void couple(std::span<const int> blocks);

  int block_count() const { return static_cast<int>(sizes_.size()); }
  int size(int block) const { return sizes_[block]; }
  /// First unknown of a block; that of block_count() is the number of unknowns.
  int offset(int block) const { return offsets_[block]; }
  int unknown_count() const { return offsets_.back(); }
  /// Blocks with a higher number that meet `block`, ascending.
  std::vector<int> after(int block) const;

 private:
  std::vector<int> sizes_, offsets_;
  // Of few blocks a bit for each pair, of many their lists, with repeats that are tidied up when a list has doubled.
  std::vector<std::vector<bool>> bits_;
  std::vector<std::vector<int>> after_;
  std::vector<std::size_t> tidy_at_;
};

/// Values of the lower triangle on a pattern, zero at first.
class SymmetricBlocks {
 public:
  SymmetricBlocks() : offsets_{0} {}
  explicit SymmetricBlocks(const Pattern& pattern);
  /// What it takes, before it is made.
  static std::size_t bytes(const Pattern& pattern);

  using Values = Eigen::Map<Eigen::MatrixXd, 0, Eigen::OuterStride<>>;
  using ConstValues = Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>>;
  /// size(row) × size(column), for row ≥ column; of the diagonal block the lower triangle counts. Throws
  /// std::out_of_range if the two do not meet.
  Values at(int row, int column);
  ConstValues at(int row, int column) const;
  /// Adds `values` (size(row) × size(column)) there or, transposed, at its mirror.
  void add(int row, int column, const Eigen::Ref<const Eigen::MatrixXd>& values);
  void set_zero();

  int block_count() const { return static_cast<int>(columns_.size()); }
  int size(int block) const { return offsets_[block + 1] - offset(block); }
  int offset(int block) const { return offsets_[block]; }
  int unknown_count() const { return offsets_.back(); }
  Eigen::VectorXd diagonal() const;
  /// A x, A being symmetric.
  Eigen::MatrixXd multiply(const Eigen::Ref<const Eigen::MatrixXd>& x) const;
  /// diag(s) A diag(s) in place.
  void scale(const Eigen::VectorXd& s);

  /// All of a block's columns from its diagonal on: the blocks below each other, in one column-major panel.
  struct Column {
    std::vector<int> rows;    ///< blocks, ascending, the column's own first
    std::vector<int> starts;  ///< their first rows in the panel; behind the last the number of rows
    std::size_t begin = 0;    ///< of the panel among values()
    int height() const { return starts.back(); }
  };
  const Column& column(int block) const { return columns_[block]; }
  const double* values() const { return values_.data(); }
  std::size_t value_count() const { return values_.size(); }
  double* values() { return values_.data(); }

 private:
  std::size_t find(int row, int column) const;

  std::vector<int> offsets_;
  std::vector<Column> columns_;
  std::vector<double> values_;
};

}  // namespace plumbline::least_squares
