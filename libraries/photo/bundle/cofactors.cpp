#include "photo/bundle/cofactors.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>

#include "plumbline/stop.hpp"

namespace plumbline::bundle {
Cofactors::Cofactors(const Problem& problem, const Layout& layout, const State& state, const Elimination& elimination,
                     const Datum& datum)
    : problem_(problem),
      layout_(layout),
      elimination_(elimination),
      kept_(elimination.factor()),
      is_dense_(elimination.factor().analysis().is_dense()),
      own_(elimination.blocks().size()) {
  kept_.scale(elimination.scale());
  if (datum.count == 0) return;
  g_ = motions_of(problem, layout, state, least_squares::centre_of(bodies_of(problem, state))).leftCols(datum.count);
  Eigen::MatrixXd c = Eigen::MatrixXd::Zero(g_.rows(), datum.count);
  c(datum.held, Eigen::all) = g_(datum.held, Eigen::all);
  const Eigen::MatrixXd inverse = (c.transpose() * g_).inverse();
  p_ = inverse * elimination.solve(c).transpose();
  m_ = p_ * c * inverse.transpose();
}

Cofactors::Local Cofactors::local(const Elimination::Block& block) const {
  Local result;
  const auto y = elimination_.y(block);
  const Eigen::Index s = block.size;
  if (!is_dense_) {
    std::vector<int> kept;
    for (int b : block.kept) kept.push_back(elimination_.kept_index(b));
    result.kept = kept_.joint(kept);
  }
  result.t.setZero(s, block.columns);
  result.own.setZero(s, s);
  if (!block.determined()) return result;
  const double* numbers = elimination_.y_of(block);
  Eigen::Index at = 0;
  if (is_dense_) {
    const auto all = kept_.dense();
    const Run* runs = elimination_.runs(block);
    for (const Run* run = runs; run < runs + block.run_count; ++run)
      for (int c = 0; c < run->length; ++c)
        multiply_runs(numbers, block.size, block.columns, runs, block.run_count, all.col(run->offset + c).data(),
                      result.t.col(at++).data());
  } else {
    const Run whole{0, 0, block.columns};
    for (; at < block.columns; ++at)
      multiply_runs(numbers, block.size, block.columns, &whole, 1, result.kept.col(at).data(), result.t.col(at).data());
  }
  const auto lower = block.factor.topLeftCorner(s, s).triangularView<Eigen::Lower>();
  result.own = Eigen::MatrixXd::Identity(s, s) + result.t * y.transpose();
  const Eigen::MatrixXd inverse = lower.solve(Eigen::MatrixXd::Identity(s, s));
  result.own = (inverse.transpose() * result.own * inverse).eval();
  result.own = (0.5 * (result.own + result.own.transpose())).eval();
  return result;
}

Eigen::MatrixXd Cofactors::own_before_datum(int block) const {
  const int e = elimination_.eliminated(block);
  if (e < 0) return kept_.block(elimination_.kept_index(block), elimination_.kept_index(block));
  const Eigen::MatrixXd& known = own_[e];
  return known.size() > 0 ? known : local(elimination_.blocks()[e]).own;
}

/// What of a block's errors comes from kept unknowns, and what it has of its own: Q_ab = G_a Q G_bᵀ, and for a = b
/// V⁻¹ more.
struct Cofactors::Reach {
  std::vector<int> kept, starts;  ///< kept blocks by their index, and where their columns in `g` begin
  Eigen::MatrixXd g;              ///< −L⁻ᵀ Y of an eliminated block, the identity of a kept one
  Eigen::MatrixXd own;            ///< V⁻¹, or zero
};

Cofactors::Reach Cofactors::reach_of(int block) const {
  Reach reach;
  const int size = layout_.size(block), e = elimination_.eliminated(block);
  reach.own.setZero(size, size);
  if (size == 0) return reach;
  if (e < 0) {
    reach.kept = {elimination_.kept_index(block)};
    reach.starts = {0};
    reach.g.setIdentity(size, size);
    return reach;
  }
  const auto& from = elimination_.blocks()[e];
  if (!from.determined()) return reach;
  for (int b : from.kept) reach.kept.push_back(elimination_.kept_index(b));
  reach.starts = from.local;
  const auto lower = from.factor.topLeftCorner(size, size).triangularView<Eigen::Lower>();
  reach.g = -elimination_.y(from);
  lower.transpose().solveInPlace(reach.g);
  const Eigen::MatrixXd inverse = lower.solve(Eigen::MatrixXd::Identity(size, size));
  reach.own = inverse.transpose() * inverse;
  return reach;
}

/// G Q Gᵀ from the inverse of all kept blocks that are reached, which all meet.
Eigen::MatrixXd Cofactors::by_inverse(const std::vector<Reach>& reaches, const std::vector<int>& kept) const {
  const auto& analysis = elimination_.factor().analysis();
  std::vector<Eigen::Index> row(static_cast<size_t>(analysis.block_count()));  // by kept block
  Eigen::MatrixXd gathered;
  if (!is_dense_) gathered = kept_.joint(kept);
  Eigen::Index next = 0, all = 0;
  for (int k : kept) row[k] = is_dense_ ? analysis.offset(k) : next, next += analysis.size(k);
  const Eigen::Map<const Eigen::MatrixXd> q =
      is_dense_ ? kept_.dense() : Eigen::Map<const Eigen::MatrixXd>(gathered.data(), gathered.rows(), gathered.cols());
  for (const Reach& reach : reaches) all += reach.own.rows();
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(all, all);
  Eigen::Index at = 0;
  for (size_t i = 0; i < reaches.size(); at += reaches[i].own.rows(), ++i) {
    stop_point();
    Eigen::MatrixXd to_kept = Eigen::MatrixXd::Zero(reaches[i].own.rows(), q.cols());
    for (size_t k = 0; k < reaches[i].kept.size(); ++k) {
      const int b = reaches[i].kept[k], size = analysis.size(b);
      to_kept.noalias() += reaches[i].g.middleCols(reaches[i].starts[k], size) * q.middleCols(row[b], size).transpose();
    }
    Eigen::Index to = 0;
    for (size_t j = 0; j <= i; to += reaches[j].own.rows(), ++j) {
      auto part = result.block(at, to, reaches[i].own.rows(), reaches[j].own.rows());
      for (size_t k = 0; k < reaches[j].kept.size(); ++k) {
        const int b = reaches[j].kept[k], size = analysis.size(b);
        part.noalias() +=
            to_kept.middleCols(row[b], size) * reaches[j].g.middleCols(reaches[j].starts[k], size).transpose();
      }
      if (i != j) result.block(to, at, part.cols(), part.rows()) = part.transpose();
    }
  }
  return result;
}

/// The same for kept blocks of which some never meet: the functionals S Gᵀ of the factor's matrix.
Eigen::MatrixXd Cofactors::by_solves(const std::vector<Reach>& reaches) const {
  const auto& analysis = elimination_.factor().analysis();
  Eigen::Index all = 0;
  for (const Reach& reach : reaches) all += reach.own.rows();
  Eigen::MatrixXd functionals = Eigen::MatrixXd::Zero(analysis.unknown_count(), all);
  Eigen::Index at = 0;
  for (const Reach& reach : reaches) {
    for (size_t k = 0; k < reach.kept.size(); ++k) {
      const int offset = analysis.offset(reach.kept[k]), size = analysis.size(reach.kept[k]);
      functionals.block(offset, at, size, reach.own.rows()) = elimination_.scale().segment(offset, size).asDiagonal() *
                                                              reach.g.middleCols(reach.starts[k], size).transpose();
    }
    at += reach.own.rows();
  }
  return elimination_.factor().covariance(functionals);
}

Eigen::MatrixXd Cofactors::joint(const std::vector<int>& blocks) const {
  Eigen::MatrixXd q;
  if (blocks.size() == 1) {
    if (layout_.size(blocks[0]) > 0) q = own_before_datum(blocks[0]);
  } else {
    std::vector<Reach> reaches;
    std::vector<int> kept;
    for (int b : blocks) {
      reaches.push_back(reach_of(b));
      kept.insert(kept.end(), reaches.back().kept.begin(), reaches.back().kept.end());
    }
    std::sort(kept.begin(), kept.end());
    kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
    q = is_dense_ || kept_.has_all(kept) ? by_inverse(reaches, kept) : by_solves(reaches);
    Eigen::Index at = 0;
    for (size_t i = 0; i < blocks.size(); at += layout_.size(blocks[i]), ++i) {
      Eigen::Index to = 0;
      for (size_t j = 0; j < blocks.size(); to += layout_.size(blocks[j]), ++j)
        if (blocks[i] == blocks[j]) q.block(at, to, reaches[i].own.rows(), reaches[i].own.rows()) += reaches[i].own;
    }
  }
  Eigen::Index at = 0;
  for (size_t i = 0; i < blocks.size(); at += layout_.size(blocks[i]), ++i) {
    Eigen::Index to = 0;
    for (size_t j = 0; j <= i; to += layout_.size(blocks[j]), ++j) {
      auto part = q.block(at, to, layout_.size(blocks[i]), layout_.size(blocks[j]));
      to_datum(blocks[i], blocks[j], part);
      if (i == j) part = (0.5 * (part + part.transpose())).eval();
      if (i != j) q.block(to, at, part.cols(), part.rows()) = part.transpose();
    }
  }
  return q;
}

void Cofactors::to_datum(int a, int b, Eigen::Ref<Eigen::MatrixXd> q) const {
  if (g_.size() == 0) return;
  const auto ga = g_.middleRows(layout_.offset(a), layout_.size(a));
  const auto gb = g_.middleRows(layout_.offset(b), layout_.size(b));
  q -= ga * p_.middleCols(layout_.offset(b), layout_.size(b));
  q -= p_.middleCols(layout_.offset(a), layout_.size(a)).transpose() * gb.transpose();
  q += ga * m_ * gb.transpose();
}

Eigen::MatrixXd Cofactors::cross(const std::vector<int>& blocks, const std::vector<int>& unknowns,
                                 const std::vector<int>& blocks_of_unknowns) const {
  std::vector<int> all = blocks;
  all.insert(all.end(), blocks_of_unknowns.begin(), blocks_of_unknowns.end());
  std::vector<Eigen::Index> columns;
  Eigen::Index rows = 0;
  for (int b : blocks) rows += layout_.size(b);
  for (Eigen::Index at : positions(unknowns, blocks_of_unknowns)) columns.push_back(rows + at);
  return joint(all).topRows(rows)(Eigen::all, columns);
}

std::vector<Eigen::Index> Cofactors::positions(const std::vector<int>& unknowns, const std::vector<int>& blocks) const {
  std::vector<Eigen::Index> result;
  for (int u : unknowns) {
    Eigen::Index at = 0;
    for (int b : blocks) {
      if (u >= layout_.offset(b) && u < layout_.offset(b) + layout_.size(b)) {
        result.push_back(at + u - layout_.offset(b));
        break;
      }
      at += layout_.size(b);
    }
  }
  return result;
}

std::vector<Eigen::MatrixXd> Cofactors::all_own() const {
  std::vector<Eigen::MatrixXd> result(static_cast<size_t>(layout_.block_count()));
  for (int b = 0; b < layout_.block_count(); ++b) {
    stop_point();
    if (layout_.size(b) > 0) result[b] = own(b);
  }
  return result;
}

/// Cofactors of all unknowns an observation touches, in the order of its columns.
struct Cofactors::Touched {
  static constexpr int stride = Rows::stride;
  std::array<double, stride * stride> k{};

