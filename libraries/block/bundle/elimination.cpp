#include "block/bundle/elimination.hpp"

#include <algorithm>
#include <cmath>

#include "block/bundle/parallel.hpp"
#include "block/bundle/terms.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::bundle {
namespace {

constexpr int max_chunks = 8, smallest_chunk = 64;

bool is_shared(Kind kind) {
  return kind == Kind::camera || kind == Kind::scale || kind == Kind::inset || kind == Kind::shift;
}

/// Weighs the rows of a robust observation; returns its part of the cost.
double apply_loss(const Loss& loss, bool robust, bool jacobians, Rows& rows) {
  const double s = rows.values().squaredNorm();
  if (!robust || loss.kind == Loss::Kind::none) return s;
  if (jacobians) {
    const double factor = std::sqrt(loss.slope(s));
    if (factor == 1) return loss.value(s);
    for (int i = 0; i < rows.rows; ++i) rows.residual[static_cast<size_t>(i)] *= factor;
    for (int i = 0; i < rows.rows; ++i)
      for (int c = 0; c < rows.columns; ++c) rows.storage[static_cast<size_t>(i * Rows::stride + c)] *= factor;
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
  std::vector<double> diagonal;  ///< 6 × 6 a kept block, at a third of its offset
  Eigen::MatrixXd border;        ///< shared × primary
  Eigen::MatrixXd corner;        ///< shared × shared
  Eigen::VectorXd gradient;      ///< Jᵀ r of kept unknowns
  double cost = 0;
  std::string undefined;
};

Elimination::Elimination(const Problem& problem, const Layout& layout, Side side, int threads)
    : problem_(problem), layout_(layout), threads_(threads) {
  choose_side(side);
  sort_unknowns();
  sort_terms();
  prepare_known();
}

void Elimination::choose_side(Side side) {
  tied_.assign(static_cast<size_t>(layout_.block_count()), false);
  for (const auto& d : problem_.distances)
    for (Ref ref : {d.from, d.to}) tied_[static_cast<size_t>(layout_.block(ref))] = true;
  for (const auto& k : problem_.known)
    if (k.refs.size() > 1)
      for (Ref ref : k.refs) tied_[static_cast<size_t>(layout_.block(ref))] = true;
  bool images_tied = false;
  for (size_t i = 0; i < problem_.images.size(); ++i)
    images_tied = images_tied || tied_[static_cast<size_t>(layout_.block({Kind::image, static_cast<int>(i)}))];
  if (side != Side::automatic) {
    side_ = side;
    return;
  }
  // Multiplications of the elimination and of the factorisation, roughly.
  std::vector<double> seen_by_image(problem_.images.size()), seen_by_point(problem_.points.size()),
      seen_by_plate(problem_.plates.size());
  for (const auto& o : problem_.image_points)
    seen_by_image[static_cast<size_t>(o.image)] += 3, seen_by_point[static_cast<size_t>(o.point)] += 6;
  for (const auto& o : problem_.image_tags)
    seen_by_image[static_cast<size_t>(o.image)] += 6, seen_by_plate[static_cast<size_t>(o.plate)] += 6;
  double body_size = 0, image_size = 6 * static_cast<double>(problem_.images.size()), by_body = 0, by_image = 0;
  for (double s : seen_by_image) by_image += 3 * s * s;
  for (size_t j = 0; j < seen_by_point.size(); ++j) {
    body_size += 3;
    if (tied_[static_cast<size_t>(layout_.block({Kind::point, static_cast<int>(j)}))])
      image_size += 3;
    else
      by_body += 1.5 * seen_by_point[j] * seen_by_point[j];
  }
  for (size_t j = 0; j < seen_by_plate.size(); ++j) {
    body_size += 6;
    if (tied_[static_cast<size_t>(layout_.block({Kind::plate, static_cast<int>(j)}))])
      image_size += 6;
    else
      by_body += 3 * seen_by_plate[j] * seen_by_plate[j];
  }
  by_body += std::pow(image_size, 3) / 6;
  by_image += std::pow(body_size, 3) / 6;
  side_ = by_image < by_body && !images_tied ? Side::images : Side::bodies;
}

void Elimination::sort_unknowns() {
  const int count = layout_.block_count();
  eliminated_.assign(static_cast<size_t>(count), -1);
  kept_offset_.assign(static_cast<size_t>(count), -1);
  std::vector<int> shared;
  for (int b = 0; b < count; ++b) {
    if (layout_.size(b) == 0) continue;
    const Kind kind = layout_.ref(b).kind;
    const bool body = kind == Kind::point || kind == Kind::plate;
    const bool goes = side_ == Side::bodies ? body && !tied_[static_cast<size_t>(b)] : kind == Kind::image;
    if (goes) {
      eliminated_[static_cast<size_t>(b)] = static_cast<int>(blocks_.size());
      blocks_.emplace_back();
      blocks_.back().block = b;
      blocks_.back().size = layout_.size(b);
    } else if (is_shared(kind)) {
      shared.push_back(b);
    } else {
      kept_offset_[static_cast<size_t>(b)] = kept_count_;
      kept_count_ += layout_.size(b);
      kept_blocks_.push_back(b);
    }
  }
  primary_count_ = kept_count_;
  for (int b : shared) {
    kept_offset_[static_cast<size_t>(b)] = kept_count_;
    kept_count_ += layout_.size(b);
    kept_blocks_.push_back(b);
  }
}

/// In the order of Rows' parts.
void Elimination::blocks_of(const TermRef& term, std::vector<int>& all) const {
  all.clear();
  const size_t i = static_cast<size_t>(term.index);
  if (term.kind == TermRef::Kind::point) {
    const ImagePoint& o = problem_.image_points[i];
    all = {layout_.block({Kind::image, o.image}),
           layout_.block({Kind::camera, problem_.images[static_cast<size_t>(o.image)].camera}),
           layout_.block({Kind::shift, o.image}), layout_.block({Kind::point, o.point})};
  } else if (term.kind == TermRef::Kind::tag) {
    const ImageTag& o = problem_.image_tags[i];
    const int batch = problem_.plates[static_cast<size_t>(o.plate)].batch;
    all = {layout_.block({Kind::image, o.image}),
           layout_.block({Kind::camera, problem_.images[static_cast<size_t>(o.image)].camera}),
           layout_.block({Kind::shift, o.image}),
           layout_.block({Kind::scale, batch}),
           layout_.block({Kind::inset, o.inset < 0 ? batch : o.inset}),
           layout_.block({Kind::plate, o.plate})};
  } else if (term.kind == TermRef::Kind::distance) {
    all = {layout_.block(problem_.distances[i].from), layout_.block(problem_.distances[i].to)};
  } else {
    for (Ref ref : problem_.known[i].refs) all.push_back(layout_.block(ref));
  }
  std::erase_if(all, [&](int b) { return layout_.size(b) == 0; });
}

void Elimination::sort_terms() {
  terms_.resize(blocks_.size());
  std::vector<int> all;
  const auto add = [&](TermRef::Kind kind, size_t count) {
    for (size_t i = 0; i < count; ++i) {
      const TermRef term{kind, static_cast<int>(i), {}};
      blocks_of(term, all);
      const auto goes = std::find_if(all.begin(), all.end(), [&](int b) { return eliminated(b) >= 0; });
      if (goes == all.end()) {
        loose_.push_back(term);
        continue;
      }
      terms_[static_cast<size_t>(eliminated(*goes))].push_back(term);
      auto& kept = blocks_[static_cast<size_t>(eliminated(*goes))].kept;
      for (int b : all)
        if (b != *goes) kept.push_back(b);
    }
  };
  add(TermRef::Kind::point, problem_.image_points.size());
  add(TermRef::Kind::tag, problem_.image_tags.size());
  add(TermRef::Kind::distance, problem_.distances.size());
  add(TermRef::Kind::known, problem_.known.size());
  coupled_.resize(static_cast<size_t>(layout_.block_count()));
  size_t y = 0;
  for (size_t e = 0; e < blocks_.size(); ++e) {
    Block& block = blocks_[e];
    std::sort(block.kept.begin(), block.kept.end(), [&](int a, int b) { return kept_offset(a) < kept_offset(b); });
    block.kept.erase(std::unique(block.kept.begin(), block.kept.end()), block.kept.end());
    block.y = y;
    block.first_run = static_cast<int>(runs_.size());
    for (size_t k = 0; k < block.kept.size(); ++k) {
      const int offset = kept_offset(block.kept[k]), size = layout_.size(block.kept[k]);
      if (block.run_count > 0 && runs_.back().offset + runs_.back().length == offset)
        runs_.back().length += size;
      else
        runs_.push_back({block.columns, offset, size}), ++block.run_count;
      block.local.push_back(block.columns);
      block.columns += size;
    }
    y += static_cast<size_t>(block.size) * (static_cast<size_t>(block.columns) + 1);
    for (auto& term : terms_[e]) {
      size_t next = 0;
      blocks_of(term, all);
      for (int b : all) {
        if (b == block.block) continue;
        const auto at = std::lower_bound(block.kept.begin(), block.kept.end(), b,
                                         [&](int p, int q) { return kept_offset(p) < kept_offset(q); });
        term.local[next++] = block.local[static_cast<size_t>(at - block.kept.begin())];
      }
    }
  }
  y_.resize(y);
  for (const Block& block : blocks_)
    for (size_t k = 0; k < block.kept.size(); ++k)
      coupled_[static_cast<size_t>(block.kept[k])].push_back(
          {y_of(block), runs(block), block.run_count, block.size, block.columns, block.local[k]});
}

std::string Elimination::name(const TermRef& term) const {
  const size_t i = static_cast<size_t>(term.index);
  if (term.kind == TermRef::Kind::point) {
    const auto& o = problem_.image_points[i];
    return "point " + problem_.points[static_cast<size_t>(o.point)].name + " in image " +
           problem_.images[static_cast<size_t>(o.image)].name;
  }
  if (term.kind == TermRef::Kind::tag) {
    const auto& o = problem_.image_tags[i];
    return "the tag of " + problem_.plates[static_cast<size_t>(o.plate)].name + " in image " +
           problem_.images[static_cast<size_t>(o.image)].name;
  }
  return "the distance '" + problem_.distances[i].name + "'";
}

void Elimination::prepare_known() {
  for (const Known& term : problem_.known) {
    Linear& known = known_.emplace_back();
    known.whitening = term.whitening / problem_.groups[static_cast<size_t>(term.group)].sigma_factor;
    std::vector<int> chosen;
    linear_columns(problem_, layout_, term, chosen, known.columns);
    known.jacobian = known.whitening(Eigen::all, chosen);
    known.diagonal = known.jacobian.rows() == known.jacobian.cols() && known.jacobian.isDiagonal(0);
    if (known.diagonal)
      known.normal = known.jacobian.diagonal().cwiseAbs2().asDiagonal();
    else
      known.normal = known.jacobian.transpose() * known.jacobian;
    for (int c : known.columns)
      for (Ref ref : term.refs) {
        const int b = layout_.block(ref), within = c - layout_.offset(b);
        if (within < 0 || within >= layout_.size(b)) continue;
        known.at.push_back(std::max(0, kept_offset(b)) + within);
        break;
      }
  }
}

/// Jᵀ r of problem.known[index]; adds its part of the cost.
Eigen::VectorXd Elimination::gradient_of_known(const State& state, size_t index, double& cost) const {
  const Eigen::VectorXd residual = residual_of(problem_, state, problem_.known[index], known_[index].whitening);
  cost += residual.squaredNorm();
  return known_[index].jacobian.transpose() * residual;
}

bool Elimination::linearise(const State& state, const Loss& loss, int first, int last, double damping, Sums& sums) {
  const int shared = kept_count_ - primary_count_;
  sums.diagonal.assign(36 * static_cast<size_t>(primary_count_ / 3 + 1), 0.0);
  sums.border.setZero(shared, primary_count_);
  sums.corner.setZero(shared, shared);
  sums.gradient.setZero(kept_count_);
  Rows rows;
  for (int e = first; e < last; ++e) {
    stop_point();
    Block& block = blocks_[static_cast<size_t>(e)];
    double* w = y_.data() + block.y;
    std::fill_n(w, static_cast<size_t>(block.size) * (static_cast<size_t>(block.columns) + 1), 0.0);
    Eigen::Matrix<double, 6, 6> v = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> g = Eigen::Matrix<double, 6, 1>::Zero();
    for (const TermRef& term : terms_[static_cast<size_t>(e)]) {
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
  const int shared = kept_count_ - primary_count_;
  std::array<Outer, 48> jobs;
  int count = 0;
  const auto add = [&](double* target, std::ptrdiff_t stride, const Rows::Part& a, const Rows::Part& b) {
    jobs[static_cast<size_t>(count++)] = {
        target,       stride,      rows.storage.data() + a.column, rows.storage.data() + b.column, a.size, b.size,
        Rows::stride, Rows::stride};
  };
  const auto add_gradient = [&](double* target, const Rows::Part& b) {
    jobs[static_cast<size_t>(count++)] = {target, 0, rows.residual.data(), rows.storage.data() + b.column, 1,
                                          b.size, 1, Rows::stride};
  };
  int own = 0;
  while (rows.part[static_cast<size_t>(own)].block != block.block) ++own;
  const Rows::Part& mine = rows.part[static_cast<size_t>(own)];
  add(v, 6, mine, mine);
  add_gradient(g, mine);
  int next = 0;
  for (int k = 0; k < rows.parts; ++k) {
    if (k == own) continue;
    const Rows::Part& a = rows.part[static_cast<size_t>(k)];
    const int at = kept_offset(a.block);
    add(w + term.local[static_cast<size_t>(next++)], block.columns, mine, a);
    add_gradient(sums.gradient.data() + at, a);
    if (at < primary_count_) {
      add(sums.diagonal.data() + 36 * static_cast<size_t>(at / 3), 6, a, a);
      continue;
    }
    for (int l = 0; l < rows.parts; ++l) {
      const Rows::Part& b = rows.part[static_cast<size_t>(l)];
      if (l == own) continue;
      const int b_at = kept_offset(b.block);
      if (b_at < primary_count_)
        add(&sums.border(at - primary_count_, b_at), shared, b, a);
      else
        add(&sums.corner(at - primary_count_, b_at - primary_count_), shared, b, a);
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

bool Elimination::add_loose(const State& state, const Loss& loss) {
  Rows rows;
  for (const TermRef& term : loose_) {
    stop_point();
    const size_t i = static_cast<size_t>(term.index);
    if (term.kind == TermRef::Kind::known) {
      const Linear& known = known_[i];
      const Eigen::VectorXd g = gradient_of_known(state, i, cost_);
      for (size_t c = 0; c < known.at.size(); ++c) {
        const Eigen::Index column = static_cast<Eigen::Index>(c);
        right_(known.columns[c]) -= g(column);
        if (known.diagonal)
          normal_(known.at[c], known.at[c]) += known.normal(column, column);
        else
          for (size_t r = 0; r < known.at.size(); ++r)
            if (known.at[r] >= known.at[c])
              normal_(known.at[r], known.at[c]) += known.normal(static_cast<Eigen::Index>(r), column);
      }
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
      const Rows::Part& a = rows.part[static_cast<size_t>(k)];
      right_.segment(layout_.offset(a.block), a.size) -= rows.jacobian(k).transpose() * rows.values();
      for (int l = 0; l < rows.parts; ++l) {
        const Rows::Part& b = rows.part[static_cast<size_t>(l)];
        if (kept_offset(a.block) < kept_offset(b.block)) continue;
        normal_.block(kept_offset(a.block), kept_offset(b.block), a.size, b.size) +=
            rows.jacobian(k).transpose() * rows.jacobian(l);
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
  for (size_t end = portion; end < y_.size() + portion; end += portion) {
    stop_point();
    const double* limit = y_.data() + std::min(end, y_.size());
    for (size_t k = first; k < kept_blocks_.size(); k += step) {
      const int block = kept_blocks_[k], at = kept_offset(block);
      const auto& coupled = coupled_[static_cast<size_t>(block)];
      const size_t begin = next[k];
      while (next[k] < coupled.size() && coupled[next[k]].y < limit) ++next[k];
      subtract_strip(normal_.col(at).data(), normal_.rows(), layout_.size(block), coupled.data() + begin,
                     next[k] - begin, reduced_right_.data() + at);
    }
  }
}

bool Elimination::build(const State& state, double damping, const Loss& loss) {
  const int count = static_cast<int>(blocks_.size());
  const double bytes = 8.0 * (13.0 * primary_count_ + double(kept_count_ - primary_count_) * kept_count_);
  const int chunks = bytes * max_chunks > 2e8 ? 1 : std::clamp(count / smallest_chunk, 1, max_chunks);
  std::vector<Sums> sums(static_cast<size_t>(chunks));
  right_.setZero(layout_.unknown_count());
  diagonal_.setZero(layout_.unknown_count());
  for_each_index(chunks, threads_, [&](int c) {
    const auto bound = [&](int k) { return static_cast<int>(static_cast<int64_t>(count) * k / chunks); };
    linearise(state, loss, bound(c), bound(c + 1), damping, sums[static_cast<size_t>(c)]);
  });
  undefined_.clear();
  for (const Sums& s : sums)
    if (!s.undefined.empty()) {
      undefined_ = s.undefined;
      return false;
    }
  cost_ = 0;
  normal_.setZero(kept_count_, kept_count_);
  const int shared = kept_count_ - primary_count_;
  for (const Sums& s : sums) {
    cost_ += s.cost;
    for (int b : kept_blocks_) {
      const int at = kept_offset(b), size = layout_.size(b);
      right_.segment(layout_.offset(b), size) -= s.gradient.segment(at, size);
      if (at >= primary_count_) continue;
      normal_.block(at, at, size, size) +=
          Eigen::Map<const Eigen::Matrix<double, 6, 6>>(s.diagonal.data() + 36 * static_cast<size_t>(at / 3))
              .topLeftCorner(size, size);
    }
    normal_.bottomLeftCorner(shared, primary_count_) += s.border;
    normal_.bottomRightCorner(shared, shared) += s.corner;
  }
  if (!add_loose(state, loss)) return false;
  scale_.resize(kept_count_);
  reduced_right_.resize(kept_count_);
  for (int b : kept_blocks_)
    for (int c = 0; c < layout_.size(b); ++c) {
      const int at = kept_offset(b) + c;
      double& d = normal_(at, at);
      diagonal_(layout_.offset(b) + c) = d;
      scale_(at) = d > 0 ? 1 / std::sqrt(d) : 1.0;
      reduced_right_(at) = right_(layout_.offset(b) + c);
      d *= 1 + damping;
    }
  const int parts = threads_ > 1 ? 4 * threads_ : 1;
  for_each_index(parts, threads_, [&](int p) { subtract(static_cast<size_t>(p), static_cast<size_t>(parts)); });
  return true;
}

}  // namespace plumbline::bundle
