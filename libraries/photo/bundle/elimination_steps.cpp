// What a linearised block is good for: steps with its factors, and the gradient elsewhere.
#include <algorithm>
#include <cmath>

#include "photo/bundle/elimination.hpp"
#include "photo/bundle/terms.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::bundle {

bool Elimination::gradient(const State& state, Eigen::VectorXd& right, double& cost, const Loss& loss) const {
  right.setZero(layout_.unknown_count());
  cost = 0;
  const auto weigh = [&](bool robust, double square) {
    const bool weighed = loss.kind != Loss::Kind::none && robust;
    cost += weighed ? loss.value(square) : square;
    return weighed ? loss.slope(square) : 1.0;
  };
  Rows rows;
  const auto add = [&](const auto& term, bool robust) {
    stop_point();
    if (!evaluate(problem_, layout_, state, term, true, rows)) return false;
    const double weight = weigh(robust, rows.values().squaredNorm());
    for (int k = 0; k < rows.parts; ++k) {
      const Rows::Part& part = rows.part[k];
      double* to = right.data() + layout_.offset(part.block);
      for (int r = 0; r < rows.rows; ++r) {
        const double residual = weight * rows.residual[r];
        const double* from = rows.storage.data() + r * Rows::stride + part.column;
        for (int c = 0; c < part.size; ++c) to[c] -= residual * from[c];
      }
    }
    return true;
  };
  TagGradient of_tag;
  const auto add_tag = [&](const ImageTag& term) {
    stop_point();
    if (!gradient_of(problem_, state, term, of_tag)) return false;
    subtract_gradient(term, of_tag, weigh(term.robust, of_tag.squares), right);
    return true;
  };
  for (const auto& term : problem_.image_points)
    if (!add(term, term.robust)) return false;
  for (const auto& term : problem_.image_tags)
    if (!add_tag(term)) return false;
  for (const auto& term : problem_.distances)
    if (!add(term, false)) return false;
  for (size_t k = 0; k < known_.size(); ++k) {
    const Eigen::VectorXd g = gradient_of_known(state, k, cost);
    for (size_t c = 0; c < known_[k].columns.size(); ++c)
      right(known_[k].columns[c]) -= g(static_cast<Eigen::Index>(c));
  }
  return right.allFinite();
}

/// right −= weight · Jᵀ r of a tag, in the unknowns that are free.
void Elimination::subtract_gradient(const ImageTag& term, const TagGradient& of_tag, double weight,
                                    Eigen::VectorXd& right) const {
  const int camera = problem_.images[term.image].camera;
  const auto subtract = [&](Ref ref, const auto& values) {
    const int block = layout_.block(ref), size = layout_.size(block);
    right.segment(layout_.offset(block), size) -= weight * values.head(size);
  };
  subtract({Kind::image, term.image}, of_tag.by_image);
  subtract({Kind::plate, term.plate}, of_tag.by_plate);
  subtract({Kind::shift, term.image}, of_tag.by_shift);
  const int batch = problem_.plates[term.plate].batch;
  const int scale = layout_.block({Kind::scale, batch});
  const int inset = layout_.block({Kind::inset, term.inset < 0 ? batch : term.inset});
  if (layout_.size(scale) > 0) right(layout_.offset(scale)) -= weight * of_tag.by_scale;
  if (layout_.size(inset) > 0) right(layout_.offset(inset)) -= weight * of_tag.by_inset;
  const int form = layout_.block({Kind::form, term.plate});
  right.segment(layout_.offset(form), layout_.size(form)) -=
      weight * of_tag.by_form.segment(problem_.plates[term.plate].form_begin, layout_.size(form));
  int next = layout_.offset(layout_.block({Kind::camera, camera}));
  for (int value : layout_.free_values(camera)) right(next++) -= weight * of_tag.by_interior(value);
}

bool Elimination::factorise(const Eigen::MatrixXd& motions) {
  if (how_ == Reduced::gradients) return gradients_.prepare(normal_);
  least_squares::Scaling scaling{scale_, Eigen::VectorXd::Zero(kept_count_)};
  Eigen::MatrixXd left = motions;
  for (Eigen::Index k = 0; k < motions.cols(); ++k) {
    Eigen::Index at = 0;
    const double longest = std::sqrt(left.rowwise().squaredNorm().maxCoeff(&at));
    if (!(longest > 0)) return false;
    scaling.added(at) += 1;
    const Eigen::RowVectorXd direction = left.row(at) / longest;
    left -= (left * direction.transpose()).eval() * direction;
  }
  return factor_.factorise(normal_, 0, scaling);
}

Eigen::VectorXd Elimination::step() const {
  std::vector<Half> halves;
  halves.reserve(blocks_.size());
  for (const Block& block : blocks_) halves.push_back(block.half);
  return substitute_back(reduced_right_, halves);
}

