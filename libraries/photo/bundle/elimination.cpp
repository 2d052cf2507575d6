#include "photo/bundle/elimination.hpp"

#include <algorithm>
#include <cmath>

#include "photo/bundle/parallel.hpp"
#include "photo/bundle/terms.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::bundle {
namespace {

constexpr int smallest_chunk = 64;

/// Weighs the rows of a robust observation; returns its part of the cost.
double apply_loss(const Loss& loss, bool robust, bool jacobians, Rows& rows) {
  const double s = rows.values().squaredNorm();
  if (!robust || loss.kind == Loss::Kind::none) return s;
  if (jacobians) {
    const double factor = std::sqrt(loss.slope(s));
    if (factor == 1) return loss.value(s);
    for (int i = 0; i < rows.rows; ++i) rows.residual[i] *= factor;
    for (int i = 0; i < rows.rows; ++i)
      for (int c = 0; c < rows.columns; ++c) rows.storage[i * Rows::stride + c] *= factor;
  }
  return loss.value(s);
}

}  // namespace

double Loss::value(double s) const {
  const double d = scale * scale;
  switch (kind) {
    case Kind::huber:
      return s <= d ? s : 2 * scale * std::sqrt(s) - d;
    case Kind::cauchy:
      return d * std::log1p(s / d);
    case Kind::tukey:
      return s >= d ? d / 3 : d / 3 * (1 - std::pow(1 - s / d, 3));
    case Kind::none:
      break;
  }
  return s;
}

double Loss::slope(double s) const {
  const double d = scale * scale;
  switch (kind) {
    case Kind::huber:
      return s <= d ? 1 : scale / std::sqrt(s);
    case Kind::cauchy:
      return 1 / (1 + s / d);
    case Kind::tukey:
      return s >= d ? 0 : (1 - s / d) * (1 - s / d);
    case Kind::none:
      break;
  }
  return 1;
}

/// Sums over a chunk of eliminated blocks of what belongs to kept unknowns alone.
struct Elimination::Sums {
  least_squares::SymmetricBlocks direct;
  Eigen::VectorXd gradient;  ///< Jᵀ r of kept unknowns
  double cost = 0;
  std::string undefined;
};

/// Jᵀ r of problem.known[index]; adds its part of the cost.
Eigen::VectorXd Elimination::gradient_of_known(const State& state, size_t index, double& cost) const {
  const Eigen::VectorXd residual = residual_of(problem_, state, problem_.known[index], known_[index].whitening);
  cost += residual.squaredNorm();
  return known_[index].jacobian.transpose() * residual;
}

bool Elimination::linearise(const State& state, const Loss& loss, int first, int last, double damping, Sums& sums) {
  sums.gradient.setZero(kept_count_);
  Rows rows;
  for (int e = first; e < last; ++e) {
    stop_point();
    Block& block = blocks_[e];
    double* w = y_.data() + block.y;
    std::fill_n(w, static_cast<size_t>(block.size) * (static_cast<size_t>(block.columns) + 1), 0.0);
    Eigen::Matrix<double, 6, 6> v = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> g = Eigen::Matrix<double, 6, 1>::Zero();
    for (const TermRef& term : terms_[e]) {
      const size_t i = static_cast<size_t>(term.index);
      if (term.kind == TermRef::Kind::known) {  // of this block alone: others are tied and kept
        const Linear& known = known_[i];
        g(known.at) += gradient_of_known(state, i, sums.cost);
        v(known.at, known.at) += known.normal;
        continue;
      }
      const bool is_point = term.kind == TermRef::Kind::point;
      const bool defined = is_point ? evaluate(problem_, layout_, state, problem_.image_points[i], true, rows)
                                    : evaluate(problem_, layout_, state, problem_.image_tags[i], true, rows);
      const bool robust = is_point ? problem_.image_points[i].robust : problem_.image_tags[i].robust;
      const double cost = defined ? apply_loss(loss, robust, true, rows) : std::nan("");
      if (!std::isfinite(cost)) {
        sums.undefined = name(term);
        return false;
      }
      sums.cost += cost;
      add_products(block, term, rows, w, v.data(), g.data(), sums);
    }
    diagonal_.segment(layout_.offset(block.block), block.size) = v.diagonal().head(block.size);
    right_.segment(layout_.offset(block.block), block.size) = -g.head(block.size);
    eliminate(block, damping, v, -g);
  }
  return true;
}

