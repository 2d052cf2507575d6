#include "block/bundle/cofactors.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>

#include "plumbline/stop.hpp"

namespace plumbline::bundle {
Cofactors::Cofactors(const Problem& problem, const Layout& layout, const State& state, const Elimination& elimination,
                     const Datum& datum, const Eigen::MatrixXd& inverse_factor)
    : problem_(problem), layout_(layout), elimination_(elimination), own_(elimination.blocks().size()) {
  const Eigen::Index n = elimination.kept_count();
  if (n > 0) {
    kept_ = least_squares::Cholesky::inverse_of(inverse_factor);
    const auto& scale = elimination.scale();
    for (Eigen::Index c = 0; c < n; ++c) kept_.col(c).array() *= scale.array() * scale(c);
  }
  if (datum.count == 0) return;
  g_ = motions_of(problem, layout, state, adjust::centre_of(bodies_of(problem, state))).leftCols(datum.count);
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
  if (!block.determined()) {
    result.t.setZero(s, block.columns);
    result.own.setZero(s, s);
    return result;
  }
  result.t.resize(s, block.columns);
  multiply_kept(block, result.t);
  const auto lower = block.factor.topLeftCorner(s, s).triangularView<Eigen::Lower>();
  result.own = Eigen::MatrixXd::Identity(s, s) + result.t * y.transpose();
  const Eigen::MatrixXd inverse = lower.solve(Eigen::MatrixXd::Identity(s, s));
  result.own = (inverse.transpose() * result.own * inverse).eval();
  result.own = (0.5 * (result.own + result.own.transpose())).eval();
  return result;
}

/// Y Q of the local kept unknowns, or of all of them if `product` has as many columns.
void Cofactors::multiply_kept(const Elimination::Block& block, Eigen::MatrixXd& product) const {
  const bool all = product.cols() == kept_.cols();
  const Run* runs = elimination_.runs(block);
  const Run whole{0, 0, static_cast<int>(kept_.cols())};
  Eigen::Index at = 0;
  for (const Run* run = all ? &whole : runs; run < (all ? &whole + 1 : runs + block.run_count); ++run)
    for (int c = 0; c < run->length; ++c)
      multiply_runs(elimination_.y_of(block), block.size, block.columns, runs, block.run_count,
                    kept_.col(run->offset + c).data(), product.col(at++).data());
}

Eigen::MatrixXd Cofactors::raw(int a, int b) const {
  const int ea = elimination_.eliminated(a), eb = elimination_.eliminated(b);
  if (ea < 0 && eb < 0)
    return kept_.block(elimination_.kept_offset(a), elimination_.kept_offset(b), layout_.size(a), layout_.size(b));
  if (ea < 0) return raw(b, a).transpose();
  const auto& block = elimination_.blocks()[static_cast<size_t>(ea)];
  if (ea == eb) {
    const Eigen::MatrixXd& known = own_[static_cast<size_t>(ea)];
    return known.size() > 0 ? known : local(block).own;
  }
  // −L⁻ᵀ Y Q to what is kept.
  const auto y = elimination_.y(block);
  const auto upper = block.factor.topLeftCorner(block.size, block.size).triangularView<Eigen::Lower>().transpose();
  const auto to_kept = [&](int offset, int size) {
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(block.size, size);
    if (!block.determined()) return sum;
    for (size_t k = 0; k < block.kept.size(); ++k)
      sum -= y.middleCols(block.local[k], layout_.size(block.kept[k])) *
             kept_.block(elimination_.kept_offset(block.kept[k]), offset, layout_.size(block.kept[k]), size);
    return Eigen::MatrixXd(upper.solve(sum));
  };
  if (eb < 0) return to_kept(elimination_.kept_offset(b), layout_.size(b));
  const auto& other = elimination_.blocks()[static_cast<size_t>(eb)];
  if (!other.determined()) return Eigen::MatrixXd::Zero(block.size, other.size);
  const auto y_other = elimination_.y(other);
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(block.size, other.size);
  for (size_t k = 0; k < other.kept.size(); ++k)
    sum -= to_kept(elimination_.kept_offset(other.kept[k]), layout_.size(other.kept[k])) *
           y_other.middleCols(other.local[k], layout_.size(other.kept[k])).transpose();
  // sum = −Q_ak Yᵀ; the other side's L⁻¹ from the right.
  return other.factor.topLeftCorner(other.size, other.size)
      .triangularView<Eigen::Lower>()
      .transpose()
      .solve(sum.transpose())
      .transpose();
}

void Cofactors::to_datum(int a, int b, Eigen::Ref<Eigen::MatrixXd> q) const {
  if (g_.size() == 0) return;
  const auto ga = g_.middleRows(layout_.offset(a), layout_.size(a));
  const auto gb = g_.middleRows(layout_.offset(b), layout_.size(b));
  q -= ga * p_.middleCols(layout_.offset(b), layout_.size(b));
  q -= p_.middleCols(layout_.offset(a), layout_.size(a)).transpose() * gb.transpose();
  q += ga * m_ * gb.transpose();
}

Eigen::MatrixXd Cofactors::joint(const std::vector<int>& blocks) const {
  std::vector<int> offset{0};
  for (int b : blocks) offset.push_back(offset.back() + layout_.size(b));
  Eigen::MatrixXd q(offset.back(), offset.back());
  // Rows of an eliminated block to everything kept, once for all its partners.
  std::vector<Eigen::MatrixXd> to_kept(blocks.size());
  const bool many = blocks.size() > 8;
  for (size_t i = 0; i < blocks.size() && many; ++i) {
    stop_point();
    const int e = elimination_.eliminated(blocks[i]);
    if (e < 0) continue;
    const auto& block = elimination_.blocks()[static_cast<size_t>(e)];
    to_kept[i] = Eigen::MatrixXd::Zero(block.size, elimination_.kept_count());
    if (!block.determined()) continue;
    multiply_kept(block, to_kept[i]);
    to_kept[i] *= -1;
    block.factor.topLeftCorner(block.size, block.size)
        .triangularView<Eigen::Lower>()
        .transpose()
        .solveInPlace(to_kept[i]);
  }
  for (size_t i = 0; i < blocks.size(); ++i)
    for (size_t j = 0; j <= i; ++j) {
      stop_point();
      auto part = q.block(offset[i], offset[j], layout_.size(blocks[i]), layout_.size(blocks[j]));
      const int ei = elimination_.eliminated(blocks[i]), ej = elimination_.eliminated(blocks[j]);
      if (!many || ei == ej || (ei < 0 && ej < 0)) {
        part = raw(blocks[i], blocks[j]);
      } else if (ei >= 0 && ej >= 0) {
        const auto& other = elimination_.blocks()[static_cast<size_t>(ej)];
        part.setZero();
        if (other.determined()) {
          const auto y = elimination_.y(other);
          Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(other.size, part.rows());
          for (size_t k = 0; k < other.kept.size(); ++k)
            sum.noalias() -=
                y.middleCols(other.local[k], layout_.size(other.kept[k])) *
                to_kept[i].middleCols(elimination_.kept_offset(other.kept[k]), layout_.size(other.kept[k])).transpose();
          part = other.factor.topLeftCorner(other.size, other.size)
                     .triangularView<Eigen::Lower>()
                     .transpose()
                     .solve(sum)
                     .transpose();
        }
      } else if (ei >= 0) {
        part = to_kept[i].middleCols(elimination_.kept_offset(blocks[j]), part.cols());
      } else {
        part = to_kept[j].middleCols(elimination_.kept_offset(blocks[i]), part.rows()).transpose();
      }
      to_datum(blocks[i], blocks[j], part);
      if (i == j) part = (0.5 * (part + part.transpose())).eval();
      if (i != j) q.block(offset[j], offset[i], part.cols(), part.rows()) = part.transpose();
    }
  return q;
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
    if (layout_.size(b) > 0) result[static_cast<size_t>(b)] = own(b);
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
        k[static_cast<size_t>((a.column + r) * stride + b.column + c)] =
            k[static_cast<size_t>((b.column + c) * stride + a.column + r)] = source(r, c);
  }
};

/// Q_vv of an observation's rows. `near`, of the eliminated block it belongs to, is null if it belongs to none;
/// `local`: where its kept parts are in `near`.
Cofactors::Square Cofactors::of_rows(const Rows& rows, int own_block, const Local* near, const int* local,
                                     Touched& touched) const {
  int next = 0;
  for (int l = 0; l < rows.parts; ++l) {
    const auto& b = rows.part[static_cast<size_t>(l)];
    const bool is_own = near && b.block == own_block;
    const int to = is_own ? 0 : elimination_.kept_offset(b.block), at = near && !is_own ? local[next++] : 0;
    for (int k = 0; k < rows.parts; ++k) {
      const auto& a = rows.part[static_cast<size_t>(k)];
      const bool from_own = near && a.block == own_block;
      if (is_own && from_own)
        touched.set(a, b, near->own);
      else if (from_own)
        touched.set(a, b, near->cross.middleCols(at, b.size));
      else if (!is_own && k <= l)
        touched.set(a, b, kept_.block(elimination_.kept_offset(a.block), to, a.size, b.size));
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
