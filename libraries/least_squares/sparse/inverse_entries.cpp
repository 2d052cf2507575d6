#include "least_squares/sparse/inverse_entries.hpp"

namespace plumbline::least_squares {

std::optional<Eigen::MatrixXd> InverseEntries::block(int a, int b, int most) {
  const Analysis& analysis = factor_.analysis();
  if (inverse_.has(a, b)) return inverse_.block(a, b);
  left_ = most;
  const bool swapped = analysis.position(a) < analysis.position(b);
  const Eigen::MatrixXd* entries = swapped ? find(b, a) : find(a, b);
  if (!entries) return std::nullopt;
  return swapped ? Eigen::MatrixXd(entries->transpose()) : *entries;
}

const Eigen::MatrixXd& InverseEntries::below(int block) {
  const auto [at, is_new] = below_.try_emplace(block);
  if (!is_new) return at->second;
  const Analysis& analysis = factor_.analysis();
  const int position = analysis.position(block);
  const auto& s = analysis.supernodes()[analysis.supernode_at(position)];
  const Eigen::Map<const Eigen::MatrixXd> panel(factor_.values().data() + s.begin, s.height(), s.width);
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(s.width, analysis.size(block));
  columns.middleRows(position - s.first, analysis.size(block)).setIdentity();
  panel.topRows(s.width).triangularView<Eigen::Lower>().solveInPlace(columns);
  at->second = -panel.bottomRows(s.height() - s.width) * columns;
  return at->second;
}

const Eigen::MatrixXd* InverseEntries::find(int later, int earlier) {
  const auto known = found_.find({later, earlier});
  if (known != found_.end()) return &known->second;
  if (--left_ < 0) return nullptr;
  const Analysis& analysis = factor_.analysis();
  const auto& s = analysis.supernodes()[analysis.supernode_at(analysis.position(earlier))];
  Eigen::MatrixXd of_rows(analysis.size(later), s.height() - s.width);
  for (int r = s.width; r < s.height();) {
    const int row = analysis.block_at(s.rows[r]), size = analysis.size(row);
    auto target = of_rows.middleCols(r - s.width, size);
    r += size;
    if (inverse_.has(later, row)) {
      target = inverse_.block(later, row);
      continue;
    }
    const bool swapped = analysis.position(later) < analysis.position(row);
    const Eigen::MatrixXd* entries = swapped ? find(row, later) : find(later, row);
    if (!entries) return nullptr;
    if (swapped)
      target = entries->transpose();
    else
      target = *entries;
  }
  return &(found_[{later, earlier}] = of_rows * below(earlier));
}

}  // namespace plumbline::least_squares