/// All products of the derivatives of one observation, each to where it belongs: V and its gradient, W, and what the
/// kept unknowns have among themselves.
void Elimination::add_products(const Block& block, const TermRef& term, const Rows& rows, double* w, double* v,
                               double* g, Sums& sums) const {
  std::array<Outer, 48> jobs;
  int count = 0;
  const auto add = [&](double* target, std::ptrdiff_t stride, const Rows::Part& a, const Rows::Part& b) {
    jobs[count++] = {
        target,       stride,      rows.storage.data() + a.column, rows.storage.data() + b.column, a.size, b.size,
        Rows::stride, Rows::stride};
  };
  const auto add_gradient = [&](double* target, const Rows::Part& b) {
    jobs[count++] = {target, 0, rows.residual.data(), rows.storage.data() + b.column, 1, b.size, 1, Rows::stride};
  };
  int own = 0;
  while (rows.part[own].block != block.block) ++own;
  const Rows::Part& mine = rows.part[own];
  add(v, 6, mine, mine);
  add_gradient(g, mine);
  int next = 0;
  for (int k = 0; k < rows.parts; ++k) {
    if (k == own) continue;
    const Rows::Part& a = rows.part[k];
    add(w + term.local[next++], block.columns, mine, a);
    add_gradient(sums.gradient.data() + kept_offset(a.block), a);
    const int index = kept_index(a.block);
    for (int l = 0; l < rows.parts; ++l) {
      const Rows::Part& b = rows.part[l];
      if (l == own || kept_index(b.block) > index) continue;
      auto target = sums.direct.at(index, kept_index(b.block));
      add(target.data(), target.outerStride(), b, a);
    }
  }
  add_outer(rows.rows, jobs.data(), count);
}

void Elimination::eliminate(Block& block, double damping, const Eigen::Matrix<double, 6, 6>& v,
                            const Eigen::Matrix<double, 6, 1>& g) {
  const int s = block.size;
  Eigen::Matrix<double, 6, 1> root;
  block.weakest = 1;
  block.factor.setZero();
  block.half.setZero();
  for (int c = 0; c < s; ++c) {
    if (!(v(c, c) > 0)) block.weakest = 0;
    root(c) = std::sqrt(std::max(v(c, c), 1e-300));
  }
  // Cholesky of V scaled to a unit diagonal: a pivot is what of an unknown the ones before it do not tell.
  for (int c = 0; c < s && block.determined(); ++c)
    for (int r = c; r < s; ++r) {
      double sum = v(r, c) / (root(r) * root(c)) + (r == c ? damping : 0.0);
      for (int k = 0; k < c; ++k) sum -= block.factor(r, k) * block.factor(c, k);
      if (r == c) {
        block.weakest = std::min(block.weakest, sum);
        if (sum < Block::singular) break;
        block.factor(c, c) = std::sqrt(sum);
      } else {
        block.factor(r, c) = sum / block.factor(c, c);
      }
    }
  double* y = y_.data() + block.y;
  if (!block.determined()) {
    block.factor.setZero();
    std::fill_n(y, static_cast<size_t>(s) * (static_cast<size_t>(block.columns) + 1), 0.0);
    return;
  }
  for (int r = 0; r < s; ++r)
    for (int c = 0; c <= r; ++c) block.factor(r, c) *= root(r);
  solve_lower(s, block.factor.data(), y, block.columns);
  block.half.head(s) = g.head(s);
  for (int r = 0; r < s; ++r) {
    for (int c = 0; c < r; ++c) block.half(r) -= block.factor(r, c) * block.half(c);
    block.half(r) /= block.factor(r, r);
    y[s * block.columns + r] = block.half(r);
  }
}

void Elimination::add_known(const Linear& known) {
  for (const auto& a : known.parts)
    for (const auto& b : known.parts) {
      if (a.kept < b.kept || (known.diagonal && &a != &b)) continue;
      normal_.at(a.kept, b.kept).block(known.at[a.first], known.at[b.first], a.count, b.count) +=
          known.normal.block(a.first, b.first, a.count, b.count);
    }
}

bool Elimination::add_loose(const State& state, const Loss& loss) {
  Rows rows;
  for (const TermRef& term : loose_) {
    stop_point();
    const size_t i = static_cast<size_t>(term.index);
    if (term.kind == TermRef::Kind::known) {
      const Eigen::VectorXd g = gradient_of_known(state, i, cost_);
      for (size_t c = 0; c < known_[i].columns.size(); ++c)
        right_(known_[i].columns[c]) -= g(static_cast<Eigen::Index>(c));
      add_known(known_[i]);
      continue;
    }
    bool defined = false, robust = false;
    if (term.kind == TermRef::Kind::point)
      defined = evaluate(problem_, layout_, state, problem_.image_points[i], true, rows),
      robust = problem_.image_points[i].robust;
    else if (term.kind == TermRef::Kind::tag)
      defined = evaluate(problem_, layout_, state, problem_.image_tags[i], true, rows),
      robust = problem_.image_tags[i].robust;
    else
      defined = evaluate(problem_, layout_, state, problem_.distances[i], true, rows);
    const double cost = defined ? apply_loss(loss, robust, true, rows) : std::nan("");
    if (!std::isfinite(cost)) {
      undefined_ = name(term);
      return false;
    }
    cost_ += cost;
    for (int k = 0; k < rows.parts; ++k) {
      const Rows::Part& a = rows.part[k];
      right_.segment(layout_.offset(a.block), a.size) -= rows.jacobian(k).transpose() * rows.values();
      for (int l = 0; l < rows.parts; ++l) {
        const Rows::Part& b = rows.part[l];
        if (kept_index(a.block) < kept_index(b.block)) continue;
        normal_.at(kept_index(a.block), kept_index(b.block)) += rows.jacobian(k).transpose() * rows.jacobian(l);
      }
    }
  }
  return true;
}