  template <typename Source>
  void set(const Rows::Part& a, const Rows::Part& b, const Source& source) {
    for (int c = 0; c < b.size; ++c)
      for (int r = 0; r < a.size; ++r)
        k[(a.column + r) * stride + b.column + c] = k[(b.column + c) * stride + a.column + r] = source(r, c);
  }
};

/// Q_vv of an observation's rows. `near`, of the eliminated block it belongs to, is null if it belongs to none;
/// `local`: where its kept parts are in `near`.
Cofactors::Square Cofactors::of_rows(const Rows& rows, int own_block, const Local* near, const int* local,
                                     Touched& touched) const {
  std::array<int, Rows::max_parts> column{};  // of the kept parts among the local ones
  int next = 0;
  for (int k = 0; k < rows.parts && near; ++k)
    if (rows.part[k].block != own_block) column[k] = local[next++];
  for (int l = 0; l < rows.parts; ++l) {
    const auto& b = rows.part[l];
    const bool to_own = near && b.block == own_block;
    const int to = column[l];
    for (int k = 0; k < rows.parts; ++k) {
      const auto& a = rows.part[k];
      const bool from_own = near && a.block == own_block;
      if (to_own && from_own)
        touched.set(a, b, near->own);
      else if (from_own)
        touched.set(a, b, near->cross.middleCols(to, b.size));
      else if (to_own || k > l)
        continue;
      else if (is_dense_)
        touched.set(
            a, b,
            kept_.dense().block(elimination_.kept_offset(a.block), elimination_.kept_offset(b.block), a.size, b.size));
      else if (near)
        touched.set(a, b, near->kept.block(column[k], to, a.size, b.size));
      else
        touched.set(a, b, kept_.block(elimination_.kept_index(a.block), elimination_.kept_index(b.block)));
    }
  }
  Square q(rows.rows, rows.rows);
  residual_cofactor(rows.rows, rows.columns, rows.storage.data(), Rows::stride, touched.k.data(), Touched::stride,
                    q.data());
  return q;
}

void Cofactors::visit_rows(const State& state, const Visit& visit) const {
  Rows rows;
  Touched touched;
  const auto visit_term = [&](const Elimination::TermRef& term, int own_block, const Local* near) {
    const size_t i = static_cast<size_t>(term.index);
    if (term.kind == Elimination::TermRef::Kind::known) return;
    if (term.kind == Elimination::TermRef::Kind::point)
      evaluate(problem_, layout_, state, problem_.image_points[i], true, rows);
    else if (term.kind == Elimination::TermRef::Kind::tag)
      evaluate(problem_, layout_, state, problem_.image_tags[i], true, rows);
    else
      evaluate(problem_, layout_, state, problem_.distances[i], true, rows);
    visit(term, rows, of_rows(rows, own_block, near, term.local.data(), touched));
  };
  for (size_t e = 0; e < elimination_.blocks().size(); ++e) {
    stop_point();
    const auto& block = elimination_.blocks()[e];
    Local near = local(block);
    own_[e] = near.own;
    near.cross = -near.t;
    if (block.determined())
      block.factor.topLeftCorner(block.size, block.size)
          .triangularView<Eigen::Lower>()
          .transpose()
          .solveInPlace(near.cross);
    for (const auto& term : elimination_.terms(static_cast<int>(e))) visit_term(term, block.block, &near);
  }
  for (const auto& term : elimination_.loose_terms()) visit_term(term, -1, nullptr);
}

Cofactors::KnownQuality Cofactors::known(const State& state, size_t index) const {
  KnownQuality result;
  result.rows = evaluate(problem_, layout_, state, problem_.known[index]);
  const Eigen::Index rows = result.rows.residual.size();
  result.residual_cofactor = Eigen::MatrixXd::Identity(rows, rows);
  if (result.rows.columns.empty()) return result;
  const auto at = positions(result.rows.columns, result.rows.blocks);
  const Eigen::MatrixXd own = joint(result.rows.blocks)(at, at);
  const Eigen::MatrixXd& jacobian = result.rows.jacobian;
  if (jacobian.rows() == jacobian.cols() && jacobian.isDiagonal(0))  // uncorrelated coordinates
    result.residual_cofactor -= jacobian.diagonal().asDiagonal() * own * jacobian.diagonal().asDiagonal();
  else
    result.residual_cofactor -= jacobian * own * jacobian.transpose();
  return result;
}

}  // namespace plumbline::bundle