Eigen::VectorXd Elimination::step(const Eigen::VectorXd& right) const {
  Eigen::VectorXd reduced(kept_count_);
  for (int b : kept_blocks_)
    reduced.segment(kept_offset(b), layout_.size(b)) = right.segment(layout_.offset(b), layout_.size(b));
  std::vector<Half> halves(blocks_.size(), Half::Zero());
  for (size_t e = 0; e < blocks_.size(); ++e) {
    stop_point();
    const Block& block = blocks_[e];
    if (!block.determined()) continue;
    const double* y = y_of(block);
    for (int r = 0; r < block.size; ++r, y += block.columns) {
      double sum = right(layout_.offset(block.block) + r);
      for (int k = 0; k < r; ++k) sum -= block.factor(r, k) * halves[e](k);
      const double half = halves[e](r) = sum / block.factor(r, r);
      for (const Run* run = runs(block); run < runs(block) + block.run_count; ++run)
        for (int c = 0; c < run->length; ++c) reduced(run->offset + c) -= half * y[run->local + c];
    }
  }
  return substitute_back(reduced, halves);
}

Eigen::VectorXd Elimination::substitute_back(const Eigen::VectorXd& reduced, const std::vector<Half>& halves) const {
  Eigen::VectorXd result = Eigen::VectorXd::Zero(layout_.unknown_count()), kept;
  if (how_ == Reduced::gradients) {
    least_squares::ConjugateGradients::Solution found = gradients_.solve(reduced);
    gradient_steps_ += found.steps;
    kept = std::move(found.x);
  } else {
    kept = scale_.cwiseProduct(factor_.solve(scale_.cwiseProduct(reduced)).col(0));
  }
  for (int b : kept_blocks_)
    result.segment(layout_.offset(b), layout_.size(b)) = kept.segment(kept_offset(b), layout_.size(b));
  std::array<double, 6> from_kept;
  for (size_t e = 0; e < blocks_.size(); ++e) {
    stop_point();
    const Block& block = blocks_[e];
    if (!block.determined()) continue;
    multiply_runs(y_of(block), block.size, block.columns, runs(block), block.run_count, kept.data(), from_kept.data());
    auto x = result.segment(layout_.offset(block.block), block.size);
    for (int r = block.size - 1; r >= 0; --r) {
      double sum = halves[e](r) - from_kept[r];
      for (int k = r + 1; k < block.size; ++k) sum -= block.factor(k, r) * x(k);
      x(r) = sum / block.factor(r, r);
    }
  }
  return result;
}

Eigen::MatrixXd Elimination::solve(const Eigen::MatrixXd& right) const {
  const Eigen::Index d = right.cols();
  Eigen::MatrixXd kept(kept_count_, d), result = Eigen::MatrixXd::Zero(right.rows(), d);
  std::vector<Eigen::MatrixXd> half(blocks_.size());
  for (int b : kept_blocks_)
    kept.middleRows(kept_offset(b), layout_.size(b)) = right.middleRows(layout_.offset(b), layout_.size(b));
  for (size_t e = 0; e < blocks_.size(); ++e) {
    stop_point();
    const Block& block = blocks_[e];
    if (!block.determined()) continue;
    half[e] = block.factor.topLeftCorner(block.size, block.size)
                  .triangularView<Eigen::Lower>()
                  .solve(right.middleRows(layout_.offset(block.block), block.size));
    const auto own = y(block);
    for (size_t k = 0; k < block.kept.size(); ++k)
      kept.middleRows(kept_offset(block.kept[k]), layout_.size(block.kept[k])) -=
          own.middleCols(block.local[k], layout_.size(block.kept[k])).transpose() * half[e];
  }
  kept = scale_.asDiagonal() * factor_.solve(scale_.asDiagonal() * kept);
  for (int b : kept_blocks_)
    result.middleRows(layout_.offset(b), layout_.size(b)) = kept.middleRows(kept_offset(b), layout_.size(b));
  for (size_t e = 0; e < blocks_.size(); ++e) {
    stop_point();
    const Block& block = blocks_[e];
    if (!block.determined()) continue;
    const auto own = y(block);
    for (size_t k = 0; k < block.kept.size(); ++k)
      half[e] -= own.middleCols(block.local[k], layout_.size(block.kept[k])) *
                 kept.middleRows(kept_offset(block.kept[k]), layout_.size(block.kept[k]));
    result.middleRows(layout_.offset(block.block), block.size) =
        block.factor.topLeftCorner(block.size, block.size).triangularView<Eigen::Lower>().transpose().solve(half[e]);
  }
  return result;
}

}  // namespace plumbline::bundle