/// Of every `step`th kept block from `first` on. Eliminated blocks are taken in portions, so that what is read of them
/// is still near the processor when the next kept block wants it; the order of each sum is that of the blocks all the
/// same.
void Elimination::subtract(size_t first, size_t step) {
  constexpr size_t portion = 32 * 1024;  // numbers of Y: a quarter of a megabyte
  std::vector<size_t> next(kept_blocks_.size(), 0);
  std::vector<int> rows(static_cast<size_t>(kept_count_));
  for (size_t end = portion; end < y_.size() + portion; end += portion) {
    stop_point();
    const double* limit = y_.data() + std::min(end, y_.size());
    for (size_t k = first; k < kept_blocks_.size(); k += step) {
      const int block = kept_blocks_[k], at = kept_offset(block);
      const auto& coupled = coupled_[block];
      const size_t begin = next[k];
      while (next[k] < coupled.size() && coupled[next[k]].y < limit) ++next[k];
      if (next[k] == begin) continue;
      const auto& column = normal_.column(static_cast<int>(k));
      for (size_t r = 0; r < column.rows.size(); ++r) rows[normal_.offset(column.rows[r])] = column.starts[r];
      subtract_strip(normal_.values() + column.begin, column.height(), layout_.size(block), rows.data(),
                     coupled.data() + begin, next[k] - begin, reduced_right_.data() + at);
    }
  }
}

bool Elimination::build(const State& state, double damping, const Loss& loss) {
  allocate();
  const int count = static_cast<int>(blocks_.size());
  const double bytes = sizeof(double) * (kept_count_ + static_cast<double>(direct_.value_count()));
  const int chunks = bytes * max_chunks > 2e8 ? 1 : std::clamp(count / smallest_chunk, 1, max_chunks);
  std::vector<Sums> sums(static_cast<size_t>(chunks), Sums{direct_, {}, 0, {}});
  right_.setZero(layout_.unknown_count());
  diagonal_.setZero(layout_.unknown_count());
  for_each_index(chunks, threads_, [&](int c) {
    const auto bound = [&](int k) { return static_cast<int>(static_cast<int64_t>(count) * k / chunks); };
    linearise(state, loss, bound(c), bound(c + 1), damping, sums[c]);
  });
  undefined_.clear();
  for (const Sums& s : sums)
    if (!s.undefined.empty()) {
      undefined_ = s.undefined;
      return false;
    }
  cost_ = 0;
  normal_.set_zero();
  for (const Sums& s : sums) {
    cost_ += s.cost;
    for (int k = 0; k < direct_.block_count(); ++k) {
      const int b = kept_blocks_[k];
      right_.segment(layout_.offset(b), layout_.size(b)) -= s.gradient.segment(kept_offset(b), layout_.size(b));
      for (int row : direct_.column(k).rows) normal_.at(row, k) += s.direct.at(row, k);
    }
  }
  if (!add_loose(state, loss)) return false;
  scale_.resize(kept_count_);
  reduced_right_.resize(kept_count_);
  for (int b : kept_blocks_) {
    auto own = normal_.at(kept_index(b), kept_index(b));
    for (int c = 0; c < layout_.size(b); ++c) {
      const int at = kept_offset(b) + c;
      diagonal_(layout_.offset(b) + c) = own(c, c);
      scale_(at) = own(c, c) > 0 ? 1 / std::sqrt(own(c, c)) : 1.0;
      reduced_right_(at) = right_(layout_.offset(b) + c);
      own(c, c) *= 1 + damping;
    }
  }
  const int parts = threads_ > 1 ? 4 * threads_ : 1;
  for_each_index(parts, threads_, [&](int p) { subtract(static_cast<size_t>(p), static_cast<size_t>(parts)); });
  return true;
}

}  // namespace plumbline::bundle
