#include "photo/bundle/score.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

#include "photo/bundle/terms.hpp"

namespace plumbline::bundle {

ScoreTest::ScoreTest(const Problem& problem, const Problem& larger, const State& state, const Elimination& factors)
    : larger_(larger), factors_(factors), small_(problem), large_(larger) {
  sort_unknowns();
  const auto count = static_cast<Eigen::Index>(refs_.size());
  own_.setZero(6, count);
  kept_.setZero(factors.kept_count(), count);
  coupling_.setZero(small_.unknown_count(), count);
  matrix_.setZero(count, count);
  reduced_.setZero(count, count);
  right_.setZero(count);
  for (size_t e = 0; e < factors.blocks().size(); ++e) {
    add_observations(state, static_cast<int>(e));
    reduce(factors.blocks()[e]);
  }
  add_observations(state, -1);
  add_known(state);
  kept_ = factors.scale().asDiagonal() * kept_;
  kept_ = factors.factor().half_solve(kept_);  // rows in another order, of which only products are taken
  reduced_.selfadjointView<Eigen::Lower>().rankUpdate(kept_.transpose());
}

void ScoreTest::sort_unknowns() {
  for (int b = 0; b < large_.block_count(); ++b) {
    const Ref ref = large_.ref(b);
    const int before = small_.block(ref);
    for (int c = 0; c < large_.size(b); ++c) {
      const bool is_new = c >= small_.size(before);
      further_.push_back(is_new ? static_cast<int>(refs_.size()) : -1);
      block_.push_back(before);
      row_.push_back(c);
      if (is_new) refs_.push_back(ref);
    }
  }
}

/// Products of the rows' derivatives by further unknowns with all others. `jacobian` is stored row by row.
void ScoreTest::add(const std::vector<int>& columns, const RowMajor& jacobian,
                    const Eigen::Ref<const Eigen::VectorXd>& residual, int eliminated) {
  const auto rows = static_cast<int>(jacobian.rows()), count = static_cast<int>(columns.size());
  const auto stride = static_cast<int>(jacobian.outerStride());
  products_.assign(static_cast<size_t>(count) + 1, 0.0);
  for (int c = 0; c < count; ++c) {
    const int further = further_[columns[c]];
    if (further < 0) continue;
    std::fill(products_.begin(), products_.end(), 0.0);
    const Outer jobs[2] = {{products_.data(), 0, jacobian.data() + c, jacobian.data(), 1, count, stride, stride},
                           {products_.data() + count, 0, jacobian.data() + c, residual.data(), 1, 1, stride, 1}};
    add_outer(rows, jobs, 2);
    right_(further) -= products_[count];
    for (size_t d = 0; d < columns.size(); ++d) {
      const size_t unknown = static_cast<size_t>(columns[d]);
      if (further_[unknown] >= 0) {
        matrix_(further, further_[unknown]) += products_[d];
        continue;
      }
      coupling_(small_.offset(block_[unknown]) + row_[unknown], further) += products_[d];
      if (eliminated >= 0 && factors_.eliminated(block_[unknown]) == eliminated)
        own_(row_[unknown], further) += products_[d];
      else
        kept_(factors_.kept_offset(block_[unknown]) + row_[unknown], further) += products_[d];
    }
  }
}

/// Those that belong to an eliminated block, or to none (−1).
void ScoreTest::add_observations(const State& state, int eliminated) {
  Rows rows;
  std::vector<int> columns;
  for (const auto& term : eliminated < 0 ? factors_.loose_terms() : factors_.terms(eliminated)) {
    const size_t i = static_cast<size_t>(term.index);
    if (term.kind == Elimination::TermRef::Kind::point)
      evaluate(larger_, large_, state, larger_.image_points[i], true, rows);
    else if (term.kind == Elimination::TermRef::Kind::tag)
      evaluate(larger_, large_, state, larger_.image_tags[i], true, rows);
    else
      continue;  // distances and known coordinates have nothing to do with a camera
    columns.clear();
    for (int k = 0; k < rows.parts; ++k)
      for (int c = 0; c < rows.part[k].size; ++c) columns.push_back(large_.offset(rows.part[k].block) + c);
    const Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>, 0,
                     Eigen::OuterStride<Rows::stride>>
        jacobian(rows.storage.data(), rows.rows, rows.columns);
    add(columns, jacobian, rows.values(), eliminated);
  }
}

void ScoreTest::add_known(const State& state) {
  for (const auto& term : larger_.known) {
    if (term.refs.size() != 1 || (term.refs[0].kind != Kind::camera && term.refs[0].kind != Kind::shift)) continue;
    const KnownRows rows = evaluate(larger_, large_, state, term);
    add(rows.columns, rows.jacobian, rows.residual, -1);
  }
}

/// Takes an eliminated block out of what is coupled with it.
void ScoreTest::reduce(const Elimination::Block& block) {
  std::vector<int> touched;
  for (int k = 0; k < static_cast<int>(own_.cols()); ++k)
    if (!own_.col(k).isZero(0)) touched.push_back(k);
  Eigen::MatrixXd half = own_(Eigen::seqN(0, block.size), touched);
  own_.setZero();
  block.factor.topLeftCorner(block.size, block.size).triangularView<Eigen::Lower>().solveInPlace(half);
  reduced_(touched, touched) += half.transpose() * half;
  const auto y = factors_.y(block);
  const Run* runs = factors_.runs(block);
  for (int r = 0; r < block.run_count; ++r)
    kept_(Eigen::seqN(runs[r].offset, runs[r].length), touched) -=
        y.middleCols(runs[r].local, runs[r].length).transpose() * half;
}

std::vector<int> ScoreTest::chosen(Kind kind, int index) const {
  std::vector<int> further;
  for (size_t k = 0; k < refs_.size(); ++k)
    if (refs_[k].kind == kind && (index == all || refs_[k].index == index)) further.push_back(static_cast<int>(k));
  return further;
}

Eigen::MatrixXd ScoreTest::influence(Kind kind, int index) const {
  return factors_.solve(coupling_(Eigen::all, chosen(kind, index)));
}

ScoreTest::Explained ScoreTest::by(Kind kind, int index) const {
  constexpr double undetermined = 1e-12;  // part of a further unknown that the others do not tell
  const std::vector<int> further = chosen(kind, index);
  const Eigen::MatrixXd own = matrix_(further, further), left = own - reduced_(further, further);
  const Eigen::LLT<Eigen::MatrixXd> factor(left);
  if (factor.info() != Eigen::Success ||
      (factor.matrixLLT().diagonal().cwiseAbs2().array() < undetermined * own.diagonal().array()).any())
    return {};
  Explained explained;
  const Eigen::VectorXd right = right_(further);
  explained.step = factor.solve(right);
  explained.decrease = right.dot(explained.step);
  explained.information = left.trace();
  return explained;
}

}  // namespace plumbline::bundle
